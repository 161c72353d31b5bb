//! RRT*.
//!
//! Karaman and Frazzoli 2011, doi:10.1177/0278364911406761. Every new state takes the parent nearby
//! by which its way is shortest, and becomes the parent of those whose way it shortens; lengths
//! tend to the optimum.
//!
//! Deviations: with a path known, nodes through which none can be shorter are not added; the goal
//! is tried from every new node that promises a shorter path, see `goal_reach`.

use super::entry::{PlannerEntry, RANGE, iterations};
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::Settings;

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "rrt_star",
    title: "RRT*",
    description: "Like RRT, and paths get shorter with every sample: new nodes take the best parent nearby and become parents where that is shorter.",
    source: "Karaman and Frazzoli 2011, doi:10.1177/0278364911406761",
    anytime: true,
    needs_clearance: false,
    parameters: &[iterations(ITERATIONS), RANGE, GOAL_BIAS, GOAL_REACH],
};

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> RrtStar {
    RrtStar { star: Star::new(settings, problem, 0) }
}

pub(super) struct RrtStar {
    star: Star,
}

impl Planner for RrtStar {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let Star { goal_bias, target, .. } = &mut self.star;
        world.sample_or_goal(*goal_bias, target);
        self.star.grow(world);
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.star.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.star.roadmap
    }
}
