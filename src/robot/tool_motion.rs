//! How fast the tool moves, and how sharply it can change that.

use nalgebra::Vector3;

use super::kinematics::{Jacobian, Kinematics};

/// What one joint does at most during some interval of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointRange {
    /// Largest distance from position zero, rad or m.
    pub position: f64,
    /// Largest magnitudes of velocity, acceleration and jerk.
    pub derivatives: [f64; 3],
}

/// Bounds on a link's angular velocity and its first two derivatives, rad/s to rad/s³.
///
/// With `omega` its angular velocity, a vector `r` that is fixed in the link changes by
///
/// ```text
/// r'   = omega × r
/// r''  = omega' × r + omega × r'
/// r''' = omega'' × r + 2 omega' × r' + omega × r''
/// ```
///
/// so that, with bounds `W`, `A` and `B`, per unit of its length `|r'| <= W`, `|r''| <= A + W²` and
/// `|r'''| <= B + 3 A W + W³`.
#[derive(Clone, Copy, Default)]
struct Turning {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

impl Turning {
    /// How fast a unit vector fixed in the link changes: bounds on its three derivatives.
    fn of_a_unit_vector(&self) -> [f64; 3] {
        let Self { velocity: w, acceleration: a, jerk: b } = *self;
        [w, a + w * w, b + 3.0 * a * w + w * w * w]
    }

    /// The next link's, which turns about an axis fixed in this one.
    ///
    /// Its angular velocity is `omega + z q'`; differentiated twice, with the derivatives of `z` above.
    fn beyond(&self, [velocity, acceleration, jerk]: [f64; 3]) -> Self {
        let [z1, z2, _] = self.of_a_unit_vector();
        Self {
            velocity: self.velocity + velocity,
            acceleration: self.acceleration + acceleration + z1 * velocity,
            jerk: self.jerk + jerk + 2.0 * z1 * acceleration + z2 * velocity,
        }
    }
}

impl Kinematics {
    /// The velocity of the tool's origin in the world, m/s, from the Jacobian that
    /// [`jacobian`](Self::jacobian) left and the joints' velocities (rad/s or m/s).
    ///
    /// # Panics
    ///
    /// If `jacobian` or `velocities` has another number of joints.
    pub fn tool_velocity(&self, jacobian: &Jacobian, velocities: &[f64]) -> Vector3<f64> {
        assert_eq!(velocities.len(), self.dof(), "one velocity per joint");
        let columns = jacobian.matrix().column_iter().zip(velocities);
        columns.fold(Vector3::zeros(), |sum, (column, velocity)| {
            sum + Vector3::new(column[0], column[1], column[2]) * *velocity
        })
    }

    /// A bound on the magnitude of the third derivative of the tool's position, m/s³, while the joints
    /// stay within `joints`, whatever their configuration.
    ///
    /// The tool's position is a sum of vectors: per link its constant offsets before and beyond the joint, one along the
    /// joint's axis, and the tool's offset. Each is fixed in a link or, at a prismatic joint, changes its length along an axis that is. The
    /// bound adds up what each can contribute; how a link turns follows from joint to joint.
    ///
    /// # Panics
    ///
    /// If `joints` has another number of joints.
    pub fn tool_jerk_bound(&self, joints: &[JointRange]) -> f64 {
        assert_eq!(joints.len(), self.dof(), "one range per joint");
        let mut turning = Turning::default();
        let mut bound = 0.0;
        for link in &self.links {
            let JointRange { position, derivatives } = joints[link.joint];
            let derivatives = derivatives.map(|derivative| derivative * link.ratio.abs());
            let [v, a, j] = derivatives;
            let [z1, z2, z3] = turning.of_a_unit_vector();
            bound += link.before.length() * z3;
            if link.slides {
                let length = link.d.abs() + position * link.ratio.abs();
                bound += length * z3 + 3.0 * v * z2 + 3.0 * a * z1 + j;
            } else {
                bound += link.d.abs() * z3;
                turning = turning.beyond(derivatives);
            }
            bound += link.after.length() * turning.of_a_unit_vector()[2];
        }
        bound + self.flange_from_tool.length() * turning.of_a_unit_vector()[2]
    }
}
