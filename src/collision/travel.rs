//! How far bodies move at most: what every proof about motions rests on.
//!
//! Turning moves a point by no more than the angle times its distance from the axis, and sliding by the slide. The distance from
//! an axis is no more than the sum of what lies between: the lengths of constants, the travels of sliding joints, and
//! the point's own distance from the origin of its frame; from the last axis it is known.

use super::chain::Chain;

/// How far the points of a solid are from where joints turn them, m.
///
/// Of a sphere or a capsule its line counts alone: what turns about its own centre does not move.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arms {
    /// From the origin of the frame that they move with.
    pub(super) whole: f64,
    /// From the z axis of that frame, about which the last joint turns.
    pub(super) about_axis: f64,
}

impl Arms {
    /// Of two solids together.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            whole: self.whole.max(other.whole),
            about_axis: self.about_axis.max(other.about_axis),
        }
    }
}

/// How far solids of a group move on a motion, in terms of their arms.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rate {
    /// Whatever the arms, m.
    shared: f64,
    /// Turned by joints before the last one, rad.
    turned: f64,
    /// Turned by the last one, rad.
    turned_last: f64,
}

/// Rounding must not make a bound smaller, not even to single precision.
const UP: f64 = 1.0 + 1e-6;

impl Rate {
    /// Of a group that moves with the last of `screws`, relative to what is before the first; `levers` are the group's.
    pub(super) fn new(
        chain: &Chain,
        screws: std::ops::Range<usize>,
        levers: &[f64],
        delta: &[f64],
    ) -> Self {
        let mut rate = Self::default();
        for index in screws.clone() {
            let screw = &chain.screws[index];
            let moved = (screw.ratio * delta[screw.joint]).abs() * UP;
            if !screw.turns {
                rate.shared += moved;
            } else if index + 1 == screws.end {
                rate.turned_last += moved;
            } else {
                rate.shared += moved * levers[index];
                rate.turned += moved;
            }
        }
        rate
    }

    /// How far a solid moves at most, m.
    #[inline(always)]
    pub(super) fn of(&self, arms: &Arms) -> f64 {
        self.shared + self.turned * arms.whole + self.turned_last * arms.about_axis
    }
}
