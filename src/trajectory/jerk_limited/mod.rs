//! The fastest trajectory through waypoints under limits on velocity, acceleration and jerk.
//!
//! For every joint jerk is constant piece by piece (acceleration, where jerk has no limit). All
//! joints meet the waypoints at the same times; what they do in between is each joint's own.
//!
//! # The programme
//!
//! A segment of duration `h` is divided into cells; cell `c` lasts `T = phi h`, its share `phi` is
//! each joint's own. With acceleration linear in a cell, `d` its change,
//!
//! ```text
//! x' = x + T v + T² (a/2 + d/6),   v' = v + T (a + d/2),   a' = a + d,
//! ```
//!
//! minimise the sum of `h` so that `|d| <= J T`, `|a'| <= A`, `|v'| <= V` and
//! `|v + T a/2| <= V`. The last is the middle control point of velocity in Bernstein
//! form: with it, speed keeps its limit over the whole cell and not only at its ends.
//! Where jerk is free, acceleration jumps at a cell's start: `d` counts fully from there.
//!
//! # Its solution
//!
//! A primal-dual interior point method (Wächter and Biegler, Mathematical Programming 106, 2006,
//! doi:10.1007/s10107-004-0559-y, whose filter and reduction of the barrier parameter we keep, simplified).
//! For given durations every joint's problem is convex and a chain of cells, so that a
//! Newton step is a Riccati recursion (Rao, Wright and Rawlings, JOTA 99, 1998,
//! doi:10.1023/A:1021711402723). Durations enter as parameters of the recursion; what remains is
//! one small system in the durations, the only place where curvature can be
//! negative. There the magnitudes of its eigenvalues replace them, see [`interior_point`].
//!
//! First all cells of a segment are equal and few. Then those in which the jerk
//! switches are halved again and again ([`refine`]), and the second solution starts from the first.
//!
//! # What is delivered
//!
//! The solution misses the equalities by rounding and keeps the limits strictly. [`profile`] joins cells of
//! equal jerk, restores the equalities, finds exact peaks and uses the limits exactly by the scaling law.
//! No result is slower than [`stopping`] at every waypoint, which is always possible. That also takes the place
//! of a result that leaves the position limits between waypoints: they are not yet in the programme.
//!
//! Long lists are planned in [`windows`].

#![expect(
    clippy::needless_range_loop,
    reason = "rows and columns of matrices are known by their numbers"
)]

mod chain;
mod interior_point;
mod layout;
mod newton;
mod problem;
mod profile;
mod refine;
mod step;
mod stopping;
mod windows;

pub use stopping::alone;

use super::Trajectory;
use super::bound::Prices;
use super::kernel::KernelLimits;

/// A fastest trajectory.
#[derive(Clone, Debug)]
pub struct Fastest {
    /// Cubic pieces (quadratic where jerk is free), within all limits.
    pub trajectory: Trajectory,
    /// When each waypoint is reached, s.
    pub times: Vec<f64>,
    /// Newton steps.
    pub iterations: usize,
    /// Whether every programme was solved to its end.
    pub converged: bool,
    /// Whether the result stops at every waypoint because nothing faster was found.
    pub stops: bool,
    /// Multipliers of the programmes solved: prices that prove a lower bound.
    pub prices: Prices,
}

/// The fastest trajectory through `waypoints[waypoint][joint]`, from rest to rest.
///
/// Limits that do not exist are infinite. Neighbouring waypoints differ in at least one joint.
pub fn fastest(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Fastest {
    let ways: Vec<Vec<f64>> = waypoints
        .windows(2)
        .map(|pair| pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect())
        .collect();
    let limits = layout::effective(&ways, limits);
    let mut best = stopping::stopping(&ways, &limits);
    best.stretch(best.ratio(&limits));
    let mut found = windows::plan(&ways, &limits);
    found.motion.stretch(found.motion.ratio(&limits));
    let faster =
        found.motion.duration() < best.duration() && found.motion.within(waypoints, &limits);
    if faster {
        best = found.motion;
    }
    let (trajectory, times) = best.trajectory(waypoints);
    Fastest {
        trajectory,
        times,
        iterations: found.iterations,
        converged: found.converged,
        stops: !faster && ways.len() > 1,
        prices: found.prices,
    }
}
