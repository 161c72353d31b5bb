//! What a worker runs: from a stored request to a stored result.

use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::plan;
use crate::budget::{Budget, StopReason};
use crate::fault::Faults;
use crate::job::{Progress, RunContext, RunOutcome, Runner};
use crate::plan::{PlanRequest, PlanResult, TrajectoryResult};

/// Plans what the request asks for.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlanningRunner;

/// A result in a few figures: what a job's last event carries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResultSummary {
    /// Total duration, s.
    pub duration: f64,
    /// True if the certificate of every leg is lawful.
    pub lawful: bool,
    /// The worst ratio of a peak to its limit.
    pub worst_ratio: f64,
    /// No lawful trajectory is shorter, s; null if not proven.
    pub lower_bound: Option<f64>,
    /// Number of legs; 1 if the task is not a program.
    pub legs: usize,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Planning time, s.
    pub planning_s: f64,
}

impl From<&PlanResult> for ResultSummary {
    fn from(result: &PlanResult) -> Self {
        let bounds = trajectories(result).map(|leg| leg.bound.as_ref().map(|bound| bound.lower));
        let lower_bound = bounds.sum();
        match result {
            PlanResult::Trajectory(result) => Self {
                duration: result.duration,
                lawful: result.certificate.lawful,
                worst_ratio: result.certificate.worst_ratio,
                lower_bound,
                legs: 1,
                evaluations: result.evaluations,
                planning_s: result.planning_s,
            },
            PlanResult::Program(program) => Self {
                duration: program.duration,
                lawful: program.lawful,
                worst_ratio: program.worst_ratio,
                lower_bound,
                legs: program.legs.len(),
                evaluations: program.evaluations,
                planning_s: program.planning_s,
            },
        }
    }
}

/// The trajectories of a result, leg by leg.
pub(super) fn trajectories(result: &PlanResult) -> impl Iterator<Item = &TrajectoryResult> {
    let (single, legs) = match result {
        PlanResult::Trajectory(result) => (Some(&**result), &[][..]),
        PlanResult::Program(program) => (None, &program.legs[..]),
    };
    single.into_iter().chain(legs.iter().map(|leg| &leg.result))
}

impl Runner for PlanningRunner {
    fn run(&self, request: &str, context: &RunContext<'_>) -> RunOutcome {
        let request = match read(request) {
            Ok(request) => request,
            Err(faults) => return rejected(&faults),
        };
        // Robots were put into the request when it was accepted.
        let prepared = match plan::validate(&request, &|_| None) {
            Ok(prepared) => prepared,
            Err(faults) => return rejected(&faults),
        };
        let budget = Budget::new(context.cancel.clone()).with_deadline(context.deadline);
        let progress = |progress: plan::Progress| (context.progress)(reported(progress));
        let (result, error) = match prepared.run(&budget, &progress) {
            Ok(result) => (Some(Box::new(result)), None),
            Err(mut error) => (error.partial.take(), Some(error)),
        };
        conclude(result, error, context)
    }
}

fn read(request: &str) -> Result<PlanRequest, Faults> {
    match serde_json::from_str(request) {
        Ok(value) => PlanRequest::parse(value),
        Err(error) => {
            let mut faults = Faults::default();
            faults.add("", error.to_string());
            Err(faults)
        }
    }
}

/// A request that an earlier version accepted and this one does not take.
fn rejected(faults: &Faults) -> RunOutcome {
    RunOutcome::Failed {
        code: "invalid".to_owned(),
        message: faults.to_string(),
        details: serde_json::to_value(&faults.0).unwrap_or_default(),
        partial: None,
    }
}

fn reported(progress: plan::Progress) -> Progress {
    let plan::Progress { leg, iteration, evaluations, elapsed_s, best, mean, lower_bound } =
        progress;
    Progress { iteration, evaluations, elapsed_s, best, mean, lower_bound, leg }
}

/// Tells why a run ended from what it left.
fn conclude(
    result: Option<Box<PlanResult>>,
    error: Option<plan::PlanError>,
    context: &RunContext<'_>,
) -> RunOutcome {
    let text = match result.as_deref().map(serde_json::to_string).transpose() {
        Ok(text) => text,
        Err(cause) => return failed("internal", cause.to_string(), None),
    };
    let stopped_by = |reason| {
        let mut plans = result.iter().flat_map(|result| trajectories(result));
        error.is_some() || plans.any(|plan| plan.stop_reason == reason)
    };
    match context.cancel.reason() {
        Some(StopReason::Cancelled) => return RunOutcome::Cancelled { partial: text },
        // A result that was complete before the interruption is kept.
        Some(reason) if stopped_by(reason) => return RunOutcome::Interrupted,
        _ => {}
    }
    let late = context.deadline.is_some_and(|deadline| Instant::now() >= deadline);
    if late && stopped_by(StopReason::TimeLimit) {
        let message = "the job's deadline passed while it was planned".to_owned();
        return failed("deadline_exceeded", message, text);
    }
    match (error, text, result) {
        (Some(plan::PlanError { code, message, details, partial: _ }), partial, _) => {
            RunOutcome::Failed { code: code.to_owned(), message, details, partial }
        }
        (None, Some(text), Some(result)) => {
            let summary = serde_json::to_value(ResultSummary::from(&*result));
            RunOutcome::Succeeded { result: text, summary: summary.unwrap_or_default() }
        }
        _ => failed("internal", "the planner left neither result nor error".to_owned(), None),
    }
}

fn failed(code: &str, message: String, partial: Option<String>) -> RunOutcome {
    RunOutcome::Failed { code: code.to_owned(), message, details: Value::Null, partial }
}
