//! The linear programme of a payment, for eight cases at a time.
//!
//! A chain of steps leads from the state at the start over the cells' mean velocities to the state
//! at the end; see [`super::payment`] for what it relaxes. A primal-dual interior point method looks for good
//! multipliers: it starts from rest in the middle of all limits, so that only the way is missing, and
//! a Newton step is a recursion along the chain. What multipliers prove is computed from them alone.

use pulp::WithSimd;

use crate::math::lanes::{Lanes, Mask, Simd, Vector, registers};

/// Cells of equal length into which a segment is divided.
pub const CELLS: usize = 32;

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

/// What rounding may change in a sum over all steps, as a share of the magnitudes that enter it: the
/// multipliers of impossible durations are huge and cancel.
const ROUNDING: f64 = 1e-13;

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

/// A state of the programme, eight cases at a time. Index 0 is the start, `k + 1` after step `k`.
struct Point {
    /// Step of the mean acceleration, mean acceleration, velocity.
    y: [[Lanes; 3]; STEPS + 1],
    /// Multipliers of `y <= limit` and `-y <= limit`.
    z: [[[Lanes; 2]; 3]; STEPS + 1],
    /// Multiplier of the way.
    lambda: Lanes,
    /// Deviations at the start and at the end, and multipliers of `y <= room` and `-y <= room`.
    deviations: [Lanes; 2],
    bounds: [[Lanes; 2]; 2],
}

/// Whether a limit counts: there is no step before the start, and the last leaves velocity as it is.
const fn counts(index: usize, row: usize) -> bool {
    !(index == 0 && row == 0 || index == STEPS && row == 2)
}

/// The cases in units of their own: velocity limit, cell and duration are one.
pub struct Scaled {
    /// Of mean acceleration and of its differences.
    pub limits: [Lanes; 2],
    /// The sum of all mean velocities.
    pub way: Lanes,
    /// Prices of velocity and acceleration at the start and the end.
    pub enter: [Lanes; 2],
    pub leave: [Lanes; 2],
    /// By how much the position may deviate at the start and at the end, and its prices there.
    pub rooms: [Lanes; 2],
    pub positions: [Lanes; 2],
    /// One where the start is at rest, else zero.
    pub from_rest: Lanes,
}

/// Solves eight cases; returns `lambda D`, and what the limits of velocity, acceleration and
/// jerk take from it, all in units of the duration, and `lambda`.
pub struct Solve<'a>(pub &'a Scaled, pub usize);

impl WithSimd for Solve<'_> {
    type Output = [Lanes; 5];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Lanes; 5] {
        let Self(scaled, used) = self;
        let mut found = [Lanes::ZERO; 5];
        let mut point = Point {
            y: [[Lanes::ZERO; 3]; STEPS + 1],
            z: [[[Lanes::ZERO; 2]; 3]; STEPS + 1],
            lambda: Lanes::ZERO,
            deviations: [Lanes::ZERO; 2],
            bounds: [[Lanes::ZERO; 2]; 2],
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
    rooms: [Vector<S>; 2],
    /// Where there is room.
    open: [Mask<S>; 2],
    /// What a deviation at the start costs, and one at the end.
    positions: [Vector<S>; 2],
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

/// Those, steps of the deviations, and the multiplier of the way.
type Newton<S> = (Steps<S>, [Vector<S>; 2], Vector<S>);

impl<S: Simd> Programme<S> {
    #[inline(always)]
    fn load(simd: S, scaled: &Scaled, part: usize) -> Self {
        let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
        let zero = Vector::splat(simd, 0.0);
        let rooms = [load(&scaled.rooms[0]), load(&scaled.rooms[1])];
        Self {
            simd,
            part,
            acceleration: load(&scaled.limits[0]),
            jerk: load(&scaled.limits[1]),
            way: load(&scaled.way),
            enter: [load(&scaled.enter[0]), load(&scaled.enter[1])],
            leave: [load(&scaled.leave[0]), load(&scaled.leave[1])],
            from_rest: Vector::splat(simd, 0.5).below(load(&scaled.from_rest)),
            rooms,
            open: rooms.map(|room| zero.below(room)),
            positions: [load(&scaled.positions[0]), zero - load(&scaled.positions[1])],
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
    fn solve(&self, point: &mut Point) -> [Vector<S>; 5] {
        for index in 0..=STEPS {
            for row in 0..3 {
                self.splat(0.0).store(&mut point.y[index][row], self.part);
                let z = self.splat(BARRIER) / self.limit(index, row);
                z.store(&mut point.z[index][row][0], self.part);
                z.store(&mut point.z[index][row][1], self.part);
            }
        }
        for side in 0..2 {
            self.splat(0.0).store(&mut point.deviations[side], self.part);
            let z = self.splat(BARRIER) / self.open[side].select(self.rooms[side], self.splat(1.0));
            for bound in &mut point.bounds[side] {
                z.store(bound, self.part);
            }
        }
        let mut missing = self.way;
        let mut mu = BARRIER;
        let one = self.splat(1.0);
        let total =
            |[way, v, a, j, lambda]: [Vector<S>; 5]| way - v - a - j - self.lost_in_rooms(lambda);
        let mut best = self.value(point);
        let most = self.splat(1.0)
            + self.leave[0].abs()
            + self.enter[0].abs()
            + (self.leave[1].abs() + self.enter[1].abs()) * self.acceleration
            + self.positions[0].abs() * self.rooms[0]
            + self.positions[1].abs() * self.rooms[1];
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

    /// What deviations take from `lambda D` at most.
    #[inline(always)]
    fn lost_in_rooms(&self, lambda: Vector<S>) -> Vector<S> {
        let [enter, leave] = self.positions;
        (enter - lambda).abs() * self.rooms[0] + (leave + lambda).abs() * self.rooms[1]
    }

    /// Inverse weight and slope of the barrier for a deviation; zero where there is no room.
    #[inline(always)]
    fn room(&self, point: &Point, side: usize, mu: f64) -> [Vector<S>; 2] {
        let (zero, one) = (self.splat(0.0), self.splat(1.0));
        let y = self.load_lanes(&point.deviations[side]);
        let room = self.open[side].select(self.rooms[side], one);
        let [up, down] = &point.bounds[side];
        let [upper, lower] = [one / (room - y), one / (room + y)];
        let weight = self.load_lanes(up) * upper + self.load_lanes(down) * lower;
        let only = |value| self.open[side].select(value, zero);
        [only(one / weight), only((upper - lower) * mu + self.positions[side])]
    }

    /// The Newton step, and the multiplier of the way it leads to.
    #[inline(always)]
    fn newton(&self, point: &Point, missing: Vector<S>, mu: f64) -> Newton<S> {
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
        let [[give_enter, slope_enter], [give_leave, slope_leave]] =
            [0, 1].map(|side| self.room(point, side, mu));
        m1 = m1 + slope_enter * give_enter - slope_leave * give_leave;
        m2 = m2 - give_enter - give_leave;
        let lambda = zero - (missing + m1) / m2;
        let deviations =
            [(lambda - slope_enter) * give_enter, (zero - lambda - slope_leave) * give_leave];
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
        (steps, deviations, lambda)
    }

    /// Moves as far as the limits allow. Returns what is still missing of the way.
    #[inline(always)]
    fn advance(
        &self,
        point: &mut Point,
        (steps, deviations, lambda): &Newton<S>,
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
        let mut turns = [[zero; 2]; 2];
        for side in 0..2 {
            let room = self.open[side].select(self.rooms[side], one);
            let y = self.load_lanes(&point.deviations[side]);
            for (bound, sign) in [(0, 1.0), (1, -1.0)] {
                let inverse = one / (room - y * sign);
                let share = deviations[side] * sign * inverse;
                let z = self.load_lanes(&point.bounds[side][bound]);
                let change = inverse * mu - z + z * share;
                let only = |value| self.open[side].select(value, zero);
                turns[side][bound] = only(change);
                slack = slack.max(share);
                price = price.max(only(zero - change / z));
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
                for (z, change) in point.z[index][row].iter_mut().zip(changes[index][row]) {
                    (self.load_lanes(z) + change * dual).store(z, self.part);
                }
            }
        }
        for side in 0..2 {
            let y = &mut point.deviations[side];
            (self.load_lanes(y) + deviations[side] * primal).store(y, self.part);
            for (z, change) in point.bounds[side].iter_mut().zip(turns[side]) {
                (self.load_lanes(z) + change * dual).store(z, self.part);
            }
        }
        let old = self.load_lanes(&point.lambda);
        (old + (*lambda - old) * dual).store(&mut point.lambda, self.part);
        missing - missing * primal
    }

    /// What the multipliers prove, see [`Solve`].
    #[inline(always)]
    fn value(&self, point: &Point) -> [Vector<S>; 5] {
        let zero = self.splat(0.0);
        let lambda = self.load_lanes(&point.lambda);
        let (mut velocity, mut acceleration, mut jerk) = (zero, zero, zero);
        let mut costate = [zero - self.leave[0], zero - self.leave[1]];
        // The same sums of magnitudes.
        let mut size = [self.leave[0].abs(), self.leave[1].abs()];
        let mut lost = zero;
        let net = |index: usize, row: usize| {
            let [up, down] = &point.z[index][row];
            self.load_lanes(up) - self.load_lanes(down)
        };
        for k in (0..STEPS).rev() {
            let zm = net(k + 1, 1);
            acceleration = acceleration + zm.abs();
            costate[1] = costate[1] + zm;
            size[1] = size[1] + zm.abs();
            if counts(k + 1, 2) {
                let zv = net(k + 1, 2);
                velocity = velocity + zv.abs();
                costate[0] = costate[0] + zv;
                size[0] = size[0] + zv.abs();
            }
            if k < CELLS {
                costate[0] = costate[0] - lambda;
                size[0] = size[0] + lambda.abs();
            }
            costate[1] = costate[1] + costate[0] * weight(k);
            size[1] = size[1] + size[0] * weight(k);
            jerk = jerk + costate[1].abs() * reach(k);
            lost = lost + size[1] * reach(k);
        }
        let start = [costate[0] + self.enter[0], costate[1] + self.enter[1]];
        let free = |value: Vector<S>| self.from_rest.select(zero, value.abs());
        velocity = velocity + free(start[0]);
        acceleration = acceleration + free(start[1]);
        velocity = velocity + (size[0] + self.enter[0].abs()) * ROUNDING;
        acceleration = acceleration + (size[1] + self.enter[1].abs()) * ROUNDING;
        jerk = jerk + lost * ROUNDING;
        let (acceleration, jerk) = (acceleration * self.acceleration, jerk * self.jerk);
        [lambda * self.way, velocity, acceleration, jerk, lambda]
    }
}
