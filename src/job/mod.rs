//! Planning jobs: what is kept of each, the queue, the workers that run them
//! and the watchers that follow them.
//!
//! [`Jobs`] is the door. It stores a job before it answers, queues it by
//! priority, runs it on threads of its own and shows every watcher the same
//! sequence of events. This module knows neither robots nor SQL: planning
//! comes in through [`Runner`], storage through [`JobStore`].

mod event;
mod metrics;
mod model;
mod runner;
mod store;

pub use event::{EventKind, JobEvent, Progress};
pub use metrics::Metrics;
pub use model::{
    DEFAULT_PRIORITY, Idempotency, Job, JobCounts, JobError, JobFilter, JobId, JobPage, JobResult,
    JobState, NewJob, Submitted, UnknownJobState,
};
pub use runner::{RunContext, RunOutcome, Runner};
pub use store::{
    Claim, EventSink, Finish, Inserted, JobStore, QueuedJob, Reply, ReplySender, StoreError,
};
