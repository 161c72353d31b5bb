//! The limit of the tool's speed: what of a plan it slows down, and how that is told.

use super::result::Binding;
use super::waypoints::{Run, Timed};
use crate::trajectory::Trajectory;

/// Rounds in which a motion loses what rounding left above the limit.
const ROUNDINGS: usize = 4;

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
