//! How far a pose is from another one.

use nalgebra::{Vector3, Vector6};

use crate::geometry::Transform;

/// How far a pose is from the wanted one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// m.
    pub position: f64,
    /// Angle of the turn between the two, rad.
    pub orientation: f64,
}

impl PoseError {
    /// What counts as reached if nobody says: 0.1 mm and 1 mrad. Arms with six joints are exact to rounding; for
    /// arms with fewer joints a pose written with few digits is never exactly reachable.
    pub const TOLERANCE: Self = Self { position: 1e-4, orientation: 1e-3 };

    /// Between where the tool is and where it should be.
    pub fn between(tool: &Transform, target: &Transform) -> Self {
        let error = error_between(tool, target);
        let [position, orientation] =
            [0, 3].map(|row| Vector3::from(error.fixed_rows::<3>(row)).norm());
        Self { position, orientation }
    }

    /// True if both are within `tolerance`.
    pub fn within(&self, tolerance: &Self) -> bool {
        self.position <= tolerance.position && self.orientation <= tolerance.orientation
    }

    /// What is looked for first: only where nothing is as near as this, the caller's tolerance counts.
    pub(super) const EXACT: Self = Self { position: 1e-10, orientation: 1e-10 };

    pub(super) fn largest(&self) -> f64 {
        self.position.max(self.orientation)
    }
}

/// The way from `tool` to `target`: the offset (m), then the turn as a vector along its axis (rad).
pub(super) fn error_between(tool: &Transform, target: &Transform) -> Vector6<f64> {
    let offset = target.origin - tool.origin;
    let axis = (tool.x.cross(&target.x) + tool.y.cross(&target.y) + tool.z.cross(&target.z)) * 0.5;
    let cos = 0.5 * (tool.x.dot(&target.x) + tool.y.dot(&target.y) + tool.z.dot(&target.z) - 1.0);
    let sin = axis.norm();
    let turn = if sin > 1e-6 {
        axis * (libm::atan2(sin, cos) / sin)
    } else if cos > 0.0 {
        axis
    } else {
        let half = half_turn(tool, target);
        half * libm::atan2(sin, cos).copysign(half.dot(&axis))
    };
    Vector6::new(offset.x, offset.y, offset.z, turn.x, turn.y, turn.z)
}

/// The axis of a half turn: twice its projection is the identity plus the rotation.
fn half_turn(tool: &Transform, target: &Transform) -> Vector3<f64> {
    let rotation = target.rotation() * tool.rotation().transpose();
    let columns =
        [0, 1, 2].map(|index| Vector3::from(rotation.column(index)) + Vector3::ith(index, 1.0));
    columns.into_iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default().normalize()
}
