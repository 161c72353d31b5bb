//! Motions around obstacles: what is asked for and what comes out beside the trajectory.

use super::{Defaulted, MessageForm, Place};
use crate::fault::Faults;
use crate::geometry::Pose;
use crate::grpc::proto;
use crate::plan::{MotionEnd, MotionPath, MotionTask};

message_form!(MotionPath {
    planned,
    path,
    length,
    straight_length,
    nodes,
    iterations,
    checks,
    planner,
    smoothing,
    added_waypoints,
});

/// Interpolation of a motion that names none, as in the JSON form.
const DEFAULT_INTERPOLATION: &str = "jerk_limited";

impl MessageForm<proto::MotionTask> for MotionTask {
    fn into_message(self) -> proto::MotionTask {
        let Self {
            start,
            goal,
            clearance_m,
            planner,
            smoothing,
            interpolation,
            clock,
            optimizer,
            constraint_handling,
            constraints,
            durations,
            duration,
            objective,
        } = self;
        proto::MotionTask {
            start: Some(start.into_message()),
            goal: Some(goal.into_message()),
            clearance_m,
            planner: Some(planner.into_message()),
            smoothing: Some(smoothing.into_message()),
            interpolation,
            clock: clock.into_message(),
            optimizer: Some(optimizer.into_message()),
            constraint_handling: constraint_handling.into_message(),
            constraints: constraints.into_message(),
            durations: durations.into_message(),
            duration: duration.into_message(),
            objective: objective.into_message(),
        }
    }

    fn from_message(message: proto::MotionTask, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::MotionTask {
            start,
            goal,
            clearance_m,
            planner,
            smoothing,
            interpolation,
            clock,
            optimizer,
            constraint_handling,
            constraints,
            durations,
            duration,
            objective,
        } = message;
        let Defaulted(planner) = MessageForm::from_message(planner, place.field("planner"), faults);
        let Defaulted(smoothing) =
            MessageForm::from_message(smoothing, place.field("smoothing"), faults);
        let Defaulted(optimizer) =
            MessageForm::from_message(optimizer, place.field("optimizer"), faults);
        let handling = place.field("constraint_handling");
        // What is absent has no kind, and that is the fault told.
        let (start, goal) = (start.unwrap_or_default(), goal.unwrap_or_default());
        Self {
            start: MessageForm::from_message(start, place.field("start"), faults),
            goal: MessageForm::from_message(goal, place.field("goal"), faults),
            clearance_m,
            planner,
            smoothing,
            interpolation: match interpolation.is_empty() {
                true => DEFAULT_INTERPOLATION.to_owned(),
                false => interpolation,
            },
            clock: MessageForm::from_message(clock, place.field("clock"), faults),
            optimizer,
            constraint_handling: MessageForm::from_message(constraint_handling, handling, faults),
            constraints: MessageForm::from_message(constraints, place.field("constraints"), faults),
            durations: MessageForm::from_message(durations, place.field("durations"), faults),
            duration: MessageForm::from_message(duration, place.field("duration"), faults),
            objective: MessageForm::from_message(objective, place.field("objective"), faults),
        }
    }
}

impl MessageForm<proto::MotionEnd> for MotionEnd {
    fn into_message(self) -> proto::MotionEnd {
        use proto::motion_end::Kind;
        let kind = match self {
            Self::Joints(joints) => Kind::Joints(joints.into_message()),
            Self::Pose(pose) => Kind::Pose(pose.into_message()),
        };
        proto::MotionEnd { kind: Some(kind) }
    }

    fn from_message(message: proto::MotionEnd, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::motion_end::Kind;
        match message.kind {
            Some(Kind::Joints(joints)) => {
                Self::Joints(MessageForm::from_message(joints, place.field("joints"), faults))
            }
            Some(Kind::Pose(pose)) => {
                Self::Pose(MessageForm::from_message(pose, place.field("pose"), faults))
            }
            None => {
                place.fault(faults, "expected joints or a pose");
                Self::Pose(Pose::default())
            }
        }
    }
}
