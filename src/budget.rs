//! Limits on a planning run: evaluations, time and cancellation.
//!
//! This is the only place below the job layer that reads a clock, so a run
//! without a time limit depends on nothing but its request and seed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Why an optimisation run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The method found no way to improve any further.
    Converged,
    /// What was asked for is found: a path, or one that is short enough.
    Solved,
    /// All requested iterations were done.
    IterationLimit,
    /// The evaluation limit was reached.
    EvaluationLimit,
    /// The time limit or the job's deadline passed; the result may differ
    /// from run to run.
    TimeLimit,
    /// Somebody cancelled the run.
    Cancelled,
    /// The server drains: the run will be started again elsewhere or later.
    Interrupted,
}

impl std::fmt::Display for StopReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::Solved => "solved",
            Self::IterationLimit => "iteration limit",
            Self::EvaluationLimit => "evaluation limit",
            Self::TimeLimit => "time limit",
            Self::Cancelled => "cancelled",
            Self::Interrupted => "interrupted",
        })
    }
}

/// A flag shared between a run and whoever may want to end it.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<AtomicU8>);

impl CancelToken {
    const RUNNING: u8 = 0;
    const CANCELLED: u8 = 1;
    const INTERRUPTED: u8 = 2;

    /// Ends the run for good. Wins over an interruption.
    pub fn cancel(&self) {
        self.0.store(Self::CANCELLED, Ordering::Release);
    }

    /// Ends the run so that it can be started again.
    pub fn interrupt(&self) {
        // A cancelled run stays cancelled: the exchange fails and that is right.
        let _ = self.0.compare_exchange(
            Self::RUNNING,
            Self::INTERRUPTED,
            Ordering::AcqRel,
            Ordering::Acquire,
        );
    }

    /// Why the run should end, if it should.
    pub fn reason(&self) -> Option<StopReason> {
        match self.0.load(Ordering::Acquire) {
            Self::CANCELLED => Some(StopReason::Cancelled),
            Self::INTERRUPTED => Some(StopReason::Interrupted),
            _ => None,
        }
    }
}

/// The limits of one run.
#[derive(Clone, Debug)]
pub struct Budget {
    started: Instant,
    deadline: Option<Instant>,
    max_evaluations: Option<u64>,
    cancel: CancelToken,
}

impl Default for Budget {
    fn default() -> Self {
        Self::new(CancelToken::default())
    }
}

impl Budget {
    /// A budget without limits that `cancel` can end.
    pub fn new(cancel: CancelToken) -> Self {
        Self { started: Instant::now(), deadline: None, max_evaluations: None, cancel }
    }

    /// Ends the run at `deadline`, or earlier if it already had to.
    #[must_use]
    pub fn with_deadline(mut self, deadline: Option<Instant>) -> Self {
        self.deadline = match (self.deadline, deadline) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        self
    }

    /// Ends the run after `limit` from now.
    #[must_use]
    pub fn with_time_limit(self, limit: Option<Duration>) -> Self {
        let deadline = limit.and_then(|limit| Instant::now().checked_add(limit));
        self.with_deadline(deadline)
    }

    /// Ends the run after this many evaluations of the objective.
    #[must_use]
    pub fn with_max_evaluations(mut self, max_evaluations: Option<u64>) -> Self {
        self.max_evaluations = max_evaluations;
        self
    }

    /// How many more evaluations may follow `evaluations`.
    pub fn evaluations_left(&self, evaluations: u64) -> u64 {
        self.max_evaluations.map_or(u64::MAX, |limit| limit.saturating_sub(evaluations))
    }

    /// Why the run should end after `evaluations`, if it should.
    pub fn stop_reason(&self, evaluations: u64) -> Option<StopReason> {
        if let Some(reason) = self.cancel.reason() {
            return Some(reason);
        }
        if self.max_evaluations.is_some_and(|limit| evaluations >= limit) {
            return Some(StopReason::EvaluationLimit);
        }
        let late = self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        late.then_some(StopReason::TimeLimit)
    }

    /// Seconds since the budget was made.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancelling_wins_over_interrupting() {
        let token = CancelToken::default();
        assert_eq!(token.reason(), None);
        token.interrupt();
        assert_eq!(token.reason(), Some(StopReason::Interrupted));
        token.cancel();
        token.interrupt();
        assert_eq!(token.reason(), Some(StopReason::Cancelled));
    }

    #[test]
    fn the_tightest_limit_ends_the_run() {
        let budget = Budget::default().with_max_evaluations(Some(10));
        assert_eq!(budget.stop_reason(9), None);
        assert_eq!(budget.stop_reason(10), Some(StopReason::EvaluationLimit));
        let late = Budget::default().with_time_limit(Some(Duration::ZERO));
        assert_eq!(late.stop_reason(0), Some(StopReason::TimeLimit));
    }
}
