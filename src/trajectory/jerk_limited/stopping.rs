//! The fastest motion that stops at every waypoint: closed form, always possible.

use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::rest_to_rest::{alone, gains, rest_to_rest};

use super::profile::{Motion, Phase};
use super::speeds::Bounds;

/// One joint's phases over a segment of `length`.
fn phases(way: f64, length: f64, limits: [f64; 3]) -> Vec<Phase> {
    if way == 0.0 {
        return vec![Phase { start: 0.0, length, state: [0.0; 4] }];
    }
    let [ramp, hold, cruise] = rest_to_rest(way.abs(), limits);
    let smooth = ramp > 0.0;
    // In units of the peak acceleration.
    let pattern = [
        (ramp, 1.0, 0.0),
        (hold, 0.0, 1.0),
        (ramp, -1.0, 1.0),
        (cruise, 0.0, 0.0),
        (ramp, -1.0, 0.0),
        (hold, 0.0, -1.0),
        (ramp, 1.0, -1.0),
    ];
    let natural = 4.0 * ramp + 2.0 * hold + cruise;
    let factor = length / natural;
    let way_per_peak = (ramp + hold) * (2.0 * ramp + hold + cruise) * factor * factor;
    let peak = way / way_per_peak;
    let (mut x, mut v, mut start) = (0.0, 0.0, 0.0);
    let mut phases = Vec::with_capacity(7);
    for (duration, jerk, acceleration) in pattern {
        let length = duration * factor;
        if length <= 0.0 {
            continue;
        }
        let jerk = if smooth { jerk * peak / (ramp * factor) } else { 0.0 };
        let phase = Phase { start, length, state: [x, v, acceleration * peak, jerk] };
        [x, v, ..] = phase.at(length);
        start += length;
        phases.push(phase);
    }
    phases
}

/// The fastest motion along `ways[segment][joint]` that stops at every waypoint.
///
/// `limits` without acceleration and jerk must have been given finite ones, see
/// [`super::layout::effective`].
pub fn stopping(ways: &[Vec<f64>], limits: Bounds) -> Motion {
    let duration = |(segment, row): (usize, &Vec<f64>)| {
        let of = |(joint, way): (usize, &f64)| alone(*way, limits.of(segment, joint));
        row.iter().enumerate().map(of).fold(0.0, f64::max)
    };
    let durations: Vec<f64> = ways.iter().enumerate().map(duration).collect();
    let joint = |joint: usize| {
        let segment = |(segment, (row, length)): (usize, (&Vec<f64>, &f64))| {
            phases(row[joint], *length, limits.of(segment, joint))
        };
        ways.iter().zip(&durations).enumerate().map(segment).collect()
    };
    let phases = (0..limits.len()).map(joint).collect();
    // At rest every state costs nothing that could be told from here.
    let prices = vec![vec![[0.0; 3]; limits.len()]; ways.len()];
    let gains = ways.iter().map(|row| slowest_gains(row, &limits)).collect();
    Motion { phases, prices, gains, durations }
}

/// Only the slowest joint's limits hold a segment back.
fn slowest_gains(row: &[f64], limits: &[KernelLimits]) -> Vec<[f64; 3]> {
    let mut all = vec![[0.0; 3]; limits.len()];
    let times = row.iter().zip(limits).map(|(way, limit)| alone(*way, limit.derivatives));
    if let Some((joint, _)) = times.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) {
        all[joint] = gains(row[joint], limits[joint].derivatives);
    }
    all
}
