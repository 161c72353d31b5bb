//! A lower bound on what one joint pays for one segment of given duration.
//!
//! The joint pays `p · s` for the state `s = (v, a)` in which it enters and gets back `p' · s'` for the one in which
//! it leaves. The least payment over all lawful curves is a linear programme in infinitely many variables. We relax it to
//! finitely many: the segment is divided into cells of length `T`, the variables are their mean velocities `w_k`, the
//! mean accelerations `m_k` (times `T`) from one cell's centre to the next, and the states at the ends. A mean is
//! within the limits of what it is a mean of, so that
//!
//! ```text
//! |w_k| <= V,   m_k = w_k - w_(k-1),   |m_k| <= A T,   |m_(k+1) - m_k| <= J T²,   sum w_k = D / T
//! ```
//!
//! hold for every lawful curve; at the ends the same holds for half cells, see [`weight`] and [`reach`].
//!
//! Any multipliers of this finite programme give a lower bound, however they were found. An
//! interior point method finds good ones for eight cases at a time, [`Minorant`] holds
//! what they prove, also of other durations.

use pulp::{Arch, WithSimd};

use crate::math::lanes::{Lanes, Mask, Simd, Vector, WIDTH, registers};

/// Cells of equal length into which a segment is divided.
const CELLS: usize = 32;

/// Steps from the state at the start to that at the end: half a cell, `CELLS - 1` from centre
/// to centre, half a cell, and one that only acceleration takes.
const STEPS: usize = CELLS + 2;

/// The last step.
const LAST: usize = STEPS - 1;

/// Interior point iterations.
const ITERATIONS: usize = 12;

/// Barrier parameter at the start, in units of the segment's duration.
const BARRIER: f64 = 0.1;

/// The barrier parameter at the end at least.
const LAST_BARRIER: f64 = 1e-7;

/// By what the barrier parameter falls in an iteration.
const FALL: f64 = 0.2;

/// How much of the way to the nearest limit a step may go.
const NEAR: f64 = 0.99;

/// How far velocity moves with the mean acceleration of a step.
const fn weight(step: usize) -> f64 {
    match step {
        0 | CELLS => 0.5,
        LAST => 0.0,
        _ => 1.0,
    }
}

/// By how much two neighbouring mean accelerations may differ, in `J T`: the distance of the centroids
/// of what they are means over, in cells. At the ends they are triangles over half
/// the width, whose centroids lie at a third of a cell, and the state itself.
const fn reach(step: usize) -> f64 {
    match step {
        0 | LAST => 1.0 / 3.0,
        1 | CELLS => 2.0 / 3.0,
        _ => 1.0,
    }
}

/// Mean accelerations that any velocities admit, in units of their limit: half a cell from one limit to the other.
const ANY_ACCELERATION: f64 = 4.0;

/// Differences of mean accelerations that any accelerations admit, in units of their
/// limit: twice the limit, of which [`reach`] takes two thirds.
const ANY_JERK: f64 = 3.0;

/// One joint, one segment, one duration.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Duration, s.
    pub duration: f64,
    /// Way, rad or m.
    pub way: f64,
    /// Limits of velocity, acceleration and jerk. Velocity's is finite; prices on acceleration count
    /// only where jerk's is.
    pub limits: [f64; 3],
    /// What velocity and acceleration cost at the start: s per rad/s and per rad/s².
    pub enter: [f64; 2],
    /// What they give back at the end.
    pub leave: [f64; 2],
    /// Whether the joint starts at rest: then `enter` does not count.
    pub from_rest: bool,
}

impl Case {
    /// The same for a joint that ends at rest, with time running backwards: its way and
    /// velocities change sign, accelerations do not.
    pub fn backwards(&self) -> Self {
        let [v, a] = self.enter;
        let (way, enter, leave) = (-self.way, [0.0; 2], [v, -a]);
        Self { way, enter, leave, from_rest: true, ..*self }
    }
}

/// A lower bound on the payment for any duration `h = r h0`, good near the one it was made for:
/// `fixed + linear r + inverse / r - square r² - kink |r - 1|`.
///
/// The multipliers of the way, of velocity, of acceleration and of jerk limits stay the same in units that scale
/// with `h`; only prices on acceleration do not fit any more, by `kink`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Minorant {
    /// The duration `h0` for which it was made, s.
    pub duration: f64,
    fixed: f64,
    linear: f64,
    inverse: f64,
    square: f64,
    kink: f64,
}

impl Minorant {
    /// What all joints pay, and the time itself; all made for the same duration.
    pub fn sum(joints: &[Self]) -> Self {
        let duration = joints.first().map_or(0.0, |joint| joint.duration);
        let mut sum = Self { duration, linear: duration, ..Self::default() };
        for joint in joints {
            sum.fixed += joint.fixed;
            sum.linear += joint.linear;
            sum.inverse += joint.inverse;
            sum.square += joint.square;
            sum.kink += joint.kink;
        }
        sum
    }

    /// The bound at a duration.
    pub fn at(&self, duration: f64) -> f64 {
        let r = duration / self.duration;
        // Convex in r: its tangent is below, and concave with the rest, so that between
        // two durations the least value is at one of them.
        let inverse = if self.inverse > 0.0 { 2.0 - r } else { 1.0 / r };
        self.fixed + self.linear * r + self.inverse * inverse
            - self.square * r * r
            - self.kink * (r - 1.0).abs()
    }
}

/// A state of the programme, eight cases at a time. Index 0 is the start, `k + 1` after step `k`.
struct Point {
    /// Step of the mean acceleration, mean acceleration, velocity.
    y: [[Lanes; 3]; STEPS + 1],
    /// Multipliers of `y <= limit` and `-y <= limit`.
    z: [[[Lanes; 2]; 3]; STEPS + 1],
    /// Multiplier of the way.
    lambda: Lanes,
}

/// Whether a limit counts: there is no step before the start, and the last leaves velocity as it is.
const fn counts(index: usize, row: usize) -> bool {
    !(index == 0 && row == 0 || index == STEPS && row == 2)
}

/// The cases in units of their own: velocity limit, cell and duration are one.
struct Scaled {
    limits: [Lanes; 2],
    way: Lanes,
    enter: [Lanes; 2],
    leave: [Lanes; 2],
    from_rest: Lanes,
}

impl Scaled {
    fn new(cases: &[Case]) -> Self {
        let each = |f: &dyn Fn(&Case) -> f64| {
            let values: Vec<f64> = cases.iter().map(f).collect();
            Lanes::from_slice(&values, values[0])
        };
        let t = |case: &Case| case.duration / CELLS as f64;
        let price = |case: &Case, price: [f64; 2], e: usize| {
            let per = case.limits[0] / case.duration;
            if e == 0 { price[0] * per } else { price[1] * per / t(case) }
        };
        let acceleration = |c: &Case| {
            let limit = c.limits[1] * t(c) / c.limits[0];
            if limit.is_finite() { limit } else { ANY_ACCELERATION }
        };
        let jerk = |c: &Case| {
            let limit = c.limits[2] * t(c) * t(c) / c.limits[0];
            if limit.is_finite() { limit } else { ANY_JERK * acceleration(c) }
        };
        Self {
            limits: [each(&acceleration), each(&jerk)],
            way: each(&|c| c.way / (t(c) * c.limits[0])),
            enter: [0, 1].map(|e| each(&|c| price(c, c.enter, e))),
            leave: [0, 1].map(|e| each(&|c| price(c, c.leave, e))),
            from_rest: each(&|c| f64::from(u8::from(c.from_rest))),
        }
    }
}

/// Bounds for all `cases`, in their order.
pub fn minorants(cases: &[Case]) -> Vec<Minorant> {
    let arch = Arch::new();
    let mut all = Vec::with_capacity(cases.len());
    for chunk in cases.chunks(WIDTH) {
        let scaled = Scaled::new(chunk);
        let values = arch.dispatch(Solve(&scaled, chunk.len()));
        for (lane, case) in chunk.iter().enumerate() {
            let [lambda, velocity, acceleration, jerk] = values.map(|v| v.0[lane]);
            let h = case.duration;
            let entered = if case.from_rest { 0.0 } else { case.enter[1].abs() };
            let mut minorant = Minorant {
                duration: h,
                fixed: -h * velocity,
                inverse: h * lambda,
                ..Minorant::default()
            };
            // What stands for a limit that does not exist scales as the next that does.
            let [_, has_acceleration, has_jerk] = case.limits.map(f64::is_finite);
            let slower = if has_acceleration { &mut minorant.linear } else { &mut minorant.fixed };
            *slower -= h * acceleration;
            if has_jerk {
                minorant.square = h * jerk;
                minorant.kink = case.limits[1] * (entered + case.leave[1].abs());
            } else {
                *slower -= h * jerk;
            }
            all.push(minorant);
        }
    }
    all
}

/// Solves eight cases; returns `lambda D`, and what the limits of velocity, acceleration and
/// jerk take from it, all in units of the duration.
struct Solve<'a>(&'a Scaled, usize);

impl WithSimd for Solve<'_> {
    type Output = [Lanes; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Lanes; 4] {
        let Self(scaled, used) = self;
        let mut found = [Lanes::ZERO; 4];
        let mut point = Point {
            y: [[Lanes::ZERO; 3]; STEPS + 1],
            z: [[[Lanes::ZERO; 2]; 3]; STEPS + 1],
            lambda: Lanes::ZERO,
        };
        for part in 0..registers::<S>(used) {
            let programme = Programme::load(simd, scaled, part);
            for (value, lanes) in programme.solve(&mut point).into_iter().zip(&mut found) {
                value.store(lanes, part);
            }
        }
        found
    }
}

/// One register of cases.
struct Programme<S: Simd> {
    simd: S,
    part: usize,
    acceleration: Vector<S>,
    jerk: Vector<S>,
    way: Vector<S>,
    enter: [Vector<S>; 2],
    leave: [Vector<S>; 2],
    from_rest: Mask<S>,
}

/// What the forward pass needs of a step.
#[derive(Clone, Copy)]
struct Gain<S: Simd> {
    state: [Vector<S>; 2],
    known: Vector<S>,
    along: Vector<S>,
}

/// Steps of `y`, by index and row.
type Steps<S> = [[Vector<S>; 3]; STEPS + 1];

impl<S: Simd> Programme<S> {
    #[inline(always)]
    fn load(simd: S, scaled: &Scaled, part: usize) -> Self {
        let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
        Self {
            simd,
            part,
            acceleration: load(&scaled.limits[0]),
            jerk: load(&scaled.limits[1]),
            way: load(&scaled.way),
            enter: [load(&scaled.enter[0]), load(&scaled.enter[1])],
            leave: [load(&scaled.leave[0]), load(&scaled.leave[1])],
            from_rest: Vector::splat(simd, 0.5).below(load(&scaled.from_rest)),
        }
    }

    #[inline(always)]
    fn splat(&self, value: f64) -> Vector<S> {
        Vector::splat(self.simd, value)
    }

    #[inline(always)]
    fn load_lanes(&self, lanes: &Lanes) -> Vector<S> {
        Vector::load(self.simd, lanes, self.part)
    }

    /// The limit of row `row` at `index`.
    #[inline(always)]
    fn limit(&self, index: usize, row: usize) -> Vector<S> {
        match row {
            0 => self.jerk * reach(index.saturating_sub(1)),
            1 => self.acceleration,
            _ => self.splat(1.0),
        }
    }

    /// The best of what the multipliers of all iterations prove: where no curve is
    /// lawful they have no end.
    #[inline(always)]
    fn solve(&self, point: &mut Point) -> [Vector<S>; 4] {
        for index in 0..=STEPS {
            for row in 0..3 {
                self.splat(0.0).store(&mut point.y[index][row], self.part);
                let z = self.splat(BARRIER) / self.limit(index, row);
                z.store(&mut point.z[index][row][0], self.part);
                z.store(&mut point.z[index][row][1], self.part);
            }
        }
        let mut missing = self.way;
        let mut mu = BARRIER;
        let one = self.splat(1.0);
        let total = |[way, v, a, j]: [Vector<S>; 4]| way - v - a - j;
        let mut best = self.value(point);
        let most = self.splat(1.0)
            + self.leave[0].abs()
            + self.enter[0].abs()
            + (self.leave[1].abs() + self.enter[1].abs()) * self.acceleration;
        for _ in 0..ITERATIONS {
            mu = (mu * FALL).max(LAST_BARRIER);
            let steps = self.newton(point, missing, mu);
            missing = self.advance(point, &steps, missing, mu);
            let value = self.value(point);
            let [old, new] = [total(best), total(value)];
            // Beyond `most` more is no use, and steep multipliers say little of durations near by. What
            // two sets of multipliers prove, any mixture of them proves as well.
            let share = ((most - old) / (new - old)).min(one);
            let better = old.below(new).and(old.below(most));
            for (best, value) in best.iter_mut().zip(value) {
                *best = better.select(*best + (value - *best) * share, *best);
            }
        }
        best
    }

    /// Weight and slope of the barrier for row `row` at `index`.
    #[inline(always)]
    fn barrier(&self, point: &Point, index: usize, row: usize, mu: f64) -> [Vector<S>; 2] {
        let limit = self.limit(index, row);
        let y = self.load_lanes(&point.y[index][row]);
        let [up, down] = &point.z[index][row];
        let upper = self.splat(1.0) / (limit - y);
        let lower = self.splat(1.0) / (limit + y);
        [self.load_lanes(up) * upper + self.load_lanes(down) * lower, (upper - lower) * mu]
    }

    /// The Newton step, and the multiplier of the way it leads to.
    #[inline(always)]
    fn newton(&self, point: &Point, missing: Vector<S>, mu: f64) -> (Steps<S>, Vector<S>) {
        let zero = self.splat(0.0);
        let one = self.splat(1.0);
        let none = Gain { state: [zero; 2], known: zero, along: zero };
        let mut gains = [none; STEPS];
        // P: vv, vm, mm; slopes: known, and along lambda.
        let mut p = [zero; 3];
        let mut q = [zero - self.leave[0], zero - self.leave[1]];
        let mut l = [zero; 2];
        let (mut m1, mut m2) = (zero, zero);
        for k in (0..STEPS).rev() {
            let index = k + 1;
            let [w, g] = self.barrier(point, index, 1, mu);
            p[2] = p[2] + w;
            q[1] = q[1] + g;
            if counts(index, 2) {
                let [w, g] = self.barrier(point, index, 2, mu);
                p[0] = p[0] + w;
                q[0] = q[0] + g;
            }
            if k < CELLS {
                l[0] = l[0] - one;
            }
            let gamma = weight(k);
            let [w, g] = self.barrier(point, index, 0, mu);
            // P c with c = (gamma, 1), which is also P F's second column.
            let pc = [p[0] * gamma + p[1], p[1] * gamma + p[2]];
            let both = pc[0] * gamma + pc[1];
            let inverse = one / (both + w);
            let row = [pc[0], both];
            let known = q[0] * gamma + q[1] + g;
            let along = l[0] * gamma + l[1];
            let gain = [row[0] * inverse, row[1] * inverse];
            gains[k] = Gain { state: gain, known: known * inverse, along: along * inverse };
            p = [p[0] - row[0] * gain[0], pc[0] - row[0] * gain[1], both - row[1] * gain[1]];
            q = [q[0] - gain[0] * known, q[0] * gamma + q[1] - gain[1] * known];
            l = [l[0] - gain[0] * along, l[0] * gamma + l[1] - gain[1] * along];
            m1 = m1 - known * along * inverse;
            m2 = m2 - along * along * inverse;
        }
        let [wm, gm] = self.barrier(point, 0, 1, mu);
        let [wv, gv] = self.barrier(point, 0, 2, mu);
        p = [p[0] + wv, p[1], p[2] + wm];
        q = [q[0] + gv + self.enter[0], q[1] + gm + self.enter[1]];
        let inverse = one / (p[0] * p[2] - p[1] * p[1]);
        let solve = |b: [Vector<S>; 2]| {
            let x = [p[1] * b[1] - p[2] * b[0], p[1] * b[0] - p[0] * b[1]];
            [
                self.from_rest.select(zero, x[0] * inverse),
                self.from_rest.select(zero, x[1] * inverse),
            ]
        };
        let (start, turn) = (solve(q), solve(l));
        m1 = m1 + l[0] * start[0] + l[1] * start[1];
        m2 = m2 + l[0] * turn[0] + l[1] * turn[1];
        let lambda = zero - (missing + m1) / m2;
        let mut state = [start[0] + lambda * turn[0], start[1] + lambda * turn[1]];
        let mut steps = [[zero; 3]; STEPS + 1];
        steps[0] = [zero, state[1], state[0]];
        for k in 0..STEPS {
            let Gain { state: gain, known, along } = gains[k];
            let d = zero - (gain[0] * state[0] + gain[1] * state[1] + known + along * lambda);
            let m = state[1] + d;
            let v = state[0] + m * weight(k);
            state = [v, m];
            steps[k + 1] = [d, m, v];
        }
        (steps, lambda)
    }

    /// Moves as far as the limits allow. Returns what is still missing of the way.
    #[inline(always)]
    fn advance(
        &self,
        point: &mut Point,
        (steps, lambda): &(Steps<S>, Vector<S>),
        missing: Vector<S>,
        mu: f64,
    ) -> Vector<S> {
        let (zero, one) = (self.splat(0.0), self.splat(1.0));
        let (mut slack, mut price) = (one, one);
        let mut changes = [[[zero; 2]; 3]; STEPS + 1];
        for index in 0..=STEPS {
            for row in 0..3 {
                if !counts(index, row) {
                    continue;
                }
                let limit = self.limit(index, row);
                let y = self.load_lanes(&point.y[index][row]);
                let step = steps[index][row];
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let inverse = one / (limit - y * sign);
                    let share = step * sign * inverse;
                    let z = self.load_lanes(&point.z[index][row][side]);
                    let change = inverse * mu - z + z * share;
                    changes[index][row][side] = change;
                    slack = slack.max(share);
                    price = price.max(zero - change / z);
                }
            }
        }
        // Shares above one would pass a limit.
        let part = |largest: Vector<S>| (self.splat(NEAR) / largest).min(one);
        let (primal, dual) = (part(slack), part(price));
        for index in 0..=STEPS {
            for row in 0..3 {
                if !counts(index, row) {
                    continue;
                }
                let y = &mut point.y[index][row];
                (self.load_lanes(y) + steps[index][row] * primal).store(y, self.part);
                for side in 0..2 {
                    let z = &mut point.z[index][row][side];
                    (self.load_lanes(z) + changes[index][row][side] * dual).store(z, self.part);
                }
            }
        }
        let old = self.load_lanes(&point.lambda);
        (old + (*lambda - old) * dual).store(&mut point.lambda, self.part);
        missing - missing * primal
    }

    /// What the multipliers prove, see [`Solve`].
    #[inline(always)]
    fn value(&self, point: &Point) -> [Vector<S>; 4] {
        let zero = self.splat(0.0);
        let lambda = self.load_lanes(&point.lambda);
        let (mut velocity, mut acceleration, mut jerk) = (zero, zero, zero);
        let mut costate = [zero - self.leave[0], zero - self.leave[1]];
        let net = |index: usize, row: usize| {
            let [up, down] = &point.z[index][row];
            self.load_lanes(up) - self.load_lanes(down)
        };
        for k in (0..STEPS).rev() {
            let zm = net(k + 1, 1);
            acceleration = acceleration + zm.abs();
            costate[1] = costate[1] + zm;
            if counts(k + 1, 2) {
                let zv = net(k + 1, 2);
                velocity = velocity + zv.abs();
                costate[0] = costate[0] + zv;
            }
            if k < CELLS {
                costate[0] = costate[0] - lambda;
            }
            costate[1] = costate[1] + costate[0] * weight(k);
            jerk = jerk + costate[1].abs() * reach(k);
        }
        let start = [costate[0] + self.enter[0], costate[1] + self.enter[1]];
        let free = |value: Vector<S>| self.from_rest.select(zero, value.abs());
        velocity = velocity + free(start[0]);
        acceleration = acceleration + free(start[1]);
        [lambda * self.way, velocity, acceleration * self.acceleration, jerk * self.jerk]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;

    /// A random lawful curve: states at its ends, way and duration. Jerk is piecewise constant; the
    /// whole curve is scaled so that it just keeps `limits`.
    fn curve(
        random: &mut RandomStream,
        limits: [f64; 3],
        from_rest: bool,
    ) -> ([f64; 2], [f64; 2], f64, f64) {
        let mut state = [random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)];
        if from_rest {
            state = [0.0; 2];
        }
        let start = state;
        let (mut way, mut duration) = (0.0, 0.0);
        let mut peaks = [state[0].abs(), state[1].abs(), 0.0f64];
        for _ in 0..1 + (random.unit() * 8.0) as usize {
            let jerk = (random.unit() * 3.0).floor() - 1.0;
            let (steps, length) = (400, random.uniform(0.0, 1.5));
            let dt = length / f64::from(steps);
            for _ in 0..steps {
                let [v, a] = state;
                way += dt * (v + dt * (a / 2.0 + dt * jerk / 6.0));
                state = [v + dt * (a + dt * jerk / 2.0), a + dt * jerk];
                // Speed between the samples is above them by less than this.
                let beyond = dt * dt * jerk.abs() + 1e-9;
                peaks = [
                    peaks[0].max(state[0].abs() + beyond),
                    peaks[1].max(state[1].abs()),
                    peaks[2].max(jerk.abs()),
                ];
            }
            duration += length;
        }
        let scale = (0..3).map(|e| limits[e] / peaks[e]).fold(f64::INFINITY, f64::min);
        (start.map(|s| s * scale), state.map(|s| s * scale), way * scale, duration)
    }

    /// Draws limits over three decades, some of which do not exist, and prices of any size.
    fn draw(random: &mut RandomStream) -> ([f64; 3], [[f64; 2]; 2]) {
        let mut limit = |there: f64| {
            let value = 10f64.powf(random.uniform(-1.5, 1.5));
            if random.unit() < there { value } else { f64::INFINITY }
        };
        let limits = [limit(1.0), limit(0.85), limit(0.8)];
        let mut price = |e: usize| {
            let there = e == 0 || limits[2].is_finite();
            let size = 10f64.powf(random.uniform(-3.0, 1.0));
            if there { random.uniform(-1.0, 1.0) * size } else { 0.0 }
        };
        ([limits[0], limits[1].min(1e3), limits[2]], [[price(0), price(1)], [price(0), price(1)]])
    }

    /// Attack: curves that are lawful must never pay less than the bound, at the
    /// duration it was made for and at others.
    #[test]
    fn no_lawful_curve_pays_less_than_the_bound() {
        let mut random = RandomStream::new(5, 0);
        let (mut checked, mut close) = (0, 0);
        for round in 0..3000 {
            let from_rest = round % 3 == 0;
            let (limits, [enter, leave]) = draw(&mut random);
            let (start, end, way, duration) = curve(&mut random, limits, from_rest);
            let stretch = 2f64.powf(random.uniform(-1.0, 1.0));
            let case = Case { duration, way, limits, enter, leave, from_rest };
            let made = [
                case,
                Case { duration: duration * stretch, ..case },
                Case { duration: duration * 1.01, ..case },
            ];
            let pays =
                enter[0] * start[0] + enter[1] * start[1] - leave[0] * end[0] - leave[1] * end[1];
            for minorant in minorants(&made) {
                let bound = minorant.at(duration);
                let size = limits[0] * (enter[0].abs() + leave[0].abs());
                assert!(
                    bound <= pays + 1e-9 * size.max(1.0),
                    "{round}: {bound} > {pays}, {case:?}"
                );
                checked += 1;
                close += usize::from(bound > pays - 0.5 * size);
            }
        }
        assert_eq!(checked, 9000);
        assert!(close > 500, "only {close} bounds are near enough to test anything");
    }

    /// A joint paid for its speed at the end of a run-up from rest gains all that jerk admits, and
    /// what the bound says is that, nearly: `v = J h²/2`.
    #[test]
    fn the_bound_is_tight_where_the_optimum_is_known() {
        let (h, jerk) = (0.5, 8.0);
        let way = jerk * h * h * h / 6.0;
        let case = Case {
            duration: h,
            way,
            limits: [10.0, 50.0, jerk],
            enter: [0.0; 2],
            leave: [1.0, 0.0],
            from_rest: true,
        };
        let bound = minorants(&[case])[0].at(h);
        let optimum = -jerk * h * h / 2.0;
        assert!(bound <= optimum && bound > 1.01 * optimum, "{bound}, optimum {optimum}");
        // Braking to rest from the same speed, priced where it enters, is the same the other way round.
        let braking =
            Case { way: -way, enter: [1.0, 0.0], leave: [0.0; 2], from_rest: false, ..case };
        assert_eq!(minorants(&[braking.backwards()])[0].at(h), bound);
    }

    /// Where no lawful curve exists the bound rises without end, so that prices prove it.
    #[test]
    fn impossible_durations_cost_more_than_any_gain() {
        let case = Case {
            duration: 1.0,
            way: 1.5,
            limits: [2.0, 3.0, 10.0],
            enter: [0.0; 2],
            leave: [0.1, 0.0],
            from_rest: true,
        };
        let bounds = minorants(&[case, Case { duration: 1.6, ..case }]);
        assert!(bounds[0].at(1.0) > 1.0, "{}", bounds[0].at(1.0));
        assert!(bounds[1].at(1.6) < 0.0, "{}", bounds[1].at(1.6));
    }
}
