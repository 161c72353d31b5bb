//! Why a use case failed, without a word of any protocol.

use std::any::Any;
use std::fmt;

use crate::fault::{Fault, Faults};
use crate::job::{JobsError, panic_text};

/// What kind of failure it is. Each edge maps these once to its own codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorCode {
    /// The input is not even JSON, or not a message.
    Unreadable,
    /// The input can be read and makes no sense; the faults say where.
    Invalid,
    /// There is no such job, robot or leg.
    NotFound,
    /// The state of a job or robot forbids it.
    Conflict,
    /// The job has not ended, so there is no result yet.
    NotEnded,
    /// The job ended without the result asked for.
    NoResult,
    /// The idempotency key was used for another request.
    IdempotencyMismatch,
    /// The input is larger than allowed.
    TooLarge,
    /// As many jobs wait as may; try again later.
    QueueFull,
    /// The server is about to stop.
    Draining,
    /// The store has failed; the server has to be started again.
    Unavailable,
    /// A fault of ours; the log has the cause.
    Internal,
}

impl ErrorCode {
    /// Every code.
    pub const ALL: [Self; 12] = [
        Self::Unreadable,
        Self::Invalid,
        Self::NotFound,
        Self::Conflict,
        Self::NotEnded,
        Self::NoResult,
        Self::IdempotencyMismatch,
        Self::TooLarge,
        Self::QueueFull,
        Self::Draining,
        Self::Unavailable,
        Self::Internal,
    ];

    /// The stable name that users see.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Unreadable => "unreadable",
            Self::Invalid => "invalid",
            Self::NotFound => "not_found",
            Self::Conflict => "conflict",
            Self::NotEnded => "not_ended",
            Self::NoResult => "no_result",
            Self::IdempotencyMismatch => "idempotency_mismatch",
            Self::TooLarge => "too_large",
            Self::QueueFull => "queue_full",
            Self::Draining => "draining",
            Self::Unavailable => "unavailable",
            Self::Internal => "internal",
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Why a use case failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ServiceError {
    /// The kind of failure.
    pub code: ErrorCode,
    /// What happened, for the client's eyes.
    pub message: String,
    /// With [`ErrorCode::Invalid`], everything that is wrong.
    pub faults: Vec<Fault>,
}

impl ServiceError {
    /// An error without faults.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), faults: Vec::new() }
    }

    /// A fault of ours: `cause` goes to the log, the client learns only that
    /// it happened.
    pub fn internal(cause: impl fmt::Display) -> Self {
        tracing::error!(%cause, "internal fault");
        Self::new(ErrorCode::Internal, "the server made a mistake; its log has the cause")
    }

    /// A request's panic, which an edge has caught.
    pub fn panic(panic: &(dyn Any + Send)) -> Self {
        Self::internal(format!("panic: {}", panic_text(panic)))
    }
}

impl From<Faults> for ServiceError {
    fn from(faults: Faults) -> Self {
        // Those who found them may not have cut the list.
        let faults = faults.into_result(()).err().unwrap_or_default();
        Self { code: ErrorCode::Invalid, message: faults.to_string(), faults: faults.0 }
    }
}

impl From<JobsError> for ServiceError {
    fn from(error: JobsError) -> Self {
        let code = match &error {
            JobsError::NotFound(_) => ErrorCode::NotFound,
            JobsError::Conflict { .. } => ErrorCode::Conflict,
            JobsError::QueueFull { .. } => ErrorCode::QueueFull,
            JobsError::Draining => ErrorCode::Draining,
            JobsError::IdempotencyMismatch => ErrorCode::IdempotencyMismatch,
            JobsError::PageToken(_) => ErrorCode::Invalid,
            JobsError::StoreFailed(reason) => {
                tracing::error!(%reason, "the store has failed");
                return Self::new(ErrorCode::Unavailable, "the store has failed");
            }
            JobsError::Internal(cause) => return Self::internal(cause),
        };
        Self::new(code, error.to_string())
    }
}
