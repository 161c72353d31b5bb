//! Times a path so that the curve stays as free as the path.
//!
//! A curve through the corners of a path leaves the straight motions between them. Where it comes too near to something,
//! the straight motion there is divided, which brings the curve closer to it; the path itself does not change.

use serde_json::json;

use super::checker::FreeMotions;
use super::prepare::PreparedMotion;
use super::travel::{Part, Travelled};
use crate::budget::Budget;
use crate::collision::{ClearanceError, ProvenClearance};
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepare::MAX_WAYPOINTS;
use crate::plan::prepared::{PreparedPlan, Progress};
use crate::plan::result::{PlanResult, TrajectoryResult};
use crate::plan::waypoints;
use crate::trajectory::Clearance;

/// How often what is too near is divided before the timing is given up: a corner's parts are then 256 times shorter.
const ROUNDS: usize = 9;

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
        let motion = Travelled(&result.trajectory);
        let least = task.checker.proven_clearance(&motion, TOLERANCE_M, &mut free.scratch);
        if let Ok(found) = &least
            && found.as_ref().is_none_or(|found| found.proven_m > task.clearance_m)
        {
            result.certificate.clearance = least.ok().flatten().map(|found| Clearance {
                smallest_m: found.proven_m,
                at: found.at,
                pair: found.pair,
            });
            return Ok((result, points.len() - path.len()));
        }
        // From the last on, so that those before keep their numbers.
        let near = too_near(task, &result, free);
        for &segment in near.iter().rev() {
            divide(&mut points, segment);
        }
        if let (true, Err(error)) = (near.is_empty(), least) {
            return Err(unproven(&error, result));
        }
        // What is divided again and again has no room at all, and every round costs twice as much.
        if points.len() > MAX_WAYPOINTS {
            break;
        }
    }
    Err(given_up(path))
}

/// The segments that come nearer to something than allowed.
fn too_near(
    task: &PreparedMotion,
    result: &TrajectoryResult,
    free: &mut FreeMotions,
) -> Vec<usize> {
    let motion = Travelled(&result.trajectory);
    let is_free = |found: Option<ProvenClearance>| {
        found.is_none_or(|found| found.proven_m > task.clearance_m)
    };
    let segments = result.waypoint_times.windows(2).enumerate();
    segments
        .filter(|(_, times)| {
            let part = Part { motion: &motion, start: times[0], end: times[1] };
            let proven = task.checker.proven_clearance(&part, TOLERANCE_M, &mut free.scratch);
            !proven.is_ok_and(is_free)
        })
        .map(|(segment, _)| segment)
        .collect()
}

fn unproven(error: &ClearanceError, result: TrajectoryResult) -> PlanError {
    PlanError {
        code: PlanCode::NotFree,
        message: format!("no clearance can be proven: {error}"),
        details: json!({}),
        partial: Some(Box::new(PlanResult::Trajectory(Box::new(result)))),
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
        message: "a free path was found, but no timing that stays free although what came too near was halved \
                  again and again; ask for less clearance or take jerk_limited"
            .to_owned(),
        details: json!({ "path": path }),
        partial: None,
    }
}
