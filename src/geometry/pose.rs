//! Rigid poses: as JSON for people and programs, as axes for arithmetic.

use std::ops::Mul;

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Where something is and how it is turned, in the frame it is given in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Pose {
    /// Position `[x, y, z]`, m; default the origin.
    #[serde(default)]
    #[schema(min_items = 3, max_items = 3)]
    pub position: [f64; 3],
    /// Unit quaternion `[x, y, z, w]`; default no rotation.
    #[serde(default = "no_rotation")]
    #[schema(min_items = 4, max_items = 4)]
    pub orientation: [f64; 4],
}

fn no_rotation() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

impl Default for Pose {
    /// The identity.
    fn default() -> Self {
        Self { position: [0.0; 3], orientation: no_rotation() }
    }
}

/// A rigid transform, kept as the axes and the origin of the frame it leads to.
///
/// `world_from_tool` holds the tool's x, y and z axes and its origin, all in
/// world coordinates. Transforms compose by sight:
/// `world_from_tool = world_from_flange * flange_from_tool`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Unit vector along x.
    pub x: Vector3<f64>,
    /// Unit vector along y.
    pub y: Vector3<f64>,
    /// Unit vector along z.
    pub z: Vector3<f64>,
    /// Origin, m.
    pub origin: Vector3<f64>,
}

impl Transform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self {
        x: Vector3::new(1.0, 0.0, 0.0),
        y: Vector3::new(0.0, 1.0, 0.0),
        z: Vector3::new(0.0, 0.0, 1.0),
        origin: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Turns a direction into the outer frame.
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.x * direction.x + self.y * direction.y + self.z * direction.z
    }

    /// Takes a point into the outer frame, m.
    pub fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.direction(point)
    }

    /// Turns a direction of the outer frame into this one.
    pub fn inverse_direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.x.dot(direction), self.y.dot(direction), self.z.dot(direction))
    }

    /// Takes a point of the outer frame into this one, m.
    pub fn inverse_point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.inverse_direction(&(point - self.origin))
    }

    /// A turn about `axis`, a unit vector through the origin, by the angle with sine and cosine `(sin, cos)`.
    pub fn about(axis: &Vector3<f64>, (sin, cos): (f64, f64)) -> Self {
        let column = |unit: Vector3<f64>| {
            unit * cos + axis.cross(&unit) * sin + axis * (axis.dot(&unit) * (1.0 - cos))
        };
        Self {
            x: column(Vector3::x()),
            y: column(Vector3::y()),
            z: column(Vector3::z()),
            origin: Vector3::zeros(),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let turned = self.rotation().transpose();
        let axis = |index: usize| Vector3::from(turned.column(index));
        Self { x: axis(0), y: axis(1), z: axis(2), origin: -(turned * self.origin) }
    }

    /// The rotation matrix, its columns the axes.
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[self.x, self.y, self.z])
    }
}

impl Mul for Transform {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self {
            x: self.direction(&inner.x),
            y: self.direction(&inner.y),
            z: self.direction(&inner.z),
            origin: self.point(&inner.origin),
        }
    }
}

impl From<&Pose> for Transform {
    /// Normalises the orientation on the way; its norm must not be zero.
    fn from(pose: &Pose) -> Self {
        let [x, y, z, w] = pose.orientation;
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Self {
            x: rotation * Vector3::x(),
            y: rotation * Vector3::y(),
            z: rotation * Vector3::z(),
            origin: Vector3::from(pose.position),
        }
    }
}

impl From<&Transform> for Pose {
    /// Of the two quaternions of a rotation, the one whose `w` is not negative.
    fn from(transform: &Transform) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(transform.rotation());
        let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
        let sign = if quaternion.w < 0.0 { -1.0 } else { 1.0 };
        let orientation = [quaternion.i, quaternion.j, quaternion.k, quaternion.w];
        Self {
            position: transform.origin.into(),
            orientation: orientation.map(|component| sign * component),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter_turn_about_z() -> Pose {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Pose { position: [1.0, 2.0, 3.0], orientation: [0.0, 0.0, half, half] }
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let transform = Transform::from(&quarter_turn_about_z());
        assert!((transform.x - Vector3::y()).norm() < 1e-15);
        assert!((transform.y + Vector3::x()).norm() < 1e-15);
        let point = transform.point(&Vector3::new(1.0, 0.0, 0.0));
        assert!((point - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-15);
    }

    #[test]
    fn composing_applies_the_right_hand_side_first() {
        let outer = Transform::from(&quarter_turn_about_z());
        let inner = Transform { origin: Vector3::new(0.5, 0.0, 0.0), ..Transform::IDENTITY };
        let both = outer * inner;
        assert!((both.origin - Vector3::new(1.0, 2.5, 3.0)).norm() < 1e-15);
        assert!((both.rotation() - outer.rotation()).norm() < 1e-15);
    }

    #[test]
    fn poses_survive_the_way_through_a_transform() {
        for orientation in [
            [0.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.5, -0.5, 0.5, 0.5],
            [0.36, 0.48, 0.8, 0.0],
            [0.1, 0.1, 0.7, 0.7],
        ] {
            let pose = Pose { position: [0.1, -0.2, 0.3], orientation };
            let back = Pose::from(&Transform::from(&pose));
            assert_eq!(back.position, pose.position);
            for (left, right) in back.orientation.iter().zip(pose.orientation) {
                assert!((left - right).abs() < 1e-15, "{back:?} is not {pose:?}");
            }
        }
    }

    #[test]
    fn the_same_rotation_is_always_written_alike() {
        let pose = Pose { orientation: [-0.5, 0.5, -0.5, -0.5], ..Pose::default() };
        let back = Pose::from(&Transform::from(&pose));
        assert!(back.orientation[3] > 0.0);
    }

    #[test]
    fn an_empty_object_is_the_identity() {
        let pose: Pose = serde_json::from_str("{}").unwrap();
        assert_eq!(pose, Pose::default());
        assert_eq!(Transform::from(&pose), Transform::IDENTITY);
    }
}
