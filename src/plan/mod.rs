//! From a `PlanRequest` to a `PlanResult`: synchronous, without I/O.

pub mod cell;
mod error;
mod limits;
mod prepare;
mod prepared;
mod program;
mod request;
mod result;
mod run;
pub mod scenarios;
pub mod verify;
mod waypoints;

pub use error::{PlanCode, PlanError};
pub use prepare::{MAX_LEGS, MAX_WAYPOINTS, validate};
pub use prepared::{PreparedPlan, Progress};
pub use request::*;
pub use result::*;
