//! How RRT* and its relatives add a state to a tree: by the cheapest parent
//! nearby, and as a parent for those it is cheaper for.
//!
//! Karaman and Frazzoli 2011, doi:10.1177/0278364911406761; with ancestors as
//! candidates, Jeong et al. 2019, doi:10.1016/j.eswa.2019.01.032.

use std::f64::consts::PI;

use super::tree::Tree;
use super::world::World;
use super::{PlanningProblem, ValidityChecker, distance};

/// Adds states to one tree.
pub(super) struct Rewiring {
    /// Longest extension.
    pub range: f64,
    /// Generations of ancestors that may be parents, too.
    depth: usize,
    radius: NearRadius,
    state: Vec<f64>,
    near: Vec<(u32, f64)>,
    /// Candidates for the parent: cost of the new state by them, name, step.
    candidates: Vec<(f64, u32, f64)>,
    /// The new node after its ancestors, the furthest first.
    line: Vec<u32>,
    /// When each node was a candidate last.
    seen: Vec<u32>,
    round: u32,
}

impl Rewiring {
    /// `depth` generations of ancestors take part.
    pub fn new(problem: &PlanningProblem, range: f64, depth: usize) -> Self {
        Self {
            range,
            depth,
            radius: NearRadius::new(problem, 4.0 * range),
            state: vec![0.0; problem.dimension()],
            near: Vec::new(),
            candidates: Vec::new(),
            line: Vec::new(),
            seen: Vec::new(),
            round: 0,
        }
    }

    /// Lets the near radius speak of a part of the box, `share` of its volume.
    pub fn restrict(&mut self, share: f64) {
        self.radius.restrict(share);
    }

    /// Extends a tree towards `target` and rewires it around the new node, if
    /// there is one: none if the motion from the nearest node is not free, or if
    /// no path through the new node to `other_end` is shorter than `limit`.
    pub fn extend<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        tree: &mut Tree,
        target: &[f64],
        other_end: &[f64],
        limit: f64,
    ) -> Option<u32> {
        let (nearest, squared) = tree.nearest(target);
        let step = steer(tree.state(nearest), target, squared.sqrt(), self.range, &mut self.state)?;
        let left = distance(&self.state, other_end);
        if tree.distance(0, &self.state) + left >= limit
            || !world.is_free(tree.state(nearest), &self.state)
        {
            return None;
        }
        let radius = self.radius.at(tree.len());
        tree.within(&self.state, radius, &mut self.near);
        for (_, away) in &mut self.near {
            *away = away.sqrt();
        }
        let (parent, step) = self.cheapest_parent(world, tree, nearest, step);
        if tree.cost(parent) + step + left >= limit {
            return None;
        }
        let node = tree.add(&self.state, parent, step);
        self.rewire(world, tree, node);
        Some(node)
    }

    /// The parent by which the new state costs least, and the step from it;
    /// `nearest` is known to be free.
    fn cheapest_parent<C: ValidityChecker>(
        &mut self,
        world: &mut World<'_, C>,
        tree: &Tree,
        nearest: u32,
        step: f64,
    ) -> (u32, f64) {
        let limit = tree.cost(nearest) + step;
        self.candidates.clear();
        let near = self.near.iter();
        self.candidates.extend(near.filter_map(|&(node, step)| candidate(tree, node, step, limit)));
        if self.depth > 0 {
            self.add_ancestors(tree, limit);
        }
        self.candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut candidates = self.candidates.iter();
        let free = candidates.find(|(_, node, _)| world.is_free(tree.state(*node), &self.state));
        free.map_or((nearest, step), |&(_, node, step)| (node, step))
    }

    /// Adds the ancestors of the nodes nearby to the candidates, each once.
    fn add_ancestors(&mut self, tree: &Tree, limit: f64) {
        self.round += 1;
        self.seen.resize(tree.len(), 0);
        for &(node, _) in &self.near {
            for ancestor in tree.ancestors(node).take(self.depth) {
                if std::mem::replace(&mut self.seen[ancestor as usize], self.round) != self.round {
                    let step = tree.distance(ancestor, &self.state);
                    self.candidates.extend(candidate(tree, ancestor, step, limit));
                }
            }
        }
    }

    /// Makes the new node, or one of its ancestors, the parent of the nodes
    /// nearby that get cheaper by it. None of them can descend from such a node,
    /// since costs grow from parents to children.
    fn rewire<C: ValidityChecker>(&mut self, world: &mut World<'_, C>, tree: &mut Tree, node: u32) {
        self.trace(tree, node);
        for &(near, away) in &self.near {
            for &parent in &self.line {
                let cost = tree.cost(near);
                let step =
                    if parent == node { away } else { tree.distance(parent, tree.state(near)) };
                if tree.cost(parent) + step < cost
                    && world.is_free(tree.state(parent), tree.state(near))
                {
                    tree.reparent(near, parent, step);
                    break;
                }
            }
        }
    }

    /// A node after its ancestors of as many generations as take part, the
    /// furthest, by which the way is shortest, first.
    pub fn trace(&mut self, tree: &Tree, node: u32) -> &[u32] {
        self.line.clear();
        self.line.push(node);
        self.line.extend(tree.ancestors(node).take(self.depth));
        self.line.reverse();
        &self.line
    }
}

#[inline]
fn candidate(tree: &Tree, node: u32, step: f64, limit: f64) -> Option<(f64, u32, f64)> {
    let cost = tree.cost(node) + step;
    (cost < limit).then_some((cost, node, step))
}

/// Writes the state at most `range` from `from` towards `target`, which lies
/// `away`, and returns its distance; none where that is no motion at all.
#[inline(always)]
pub(super) fn steer(
    from: &[f64],
    target: &[f64],
    away: f64,
    range: f64,
    state: &mut [f64],
) -> Option<f64> {
    if away <= range {
        state.copy_from_slice(target);
        return Some(away).filter(|&away| away > 0.0);
    }
    let share = range / away;
    for ((x, from), to) in state.iter_mut().zip(from).zip(target) {
        *x = from + (to - from) * share;
    }
    Some(distance(from, state)).filter(|&step| step > 0.0)
}

/// Within which radius a tree of `n` nodes is rewired:
/// `min(gamma (ln n / n)^(1/d), cap)` with the least `gamma` that keeps RRT*
/// optimal, `2 (1 + 1/d)^(1/d) (volume / volume of the unit ball)^(1/d)`.
struct NearRadius {
    cap: f64,
    /// Of the whole box.
    gamma: f64,
    /// Of the part that matters.
    part: f64,
    dimension: f64,
    radius: f64,
    /// Tree sizes for which it holds: it is computed again when the tree has
    /// grown by a sixteenth.
    sizes: std::ops::Range<usize>,
}

impl NearRadius {
    fn new(problem: &PlanningProblem, cap: f64) -> Self {
        let dimension = problem.dimension() as f64;
        let ends = problem.lower.iter().zip(&problem.upper);
        let logarithm: f64 = ends.map(|(lower, upper)| libm::log(upper - lower)).sum();
        let side = libm::exp((logarithm - libm::log(unit_ball(problem.dimension()))) / dimension);
        let gamma = 2.0 * libm::pow(1.0 + 1.0 / dimension, 1.0 / dimension) * side;
        Self { cap, gamma, part: gamma, dimension, radius: cap, sizes: 0..0 }
    }

    fn restrict(&mut self, share: f64) {
        self.part = self.gamma * libm::pow(share, 1.0 / self.dimension);
        self.sizes = 0..0;
    }

    fn at(&mut self, nodes: usize) -> f64 {
        if !self.sizes.contains(&nodes) {
            let n = nodes.max(2) as f64;
            let radius = self.part * libm::pow(libm::log(n) / n, 1.0 / self.dimension);
            self.radius = radius.min(self.cap);
            self.sizes = nodes..nodes + nodes / 16 + 1;
        }
        self.radius
    }
}

/// The volume of the unit ball.
pub(super) fn unit_ball(dimension: usize) -> f64 {
    let half = dimension as f64 / 2.0;
    libm::pow(PI, half) / libm::tgamma(half + 1.0)
}
