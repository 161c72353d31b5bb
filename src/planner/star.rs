//! One tree that RRT* and its relatives grow from the start, and how it reaches
//! the goal.

use super::entry::optional;
use super::rewiring::Rewiring;
use super::roadmap::Roadmap;
use super::world::World;
use super::{PlanningProblem, ValidityChecker, distance};
use crate::fault::parameter::{Parameter, Settings, real};

/// One tree from the start that is rewired, and the goal.
pub(super) struct Star {
    pub roadmap: Roadmap,
    pub rewiring: Rewiring,
    /// Probability of aiming at the goal.
    pub goal_bias: f64,
    goal_reach: f64,
    /// Where a sample goes.
    pub target: Vec<f64>,
}

/// `goal_bias`.
pub(super) const GOAL_BIAS: Parameter = real(
    "goal_bias",
    "probability with which the goal itself is the sample; default 0.05",
    0.05,
    0.0,
    1.0,
);

/// `goal_reach`.
pub(super) const GOAL_REACH: Parameter = optional(
    "goal_reach",
    "longest straight motion to the goal that is tried from a new node, in the units of the \
     space; default: any, whereas the sources take the range",
);

/// Samples, unless set: enough for a plane or a space with some tens of obstacles.
pub(super) const ITERATIONS: f64 = 10_000.0;

/// Share of the box's diagonal that one extension covers, unless set.
const RANGE_SHARE: f64 = 0.1;

/// The range of a planner that goes on after its first path.
pub(super) fn range(settings: &Settings, problem: &PlanningProblem) -> f64 {
    settings.optional("range").unwrap_or(RANGE_SHARE * problem.diagonal())
}

impl Star {
    /// With `depth` generations of ancestors taking part.
    pub fn new(settings: &Settings, problem: &PlanningProblem, depth: usize) -> Self {
        Self {
            roadmap: Roadmap::new(problem),
            rewiring: Rewiring::new(problem, range(settings, problem), depth),
            goal_bias: settings.get("goal_bias"),
            goal_reach: settings.optional("goal_reach").unwrap_or(f64::INFINITY),
            target: vec![0.0; problem.dimension()],
        }
    }

    /// Extends the tree towards `target` and tries the goal from the new node.
    pub fn grow<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) -> Option<u32> {
        let limit = self.roadmap.length();
        let goal = &world.problem.goal;
        let tree = &mut self.roadmap.trees[0];
        let node = self.rewiring.extend(world, tree, &self.target, goal, limit)?;
        for &from in self.rewiring.trace(&self.roadmap.trees[0], node) {
            let state = self.roadmap.trees[0].state(from);
            let step = distance(state, goal);
            if step <= self.goal_reach
                && self.roadmap.through([from, 0], step) < self.roadmap.length()
                && world.is_free(state, goal)
            {
                self.roadmap.offer([from, 0], step);
                break;
            }
        }
        Some(node)
    }
}
