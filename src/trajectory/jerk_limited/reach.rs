//! How far one joint can get in a given time between two velocities and accelerations.
//!
//! For a given duration the lawful motions between two states form a convex set, so that the
//! displacements they reach form an interval. Its upper end is what [`Reach`] knows; the lower
//! end is that of the mirrored states. Both are closed forms of the duration.
//!
//! # The farthest motion
//!
//! By Pontryagin's principle jerk is `+J` first, `-J` in the middle and `+J` at the end, with
//! acceleration held at `A` or `-A` and velocity at `V` in between. Extend the first and last
//! part, forwards or backwards in time, to where acceleration is zero: after `lag = a/J` back
//! from the start and `lag = -a/J` on from the goal, at velocities `base = v - a²/2J`. The
//! extended motion is a rise from rest of acceleration at one base to a peak velocity `p`
//! and a fall to the other base, and each is symmetric: it takes
//!
//! ```text
//! tau(u) = 2 sqrt(u/J) where u <= A²/J, else u/A + A/J,   u = p - base,
//! ```
//!
//! and covers `tau (p + base)/2`. With `s² = u/J` a negative `s` is the motion whose acceleration
//! turns before it has come to zero: the same formulas describe it.
//! All that follows is in units in which jerk and, if it has a limit, acceleration have
//! limit 1 (in units of acceleration where jerk has no limit), and in extended time.

/// A part of the curve of displacement over duration that has one formula.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// No ramp reaches the limit of acceleration; the parameter is the sum of both `s`.
    Free,
    /// That from or to the lower base does; the parameter is the other's `s`.
    Half,
    /// Both do; the parameter is the peak velocity.
    Full,
}

/// Constant jerk for a while: duration, acceleration at the start and jerk.
pub type Stroke = [f64; 3];

/// The strokes of an extreme motion, some of them of no duration.
pub type Strokes = [Stroke; 7];

/// What rounding may change in a velocity or displacement, relative to the terms it is the sum of.
pub const NOISE: f64 = 4e-15;

/// Half widths of the gap are taken to be at least this, so that noise stays small.
const SHORT: f64 = 3e-3;

/// Safeguarded Newton steps end sooner; halving alone would need no more than this.
const STEPS: usize = 100;

/// The farthest displacement as a function of duration.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Velocity at zero acceleration; the lower one first.
    base: [f64; 2],
    /// Times from zero acceleration, in the same order.
    lag: [f64; 2],
    /// Whether the lower base is the goal's.
    swapped: bool,
    /// Difference and mean of the bases.
    rise: f64,
    mean: f64,
    /// Time from zero acceleration to its limit.
    ramp: f64,
    speed: f64,
    /// Extended durations between which the parts hold: `Half`, `Free`, `Half` and `Full`; then
    /// that at which the limit of velocity is reached.
    knots: [f64; 3],
    cruising: f64,
    /// What extension adds to durations and displacements.
    delay: f64,
    shift: f64,
    /// What rounding may change in a velocity, the shortest duration and its displacement.
    noise: [f64; 3],
    /// Extended durations that the change of velocity and acceleration allows.
    spans: [[f64; 2]; 2],
}

impl Reach {
    /// From and to velocities and accelerations `v` and `a`, where `ramp` is 0 without a limit of
    /// jerk, infinite without one of acceleration and else 1.
    pub fn new(v: [f64; 2], a: [f64; 2], speed: f64, ramp: f64) -> Self {
        let lag = if ramp > 0.0 { [a[0], -a[1]] } else { [0.0; 2] };
        let base = [v[0] - lag[0] * lag[0] / 2.0, v[1] - lag[1] * lag[1] / 2.0];
        let part = |i: usize| lag[i] * (base[i] + lag[i] * lag[i] / 6.0);
        let noise = NOISE * (v[0].abs() + v[1].abs() + lag[0] * lag[0] + lag[1] * lag[1]);
        let mut reach = Self {
            base,
            lag,
            swapped: false,
            rise: 0.0,
            mean: (base[0] + base[1]) / 2.0,
            ramp,
            speed,
            knots: [0.0; 3],
            cruising: f64::INFINITY,
            delay: lag[0] + lag[1],
            shift: part(0) + part(1),
            noise: [noise, 0.0, 0.0],
            spans: [[0.0; 2]; 2],
        };
        reach.arrange();
        reach.knots = reach.knots();
        reach.spans = reach.spans();
        reach.measure_noise();
        if speed.is_finite() {
            let time =
                reach.ramp_time(speed - reach.base[0]) + reach.ramp_time(speed - reach.base[1]);
            // The states may touch the limit: then rounding must not take the last span.
            reach.cruising = time.max(reach.spans[1][0]);
        }
        reach
    }

    /// Puts the lower base first.
    ///
    /// One stroke of positive jerk connects states of equal base, one of negative jerk those whose outer
    /// strokes both vanish. Whether it does must not depend on rounding: where the
    /// goal moves, the next duration possible may be far longer.
    fn arrange(&mut self) {
        let Self { base: [from, to], lag: [first, last], noise: [noise, ..], .. } = *self;
        let level = (to - from).abs() <= noise;
        self.swapped = if level { last > first } else { from > to };
        if self.swapped {
            self.lag.swap(0, 1);
            self.base.swap(0, 1);
        }
        let [lower, upper] = self.lag;
        let single = lower * lower - upper * upper;
        self.rise = self.base[1] - self.base[0];
        if level {
            self.rise = 0.0;
        } else if single >= 0.0 && (self.rise - single).abs() <= noise {
            self.rise = single;
        }
        self.base[1] = self.base[0] + self.rise;
    }

    /// Velocity changes with duration as the acceleration says at which jerk turns; at the edges
    /// of the gap that is its half width. A change of duration changes displacement.
    fn measure_noise(&mut self) {
        let Self { lag: [lower, upper], base, rise, noise: [noise, ..], .. } = *self;
        let half = libm::sqrt((lower * lower - rise).max(0.0));
        let moved = noise / half.max(SHORT);
        let times = self.earliest() + lower.abs() + upper.abs();
        self.noise = [noise, moved, noise * times + moved * (base[0].abs() + base[1].abs())];
    }

    /// Time of a symmetric change of velocity.
    fn ramp_time(&self, change: f64) -> f64 {
        let change = change.max(0.0);
        if change < self.ramp * self.ramp { 2.0 * libm::sqrt(change) } else { change + self.ramp }
    }

    fn knots(&self) -> [f64; 3] {
        let Self { rise, ramp, .. } = *self;
        if ramp == 0.0 {
            return [rise; 3];
        }
        if ramp.is_infinite() {
            return [0.0, ramp, ramp];
        }
        let width = if rise < 1.0 { libm::sqrt(1.0 - rise) } else { 0.0 };
        // Without a free part the two halves are one.
        let free =
            if rise < 1.0 { [rise / (1.0 + width) * 2.0, 2.0 + 2.0 * width] } else { [rise; 2] };
        [free[0], free[1], 4.0 + rise]
    }

    /// Where both outer strokes have durations of at least zero. Between the spans the change
    /// of velocity and acceleration alone is impossible; the first may be empty.
    fn spans(&self) -> [[f64; 2]; 2] {
        let Self { rise, ramp, lag: [lower, upper], .. } = *self;
        let square = upper * upper + rise;
        let start = if square >= ramp * ramp {
            upper * (upper + 2.0) + rise + ramp
        } else if upper >= 0.0 {
            2.0 * (libm::sqrt(square) + upper)
        } else {
            2.0 * rise / (libm::sqrt(square) - upper)
        };
        let gap = lower * lower - rise;
        if lower <= 0.0 || gap <= 0.0 {
            return [[f64::NEG_INFINITY; 2], [start, f64::INFINITY]];
        }
        let half = libm::sqrt(gap);
        let edges = [2.0 * rise / (lower + half), 2.0 * (lower + half)];
        let first = if upper < 0.0 && gap <= upper * upper + self.noise[0] {
            [start, edges[0].max(start)]
        } else {
            [f64::NEG_INFINITY; 2]
        };
        [first, [if upper > half { start } else { edges[1] }, f64::INFINITY]]
    }

    fn part(&self, time: f64) -> Part {
        let [first, second, third] = self.knots;
        match time {
            _ if time >= third => Part::Full,
            _ if time < first || time >= second => Part::Half,
            _ => Part::Free,
        }
    }

    fn parameter(&self, part: Part, time: f64) -> f64 {
        match part {
            Part::Free => time / 2.0,
            Part::Half => libm::sqrt((time - self.rise).max(0.0)) - 1.0,
            Part::Full => time / 2.0 + self.mean - self.ramp,
        }
    }

    fn time(&self, part: Part, p: f64) -> f64 {
        match part {
            Part::Free => 2.0 * p,
            Part::Half => (p + 1.0) * (p + 1.0) + self.rise,
            Part::Full => 2.0 * (p - self.mean + self.ramp),
        }
    }

    /// Displacement of the extended motion.
    fn value(&self, part: Part, p: f64) -> f64 {
        let [lower, upper] = self.base;
        match part {
            Part::Free if p == 0.0 => 0.0,
            Part::Free => p * (2.0 * self.mean + p * p / 4.0) - self.rise * self.rise / (4.0 * p),
            Part::Half => {
                let peak = upper + p * p;
                (peak + lower) * (peak - lower + 1.0) / 2.0 + p * (upper + peak)
            }
            Part::Full => {
                let change = [p - lower, p - upper];
                (p + lower) * (change[0] + self.ramp) / 2.0
                    + (p + upper) * (change[1] + self.ramp) / 2.0
            }
        }
    }

    fn slope(&self, part: Part, p: f64) -> f64 {
        match part {
            Part::Free => {
                let ratio = self.rise / p;
                2.0 * self.mean + 0.75 * p * p + ratio * ratio / 4.0
            }
            Part::Half => (p + 1.0) * (p * (2.0 * p + 1.0) + 2.0 * self.base[1]),
            Part::Full => 2.0 * p + self.ramp,
        }
    }

    /// Where the slope changes its sign, in ascending order.
    fn turns(&self, part: Part) -> [f64; 2] {
        let none = [f64::NAN; 2];
        match part {
            Part::Free => {
                let square = 4.0 * self.mean * self.mean - 0.75 * self.rise * self.rise;
                if self.mean >= 0.0 || square <= 0.0 {
                    return none;
                }
                let far = libm::sqrt(square) - 2.0 * self.mean;
                // The product of both roots' squares is rise²/3.
                [self.rise / libm::sqrt(2.0 * far), libm::sqrt(far / 1.5)]
            }
            Part::Half => {
                let square = 1.0 - 16.0 * self.base[1];
                if square <= 0.0 {
                    return none;
                }
                let root = libm::sqrt(square);
                [(-1.0 - root) / 4.0, (-1.0 + root) / 4.0]
            }
            Part::Full => [f64::NAN, -self.ramp / 2.0],
        }
    }

    /// Where between `low` and `high` the displacement passes `goal`; it does not turn between.
    fn crossing(&self, part: Part, [mut low, mut high]: [f64; 2], goal: f64, rises: bool) -> f64 {
        if part == Part::Full {
            // p² + ramp p = rest, in the form that does not cancel.
            let [lower, upper] = self.base;
            let rest = goal + (lower * lower + upper * upper) / 2.0 - self.ramp * self.mean;
            let root = libm::sqrt((self.ramp * self.ramp / 4.0 + rest).max(0.0));
            let p = if rises { rest / (root + self.ramp / 2.0) } else { -self.ramp / 2.0 - root };
            return if p.is_nan() { low } else { p.clamp(low, high) };
        }
        if high.is_infinite() {
            // There the cube outweighs all other terms.
            let cube = libm::cbrt(4.0 * goal.abs());
            high = 4.0
                * cube.max(libm::sqrt(8.0 * self.mean.abs())).max(libm::sqrt(self.rise)).max(low);
        }
        let sign = if rises { 1.0 } else { -1.0 };
        let ends = [self.value(part, low) - goal, self.value(part, high) - goal];
        let mut p = low - ends[0] * (high - low) / (ends[1] - ends[0]);
        for _ in 0..STEPS {
            if !(p > low && p < high) {
                p = low + (high - low) / 2.0;
                if p <= low || p >= high {
                    break;
                }
            }
            let miss = self.value(part, p) - goal;
            if sign * miss < 0.0 {
                low = p
            } else {
                high = p
            };
            let step = miss / self.slope(part, p);
            p -= step;
            if step.abs() <= 4.0 * f64::EPSILON * p.abs() {
                break;
            }
        }
        p.clamp(low, high)
    }

    /// The extended duration without that of cruising, and that.
    fn extended(&self, duration: f64) -> (f64, f64) {
        let time = duration + self.delay;
        let [first, second] = self.spans;
        // Rounding may have led out of a span.
        if time < second[0] && time - first[1] < second[0] - time {
            return (time.max(first[0]).min(first[1]), 0.0);
        }
        let time = time.max(second[0]);
        (time.min(self.cruising), (time - self.cruising).max(0.0))
    }

    /// Farthest displacement after `duration`.
    pub fn displacement(&self, duration: f64) -> f64 {
        let (time, cruise) = self.extended(duration);
        let part = self.part(time);
        let value = self.value(part, self.parameter(part, time)) - self.shift;
        if cruise > 0.0 { value + cruise * self.speed } else { value }
    }

    /// The shortest duration at all.
    pub fn earliest(&self) -> f64 {
        let [first, second] = self.spans;
        let start = if first[0].is_finite() { first[0] } else { second[0] };
        start - self.delay
    }

    /// What rounding may change in the duration and displacement of the shortest motion.
    pub fn noise(&self) -> [f64; 2] {
        [self.noise[1], self.noise[2]]
    }

    /// Durations at which `way` does not exceed the farthest displacement, in ascending order.
    /// Where just one displacement can be reached, `way` may differ from it by `slack`.
    pub fn windows(&self, way: f64, slack: f64, windows: &mut Vec<[f64; 2]>) {
        windows.clear();
        for span in self.spans {
            if span[0].is_finite() {
                Scan { reach: self, goal: way + self.shift, open: None, windows }.span(span, slack);
            }
        }
    }

    /// The motion that gets there.
    pub fn strokes(&self, duration: f64) -> Strokes {
        let Self { base, ramp, rise, .. } = *self;
        let (time, cruise) = self.extended(duration);
        let part = self.part(time);
        let p = self.parameter(part, time);
        let (mut ramps, mut holds) = match part {
            Part::Free => {
                // At no extended time at all jerk never changes.
                let ratio = if p > 0.0 { rise / p } else { -2.0 * self.lag[1] };
                let fall = ((p - ratio) / 2.0).max(self.lag[1]);
                ([p - fall, fall], [0.0; 2])
            }
            Part::Half => ([1.0, p], [p * p + rise - 1.0, 0.0]),
            Part::Full => ([ramp; 2], base.map(|base| p - base - ramp)),
        };
        let mut lag = self.lag;
        if self.swapped {
            ramps.swap(0, 1);
            holds.swap(0, 1);
            lag.swap(0, 1);
        }
        strokes(lag, ramps, holds, cruise)
    }
}

/// A motion from its two ramps, the times it holds their accelerations and velocity.
fn strokes(lag: [f64; 2], ramps: [f64; 2], holds: [f64; 2], cruise: f64) -> Strokes {
    let [rise, fall] = ramps;
    // Without a limit of jerk acceleration is in units of its limit, whatever the ramp.
    let unit = |ramp: f64, hold: f64| if ramp == 0.0 && hold > 0.0 { 1.0 } else { ramp };
    let [most, least] = [unit(rise, holds[0]), -unit(fall, holds[1])];
    // A fall of acceleration that nothing interrupts is one stroke; it may be shorter than either part.
    let [down, cruise, on] =
        if cruise > 0.0 { [rise, cruise, fall] } else { [rise + fall, 0.0, 0.0] };
    [
        [rise - lag[0], lag[0], 1.0],
        [holds[0], most, 0.0],
        [down, rise, -1.0],
        [cruise, 0.0, 0.0],
        [on, 0.0, -1.0],
        [holds[1], least, 0.0],
        [fall - lag[1], -fall, 1.0],
    ]
}

/// The fastest change from velocity and acceleration to rest, upwards: `velocity` at zero
/// acceleration must not be positive. In the units of [`Reach`].
pub fn rise_to_rest(velocity: f64, acceleration: f64, ramp: f64) -> Strokes {
    let lag = if ramp > 0.0 { acceleration } else { 0.0 };
    let change = (lag * lag / 2.0 - velocity).max(0.0);
    let (rise, hold) =
        if change < ramp * ramp { (libm::sqrt(change), 0.0) } else { (ramp, change - ramp) };
    strokes([lag, 0.0], [rise, 0.0], [hold, 0.0], 0.0)
}

/// A walk along the curve of displacement.
struct Scan<'a> {
    reach: &'a Reach,
    /// Displacement of the extended motion that is wanted.
    goal: f64,
    /// Since when it is exceeded.
    open: Option<f64>,
    windows: &'a mut Vec<[f64; 2]>,
}

impl Scan<'_> {
    fn span(mut self, [from, to]: [f64; 2], slack: f64) {
        let Reach { knots: [first, second, third], cruising, speed, .. } = *self.reach;
        if self.at(from) >= self.goal - slack {
            self.open = Some(from);
        }
        let until = to.min(cruising);
        let parts = [
            (Part::Half, 0.0, first),
            (Part::Free, first, second),
            (Part::Half, second, third),
            (Part::Full, third, f64::INFINITY),
        ];
        for (part, low, high) in parts {
            let (low, high) = (low.max(from), high.min(until));
            if low < high {
                self.part(part, low, high);
            }
        }
        if to.is_infinite() && cruising.is_finite() && self.open.is_none() {
            self.open = Some(cruising + (self.goal - self.at(cruising)).max(0.0) / speed);
        }
        match self.open {
            Some(open) => self.close(open, to),
            None if self.at(to) >= self.goal - slack => self.close(to, to),
            None => {}
        }
    }

    fn at(&self, time: f64) -> f64 {
        let part = self.reach.part(time);
        self.reach.value(part, self.reach.parameter(part, time))
    }

    fn close(&mut self, open: f64, end: f64) {
        self.windows.push([open, end].map(|time| time - self.reach.delay));
    }

    fn part(&mut self, part: Part, low: f64, high: f64) {
        let reach = self.reach;
        let [mut low, high] = [low, high].map(|time| reach.parameter(part, time));
        for end in reach.turns(part).into_iter().chain([high]) {
            // A turn outside (or none) is no end.
            if !(end > low && end <= high) {
                continue;
            }
            let above = end.is_infinite() || reach.value(part, end) >= self.goal;
            if above != self.open.is_some() {
                let time = reach.time(part, reach.crossing(part, [low, end], self.goal, above));
                match self.open.take() {
                    Some(open) => self.close(open, time),
                    None => self.open = Some(time),
                }
            }
            low = end;
        }
    }
}
