//! The task `motion`: from here to there around what stands in the way.
//!
//! Ends become configurations ([`ends`]), a planner finds a path of straight free motions between them and
//! shortcuts make it short ([`run`]), and then it is timed like waypoints, with more of them wherever the curve would leave
//! the free space ([`timing`]). The certificate's clearance is proven over continuous time ([`travel`]).

mod checker;
mod ends;
mod prepare;
mod request;
mod result;
mod run;
mod timing;
mod travel;

pub(super) use prepare::{PreparedMotion, prepare};
pub use request::{MotionEnd, MotionTask};
pub use result::MotionPath;
pub(super) use run::run;
