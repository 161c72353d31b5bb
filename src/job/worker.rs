//! What a worker does with a job.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use jiff::Timestamp;
use serde_json::Value;

use super::backlog::Slot;
use super::model::now;
use super::scheduler::{Claimed, Scheduler};
use super::throttle::Throttle;
use super::{
    Claim, Finish, JobError, JobState, JobStore, Metrics, Progress, QueuedJob, RunContext,
    RunOutcome, Runner, StoreError, lock,
};
use crate::budget::StopReason;

/// What all workers share.
pub(super) struct Worker {
    pub(super) scheduler: Arc<Scheduler>,
    pub(super) store: Arc<dyn JobStore>,
    pub(super) runner: Arc<dyn Runner>,
    pub(super) metrics: Arc<Metrics>,
}

impl Worker {
    /// Runs jobs that fit `slot` until the scheduler stops or the store fails.
    pub(super) fn work(&self, slot: Slot) {
        while let Some(claimed) = self.scheduler.next(slot) {
            if self.store_failed(&claimed.job, self.handle(&claimed)) {
                return;
            }
        }
    }

    /// Ends jobs that can no longer start in time, until the scheduler stops
    /// or the store fails.
    pub(super) fn expire_late_jobs(&self) {
        while let Some(job) = self.scheduler.next_expired() {
            if self.store_failed(&job, self.expire(&job)) {
                return;
            }
        }
    }

    /// Logs an error; true if there is no point in going on.
    fn store_failed(&self, job: &QueuedJob, outcome: Result<(), StoreError>) -> bool {
        let Err(error) = outcome else { return false };
        tracing::error!(job = %job.id, %error, "a job's change of state was not stored");
        matches!(error, StoreError::Failed(_))
    }

    fn handle(&self, claimed: &Claimed) -> Result<(), StoreError> {
        let job = &claimed.job;
        let start = now();
        if job.latest_start().is_some_and(|latest| latest <= start) {
            return self.expire(job);
        }
        // Nothing if the job was cancelled between the queue and here.
        let claim = match self.store.start(job.id, start).wait() {
            Ok(Some(claim)) => claim,
            Ok(None) => return Ok(()),
            Err(StoreError::Statement(error)) => return self.give_up(job, &error),
            Err(error) => return Err(error),
        };
        let waited = start.duration_since(job.created_at).as_secs_f64();
        self.metrics.started(&job.task, &job.method, waited.max(0.0));
        let outcome = self.run(claimed, &claim, start);
        self.conclude(claimed, &claim, outcome)
    }

    fn expire(&self, job: &QueuedJob) -> Result<(), StoreError> {
        let at = now();
        let (code, message) = match job.deadline() {
            Some(deadline) if deadline <= at => {
                ("deadline_exceeded", format!("still queued at its deadline, {deadline}"))
            }
            _ => ("start_by_passed", "still queued at its latest time to start".to_owned()),
        };
        let error = JobError { code: code.to_owned(), message, details: Value::Null };
        let finish = Finish { error: Some(error), ..Finish::new(JobState::Expired, at) };
        if self.store.finish_queued(job.id, finish).wait()? {
            self.metrics.ended(JobState::Expired, &job.task, &job.method);
        }
        Ok(())
    }

    /// Fails a job that cannot be read from the store, so that it does not
    /// wait for ever.
    fn give_up(&self, job: &QueuedJob, error: &str) -> Result<(), StoreError> {
        tracing::error!(job = %job.id, error, "a job could not be started");
        let finish = finish_of(internal("the job could not be read from the store"));
        if self.store.finish_queued(job.id, finish).wait()? {
            self.metrics.ended(JobState::Failed, &job.task, &job.method);
        }
        Ok(())
    }

    /// Runs the planner and passes its progress on.
    fn run(&self, claimed: &Claimed, claim: &Claim, start: Timestamp) -> RunOutcome {
        let job = &claimed.job;
        if claimed.cancel.reason() == Some(StopReason::Cancelled) {
            return RunOutcome::Cancelled { partial: None };
        }
        let begun = Instant::now();
        let reports = Mutex::new((Throttle::default(), 0));
        let progress = |progress: Progress| {
            let mut reports = lock(&reports);
            reports.1 = progress.evaluations.max(reports.1);
            if let Some(progress) = reports.0.admit(begun.elapsed(), progress.finite()) {
                // Sent under the lock to keep the order; nobody waits for the commit.
                drop(self.store.progress(job.id, claim.number, now(), progress));
            }
        };
        let deadline = job.deadline().and_then(|deadline| {
            let left = Duration::try_from(deadline.duration_since(start)).unwrap_or_default();
            begun.checked_add(left)
        });
        let cancel = claimed.cancel.clone();
        let context = RunContext { job: job.id, cancel, deadline, progress: &progress };
        let run = || self.runner.run(&claim.request, &context);
        let outcome = catch_unwind(AssertUnwindSafe(run))
            .unwrap_or_else(|panic| panicked(job, panic.as_ref()));
        let (mut throttle, evaluations) =
            reports.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(progress) = throttle.take_held() {
            drop(self.store.progress(job.id, claim.number, now(), progress));
        }
        self.metrics.ran(&job.task, &job.method, begun.elapsed().as_secs_f64(), evaluations);
        outcome
    }

    /// Stores how the run ended.
    fn conclude(
        &self,
        claimed: &Claimed,
        claim: &Claim,
        outcome: RunOutcome,
    ) -> Result<(), StoreError> {
        let job = &claimed.job;
        let finish = match (outcome, claimed.cancel.reason()) {
            (RunOutcome::Interrupted, Some(StopReason::Interrupted)) => {
                if !self.store.requeue(job.id, claim.number, now()).wait()? {
                    self.metrics.discarded_results.inc();
                }
                return Ok(());
            }
            (RunOutcome::Interrupted, None) => {
                finish_of(internal("the planner stopped without being asked to"))
            }
            (outcome, _) => finish_of(outcome),
        };
        let mut state = finish.state;
        let mut stored = self.store.finish(job.id, claim.number, finish).wait();
        if let Err(StoreError::Statement(error)) = &stored {
            // A result beyond what the store can hold must not leave the job running.
            tracing::error!(job = %job.id, error, "a result was not stored");
            let finish = finish_of(internal("the result could not be stored"));
            state = finish.state;
            stored = self.store.finish(job.id, claim.number, finish).wait();
        }
        if stored? {
            self.metrics.ended(state, &job.task, &job.method);
        } else {
            self.metrics.discarded_results.inc();
            tracing::warn!(job = %job.id, claim = claim.number, "a late result was discarded");
        }
        Ok(())
    }
}

fn finish_of(outcome: RunOutcome) -> Finish {
    let at = now();
    match outcome {
        RunOutcome::Succeeded { result, summary } => Finish {
            result: Some(result),
            summary: Some(summary),
            ..Finish::new(JobState::Succeeded, at)
        },
        RunOutcome::Failed { code, message, details, partial } => Finish {
            result: partial,
            error: Some(JobError { code, message, details }),
            ..Finish::new(JobState::Failed, at)
        },
        RunOutcome::Cancelled { partial } => {
            Finish { result: partial, ..Finish::new(JobState::Cancelled, at) }
        }
        // Cancelled after the planner had given way to an interruption.
        RunOutcome::Interrupted => Finish::new(JobState::Cancelled, at),
    }
}

fn panicked(job: &QueuedJob, panic: &(dyn Any + Send)) -> RunOutcome {
    tracing::error!(
        job = %job.id, task = job.task, method = job.method, panic = panic_text(panic),
        "the planner panicked",
    );
    internal("the planner panicked; the server's log has the details under this job's id")
}

/// What a caught panic said.
pub fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("without a message")
}

fn internal(message: &str) -> RunOutcome {
    RunOutcome::Failed {
        code: "internal".to_owned(),
        message: message.to_owned(),
        details: Value::Null,
        partial: None,
    }
}
