//! The limit of the tool's speed: what of a plan it slows down, and how that is told.
//!
//! Any motion from rest to rest keeps the limit once it is slow enough as a whole. Of the fastest of all motions only
//! the segments where the tool is too fast are slowed down: there the joints get lower limits of velocity, in proportion
//! to how they move, and the motion is planned again, a few times. What then is left above the limit, the
//! whole motion gives.

use super::error::PlanError;
use super::result::Binding;
use super::waypoints::{Run, Timed};
use crate::math::polynomial::Extremes;
use crate::trajectory::jerk_limited::{Demand, Fastest, fastest_at_speeds};
use crate::trajectory::{TcpLimit, Trajectory};

/// Rounds in which a motion loses what rounding left above the limit.
const ROUNDINGS: usize = 4;

/// Rounds in which a fastest motion is planned again with other speeds.
const ROUNDS: usize = 8;

/// A segment whose peak is between these shares of the limit keeps its speeds.
const CLOSE: [f64; 2] = [0.998, 1.0005];

/// Least limit of a joint's velocity in a segment, as a share of its peak in the whole motion: a joint that
/// hardly moved there may have to, once others are slower.
const LEAST_SPEED: f64 = 0.1;

/// A peak this near its limit binds.
const BINDING_RATIO: f64 = 0.999;

impl Run<'_> {
    /// Slows the motion down as far as the tool's limit asks: speeds scale with the inverse of time, so that the
    /// least factor is the peak over the limit.
    ///
    /// Durations that are given, and ends in motion, leave no choice: there the certificate judges.
    pub(super) fn keep_tcp_speed(&self, mut timed: Timed) -> Timed {
        let Some(limit) = &self.tcp_limit else { return timed };
        // What cannot be computed is told later.
        let sound = timed.trajectory.validate(self.limits.len()).is_ok();
        if self.task.fixed.is_some() || self.task.ends.is_some() || !sound {
            return timed;
        }
        timed.without_tcp_limit.get_or_insert(timed.trajectory.duration());
        for _ in 0..ROUNDINGS {
            let ratio = limit.peak(&timed.trajectory).upper / limit.speed;
            if ratio <= 1.0 || !ratio.is_finite() {
                break;
            }
            timed.slow_down(ratio * (1.0 + f64::EPSILON));
        }
        timed
    }

    /// A motion that takes less time than `first`, the fastest of all that `demand` admits, once both are slow enough as a whole
    /// for the tool's limit; `first` if there is none.
    pub(super) fn slowed_where_needed(
        &self,
        first: Fastest,
        demand: &Demand,
    ) -> Result<Fastest, PlanError> {
        let Some(limit) = self.tcp_limit.as_ref().filter(|_| self.task.ends.is_none()) else {
            return Ok(first);
        };
        let mut speeds = vec![vec![f64::INFINITY; self.limits.len()]; first.durations.len()];
        let mut ratios = ratios(limit, &first);
        let mut best = (slowed(&first, &ratios), first.clone());
        let mut last = first;
        let mut iterations = last.iterations;
        for _ in 0..ROUNDS {
            if !adapt(&mut speeds, &last, &ratios) || self.budget.stop_reason(0).is_some() {
                break;
            }
            last = fastest_at_speeds(&Demand { speeds: &speeds, ..*demand }, self.budget);
            self.still_wanted()?;
            iterations += last.iterations;
            ratios = self::ratios(limit, &last);
            let duration = slowed(&last, &ratios);
            if duration < best.0 {
                best = (duration, last.clone());
            }
        }
        Ok(Fastest { iterations, ..best.1 })
    }

    /// In which segments the tool reaches its limit.
    pub(super) fn tcp_bindings(&self, trajectory: &Trajectory, times: &[f64]) -> Vec<Binding> {
        let Some(limit) = &self.tcp_limit else { return Vec::new() };
        let binds = |ends: &[f64]| {
            let peak = limit.peak_between(trajectory, [ends[0], ends[1]]);
            peak.upper >= BINDING_RATIO * limit.speed
        };
        let segments = times.windows(2).enumerate().filter(|(_, ends)| binds(ends));
        let binding = |(segment, _)| Binding {
            segment,
            joint: "tcp".to_owned(),
            limit: "tcp_speed".to_owned(),
        };
        segments.map(binding).collect()
    }
}

/// Each segment's peak of the tool's speed over its limit.
fn ratios(limit: &TcpLimit, found: &Fastest) -> Vec<f64> {
    let peak = |ends: &[f64]| limit.peak_between(&found.trajectory, [ends[0], ends[1]]).upper;
    found.times.windows(2).map(|ends| peak(ends) / limit.speed).collect()
}

/// How long the motion takes once it is slow enough as a whole, s.
fn slowed(found: &Fastest, ratios: &[f64]) -> f64 {
    found.trajectory.duration() * ratios.iter().copied().fold(1.0, f64::max)
}

/// Lowers the joints' speeds in segments where the tool is too fast, and raises them where it was
/// slowed down too much. False if nothing is left to change.
fn adapt(speeds: &mut [Vec<f64>], found: &Fastest, ratios: &[f64]) -> bool {
    let peaks = peaks(found);
    let highest = |joint: usize| peaks.iter().map(|row| row[joint]).fold(0.0, f64::max);
    let highest: Vec<f64> = (0..peaks[0].len()).map(highest).collect();
    let mut changed = false;
    for ((row, peaks), ratio) in speeds.iter_mut().zip(&peaks).zip(ratios) {
        let was_slowed = row.iter().any(|speed| speed.is_finite());
        if *ratio > CLOSE[1] {
            for ((speed, peak), highest) in row.iter_mut().zip(peaks).zip(&highest) {
                let base = peak.max(LEAST_SPEED * highest);
                if base > 0.0 {
                    *speed = speed.min(base / ratio);
                }
            }
        } else if was_slowed && *ratio < CLOSE[0] && *ratio > 0.0 {
            // Half of what is missing: all of it would swing.
            row.iter_mut().for_each(|speed| *speed /= ratio.sqrt());
        } else {
            continue;
        }
        changed = true;
    }
    changed
}

/// Each joint's largest speed in each segment: `[segment][joint]`.
fn peaks(found: &Fastest) -> Vec<Vec<f64>> {
    let Trajectory { breakpoints, pieces } = &found.trajectory;
    let mut peaks = vec![vec![0.0f64; found.trajectory.dof()]; found.durations.len()];
    for (ends, joints) in breakpoints.windows(2).zip(pieces) {
        let middle = 0.5 * (ends[0] + ends[1]);
        let later = found.times.partition_point(|time| *time <= middle);
        let segment = later.saturating_sub(1).min(peaks.len() - 1);
        for (peak, coefficients) in peaks[segment].iter_mut().zip(joints) {
            *peak = peak.max(Extremes::new(coefficients, ends[1] - ends[0]).of(1).peak().0);
        }
    }
    peaks
}

impl Timed {
    /// The same motion `factor` times as slow.
    fn slow_down(&mut self, factor: f64) {
        self.trajectory.stretch(factor);
        self.durations.iter_mut().for_each(|duration| *duration *= factor);
    }

    /// How long the motion would take without the tool's limit, s, where that makes it longer.
    pub(super) fn faster_without_tcp_limit(&self) -> Option<f64> {
        self.without_tcp_limit.filter(|without| *without < self.trajectory.duration())
    }
}
