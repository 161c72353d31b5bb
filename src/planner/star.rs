//! One tree that RRT* and its relatives grow from the start, and how it reaches
//! the goal.

use super::entry::{optional, range};
use super::rewiring::Rewiring;
use super::roadmap::Roadmap;
use super::tree::Tree;
use super::world::World;
use super::{PlanningProblem, ValidityChecker, distance};
use crate::fault::parameter::{Parameter, Settings, real};

/// One tree from the start that is rewired, and the goal.
pub(super) struct Star {
    pub roadmap: Roadmap,
    pub rewiring: Rewiring,
    /// Probability of aiming at the goal.
    pub goal_bias: f64,
    goal_reach: f64,
    /// Where a sample goes.
    pub target: Vec<f64>,
    /// What takes a corner's place.
    before: Vec<f64>,
    after: Vec<f64>,
}

/// `goal_bias`.
pub(super) const GOAL_BIAS: Parameter = real(
    "goal_bias",
    "probability with which the goal itself is the sample; default 0.05",
    0.05,
    0.0,
    1.0,
);

/// `goal_reach`.
pub(super) const GOAL_REACH: Parameter = optional(
    "goal_reach",
    "longest straight motion to the goal that is tried from a new node, in the units of the \
     space; default: any, whereas the sources take the range",
);

/// Samples, unless set: enough for a plane or a space with some tens of obstacles.
pub(super) const ITERATIONS: f64 = 10_000.0;

impl Star {
    /// With `depth` generations of ancestors taking part.
    pub fn new(settings: &Settings, problem: &PlanningProblem, depth: usize) -> Self {
        Self {
            roadmap: Roadmap::new(problem),
            rewiring: Rewiring::new(problem, range(settings, problem), depth),
            goal_bias: settings.get("goal_bias"),
            goal_reach: settings.optional("goal_reach").unwrap_or(f64::INFINITY),
            target: vec![0.0; problem.dimension()],
            before: vec![0.0; problem.dimension()],
            after: vec![0.0; problem.dimension()],
        }
    }

    /// Extends the tree towards `target` and tries the goal from the new node.
    pub fn grow<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) -> Option<u32> {
        let limit = self.roadmap.length();
        let goal = &world.problem.goal;
        let tree = &mut self.roadmap.trees[0];
        let node = self.rewiring.extend(world, tree, &self.target, goal, limit)?;
        for &from in self.rewiring.trace(&self.roadmap.trees[0], node) {
            let state = self.roadmap.trees[0].state(from);
            let step = distance(state, goal);
            if step <= self.goal_reach
                && self.roadmap.through([from, 0], step) < self.roadmap.length()
                && world.is_free(state, goal)
            {
                self.roadmap.offer([from, 0], step);
                break;
            }
        }
        Some(node)
    }

    /// Makes the best path shorter as it is: joins every node with the furthest
    /// ancestor in sight, the goal first.
    pub fn straighten<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let Some([end, _]) = self.roadmap.join() else { return };
        self.target.copy_from_slice(&world.problem.goal);
        let tree = &self.roadmap.trees[0];
        if let Some((ancestor, step)) = furthest_in_sight(world, tree, end, &self.target) {
            self.roadmap.offer([ancestor, 0], step);
        }
        let Some([mut at, _]) = self.roadmap.join() else { return };
        let tree = &mut self.roadmap.trees[0];
        while let Some(parent) = tree.parent(at) {
            self.target.copy_from_slice(tree.state(at));
            if let Some((ancestor, step)) = furthest_in_sight(world, tree, parent, &self.target)
                && tree.cost(ancestor) + step < tree.cost(at)
            {
                tree.reparent(at, ancestor, step);
            }
            at = tree.parent(at).unwrap_or(0);
        }
    }

    /// Straightens the best path and cuts its corners, once; whether it may be
    /// worth doing so again.
    pub fn tighten<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) -> bool {
        let length = self.roadmap.length();
        self.straighten(world);
        self.cut_corners(world);
        self.roadmap.length() < length * (1.0 - LEAST_SAVING)
    }

    /// Cuts the corners of the best path, the last first: two new nodes before
    /// and after it take a corner's place where the motion between them is free.
    fn cut_corners<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        let Some([mut corner, _]) = self.roadmap.join() else { return };
        // None stands for the goal.
        let mut next = None;
        while let Some(parent) = self.roadmap.trees[0].parent(corner) {
            (next, corner) = match self.cut(world, parent, corner, next) {
                Some(before) => (Some(before), parent),
                None => (Some(corner), parent),
            };
        }
    }

    /// Cuts one corner; the node that is the first of the two, if there are any.
    fn cut<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        parent: u32,
        corner: u32,
        next: Option<u32>,
    ) -> Option<u32> {
        let least = LEAST_SAVING * self.roadmap.length();
        let tree = &mut self.roadmap.trees[0];
        let goal = &world.problem.goal;
        let mut share = 1.0;
        loop {
            share *= 0.5;
            let state = tree.state(corner);
            let end = next.map_or(goal.as_slice(), |next| tree.state(next));
            between(state, tree.state(parent), share, &mut self.before);
            between(state, end, share, &mut self.after);
            let steps = [
                tree.distance(parent, &self.before),
                distance(&self.before, &self.after),
                distance(&self.after, end),
            ];
            let old = tree.distance(parent, state) + distance(state, end);
            if steps.iter().sum::<f64>() >= old - least {
                return None;
            }
            // Rounding moves both off the motions they are taken from.
            if world.is_free(&self.before, &self.after)
                && world.is_free(tree.state(parent), &self.before)
                && world.is_free(&self.after, end)
            {
                let before = tree.add(&self.before, parent, steps[0]);
                let after = tree.add(&self.after, before, steps[1]);
                match next {
                    Some(next) => tree.reparent(next, after, steps[2]),
                    None => self.roadmap.offer([after, 0], steps[2]),
                }
                return Some(before);
            }
        }
    }
}

/// Share of the path that is worth two nodes.
const LEAST_SAVING: f64 = 1e-8;

/// Writes the point at a share of the way from one state to another.
fn between(from: &[f64], to: &[f64], share: f64, state: &mut [f64]) {
    for (x, (from, to)) in state.iter_mut().zip(from.iter().zip(to)) {
        *x = from + (to - from) * share;
    }
}

/// Most ancestors that are looked at from one node: of longer lines evenly picked
/// ones.
const LOOKS: usize = 64;

/// The earliest ancestor of a node from which a free motion leads to `state`,
/// and that motion's length.
fn furthest_in_sight<C: ValidityChecker>(
    world: &mut World<'_, C>,
    tree: &Tree,
    node: u32,
    state: &[f64],
) -> Option<(u32, f64)> {
    let ancestors: Vec<u32> = tree.ancestors(node).collect();
    let apart = ancestors.len().div_ceil(LOOKS).max(1);
    let mut furthest = ancestors.into_iter().rev().step_by(apart);
    let in_sight = furthest.find(|&ancestor| world.is_free(tree.state(ancestor), state))?;
    Some((in_sight, tree.distance(in_sight, state)))
}
