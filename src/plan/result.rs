//! What a user gets.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::family::FamilyResult;
use super::motion::MotionPath;
use super::pareto::ParetoFront;
use super::path::PathResult;
use super::study::ComparisonResult;
use crate::budget::StopReason;
use crate::optimize::ConvergencePoint;
use crate::trajectory::objective::Measures;
use crate::trajectory::{Certificate, LowerBound, Trajectory};

/// The result of a planning job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum PlanResult {
    /// Of a program: a result per leg.
    Program(ProgramResult),
    /// Of a task with one trajectory.
    Trajectory(Box<TrajectoryResult>),
    /// Of a path: its corners and how it was found.
    Path(Box<PathResult>),
    /// Of a family: a row per member and the plan of the slowest.
    Family(FamilyResult),
    /// Of a comparison or a benchmark: a result per problem and method.
    Comparison(ComparisonResult),
}

/// A timed trajectory and the figures that prove it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TrajectoryResult {
    /// The robot's name.
    pub robot: String,
    /// Joint order of every vector below.
    pub joint_names: Vec<String>,
    /// `rad` or `m` per joint: the unit of its position.
    pub joint_units: Vec<String>,
    /// Total duration, s.
    pub duration: f64,
    /// Duration of each segment between waypoints, s.
    pub durations: Vec<f64>,
    /// When each waypoint is passed, s.
    pub waypoint_times: Vec<f64>,
    /// The configurations passed.
    pub waypoints: Vec<Vec<f64>>,
    /// The trajectory as delivered.
    pub trajectory: Trajectory,
    /// Proof that it keeps the limits, or where it does not.
    pub certificate: Certificate,
    /// How short any trajectory through the waypoints could be.
    pub bound: Option<LowerBound>,
    /// Figures that describe the plan.
    pub metrics: PlanMetrics,
    /// Of a motion around obstacles, the path it follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionPath>,
    /// With `pareto`, the front asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pareto: Option<ParetoFront>,
    /// With `clock: per_joint`, what each joint would need alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_joint: Option<Vec<JointOptimum>>,
    /// How the best candidate improved.
    pub convergence: Vec<ConvergencePoint>,
    /// Interpolation used.
    pub interpolation: String,
    /// Optimizer used.
    pub optimizer: String,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// Iterations done.
    pub iterations: u64,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Planning time, s. With `convergence[].elapsed_s` the only field that may
    /// differ between equal requests.
    pub planning_s: f64,
    /// The request's seed.
    pub seed: u64,
    /// Version of Takt that planned it.
    pub version: String,
}

/// One joint's durations when it is planned alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointOptimum {
    /// Joint name.
    pub joint: String,
    /// Duration of each segment, s.
    pub durations: Vec<f64>,
    /// Their sum, s.
    pub duration: f64,
    /// Candidates evaluated for this joint.
    pub evaluations: u64,
}

/// Figures that describe a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PlanMetrics {
    /// Duration of the first lawful candidate, s.
    pub initial_duration: f64,
    /// Share of `initial_duration` saved; negative where a longer duration was asked for, or the tool's
    /// speed limit needs it.
    pub saved: f64,
    /// The whole motion's time, jerk and energy.
    #[serde(default)]
    pub objective: Measures,
    /// With weights, the same of the fastest motion, to which they are relative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Measures>,
    /// Root mean square jerk per joint.
    pub rms_jerk: Vec<f64>,
    /// Mean speed over the velocity limit per joint; null without a limit.
    pub mean_utilisation: Vec<Option<f64>>,
    /// Distance travelled per joint, rad or m.
    pub path_length: Vec<f64>,
    /// Limits that keep the trajectory from being shorter.
    pub binding: Vec<Binding>,
    /// With a limit on the tool's speed, how long the motion would take without it, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_tcp_limit: Option<f64>,
    /// With `jerk_limited`, what more of each limit would save, most first; absent where the limit of the
    /// tool's speed makes the motion longer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<Sensitivity>,
}

/// What more of a limit saves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Sensitivity {
    /// Joint name.
    pub joint: String,
    /// `velocity`, `acceleration` or `jerk`.
    pub limit: String,
    /// By how much the optimum gets shorter if the limit is one percent higher, s, to first
    /// order: less where another joint is nearly as slow.
    pub seconds_per_percent: f64,
}

/// A limit that is reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Binding {
    /// Segment between waypoints, from 0.
    pub segment: usize,
    /// Joint name; `tcp` for the tool centre point.
    pub joint: String,
    /// `velocity`, `acceleration`, `jerk` or, of the tool centre point, `tcp_speed`.
    pub limit: String,
}

/// A program's legs in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProgramResult {
    /// The robot's name.
    pub robot: String,
    /// Joint order of every vector below.
    pub joint_names: Vec<String>,
    /// Cycle time: the legs' durations together, s.
    pub duration: f64,
    /// True if every leg's certificate is lawful.
    pub lawful: bool,
    /// The worst ratio of a peak to its limit over all legs.
    pub worst_ratio: f64,
    /// A result per leg.
    pub legs: Vec<LegResult>,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Planning time, s.
    pub planning_s: f64,
    /// The request's seed.
    pub seed: u64,
    /// Version of Takt that planned it.
    pub version: String,
}

/// One leg of a program, planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LegResult {
    /// The leg's name.
    pub name: String,
    /// The note that came with the leg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// When it starts within the program, s.
    pub start: f64,
    /// Its result.
    pub result: TrajectoryResult,
}
