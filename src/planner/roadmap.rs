//! One tree from the start, one from the goal, and where they meet.

use super::PlanningProblem;
use super::tree::{GrownTree, Tree};

/// What a planner grows. Where only the start has a tree, the goal's is its
/// root alone.
pub(super) struct Roadmap {
    /// From the start, and from the goal.
    pub trees: [Tree; 2],
    /// A node of each that a free motion joins, on the shortest path so far,
    /// and the length of that motion.
    join: Option<([u32; 2], f64)>,
}

impl Roadmap {
    pub fn new(problem: &PlanningProblem) -> Self {
        Self {
            trees: [Tree::new(problem, &problem.start), Tree::new(problem, &problem.goal)],
            join: None,
        }
    }

    /// Length of the best path so far; infinite if there is none.
    #[inline(always)]
    pub fn length(&self) -> f64 {
        self.join.map_or(f64::INFINITY, |(nodes, step)| self.through(nodes, step))
    }

    /// Length of the path through two nodes that lie `step` apart.
    #[inline(always)]
    pub fn through(&self, [from, to]: [u32; 2], step: f64) -> f64 {
        self.trees[0].cost(from) + step + self.trees[1].cost(to)
    }

    /// The nodes where the best path leaves one tree for the other.
    pub fn join(&self) -> Option<[u32; 2]> {
        self.join.map(|(nodes, _)| nodes)
    }

    /// Takes the path over a free motion between two nodes, `step` apart, if it
    /// is the best so far.
    pub fn offer(&mut self, nodes: [u32; 2], step: f64) {
        if self.through(nodes, step) < self.length() {
            self.join = Some((nodes, step));
        }
    }

    /// Replaces the start's tree by one in which the join's node is `node`.
    pub fn replace_tree(&mut self, tree: Tree, node: u32) {
        self.trees[0] = tree;
        if let Some((nodes, _)) = &mut self.join {
            nodes[0] = node;
        }
    }

    pub fn nodes(&self) -> usize {
        self.trees.iter().map(Tree::len).sum()
    }

    /// The best path, both ends included.
    pub fn path(&self) -> Option<Vec<Vec<f64>>> {
        let [from, to] = self.join()?;
        let mut path = self.trees[0].path(from);
        let mut rest = self.trees[1].path(to);
        // Trees that grew into the same state share it.
        if path.last() == rest.last() && path.len() + rest.len() > 2 {
            rest.pop();
        }
        path.extend(rest.into_iter().rev());
        Some(path)
    }

    pub fn into_grown(self) -> [GrownTree; 2] {
        self.trees.map(Tree::into_grown)
    }
}
