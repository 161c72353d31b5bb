//! The tasks `comparison` and `benchmark`: methods compared over many seeded runs.

mod prepare;
mod ranking;
mod request;
mod result;
mod row;
mod run;
mod trace;

pub(super) use prepare::{PreparedStudy, prepare_benchmark, prepare_comparison, refuse_tcp_limit};
pub use ranking::Standing;
pub use request::{
    BenchmarkTask, ComparedProblem, ComparisonTask, MAX_DIMENSION, MAX_METHODS, MAX_PROBLEMS,
    MAX_RUNS, MethodChoice,
};
pub use result::{
    BestRun, ComparisonResult, CurvePoint, EvaluationQuartiles, KnownOptimum, MethodResult,
    ProblemResult,
};
pub(super) use run::run;
