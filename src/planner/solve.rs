//! The one loop around every planner.

use super::entry::PlannerEntry;
use super::tree::GrownTree;
use super::world::World;
use super::{PathEnd, Planner, PlannerError, PlanningProblem, ValidityChecker, distance, registry};
use crate::budget::{Budget, StopReason};
use crate::fault::parameter::Settings;

/// How long the best path was at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthPoint {
    /// Iterations done.
    pub iteration: u64,
    /// Motions checked so far.
    pub checks: u64,
    /// Nodes of all trees.
    pub nodes: usize,
    /// Seconds since the budget was made.
    pub elapsed_s: f64,
    /// Length of the best path; none as long as there is none.
    pub length: Option<f64>,
}

/// What a planner found.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSolution {
    /// States from start to goal, both exact; the motions between are straight
    /// and free. None if no path was found.
    pub path: Option<Vec<Vec<f64>>>,
    /// Its length; infinite if there is none.
    pub length: f64,
    /// Nodes of all trees at the end.
    pub nodes: usize,
    /// Iterations done.
    pub iterations: u64,
    /// Motions checked.
    pub checks: u64,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// Every improvement, thinned to at most [`LengthPoint::MOST`] points.
    pub lengths: Vec<LengthPoint>,
    /// The trees from the start and from the goal.
    pub trees: [GrownTree; 2],
}

impl LengthPoint {
    /// Most points of a curve that are kept.
    pub const MOST: usize = 512;
}

/// Checks and small searches between two looks at the clock and the token, a
/// millisecond's work at most.
const UNWATCHED: u64 = 16;

/// Nodes that end a search before they fill the memory: some hundred megabytes.
const MOST_NODES: usize = 2_000_000;

/// Iterations between two reports if nothing improves.
const SILENCE: u64 = 4096;

/// Finds a path by the planner called by `entry`.
///
/// The straight motion is tried first. An iteration counts as an evaluation of
/// the budget; two million nodes end a search like an evaluation limit.
/// `progress` sees every improvement and signs of life between.
///
/// # Errors
///
/// If an end is outside the box or not free, or if the checker cannot do what
/// the planner needs. That no path was found is a result.
pub fn solve<C: ValidityChecker>(
    entry: &PlannerEntry,
    settings: &Settings,
    problem: &PlanningProblem,
    checker: &mut C,
    seed: u64,
    budget: &Budget,
    progress: &mut dyn FnMut(&LengthPoint),
) -> Result<PathSolution, PlannerError> {
    check(problem, checker)?;
    if entry.needs_clearance && checker.clearance(&problem.start).is_none() {
        return Err(PlannerError::NeedsClearance(entry.name));
    }
    let limits = Limits::new(entry, settings, problem, budget);
    let search = Search { world: World::new(problem, checker, seed), limits, progress };
    Ok(registry::run(entry, settings, search))
}

fn check<C: ValidityChecker>(
    problem: &PlanningProblem,
    checker: &mut C,
) -> Result<(), PlannerError> {
    for (end, state) in [(PathEnd::Start, &problem.start), (PathEnd::Goal, &problem.goal)] {
        assert_eq!(state.len(), problem.dimension(), "the {end} is of another space");
        let ends = problem.lower.iter().zip(&problem.upper);
        for (coordinate, (&value, (&lower, &upper))) in state.iter().zip(ends).enumerate() {
            if !(lower..=upper).contains(&value) {
                return Err(PlannerError::OutOfBounds { end, coordinate, value, lower, upper });
            }
        }
        if !checker.is_state_valid(state) {
            return Err(PlannerError::EndNotFree(end));
        }
    }
    Ok(())
}

/// When to end.
struct Limits {
    budget: Budget,
    iterations: u64,
    /// What ends the search when the path is no longer than this.
    enough: f64,
    /// The straight line.
    least: f64,
}

impl Limits {
    fn new(
        entry: &PlannerEntry,
        settings: &Settings,
        problem: &PlanningProblem,
        budget: &Budget,
    ) -> Self {
        let least = distance(&problem.start, &problem.goal);
        let first = !entry.anytime || settings.flag("first_path");
        let enough = if first { f64::MAX } else { least * (1.0 + settings.get("gap")) };
        let limit = settings.optional("time_limit_s").map(std::time::Duration::from_secs_f64);
        let budget = budget.clone().with_time_limit(limit);
        Self { budget, iterations: settings.integer("iterations"), enough, least }
    }

    /// Why the search should end with a path of this length after so many iterations.
    fn reached(&self, length: f64, iterations: u64) -> Option<StopReason> {
        // Sums over a path along the straight line differ from it by rounding.
        if length <= self.least * (1.0 + 1e-12) {
            return Some(StopReason::Converged);
        }
        if length <= self.enough {
            return Some(StopReason::Solved);
        }
        (iterations >= self.iterations).then_some(StopReason::IterationLimit)
    }
}

/// A problem and when to end, before a planner is chosen.
pub(super) struct Search<'a, C> {
    pub world: World<'a, C>,
    limits: Limits,
    progress: &'a mut dyn FnMut(&LengthPoint),
}

impl<C: ValidityChecker> Search<'_, C> {
    /// Lets a planner search.
    pub fn run<P: Planner>(mut self, mut planner: P) -> PathSolution {
        let (start, goal) = (&self.world.problem.start, &self.world.problem.goal);
        if self.world.is_free(start, goal) {
            planner.roadmap().offer([0, 0], self.limits.least);
        }
        let mut lengths = Vec::new();
        let (mut iterations, mut length, mut told) = (0, f64::INFINITY, 0);
        let left = self.limits.budget.evaluations_left(0);
        let mut watched = 0;
        let stop_reason = loop {
            let now = planner.roadmap().length();
            if now < length || iterations == told + SILENCE {
                told = iterations;
                let point = self.point(iterations, planner.roadmap().nodes(), now);
                (self.progress)(&point);
                if now < length {
                    keep(&mut lengths, point);
                }
                length = now;
            }
            if let Some(reason) = self.limits.reached(length, iterations) {
                break reason;
            }
            if iterations == left || planner.roadmap().nodes() > MOST_NODES {
                break StopReason::EvaluationLimit;
            }
            if iterations + self.world.checks >= watched {
                watched = iterations + self.world.checks + UNWATCHED;
                if let Some(reason) = self.limits.budget.stop_reason(iterations) {
                    break reason;
                }
            }
            planner.step(&mut self.world);
            iterations += 1;
        };
        let roadmap = planner.into_roadmap();
        let (path, nodes) = (roadmap.path(), roadmap.nodes());
        let (checks, trees) = (self.world.checks, roadmap.into_grown());
        PathSolution { path, length, nodes, iterations, checks, stop_reason, lengths, trees }
    }

    fn point(&self, iteration: u64, nodes: usize, length: f64) -> LengthPoint {
        LengthPoint {
            iteration,
            checks: self.world.checks,
            nodes,
            elapsed_s: self.limits.budget.elapsed_s(),
            length: Some(length).filter(|length| length.is_finite()),
        }
    }
}

/// Adds a point to a curve; of a full one every second point goes.
fn keep(lengths: &mut Vec<LengthPoint>, point: LengthPoint) {
    if lengths.len() == LengthPoint::MOST {
        let mut index = 0;
        lengths.retain(|_| {
            index += 1;
            index % 2 == 1
        });
    }
    lengths.push(point);
}
