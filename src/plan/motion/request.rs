//! What a user asks for when planning a motion around obstacles.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::Pose;
use crate::plan::objectives::ObjectiveWeights;
use crate::plan::path::{PlannerChoice, SmoothingChoice};
use crate::plan::poses::Waypoint;
use crate::plan::request::{
    Clock, ConstraintHandling, Constraints, DurationGoal, DurationRange, OptimizerChoice,
    WaypointsTask,
};

/// Move from `start` to `goal` in the least time, at rest at both, without touching the scene or the robot itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionTask {
    /// Where the motion begins.
    pub start: MotionEnd,
    /// Where it ends.
    pub goal: MotionEnd,
    /// Distance to keep from everything, m; 0 is not to touch.
    #[serde(default)]
    #[schema(minimum = 0.0)]
    pub clearance_m: f64,
    /// Planner by registry name, with its parameters.
    #[serde(default)]
    pub planner: PlannerChoice,
    /// Smoothing of the path: `shortcut` or `none`; corners are rounded by the timing.
    #[serde(default)]
    pub smoothing: SmoothingChoice,
    /// Interpolation by registry name: any that takes any number of waypoints.
    #[serde(default = "default_interpolation")]
    pub interpolation: String,
    /// As for waypoints.
    #[serde(default)]
    pub clock: Clock,
    /// As for waypoints.
    #[serde(default)]
    pub optimizer: OptimizerChoice,
    /// As for waypoints.
    #[serde(default)]
    pub constraint_handling: ConstraintHandling,
    /// As for waypoints.
    #[serde(default)]
    pub constraints: Constraints,
    /// As for waypoints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub durations: Option<DurationRange>,
    /// As for waypoints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration: Option<DurationGoal>,
    /// As for waypoints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<ObjectiveWeights>,
}

/// One end of a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionEnd {
    /// A configuration in joint order, rad or m.
    Joints(Vec<f64>),
    /// Where the tool shall be in the world; of the configurations that bring it there one that is free is taken.
    Pose(Pose),
}

fn default_interpolation() -> String {
    "jerk_limited".to_owned()
}

impl MotionTask {
    /// The task of timing `waypoints` as this one asks for.
    pub(super) fn through(&self, waypoints: Vec<Vec<f64>>) -> WaypointsTask {
        WaypointsTask {
            waypoints: waypoints.into_iter().map(Waypoint::Joints).collect(),
            interpolation: self.interpolation.clone(),
            clock: self.clock,
            optimizer: self.optimizer.clone(),
            constraint_handling: self.constraint_handling,
            constraints: self.constraints,
            durations: self.durations,
            duration: self.duration,
            objective: self.objective,
            pareto: None,
            via_tolerance: None,
            fixed_durations: None,
            start: None,
            goal: None,
        }
    }
}
