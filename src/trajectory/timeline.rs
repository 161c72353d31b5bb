//! Which limit of which joint holds which instant.
//!
//! A limit holds a joint while the magnitude of its velocity, acceleration or
//! jerk is within [`TOLERANCE`] of it. Where that begins and ends are roots of
//! polynomials; nothing is sampled.

use serde::Serialize;
use utoipa::ToSchema;

use super::certificate::JointCertificate;
use super::limits::DERIVATIVES;
use super::polynomial_trajectory::Trajectory;
use crate::math::polynomial::{derivative, roots, value};

/// This near its limit, relative to the limit, a value is held by it.
pub const TOLERANCE: f64 = 1e-3;

/// Gaps up to this share of the whole time are rounding.
const ROUNDING: f64 = 1e-9;

/// When which limits hold a motion back.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct BindingTimeline {
    /// Duration of the motion, s.
    pub duration: f64,
    /// How near a limit counts as held, relative to the limit.
    pub tolerance: f64,
    /// Share of the time in which at least one limit holds.
    pub held: f64,
    /// Per joint, in joint order.
    pub joints: Vec<JointTimeline>,
}

/// When which limits hold a joint.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct JointTimeline {
    /// Joint name.
    pub joint: String,
    /// Velocity, acceleration and jerk, those whose limits are known.
    pub limits: Vec<LimitTimeline>,
}

/// When one limit holds.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct LimitTimeline {
    /// `velocity`, `acceleration` or `jerk`.
    pub limit: String,
    /// Share of the time in which it holds.
    pub share: f64,
    /// When, ascending and apart from each other.
    pub intervals: Vec<Interval>,
}

/// A part of the time axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Interval {
    /// Where it begins, s.
    pub start: f64,
    /// Where it ends, s.
    pub end: f64,
}

impl BindingTimeline {
    /// The timeline of a valid trajectory within the limits its certificate
    /// tells for `joints`.
    pub fn new(trajectory: &Trajectory, joints: &[JointCertificate]) -> Self {
        let duration = trajectory.duration();
        let share = |intervals: &[Interval]| {
            // The sum of no numbers would be a negative zero.
            let length = intervals.iter().fold(0.0, |sum, it| sum + (it.end - it.start));
            length / duration.max(f64::MIN_POSITIVE)
        };
        let joints: Vec<JointTimeline> = joints
            .iter()
            .enumerate()
            .map(|(index, joint)| {
                let peaks = [&joint.velocity, &joint.acceleration, &joint.jerk];
                let known = peaks.into_iter().zip(DERIVATIVES).enumerate();
                let limits = known.filter_map(|(order, (peak, name))| {
                    let intervals = held(trajectory, index, order + 1, peak.limit?);
                    let share = share(&intervals);
                    Some(LimitTimeline { limit: name.to_owned(), share, intervals })
                });
                JointTimeline { joint: joint.name.clone(), limits: limits.collect() }
            })
            .collect();
        let mut all: Vec<Interval> = joints
            .iter()
            .flat_map(|joint| &joint.limits)
            .flat_map(|limit| limit.intervals.iter().copied())
            .collect();
        all.sort_by(|a, b| a.start.total_cmp(&b.start));
        let held = share(&joined(all, ROUNDING * duration));
        Self { duration, tolerance: TOLERANCE, held, joints }
    }
}

/// When derivative `order` of a joint is at its limit.
fn held(trajectory: &Trajectory, joint: usize, order: usize, limit: f64) -> Vec<Interval> {
    let threshold = limit * (1.0 - TOLERANCE);
    let mut found = Vec::new();
    for (piece, bounds) in trajectory.pieces.iter().zip(trajectory.breakpoints.windows(2)) {
        let Some(position) = piece.get(joint) else { continue };
        let curve = (0..order).fold(position.clone(), |curve, _| derivative(&curve));
        held_in_piece(&curve, [bounds[0], bounds[1]], threshold, &mut found);
    }
    joined(found, ROUNDING * trajectory.duration())
}

/// Adds when `curve`, which begins at the first of `bounds`, is beyond
/// `threshold` in magnitude.
fn held_in_piece(curve: &[f64], bounds: [f64; 2], threshold: f64, found: &mut Vec<Interval>) {
    let [start, end] = bounds;
    let length = end - start;
    let crossings = |level: f64| {
        let mut shifted = curve.to_vec();
        if let Some(constant) = shifted.first_mut() {
            *constant -= level;
        }
        roots(&shifted, length)
    };
    let mut cuts = crossings(threshold);
    cuts.extend(crossings(-threshold));
    cuts.sort_by(f64::total_cmp);
    let mut before = 0.0;
    for cut in cuts.into_iter().chain([length]) {
        if cut > before && value(curve, 0.5 * (before + cut)).abs() >= threshold {
            // The piece's own end, so that the next one begins exactly there.
            let until = if cut == length { end } else { start + cut };
            found.push(Interval { start: start + before, end: until });
        }
        before = cut;
    }
}

/// Ascending intervals with those that touch or overlap made one.
fn joined(intervals: Vec<Interval>, gap: f64) -> Vec<Interval> {
    let mut joined: Vec<Interval> = Vec::with_capacity(intervals.len());
    for interval in intervals {
        match joined.last_mut() {
            Some(last) if interval.start <= last.end + gap => last.end = last.end.max(interval.end),
            _ => joined.push(interval),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(start: f64, end: f64) -> Interval {
        Interval { start, end }
    }

    #[test]
    fn intervals_that_touch_are_one() {
        let joined = joined(vec![interval(0.0, 1.0), interval(1.0, 2.0), interval(3.0, 4.0)], 1e-9);
        assert_eq!(joined, [interval(0.0, 2.0), interval(3.0, 4.0)]);
    }

    #[test]
    fn both_signs_are_held() {
        // sin-like: 3 t - 4 t³ on [-1, 1], moved to begin at zero; peaks ±1 at ±½.
        let curve = [1.0, -9.0, 12.0, -4.0];
        let mut found = Vec::new();
        held_in_piece(&curve, [10.0, 12.0], 0.999, &mut found);
        // Beyond the threshold at the ends, where it is ±1, and around both peaks.
        assert_eq!(found.len(), 4);
        for (found, middle) in found.iter().zip([10.0, 10.5, 11.5, 12.0]) {
            assert!((found.start..=found.end).contains(&middle), "{found:?}");
            assert!(found.end - found.start < 0.1);
        }
    }
}
