//! Cubic B-spline with knots at the waypoints' times.
//!
//! A cubic B-spline that interpolates at its knots, with fourfold knots and zero
//! velocity at the ends, is the clamped cubic spline: the spline is unique, and
//! the B-spline basis is but another way to write it. So the kernel is that of
//! `cubic`. Who wants control points reads them from the trajectory: a piece of
//! duration `h` that starts with position `x` and velocity `v` and ends with `y`
//! and `w` has the Bézier points `x, x + v h/3, y - w h/3, y`, and de Boor's
//! points follow from these by knot removal.

use super::cubic::Cubic;
use super::{Interpolation, Timing};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "bspline",
    title: "Cubic B-spline",
    description: "Cubic B-spline through the waypoints, with knots at their times and zero velocity \
                  at both ends: the same curve as `cubic`, delivered in the same form, as one \
                  cubic per segment. Unlike `bspline_uniform` it can be executed.",
    source: "de Boor 1978, A Practical Guide to Splines; what Lin and Yang's uniform B-spline \
             becomes in time",
    continuity: 2,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: false,
    executable: true,
    timing: Timing::Search(&Cubic),
};
