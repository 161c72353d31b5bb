//! Robot against scene and against itself.
//!
//! A [`CollisionChecker`] is a robot in a scene, compiled for speed. What it calls free is free by exact distances: of
//! configurations, of straight motions by samples or over all their length, and of any timed motion by a proven
//! clearance.

mod chain;
mod checker;
mod clearance;
mod continuous;
mod cover;
mod kernel;
mod lane_chain;
mod lane_obstacle;
mod model;
mod motion;
mod travel;

pub use checker::{BATCH, CollisionChecker, CollisionScratch, MotionCheck};
pub use clearance::Clearance;
pub use continuous::{ClearanceError, JointMotion, ProvenClearance};
