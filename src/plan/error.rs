//! Why planning failed.

use serde::Serialize;
use serde_json::{Value, json};

use super::result::PlanResult;
use crate::budget::StopReason;

/// What went wrong, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanCode {
    /// The limits do not admit what was asked.
    LimitsUnreachable,
    /// No path was found.
    NoPath,
    /// The start touches or lies in an obstacle.
    StartInCollision,
    /// The goal touches or lies in an obstacle.
    GoalInCollision,
    /// No configuration within the limits brings the tool to a pose.
    IkNoSolution,
    /// No timing of a free path was proven to stay free.
    NotFree,
    /// The job's deadline passed.
    DeadlineExceeded,
    /// Somebody cancelled.
    Cancelled,
    /// The server drains; the job will be planned again.
    Interrupted,
}

impl PlanCode {
    /// The code as users see it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::LimitsUnreachable => "limits_unreachable",
            Self::NoPath => "no_path",
            Self::StartInCollision => "start_in_collision",
            Self::GoalInCollision => "goal_in_collision",
            Self::IkNoSolution => "ik_no_solution",
            Self::NotFree => "motion_not_free",
            Self::DeadlineExceeded => "deadline_exceeded",
            Self::Cancelled => "cancelled",
            Self::Interrupted => "interrupted",
        }
    }
}

impl std::fmt::Display for PlanCode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Planning that ended without a valid plan.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct PlanError {
    /// What went wrong.
    pub code: PlanCode,
    /// In words, naming joint, value and limit where there are any.
    pub message: String,
    /// The same as data: leg, joint, limit, time, values.
    pub details: Value,
    /// What exists of the plan.
    pub partial: Option<Box<PlanResult>>,
}

impl PlanError {
    /// The limits do not admit what was asked.
    pub fn unreachable(message: String, details: Value) -> Self {
        Self { code: PlanCode::LimitsUnreachable, message, details, partial: None }
    }

    /// The run was ended from outside; none if `reason` is the run's own.
    pub fn stopped(reason: StopReason) -> Option<Self> {
        let (code, message) = match reason {
            StopReason::Cancelled => (PlanCode::Cancelled, "cancelled while planning"),
            StopReason::Interrupted => (PlanCode::Interrupted, "the server drains"),
            StopReason::TimeLimit => (PlanCode::DeadlineExceeded, "deadline passed while planning"),
            StopReason::Converged
            | StopReason::Solved
            | StopReason::IterationLimit
            | StopReason::EvaluationLimit => return None,
        };
        Some(Self { code, message: message.to_owned(), details: json!({}), partial: None })
    }

    /// The same error with what exists of the plan.
    #[must_use]
    pub fn with_partial(self, partial: PlanResult) -> Self {
        Self { partial: Some(Box::new(partial)), ..self }
    }

    /// The same error, said of a program's leg.
    #[must_use]
    pub fn in_leg(mut self, leg: &str) -> Self {
        self.message = format!("leg {leg}: {}", self.message);
        if let Value::Object(details) = &mut self.details {
            details.insert("leg".to_owned(), json!(leg));
        }
        self
    }
}
