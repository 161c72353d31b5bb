//! Improved Bi-APF-RRT*: RRT* from both ends in an artificial potential field.
//!
//! Zhang et al. 2023, doi:10.3390/act12120459, compare with a method of this name without describing
//! it. This one is built from public relatives: doi:10.3390/s23021041 and Tahir et al. 2018,
//! doi:10.1016/j.robot.2018.06.013. How near it is to theirs is unknown.
//!
//! A tree grows from its node nearest to the sample, in the direction of a sum: towards the sample,
//! towards the other root, and away from obstacles nearer than `influence`, by
//! `(1/d - 1/influence) / d²` made to be one at a quarter of it and never more. If that is blocked,
//! it grows towards the sample alone.

use super::both_ends::{BothEnds, REACH};
use super::entry::{PlannerEntry, RANGE, iterations, optional, range};
use super::potential::{away_from_obstacles, normalise};
use super::roadmap::Roadmap;
use super::star::ITERATIONS;
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings, real};

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "bi_apf_rrt_star",
    title: "Improved Bi-APF-RRT*",
    description: "RRT* from both ends whose extensions are pulled to the other end and pushed off \
                  obstacles. Only named in its source, so how near it is to that is unknown.",
    source: "named by Zhang et al. 2023, doi:10.3390/act12120459; built from doi:10.3390/s23021041 \
             and Tahir et al. 2018, doi:10.1016/j.robot.2018.06.013",
    anytime: true,
    needs_clearance: true,
    parameters: &[iterations(ITERATIONS), RANGE, REACH, BIAS, ATTRACTION, INFLUENCE],
};

const BIAS: Parameter = real(
    "bias",
    "probability with which the other tree's newest node is the sample; default 0.3",
    0.3,
    0.0,
    1.0,
);

const ATTRACTION: Parameter = real(
    "attraction",
    "weight of the pull towards the other end beside that of the sample; default 0.5",
    0.5,
    0.0,
    100.0,
);

const INFLUENCE: Parameter = optional(
    "influence",
    "obstacles nearer than this push, in the units of the space; default: three times the range",
);

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> BiApfRrtStar {
    let range = range(settings, problem);
    let zero = || vec![0.0; problem.dimension()];
    BiApfRrtStar {
        both: BothEnds::new(settings, problem, range, 0),
        range,
        bias: settings.get("bias"),
        attraction: settings.get("attraction"),
        influence: settings.optional("influence").unwrap_or(3.0 * range),
        side: 0,
        sample: zero(),
        target: zero(),
        pull: zero(),
        push: zero(),
    }
}

pub(super) struct BiApfRrtStar {
    both: BothEnds,
    range: f64,
    bias: f64,
    attraction: f64,
    influence: f64,
    /// The tree that is extended next.
    side: usize,
    sample: Vec<f64>,
    target: Vec<f64>,
    pull: Vec<f64>,
    push: Vec<f64>,
}

impl Planner for BiApfRrtStar {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let side = self.side;
        self.side = 1 - side;
        if world.random.unit() < self.bias {
            let other = &self.both.roadmap.trees[1 - side];
            self.sample.copy_from_slice(other.state(other.newest()));
        } else {
            world.sample(&mut self.sample);
        }
        self.guide(world, side);
        let mut node = self.both.grow(world, side, &self.target);
        if node.is_none() {
            node = self.both.grow(world, side, &self.sample);
        }
        if let Some(node) = node {
            self.both.connect(world, side, node);
        }
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.both.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.both.roadmap
    }
}

impl BiApfRrtStar {
    /// Writes where the field leads from the node nearest to the sample.
    fn guide<C: ValidityChecker>(&mut self, world: &mut World<'_, C>, side: usize) {
        let PlanningProblem { lower, upper, start, goal } = world.problem;
        let tree = &mut self.both.roadmap.trees[side];
        let (nearest, _) = tree.nearest(&self.sample);
        let from = tree.state(nearest);
        let other_root = if side == 0 { goal } else { start };
        let strength = repulsion(world.clearance(from), self.influence);
        if strength > 0.0 {
            let reach = 1e-3 * self.range;
            away_from_obstacles(world, from, reach, &mut self.target, &mut self.push);
        }
        towards(from, other_root, &mut self.pull);
        towards(from, &self.sample, &mut self.target);
        for (x, (pull, push)) in self.target.iter_mut().zip(self.pull.iter().zip(&self.push)) {
            *x += self.attraction * pull;
            if strength > 0.0 {
                *x += strength * push;
            }
        }
        normalise(&mut self.target);
        let ends = lower.iter().zip(upper);
        for ((x, from), (&lower, &upper)) in self.target.iter_mut().zip(from).zip(ends) {
            *x = (from + self.range * *x).max(lower).min(upper);
        }
    }
}

/// How strongly an obstacle at a distance pushes, at most 1.
fn repulsion(distance: f64, influence: f64) -> f64 {
    if distance >= influence {
        return 0.0;
    }
    let force = |distance: f64| (1.0 / distance - 1.0 / influence) / (distance * distance);
    let quarter = 0.25 * influence;
    force(distance.max(quarter)) / force(quarter)
}

/// Writes the direction from one state to another, of length one.
fn towards(from: &[f64], to: &[f64], direction: &mut [f64]) {
    for (x, (from, to)) in direction.iter_mut().zip(from.iter().zip(to)) {
        *x = to - from;
    }
    normalise(direction);
}
