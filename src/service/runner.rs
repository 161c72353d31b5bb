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
    /// Total duration, s, of a family that of its slowest member; null of a path
    /// and where methods were compared.
    pub duration: Option<f64>,
    /// True if the certificate of every leg or planned member is lawful; null of a path and where methods were compared.
    pub lawful: Option<bool>,
    /// The worst ratio of a peak to its limit; null of a path and where methods were compared.
    pub worst_ratio: Option<f64>,
    /// No lawful trajectory is shorter, s; null if not proven.
    pub lower_bound: Option<f64>,
    /// Number of legs; members of a family; problems where methods were compared; else 1.
    pub legs: usize,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Planning time, s.
    pub planning_s: f64,
    /// The result in words, of a path, a family and where methods were compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
}

impl From<&PlanResult> for ResultSummary {
    fn from(result: &PlanResult) -> Self {
        let bound = |result: &TrajectoryResult| result.bound.as_ref().map(|bound| bound.lower);
        match result {
            PlanResult::Trajectory(result) => Self {
                duration: Some(result.duration),
                lawful: Some(result.certificate.lawful),
                worst_ratio: Some(result.certificate.worst_ratio),
                lower_bound: bound(result),
                legs: 1,
                evaluations: result.evaluations,
                planning_s: result.planning_s,
                verdict: None,
            },
            PlanResult::Program(program) => Self {
                duration: Some(program.duration),
                lawful: Some(program.lawful),
                worst_ratio: Some(program.worst_ratio),
                lower_bound: program.legs.iter().map(|leg| bound(&leg.result)).sum(),
                legs: program.legs.len(),
                evaluations: program.evaluations,
                planning_s: program.planning_s,
                verdict: None,
            },
            PlanResult::Path(path) => Self {
                duration: None,
                lawful: None,
                worst_ratio: None,
                lower_bound: None,
                legs: 1,
                evaluations: path.evaluations,
                planning_s: path.planning_s,
                verdict: Some(path.verdict()),
            },
            PlanResult::Family(family) => Self {
                duration: Some(family.worst_case.duration),
                lawful: Some(family.lawful),
                worst_ratio: Some(family.worst_ratio),
                lower_bound: bound(&family.worst_case),
                legs: family.members.len(),
                evaluations: family.evaluations,
                planning_s: family.planning_s,
                verdict: Some(family.verdict.clone()),
            },
            PlanResult::Comparison(comparison) => Self {
                duration: None,
                lawful: None,
                worst_ratio: None,
                lower_bound: None,
                legs: comparison.problems.len(),
                evaluations: comparison.evaluations,
                planning_s: comparison.planning_s,
                verdict: Some(comparison.verdict.clone()),
            },
        }
    }
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
        PlanCode::LimitsUnreachable
        | PlanCode::IkNoSolution
        | PlanCode::NotFree
        | PlanCode::NoPath
        | PlanCode::StartInCollision
        | PlanCode::GoalInCollision
        | PlanCode::DeadlineExceeded => {
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
