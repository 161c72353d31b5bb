//! What a user gets when the path of a point is planned.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::bezier::BezierPiece;
use super::request::Space;
use crate::budget::StopReason;
use crate::optimize::ConvergencePoint;

/// A free path, and how it was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PathResult {
    /// Corners of the path as planned, from start to goal.
    pub path: Vec<Vec<f64>>,
    /// Corners of the smoothed path; with a curve, points of it that are joined
    /// by free motions, too. Null if nothing was to be smoothed.
    pub smoothed_path: Option<Vec<Vec<f64>>>,
    /// The smoothed path piece by piece, if it is a curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curve: Option<Vec<BezierPiece>>,
    /// Length of the path as planned.
    pub length: f64,
    /// Length of the smoothed path; null if nothing was to be smoothed.
    pub smoothed_length: Option<f64>,
    /// The straight line from start to goal: no path is shorter.
    pub straight_length: f64,
    /// Smallest distance of a corner of the path from an obstacle; null without
    /// obstacles.
    pub clearance: Option<f64>,
    /// Nodes of all trees.
    pub nodes: usize,
    /// Iterations done.
    pub iterations: u64,
    /// Motions checked.
    pub evaluations: u64,
    /// Every improvement of the length: `evaluations` are motions checked, `best`
    /// is the length.
    pub convergence: Vec<ConvergencePoint>,
    /// Planner used.
    pub planner: String,
    /// Smoothing used.
    pub smoothing: String,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// The space, so that the result can be drawn.
    pub space: Space,
    /// With `trees`, motions that the planner's trees are made of: all, or so
    /// many evenly picked ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tree_edges: Vec<TreeEdge>,
    /// Planning time, s. With `convergence[].elapsed_s` the only field that may
    /// differ between equal requests.
    pub planning_s: f64,
    /// The request's seed.
    pub seed: u64,
    /// Version of Takt that planned it.
    pub version: String,
}

/// One motion of a tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeEdge {
    /// The parent.
    pub from: Vec<f64>,
    /// The child.
    pub to: Vec<f64>,
}

impl PathResult {
    /// The path to follow: smoothed if it was to be.
    pub fn best_path(&self) -> &[Vec<f64>] {
        self.smoothed_path.as_ref().unwrap_or(&self.path)
    }

    /// Its length.
    pub fn best_length(&self) -> f64 {
        self.smoothed_length.unwrap_or(self.length)
    }

    /// In words: how long it is and how much of that is detour.
    pub fn verdict(&self) -> String {
        let length = self.best_length();
        let detour = if self.straight_length > 0.0 {
            100.0 * (length / self.straight_length - 1.0)
        } else {
            0.0
        };
        let corners = self.path.len().saturating_sub(2);
        format!(
            "path of length {length:.4} by {}, {detour:.2} % longer than the straight line, \
             {corners} corners as planned",
            self.planner
        )
    }
}
