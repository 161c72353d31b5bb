//! From a `PlanRequest` to a `PlanResult`.

mod request;
mod result;

pub use request::*;
pub use result::*;
