//! What all experiments do: plan a request as anybody's, repeat it with other
//! seeds, and take the peaks of a curve at published times.

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::budget::Budget;
use crate::math::statistics;
use crate::plan::{ComparisonResult, PlanRequest, PlanResult, TrajectoryResult, validate};
use crate::robot::catalogue;
use crate::trajectory::interpolation::{Timing, interpolation};
use crate::trajectory::kernel::{JointLanes, KernelLimits};

/// An experiment that could not be run.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ReproduceError(pub(super) String);

fn run(request: Value) -> Result<PlanResult, ReproduceError> {
    let failed = |error: &dyn std::fmt::Display| ReproduceError(error.to_string());
    let request = PlanRequest::parse(request).map_err(|faults| failed(&faults))?;
    let plan = validate(&request, &catalogue::get).map_err(|faults| failed(&faults))?;
    plan.run(&Budget::default(), &|_| {}).map_err(|error| failed(&error))
}

/// Plans a request with one trajectory.
pub(super) fn plan(request: Value) -> Result<TrajectoryResult, ReproduceError> {
    match run(request)? {
        PlanResult::Trajectory(result) => Ok(*result),
        _ => Err(ReproduceError("the task has not one trajectory".to_owned())),
    }
}

/// Plans a request with the seeds 0 to `runs`.
pub(super) fn repeat(request: &Value, runs: u32) -> Result<Vec<TrajectoryResult>, ReproduceError> {
    let seeded = |seed: u32| {
        let mut request = request.clone();
        request["seed"] = json!(seed);
        plan(request)
    };
    (0..runs).into_par_iter().map(seeded).collect()
}

/// Runs a benchmark.
pub(super) fn benchmark(task: Value) -> Result<ComparisonResult, ReproduceError> {
    match run(json!({ "task": task }))? {
        PlanResult::Comparison(result) => Ok(result),
        _ => Err(ReproduceError("the task is no benchmark".to_owned())),
    }
}

/// The exact peaks of `waypoints[waypoint][joint]` at these durations: per
/// joint, velocity, acceleration and jerk.
pub(super) fn peaks(
    family: &str,
    waypoints: &[Vec<f64>],
    durations: &[f64],
) -> Result<Vec<[f64; 3]>, ReproduceError> {
    let dof = waypoints.first().map_or(0, Vec::len);
    let Some(Timing::Search(kernel)) = interpolation(family).map(|it| &it.timing) else {
        return Err(ReproduceError(format!("{family} has no durations to choose")));
    };
    let unit = KernelLimits { derivatives: [1.0; 3], position: [f64::NEG_INFINITY, f64::INFINITY] };
    let joints = JointLanes::new(waypoints, &vec![unit; dof]);
    let mut work = kernel.workspace(&joints);
    kernel.ratios(&joints, durations, &mut work);
    let peak = |joint: usize, order: usize| {
        let ratio = |segment: usize| work.ratio(&joints, segment, joint, order);
        (0..joints.segments()).map(ratio).fold(0.0, f64::max)
    };
    Ok((0..dof).map(|joint| [0, 1, 2].map(|order| peak(joint, order))).collect())
}

/// One joint's column of waypoints.
pub(super) fn joint(waypoints: &[Vec<f64>], joint: usize) -> Vec<Vec<f64>> {
    waypoints.iter().map(|row| row.get(joint).copied().into_iter().collect()).collect()
}

/// The mean of `values`; not a number if there are none, which no verdict takes
/// for agreement.
pub(super) fn mean(values: &[f64]) -> f64 {
    statistics::mean(values).unwrap_or(f64::NAN)
}
