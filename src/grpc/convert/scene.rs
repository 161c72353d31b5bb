//! What stands around a robot.

use super::{MessageForm, Place};
use crate::fault::Faults;
use crate::grpc::proto;
use crate::plan::SceneRef;
use crate::scene::{AttachedObject, Obstacle, SceneDescription};

message_form!(Obstacle as SceneObstacle { name, shape: Required, pose: Defaulted });

message_form!(AttachedObject { name, link, shape: Required, pose: Defaulted });

/// Name of a scene that was given none, as in the JSON form.
const UNNAMED: &str = "unnamed";

impl MessageForm<proto::Scene> for SceneDescription {
    fn into_message(self) -> proto::Scene {
        let Self { name, description, obstacles, attached, allowed_pairs } = self;
        proto::Scene {
            name,
            description,
            obstacles: obstacles.into_message(),
            attached: attached.into_message(),
            allowed_pairs: allowed_pairs.into_message(),
        }
    }

    fn from_message(message: proto::Scene, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Scene { name, description, obstacles, attached, allowed_pairs } = message;
        let pairs = place.field("allowed_pairs");
        Self {
            name: if name.is_empty() { UNNAMED.to_owned() } else { name },
            description,
            obstacles: MessageForm::from_message(obstacles, place.field("obstacles"), faults),
            attached: MessageForm::from_message(attached, place.field("attached"), faults),
            allowed_pairs: MessageForm::from_message(allowed_pairs, pairs, faults),
        }
    }
}

impl MessageForm<proto::NamePair> for [String; 2] {
    fn into_message(self) -> proto::NamePair {
        let [first, second] = self;
        proto::NamePair { first, second }
    }

    fn from_message(message: proto::NamePair, _: Place<'_>, _: &mut Faults) -> Self {
        let proto::NamePair { first, second } = message;
        [first, second]
    }
}

impl MessageForm<proto::SceneRef> for SceneRef {
    fn into_message(self) -> proto::SceneRef {
        use proto::scene_ref::Kind;
        let kind = match self {
            Self::Name(name) => Kind::Name(name),
            Self::Inline(scene) => Kind::Inline(scene.into_message()),
        };
        proto::SceneRef { kind: Some(kind) }
    }

    fn from_message(message: proto::SceneRef, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::scene_ref::Kind;
        match message.kind {
            Some(Kind::Name(name)) => Self::Name(name),
            Some(Kind::Inline(scene)) => {
                Self::Inline(Box::new(SceneDescription::from_message(scene, place, faults)))
            }
            None => {
                place.fault(faults, "expected a scene's name or a scene");
                Self::Name(String::new())
            }
        }
    }
}
