//! Sampling planners: a way from a start to a goal that touches nothing.
//!
//! Nothing here knows what moves or what stands in the way: a state is a list
//! of numbers in a box, and a [`ValidityChecker`] tells which states and
//! straight motions are free. One file per method; the loop around them,
//! limits, counting and progress are [`solve`]'s.
//!
//! Lengths are Euclidean. What the methods share: trees with costs and fast
//! neighbours (`tree`, `neighbours`), the drawing of states (`world`), the
//! choice of parents and the rewiring of RRT* (`rewiring`), one tree with a goal
//! (`star`), two trees that meet (`both_ends`), and the potential field of the
//! guided ones (`potential`).

mod bi_apf_rrt_star;
mod both_ends;
mod entry;
mod informed;
mod informed_rrt_star;
mod ipq_rrt_star_connect;
mod neighbours;
mod p_rrt_star;
mod potential;
mod pq_rrt_star;
mod quick_rrt_star;
mod registry;
mod rewiring;
mod roadmap;
mod rrt;
mod rrt_connect;
mod rrt_star;
mod rrt_star_smart;
mod shortcut;
mod solve;
mod star;
mod tree;
mod world;

pub use entry::{PlannerEntry, PlannerInfo};
pub use registry::{PLANNERS, auto, planner, planner_names};
pub use shortcut::shortcut;
pub use solve::{LengthPoint, PathSolution, solve};
pub use tree::GrownTree;

use roadmap::Roadmap;
use world::World;

/// Tells which states and motions are free. The planner's caller implements it.
///
/// Working memory is the checker's own, so every thread needs one of its own.
pub trait ValidityChecker {
    /// Whether a state is free.
    fn is_state_valid(&mut self, state: &[f64]) -> bool;

    /// Whether every state on the straight line between two is free, both ends
    /// included; the same in both directions.
    fn is_motion_valid(&mut self, from: &[f64], to: &[f64]) -> bool;

    /// Distance from a state to the nearest obstacle, in the units of the
    /// state; not positive for one that is not free, infinite without
    /// obstacles. None where the checker cannot tell: methods that follow a
    /// potential field are then refused.
    fn clearance(&mut self, _state: &[f64]) -> Option<f64> {
        None
    }
}

/// A way to be found: from `start` to `goal` within a box.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanningProblem {
    /// Lower ends of the box.
    pub lower: Vec<f64>,
    /// Upper ends, each above its lower end.
    pub upper: Vec<f64>,
    /// Where the path begins.
    pub start: Vec<f64>,
    /// Where it ends.
    pub goal: Vec<f64>,
}

impl PlanningProblem {
    /// Number of coordinates of a state.
    pub fn dimension(&self) -> usize {
        self.lower.len()
    }

    /// The box's diagonal.
    pub fn diagonal(&self) -> f64 {
        distance(&self.lower, &self.upper)
    }
}

/// Why there is nothing to plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlannerError {
    /// An end has another number of coordinates than the box, or lies outside.
    #[error("coordinate {coordinate} of the {end} is {value}, outside {lower} to {upper}")]
    OutOfBounds {
        /// Which end.
        end: PathEnd,
        /// Which coordinate, from 0.
        coordinate: usize,
        /// Its value.
        value: f64,
        /// The box's lower end.
        lower: f64,
        /// The box's upper end.
        upper: f64,
    },
    /// An end is not free.
    #[error("the {0} is not free")]
    EndNotFree(PathEnd),
    /// The method follows distances to obstacles, which the checker does not know.
    #[error("{0} needs distances to obstacles, which are not known here")]
    NeedsClearance(&'static str),
}

/// One end of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathEnd {
    /// Where it begins.
    Start,
    /// Where it ends.
    Goal,
}

impl std::fmt::Display for PathEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Goal => "goal",
        })
    }
}

/// How one iteration follows from the last.
trait Planner: Sized {
    /// Grows the tree or the trees once.
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>);

    /// What has been grown.
    fn roadmap(&mut self) -> &mut Roadmap;

    /// What has been grown, at the end.
    fn into_roadmap(self) -> Roadmap;
}

/// The squared distance of two states.
#[inline(always)]
fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The distance of two states.
#[inline(always)]
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    squared_distance(a, b).sqrt()
}

/// The length of a path.
pub fn length(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum()
}
