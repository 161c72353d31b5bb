//! The JSON form of a scene: what users send, store and read back.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::{Pose, Shape};

/// A scene as JSON. Units are SI: m, and unit quaternions `[x, y, z, w]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct SceneDescription {
    /// Name: 1 to 64 of `a-z 0-9 _ . -`, a letter first; default `unnamed`.
    #[serde(default = "unnamed")]
    #[schema(example = "cell-3")]
    pub name: String,
    /// What the scene shows, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// What stands around the robot.
    #[serde(default)]
    pub obstacles: Vec<Obstacle>,
    /// What the robot carries: tools and parts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attached: Vec<AttachedObject>,
    /// Pairs that may touch: names of obstacles, attached objects, the robot's links (`link_0` is the base, `link_2` the
    /// frame after joint 2) or its bodies; a body stands for its link.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed_pairs: Vec<[String; 2]>,
}

fn unnamed() -> String {
    "unnamed".to_owned()
}

impl Default for SceneDescription {
    /// Nothing at all.
    fn default() -> Self {
        Self {
            name: unnamed(),
            description: None,
            obstacles: Vec::new(),
            attached: Vec::new(),
            allowed_pairs: Vec::new(),
        }
    }
}

/// Something that stands still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SceneObstacle)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Obstacle {
    /// Name, unique within the scene.
    #[schema(min_length = 1, max_length = 64)]
    pub name: String,
    /// The solid.
    pub shape: Shape,
    /// Of the solid's origin and axes in the world; default the identity.
    #[serde(default)]
    pub pose: Pose,
}

/// Something that moves with a link of the robot, and may touch that link or, where it has no body, the nearest one before
/// it that has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct AttachedObject {
    /// Name, unique within the scene.
    #[schema(min_length = 1, max_length = 64)]
    pub name: String,
    /// The link: 0 is the base, i the frame after joint i; default the tool's frame, which moves with the last link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<usize>,
    /// The solid.
    pub shape: Shape,
    /// Of the solid's origin and axes in the link's frame; default the identity.
    #[serde(default)]
    pub pose: Pose,
}
