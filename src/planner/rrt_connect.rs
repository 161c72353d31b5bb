//! RRT-Connect.
//!
//! Kuffner and LaValle 2000, doi:10.1109/ROBOT.2000.844730. Trees from both ends take turns: one
//! is extended towards a random state, the other goes on towards the new node until something is
//! in the way.
//!
//! Deviations: a long way to the other tree takes several iterations, so that whoever cancels need not
//! wait; samples are of a sequence that fills the box evenly, with a random start. On three maps
//! of a plane that saves a tenth to two fifths of all checks beside uniform random samples.

use super::entry::{PlannerEntry, RANGE, iterations, range};
use super::rewiring::steer;
use super::roadmap::Roadmap;
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker, distance};
use crate::fault::parameter::Settings;

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "rrt_connect",
    title: "RRT-Connect",
    description: "Trees from both ends grow towards each other. The fastest way to a first path, \
                  which is not a short one: smooth it.",
    source: "Kuffner and LaValle 2000, doi:10.1109/ROBOT.2000.844730",
    anytime: false,
    needs_clearance: false,
    parameters: &[iterations(100_000.0), RANGE],
};

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> RrtConnect {
    RrtConnect {
        roadmap: Roadmap::new(problem),
        range: range(settings, problem),
        side: 0,
        target: vec![0.0; problem.dimension()],
        state: vec![0.0; problem.dimension()],
        next: vec![0.0; problem.dimension()],
        under_way: None,
    }
}

pub(super) struct RrtConnect {
    roadmap: Roadmap,
    range: f64,
    /// The tree that is extended next.
    side: usize,
    target: Vec<f64>,
    /// The new node.
    state: Vec<f64>,
    /// Where the other tree goes next.
    next: Vec<f64>,
    /// The node of tree `side` that the other tree is on its way to, and how far
    /// that has come, where the way is too long for one iteration.
    under_way: Option<(usize, u32, u32)>,
}

/// Most steps of one tree towards the other in one iteration.
const STEPS: usize = 16;

impl Planner for RrtConnect {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        if let Some((side, node, at)) = self.under_way.take() {
            return self.connect(world, side, node, at);
        }
        world.sample_evenly(&mut self.target);
        let side = self.side;
        self.side = 1 - side;
        let tree = &mut self.roadmap.trees[side];
        let (nearest, squared) = tree.nearest(&self.target);
        let from = tree.state(nearest);
        let step = steer(from, &self.target, squared.sqrt(), self.range, &mut self.state);
        let Some(step) = step else { return };
        if world.is_free(from, &self.state) {
            let node = tree.add(&self.state, nearest, step);
            let (at, _) = self.roadmap.trees[1 - side].nearest(&self.state);
            self.connect(world, side, node, at);
        }
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.roadmap
    }
}

impl RrtConnect {
    /// Lets the other tree go on from its node `at` to the new node of tree `side`.
    fn connect<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        side: usize,
        node: u32,
        mut at: u32,
    ) {
        let tree = &mut self.roadmap.trees[1 - side];
        for _ in 0..STEPS {
            let from = tree.state(at);
            let left = distance(from, &self.state);
            let step = steer(from, &self.state, left, self.range, &mut self.next);
            if !step.is_none_or(|_| world.is_free(from, &self.next)) {
                return;
            }
            if left <= self.range {
                self.join(side, node, at, left);
                return;
            }
            let Some(step) = step else { return };
            at = tree.add(&self.next, at, step);
        }
        self.under_way = Some((side, node, at));
    }

    fn join(&mut self, side: usize, node: u32, other: u32, step: f64) {
        let nodes = if side == 0 { [node, other] } else { [other, node] };
        self.roadmap.offer(nodes, step);
    }
}
