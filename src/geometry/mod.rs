//! Rigid poses and shapes.

mod pose;
mod shape;

pub use pose::{Pose, Transform};
pub use shape::{Placed, Shape};
