//! Timed motion: trajectories, interpolations, timing and certificates.

mod bound;
mod certificate;
mod curve;
mod export;
pub mod interpolation;
pub mod kernel;
mod limits;
mod polynomial_trajectory;
pub mod timing;

pub use bound::LowerBound;
pub use certificate::{Certificate, Clearance, JointCertificate, Peak, PositionRange, Violation};
pub use export::{
    ExportError, JointTrajectory, JointTrajectoryPoint, MAX_SAMPLES, Quantity, RosDuration,
    Samples, Timeline, UnknownQuantity,
};
pub use limits::{DERIVATIVES, JointBounds, Limit};
pub use polynomial_trajectory::{KinematicState, Trajectory, TrajectoryError};
