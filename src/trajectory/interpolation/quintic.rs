//! Quintic spline: C4 through any number of waypoints, at rest at both ends
//! with zero acceleration.
//!
//! Unknown are velocity and acceleration at the inner knots; snap and
//! jerk are continuous there. The two conditions are the gradient of the
//! integral of squared jerk, so the block-tridiagonal system is symmetric and
//! positive definite and needs no pivoting, however uneven the durations.

use super::hermite::quintic_piece;
use super::{Interpolation, Timing};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "quintic",
    title: "Quintic spline",
    description: "Quintic spline with velocity and acceleration zero at both ends; position up to \
                  snap are continuous at every inner waypoint.",
    source: "natural spline theory; Han et al. 2022 solve the three-segment case with other end conditions",
    continuity: 4,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: true,
    executable: true,
    timing: Timing::Search(&Quintic),
};

/// The C4 quintic spline.
pub struct Quintic;

impl Family for Quintic {
    const DEGREE: usize = 5;

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        eliminate(joints, durations, work);
        substitute_back(joints, work);
        let (groups, segments) = (joints.groups(), joints.segments());
        for (segment, &h) in durations.iter().enumerate() {
            for group in 0..groups {
                let cell = segment * groups + group;
                let at = |knot: usize| {
                    if knot == 0 || knot == segments {
                        return [Lanes::ZERO; 2];
                    }
                    let [v, a] = work.knots[knot * groups + group];
                    [v * h, a * (h * h)]
                };
                work.pieces[cell] = quintic_piece(
                    joints.start[cell],
                    joints.change[cell],
                    at(segment),
                    at(segment + 1),
                );
            }
        }
    }
}

/// Forward sweep. With `h`, `k` the durations before and after a knot and
/// `x = (v, a)` there, the rows are
/// `Bᵀ(h) x₋ + [192/h³+192/k³, 36/k²-36/h²; ·, 9/h+9/k] x + B(k) x₊
///  = (360 (D/h⁴ + E/k⁴), 60 (E/k³ - D/h³))` with
/// `B(k) = [168/k³, -24/k²; 24/k², -3/k]`.
#[inline(always)]
fn eliminate(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
    let (groups, segments) = (joints.groups(), joints.segments());
    for knot in 1..segments {
        let [h, k] = [1.0 / durations[knot - 1], 1.0 / durations[knot]];
        let [h2, k2] = [h * h, k * k];
        let [h3, k3] = [h2 * h, k2 * k];
        let mut pivot = [192.0 * (h3 + k3), 36.0 * (k2 - h2), 9.0 * (h + k)];
        // L = Bᵀ(h) S⁻¹ of the knot before, row by row.
        let mut lower = [0.0; 4];
        if knot > 1 {
            let [p, q, r, ..] = work.blocks[knot - 1];
            let bt = [168.0 * h3, 24.0 * h2, -24.0 * h2, -3.0 * h];
            lower = [
                bt[0] * p + bt[1] * q,
                bt[0] * q + bt[1] * r,
                bt[2] * p + bt[3] * q,
                bt[2] * q + bt[3] * r,
            ];
            // S = diagonal - L B(h), symmetric.
            let b = [168.0 * h3, -24.0 * h2, 24.0 * h2, -3.0 * h];
            pivot[0] -= lower[0] * b[0] + lower[1] * b[2];
            pivot[1] -= lower[0] * b[1] + lower[1] * b[3];
            pivot[2] -= lower[2] * b[1] + lower[3] * b[3];
        }
        let inverse = 1.0 / (pivot[0] * pivot[2] - pivot[1] * pivot[1]);
        let inverted = [pivot[2] * inverse, -pivot[1] * inverse, pivot[0] * inverse];
        work.blocks[knot] =
            [inverted[0], inverted[1], inverted[2], 168.0 * k3, 24.0 * k2, 3.0 * k, 0.0, 0.0];
        for group in 0..groups {
            let left = joints.change[(knot - 1) * groups + group];
            let right = joints.change[knot * groups + group];
            let mut rhs = [
                left * (360.0 * h2 * h2) + right * (360.0 * k2 * k2),
                right * (60.0 * k3) - left * (60.0 * h3),
            ];
            if knot > 1 {
                let [v, a] = work.knots[(knot - 1) * groups + group];
                rhs[0] = rhs[0] - v * lower[0] - a * lower[1];
                rhs[1] = rhs[1] - v * lower[2] - a * lower[3];
            }
            work.knots[knot * groups + group] = rhs;
        }
    }
}

#[inline(always)]
fn substitute_back(joints: &JointLanes, work: &mut Workspace) {
    let (groups, segments) = (joints.groups(), joints.segments());
    for knot in (1..segments).rev() {
        let [p, q, r, b0, b1, b2, ..] = work.blocks[knot];
        for group in 0..groups {
            let [mut y, mut z] = work.knots[knot * groups + group];
            if knot + 1 < segments {
                let [v, a] = work.knots[(knot + 1) * groups + group];
                y = y - v * b0 + a * b1;
                z = z - v * b1 + a * b2;
            }
            work.knots[knot * groups + group] = [y * p + z * q, y * q + z * r];
        }
    }
}
