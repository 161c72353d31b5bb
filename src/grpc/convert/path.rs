//! The path of a point: what is asked for and what comes out.

use super::{MessageForm, Place};
use crate::fault::Faults;
use crate::grpc::proto;
use crate::plan::{
    BallObstacle, BezierPiece, BoxObstacle, Obstacle, PathResult, PathTask, PlannerChoice,
    SmoothingChoice, Space, TreeEdge,
};

message_form!(PathTask {
    space: Required,
    start,
    goal,
    planner: Defaulted,
    smoothing: Defaulted,
    trees,
});

message_form!(Space { lower, upper, obstacles });

message_form!(BallObstacle { center, radius });

message_form!(BoxObstacle { lower, upper });

message_form!(PlannerChoice { name, parameters });

message_form!(SmoothingChoice { name, parameters });

message_form!(PathResult {
    path,
    smoothed_path,
    curve,
    length,
    smoothed_length,
    straight_length,
    clearance,
    nodes,
    iterations,
    evaluations,
    convergence,
    planner,
    smoothing,
    stop_reason,
    space: Required,
    tree_edges,
    planning_s,
    seed,
    version,
});

message_form!(BezierPiece { control_points });

message_form!(TreeEdge { from, to });

impl MessageForm<proto::Obstacle> for Obstacle {
    fn into_message(self) -> proto::Obstacle {
        use proto::obstacle::Kind;
        let kind = match self {
            Self::Ball(ball) => Kind::Ball(ball.into_message()),
            Self::Box(block) => Kind::Box(block.into_message()),
        };
        proto::Obstacle { kind: Some(kind) }
    }

    fn from_message(message: proto::Obstacle, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::obstacle::Kind;
        // The JSON form has the obstacle's fields beside its `type`.
        match message.kind {
            Some(Kind::Ball(ball)) => Self::Ball(MessageForm::from_message(ball, place, faults)),
            Some(Kind::Box(block)) => Self::Box(MessageForm::from_message(block, place, faults)),
            None => {
                place.fault(faults, "expected an obstacle: ball, box");
                Self::Ball(BallObstacle { center: Vec::new(), radius: 0.0 })
            }
        }
    }
}
