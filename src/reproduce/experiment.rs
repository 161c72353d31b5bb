//! What all experiments do: plan a request as anybody's, repeat it with other
//! seeds, and take the peaks of a curve at published times.

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::budget::Budget;
use crate::math::statistics;
use crate::picture::Beside;
use crate::plan::{
    ComparisonResult, PathResult, PlanRequest, PlanResult, TrajectoryResult, scenarios, validate,
};
use crate::robot::catalogue;
use crate::trajectory::interpolation::{Timing, interpolation};
use crate::trajectory::kernel::{JointLanes, KernelLimits};

/// An experiment that could not be run.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ReproduceError(pub(super) String);

/// Plans `request`. The inner error is a search that found nothing lawful.
fn attempt(request: Value) -> Result<Result<PlanResult, String>, ReproduceError> {
    let failed = |error: &dyn std::fmt::Display| ReproduceError(error.to_string());
    let request = PlanRequest::parse(request).map_err(|faults| failed(&faults))?;
    let plan = validate(&request, &catalogue::get).map_err(|faults| failed(&faults))?;
    Ok(plan.run(&Budget::default(), &|_| {}).map_err(|error| error.to_string()))
}

fn trajectory(result: PlanResult) -> Result<TrajectoryResult, ReproduceError> {
    match result {
        PlanResult::Trajectory(result) => Ok(*result),
        _ => Err(ReproduceError("the task has not one trajectory".to_owned())),
    }
}

/// The request of the built-in scenario `name`.
pub(super) fn scenario(name: &str) -> Result<Value, ReproduceError> {
    let missing = || ReproduceError(format!("there is no scenario {name}"));
    Ok(scenarios::get(name).ok_or_else(missing)?.request.clone())
}

/// Plans a request with one trajectory.
pub(super) fn plan(request: &Value) -> Result<TrajectoryResult, ReproduceError> {
    trajectory(attempt(request.clone())?.map_err(ReproduceError)?)
}

/// Runs a comparison or a benchmark.
pub(super) fn compare(request: &Value) -> Result<ComparisonResult, ReproduceError> {
    match attempt(request.clone())?.map_err(ReproduceError)? {
        PlanResult::Comparison(result) => Ok(result),
        _ => Err(ReproduceError("the task compares nothing".to_owned())),
    }
}

/// One path planned with the seeds 0 to `runs`; none where a seed found none.
pub(super) fn paths(request: &Value, runs: u32) -> Result<Vec<Option<PathResult>>, ReproduceError> {
    let run = |seed: u32| {
        let mut request = request.clone();
        request["seed"] = json!(seed);
        match attempt(request)? {
            Ok(PlanResult::Path(result)) => Ok(Some(*result)),
            Ok(_) => Err(ReproduceError("the task plans no path".to_owned())),
            Err(_) => Ok(None),
        }
    };
    (0..runs).into_par_iter().map(run).collect()
}

/// One request planned with several seeds: a result per seed, none where the
/// search found nothing lawful.
pub(super) struct Repeated(Vec<Option<TrajectoryResult>>);

/// Plans a request with the seeds 0 to `runs`.
pub(super) fn repeat(request: &Value, runs: u32) -> Result<Repeated, ReproduceError> {
    let seeded = |seed: u32| {
        let mut request = request.clone();
        request["seed"] = json!(seed);
        attempt(request)?.ok().map(trajectory).transpose()
    };
    (0..runs).into_par_iter().map(seeded).collect::<Result<_, _>>().map(Repeated)
}

impl Repeated {
    /// A figure of every run.
    pub(super) fn sample(&self, figure: impl Fn(&TrajectoryResult) -> Option<f64>) -> Sample {
        Sample::new(self.0.iter().map(|result| result.as_ref().and_then(&figure)))
    }

    /// The whole motions' durations, s.
    pub(super) fn durations(&self) -> Sample {
        self.sample(|result| Some(result.duration))
    }

    /// The durations of the joint at `index` of the robot when planned alone, s.
    pub(super) fn joint(&self, index: usize) -> Sample {
        self.sample(|result| alone(result, index))
    }

    /// By what share each run is shorter than the run of `other` with its seed.
    pub(super) fn savings(&self, other: &Self) -> Sample {
        let pairs = self.0.iter().zip(&other.0);
        Sample::new(
            pairs.map(|(ours, other)| {
                Some(1.0 - ours.as_ref()?.duration / other.as_ref()?.duration)
            }),
        )
    }
}

/// The duration of the joint at `index` of the robot when planned alone, s; none
/// if it does not move.
pub(super) fn alone(result: &TrajectoryResult, index: usize) -> Option<f64> {
    let name = result.joint_names.get(index)?;
    let joints = result.per_joint.as_ref()?;
    joints.iter().find(|joint| joint.joint == *name).map(|joint| joint.duration)
}

/// A joint's duration as a method has it, for a picture.
pub(super) fn in_picture(name: String, published: f64, ours: &Sample, optimum: f64) -> Beside {
    Beside { name, published: Some(published), ours: ours.quartiles(), optimum: Some(optimum) }
}

/// A figure over several runs.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Ascending.
    values: Vec<f64>,
    /// Runs without a result.
    failed: usize,
}

impl Sample {
    /// The figure of every run; none where a run had no result.
    pub(super) fn new(values: impl Iterator<Item = Option<f64>>) -> Self {
        let all: Vec<Option<f64>> = values.collect();
        let mut values: Vec<f64> = all.iter().flatten().copied().collect();
        values.sort_by(f64::total_cmp);
        Self { failed: all.len() - values.len(), values }
    }

    /// The mean; not a number if there is none, which no verdict takes for
    /// agreement.
    pub(super) fn mean(&self) -> f64 {
        statistics::mean(&self.values).unwrap_or(f64::NAN)
    }

    /// Quartiles; none without values.
    pub(super) fn quartiles(&self) -> Option<[f64; 3]> {
        statistics::quartiles(&self.values)
    }

    /// From the least value to the largest.
    pub(super) fn range(&self, decimals: usize) -> String {
        match (self.values.first(), self.values.last()) {
            (Some(least), Some(most)) => format!("{least:.decimals$} to {most:.decimals$}"),
            _ => "nothing".to_owned(),
        }
    }

    /// Mean and quartiles, each times `factor`, and how many runs had no result.
    pub(super) fn shown(&self, factor: f64, decimals: usize) -> String {
        let number = |value: f64| format!("{:.decimals$}", factor * value);
        let failed = match self.failed {
            0 => String::new(),
            failed => format!("; {failed} of {} runs without", failed + self.values.len()),
        };
        match self.quartiles() {
            Some([lower, _, upper]) => {
                format!("{} ({} to {}{failed})", number(self.mean()), number(lower), number(upper))
            }
            None => "no run found any".to_owned(),
        }
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

/// Times as printed, each longer by `half`, half of the last digit printed: what
/// exceeds a limit even so does not exceed it by rounding.
pub(super) fn rounded_up<const N: usize>(times: &[f64; N], half: f64) -> [f64; N] {
    times.map(|time| time + half)
}

/// A peak this far above its limit exceeds it, whatever the last digits.
pub(super) const EXCESS: f64 = 1.001;

/// The exact peaks of one joint.
pub(super) fn peaks_alone(
    family: &str,
    waypoints: &[Vec<f64>],
    joint: usize,
    durations: &[f64],
) -> Result<[f64; 3], ReproduceError> {
    let column: Vec<Vec<f64>> =
        waypoints.iter().map(|row| row.get(joint).copied().into_iter().collect()).collect();
    Ok(peaks(family, &column, durations)?.first().copied().unwrap_or_default())
}

/// The largest of all joints' peaks of the `order`-th derivative, from 0 for velocity.
pub(super) fn largest(peaks: &[[f64; 3]], order: usize) -> f64 {
    peaks.iter().map(|peak| peak[order]).fold(0.0, f64::max)
}

/// A number in words that also say where no run had a result.
pub(super) fn number(value: f64, decimals: usize) -> String {
    if value.is_nan() { "none".to_owned() } else { format!("{value:.decimals$}") }
}

/// How far `ours` is from `published`, in words.
pub(super) fn difference(published: f64, ours: f64) -> String {
    let percent = 100.0 * (ours / published - 1.0);
    match percent {
        percent if percent.is_nan() => "no run has a result".to_owned(),
        percent if percent.abs() < 0.005 => "ours is the same".to_owned(),
        percent if percent < 0.0 => format!("ours is {:.2} % shorter", -percent),
        percent => format!("ours is {percent:.2} % longer"),
    }
}
