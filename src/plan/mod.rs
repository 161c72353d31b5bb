//! From a `PlanRequest` to a `PlanResult`: synchronous, without I/O.

mod error;
mod limits;
mod objectives;
mod pareto;
mod prepare;
mod prepared;
mod program;
mod request;
mod result;
mod run;
pub mod scenarios;
pub mod verify;
mod waypoints;
mod weighted;

pub use error::{PlanCode, PlanError};
pub use objectives::{ObjectiveWeights, ParetoMethod, ParetoRequest};
pub use pareto::{ParetoAxis, ParetoFront, ParetoPoint};
pub use prepare::{MAX_LEGS, MAX_WAYPOINTS, validate};
pub use prepared::{PreparedPlan, Progress};
pub use request::*;
pub use result::*;
