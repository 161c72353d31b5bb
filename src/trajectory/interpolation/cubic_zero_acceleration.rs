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
            return fit_single(joints, work);
        }
        moments::solve(joints, durations, work);
        for (segment, &h) in durations.iter().enumerate() {
            let (first, last) = (segment == 0, segment + 1 == segments);
            // The first segment has two pieces.
            let piece = segment + usize::from(!first);
            let own = if first || last { 0.5 * h } else { h };
            for group in 0..groups {
                let (knot, cell) = (segment * groups + group, piece * groups + group);
                let [start, way] = [joints.start[knot], joints.change[knot]];
                let from = work.knots[knot][0] * (own * own);
                let to = work.knots[knot + groups][0] * (own * own);
                if first {
                    let m = way - to * (1.0 / 6.0);
                    let virtual_way = m * (1.0 / 6.0);
                    work.pieces[cell] = from_rest(start, m);
                    work.pieces[cell + groups] =
                        moments::cubic_piece(start + virtual_way, way - virtual_way, m, to);
                } else if last {
                    let m = -way - from * (1.0 / 6.0);
                    work.pieces[cell] = moments::cubic_piece(start, way + m * (1.0 / 6.0), from, m);
                    work.pieces[cell + groups] = to_rest(start + way, m);
                } else {
                    work.pieces[cell] = moments::cubic_piece(start, way, from, to);
                }
            }
        }
    }
}

/// Both virtual points in one segment: its halves have the way `D/2` and
/// `W = 0`, so `m = D/2`. The middle piece lasts twice as long as the others; in
/// its own time acceleration goes from `4 m` to `-4 m`.
#[inline(always)]
fn fit_single(joints: &JointLanes, work: &mut Workspace) {
    let groups = joints.groups();
    for group in 0..groups {
        let [start, way] = [joints.start[group], joints.change[group]];
        let m = way * 0.5;
        let virtual_way = m * (1.0 / 6.0);
        work.pieces[group] = from_rest(start, m);
        work.pieces[groups + group] =
            moments::cubic_piece(start + virtual_way, way - virtual_way * 2.0, m * 4.0, -(m * 4.0));
        work.pieces[2 * groups + group] = to_rest(start + way, -m);
    }
}

/// The cubic from rest at `start` to acceleration `m`, in its own time.
#[inline(always)]
fn from_rest(start: Lanes, m: Lanes) -> Piece {
    let zero = Lanes::ZERO;
    [start, zero, zero, m * (1.0 / 6.0), zero, zero]
}

/// The cubic from acceleration `m` to rest at `end`, in its own time.
#[inline(always)]
fn to_rest(end: Lanes, m: Lanes) -> Piece {
    let (sixth, half) = (m * (1.0 / 6.0), m * 0.5);
    [end + sixth, -half, half, -sixth, Lanes::ZERO, Lanes::ZERO]
}
