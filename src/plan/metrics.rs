//! Figures that describe a finished plan.

use std::cell::Cell;

use super::result::{Binding, PlanMetrics};
use crate::math::polynomial::{Extremes, integral_of_square, value};
use crate::trajectory::{DERIVATIVES, JointBounds, Trajectory};

/// A peak this near its limit binds.
const BINDING_RATIO: f64 = 0.999;

/// The figures of `trajectory`, which passes its waypoints at `waypoint_times`.
pub(super) fn metrics(
    trajectory: &Trajectory,
    limits: &[JointBounds],
    waypoint_times: &[f64],
    initial_duration: f64,
) -> PlanMetrics {
    let duration = trajectory.duration();
    let mut metrics = PlanMetrics {
        initial_duration,
        saved: 1.0 - duration / initial_duration,
        ..PlanMetrics::default()
    };
    let last_segment = waypoint_times.len() - 2;
    let segment = Cell::new(0);
    for (joint, limit) in limits.iter().enumerate() {
        let (mut squared_jerk, mut way) = (0.0, 0.0);
        segment.set(0);
        for (piece, joints) in trajectory.pieces.iter().enumerate() {
            let [start, end] = [trajectory.breakpoints[piece], trajectory.breakpoints[piece + 1]];
            // A piece belongs to the segment its middle lies in.
            let middle = 0.5 * (start + end);
            while segment.get() < last_segment && middle > waypoint_times[segment.get() + 1] {
                segment.set(segment.get() + 1);
            }
            let coefficients = &joints[joint];
            let length = end - start;
            let extremes = Extremes::new(coefficients, length);
            squared_jerk += integral_of_square(&third_derivative(coefficients), length);
            way += total_variation(coefficients, extremes.turns(), length);
            for (order, name) in DERIVATIVES.iter().enumerate() {
                let ratio = extremes.of(order + 1).peak().0 / limit.derivative(order);
                let binding = Binding {
                    segment: segment.get(),
                    joint: limit.name.clone(),
                    limit: (*name).to_owned(),
                };
                if ratio >= BINDING_RATIO && !metrics.binding.contains(&binding) {
                    metrics.binding.push(binding);
                }
            }
        }
        metrics.rms_jerk.push((squared_jerk / duration).sqrt());
        metrics.path_length.push(way);
        let speed_limit = limit.derivatives[0].as_ref().map(|limit| limit.value);
        metrics.mean_utilisation.push(speed_limit.map(|limit| way / duration / limit));
    }
    metrics.binding.sort_by_key(|binding| binding.segment);
    metrics
}

fn third_derivative(coefficients: &[f64]) -> Vec<f64> {
    let factor = |power: usize| (power * (power - 1) * (power - 2)) as f64;
    coefficients.iter().enumerate().skip(3).map(|(power, c)| factor(power) * c).collect()
}

/// The way travelled between turning points.
fn total_variation(coefficients: &[f64], turns: &[f64], length: f64) -> f64 {
    let mut before = value(coefficients, 0.0);
    let mut way = 0.0;
    for t in turns.iter().copied().chain([length]) {
        let here = value(coefficients, t);
        way += (here - before).abs();
        before = here;
    }
    way
}
