//! The task `family`: one problem in many variants, planned as one job.

mod patch;
mod prepare;
mod request;
mod result;
mod run;

pub(super) use prepare::{PreparedFamily, prepare};
pub use request::{FamilyMember, FamilyProblem, FamilyTask, MAX_MEMBERS, SweepAxis};
pub use result::{FamilyResult, MemberFailure, MemberResult, MostBinding};
pub(super) use run::run;
