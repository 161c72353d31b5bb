//! Plans a motion around obstacles.

use serde_json::json;

use super::checker::FreeMotions;
use super::ends::configurations;
use super::prepare::PreparedMotion;
use super::result::MotionPath;
use super::timing::timed;
use crate::budget::Budget;
use crate::math::random::derive_seed;
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepared::{LEAST_WAY, PreparedPlan, Progress};
use crate::plan::result::PlanResult;
use crate::planner::{
    LengthPoint, PathEnd, PathSolution, PlanningProblem, distance, length, shortcut, solve,
};

/// Joints without a position limit may go so far beyond both ends, rad or m.
const BEYOND: f64 = std::f64::consts::PI;

/// So many configurations for the goal's pose are tried.
const GOALS: usize = 8;

/// The plan of a valid task.
pub(in crate::plan) fn run(
    plan: &PreparedPlan,
    task: &PreparedMotion,
    seed: u64,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let mut free = FreeMotions::new(&task.checker);
    let home = task.robot.inverse().map_or_else(|| vec![0.0; task.robot.dof()], |it| it.home());
    let start = configurations(task, PathEnd::Start, &home, &mut free)?.swap_remove(0);
    let goals = configurations(task, PathEnd::Goal, &start, &mut free)?;
    let solution = path(plan, task, &start, &goals, seed, budget, progress, &mut free)?;
    let planned = solution.path.clone().unwrap_or_default();
    let mut smooth = planned.clone();
    if let Some(attempts) = task.shortcuts {
        shortcut(&mut smooth, &mut free, attempts, derive_seed(seed, 1), budget);
    }
    let (mut result, added_waypoints) =
        timed(plan, task, &smooth, seed, budget, progress, &mut free)?;
    result.motion = Some(MotionPath {
        length: length(&smooth),
        straight_length: distance(&planned[0], &planned[planned.len() - 1]),
        planned,
        path: smooth,
        nodes: solution.nodes,
        iterations: solution.iterations,
        checks: solution.checks,
        planner: task.planner.name.to_owned(),
        smoothing: if task.shortcuts.is_some() { "shortcut" } else { "none" }.to_owned(),
        added_waypoints,
    });
    Ok(PlanResult::Trajectory(Box::new(result)))
}

/// A free path from `start` to the first of `goals` that one is found to.
#[expect(clippy::too_many_arguments, reason = "what a search needs")]
fn path(
    plan: &PreparedPlan,
    task: &PreparedMotion,
    start: &[f64],
    goals: &[Vec<f64>],
    seed: u64,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
    free: &mut FreeMotions,
) -> Result<PathSolution, PlanError> {
    let mut report = |point: &LengthPoint| progress(told(point));
    let mut tried = Vec::new();
    for goal in goals.iter().take(GOALS) {
        let way = start.iter().zip(goal).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max);
        if way < LEAST_WAY {
            return Err(PlanError::unreachable(
                "start and goal are equal: nothing moves".to_owned(),
                json!({}),
            ));
        }
        let problem = problem(plan, start, goal);
        let solved = solve(task.planner, &task.settings, &problem, free, seed, budget, &mut report);
        let solution = solved.map_err(|error| no_path(error.to_string(), json!({})))?;
        if solution.path.is_some() {
            return Ok(solution);
        }
        if let Some(stopped) = budget.stop_reason(0).and_then(PlanError::stopped) {
            return Err(stopped);
        }
        tried.push(solution);
    }
    let iterations: u64 = tried.iter().map(|solution| solution.iterations).sum();
    let nodes: usize = tried.iter().map(|solution| solution.nodes).sum();
    let message = format!(
        "no path was found by {} in {iterations} iterations to {} configurations of the goal: there may be none, \
         or only a narrow one; more iterations or another planner may find it",
        task.planner.name,
        tried.len()
    );
    let details = json!({
        "planner": task.planner.name, "iterations": iterations, "nodes": nodes, "goals": tried.len(),
        "stop_reason": tried.last().map(|solution| solution.stop_reason),
    });
    Err(no_path(message, details))
}

fn no_path(message: String, details: serde_json::Value) -> PlanError {
    PlanError { code: PlanCode::NoPath, message, details, partial: None }
}

/// The box of the position limits.
fn problem(plan: &PreparedPlan, start: &[f64], goal: &[f64]) -> PlanningProblem {
    let ends = |joint: usize| [start[joint].min(goal[joint]), start[joint].max(goal[joint])];
    let lower = plan.limits.iter().enumerate().map(|(joint, limit)| {
        limit.lower.as_ref().map_or(ends(joint)[0] - BEYOND, |limit| limit.value)
    });
    let upper = plan.limits.iter().enumerate().map(|(joint, limit)| {
        limit.upper.as_ref().map_or(ends(joint)[1] + BEYOND, |limit| limit.value)
    });
    PlanningProblem {
        lower: lower.collect(),
        upper: upper.collect(),
        start: start.to_vec(),
        goal: goal.to_vec(),
    }
}

fn told(point: &LengthPoint) -> Progress {
    Progress {
        iteration: point.iteration,
        evaluations: point.checks,
        elapsed_s: point.elapsed_s,
        ..Progress::default()
    }
}
