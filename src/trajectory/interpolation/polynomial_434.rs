//! 4-3-4: quartic, cubics, quartic, in closed form but for one tridiagonal system.
//!
//! Shu et al. name the three-segment form, the textbook classic of Fu, Gonzalez
//! and Lee; here it has any number of segments from two: quartic, cubic, ..., cubic, quartic. Its
//! `4n + 2` conditions (waypoints, velocity and acceleration continuous at the
//! inner knots, both zero at the ends) are reduced to the accelerations at the
//! inner knots. With velocity and acceleration zero at its start, the first
//! quartic over the way `D` with acceleration `W` at its end, both in its own
//! time, is `(2D - W/6) u³ + (W/6 - D) u⁴`; its end velocity `2D + W/6` gives the
//! system of `moments.rs`. The last is its mirror image.

use super::{Interpolation, Timing, moments};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "4-3-4",
    title: "4-3-4 polynomial",
    description: "Quartic, cubics, quartic: two segments or more, velocity and acceleration zero \
                  at both ends. Jerk jumps at the inner waypoints.",
    source: "named by Shu et al., dual-optimisation PSO; three segments in Fu, Gonzalez and \
             Lee 1987, Robotics: Control, Sensing, Vision, and Intelligence, chapter 4; general form \
             and solution derived here",
    continuity: 2,
    min_segments: 2,
    max_segments: None,
    bounded_jerk: true,
    executable: true,
    timing: Timing::Search(&Polynomial434),
};

/// The 4-3-4 polynomial.
pub struct Polynomial434;

impl Family for Polynomial434 {
    const DEGREE: usize = 4;

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        moments::solve(joints, durations, work);
        let (groups, segments) = (joints.groups(), joints.segments());
        let zero = Lanes::ZERO;
        for (segment, &h) in durations.iter().enumerate() {
            for group in 0..groups {
                let cell = segment * groups + group;
                let (start, way) = (joints.start[cell], joints.change[cell]);
                let from = work.knots[cell][0] * (h * h);
                let to = work.knots[cell + groups][0] * (h * h);
                work.pieces[cell] = if segment == 0 {
                    let sixth = to * (1.0 / 6.0);
                    [start, zero, zero, way * 2.0 - sixth, sixth - way, zero]
                } else if segment + 1 == segments {
                    // The first quartic backwards: D - (2D + W/6) v³ + (D + W/6) v⁴
                    // with v = 1 - u, in powers of u.
                    let sixth = from * (1.0 / 6.0);
                    let velocity = way * 2.0 - sixth;
                    [start, velocity, from * 0.5, -(way * 2.0) - from * 0.5, way + sixth, zero]
                } else {
                    moments::cubic_piece(start, way, from, to)
                };
            }
        }
    }
}
