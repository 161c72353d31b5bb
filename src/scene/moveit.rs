//! Scenes of MoveIt: `moveit_msgs/PlanningScene` as JSON, as bridges and bag converters write it.
//!
//! Read are the world's collision objects with their primitives and the entries of the allowed collision matrix that
//! are set. An object of several primitives becomes several obstacles, `name`, `name.1`, `name.2`. Meshes, planes and cones have no
//! solid here, and attached objects name links of a robot that is not known here: all of them are faults rather than left out.

use serde::Deserialize;
use serde_json::Value;

use super::{Obstacle, Scene, SceneDescription};
use crate::fault::{self, Faults};
use crate::geometry::{Pose, Shape, Transform};

/// `moveit_msgs/PlanningScene`, as far as it matters.
#[derive(Deserialize)]
struct PlanningScene {
    #[serde(default)]
    name: String,
    #[serde(default)]
    world: World,
    #[serde(default)]
    robot_state: RobotState,
    #[serde(default)]
    allowed_collision_matrix: AllowedCollisionMatrix,
}

#[derive(Default, Deserialize)]
struct World {
    #[serde(default)]
    collision_objects: Vec<CollisionObject>,
}

#[derive(Default, Deserialize)]
struct RobotState {
    #[serde(default)]
    attached_collision_objects: Vec<Value>,
}

/// `moveit_msgs/CollisionObject`.
#[derive(Deserialize)]
struct CollisionObject {
    id: String,
    /// Newer messages place the object as a whole, too.
    #[serde(default)]
    pose: RosPose,
    #[serde(default)]
    primitives: Vec<SolidPrimitive>,
    #[serde(default)]
    primitive_poses: Vec<RosPose>,
    #[serde(default)]
    meshes: Vec<Value>,
    #[serde(default)]
    planes: Vec<Value>,
}

/// `shape_msgs/SolidPrimitive`.
#[derive(Deserialize)]
struct SolidPrimitive {
    r#type: u8,
    dimensions: Vec<f64>,
}

/// `geometry_msgs/Pose`.
#[derive(Clone, Copy, Default, Deserialize)]
struct RosPose {
    #[serde(default)]
    position: RosPoint,
    #[serde(default)]
    orientation: RosQuaternion,
}

#[derive(Clone, Copy, Default, Deserialize)]
struct RosPoint {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Clone, Copy, Default, Deserialize)]
struct RosQuaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

#[derive(Default, Deserialize)]
struct AllowedCollisionMatrix {
    #[serde(default)]
    entry_names: Vec<String>,
    #[serde(default)]
    entry_values: Vec<AllowedCollisionEntry>,
}

#[derive(Deserialize)]
struct AllowedCollisionEntry {
    enabled: Vec<bool>,
}

impl Scene {
    /// Reads a planning scene of MoveIt, `value` being `moveit_msgs/PlanningScene` as JSON.
    ///
    /// # Errors
    ///
    /// All faults together, their pointers into `value`.
    pub fn from_moveit(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let Some(scene) = fault::read::<PlanningScene>(value, "", &mut faults) else {
            return faults.into_result(Self::default());
        };
        let mut description = SceneDescription::default();
        let usable = scene.name.starts_with(|c: char| c.is_ascii_lowercase());
        if usable {
            description.name.clone_from(&scene.name);
        }
        for (index, object) in scene.world.collision_objects.iter().enumerate() {
            let pointer = format!("/world/collision_objects/{index}");
            object.read(&pointer, &mut description.obstacles, &mut faults);
        }
        if !scene.robot_state.attached_collision_objects.is_empty() {
            let detail = "attached objects are not read; give them as `attached`, by link number";
            faults.add("/robot_state/attached_collision_objects", detail);
        }
        description.allowed_pairs = scene.allowed_collision_matrix.pairs();
        let description = faults.into_result(description)?;
        Self::new(description)
    }
}

impl CollisionObject {
    fn read(&self, pointer: &str, obstacles: &mut Vec<Obstacle>, faults: &mut Faults) {
        for (list, count) in [("meshes", self.meshes.len()), ("planes", self.planes.len())] {
            if count > 0 {
                let detail =
                    format!("{count} {list} of {:?}, but only primitives are read", self.id);
                faults.add(format!("{pointer}/{list}"), detail);
            }
        }
        for (index, primitive) in self.primitives.iter().enumerate() {
            let Some(shape) = primitive.shape() else {
                let detail = format!(
                    "primitive of type {} with {} dimensions of {:?} is no box (1), sphere (2) or cylinder (3)",
                    primitive.r#type,
                    primitive.dimensions.len(),
                    self.id
                );
                faults.add(format!("{pointer}/primitives/{index}"), detail);
                continue;
            };
            let local = self.primitive_poses.get(index).copied().unwrap_or_default();
            let pose = Transform::from(&self.pose.pose()) * Transform::from(&local.pose());
            let name = if index == 0 { self.id.clone() } else { format!("{}.{index}", self.id) };
            obstacles.push(Obstacle { name, shape, pose: Pose::from(&pose) });
        }
    }
}

impl SolidPrimitive {
    fn shape(&self) -> Option<Shape> {
        match (self.r#type, &self.dimensions[..]) {
            (1, &[x, y, z]) => Some(Shape::Box { size: [x, y, z] }),
            (2, &[radius]) => Some(Shape::Sphere { radius }),
            (3, &[length, radius]) => Some(Shape::Cylinder { radius, length }),
            _ => None,
        }
    }
}

impl RosPose {
    /// A quaternion of zeros is ROS's way to leave the orientation out.
    fn pose(&self) -> Pose {
        let RosQuaternion { x, y, z, w } = self.orientation;
        let position = [self.position.x, self.position.y, self.position.z];
        let given = [x, y, z, w] != [0.0; 4];
        Pose { position, orientation: if given { [x, y, z, w] } else { [0.0, 0.0, 0.0, 1.0] } }
    }
}

impl AllowedCollisionMatrix {
    fn pairs(&self) -> Vec<[String; 2]> {
        let mut pairs = Vec::new();
        for (row, (name, entry)) in self.entry_names.iter().zip(&self.entry_values).enumerate() {
            for (other, enabled) in self.entry_names.iter().zip(&entry.enabled).take(row) {
                if *enabled {
                    pairs.push([other.clone(), name.clone()]);
                }
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn primitives_stand_where_object_and_primitive_poses_put_them() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let scene = Scene::from_moveit(json!({
            "name": "kitchen", "is_diff": false,
            "world": {"collision_objects": [{
                "id": "shelf", "operation": 0,
                "pose": {"position": {"x": 1, "y": 0, "z": 0},
                    "orientation": {"x": 0, "y": 0, "z": half, "w": half}},
                "primitives": [{"type": 1, "dimensions": [0.2, 0.4, 0.6]}, {"type": 3, "dimensions": [0.5, 0.1]}],
                "primitive_poses": [{"position": {"x": 0.5, "y": 0, "z": 0}}, {}],
            }]},
            "allowed_collision_matrix": {"entry_names": ["shelf", "link_0"],
                "entry_values": [{"enabled": [false, true]}, {"enabled": [true, false]}]},
        }))
        .unwrap();
        let [shelf, post] = scene.obstacles() else { panic!("two obstacles") };
        assert_eq!((shelf.name.as_str(), post.name.as_str()), ("shelf", "shelf.1"));
        assert_eq!(shelf.shape, Shape::Box { size: [0.2, 0.4, 0.6] });
        assert_eq!(post.shape, Shape::Cylinder { radius: 0.1, length: 0.5 });
        for (value, expected) in shelf.pose.position.iter().zip([1.0, 0.5, 0.0]) {
            assert!((value - expected).abs() < 1e-12);
        }
        assert_eq!(scene.allowed_pairs(), [["shelf".to_owned(), "link_0".to_owned()]]);
    }

    #[test]
    fn what_cannot_be_read_is_told_rather_than_left_out() {
        let faults = Scene::from_moveit(json!({
            "world": {"collision_objects": [{"id": "can", "meshes": [{}],
                "primitives": [{"type": 4, "dimensions": [1, 2]}]}]},
            "robot_state": {"attached_collision_objects": [{}]},
        }))
        .unwrap_err();
        let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(
            pointers,
            [
                "/world/collision_objects/0/meshes",
                "/world/collision_objects/0/primitives/0",
                "/robot_state/attached_collision_objects"
            ]
        );
    }
}
