//! What was planned.

use super::{MessageForm, Place};
use crate::budget::StopReason;
use crate::fault::Faults;
use crate::grpc::proto;
use crate::optimize::ConvergencePoint;
use crate::plan::{
    Binding, ComparisonResult, FamilyResult, JointOptimum, LegResult, ParetoAxis, ParetoFront,
    ParetoPoint, PathResult, PlanMetrics, PlanResult, ProgramResult, Sensitivity, TrajectoryResult,
};
use crate::trajectory::objective::Measures;
use crate::trajectory::{
    Certificate, Clearance, JointCertificate, LowerBound, Peak, PositionRange, Trajectory,
    Violation,
};

message_form!(TrajectoryResult {
    robot,
    joint_names,
    joint_units,
    duration,
    durations,
    waypoint_times,
    waypoints,
    trajectory: Required,
    certificate: Required,
    bound,
    metrics: Required,
    motion,
    pareto,
    per_joint,
    convergence,
    interpolation,
    optimizer,
    stop_reason,
    iterations,
    evaluations,
    planning_s,
    seed,
    version,
});

message_form!(ProgramResult {
    robot,
    joint_names,
    duration,
    lawful,
    worst_ratio,
    legs,
    evaluations,
    planning_s,
    seed,
    version,
});

message_form!(LegResult { name, note, start, result: Required });

message_form!(PlanMetrics {
    initial_duration,
    saved,
    rms_jerk,
    mean_utilisation,
    path_length,
    binding,
    objective: Defaulted,
    reference,
    sensitivities,
    without_tcp_limit,
});

message_form!(Measures { time, rms_jerk, energy });

message_form!(ParetoFront { objectives, method, points });

message_form!(ParetoAxis { name, unit });

message_form!(ParetoPoint { values, durations, worst_ratio });

message_form!(Binding { segment, joint, limit });

message_form!(Sensitivity { joint, limit, seconds_per_percent });

message_form!(JointOptimum { joint, durations, duration, evaluations });

message_form!(ConvergencePoint { iteration, evaluations, elapsed_s, best, mean });

message_enum!(
    StopReason { Converged, Solved, IterationLimit, EvaluationLimit, TimeLimit, Cancelled, Interrupted },
    unspecified: None
);

message_form!(Trajectory { breakpoints, pieces });

message_form!(Certificate {
    lawful,
    worst_ratio,
    continuity,
    starts_at_rest,
    ends_at_rest,
    joints,
    violations,
    waypoint_error,
    clearance,
    sha256,
    tcp_speed,
    via_tolerance,
});

message_form!(JointCertificate {
    name,
    position: Required,
    velocity: Required,
    acceleration: Required,
    jerk: Required,
});

message_form!(Peak { peak, at, limit, ratio, provenance });

message_form!(PositionRange { min, min_at, max, max_at, lower, upper, provenance });

message_form!(Violation { joint, limit, at, value, limit_value, detail });

message_form!(LowerBound { lower, gap, method });

impl MessageForm<proto::PlanResult> for PlanResult {
    fn into_message(self) -> proto::PlanResult {
        use proto::plan_result::Kind;
        let kind = match self {
            Self::Trajectory(result) => Kind::Trajectory(result.into_message()),
            Self::Program(result) => Kind::Program(result.into_message()),
            Self::Path(result) => Kind::Path(result.into_message()),
            Self::Family(result) => Kind::Family(result.into_message()),
            Self::Comparison(result) => Kind::Comparison(result.into_message()),
        };
        proto::PlanResult { kind: Some(kind) }
    }

    fn from_message(message: proto::PlanResult, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::plan_result::Kind;
        let kind = message.kind.unwrap_or_else(|| {
            place.fault(
                faults,
                "expected a trajectory, a program, a path, a family or a comparison",
            );
            Kind::Program(proto::ProgramResult::default())
        });
        match kind {
            Kind::Trajectory(result) => {
                let result = TrajectoryResult::from_message(result, place, faults);
                Self::Trajectory(Box::new(result))
            }
            Kind::Program(result) => {
                Self::Program(ProgramResult::from_message(result, place, faults))
            }
            Kind::Path(result) => {
                Self::Path(Box::new(PathResult::from_message(result, place, faults)))
            }
            Kind::Family(result) => Self::Family(FamilyResult::from_message(result, place, faults)),
            Kind::Comparison(result) => {
                Self::Comparison(ComparisonResult::from_message(result, place, faults))
            }
        }
    }
}

impl MessageForm<proto::Piece> for Vec<Vec<f64>> {
    fn into_message(self) -> proto::Piece {
        let joints = self.into_iter();
        let joints = joints.map(|coefficients| proto::Polynomial { coefficients }).collect();
        proto::Piece { joints }
    }

    fn from_message(message: proto::Piece, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Piece { joints } = message;
        let read = |(joint, message)| {
            let proto::Polynomial { coefficients } = message;
            MessageForm::from_message(coefficients, place.element(joint), faults)
        };
        joints.into_iter().enumerate().map(read).collect()
    }
}

impl MessageForm<proto::Clearance> for Clearance {
    fn into_message(self) -> proto::Clearance {
        let Self { smallest_m, at, pair } = self;
        proto::Clearance { smallest_m, at, pair: pair.into() }
    }

    fn from_message(message: proto::Clearance, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Clearance { smallest_m, at, pair } = message;
        let pair = pair.try_into().unwrap_or_else(|pair: Vec<String>| {
            place.field("pair").fault(faults, format!("{} bodies instead of 2", pair.len()));
            Default::default()
        });
        Self {
            smallest_m: MessageForm::from_message(smallest_m, place.field("smallest_m"), faults),
            at: MessageForm::from_message(at, place.field("at"), faults),
            pair,
        }
    }
}
