//! Planning jobs: what is kept of each, the queue, the workers that run them
//! and the watchers that follow them.
//!
//! [`Jobs`] is the door. It stores a job before it answers, queues it by
//! priority, runs it on threads of its own and shows every watcher the same
//! sequence of events. This module knows neither robots nor SQL: planning
//! comes in through [`Runner`], storage through [`JobStore`].

mod backlog;
mod error;
mod event;
mod hub;
mod jobs;
mod metrics;
mod model;
mod runner;
mod scheduler;
mod store;
mod throttle;
mod worker;

use std::sync::{Mutex, MutexGuard, PoisonError};

pub use error::JobsError;

pub use crate::plan::Progress;
pub use event::{EventKind, JobEvent};
pub use jobs::{Drained, JobSettings, Jobs, MAX_ATTEMPTS};
pub use metrics::Metrics;
pub use model::{
    DEFAULT_PRIORITY, Idempotency, Job, JobCounts, JobError, JobFilter, JobId, JobPage, JobResult,
    JobState, NewJob, Submitted, UnknownJobState,
};
pub use runner::{RunContext, RunOutcome, Runner};
pub use store::{
    Claim, EventSink, Finish, Inserted, JobStore, KeyUse, QueuedJob, Reply, ReplySender, StoreError,
};
pub use worker::panic_text;

/// Locks `mutex`. What it guards is changed in single steps only, so a panic
/// elsewhere leaves nothing half done.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
