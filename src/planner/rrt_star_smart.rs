//! RRT*-Smart.
//!
//! Islam et al. 2012, doi:10.1109/ICMA.2012.6284384; Nasir et al. 2013, doi:10.5772/56718. Once a path is
//! known, every node of it is joined with the furthest ancestor in sight; what remains are beacons,
//! around which some of the samples are drawn. A shorter path has new beacons.
//!
//! Deviations as for RRT*.

use super::entry::{PlannerEntry, RANGE, iterations, optional, range};
use super::informed::draw_from_ball;
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings, integer};

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "rrt_star_smart",
    title: "RRT*-Smart",
    description: "RRT* that straightens its path and then samples around the corners that remain.",
    source: "Islam et al. 2012, doi:10.1109/ICMA.2012.6284384; Nasir et al. 2013, doi:10.5772/56718",
    anytime: true,
    needs_clearance: false,
    parameters: &[
        iterations(ITERATIONS),
        RANGE,
        GOAL_BIAS,
        GOAL_REACH,
        BEACON_EVERY,
        BEACON_RADIUS,
    ],
};

const BEACON_EVERY: Parameter = integer(
    "beacon_every",
    "one sample in this many is drawn around a corner of the path; default 2",
    2.0,
    1.0,
    1e6,
);

const BEACON_RADIUS: Parameter = optional(
    "beacon_radius",
    "radius of the ball around a corner, in the units of the space; default: twice the range",
);

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> RrtStarSmart {
    RrtStarSmart {
        star: Star::new(settings, problem, 0),
        every: settings.integer("beacon_every"),
        radius: settings.optional("beacon_radius").unwrap_or(2.0 * range(settings, problem)),
        count: 0,
        beacons: Vec::new(),
        straightened: f64::INFINITY,
    }
}

pub(super) struct RrtStarSmart {
    star: Star,
    every: u64,
    radius: f64,
    /// Iterations done.
    count: u64,
    /// Corners of the path, one behind the other.
    beacons: Vec<f64>,
    /// Length of the path that they are of.
    straightened: f64,
}

impl Planner for RrtStarSmart {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let length = self.star.roadmap.length();
        if length < self.straightened {
            self.place_beacons(world);
        }
        self.count += 1;
        if self.beacons.is_empty() || !self.count.is_multiple_of(self.every) {
            let Star { goal_bias, target, .. } = &mut self.star;
            world.sample_or_goal(*goal_bias, target);
        } else {
            self.sample_near_beacon(world);
        }
        self.star.grow(world);
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.star.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.star.roadmap
    }
}

impl RrtStarSmart {
    fn place_beacons<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        self.star.straighten(world);
        self.straightened = self.star.roadmap.length();
        self.beacons.clear();
        let Some([end, _]) = self.star.roadmap.join() else { return };
        let tree = &self.star.roadmap.trees[0];
        let inner = std::iter::once(end).chain(tree.ancestors(end)).filter(|&node| node != 0);
        inner.for_each(|node| self.beacons.extend_from_slice(tree.state(node)));
    }

    fn sample_near_beacon<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let target = &mut self.star.target;
        let count = self.beacons.len() / target.len();
        let beacon = (world.random.unit() * count as f64) as usize;
        let beacon = &self.beacons[beacon * target.len()..][..target.len()];
        draw_from_ball(&mut world.random, target);
        let ends = world.problem.lower.iter().zip(&world.problem.upper);
        for ((x, beacon), (&lower, &upper)) in target.iter_mut().zip(beacon).zip(ends) {
            *x = (beacon + self.radius * *x).max(lower).min(upper);
        }
    }
}
