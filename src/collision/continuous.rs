//! The smallest clearance of a timed motion, proven over continuous time.
//!
//! Between two times no point of a body moves further from where it is in the middle than the sum over the joints of how far each goes,
//! times the body's reach from it. So the clearance in the middle, less that, holds for the whole interval. The interval
//! with the least such bound is halved until none is below the least clearance that was found by more than a tolerance.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::checker::{CollisionChecker, CollisionScratch};
use super::clearance::{Mover, Owner, Search};
use super::kernel::Touch;
use super::travel::Rate;

/// How joints move in time, as far as a proof needs to know.
pub trait JointMotion {
    /// Length of the motion, s.
    fn duration(&self) -> f64;

    /// Writes the positions at `time`, rad or m per joint.
    fn position(&self, time: f64, position: &mut [f64]);

    /// Writes a bound on how far each joint is, at any time from `start` to `end`, from where it is half way between
    /// them: rad or m per joint.
    fn travel(&self, start: f64, end: f64, travel: &mut [f64]);
}

/// The smallest clearance of a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenClearance {
    /// The clearance is nowhere smaller, m.
    pub proven_m: f64,
    /// The smallest that was measured, m; not positive where something touches, and then the search ended there.
    pub smallest_m: f64,
    /// When it was measured, s.
    pub at: f64,
    /// The robot's body or attached object, then the obstacle or the other body.
    pub pair: [String; 2],
}

/// Why a motion's clearance cannot be told.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClearanceError {
    /// A position that bounds do not hold for.
    #[error("joint {joint} is at {position} after {at} s, not finite or beyond the joint's limits")]
    OutOfReach {
        /// Which joint, from 0.
        joint: usize,
        /// Where it is, rad or m.
        position: f64,
        /// When, s.
        at: f64,
    },
    /// More halvings than any motion needs that is not in touch with something all along.
    #[error("the clearance is not proven after {0} measurements")]
    Unproven(usize),
}

/// Measurements after which a proof is given up.
const MOST_MEASUREMENTS: usize = 200_000;
/// Before anything is known, a motion is divided into so many intervals.
const FIRST_INTERVALS: usize = 16;

/// An interval of time, ordered so that the least bound comes first.
struct Interval {
    bound: f64,
    start: f64,
    end: f64,
}

/// What is known in the middle of an interval.
struct Measured<'a> {
    /// How groups and pairs move within it.
    group_rates: &'a [Rate],
    pair_rates: &'a [Rate],
    bound: f64,
    smallest: Option<(f64, Touch)>,
}

impl Measured<'_> {
    fn moved(&self, mover: Mover<'_>) -> f64 {
        let rate = match mover.of {
            Owner::Group(group) => &self.group_rates[group],
            Owner::Pair(pair) => &self.pair_rates[pair],
        };
        rate.of(mover.arms)
    }
}

impl Search for Measured<'_> {
    fn enough(&self, mover: Mover<'_>) -> f64 {
        let smallest = self.smallest.map_or(f64::INFINITY, |(distance, _)| distance);
        smallest.max(self.bound + self.moved(mover))
    }

    fn found(&mut self, touch: Touch, mover: Mover<'_>, distance: f64) {
        self.bound = self.bound.min(distance - self.moved(mover));
        if self.smallest.is_none_or(|(smallest, _)| distance < smallest) {
            self.smallest = Some((distance, touch));
        }
    }
}

impl CollisionChecker {
    /// Proves the smallest clearance of `motion` to within `tolerance_m` (positive); nothing if there is nothing to keep
    /// away from.
    ///
    /// # Errors
    ///
    /// Positions that are not finite or beyond the limits of sliding joints, and proofs that take too long.
    ///
    /// # Panics
    ///
    /// If `scratch` is another checker's.
    pub fn proven_clearance(
        &self,
        motion: &impl JointMotion,
        tolerance_m: f64,
        scratch: &mut CollisionScratch,
    ) -> Result<Option<ProvenClearance>, ClearanceError> {
        let duration = motion.duration();
        let mut least: Option<(f64, f64, Touch)> = None;
        let mut open = BinaryHeap::new();
        let mut measurements = 0;
        let first = |k: usize| duration * k as f64 / FIRST_INTERVALS as f64;
        let mut halves: Vec<_> = (0..FIRST_INTERVALS).map(|k| [first(k), first(k + 1)]).collect();
        loop {
            for [start, end] in halves.drain(..) {
                let (bound, smallest) = self.measure(motion, start, end, scratch)?;
                measurements += 1;
                let Some((distance, touch)) = smallest else { return Ok(None) };
                if least.is_none_or(|(smallest, ..)| distance < smallest) {
                    least = Some((distance, 0.5 * (start + end), touch));
                }
                open.push(Interval { bound, start, end });
            }
            let (Some(interval), Some((smallest_m, at, touch))) = (open.pop(), least) else {
                return Ok(None);
            };
            let proven_m = interval.bound.min(smallest_m);
            if smallest_m <= 0.0 || proven_m >= smallest_m - tolerance_m {
                let pair = self.model.pair_names(touch);
                return Ok(Some(ProvenClearance { proven_m, smallest_m, at, pair }));
            }
            if measurements >= MOST_MEASUREMENTS {
                return Err(ClearanceError::Unproven(measurements));
            }
            let middle = 0.5 * (interval.start + interval.end);
            halves.extend([[interval.start, middle], [middle, interval.end]]);
        }
    }

    /// A bound on the clearance between two times, and what is nearest half way between them.
    fn measure(
        &self,
        motion: &impl JointMotion,
        start: f64,
        end: f64,
        scratch: &mut CollisionScratch,
    ) -> Result<(f64, Option<(f64, Touch)>), ClearanceError> {
        let at = 0.5 * (start + end);
        motion.position(at, &mut scratch.from);
        if !self.is_within_reach(&scratch.from) {
            return Err(self.out_of_reach(&scratch.from, at));
        }
        scratch.exact.place(&self.model, &scratch.from);
        motion.travel(start, end, &mut scratch.delta);
        self.prepare_rates(scratch);
        let mut measured = Measured {
            group_rates: &scratch.group_rates,
            pair_rates: &scratch.pair_rates,
            bound: f64::INFINITY,
            smallest: None,
        };
        self.model.search(&scratch.exact, &mut measured);
        Ok((measured.bound, measured.smallest))
    }

    fn out_of_reach(&self, position: &[f64], at: f64) -> ClearanceError {
        let beyond = |joint: &usize| {
            let mut alone = vec![0.0; position.len()];
            alone[*joint] = position[*joint];
            !self.is_within_reach(&alone)
        };
        let joint = (0..position.len()).find(beyond).unwrap_or_default();
        ClearanceError::OutOfReach { joint, position: position[joint], at }
    }
}

impl Ord for Interval {
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.start.total_cmp(&self.start))
    }
}

impl PartialOrd for Interval {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Interval {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Interval {}
