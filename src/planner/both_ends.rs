//! Two trees, from the start and from the goal, that are rewired and meet.

use super::entry::optional;
use super::rewiring::Rewiring;
use super::roadmap::Roadmap;
use super::world::World;
use super::{PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings};

/// Two trees that are rewired and joined.
pub(super) struct BothEnds {
    pub roadmap: Roadmap,
    rewirings: [Rewiring; 2],
    reach: f64,
    near: Vec<(u32, f64)>,
}

/// `connection_reach`.
pub(super) const REACH: Parameter = optional(
    "connection_reach",
    "longest motion by which the trees are joined, in the units of the space; default: twice the \
     range",
);

impl BothEnds {
    /// With `depth` generations of ancestors taking part.
    pub fn new(settings: &Settings, problem: &PlanningProblem, range: f64, depth: usize) -> Self {
        Self {
            roadmap: Roadmap::new(problem),
            rewirings: [0, 1].map(|_| Rewiring::new(problem, range, depth)),
            reach: settings.optional("connection_reach").unwrap_or(2.0 * range),
            near: Vec::new(),
        }
    }

    /// Extends tree `side` towards a state.
    pub fn grow<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        side: usize,
        target: &[f64],
    ) -> Option<u32> {
        let limit = self.roadmap.length();
        let other_end = if side == 0 { &world.problem.goal } else { &world.problem.start };
        let tree = &mut self.roadmap.trees[side];
        self.rewirings[side].extend(world, tree, target, other_end, limit)
    }

    /// Joins a node of tree `side` with the node of the other tree nearby that
    /// gives the shortest path, if that is the best so far.
    pub fn connect<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        side: usize,
        node: u32,
    ) {
        let Roadmap { trees: [from, to], .. } = &mut self.roadmap;
        let (own, other) = if side == 0 { (from, to) } else { (to, from) };
        other.within(own.state(node), self.reach, &mut self.near);
        for (_, length) in &mut self.near {
            *length = length.sqrt();
        }
        let total = |&(name, step): &(u32, f64)| step + other.cost(name);
        self.near.sort_unstable_by(|a, b| total(a).total_cmp(&total(b)).then(a.0.cmp(&b.0)));
        for &(name, step) in &self.near {
            let nodes = if side == 0 { [node, name] } else { [name, node] };
            if self.roadmap.through(nodes, step) >= self.roadmap.length() {
                return;
            }
            let [own, other] = [&self.roadmap.trees[side], &self.roadmap.trees[1 - side]];
            if world.is_free(own.state(node), other.state(name)) {
                self.roadmap.offer(nodes, step);
                return;
            }
        }
    }
}
