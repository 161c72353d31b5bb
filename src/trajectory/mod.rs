//! Timed motion: trajectories, interpolations, timing and certificates.

mod bound;
mod certificate;
mod curve;
mod ends;
mod export;
pub mod front;
pub mod interpolation;
pub mod jerk_limited;
pub mod kernel;
mod limits;
pub mod objective;
mod polynomial_trajectory;
mod rest_to_rest;
mod rooms;
mod tcp_speed;
mod timeline;
pub mod timing;
mod via;
pub mod weighted;

pub use bound::{LowerBound, Prices, lower_bound};
pub use certificate::{Certificate, Clearance, JointCertificate, Peak, PositionRange, Violation};
pub use ends::Ends;
pub use export::{
    ExportError, JointTrajectory, JointTrajectoryPoint, MAX_SAMPLES, Quantity, RosDuration,
    Samples, Timeline, UnknownQuantity,
};
pub use limits::{DERIVATIVES, JointBounds, Limit};
pub use polynomial_trajectory::{KinematicState, Trajectory, TrajectoryError};
pub use rooms::{Room, Rooms, rooms};
pub use tcp_speed::{TcpLimit, TcpPeak};
pub use timeline::{BindingTimeline, Interval, JointTimeline, LimitTimeline};
