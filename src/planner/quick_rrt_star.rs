//! Quick-RRT*.
//!
//! Jeong et al. 2019, doi:10.1016/j.eswa.2019.01.032. RRT* in which ancestors of nodes nearby may be
//! parents, too, so that paths get straight sooner. By the triangle inequality the furthest ancestor
//! is tried first. Deviations as for RRT*.

use super::entry::{PlannerEntry, RANGE, iterations};
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings, integer};

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "quick_rrt_star",
    title: "Quick-RRT*",
    description: "RRT* in which ancestors of nodes nearby may be parents, too: paths get straight sooner.",
    source: "Jeong et al. 2019, doi:10.1016/j.eswa.2019.01.032",
    anytime: true,
    needs_clearance: false,
    parameters: &[iterations(ITERATIONS), RANGE, GOAL_BIAS, GOAL_REACH, DEPTH],
};

/// `depth`.
pub(super) const DEPTH: Parameter = integer(
    "depth",
    "generations of ancestors that may be parents, too; default 2, of the source",
    2.0,
    0.0,
    100.0,
);

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> QuickRrtStar {
    QuickRrtStar { star: Star::new(settings, problem, settings.integer("depth") as usize) }
}

pub(super) struct QuickRrtStar {
    star: Star,
}

impl Planner for QuickRrtStar {
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
