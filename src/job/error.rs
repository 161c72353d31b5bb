//! Why the job layer refused.

use std::sync::Arc;

use super::{JobId, JobState, StoreError};

/// Why a call on [`Jobs`](super::Jobs) had no effect.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JobsError {
    /// There is no such job.
    #[error("there is no job {0}")]
    NotFound(JobId),
    /// The job's state forbids it.
    #[error("job {id} is {state}")]
    Conflict {
        /// The job.
        id: JobId,
        /// Where it stands.
        state: JobState,
    },
    /// As many jobs wait as may; try again later.
    #[error("the queue is full: {capacity} jobs wait")]
    QueueFull {
        /// How many may wait.
        capacity: usize,
    },
    /// The server is about to stop.
    #[error("the server is draining and takes no more jobs")]
    Draining,
    /// The idempotency key was used for another body.
    #[error("the idempotency key was used before for another request")]
    IdempotencyMismatch,
    /// The page token is not one of ours.
    #[error("unknown page token `{0}`")]
    PageToken(String),
    /// The store takes no more work until the server is started again.
    #[error("the store has failed: {0}")]
    StoreFailed(Arc<str>),
    /// A fault of ours; the message is for the log.
    #[error("internal fault: {0}")]
    Internal(String),
}

impl From<StoreError> for JobsError {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Failed(reason) => Self::StoreFailed(reason),
            StoreError::PageToken(token) => Self::PageToken(token),
            StoreError::Statement(message) => Self::Internal(message),
        }
    }
}
