//! Trapezoidal velocity: stops at every waypoint, straight lines in joint space.
//!
//! Every joint follows the same profile from 0 to 1, so the motion between two
//! waypoints is a straight line. With ramps of duration `r` and `s` the time
//! from the start of one ramp to the start of the other, speed is `D / s` and
//! acceleration `D / (r s)`; the shortest `r + s` that keeps both limits of
//! every joint follows in closed form.

use super::{Interpolation, Profile, ProfileLimits, Timing};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "trapezoidal",
    title: "Trapezoidal velocity",
    description: "Stops at every waypoint; constant acceleration, constant speed, constant \
                  deceleration along a straight line in joint space. Acceleration steps, so no \
                  jerk limit can be kept. Durations follow in closed form: no optimizer searches.",
    source: "Biagiotti and Melchiorri 2008, doi:10.1007/978-3-540-85629-0, chapter 3",
    continuity: 1,
    min_segments: 1,
    max_segments: None,
    bounded_jerk: false,
    executable: true,
    timing: Timing::ClosedForm(profile),
};

/// The fastest profile over `way[joint]` within the limits.
pub fn profile(way: &[f64], limits: &[ProfileLimits]) -> Profile {
    let largest = |f: fn(&ProfileLimits) -> f64| {
        way.iter().zip(limits).map(|(way, limit)| way.abs() / f(limit)).fold(0.0, f64::max)
    };
    // s >= per_velocity and r s >= per_acceleration; r + s is least where s is
    // as small as it may be, but not below r.
    let per_velocity = largest(|limit| limit.velocity);
    let per_acceleration = largest(|limit| limit.acceleration);
    let s = per_velocity.max(per_acceleration.sqrt());
    let ramp = per_acceleration / s;
    let acceleration = 1.0 / (ramp * s);
    let ramp_end = 0.5 * acceleration * ramp * ramp;
    let mut pieces = vec![(ramp, vec![0.0, 0.0, 0.5 * acceleration])];
    // A triangle has no cruise; rounding must not make one of length 1e-17.
    let cruise = s - ramp;
    if cruise > 1e-9 * s {
        pieces.push((cruise, vec![ramp_end, acceleration * ramp]));
    }
    pieces.push((ramp, vec![1.0 - ramp_end, acceleration * ramp, -0.5 * acceleration]));
    Profile { pieces }
}
