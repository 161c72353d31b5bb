//! Times a path so that the curve stays as free as the path.
//!
//! A curve through the corners of a path leaves the straight motions between them. Where it comes too near to something,
//! the straight motion there is divided, which brings the curve closer to it; the path itself does not change.

use serde_json::json;

use super::checker::FreeMotions;
use super::prepare::PreparedMotion;
use super::travel::Travelled;
use crate::budget::Budget;
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepared::{PreparedPlan, Progress};
use crate::plan::result::{PlanResult, TrajectoryResult};
use crate::plan::waypoints;
use crate::trajectory::Clearance;

/// How often the path is divided before the timing is given up.
const ROUNDS: usize = 60;

/// To what the smallest clearance is proven, m.
const TOLERANCE_M: f64 = 5e-4;

/// The timed path, its certificate with its clearance, and how many points were added.
pub fn timed(
    plan: &PreparedPlan,
    task: &PreparedMotion,
    path: &[Vec<f64>],
    seed: u64,
    budget: &Budget,
    progress: &dyn Fn(Progress),
    free: &mut FreeMotions,
) -> Result<(TrajectoryResult, usize), PlanError> {
    let mut points = path.to_vec();
    for _ in 0..ROUNDS {
        let timing = task.timing.through(points.clone());
        let mut result = waypoints::plan(plan, &timing, seed, budget, progress)?;
        let clearance = clearance(task, &result, free)?;
        let near = clearance.as_ref().filter(|clearance| clearance.smallest_m <= task.clearance_m);
        let Some(near) = near else {
            result.certificate.clearance = clearance;
            return Ok((result, points.len() - path.len()));
        };
        let last = points.len() - 2;
        let segment = result.waypoint_times.partition_point(|time| *time <= near.at) - 1;
        divide(&mut points, segment.min(last));
    }
    Err(given_up(path))
}

/// The proven clearance of a trajectory; none if there is nothing to keep away from.
fn clearance(
    task: &PreparedMotion,
    result: &TrajectoryResult,
    free: &mut FreeMotions,
) -> Result<Option<Clearance>, PlanError> {
    let motion = Travelled(&result.trajectory);
    let proven = task.checker.proven_clearance(&motion, TOLERANCE_M, &mut free.scratch);
    match proven {
        Ok(found) => Ok(found.map(|found| {
            let smallest_m = if found.smallest_m > 0.0 { found.proven_m } else { found.smallest_m };
            Clearance { smallest_m, at: found.at, pair: found.pair }
        })),
        Err(error) => {
            let message = format!("no clearance can be proven: {error}");
            let partial = Some(Box::new(PlanResult::Trajectory(Box::new(result.clone()))));
            Err(PlanError { code: PlanCode::NotFree, message, details: json!({}), partial })
        }
    }
}

fn divide(points: &mut Vec<Vec<f64>>, segment: usize) {
    let ends = points[segment].iter().zip(&points[segment + 1]);
    let middle = ends.map(|(from, to)| 0.5 * (from + to)).collect();
    points.insert(segment + 1, middle);
}

fn given_up(path: &[Vec<f64>]) -> PlanError {
    PlanError {
        code: PlanCode::NotFree,
        message: format!(
            "a free path was found, but no timing that stays free after {ROUNDS} divisions of it; ask for less \
             clearance or take jerk_limited"
        ),
        details: json!({ "path": path }),
        partial: None,
    }
}
