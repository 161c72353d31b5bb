//! From a `PlanRequest` to a `PlanResult`: synchronous, without I/O.

pub mod cell;
mod ends;
mod error;
mod family;
mod limits;
mod metrics;
mod motion;
mod objectives;
mod optimum;
mod pareto;
pub mod path;
mod poses;
mod prepare;
mod prepared;
mod program;
mod request;
mod result;
mod run;
pub mod samples;
pub mod scenarios;
mod side_by_side;
mod study;
mod tcp_speed;
mod unsearched;
pub mod verify;
mod via;
mod waypoints;
mod weighted;

pub use error::{PlanCode, PlanError};
pub use family::{
    FamilyMember, FamilyProblem, FamilyResult, FamilyTask, MAX_MEMBERS, MemberFailure,
    MemberResult, MostBinding, SweepAxis,
};
pub use motion::{MotionEnd, MotionPath, MotionTask};
pub use objectives::{ObjectiveWeights, ParetoMethod, ParetoRequest};
pub use pareto::{ParetoAxis, ParetoFront, ParetoPoint};
pub use path::{
    BallObstacle, BezierPiece, BoxObstacle, Obstacle, PathResult, PathTask, PlannerChoice,
    SmoothingChoice, Space, TreeEdge,
};
pub use poses::{PoseWaypoint, Waypoint};
pub use prepare::{MAX_LEGS, MAX_WAYPOINTS, validate};
pub use prepared::{MembersDone, PreparedPlan, Progress};
pub use request::*;
pub use result::*;
pub use study::{
    BenchmarkTask, BestRun, ComparedProblem, ComparisonResult, ComparisonTask, CurvePoint,
    EvaluationQuartiles, KnownOptimum, MAX_DIMENSION, MAX_METHODS, MAX_PROBLEMS, MAX_RUNS,
    MethodChoice, MethodResult, ProblemResult, Standing,
};
