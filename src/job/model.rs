//! What is kept of a job and served to its owner.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;
use uuid::Uuid;

use super::Progress;

/// Names a job: a UUID of version 7, so that ids sort by time of acceptance.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(transparent)]
#[schema(value_type = String, format = "uuid")]
pub struct JobId(Uuid);

impl JobId {
    /// A new id, unlike any other.
    #[expect(clippy::new_without_default, reason = "every call gives another id")]
    pub fn new() -> Self {
        Self(Uuid::now_v7())
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for JobId {
    type Err = uuid::Error;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(Self)
    }
}

/// Where a job stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Accepted and stored; waits for a worker.
    Queued,
    /// A worker plans.
    Running,
    /// Ended with a result.
    Succeeded,
    /// Ended without a complete result; the job's error says why.
    Failed,
    /// Ended because somebody asked for it.
    Cancelled,
    /// Ended because it could not start in time.
    Expired,
}

impl JobState {
    /// Every state, in the order of a job's life.
    pub const ALL: [Self; 6] = [
        Self::Queued,
        Self::Running,
        Self::Succeeded,
        Self::Failed,
        Self::Cancelled,
        Self::Expired,
    ];

    /// True for the four states that no job leaves.
    pub fn is_ended(self) -> bool {
        !matches!(self, Self::Queued | Self::Running)
    }

    /// The state's name as users and the store write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
            Self::Expired => "expired",
        }
    }
}

impl fmt::Display for JobState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// No state has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown job state `{0}`; known: {known}", known = JobState::ALL.map(JobState::as_str).join(", "))]
pub struct UnknownJobState(pub String);

impl FromStr for JobState {
    type Err = UnknownJobState;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let named = |state: &Self| state.as_str() == text;
        Self::ALL.into_iter().find(named).ok_or_else(|| UnknownJobState(text.to_owned()))
    }
}

/// Why a job ended without success.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobError {
    /// Stable name of the fault, such as `limits_unreachable`.
    pub code: String,
    /// What happened, for people.
    pub message: String,
    /// Where it happened: waypoint, joint, limit and the like.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    #[schema(value_type = Object)]
    pub details: Value,
}

/// A planning job without its request and result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Job {
    /// The job's name.
    pub id: JobId,
    /// Where it stands.
    pub state: JobState,
    /// 0 to 100; higher starts earlier.
    #[schema(minimum = 0, maximum = 100)]
    pub priority: u8,
    /// The owner's own marks.
    pub labels: BTreeMap<String, String>,
    /// The task's type, such as `waypoints`.
    pub task: String,
    /// The method that plans it, such as `improved_pso`.
    pub method: String,
    /// The robot it is planned for.
    pub robot: String,
    /// Seed of the random streams.
    pub seed: u64,
    /// When it was accepted.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// When the latest attempt began.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub started_at: Option<Timestamp>,
    /// When it ended.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub finished_at: Option<Timestamp>,
    /// Seconds from acceptance within which it has to end.
    pub deadline_s: Option<f64>,
    /// Latest time at which it may begin.
    #[schema(value_type = Option<String>, format = DateTime)]
    pub start_by: Option<Timestamp>,
    /// Attempts so far, the running one included. An attempt that a draining
    /// server interrupted is not counted.
    pub attempt: u32,
    /// The latest progress that was kept.
    pub progress: Option<Progress>,
    /// Why it failed or expired.
    pub error: Option<JobError>,
}

impl Job {
    /// The job that `new` becomes when accepted at `created_at`.
    pub fn accepted(id: JobId, new: &NewJob, created_at: Timestamp) -> Self {
        Self {
            id,
            state: JobState::Queued,
            priority: new.priority,
            labels: new.labels.clone(),
            task: new.task.clone(),
            method: new.method.clone(),
            robot: new.robot.clone(),
            seed: new.seed,
            created_at,
            started_at: None,
            finished_at: None,
            deadline_s: new.deadline_s,
            start_by: new.start_by,
            attempt: 0,
            progress: None,
            error: None,
        }
    }
}

/// A request to plan, checked and ready to be accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct NewJob {
    /// The plan request as canonical JSON; the [`Runner`](super::Runner) gets
    /// exactly this text.
    pub request: String,
    /// The task's type.
    pub task: String,
    /// The method that plans it.
    pub method: String,
    /// The robot's name.
    pub robot: String,
    /// Seed of the random streams.
    pub seed: u64,
    /// 0 to 100; higher starts earlier.
    pub priority: u8,
    /// The owner's own marks.
    pub labels: BTreeMap<String, String>,
    /// Seconds from acceptance within which the job has to end.
    pub deadline_s: Option<f64>,
    /// Latest time at which the job may begin.
    pub start_by: Option<Timestamp>,
    /// True if the work is estimated to be short, so that it may use the slot
    /// kept free of long jobs.
    pub short: bool,
    /// Makes a repeated submission harmless.
    pub idempotency: Option<Idempotency>,
}

/// Priority of a job whose request names none.
pub const DEFAULT_PRIORITY: u8 = 50;

/// A client's name for one submission, with what it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Idempotency {
    /// The client's key.
    pub key: String,
    /// SHA-256 of the body sent under that key.
    pub body_sha256: [u8; 32],
}

/// A submission's answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Submitted {
    /// The job, stored.
    pub job: Job,
    /// True if an earlier submission under the same key made it.
    pub existing: bool,
}

/// Which jobs to list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Only jobs in this state.
    pub state: Option<JobState>,
    /// Only jobs that carry all these labels.
    pub labels: BTreeMap<String, String>,
    /// At most this many jobs; at least one is taken.
    pub page_size: usize,
    /// Where the page before ended.
    pub page_token: Option<String>,
}

/// Jobs, newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobPage {
    /// The page's jobs.
    pub jobs: Vec<Job>,
    /// Asks for the next page; absent on the last.
    pub next_page_token: Option<String>,
}

/// An ended job with what it produced.
#[derive(Clone, Debug, PartialEq)]
pub struct JobResult {
    /// The job.
    pub job: Job,
    /// The result as JSON text: complete if the job succeeded, else what there
    /// was of the plan, if anything.
    pub text: Option<String>,
}

/// How many jobs this process holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobCounts {
    /// Jobs that wait for a worker.
    pub queued: usize,
    /// Jobs that run.
    pub running: usize,
    /// Jobs that may wait at once.
    pub capacity: usize,
}

/// The time now, in the unit that every store can keep.
pub(super) fn now() -> Timestamp {
    to_microseconds(Timestamp::now())
}

/// `time` in full microseconds: live and stored times then are equal.
pub(super) fn to_microseconds(time: Timestamp) -> Timestamp {
    Timestamp::from_microsecond(time.as_microsecond()).unwrap_or(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_have_one_name_everywhere() {
        for state in JobState::ALL {
            assert_eq!(serde_json::to_value(state).unwrap(), state.as_str());
            assert_eq!(state.as_str().parse(), Ok(state));
        }
        assert!("done".parse::<JobState>().is_err());
        let ended = JobState::ALL.into_iter().filter(|state| state.is_ended()).count();
        assert_eq!(ended, 4);
    }

    #[test]
    fn ids_are_read_as_written_and_sort_by_time() {
        let ids: Vec<JobId> = (0..100).map(|_| JobId::new()).collect();
        assert!(ids.is_sorted());
        assert_eq!(ids[0].to_string().parse(), Ok(ids[0]));
        assert_eq!(serde_json::to_value(ids[0]).unwrap(), ids[0].to_string());
    }
}
