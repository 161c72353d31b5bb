//! 3-5-3: cubic, quintic, cubic, in closed form.
//!
//! Chen et al. 2023, doi:10.3390/app131810482, eqs. 14-17: C2 at both inner
//! knots, velocity and acceleration zero at both ends. Instead of the paper's
//! 14 x 14 system: the cubics follow from their own ways alone, and the quintic
//! joins them.

use super::hermite::quintic_piece;
use super::{Interpolation, Timing};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "3-5-3",
    title: "3-5-3 polynomial",
    description: "Cubic, quintic, cubic: three segments, velocity and acceleration zero at both \
                  ends. Jerk jumps at the inner waypoints.",
    source: "Chen et al. 2023, doi:10.3390/app131810482, eqs. 14-17",
    continuity: 2,
    min_segments: 3,
    max_segments: Some(3),
    bounded_jerk: true,
    executable: true,
    timing: Timing::Search(&Polynomial353),
};

/// The 3-5-3 polynomial.
pub struct Polynomial353;

impl Family for Polynomial353 {
    const DEGREE: usize = 5;

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        let groups = joints.groups();
        let [first, middle, last] = [durations[0], durations[1], durations[2]];
        let (into, out) = (middle / first, middle / last);
        for group in 0..groups {
            let [a, b, c] = [group, groups + group, 2 * groups + group];
            let (way, back) = (joints.change[a], joints.change[c]);
            let zero = Lanes::ZERO;
            work.pieces[a] = [joints.start[a], zero, zero, way, zero, zero];
            // 1 - (1 - u)^3 = 3u - 3u^2 + u^3.
            work.pieces[c] = [joints.start[c], back * 3.0, -(back * 3.0), back, zero, zero];
            // Velocity 3 D / t and acceleration 6 D / t^2 at the inner knots,
            // in the middle segment's own time.
            let from = [way * (3.0 * into), way * (6.0 * into * into)];
            let to = [back * (3.0 * out), back * (-6.0 * out * out)];
            work.pieces[b] = quintic_piece(joints.start[b], joints.change[b], from, to);
        }
    }
}
