//! The nearest pose of any chain, by damped least squares within the joint limits.
//!
//! Levenberg-Marquardt with the damping of Sugihara 2011, doi:10.1109/TRO.2011.2148230 (half the squared error and a
//! little more), raised where a step does not help. Joints on a limit that would leave it are held.

use nalgebra::{Cholesky, Matrix6, Vector6};

use super::error::error_between;
use super::range::Range;
use crate::geometry::Transform;
use crate::robot::{Jacobian, Kinematics, LinkFrames, Robot};

/// Most steps from one start.
const STEPS: usize = 60;
/// An error this small (m, and rad) is none.
const EXACT: f64 = 1e-14;
/// The damping that stays when the error is gone: it keeps singular places solvable.
const LEAST_DAMPING: f64 = 1e-9;

/// Working memory of a descent.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    frames: LinkFrames,
    jacobian: Jacobian,
}

impl Scratch {
    pub(super) fn new(kinematics: &Kinematics) -> Self {
        Self { frames: LinkFrames::new(kinematics), jacobian: Jacobian::new(kinematics.dof()) }
    }
}

/// Moves `joints`, which are within `ranges`, to the nearest place where the tool is at `target`, or where its error
/// (m and rad, squared and added) is smallest nearby. Returns that error, not squared.
pub(super) fn descend(
    kinematics: &Kinematics,
    ranges: &[Range],
    target: &Transform,
    joints: &mut [f64],
    scratch: &mut Scratch,
    steps: Option<usize>,
) -> f64 {
    let Scratch { frames, jacobian } = scratch;
    let mut tried = [0.0; Robot::MAX_DOF];
    let tried = &mut tried[..joints.len()];
    kinematics.forward(joints, frames);
    let mut error = error_between(frames.tool(), target);
    let mut raised = 1.0;
    for _ in 0..steps.unwrap_or(STEPS) {
        let squared = error.norm_squared();
        if squared.sqrt() <= EXACT {
            break;
        }
        kinematics.jacobian(frames, jacobian);
        let damping = raised * (0.5 * squared + LEAST_DAMPING * squared.sqrt().min(1.0));
        if !step(jacobian, &error, damping, joints, ranges, tried) {
            break;
        }
        kinematics.forward(tried, frames);
        let next = error_between(frames.tool(), target);
        if next.norm_squared() < squared {
            joints.copy_from_slice(tried);
            let gained = next.norm() < 0.999_999 * squared.sqrt();
            (error, raised) = (next, (0.25_f64 * raised).max(1e-3));
            if !gained {
                break;
            }
        } else {
            if raised > 1e8 {
                break;
            }
            raised *= 8.0;
            kinematics.forward(joints, frames);
        }
    }
    error.norm()
}

/// One damped step from `joints` to `tried`, within `ranges`; false if none is left.
fn step(
    jacobian: &Jacobian,
    error: &Vector6<f64>,
    damping: f64,
    joints: &[f64],
    ranges: &[Range],
    tried: &mut [f64],
) -> bool {
    let columns = || jacobian.matrix().column_iter();
    // A joint that stands on a limit and would leave it takes no part; neither does one that the
    // step found so would take over its limit, from the next round on.
    let mut free = [true; Robot::MAX_DOF];
    for (((free, column), joint), range) in free.iter_mut().zip(columns()).zip(joints).zip(ranges) {
        let uphill = column.dot(error);
        *free = !(*joint <= range.lower && uphill < 0.0 || *joint >= range.upper && uphill > 0.0);
    }
    for _ in 0..3 {
        let mut normal = Matrix6::identity() * damping;
        for (column, _) in columns().zip(&free).filter(|(_, free)| **free) {
            normal.ger(1.0, &column, &column, 1.0);
        }
        let Some(cholesky) = Cholesky::new(normal) else { return false };
        let weights = cholesky.solve(error);
        let mut held = false;
        for (index, column) in columns().enumerate() {
            let change = if free[index] { column.dot(&weights) } else { 0.0 };
            let (moved, range) = (joints[index] + change, &ranges[index]);
            tried[index] = moved.max(range.lower).min(range.upper);
            if free[index] && tried[index] != moved && tried[index] == joints[index] {
                (free[index], held) = (false, true);
            }
        }
        if !held {
            break;
        }
    }
    tried != joints
}
