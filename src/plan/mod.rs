//! From a `PlanRequest` to a `PlanResult`: synchronous, without I/O.

mod error;
mod limits;
mod prepare;
mod program;
mod request;
mod result;
pub mod scenarios;
pub mod verify;
mod waypoints;

pub use error::{PlanCode, PlanError};
pub use prepare::{MAX_LEGS, MAX_WAYPOINTS, PreparedPlan, Progress, validate};
pub use request::*;
pub use result::*;
