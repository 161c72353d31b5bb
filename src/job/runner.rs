//! What the workers run. The planning itself is implemented above.

use std::time::Instant;

use serde_json::Value;

use super::{JobId, Progress};
use crate::budget::CancelToken;

/// Carries out the work of a job.
pub trait Runner: Send + Sync {
    /// Plans `request`, the text given as [`NewJob::request`](super::NewJob).
    ///
    /// Called on a worker's thread. An implementation looks at the token and
    /// the deadline of `context` about every millisecond; the same request may
    /// be run again after a crash. A panic fails the job and nothing else.
    fn run(&self, request: &str, context: &RunContext<'_>) -> RunOutcome;
}

/// What a run may know of the world around it.
#[derive(Clone)]
pub struct RunContext<'a> {
    /// The job that is run.
    pub job: JobId,
    /// Says when the run has to end: return [`RunOutcome::Cancelled`] or
    /// [`RunOutcome::Interrupted`] as it asks.
    pub cancel: CancelToken,
    /// When passed, return [`RunOutcome::Failed`] with the code
    /// `deadline_exceeded`.
    pub deadline: Option<Instant>,
    /// Takes progress, as often as it comes; never blocks on a watcher or on
    /// the store.
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum RunOutcome {
    /// The plan is complete.
    Succeeded {
        /// The result as JSON text, served as it is.
        result: String,
        /// The result in a few figures, for the last event.
        summary: Value,
    },
    /// There is no complete plan.
    Failed {
        /// Stable name of the fault.
        code: String,
        /// What happened, for people.
        message: String,
        /// Where it happened.
        details: Value,
        /// What exists of the plan, as JSON text.
        partial: Option<String>,
    },
    /// The token said cancelled.
    Cancelled {
        /// What exists of the plan, as JSON text.
        partial: Option<String>,
    },
    /// The token said interrupted: the job is queued again, and the attempt
    /// does not count.
    Interrupted,
}
