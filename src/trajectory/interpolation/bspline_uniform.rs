//! Uniform cubic B-spline in the segments' own time, as published.
//!
//! Lin and Yang (the basis `B₁` corrected to `(3u³ - 6u² + 4)/6`): segment `i`
//! follows the control points `V_{i-1}` to `V_{i+2}`, which solve
//! `V_{i-1} + 4 V_i + V_{i+1} = 6 P_i` at the waypoints `P_1` to `P_m`. The paper
//! leaves the ends open; we read zero end velocity, `V₀ = V₂` and
//! `V_{m+1} = V_{m-1}`, so `4 V₁ + 2 V₂ = 6 P₁` and `2 V_{m-1} + 4 V_m = 6 P_m`.
//!
//! The shape does not depend on durations: in `u` it is the C2 cubic with zero
//! end slopes through the waypoints, and that is the clamped spline of `cubic`
//! with all durations 1, whose knot slopes are `(V_{i+1} - V_{i-1})/2`. In time
//! the slope on either side of a waypoint is divided by another duration: unless
//! these are equal, velocity jumps there by their ratio, and no robot can follow.

use super::cubic::Cubic;
use super::{Interpolation, Timing};
use crate::trajectory::kernel::{Family, JointLanes, Workspace};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "bspline_uniform",
    title: "Uniform cubic B-spline",
    description: "Uniform cubic B-spline as published, for comparison: smooth in each segment's own \
                  time, but where neighbouring durations differ velocity jumps at the waypoint, \
                  which no robot can follow. Limits are kept inside the segments; the \
                  certificate reports the jumps. To execute, use `bspline`.",
    source: "Lin and Yang, adaptive genetic algorithm for palletizing, uniform cubic B-spline",
    continuity: 0,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: false,
    executable: false,
    timing: Timing::Search(&UniformBspline),
};

/// The uniform cubic B-spline.
pub struct UniformBspline;

impl Family for UniformBspline {
    const DEGREE: usize = 3;

    fn prepare(joints: &JointLanes, work: &mut Workspace) {
        Cubic::fit(joints, &vec![1.0; joints.segments()], work);
    }

    #[inline(always)]
    fn fit(_joints: &JointLanes, _durations: &[f64], _work: &mut Workspace) {}
}
