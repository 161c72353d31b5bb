//! Rigid poses, shapes and exact distances.

mod closest;
mod gjk;
mod pose;
mod shape;
mod solid;
mod validation;

pub use pose::{Pose, Transform};
pub use shape::{Placed, Shape};
pub use solid::{Core, Solid};
pub use validation::{check_pose, check_shape, length_problem};
