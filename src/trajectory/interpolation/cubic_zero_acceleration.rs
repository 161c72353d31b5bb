//! Cubic spline at rest and without acceleration at both ends: C2 throughout,
//! thanks to one virtual point in the first and one in the last segment.
//!
//! Biagiotti and Melchiorri 2008, doi:10.1007/978-3-540-85629-0, section 4.4.4,
//! place the virtual points anywhere and find their positions with the spline.
//! Here they lie half way in time, where the system becomes symmetric and equal
//! to that of `4-3-4` (`moments.rs`). With the half segment's own time, `D` the
//! way and `W` the acceleration at the inner waypoint, the first segment's
//! virtual point lies `m/6` from the start and has velocity `m/2` and
//! acceleration `m = D - W/6`; the last segment is the mirror image.
//!
//! A single segment holds both virtual points, at a quarter and three quarters:
//! its halves are two segments with `W = 0` between them, whose inner pieces are
//! one cubic.

use super::{Interpolation, Timing, moments};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Piece, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "cubic_zero_acceleration",
    title: "Cubic spline without acceleration at the ends",
    description: "Cubic spline with velocity and acceleration zero at both ends: one virtual \
                  point half way through the first and one half way through the last segment (a \
                  quarter and three quarters through a single one). Jerk is constant in each \
                  piece.",
    source: "Biagiotti and Melchiorri 2008, doi:10.1007/978-3-540-85629-0, section 4.4.4",
    continuity: 2,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: true,
    executable: true,
    timing: Timing::Search(&CubicZeroAcceleration),
};

/// The cubic spline with virtual points.
pub struct CubicZeroAcceleration;

impl Family for CubicZeroAcceleration {
    const DEGREE: usize = 3;

    #[inline(always)]
    fn shares(segment: usize, segments: usize) -> &'static [f64] {
        if segments == 1 {
            &[0.25, 0.5, 0.25]
        } else if segment == 0 || segment + 1 == segments {
            &[0.5, 0.5]
        } else {
            &[1.0]
        }
    }

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        let (groups, segments) = (joints.groups(), joints.segments());
        if segments == 1 {
            for group in 0..groups {
                let [start, way] = [joints.start[group], joints.change[group]];
                // `m` of half the way; over the middle piece, twice as long,
                // acceleration goes from `4 m` to `-4 m` in its own time.
                let m = way * 0.5;
                let [first, last] = [rest_to(start, m), to_rest(start + way, -m)];
                let middle = moments::cubic_piece(
                    start + m * (1.0 / 6.0),
                    way - m * (1.0 / 3.0),
                    m * 4.0,
                    -(m * 4.0),
                );
                [
                    work.pieces[group],
                    work.pieces[groups + group],
                    work.pieces[2 * groups + group],
                ] = [first, middle, last];
            }
            return;
        }
        moments::solve(joints, durations, work);
        for (segment, &h) in durations.iter().enumerate() {
            // The first segment has two pieces.
            let piece = segment + usize::from(segment > 0);
            let own = if segment == 0 || segment + 1 == segments { 0.5 * h } else { h };
            for group in 0..groups {
                let (knot, cell) = (segment * groups + group, piece * groups + group);
                let [start, way] = [joints.start[knot], joints.change[knot]];
                let from = work.knots[knot][0] * (own * own);
                let to = work.knots[knot + groups][0] * (own * own);
                if segment == 0 {
                    let m = way - to * (1.0 / 6.0);
                    let sixth = m * (1.0 / 6.0);
                    work.pieces[cell] = rest_to(start, m);
                    work.pieces[cell + groups] =
                        moments::cubic_piece(start + sixth, way - sixth, m, to);
                } else if segment + 1 == segments {
                    let m = -way - from * (1.0 / 6.0);
                    let sixth = m * (1.0 / 6.0);
                    work.pieces[cell] = moments::cubic_piece(start, way + sixth, from, m);
                    work.pieces[cell + groups] = to_rest(start + way, m);
                } else {
                    work.pieces[cell] = moments::cubic_piece(start, way, from, to);
                }
            }
        }
    }
}

/// The cubic from rest at `start` to acceleration `m`, in its own time.
#[inline(always)]
fn rest_to(start: Lanes, m: Lanes) -> Piece {
    let zero = Lanes::ZERO;
    [start, zero, zero, m * (1.0 / 6.0), zero, zero]
}

/// The cubic from acceleration `m` to rest at `end`, in its own time.
#[inline(always)]
fn to_rest(end: Lanes, m: Lanes) -> Piece {
    let (sixth, half) = (m * (1.0 / 6.0), m * 0.5);
    [end + sixth, -half, half, -sixth, Lanes::ZERO, Lanes::ZERO]
}
