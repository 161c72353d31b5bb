//! PQ-RRT*, Quick-RRT* in a potential field.
//!
//! Li et al. 2020, doi:10.1016/j.eswa.2020.113425. Samples move as in P-RRT*, parents are chosen as in
//! Quick-RRT*. Deviations as for both.

use super::entry::{PlannerEntry, RANGE, iterations, range};
use super::potential::{Descent, KEEP_OFF, STEPS, STRIDE};
use super::quick_rrt_star::DEPTH;
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::Settings;

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "pq_rrt_star",
    title: "PQ-RRT*",
    description: "Quick-RRT* whose samples first move towards the goal until an obstacle is near.",
    source: "Li et al. 2020, doi:10.1016/j.eswa.2020.113425",
    anytime: true,
    needs_clearance: true,
    parameters: &[
        iterations(ITERATIONS),
        RANGE,
        GOAL_BIAS,
        GOAL_REACH,
        DEPTH,
        STEPS,
        STRIDE,
        KEEP_OFF,
    ],
};

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> PqRrtStar {
    PqRrtStar {
        star: Star::new(settings, problem, settings.integer("depth") as usize),
        descent: Descent::new(settings, range(settings, problem)),
    }
}

pub(super) struct PqRrtStar {
    star: Star,
    descent: Descent,
}

impl Planner for PqRrtStar {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let Star { goal_bias, target, .. } = &mut self.star;
        world.sample_or_goal(*goal_bias, target);
        self.descent.descend(world, &world.problem.goal, target);
        self.star.grow(world);
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.star.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.star.roadmap
    }
}
