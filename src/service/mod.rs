//! What the service can do, without a word of any protocol.
//!
//! Both edges and the command line come here; so whatever is checked here is
//! checked for all of them.

mod blocking;
mod error;
mod job_request;
mod kinematics;
mod robots;
mod runner;

use std::sync::Arc;
use std::time::Duration;

use futures::{Stream, StreamExt};
use jiff::{SignedDuration, Timestamp};
use sha2::{Digest, Sha256};
use uuid::Uuid;

pub use blocking::blocking;
pub use error::{ErrorCode, ServiceError};
pub use job_request::JobRequest;
pub use kinematics::{
    ExcludingLimit, ForwardKinematics, ForwardKinematicsRequest, InverseFailure,
    InverseKinematicsAnswer, InverseKinematicsRequest, InverseSolution, PoseTolerance,
    SolutionChoice,
};
pub use robots::{RobotOrigin, RobotPut, RobotStore, RobotSummary};
pub use runner::{PlanningRunner, ResultSummary};

use crate::fault::Faults;
use crate::job::{
    Drained, Idempotency, Job, JobCounts, JobEvent, JobFilter, JobId, JobPage, JobResult, JobState,
    Jobs, JobsError, Metrics, NewJob, Submitted,
};
use crate::optimize::{OPTIMIZERS, OptimizerEntry, OptimizerInfo};
use crate::plan::path::{SMOOTHINGS, SmoothingEntry, SmoothingInfo};
use crate::plan::scenarios::Scenario;
use crate::plan::verify::VerifyRequest;
use crate::plan::{self, PlanResult, RobotRef};
use crate::planner::{PLANNERS, PlannerEntry, PlannerInfo};
use crate::trajectory::Certificate;
use crate::trajectory::interpolation::{INTERPOLATIONS, Interpolation, InterpolationInfo};

/// The use cases. Cheap to clone; all clones are the same service.
#[derive(Clone)]
pub struct Service {
    inner: Arc<Inner>,
}

struct Inner {
    jobs: Jobs,
    robots: Arc<dyn RobotStore>,
    metrics: Arc<Metrics>,
}

/// Jobs expected to take less than this may use the worker kept for short ones.
const SHORT_S: f64 = 1.0;

impl Service {
    /// Most characters of an idempotency key.
    pub const MAX_IDEMPOTENCY_KEY: usize = 255;

    /// The service over running `jobs`.
    pub fn new(jobs: Jobs, robots: Arc<dyn RobotStore>, metrics: Arc<Metrics>) -> Self {
        // A counter that is not there before its first count seems never to
        // have increased.
        for code in ErrorCode::ALL.map(ErrorCode::as_str) {
            metrics.rejections.with_label_values(&[code]);
        }
        Self { inner: Arc::new(Inner { jobs, robots, metrics }) }
    }

    /// Accepts a job. When this returns it is stored for good.
    ///
    /// A robot given by name is put into the job in full, so that registering
    /// another under its name changes nothing. The same `idempotency_key` with
    /// an equal request answers with the first job.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Invalid`] with all faults, [`ErrorCode::IdempotencyMismatch`],
    /// [`ErrorCode::QueueFull`], [`ErrorCode::Draining`] or
    /// [`ErrorCode::Unavailable`]; the job is then not accepted.
    pub async fn create_job(
        &self,
        request: JobRequest,
        idempotency_key: Option<String>,
    ) -> Result<Submitted, ServiceError> {
        let idempotency = idempotency_key.map(|key| idempotency(key, &request)).transpose()?;
        let new = self.prepare(request, idempotency).await?;
        Ok(self.inner.jobs.submit(new).await?)
    }

    /// Counts a submission that an edge answered with `code`, be it for
    /// [`create_job`](Self::create_job) or because it could not be read.
    pub fn count_rejection(&self, code: &'static str) {
        self.inner.metrics.rejections.with_label_values(&[code]).inc();
    }

    async fn prepare(
        &self,
        mut request: JobRequest,
        idempotency: Option<Idempotency>,
    ) -> Result<NewJob, ServiceError> {
        let new = self.with_robots(move |find| {
            let mut faults = Faults::default();
            request.check(&mut faults);
            let prepared = match plan::validate(&request.plan, find) {
                Ok(prepared) => faults.into_result(prepared)?,
                Err(more) => {
                    faults.add_below("", more);
                    return Err(faults);
                }
            };
            for reference in request.plan.robots_mut() {
                if let RobotRef::Name(name) = reference
                    && let Some(robot) = find(name)
                {
                    *reference = RobotRef::Inline(Box::new(robot.description().clone()));
                }
            }
            let text = serde_json::to_string(&request.plan);
            Ok(text.map(|text| NewJob {
                request: text,
                task: prepared.task().to_owned(),
                method: prepared.method(),
                robot: prepared.robot_name().to_owned(),
                seed: request.plan.seed,
                priority: request.priority,
                labels: request.labels,
                deadline_s: request.deadline_s,
                start_by: request.start_by,
                short: prepared.estimate_s() < SHORT_S,
                idempotency,
            }))
        });
        new.await?.map_err(ServiceError::internal)
    }

    /// The job as it is now.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], or the store's.
    pub async fn job(&self, id: JobId) -> Result<Job, ServiceError> {
        Ok(self.inner.jobs.get(id).await?)
    }

    /// Jobs that match, newest first.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Invalid`] for a page token that is not ours or for more
    /// labels than a job can have, or the store's.
    pub async fn list_jobs(&self, filter: JobFilter) -> Result<JobPage, ServiceError> {
        let (labels, most) = (filter.labels.len(), JobRequest::MAX_LABELS);
        if labels > most {
            let mut faults = Faults::default();
            faults.add("/labels", format!("{labels} labels are more than {most}"));
            return Err(faults.into());
        }
        Ok(self.inner.jobs.list(filter).await?)
    }

    /// Ends a job; the answer may still show it running.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::Conflict`] if it has ended, or the
    /// store's.
    pub async fn cancel_job(&self, id: JobId) -> Result<Job, ServiceError> {
        Ok(self.inner.jobs.cancel(id).await?)
    }

    /// Deletes an ended job with all that belongs to it.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::Conflict`] if it has not ended, or
    /// the store's.
    pub async fn delete_job(&self, id: JobId) -> Result<(), ServiceError> {
        self.inner.jobs.delete(id).await.map_err(|error| match error {
            JobsError::Conflict { id, state } => {
                let message = format!("job {id} is {state}; cancel it first");
                ServiceError::new(ErrorCode::Conflict, message)
            }
            error => error.into(),
        })
    }

    /// The plan request of a job as JSON text, its robot in full.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], or the store's.
    pub async fn request_text(&self, id: JobId) -> Result<String, ServiceError> {
        Ok(self.inner.jobs.request(id).await?)
    }

    /// The result of a job that succeeded, as the JSON text that was stored.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::NotEnded`],
    /// [`ErrorCode::NoResult`] if the job did not succeed, or the store's.
    pub async fn result_text(&self, id: JobId) -> Result<String, ServiceError> {
        let JobResult { job, text } = self.ended(id).await?;
        match text {
            Some(text) if job.state == JobState::Succeeded => Ok(text),
            partial => Err(no_result(&job, partial.is_some())),
        }
    }

    /// What an ended job produced, complete or not, as the JSON text that was
    /// stored.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::NotEnded`],
    /// [`ErrorCode::NoResult`] if there is nothing, or the store's.
    pub async fn partial_result_text(&self, id: JobId) -> Result<String, ServiceError> {
        let JobResult { job, text } = self.ended(id).await?;
        text.ok_or_else(|| no_result(&job, false))
    }

    /// The result of a job that succeeded.
    ///
    /// # Errors
    ///
    /// As [`result_text`](Self::result_text).
    pub async fn result(&self, id: JobId) -> Result<PlanResult, ServiceError> {
        let text = self.result_text(id).await?;
        blocking(move || serde_json::from_str(&text).map_err(ServiceError::internal)).await
    }

    async fn ended(&self, id: JobId) -> Result<JobResult, ServiceError> {
        self.inner.jobs.result(id).await.map_err(|error| match error {
            JobsError::Conflict { id, state } => {
                let message = format!("job {id} is {state}; its result comes when it has ended");
                ServiceError::new(ErrorCode::NotEnded, message)
            }
            error => error.into(),
        })
    }

    /// The job's events that follow number `after_seq` (0 for all), as they
    /// happen; ends after the last one, or with an error if the server drains
    /// or its store fails.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], or the store's.
    pub async fn watch(
        &self,
        id: JobId,
        after_seq: u64,
    ) -> Result<impl Stream<Item = Result<Arc<JobEvent>, ServiceError>> + Send + use<>, ServiceError>
    {
        let events = self.inner.jobs.watch(id, after_seq).await?;
        Ok(events.map(|event| event.map_err(ServiceError::from)))
    }

    /// The job as it is when it has ended or `timeout` has passed.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], or the store's.
    pub async fn wait_ended(&self, id: JobId, timeout: Duration) -> Result<Job, ServiceError> {
        Ok(self.inner.jobs.wait_ended(id, timeout).await?)
    }

    /// How many jobs wait and run.
    pub fn counts(&self) -> JobCounts {
        self.inner.jobs.counts()
    }

    /// The certificate of anyone's trajectory.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Invalid`] with all faults, or the store's.
    pub async fn verify(&self, request: VerifyRequest) -> Result<Certificate, ServiceError> {
        self.with_robots(move |find| plan::verify::verify(&request, find)).await
    }

    /// The optimizers on offer.
    pub fn optimizers(&self) -> Vec<OptimizerInfo> {
        OPTIMIZERS.iter().map(OptimizerEntry::info).collect()
    }

    /// The planners on offer.
    pub fn planners(&self) -> Vec<PlannerInfo> {
        PLANNERS.iter().map(PlannerEntry::info).collect()
    }

    /// The ways to smooth a path.
    pub fn smoothings(&self) -> Vec<SmoothingInfo> {
        SMOOTHINGS.iter().map(SmoothingEntry::info).collect()
    }

    /// The interpolations on offer.
    pub fn interpolations(&self) -> Vec<InterpolationInfo> {
        INTERPOLATIONS.iter().map(Interpolation::info).collect()
    }

    /// Requests that are ready to be sent.
    pub fn scenarios(&self) -> &'static [Scenario] {
        plan::scenarios::all()
    }

    /// Whether jobs can be accepted and stored.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Draining`] or [`ErrorCode::Unavailable`].
    pub async fn readiness(&self) -> Result<(), ServiceError> {
        Ok(self.inner.jobs.health().await?)
    }

    /// Whether the process can still do its work. A drain is no failure; after
    /// one, only a new start helps.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Unavailable`].
    pub fn liveness(&self) -> Result<(), ServiceError> {
        self.inner.jobs.store_failure().map_or(Ok(()), |failure| Err(failure.into()))
    }

    /// All metrics in Prometheus' text format.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Internal`].
    pub fn metrics_text(&self) -> Result<String, ServiceError> {
        self.inner.metrics.text().map_err(ServiceError::internal)
    }

    /// Deletes jobs that ended more than `days` ago and answers how many.
    ///
    /// # Errors
    ///
    /// The store's.
    pub async fn delete_older_than(&self, days: u32) -> Result<usize, ServiceError> {
        let age = SignedDuration::from_hours(i64::from(days) * 24);
        // Older than the calendar: nothing can be.
        let Ok(time) = Timestamp::now().checked_sub(age) else { return Ok(0) };
        Ok(self.inner.jobs.delete_ended_before(time).await?)
    }

    /// Stops: no job is accepted or started any more, running ones get `grace`
    /// to end, watchers' streams end.
    pub async fn drain(&self, grace: Duration) -> Drained {
        self.inner.jobs.drain(grace).await
    }
}

/// The id under which a request is followed in the log: the one `given` by the
/// client if it is a sensible one, else a new one.
pub fn request_id(given: Option<&str>) -> String {
    const LONGEST: usize = 128;
    let sensible = |id: &&str| {
        (1..=LONGEST).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_graphic())
    };
    given.filter(sensible).map_or_else(|| Uuid::now_v7().to_string(), str::to_owned)
}

/// Names a submission by its key and by what was asked, robot names not yet
/// looked up.
fn idempotency(key: String, request: &JobRequest) -> Result<Idempotency, ServiceError> {
    if !(1..=Service::MAX_IDEMPOTENCY_KEY).contains(&key.chars().count()) {
        let message =
            format!("an idempotency key has 1 to {} characters", Service::MAX_IDEMPOTENCY_KEY);
        return Err(ServiceError::new(ErrorCode::Invalid, message));
    }
    let body = serde_json::to_vec(request).map_err(ServiceError::internal)?;
    Ok(Idempotency { key, body_sha256: Sha256::digest(body).into() })
}

fn no_result(job: &Job, partial: bool) -> ServiceError {
    let id = job.id;
    let why = match &job.error {
        Some(error) => format!("{}: {}: {}", job.state, error.code, error.message),
        None => job.state.to_string(),
    };
    let rest =
        if partial { "; what there is of the plan can be had as a partial result" } else { "" };
    ServiceError::new(ErrorCode::NoResult, format!("job {id} is {why}{rest}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_sensible_request_id_is_kept() {
        assert_eq!(request_id(Some("cell-3/17")), "cell-3/17");
        for given in
            [None, Some(""), Some("two words"), Some("line\nbreak"), Some(&*"x".repeat(129))]
        {
            assert!(request_id(given).parse::<Uuid>().is_ok(), "{given:?}");
        }
    }
}
