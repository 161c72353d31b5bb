//! Han's quintic: three segments, C3, with zero jerk at both ends.
//!
//! Han et al. 2022, doi:10.3390/a15080269, eqs. 4-8. The paper solves an
//! 18 x 18 system; its rows ask for velocity, acceleration *and jerk* zero at
//! both ends (the text names only two of them) and continuous at both knots.
//! Zero jerk at the ends gives the knot accelerations from the knot velocities,
//! `a₁ = 8 v₁/h₁ - 20 D₁/h₁²` and `a₂ = 20 D₃/h₃² - 8 v₂/h₃`, and continuity
//! of jerk leaves a symmetric 2 x 2 system in the two velocities.

use super::hermite::quintic_piece;
use super::{Interpolation, Timing};
use crate::math::lanes::Lanes;
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "quintic_han",
    title: "Quintic of Han et al.",
    description: "Three quintic segments with velocity, acceleration and jerk zero at both ends, \
                  continuous up to jerk.",
    source: "Han et al. 2022, doi:10.3390/a15080269, eqs. 4-8",
    continuity: 3,
    min_segments: 3,
    max_segments: Some(3),
    bounded_jerk: true,
    executable: true,
    timing: Timing::Search(&QuinticHan),
};

/// Han's quintic.
pub struct QuinticHan;

impl Family for QuinticHan {
    const DEGREE: usize = 5;

    #[inline(always)]
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        let groups = joints.groups();
        let [t1, t2, t3] = [durations[0], durations[1], durations[2]];
        let [h1, h2, h3] = [1.0 / t1, 1.0 / t2, 1.0 / t3];
        let diagonal = |h: f64| 36.0 * (h * h + h2 * h2) + 72.0 * h * h2;
        let (p, r) = (diagonal(h1), diagonal(h3));
        let upper = 24.0 * h2 * (h2 + h3);
        let lower = 24.0 * h2 * (h2 + h1);
        let inverse = 1.0 / (p * r - upper * lower);
        for group in 0..groups {
            let [a, b, c] = [group, groups + group, 2 * groups + group];
            let [d1, d2, d3] = [joints.change[a], joints.change[b], joints.change[c]];
            let (e1, e3) = (d1 * (h1 * h1), d3 * (h3 * h3));
            let shared = d2 * (60.0 * h2 * h2 * h2);
            let y = e1 * (120.0 * h1 + 180.0 * h2) + shared + e3 * (60.0 * h2);
            let z = e3 * (120.0 * h3 + 180.0 * h2) + shared + e1 * (60.0 * h2);
            let v1 = (y * r - z * upper) * inverse;
            let v2 = (z * p - y * lower) * inverse;
            let a1 = v1 * (8.0 * h1) - e1 * 20.0;
            let a2 = e3 * 20.0 - v2 * (8.0 * h3);
            let rest = [Lanes::ZERO; 2];
            let state = |v: Lanes, a: Lanes, t: f64| [v * t, a * (t * t)];
            work.pieces[a] = quintic_piece(joints.start[a], d1, rest, state(v1, a1, t1));
            work.pieces[b] =
                quintic_piece(joints.start[b], d2, state(v1, a1, t2), state(v2, a2, t2));
            work.pieces[c] = quintic_piece(joints.start[c], d3, state(v2, a2, t3), rest);
        }
    }
}
