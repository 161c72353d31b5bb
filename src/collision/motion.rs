//! Straight motions between two configurations.

use super::checker::{CollisionChecker, CollisionScratch, wrapped};
use super::kernel::{Found, Pass, Touch, Widths};
use super::lane_chain::Lanes;
use super::travel::Rate;
use crate::math::singles::{SINGLES, Singles};

/// A part of a motion, as shares of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    middle: f32,
    half_width: f32,
}

/// The kernel's bound on rounding holds for turns of up to two whole ones.
const LONGEST_TURN: f64 = 4.0 * std::f64::consts::PI;
/// What is not proven free once nothing moves further than this around a configuration counts as blocked, m.
const PROOF_DEPTH_M: f64 = 1e-4;
/// Motions are halved no more often than this, so that shares stay exact in single precision.
const SMALLEST_HALF_WIDTH: f32 = 1.0 / (1 << 22) as f32;

impl CollisionChecker {
    /// True if the straight motion is free at its end and at samples spread over it, at least `resolution` per rad or m
    /// of its length in joint space.
    ///
    /// Sixteen samples, spread over all of the motion, are checked at a time, each time a little nearer to the start:
    /// most blocked motions fail at the first. Samples as VAMP spreads them (Thomason, Kingston and Kavraki, 2024,
    /// doi:10.1109/ICRA57147.2024.10611190), sixteen instead of eight.
    ///
    /// # Panics
    ///
    /// If a state has another number of joints, or `scratch` is another checker's.
    pub fn is_motion_free_at(
        &self,
        resolution: f64,
        from: &[f64],
        to: &[f64],
        scratch: &mut CollisionScratch,
    ) -> bool {
        self.parts_are_free(from, to, scratch, |scratch| {
            let length = scratch.delta.iter().map(|delta| delta * delta).sum::<f64>().sqrt();
            let rounds = (length * resolution / SINGLES as f64).ceil().max(1.0);
            let mut round = 0.0;
            while round < rounds {
                let back = round / (rounds * SINGLES as f64);
                let shares = Singles(std::array::from_fn(|lane| {
                    ((lane + 1) as f64 / SINGLES as f64 - back) as f32
                }));
                if self.found::<false>(&shares, &Singles::ZERO, scratch) == Found::Touching {
                    return false;
                }
                round += 1.0;
            }
            true
        })
    }

    /// True if the straight motion is proven free over all its length, its ends included.
    ///
    /// Around a configuration no point of a body moves further than the sum over the joints of how far each goes, times the
    /// body's reach from it. So spheres that are larger by as much, free in the middle of a part of the motion, prove all of that part;
    /// parts that are not proven are divided. A motion that comes nearer than about a tenth of a
    /// millimetre to touching counts as blocked.
    ///
    /// # Panics
    ///
    /// If a state has another number of joints, or `scratch` is another checker's.
    pub fn is_motion_proven_free(
        &self,
        from: &[f64],
        to: &[f64],
        scratch: &mut CollisionScratch,
    ) -> bool {
        self.parts_are_free(from, to, scratch, |scratch| self.is_part_proven_free(scratch))
    }

    /// Divides motions that turn further than the kernel can take, and asks `is_free` of each part.
    fn parts_are_free(
        &self,
        from: &[f64],
        to: &[f64],
        scratch: &mut CollisionScratch,
        is_free: impl Fn(&mut CollisionScratch) -> bool,
    ) -> bool {
        assert!(from.len() == self.dof() && to.len() == self.dof(), "one position per joint");
        if !self.is_within_reach(from) || !self.is_within_reach(to) {
            return false;
        }
        let furthest = self
            .model
            .chain
            .screws
            .iter()
            .filter(|screw| screw.turns)
            .map(|screw| (screw.ratio * (to[screw.joint] - from[screw.joint])).abs());
        let parts = (furthest.fold(0.0, f64::max) / LONGEST_TURN).ceil().max(1.0);
        let mut part = 0.0;
        while part < parts {
            let [start, end] = [part / parts, (part + 1.0) / parts];
            let ends = scratch.from.iter_mut().zip(&mut scratch.delta).zip(from.iter().zip(to));
            for ((first, delta), (from, to)) in ends {
                *first = from + (to - from) * start;
                *delta = (to - from) * (end - start);
            }
            self.prepare(scratch);
            if !is_free(scratch) {
                return false;
            }
            part += 1.0;
        }
        true
    }

    /// The motion per screw, for the kernel.
    fn prepare(&self, scratch: &mut CollisionScratch) {
        for (index, screw) in self.model.chain.screws.iter().enumerate() {
            let base = screw.position(scratch.from[screw.joint]);
            scratch.base[index] = wrapped(screw.turns, base) as f32;
            scratch.travel[index] = (screw.ratio * scratch.delta[screw.joint]) as f32;
        }
    }

    /// Looks at sixteen shares of the motion in `scratch`.
    fn found<const WIDE: bool>(
        &self,
        shares: &Singles,
        half_widths: &Singles,
        scratch: &mut CollisionScratch,
    ) -> Found {
        let CollisionScratch { buffers, from, delta, base, travel, exact, .. } = scratch;
        exact.forget();
        let mut measure = |lane: usize, touch: Touch| {
            self.distance_in_lane(lane, touch, exact, |configuration| {
                for ((position, from), delta) in configuration.iter_mut().zip(&*from).zip(&*delta) {
                    *position = from + f64::from(shares.0[lane]) * delta;
                }
            })
        };
        let pass = Pass::<WIDE> {
            model: &self.model,
            lanes: Lanes::Motion { shares, base, travel },
            widths: Widths {
                half_widths,
                groups: &scratch.group_rates,
                pairs: &scratch.pair_rates,
            },
            buffers,
            exact: &mut measure,
        };
        pulp::Arch::new().dispatch(pass)
    }

    fn is_part_proven_free(&self, scratch: &mut CollisionScratch) -> bool {
        let fastest = self.prepare_rates(scratch);
        let shallowest = (PROOF_DEPTH_M / fastest) as f32;
        scratch.intervals.clear();
        let all = Interval { middle: 0.5, half_width: 0.5 };
        all.divide(SINGLES, &mut scratch.intervals);
        while !scratch.intervals.is_empty() {
            // The coarsest stand last: the whole of the motion is looked at before any part in detail.
            let start = scratch.intervals.len().saturating_sub(SINGLES);
            let mut lanes = [Interval { middle: 0.0, half_width: 0.0 }; SINGLES];
            let count = scratch.intervals.len() - start;
            lanes[..count].copy_from_slice(&scratch.intervals[start..]);
            let first = lanes[0];
            lanes[count..].fill(first);
            scratch.intervals.truncate(start);
            let shares = Singles(lanes.map(|interval| interval.middle));
            let half_widths = Singles(lanes.map(|interval| interval.half_width));
            let open = match self.found::<true>(&shares, &half_widths, scratch) {
                Found::Touching => return false,
                Found::Open(open) => open & ((1u32 << count) - 1),
            };
            let divided = (SINGLES / open.count_ones().max(1) as usize).max(2);
            let divided = 1 << divided.ilog2();
            for (lane, interval) in lanes.iter().enumerate() {
                if open >> lane & 1 == 1 {
                    if interval.half_width < shallowest.max(SMALLEST_HALF_WIDTH) {
                        return false;
                    }
                    interval.divide(divided, &mut scratch.intervals);
                }
            }
        }
        true
    }

    /// How far each group and each pair moves on the whole of the motion; the furthest of all groups, m.
    pub(super) fn prepare_rates(&self, scratch: &mut CollisionScratch) -> f64 {
        let CollisionScratch { delta, group_rates, pair_rates, .. } = scratch;
        let (chain, groups) = (&self.model.chain, &self.model.groups);
        let mut furthest = f64::MIN_POSITIVE;
        for (rate, group) in group_rates.iter_mut().zip(groups) {
            *rate = Rate::new(chain, 0..group.screws, &group.levers, delta);
            furthest = furthest.max(rate.of(&group.arms));
        }
        for (rate, pair) in pair_rates.iter_mut().zip(&self.model.pairs) {
            let second = &groups[pair.second];
            *rate = Rate::new(chain, pair.from_screw..second.screws, &second.levers, delta);
        }
        furthest
    }
}

impl Interval {
    /// Divides into `count` equal parts.
    fn divide(&self, count: usize, parts: &mut Vec<Self>) {
        let half_width = self.half_width / count as f32;
        for part in 0..count {
            let middle = self.middle - self.half_width + (2 * part + 1) as f32 * half_width;
            parts.push(Self { middle, half_width });
        }
    }
}
