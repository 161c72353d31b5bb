//! IPQ-RRT*-connect: PQ-RRT* from both ends, with greedy targets.
//!
//! Zhang et al. 2023, doi:10.3390/act12120459, who describe it in words; algorithms and constants
//! are missing from the text that could be had. Readings:
//!
//! - Greedy targets: where the newest node of a tree is far from obstacles, the other tree's root;
//!   else the other tree's newest node.
//! - As printed, both are determined, so a tree can repeat the same blocked extension for ever: on
//!   two maps it never ended. With probability `exploration` the target is a random free state.
//! - Samples move towards the other tree's root, as in P-RRT*.
//! - Trees are joined by the cheapest free motion of at most `connection_reach`.
//! - The paper speaks of a priority queue; the Q of PQ-RRT* is Quick.

use super::both_ends::{BothEnds, REACH};
use super::entry::{PlannerEntry, RANGE, iterations, optional, range};
use super::potential::{Descent, KEEP_OFF, STEPS, STRIDE};
use super::quick_rrt_star::DEPTH;
use super::roadmap::Roadmap;
use super::star::ITERATIONS;
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings, real};

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "ipq_rrt_star_connect",
    title: "IPQ-RRT*-connect",
    description: "PQ-RRT* from both ends: trees grow straight at each other where space is open, \
                  and at random, otherwise. An iteration extends both.",
    source: "Zhang et al. 2023, doi:10.3390/act12120459; reconstructed from words",
    anytime: true,
    needs_clearance: true,
    parameters: &[
        iterations(ITERATIONS),
        RANGE,
        REACH,
        DEPTH,
        STEPS,
        STRIDE,
        KEEP_OFF,
        EXPLORATION,
        OPEN_SPACE,
    ],
};

const EXPLORATION: Parameter = real(
    "exploration",
    "probability of a random target; default 0.5. At 0 a tree may repeat the same blocked \
     extension for ever",
    0.5,
    0.0,
    1.0,
);

const OPEN_SPACE: Parameter = optional(
    "open_space",
    "further from obstacles than this a tree grows straight at the other's root, in the units of \
     the space; default: one and a half times the range",
);

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> IpqRrtStarConnect {
    let range = range(settings, problem);
    IpqRrtStarConnect {
        both: BothEnds::new(settings, problem, range, settings.integer("depth") as usize),
        descent: Descent::new(settings, range),
        exploration: settings.get("exploration"),
        open_space: settings.optional("open_space").unwrap_or(1.5 * range),
        target: vec![0.0; problem.dimension()],
    }
}

pub(super) struct IpqRrtStarConnect {
    both: BothEnds,
    descent: Descent,
    exploration: f64,
    open_space: f64,
    target: Vec<f64>,
}

impl Planner for IpqRrtStarConnect {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        for side in [0, 1] {
            self.choose_target(world, side);
            let PlanningProblem { start, goal, .. } = world.problem;
            let attractor = if side == 0 { goal } else { start };
            self.descent.descend(world, attractor, &mut self.target);
            if let Some(node) = self.both.grow(world, side, &self.target) {
                self.both.connect(world, side, node);
            }
        }
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.both.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.both.roadmap
    }
}

impl IpqRrtStarConnect {
    fn choose_target<C: ValidityChecker>(&mut self, world: &mut World<'_, C>, side: usize) {
        if world.random.unit() < self.exploration {
            world.sample_free(&mut self.target);
            return;
        }
        let [own, other] = [side, 1 - side].map(|side| &self.both.roadmap.trees[side]);
        let is_open = world.clearance(own.state(own.newest())) > self.open_space;
        let node = if is_open { 0 } else { other.newest() };
        self.target.copy_from_slice(other.state(node));
    }
}
