//! A tree of states, with the length of the way from its root to each.

use super::neighbours::Neighbours;
use super::{PlanningProblem, distance};

/// Stands for no node.
const NONE: u32 = u32::MAX;

/// A tree of states; node 0 is the root.
pub(super) struct Tree {
    dimension: usize,
    states: Vec<f64>,
    cost: Vec<f64>,
    /// Length of the motion from the parent.
    step: Vec<f64>,
    links: Vec<Links>,
    neighbours: Neighbours,
}

/// A node's place among its relatives.
#[derive(Clone, Copy)]
struct Links {
    parent: u32,
    first_child: u32,
    previous: u32,
    next: u32,
}

/// A tree as pictures show it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GrownTree {
    /// All states, one behind the other; the first is the root.
    pub states: Vec<f64>,
    /// Each state's parent; the root is its own.
    pub parents: Vec<u32>,
}

impl Tree {
    pub fn new(problem: &PlanningProblem, root: &[f64]) -> Self {
        let mut tree = Self {
            dimension: root.len(),
            states: Vec::with_capacity(64 * root.len()),
            cost: Vec::with_capacity(64),
            step: Vec::with_capacity(64),
            links: Vec::with_capacity(64),
            neighbours: Neighbours::new(&problem.lower, &problem.upper),
        };
        tree.push(root, NONE, 0.0, 0.0);
        tree
    }

    fn push(&mut self, state: &[f64], parent: u32, step: f64, cost: f64) -> u32 {
        let node = self.cost.len() as u32;
        self.states.extend_from_slice(state);
        self.step.push(step);
        self.cost.push(cost);
        self.links.push(Links { parent: NONE, first_child: NONE, previous: NONE, next: NONE });
        self.neighbours.add(state, node);
        if parent != NONE {
            self.hang(node, parent);
        }
        node
    }

    /// Adds a state, `step` away from its parent.
    pub fn add(&mut self, state: &[f64], parent: u32, step: f64) -> u32 {
        self.push(state, parent, step, self.cost(parent) + step)
    }

    pub fn len(&self) -> usize {
        self.cost.len()
    }

    #[inline(always)]
    pub fn state(&self, node: u32) -> &[f64] {
        &self.states[node as usize * self.dimension..][..self.dimension]
    }

    /// Length of the way from the root.
    #[inline(always)]
    pub fn cost(&self, node: u32) -> f64 {
        self.cost[node as usize]
    }

    #[inline]
    pub fn parent(&self, node: u32) -> Option<u32> {
        Some(self.links[node as usize].parent).filter(|&parent| parent != NONE)
    }

    /// Parent, grandparent and so on.
    #[inline]
    pub fn ancestors(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        std::iter::successors(self.parent(node), |&node| self.parent(node))
    }

    /// The last node that was added.
    pub fn newest(&self) -> u32 {
        self.len() as u32 - 1
    }

    /// The nearest node and its squared distance.
    #[inline(always)]
    pub fn nearest(&mut self, state: &[f64]) -> (u32, f64) {
        self.neighbours.nearest(state)
    }

    /// Writes the nodes at most `radius` away with their squared distances.
    pub fn within(&mut self, state: &[f64], radius: f64, found: &mut Vec<(u32, f64)>) {
        self.neighbours.within(state, radius, found);
    }

    fn hang(&mut self, node: u32, parent: u32) {
        let first = std::mem::replace(&mut self.links[parent as usize].first_child, node);
        let links = &mut self.links[node as usize];
        (links.parent, links.previous, links.next) = (parent, NONE, first);
        if first != NONE {
            self.links[first as usize].previous = node;
        }
    }

    fn unhang(&mut self, node: u32) {
        let Links { parent, previous, next, .. } = self.links[node as usize];
        if previous != NONE {
            self.links[previous as usize].next = next;
        } else {
            self.links[parent as usize].first_child = next;
        }
        if next != NONE {
            self.links[next as usize].previous = previous;
        }
    }

    /// Gives a node, not the root, another parent, `step` away, and its
    /// descendants their new costs. The parent must not descend from the node.
    pub fn reparent(&mut self, node: u32, parent: u32, step: f64) {
        self.unhang(node);
        self.hang(node, parent);
        self.step[node as usize] = step;
        self.cost[node as usize] = self.cost(parent) + step;
        let mut at = node;
        while let Some(next) = self.following(at, node) {
            let parent = self.links[next as usize].parent;
            self.cost[next as usize] = self.cost(parent) + self.step[next as usize];
            at = next;
        }
    }

    /// The next of a root's descendants, parents before their children.
    fn following(&self, node: u32, root: u32) -> Option<u32> {
        let child = self.links[node as usize].first_child;
        if child != NONE {
            return Some(child);
        }
        let mut at = node;
        while at != root {
            let Links { parent, next, .. } = self.links[at as usize];
            if next != NONE {
                return Some(next);
            }
            at = parent;
        }
        None
    }

    /// The same tree with only the nodes that are worth keeping and whose
    /// ancestors are, and what has become of `node`.
    pub fn pruned(
        &self,
        problem: &PlanningProblem,
        node: u32,
        is_kept: impl Fn(u32, &[f64]) -> bool,
    ) -> (Self, Option<u32>) {
        let mut kept = Self::new(problem, self.state(0));
        let mut names = vec![NONE; self.len()];
        names[0] = 0;
        let mut at = 0;
        while let Some(next) = self.following(at, 0) {
            let parent = names[self.links[next as usize].parent as usize];
            if parent != NONE && is_kept(next, self.state(next)) {
                let step = self.step[next as usize];
                names[next as usize] = kept.add(self.state(next), parent, step);
            }
            at = next;
        }
        (kept, Some(names[node as usize]).filter(|&name| name != NONE))
    }

    /// States from the root to a node.
    pub fn path(&self, node: u32) -> Vec<Vec<f64>> {
        let mut path = vec![self.state(node).to_vec()];
        path.extend(self.ancestors(node).map(|ancestor| self.state(ancestor).to_vec()));
        path.reverse();
        path
    }

    #[inline]
    pub fn distance(&self, node: u32, state: &[f64]) -> f64 {
        distance(self.state(node), state)
    }

    pub fn into_grown(self) -> GrownTree {
        let parent = |(node, links): (usize, &Links)| {
            if links.parent == NONE { node as u32 } else { links.parent }
        };
        let parents = self.links.iter().enumerate().map(parent).collect();
        GrownTree { states: self.states, parents }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> (PlanningProblem, Tree) {
        let problem = PlanningProblem {
            lower: vec![0.0],
            upper: vec![10.0],
            start: vec![0.0],
            goal: vec![10.0],
        };
        let mut tree = Tree::new(&problem, &[0.0]);
        for (state, parent) in [(1.0, 0), (2.0, 1), (3.0, 1), (4.0, 3), (5.0, 0)] {
            let step = tree.distance(parent, &[state]) * 2.0;
            tree.add(&[state], parent, step);
        }
        (problem, tree)
    }

    #[test]
    fn descendants_follow_a_change_of_parent() {
        let (_, mut tree) = tree();
        assert_eq!([1, 2, 3, 4, 5].map(|node| tree.cost(node)), [2.0, 4.0, 6.0, 8.0, 10.0]);
        tree.reparent(1, 0, 1.0);
        assert_eq!([1, 2, 3, 4, 5].map(|node| tree.cost(node)), [1.0, 3.0, 5.0, 7.0, 10.0]);
        tree.reparent(3, 0, 3.0);
        assert_eq!([1, 2, 3, 4, 5].map(|node| tree.cost(node)), [1.0, 3.0, 3.0, 5.0, 10.0]);
        tree.reparent(2, 4, 0.5);
        assert_eq!(tree.path(2), [[0.0], [3.0], [4.0], [2.0]]);
        assert_eq!(tree.cost(2), 5.5);
        assert_eq!(tree.into_grown().parents, [0, 0, 4, 0, 3, 0]);
    }

    #[test]
    fn what_is_cut_off_takes_its_descendants_along() {
        let (problem, tree) = tree();
        let (kept, four) = tree.pruned(&problem, 4, |_, state| state[0] != 2.0);
        assert_eq!(kept.len(), 5);
        assert_eq!(
            four.map(|four| (kept.path(four), kept.cost(four))),
            Some((tree.path(4), tree.cost(4)))
        );
        let (kept, four) = tree.pruned(&problem, 4, |_, state| state[0] != 3.0);
        assert_eq!((kept.len(), four), (4, None));
    }
}
