//! Rapidly-exploring random tree (RRT).
//!
//! LaValle 1998, TR 98-11. One tree grows from the start towards random states.
//!
//! Deviation: the goal is met exactly, by a motion no longer than the range from
//! a new node, so no tolerance is needed.

use super::entry::{PlannerEntry, RANGE, iterations, range};
use super::rewiring::steer;
use super::roadmap::Roadmap;
use super::star::GOAL_BIAS;
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker, distance};
use crate::fault::parameter::Settings;

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "rrt",
    title: "RRT",
    description: "One tree grows from the start towards random states until it reaches the goal. \
                  A first path, not a short one.",
    source: "LaValle 1998, TR 98-11",
    anytime: false,
    needs_clearance: false,
    parameters: &[iterations(100_000.0), RANGE, GOAL_BIAS],
};

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> Rrt {
    Rrt {
        roadmap: Roadmap::new(problem),
        range: range(settings, problem),
        goal_bias: settings.get("goal_bias"),
        target: vec![0.0; problem.dimension()],
        state: vec![0.0; problem.dimension()],
    }
}

pub(super) struct Rrt {
    roadmap: Roadmap,
    range: f64,
    goal_bias: f64,
    target: Vec<f64>,
    state: Vec<f64>,
}

impl Planner for Rrt {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        world.sample_or_goal(self.goal_bias, &mut self.target);
        let tree = &mut self.roadmap.trees[0];
        let (nearest, squared) = tree.nearest(&self.target);
        let from = tree.state(nearest);
        let step = steer(from, &self.target, squared.sqrt(), self.range, &mut self.state);
        let Some(step) = step else { return };
        if !world.is_free(from, &self.state) {
            return;
        }
        let node = tree.add(&self.state, nearest, step);
        let goal = &world.problem.goal;
        let left = distance(&self.state, goal);
        if left <= self.range && world.is_free(&self.state, goal) {
            self.roadmap.offer([node, 0], left);
        }
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.roadmap
    }
}
