//! P-RRT*, RRT* in a potential field.
//!
//! Qureshi and Ayaz 2016, doi:10.1007/s10514-015-9518-0. Every sample first moves towards the goal
//! until an obstacle is near. Deviations as for RRT*; step and distance are shares of the range.

use super::entry::{PlannerEntry, RANGE, iterations, range};
use super::potential::{Descent, KEEP_OFF, STEPS, STRIDE};
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::Settings;

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "p_rrt_star",
    title: "P-RRT*",
    description: "RRT* whose samples first move towards the goal until an obstacle is near.",
    source: "Qureshi and Ayaz 2016, doi:10.1007/s10514-015-9518-0",
    anytime: true,
    needs_clearance: true,
    parameters: &[iterations(ITERATIONS), RANGE, GOAL_BIAS, GOAL_REACH, STEPS, STRIDE, KEEP_OFF],
};

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> PRrtStar {
    PRrtStar {
        star: Star::new(settings, problem, 0),
        descent: Descent::new(settings, range(settings, problem)),
    }
}

pub(super) struct PRrtStar {
    star: Star,
    descent: Descent,
}

impl Planner for PRrtStar {
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
