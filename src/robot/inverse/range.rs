//! Where joints may be, and whole turns.

use std::f64::consts::{PI, TAU};

use crate::robot::{Joint, JointType};

/// A solution this far outside a limit is on it, by rounding: rad or m.
const SLACK: f64 = 1e-10;
/// How far a search looks on each side where a joint that slides has no limit, m.
const UNLIMITED_M: f64 = 1.0;

/// What positions a joint may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    /// Infinite where there is no limit.
    pub(super) lower: f64,
    pub(super) upper: f64,
    /// True if a whole turn changes nothing.
    pub(super) turns: bool,
}

impl Range {
    pub(super) fn new(joint: &Joint) -> Self {
        Self {
            lower: joint.limits.lower.unwrap_or(f64::NEG_INFINITY),
            upper: joint.limits.upper.unwrap_or(f64::INFINITY),
            turns: joint.joint_type != JointType::Prismatic,
        }
    }

    /// The position within the limits that is the same as `position` and nearest to `near`; none if
    /// the limits exclude it.
    #[inline]
    pub(super) fn fit(&self, position: f64, near: f64) -> Option<f64> {
        let mut turned = position;
        if self.turns {
            let least = ((self.lower - SLACK - position) / TAU).ceil();
            let most = ((self.upper + SLACK - position) / TAU).floor();
            let turns = ((near - position) / TAU).round();
            turned += TAU * turns.max(least).min(most);
        }
        let within = turned >= self.lower - SLACK && turned <= self.upper + SLACK;
        within.then(|| turned.max(self.lower).min(self.upper))
    }

    /// The whole turn of `position` that is least outside the limits, and how far that is.
    pub(super) fn excess(&self, position: f64) -> (f64, f64) {
        let outside = |position: f64| (self.lower - position).max(position - self.upper).max(0.0);
        let middle = self.middle();
        let turned = if self.turns {
            position + TAU * ((middle - position) / TAU).round()
        } else {
            position
        };
        (turned, outside(turned))
    }

    /// Every position within the limits that is the same as `position`, in ascending order; of a joint that turns
    /// without end only `position` itself.
    pub(super) fn same(&self, position: f64) -> impl Iterator<Item = f64> + use<> {
        let limited = self.turns && self.lower.is_finite() && self.upper.is_finite();
        let (least, most) = if limited {
            let least = ((self.lower - SLACK - position) / TAU).ceil();
            (least, ((self.upper + SLACK - position) / TAU).floor())
        } else {
            (0.0, 0.0)
        };
        // Limits of thousands of turns are winches, and nobody reads such a list.
        let count = (most - least).clamp(0.0, 64.0) as usize;
        let range = *self;
        (0..=count)
            .map(move |turn| position + TAU * (least + turn as f64))
            .map(move |turned| turned.max(range.lower).min(range.upper))
    }

    /// Where a search may look: the limits or, where there are none, a turn or a metre around `near`.
    pub(super) fn window(&self, near: f64) -> [f64; 2] {
        let reach = if self.turns { PI } else { UNLIMITED_M };
        let lower = if self.lower.is_finite() { self.lower } else { near.min(self.upper) - reach };
        let upper = if self.upper.is_finite() { self.upper } else { near.max(self.lower) + reach };
        [lower, upper]
    }

    /// The middle of the limits; 0, or the limit beyond 0, where one is missing.
    fn middle(&self) -> f64 {
        if self.lower.is_finite() && self.upper.is_finite() {
            0.5 * (self.lower + self.upper)
        } else {
            0.0_f64.max(self.lower).min(self.upper)
        }
    }

    /// Where a joint is if nobody says: at 0 or, if that is outside, in the middle.
    pub(super) fn home(&self) -> f64 {
        if (self.lower..=self.upper).contains(&0.0) { 0.0 } else { self.middle() }
    }
}
