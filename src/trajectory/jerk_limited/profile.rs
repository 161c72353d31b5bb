//! One joint's motion as pieces of constant jerk, and all joints' as a [`Trajectory`].

use std::ops::Range;

use crate::math::lanes::{Lanes, WIDTH};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::{Prices, Trajectory};

use super::layout::{Units, before, start_of};
use super::problem::{FREE, Iterate, Problem};
use super::speeds::Bounds;

/// Neighbouring pieces become one if their jerk differs by less than the first share of
/// its limit, and what that does to acceleration and velocity is below the second of theirs.
const ALIKE: [f64; 2] = [1e-3, 1e-5];

/// Breakpoints of different joints closer than this share of their segment, or
/// than this many seconds, become one.
const TOGETHER: [f64; 2] = [1e-11, 3e-12];

/// What rounding may add to a position limit, relative to it or to 1.
const ROUNDING: f64 = 1e-10;

/// Constant jerk for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// When it starts, counted from the segment's start, s.
    pub start: f64,
    /// How long it lasts, s.
    pub length: f64,
    /// Position since the waypoint that the segment starts from, velocity and acceleration where it starts, and jerk.
    pub state: [f64; 4],
}

impl Phase {
    /// Position, velocity and acceleration `t` after the start, and jerk.
    pub fn at(&self, t: f64) -> [f64; 4] {
        let [x, v, a, j] = self.state;
        [x + t * (v + t * (a / 2.0 + t * j / 6.0)), v + t * (a + t * j / 2.0), a + t * j, j]
    }

    /// Largest magnitudes of velocity, acceleration and jerk.
    pub fn peaks(&self) -> [f64; 3] {
        let [_, v, a, j] = self.state;
        let [_, v1, a1, _] = self.at(self.length);
        let mut speed = v.abs().max(v1.abs());
        // Speed turns where acceleration changes sign.
        if a * a1 < 0.0 {
            speed = speed.max((v - a * a / (2.0 * j)).abs());
        }
        [speed, a.abs().max(a1.abs()), j.abs()]
    }

    /// Smallest and largest position.
    pub fn range(&self) -> [f64; 2] {
        let [x, v, a, j] = self.state;
        let end = self.at(self.length)[0];
        let mut range = [x.min(end), x.max(end)];
        // Position turns at the roots of v + a t + j t²/2, in the form that does not cancel.
        let discriminant = a * a - 2.0 * j * v;
        if discriminant >= 0.0 {
            let q = -(a + libm::copysign(libm::sqrt(discriminant), a));
            for t in [2.0 * v / q, q / j] {
                if t > 0.0 && t < self.length {
                    let [x, ..] = self.at(t);
                    range = [range[0].min(x), range[1].max(x)];
                }
            }
        }
        range
    }

    /// The same motion `factor` times as slow.
    pub fn stretch(&mut self, factor: f64) {
        self.start *= factor;
        self.length *= factor;
        let mut divisor = 1.0;
        for value in &mut self.state {
            *value /= divisor;
            divisor *= factor;
        }
    }
}

/// `phases[joint][segment]`: every joint's motion.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Of each segment, s.
    pub durations: Vec<f64>,
    /// What position, velocity and acceleration cost where each segment starts.
    pub prices: Prices,
    /// What each limit of each joint holds back in each segment, see [`super::Fastest::gains`].
    pub gains: Vec<Vec<[f64; 3]>>,
    /// What each joint does in each segment; times count from the segment's start.
    pub phases: Vec<Vec<Vec<Phase>>>,
}

impl Motion {
    /// A motion of `joints` that has not yet begun.
    pub fn empty(joints: usize) -> Self {
        Self { durations: vec![], prices: vec![], gains: vec![], phases: vec![vec![]; joints] }
    }

    /// Of the whole, s.
    pub fn duration(&self) -> f64 {
        self.durations.iter().sum()
    }

    /// The first `segments` and the others.
    pub fn split(mut self, segments: usize) -> (Self, Self) {
        let durations = self.durations.split_off(segments);
        let prices = self.prices.split_off(segments);
        let gains = self.gains.split_off(segments);
        let phases = self.phases.iter_mut().map(|joint| joint.split_off(segments)).collect();
        (self, Self { durations, prices, gains, phases })
    }

    /// A copy of the segments in `range`.
    pub fn segments(&self, range: Range<usize>) -> Self {
        Self {
            durations: self.durations[range.clone()].to_vec(),
            prices: self.prices[range.clone()].to_vec(),
            gains: self.gains[range.clone()].to_vec(),
            phases: self.phases.iter().map(|joint| joint[range.clone()].to_vec()).collect(),
        }
    }

    /// Continues with `other`.
    pub fn append(&mut self, other: Self) {
        self.durations.extend(other.durations);
        self.prices.extend(other.prices);
        self.gains.extend(other.gains);
        for (joint, phases) in self.phases.iter_mut().zip(other.phases) {
            joint.extend(phases);
        }
    }

    /// The same motion backwards in time: velocities and jerks change sign, accelerations do not.
    pub fn reversed(mut self) -> Self {
        for joint in &mut self.phases {
            // By how much the waypoint is missed where the segment ends.
            let mut miss = 0.0;
            for segment in joint.iter_mut().rev() {
                let (Some(first), Some(last)) = (segment.first(), segment.last()) else { continue };
                let way = last.at(last.length)[0] - miss;
                let end = last.start + last.length;
                miss = first.state[0];
                for phase in segment.iter_mut() {
                    let [x, v, a, j] = phase.at(phase.length);
                    phase.start = end - (phase.start + phase.length);
                    phase.state = [x - way, -v, a, -j];
                }
                segment.reverse();
            }
            joint.reverse();
        }
        self.durations.reverse();
        self.gains.reverse();
        // What was paid where a segment starts is now given back where it ends.
        self.prices.reverse();
        self.prices.rotate_right(1);
        for [position, _, acceleration] in self.prices.iter_mut().flatten() {
            (*position, *acceleration) = (-*position, -*acceleration);
        }
        self
    }

    /// Each joint's velocity and acceleration at the end.
    pub fn end(&self) -> Vec<[f64; 2]> {
        let end = |joint: &Vec<Vec<Phase>>| {
            let last = joint.last().and_then(|phases| phases.last());
            last.map_or([0.0; 2], |phase| {
                let [_, v, a, _] = phase.at(phase.length);
                [v, a]
            })
        };
        self.phases.iter().map(end).collect()
    }

    /// The largest share of a limit that is used, as the factor by which the
    /// motion would have to be slower to use exactly all of it.
    pub fn ratio(&self, limits: Bounds) -> f64 {
        let mut ratio = 0.0f64;
        for (joint, segments) in self.phases.iter().enumerate() {
            let mut worst = [0.0f64; 3];
            for (segment, phases) in segments.iter().enumerate() {
                let limits = limits.of(segment, joint);
                for phase in phases {
                    for ((worst, peak), limit) in worst.iter_mut().zip(phase.peaks()).zip(limits) {
                        let share = peak / limit;
                        // Not-a-number must not get lost.
                        *worst = if share > *worst || share.is_nan() { share } else { *worst };
                    }
                }
            }
            for value in [worst[0], libm::sqrt(worst[1]), libm::cbrt(worst[2])] {
                ratio = if value > ratio || value.is_nan() { value } else { ratio };
            }
        }
        ratio
    }

    /// Where a stop would keep positions within their limits: of every segment that leaves
    /// them by more than rounding the waypoint that is nearer in time, unless the motion
    /// rests there already. In ascending order.
    pub fn stops_within(&self, waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Vec<usize> {
        let last = self.durations.len();
        let mut stops = Vec::new();
        for (segment, duration) in self.durations.iter().enumerate() {
            for (joint, limit) in limits.iter().enumerate() {
                let [lower, upper] = limit.position;
                let slack = |limit: f64| ROUNDING * limit.abs().max(1.0);
                let outside = self.phases[joint][segment].iter().find(|phase| {
                    let [least, most] = phase.range().map(|x| x + waypoints[segment][joint]);
                    least < lower - slack(lower) || most > upper + slack(upper)
                });
                let Some(phase) = outside else { continue };
                let early = phase.start + 0.5 * phase.length < 0.5 * duration;
                let start = segment + 1 == last || early && segment > 0;
                stops.push(if start { segment } else { segment + 1 });
            }
        }
        stops.sort_unstable();
        stops.dedup();
        stops.retain(|stop| (1..last).contains(stop));
        stops
    }

    /// The same motion `factor` times as slow.
    pub fn stretch(&mut self, factor: f64) {
        self.durations.iter_mut().for_each(|h| *h *= factor);
        self.phases.iter_mut().flatten().flatten().for_each(|phase| phase.stretch(factor));
    }

    /// By how much each joint deviates from the waypoint that `segment` starts from.
    pub fn deviations(&self, segment: usize) -> Vec<f64> {
        let first = |joint: &Vec<Vec<Phase>>| {
            let phase = joint.get(segment).and_then(|phases| phases.first());
            phase.map_or(0.0, |phase| phase.state[0])
        };
        self.phases.iter().map(first).collect()
    }

    /// As one piecewise polynomial, with the times of the waypoints.
    pub fn trajectory(&self, waypoints: &[Vec<f64>]) -> (Trajectory, Vec<f64>) {
        let mut breakpoints = vec![0.0];
        let mut times = vec![0.0];
        let mut pieces = Vec::new();
        let mut start = 0.0;
        for (segment, &length) in self.durations.iter().enumerate() {
            let cuts = self.cuts(segment);
            let mut now = vec![0usize; self.phases.len()];
            for pair in cuts.windows(2) {
                let middle = 0.5 * (pair[0] + pair[1]);
                let piece =
                    self.phases.iter().zip(&mut now).enumerate().map(|(joint, (segments, now))| {
                        let phases = &segments[segment];
                        while *now + 1 < phases.len() && phases[*now + 1].start <= middle {
                            *now += 1;
                        }
                        let [x, v, a, j] = phases[*now].at(pair[0] - phases[*now].start);
                        vec![waypoints[segment][joint] + x, v, a / 2.0, j / 6.0]
                    });
                pieces.push(piece.collect());
                breakpoints.push(start + pair[1]);
            }
            start += length;
            if let Some(last) = breakpoints.last_mut() {
                *last = start;
            }
            times.push(start);
        }
        (Trajectory { breakpoints, pieces }, times)
    }

    /// Where any joint's jerk changes in a segment, from 0 to its duration.
    fn cuts(&self, segment: usize) -> Vec<f64> {
        let length = self.durations[segment];
        let near = (TOGETHER[0] * length).max(TOGETHER[1]);
        let mut all: Vec<f64> =
            self.phases.iter().flat_map(|joint| joint[segment].iter().map(|p| p.start)).collect();
        all.sort_by(f64::total_cmp);
        let mut cuts = vec![0.0];
        for cut in all {
            if cut - cuts[cuts.len() - 1] > near && length - cut > near {
                cuts.push(cut);
            }
        }
        cuts.push(length);
        cuts
    }
}

/// One joint's segment of the programme: durations of pieces and acceleration
/// at (or, where jerk is free, in) each.
struct Course {
    smooth: bool,
    lengths: Vec<f64>,
    /// At the end of each piece.
    accelerations: Vec<f64>,
    /// Velocity and acceleration at the start.
    start: [f64; 2],
}

impl Course {
    fn new(problem: &Problem, point: &Iterate, joint: usize, segment: usize) -> Self {
        let (group, lane) = (joint / WIDTH, joint % WIDTH);
        let k = problem.cells;
        let all = problem.segments * k;
        let smooth = problem.groups[group].smooth.0[lane] > 0.0;
        let limits = problem.groups[group].limits.map(|limit| limit.0[lane]);
        let [_, v, a] = before(problem, point, group, segment * k, lane);
        let mut course = Self { smooth, lengths: vec![], accelerations: vec![], start: [v, a] };
        let mut from = a;
        let mut last = f64::NAN;
        for q in 0..k {
            let c = segment * k + q;
            let length = problem.shares[group * all + c].0[lane] * point.durations[segment];
            let to = point.cells[group * all + c].s[2].0[lane];
            let value = if smooth { (to - from) / length } else { to };
            // A piece whose value is that of the piece before continues it.
            let whole = length + course.lengths.last().copied().unwrap_or(0.0);
            let alike = if smooth {
                (ALIKE[0] * limits[2])
                    .min(ALIKE[1] * limits[1] / whole)
                    .min(ALIKE[1] * limits[0] / (whole * whole))
            } else {
                (ALIKE[0] * limits[1]).min(ALIKE[1] * limits[0] / whole)
            };
            if (value - last).abs() <= alike && k - q + course.lengths.len() > 4 {
                let end = course.lengths.len() - 1;
                course.lengths[end] += length;
                if smooth {
                    course.accelerations[end] = to;
                } else {
                    let whole = course.lengths[end];
                    course.accelerations[end] += (to - course.accelerations[end]) * length / whole;
                }
            } else {
                course.lengths.push(length);
                course.accelerations.push(to);
                last = value;
            }
            from = to;
        }
        course
    }

    /// Pieces of constant jerk from the accelerations.
    fn phases(&self) -> Vec<Phase> {
        let mut phases = Vec::with_capacity(self.lengths.len());
        let [mut v, mut a] = self.start;
        let (mut x, mut start) = (0.0, 0.0);
        for (&length, &end) in self.lengths.iter().zip(&self.accelerations) {
            let jerk = if self.smooth { (end - a) / length } else { 0.0 };
            let phase =
                Phase { start, length, state: [x, v, if self.smooth { a } else { end }, jerk] };
            [x, v, _, _] = phase.at(length);
            a = end;
            start += length;
            phases.push(phase);
        }
        phases
    }

    /// Changes the accelerations a little so that the course ends `way` from where it
    /// started, at velocity `end`.
    ///
    /// What is added is a quadratic and a cubic bump over the whole segment (a constant and a
    /// slope where acceleration may jump), so that jerk changes evenly however short pieces are.
    fn restore(&mut self, way: f64, end: f64) {
        let count = self.lengths.len();
        let total: f64 = self.lengths.iter().sum();
        let free = if self.smooth { count - 1 } else { count };
        for _ in 0..2 {
            let phases = self.phases();
            let Some(last) = phases.last() else { return };
            let [x, v, _, _] = last.at(last.length);
            let miss = [way - x, end - v];
            // How the bumps change position and velocity at the end.
            let mut effects = [[0.0; 2]; 2];
            let mut bumps = Vec::with_capacity(free);
            let mut passed = 0.0;
            for q in 0..free {
                let t = self.lengths[q];
                passed += t;
                let rest = total - passed;
                let (position, velocity, bump) = if self.smooth {
                    let next = self.lengths[q + 1];
                    let u = passed / total;
                    let position =
                        t * (t / 6.0 + rest / 2.0) + next * (next / 3.0 + (rest - next) / 2.0);
                    let bump = u * (1.0 - u);
                    (position, (t + next) / 2.0, [bump, bump * (1.0 - 2.0 * u)])
                } else {
                    let u = (passed - t / 2.0) / total;
                    (t * (t / 2.0 + rest), t, [1.0, 1.0 - 2.0 * u])
                };
                for (e, bump) in bump.iter().enumerate() {
                    effects[0][e] += position * bump;
                    effects[1][e] += velocity * bump;
                }
                bumps.push(bump);
            }
            let [[a, b], [c, d]] = effects;
            let determinant = a * d - b * c;
            let factors = [
                (d * miss[0] - b * miss[1]) / determinant,
                (a * miss[1] - c * miss[0]) / determinant,
            ];
            for (acceleration, bump) in self.accelerations.iter_mut().zip(&bumps) {
                *acceleration += bump[0] * factors[0] + bump[1] * factors[1];
            }
        }
    }
}

/// The Lagrangian's slopes over the states where segments start, as prices in s, rad and m: what a
/// state is worth for all that follows, it costs.
///
/// At the bound of a room the slope over the position differs before and after the waypoint. Both are right and what lies
/// between them, too; halfway, the prices do not depend on the direction of time.
fn in_seconds(slopes: &[[Lanes; 3]], units: &Units, segments: usize) -> Prices {
    let price = |segment: usize, joint: usize| {
        let of = |segment: usize| {
            let slope = &slopes[joint / WIDTH * segments + segment];
            slope.map(|slope| slope.0[joint % WIDTH])
        };
        let [after, v, a] = of(segment);
        // The multiplier of a way is the same all along its segment.
        let [before, ..] = of(segment.saturating_sub(1));
        let x = 0.5 * (before + after);
        let per_speed = units.time * units.time / units.length[joint];
        [-x * (units.time / units.length[joint]), -v * per_speed, -a * per_speed * units.time]
    };
    let joints = units.length.len();
    let row = |segment: usize| (0..joints).map(|joint| price(segment, joint)).collect();
    (0..segments).map(row).collect()
}

/// How much time each limit costs, in s per relative change: its multipliers times the limit,
/// `[segment][joint]` of velocity, acceleration and jerk.
fn gains(problem: &Problem, point: &Iterate, units: &Units) -> Vec<Vec<[f64; 3]>> {
    let (n, k) = (problem.segments, problem.cells);
    let one = |segment: usize, joint: usize| {
        let (group, lane) = (joint / WIDTH, joint % WIDTH);
        let mut sums = [0.0; 3];
        for c in segment * k..(segment + 1) * k {
            let z = point.cells[group * n * k + c].z.map(|z| z.0[lane]);
            // At the goal velocity is given and its limit says nothing.
            let at_end = if c + 1 < n * k { z[4] + z[5] } else { 0.0 };
            let share = problem.shares[group * n * k + c].0[lane];
            sums[0] += at_end + z[6] + z[7];
            sums[1] += z[2] + z[3];
            // The limit is on the change of acceleration in a cell: jerk times its duration.
            sums[2] += (z[0] + z[1]) * share * point.durations[segment];
        }
        let limits = problem.groups[group].limits.map(|limit| limit.0[lane]);
        [0, 1, 2].map(|e| if limits[e] < FREE { sums[e] * limits[e] * units.time } else { 0.0 })
    };
    let joints = units.length.len();
    let row = |segment: usize| (0..joints).map(|joint| one(segment, joint)).collect();
    (0..n).map(row).collect()
}

/// The motion that a solved programme describes, in seconds, rad and m; `prices` as in
/// [`super::work::Work`].
///
/// Waypoints and continuity hold to rounding, limits only nearly.
pub fn motion(problem: &Problem, point: &Iterate, prices: &[[Lanes; 3]], units: &Units) -> Motion {
    let (n, k) = (problem.segments, problem.cells);
    let phases = (0..units.length.len()).map(|joint| {
        let (group, lane) = (joint / WIDTH, joint % WIDTH);
        let segment = |segment: usize| {
            let mut course = Course::new(problem, point, joint, segment);
            let end = &point.cells[group * n * k + (segment + 1) * k - 1];
            let from = start_of(problem, point, group, segment * k, lane);
            course.restore(end.s[0].0[lane] - from, end.s[1].0[lane]);
            let mut phases = course.phases();
            for phase in &mut phases {
                phase.stretch(units.time);
                phase.state[0] += from;
                phase.state = phase.state.map(|value| value * units.length[joint]);
            }
            phases
        };
        (0..n).map(segment).collect()
    });
    Motion {
        phases: phases.collect(),
        durations: point.durations.iter().map(|h| h * units.time).collect(),
        prices: in_seconds(prices, units, n),
        gains: gains(problem, point, units),
    }
}
