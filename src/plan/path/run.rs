//! Plans and smooths the path of a point.

use serde_json::{Value, json};

use super::prepare::PreparedPath;
use super::request::Obstacle;
use super::result::{PathResult, TreeEdge};
use super::space::{PointSpace, depth};
use crate::budget::Budget;
use crate::math::random::derive_seed;
use crate::optimize::ConvergencePoint;
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepared::Progress;
use crate::plan::result::PlanResult;
use crate::planner::{
    GrownTree, LengthPoint, PathEnd, PathSolution, PlannerError, ValidityChecker, distance, solve,
};

/// Most motions of trees that are kept.
const MAX_EDGES: usize = 2000;

/// The plan of a valid task.
pub(in crate::plan) fn run(
    task: &PreparedPath,
    seed: u64,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let mut space = PointSpace::new(&task.space);
    let mut report = |point: &LengthPoint| progress(told(point));
    let PreparedPath { planner, settings, problem, .. } = task;
    let solution = solve(planner, settings, problem, &mut space, seed, budget, &mut report)
        .map_err(|error| refused(task, &error))?;
    // The planner's own time limit ends a search, not the job.
    let stopped = budget.stop_reason(0).and_then(PlanError::stopped);
    let Some(path) = solution.path.clone() else {
        return Err(stopped.unwrap_or_else(|| not_found(task, &solution)));
    };
    let result = finish(task, path, solution, &mut space, seed, budget);
    let result = PlanResult::Path(Box::new(result));
    match stopped {
        Some(error) => Err(error.with_partial(result)),
        None => Ok(result),
    }
}

fn finish(
    task: &PreparedPath,
    path: Vec<Vec<f64>>,
    solution: PathSolution,
    space: &mut PointSpace,
    seed: u64,
    budget: &Budget,
) -> PathResult {
    let smoothed =
        task.smoothing.apply(&task.smoothing_settings, space, &path, derive_seed(seed, 1), budget);
    let best = smoothed.as_ref().map_or(&path, |smoothed| &smoothed.path);
    let clearances = best.iter().filter_map(|corner| space.clearance(corner));
    let clearance = clearances.fold(f64::INFINITY, f64::min);
    let convergence = solution.lengths.iter().map(converged).collect();
    let dimension = task.problem.dimension();
    PathResult {
        length: solution.length,
        smoothed_length: smoothed.as_ref().map(|smoothed| smoothed.length),
        curve: smoothed.as_ref().and_then(|smoothed| smoothed.curve.clone()),
        smoothed_path: smoothed.map(|smoothed| smoothed.path),
        path,
        straight_length: distance(&task.problem.start, &task.problem.goal),
        clearance: Some(clearance).filter(|clearance| clearance.is_finite()),
        nodes: solution.nodes,
        iterations: solution.iterations,
        evaluations: solution.checks,
        convergence,
        planner: task.planner.name.to_owned(),
        smoothing: task.smoothing.name.to_owned(),
        stop_reason: solution.stop_reason,
        space: task.space.clone(),
        tree_edges: if task.trees { edges(&solution.trees, dimension) } else { Vec::new() },
        planning_s: budget.elapsed_s(),
        seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

fn told(point: &LengthPoint) -> Progress {
    Progress {
        iteration: point.iteration,
        evaluations: point.checks,
        elapsed_s: point.elapsed_s,
        best: point.length,
        ..Progress::default()
    }
}

fn converged(point: &LengthPoint) -> ConvergencePoint {
    ConvergencePoint {
        iteration: point.iteration,
        evaluations: point.checks,
        elapsed_s: point.elapsed_s,
        best: point.length,
        mean: None,
    }
}

/// Motions of all trees; of many, evenly picked ones.
fn edges(trees: &[GrownTree; 2], dimension: usize) -> Vec<TreeEdge> {
    let count: usize = trees.iter().map(|tree| tree.parents.len() - 1).sum();
    let all = trees.iter().flat_map(|tree| {
        let state = |node: usize| tree.states[node * dimension..][..dimension].to_vec();
        let parents = tree.parents.iter().enumerate().skip(1);
        parents
            .map(move |(node, &parent)| TreeEdge { from: state(parent as usize), to: state(node) })
    });
    all.step_by(count.div_ceil(MAX_EDGES).max(1)).collect()
}

/// An end that lies in an obstacle: in which, and how deep.
fn refused(task: &PreparedPath, error: &PlannerError) -> PlanError {
    let PlannerError::EndNotFree(end) = error else {
        // Validation has seen to everything else.
        let details = json!({});
        return PlanError {
            code: PlanCode::NoPath,
            message: error.to_string(),
            details,
            partial: None,
        };
    };
    let (code, state) = match end {
        PathEnd::Start => (PlanCode::StartInCollision, &task.problem.start),
        PathEnd::Goal => (PlanCode::GoalInCollision, &task.problem.goal),
    };
    let depths = task.space.obstacles.iter().map(|obstacle| depth(obstacle, state));
    let deepest = depths.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((index, depth)) = deepest else {
        return PlanError { code, message: error.to_string(), details: json!({}), partial: None };
    };
    // What is touched is hit as well, and the obstacles are larger by rounding's share.
    let depth = depth.max(0.0);
    let kind = match &task.space.obstacles[index] {
        Obstacle::Ball(_) => "ball",
        Obstacle::Box(_) => "box",
    };
    let message = format!("the {end} lies {depth} deep in obstacle {index}, a {kind}");
    let details = json!({
        "end": end.to_string(), "obstacle": index, "kind": kind, "depth": depth,
        "pointer": format!("/task/space/obstacles/{index}"),
    });
    PlanError { code, message, details, partial: None }
}

/// No path: how far the search came.
fn not_found(task: &PreparedPath, solution: &PathSolution) -> PlanError {
    let dimension = task.problem.dimension();
    let [from_start, from_goal] = &solution.trees;
    let nearest = |tree: &GrownTree, end: &[f64]| -> Value {
        let states = tree.states.chunks_exact(dimension).map(|state| distance(state, end));
        json!(states.fold(f64::INFINITY, f64::min))
    };
    let (iterations, nodes, reason) = (solution.iterations, solution.nodes, solution.stop_reason);
    let message = format!(
        "no path was found by {} in {iterations} iterations ({reason}): there may be none, or only a \
         narrow one; more iterations or another planner may find it",
        task.planner.name
    );
    let details = json!({
        "planner": task.planner.name, "iterations": iterations, "nodes": nodes,
        "stop_reason": reason, "straight_length": distance(&task.problem.start, &task.problem.goal),
        "nearest_to_goal": nearest(from_start, &task.problem.goal),
        "nearest_to_start": nearest(from_goal, &task.problem.start),
    });
    PlanError { code: PlanCode::NoPath, message, details, partial: None }
}
