//! What a worker runs: from a stored request to a stored result.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::budget::Budget;
use crate::fault::Faults;
use crate::job::{RunContext, RunOutcome, Runner};
use crate::plan::{self, PlanCode, PlanError, PlanRequest, PlanResult, TrajectoryResult};

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
fn trajectories(result: &PlanResult) -> impl Iterator<Item = &TrajectoryResult> {
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
        match prepared.run(&budget, context.progress) {
            Ok(result) => succeeded(&result),
            Err(error) => ended(error),
        }
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

fn succeeded(result: &PlanResult) -> RunOutcome {
    let summary = serde_json::to_value(ResultSummary::from(result));
    match (serde_json::to_string(result), summary) {
        (Ok(result), Ok(summary)) => RunOutcome::Succeeded { result, summary },
        (Err(cause), _) | (_, Err(cause)) => unwritable(&cause),
    }
}

/// What a plan without a complete result means for its job.
fn ended(error: PlanError) -> RunOutcome {
    let PlanError { code, message, details, partial } = error;
    let partial = match partial.map(|partial| serde_json::to_string(&partial)).transpose() {
        Ok(partial) => partial,
        Err(cause) => return unwritable(&cause),
    };
    match code {
        PlanCode::Cancelled => RunOutcome::Cancelled { partial },
        PlanCode::Interrupted => RunOutcome::Interrupted,
        PlanCode::LimitsUnreachable | PlanCode::DeadlineExceeded => {
            RunOutcome::Failed { code: code.as_str().to_owned(), message, details, partial }
        }
    }
}

fn unwritable(cause: &serde_json::Error) -> RunOutcome {
    RunOutcome::Failed {
        code: "internal".to_owned(),
        message: format!("the result cannot be written: {cause}"),
        details: Value::Null,
        partial: None,
    }
}
