//! The task `path`: a way for a point in a box among balls and boxes.

mod bezier;
mod prepare;
mod request;
mod result;
mod run;
mod smoothing;
mod space;

pub use bezier::BezierPiece;
pub(super) use prepare::{PreparedPath, check_planner, prepare};
pub use request::{
    BallObstacle, BoxObstacle, Obstacle, PathTask, PlannerChoice, SmoothingChoice, Space,
};
pub use result::{PathResult, TreeEdge};
pub(super) use run::run;
pub(super) use smoothing::ATTEMPTS;
pub use smoothing::{SMOOTHINGS, SmoothingEntry, SmoothingInfo, smoothing};
pub use space::PointSpace;
