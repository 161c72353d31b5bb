//! Plans a motion around obstacles.

use serde_json::json;

use super::checker::FreeMotions;
use super::ends::configurations;
use super::prepare::PreparedMotion;
use super::result::MotionPath;
use super::timing::timed;
use crate::budget::Budget;
use crate::collision::CollisionChecker;
use crate::math::random::derive_seed;
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepared::{LEAST_WAY, PreparedPlan, Progress};
use crate::plan::result::PlanResult;
use crate::planner::{
    LengthPoint, PathEnd, PathSolution, PlanningProblem, ValidityChecker, distance, length,
    shortcut, solve,
};

/// Joints without a position limit may go so far beyond both ends, rad or m.
const BEYOND: f64 = std::f64::consts::PI;

/// So many configurations for the goal's pose are tried.
const GOALS: usize = 8;

/// Iterations of the search for a path with room around it.
const ROOMY_ITERATIONS: u64 = 2000;

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
    let search = Search { plan, task, start, goals, seed, budget, progress };
    if let Some(result) = task.roomy.iter().find_map(|roomy| search.with_room(roomy, &mut free)) {
        return Ok(result);
    }
    let solution = search.path(&search.goals, budget, &mut free)?;
    let planned = solution.path.clone().unwrap_or_default();
    let mut path = planned.clone();
    search.smooth(&mut path, &mut free);
    search.timed(planned, path, &solution, &mut free)
}

/// One task being planned.
struct Search<'a> {
    plan: &'a PreparedPlan,
    task: &'a PreparedMotion,
    start: Vec<f64>,
    goals: Vec<Vec<f64>>,
    seed: u64,
    budget: &'a Budget,
    progress: &'a (dyn Fn(Progress) + Sync),
}

impl Search<'_> {
    /// A motion along a path that is free by `roomy`, if there is one.
    fn with_room(&self, roomy: &CollisionChecker, free: &mut FreeMotions) -> Option<PlanResult> {
        let mut roomy = FreeMotions::new(roomy);
        if !roomy.is_state_valid(&self.start) {
            return None;
        }
        let goals: Vec<_> =
            self.goals.iter().filter(|goal| roomy.is_state_valid(goal)).cloned().collect();
        let budget = self.budget.clone().with_max_evaluations(Some(ROOMY_ITERATIONS));
        let solution = self.path(&goals, &budget, &mut roomy).ok()?;
        let planned = solution.path.clone()?;
        let mut path = planned.clone();
        self.smooth(&mut path, &mut roomy);
        self.timed(planned, path, &solution, free).ok()
    }

    fn smooth(&self, path: &mut Vec<Vec<f64>>, free: &mut FreeMotions) {
        if let Some(attempts) = self.task.shortcuts {
            shortcut(path, free, attempts, derive_seed(self.seed, 1), self.budget);
        }
    }

    fn timed(
        &self,
        planned: Vec<Vec<f64>>,
        path: Vec<Vec<f64>>,
        solution: &PathSolution,
        free: &mut FreeMotions,
    ) -> Result<PlanResult, PlanError> {
        let task = self.task;
        let (mut result, added_waypoints) =
            timed(self.plan, task, &path, self.seed, self.budget, &self.progress, free)?;
        result.motion = Some(MotionPath {
            length: length(&path),
            straight_length: distance(&planned[0], &planned[planned.len() - 1]),
            planned,
            path,
            nodes: solution.nodes,
            iterations: solution.iterations,
            checks: solution.checks,
            planner: task.planner.name.to_owned(),
            smoothing: if task.shortcuts.is_some() { "shortcut" } else { "none" }.to_owned(),
            added_waypoints,
        });
        Ok(PlanResult::Trajectory(Box::new(result)))
    }

    /// A free path from the start to the first of `goals` that one is found to.
    fn path(
        &self,
        goals: &[Vec<f64>],
        budget: &Budget,
        free: &mut FreeMotions,
    ) -> Result<PathSolution, PlanError> {
        let Self { plan, task, start, seed, progress, .. } = self;
        let mut report = |point: &LengthPoint| progress(told(point));
        let mut tried = Vec::new();
        for goal in goals.iter().take(GOALS) {
            let ways = start.iter().zip(goal).map(|(from, to)| (to - from).abs());
            if ways.fold(0.0, f64::max) < LEAST_WAY {
                let message = "start and goal are equal: nothing moves".to_owned();
                return Err(PlanError::unreachable(message, json!({})));
            }
            let problem = problem(plan, start, goal);
            let solved =
                solve(task.planner, &task.settings, &problem, free, *seed, budget, &mut report);
            let solution = solved.map_err(|error| no_path(error.to_string(), json!({})))?;
            if solution.path.is_some() {
                return Ok(solution);
            }
            if let Some(stopped) = self.budget.stop_reason(0).and_then(PlanError::stopped) {
                return Err(stopped);
            }
            tried.push(solution);
        }
        Err(not_found(task, &tried))
    }
}

/// No path: how far the searches came.
fn not_found(task: &PreparedMotion, tried: &[PathSolution]) -> PlanError {
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
    no_path(message, details)
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
