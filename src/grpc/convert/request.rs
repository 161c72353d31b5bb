//! What is to be planned.

use super::{MessageForm, Place};
use crate::fault::Faults;
use crate::grpc::proto;
use crate::plan::{
    Clock, ConstraintHandling, Constraints, DurationGoal, DurationRange, EndMotion, Leg,
    LimitOverride, LimitOverrides, LimitScale, LimitValues, ObjectiveWeights, OptimizerChoice,
    ParetoMethod, ParetoRequest, PlanRequest, PoseWaypoint, ProgramTask, RobotRef, TASKS, Task,
    ViaTolerance, Waypoint, WaypointsTask,
};
use crate::robot::RobotDescription;
use crate::trajectory::objective::ObjectiveName;

message_form!(PlanRequest { robot, scene, task: Required, seed, limits, limit_scale });

message_form!(ProgramTask { legs });

message_form!(Leg { name, note, task: Required });

message_form!(OptimizerChoice { name, parameters });

message_form!(DurationRange { min, max });

message_form!(EndMotion { velocity, acceleration });

message_form!(ObjectiveWeights { time, rms_jerk, energy });

message_form!(ParetoRequest { objectives, points, method, max_stretch, population, generations });

message_enum!(ObjectiveName { Time, RmsJerk, Energy }, unspecified: None);

message_enum!(
    ParetoMethod { EpsilonConstraint, Nsga2 },
    unspecified: Some(Self::default())
);

message_form!(LimitOverrides { lower, upper, velocity, acceleration, jerk, tcp_speed });

message_form!(LimitScale { velocity, acceleration, jerk });

message_enum!(Clock { Shared, PerJoint }, unspecified: Some(Self::default()));

message_enum!(
    ConstraintHandling { RepairUniform, RepairSegment, Penalty, Reject },
    unspecified: Some(Self::default())
);

message_enum!(Constraints { Full, VelocityOnly }, unspecified: Some(Self::default()));

impl MessageForm<proto::RobotRef> for RobotRef {
    fn into_message(self) -> proto::RobotRef {
        use proto::robot_ref::Kind;
        let kind = match self {
            Self::Name(name) => Kind::Name(name),
            Self::Inline(robot) => Kind::Inline(robot.into_message()),
        };
        proto::RobotRef { kind: Some(kind) }
    }

    fn from_message(message: proto::RobotRef, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::robot_ref::Kind;
        match message.kind {
            Some(Kind::Name(name)) => Self::Name(name),
            // The JSON form has the robot in the name's place.
            Some(Kind::Inline(robot)) => {
                Self::Inline(Box::new(RobotDescription::from_message(robot, place, faults)))
            }
            None => {
                place.fault(faults, "expected a robot's name or a robot");
                Self::Name(String::new())
            }
        }
    }
}

impl MessageForm<proto::Task> for Task {
    fn into_message(self) -> proto::Task {
        use proto::task::Kind;
        let kind = match self {
            Self::Waypoints(task) => Kind::Waypoints(task.into_message()),
            Self::Path(task) => Kind::Path(task.into_message()),
            Self::Motion(task) => Kind::Motion(task.into_message()),
            Self::Program(task) => Kind::Program(task.into_message()),
            Self::Family(task) => Kind::Family(task.into_message()),
            Self::Comparison(task) => Kind::Comparison(task.into_message()),
            Self::Benchmark(task) => Kind::Benchmark(task.into_message()),
        };
        proto::Task { kind: Some(kind) }
    }

    fn from_message(message: proto::Task, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::task::Kind;
        // The JSON form has the task's fields beside its `type`.
        match message.kind {
            Some(Kind::Waypoints(task)) => {
                Self::Waypoints(MessageForm::from_message(task, place, faults))
            }
            Some(Kind::Path(task)) => Self::Path(MessageForm::from_message(task, place, faults)),
            Some(Kind::Motion(task)) => {
                Self::Motion(MessageForm::from_message(task, place, faults))
            }
            Some(Kind::Program(task)) => {
                Self::Program(MessageForm::from_message(task, place, faults))
            }
            Some(Kind::Family(task)) => {
                Self::Family(MessageForm::from_message(task, place, faults))
            }
            Some(Kind::Comparison(task)) => {
                Self::Comparison(MessageForm::from_message(task, place, faults))
            }
            Some(Kind::Benchmark(task)) => {
                Self::Benchmark(MessageForm::from_message(task, place, faults))
            }
            None => {
                place.fault(faults, format!("expected a task: {}", TASKS.join(", ")));
                Self::Program(ProgramTask { legs: Vec::new() })
            }
        }
    }
}

/// Interpolation of a task that names none, as in the JSON form.
const DEFAULT_INTERPOLATION: &str = "quintic";

impl MessageForm<proto::WaypointsTask> for WaypointsTask {
    fn into_message(self) -> proto::WaypointsTask {
        let Self {
            waypoints,
            interpolation,
            clock,
            optimizer,
            constraint_handling,
            constraints,
            durations,
            duration,
            objective,
            pareto,
            fixed_durations,
            start,
            goal,
            via_tolerance,
        } = self;
        proto::WaypointsTask {
            waypoints: waypoints.into_message(),
            interpolation,
            clock: clock.into_message(),
            optimizer: Some(optimizer.into_message()),
            constraint_handling: constraint_handling.into_message(),
            constraints: constraints.into_message(),
            durations: durations.into_message(),
            duration: duration.into_message(),
            objective: objective.into_message(),
            pareto: pareto.into_message(),
            fixed_durations: fixed_durations.into_message(),
            start: start.into_message(),
            goal: goal.into_message(),
            via_tolerance: via_tolerance.into_message(),
        }
    }

    fn from_message(message: proto::WaypointsTask, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::WaypointsTask {
            waypoints,
            interpolation,
            clock,
            optimizer,
            constraint_handling,
            constraints,
            durations,
            duration,
            objective,
            pareto,
            fixed_durations,
            start,
            goal,
            via_tolerance,
        } = message;
        let super::Defaulted(optimizer) =
            MessageForm::from_message(optimizer, place.field("optimizer"), faults);
        let interpolation =
            if interpolation.is_empty() { DEFAULT_INTERPOLATION.to_owned() } else { interpolation };
        let handling = place.field("constraint_handling");
        Self {
            waypoints: MessageForm::from_message(waypoints, place.field("waypoints"), faults),
            interpolation,
            clock: MessageForm::from_message(clock, place.field("clock"), faults),
            optimizer,
            constraint_handling: MessageForm::from_message(constraint_handling, handling, faults),
            constraints: MessageForm::from_message(constraints, place.field("constraints"), faults),
            durations: MessageForm::from_message(durations, place.field("durations"), faults),
            duration: MessageForm::from_message(duration, place.field("duration"), faults),
            objective: MessageForm::from_message(objective, place.field("objective"), faults),
            pareto: MessageForm::from_message(pareto, place.field("pareto"), faults),
            fixed_durations: MessageForm::from_message(
                fixed_durations,
                place.field("fixed_durations"),
                faults,
            ),
            start: MessageForm::from_message(start, place.field("start"), faults),
            goal: MessageForm::from_message(goal, place.field("goal"), faults),
            via_tolerance: MessageForm::from_message(
                via_tolerance,
                place.field("via_tolerance"),
                faults,
            ),
        }
    }
}

impl MessageForm<proto::ViaTolerance> for ViaTolerance {
    fn into_message(self) -> proto::ViaTolerance {
        use proto::via_tolerance::Kind;
        let kind = match self {
            Self::All(value) => Kind::All(value),
            Self::PerJoint(values) => Kind::PerJoint(values.into_message()),
        };
        proto::ViaTolerance { kind: Some(kind) }
    }

    fn from_message(message: proto::ViaTolerance, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::via_tolerance::Kind;
        match message.kind {
            Some(Kind::All(value)) => Self::All(f64::from_message(value, place, faults)),
            Some(Kind::PerJoint(values)) => {
                Self::PerJoint(MessageForm::from_message(values, place, faults))
            }
            None => {
                place.fault(faults, "expected one value for all joints or one per joint");
                Self::All(0.0)
            }
        }
    }
}

impl MessageForm<proto::Waypoint> for Waypoint {
    fn into_message(self) -> proto::Waypoint {
        match self {
            Self::Joints(values) => proto::Waypoint { values, pose: None, seed: Vec::new() },
            Self::Pose(PoseWaypoint { pose, seed }) => proto::Waypoint {
                values: Vec::new(),
                pose: Some(pose.into_message()),
                seed: seed.unwrap_or_default(),
            },
        }
    }

    fn from_message(message: proto::Waypoint, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Waypoint { values, pose, seed } = message;
        let Some(pose) = pose else {
            return Self::Joints(MessageForm::from_message(values, place, faults));
        };
        if !values.is_empty() {
            place.fault(faults, "a waypoint has values or a pose, not both");
        }
        let pose = MessageForm::from_message(pose, place.field("pose"), faults);
        let seed: Vec<f64> = MessageForm::from_message(seed, place.field("seed"), faults);
        Self::Pose(PoseWaypoint { pose, seed: (!seed.is_empty()).then_some(seed) })
    }
}

impl MessageForm<proto::Configuration> for Vec<f64> {
    fn into_message(self) -> proto::Configuration {
        proto::Configuration { values: self }
    }

    fn from_message(message: proto::Configuration, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Configuration { values } = message;
        MessageForm::from_message(values, place, faults)
    }
}

impl MessageForm<proto::DurationGoal> for DurationGoal {
    fn into_message(self) -> proto::DurationGoal {
        use proto::duration_goal::Kind;
        let kind = match self {
            Self::Exactly(duration) => Kind::Exactly(duration),
            Self::AtMost(duration) => Kind::AtMost(duration),
        };
        proto::DurationGoal { kind: Some(kind) }
    }

    fn from_message(message: proto::DurationGoal, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::duration_goal::Kind;
        match message.kind {
            Some(Kind::Exactly(duration)) => {
                Self::Exactly(f64::from_message(duration, place.field("exactly"), faults))
            }
            Some(Kind::AtMost(duration)) => {
                Self::AtMost(f64::from_message(duration, place.field("at_most"), faults))
            }
            None => {
                place.fault(faults, "expected exactly or at_most");
                Self::Exactly(0.0)
            }
        }
    }
}

impl MessageForm<Option<proto::LimitOverride>> for LimitOverride {
    fn into_message(self) -> Option<proto::LimitOverride> {
        use proto::limit_override::Kind;
        let kind = match self {
            Self::Keep => return None,
            Self::Remove => Kind::Remove(()),
            Self::Replace(LimitValues::All(value)) => Kind::All(value),
            Self::Replace(LimitValues::PerJoint(values)) => {
                Kind::PerJoint(proto::OptionalNumbers { values: values.into_message() })
            }
        };
        Some(proto::LimitOverride { kind: Some(kind) })
    }

    fn from_message(
        message: Option<proto::LimitOverride>,
        place: Place<'_>,
        faults: &mut Faults,
    ) -> Self {
        use proto::limit_override::Kind;
        let Some(message) = message else { return Self::Keep };
        match message.kind {
            Some(Kind::Remove(())) => Self::Remove,
            Some(Kind::All(value)) => {
                Self::Replace(LimitValues::All(f64::from_message(value, place, faults)))
            }
            Some(Kind::PerJoint(proto::OptionalNumbers { values })) => {
                let values = MessageForm::from_message(values, place, faults);
                Self::Replace(LimitValues::PerJoint(values))
            }
            None => {
                place.fault(faults, "expected remove, all or per_joint");
                Self::Keep
            }
        }
    }
}

impl MessageForm<proto::OptionalNumber> for Option<f64> {
    fn into_message(self) -> proto::OptionalNumber {
        proto::OptionalNumber { value: self }
    }

    fn from_message(message: proto::OptionalNumber, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::OptionalNumber { value } = message;
        MessageForm::from_message(value, place, faults)
    }
}
