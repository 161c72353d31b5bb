//! Cubic splines from rest to rest without acceleration at the ends, by their
//! knot accelerations (the moments of spline theory).
//!
//! A cubic cannot start with velocity and acceleration zero, run through its
//! end and leave acceleration there free, so first and last segment get one
//! freedom more each: a virtual point half way in time
//! (`cubic_zero_acceleration`) or a fourth power (`4-3-4`). Both then end with
//! the same velocity. With `h` the segment's duration, `D` its way and `w` the
//! acceleration at its inner knot, that is `2 D/h + w h/6`, while a cubic
//! between accelerations `w₁` and `w₂` starts with `D/h - (2 w₁ + w₂) h/6` and
//! ends with `D/h + (w₁ + 2 w₂) h/6`. So with `e = h/2` for first and last
//! segment and `e = h` for the others, continuity of velocity at an inner knot
//! between segments with `(e, D)` and `(f, E)` reads
//! `e w₋ + 2 (e + f) w + f w₊ = 6 (E/f - D/e)`,
//! with `w = 0` at both ends: symmetric and diagonally dominant, so elimination
//! needs no pivoting, however uneven the durations.

use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{JointLanes, Piece, Workspace};

/// Solves for the accelerations at the inner knots, into `work.knots[..][0]`,
/// for two segments or more; at the ends it is zero. O(n), and all joints share
/// one factorisation.
#[inline(always)]
pub fn solve(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
    let (groups, segments) = (joints.groups(), joints.segments());
    let effective = |segment: usize| {
        let end = segment == 0 || segment + 1 == segments;
        durations[segment] * if end { 0.5 } else { 1.0 }
    };
    for group in 0..groups {
        work.knots[group][0] = Lanes::ZERO;
        work.knots[segments * groups + group][0] = Lanes::ZERO;
    }
    for knot in 1..segments {
        let [e, f] = [effective(knot - 1), effective(knot)];
        // Elimination of the knot before (Thomas): its pivot's inverse is kept.
        let below = if knot > 1 { e * work.blocks[knot - 1][0] } else { 0.0 };
        let pivot = 1.0 / (2.0 * (e + f) - below * e);
        work.blocks[knot] = [pivot, f, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for group in 0..groups {
            let left = joints.change[(knot - 1) * groups + group] * (6.0 / e);
            let right = joints.change[knot * groups + group] * (6.0 / f);
            let before = work.knots[(knot - 1) * groups + group][0];
            work.knots[knot * groups + group][0] = right - left - before * below;
        }
    }
    for knot in (1..segments).rev() {
        let [pivot, f, ..] = work.blocks[knot];
        // The end knot has no acceleration to hand back.
        let f = if knot + 1 < segments { f } else { 0.0 };
        for group in 0..groups {
            let after = work.knots[(knot + 1) * groups + group][0];
            let cell = &mut work.knots[knot * groups + group][0];
            *cell = (*cell - after * f) * pivot;
        }
    }
}

/// The cubic from `start` over `way` between the accelerations `from` and `to`,
/// both in the piece's own time.
#[inline(always)]
pub fn cubic_piece(start: Lanes, way: Lanes, from: Lanes, to: Lanes) -> Piece {
    let velocity = way - from * (1.0 / 3.0) - to * (1.0 / 6.0);
    [start, velocity, from * 0.5, (to - from) * (1.0 / 6.0), Lanes::ZERO, Lanes::ZERO]
}
