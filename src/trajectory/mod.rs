//! Timed motion: trajectories, interpolations, timing and certificates.

mod certificate;
mod export;
pub mod interpolation;
pub mod kernel;
mod polynomial_trajectory;
pub mod timing;

pub use certificate::{Certificate, Clearance, JointCertificate, Peak, PositionRange, Violation};
pub use export::{
    ExportError, JointTrajectory, JointTrajectoryPoint, MAX_SAMPLES, Quantity, RosDuration,
    Samples, Timeline, UnknownQuantity,
};
pub use polynomial_trajectory::{KinematicState, Trajectory, TrajectoryError};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A proven lower bound on the duration of any lawful trajectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LowerBound {
    /// No lawful trajectory through the waypoints is shorter, s.
    pub lower: f64,
    /// How much longer the plan is, relative to `lower`.
    pub gap: f64,
    /// How it was proven.
    pub method: String,
}
