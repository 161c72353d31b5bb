//! What a user gets of the way to a motion, beside its trajectory.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The path that a motion follows, and how it was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionPath {
    /// Corners of the path as planned, from start to goal, rad or m: the motions between are straight and proven free.
    pub planned: Vec<Vec<f64>>,
    /// The same after smoothing. The trajectory passes them, and further points between them where it has to keep closer.
    pub path: Vec<Vec<f64>>,
    /// Length of the smoothed path, Euclidean in rad and m.
    pub length: f64,
    /// The straight line from start to goal: no path is shorter.
    pub straight_length: f64,
    /// Nodes of all trees.
    pub nodes: usize,
    /// Iterations of the planner.
    pub iterations: u64,
    /// Motions checked.
    pub checks: u64,
    /// Planner used.
    pub planner: String,
    /// Smoothing used.
    pub smoothing: String,
    /// Points that the timing added so that the curve stays free.
    pub added_waypoints: usize,
}
