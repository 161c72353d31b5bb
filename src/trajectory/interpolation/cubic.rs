//! Cubic spline: C2, at rest at both ends.
//!
//! The clamped spline of Shu et al. (whose equations are lost and
//! reconstructed here), in the knot velocities `v`:
//! continuity of acceleration at a knot between segments of durations `h` and
//! `k` with ways `D` and `E` reads
//! `v₋/h + 2 (1/h + 1/k) v + v₊/k = 3 (D/h² + E/k²)`.
//! Acceleration is not zero at the ends: it steps at start and stop.

use super::{Interpolation, Timing};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "cubic",
    title: "Cubic spline",
    description: "Cubic spline with zero velocity at both ends. Acceleration is continuous \
                  between the ends but steps at start and stop, so no jerk limit can be kept.",
    source: "Shu et al., dual-optimisation PSO, eqs. 4-11 (clamped cubic spline)",
    continuity: 2,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: false,
    executable: true,
    timing: Timing::Search(&Cubic),
};

/// The clamped cubic spline.
pub struct Cubic;

impl Family for Cubic {
    const DEGREE: usize = 3;

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        let (groups, segments) = (joints.groups(), joints.segments());
        // Knots 0 and `segments` rest; `knots[i]` holds the velocity at knot i.
        for group in 0..groups {
            work.knots[group][0] = Lanes::ZERO;
        }
        for knot in 1..segments {
            let [h, k] = [1.0 / durations[knot - 1], 1.0 / durations[knot]];
            // Elimination of the knot before (Thomas): its pivot's inverse is kept.
            let below = if knot > 1 { h * work.blocks[knot - 1][0] } else { 0.0 };
            let pivot = 1.0 / (2.0 * (h + k) - below * h);
            work.blocks[knot] = [pivot, k, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            for group in 0..groups {
                let left = joints.change[(knot - 1) * groups + group] * (h * h);
                let right = joints.change[knot * groups + group] * (k * k);
                let before = work.knots[(knot - 1) * groups + group][0];
                work.knots[knot * groups + group][0] = (left + right) * 3.0 - before * below;
            }
        }
        for knot in (1..segments).rev() {
            let [pivot, k, ..] = work.blocks[knot];
            for group in 0..groups {
                let after = if knot + 1 < segments {
                    work.knots[(knot + 1) * groups + group][0] * k
                } else {
                    Lanes::ZERO
                };
                let cell = &mut work.knots[knot * groups + group][0];
                *cell = (*cell - after) * pivot;
            }
        }
        for (segment, &h) in durations.iter().enumerate() {
            for group in 0..groups {
                let cell = segment * groups + group;
                let v0 = work.knots[cell][0] * h;
                let v1 = if segment + 1 < segments {
                    work.knots[cell + groups][0] * h
                } else {
                    Lanes::ZERO
                };
                let way = joints.change[cell];
                work.pieces[cell] = [
                    joints.start[cell],
                    v0,
                    way * 3.0 - v0 * 2.0 - v1,
                    v0 + v1 - way * 2.0,
                    Lanes::ZERO,
                    Lanes::ZERO,
                ];
            }
        }
    }
}
