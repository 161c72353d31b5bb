//! The Newton system: a Riccati recursion backwards over the cells.
//!
//! The Newton step minimises a quadratic model over the linearised dynamics. Going backwards,
//! let `V(s) = s P s / 2 + s (p_0 + sum_k p_k theta_k) + theta M theta / 2` be the least value
//! of everything after a knot, as a function of the state's step `s = (dx, dv, da)` there and
//! of parameters `theta`: one, for what is known (column 0); the steps of the durations
//! (columns 1 to n); the multiplier of the segment's way and, in the last segment, those of
//! the goal's velocity and acceleration.
//!
//! A cell adds its barrier terms and substitutes `s' = F s + c u + e dh + r`, with `u` what is
//! left of the change of acceleration once it follows the duration as
//! `lean = J phi (w0 - w1) / (w0 + w1)`. That completes the square in the two jerk
//! limits with weights `w0`, `w1`, of which one is huge where the limit holds: their
//! parts in `dh` are then added, never subtracted.
//! Minimising over `u` leaves `V` before the cell. `P` stays positive semidefinite, because the
//! Lagrangian bends only along with durations: all its second derivatives are in `M` and the
//! columns of durations.
//!
//! At a waypoint the position is given, so its step is zero there and starts anew. Before the
//! segment's start its multipliers are eliminated: the value is concave in them. Where a joint has room
//! at a waypoint, the step of its deviation is a part of the state like any other instead.

use crate::math::lanes::{Lanes, Simd, Vector};

use super::chain::{Chain, ROWS, Room, View, total};
use super::problem::Iterate;
use super::work::{COLUMNS, Elimination, Residuals, Work};

/// The value function and the Lagrangian's slope while going backwards.
struct Value<S: Simd> {
    /// `P`: xx, xv, xa, vv, va, aa.
    p: [Vector<S>; 6],
    /// `p_k`, by column.
    columns: [[Vector<S>; 3]; COLUMNS],
    /// `M` below and on its diagonal; column 0 is the slope.
    m: [[Vector<S>; COLUMNS]; COLUMNS],
    /// Multipliers of the way, of velocity and of acceleration at the knot.
    costate: [Vector<S>; 3],
    /// The Lagrangian's slope over the segment's duration.
    gradient: Vector<S>,
    dual: Vector<S>,
    primal: Vector<S>,
    sum: Vector<S>,
    product: Vector<S>,
    /// By column: what only one cell needs, kept because clearing it for every cell would cost time.
    slopes: [Vector<S>; COLUMNS],
    controls: [Vector<S>; COLUMNS],
}

/// A cell's barrier terms.
struct Barrier<S: Simd> {
    /// Multipliers.
    z: [Vector<S>; ROWS],
    /// Inverse slacks times the barrier parameter.
    pull: [Vector<S>; ROWS],
    /// Weights: multiplier over slack.
    w: [Vector<S>; ROWS],
}

/// The end of a cell in terms of its duration and its change of acceleration.
struct Moves<S: Simd> {
    /// Along the change of acceleration: position and velocity (acceleration: one).
    c: [Vector<S>; 2],
    /// Along the segment's duration.
    e: [Vector<S>; 3],
    /// Of the middle control point of velocity: along acceleration and duration.
    middle: [Vector<S>; 2],
    /// Weight of both jerk limits together.
    weight: Vector<S>,
    /// Inverse curvature over `u`.
    inverse: Vector<S>,
    /// `P e`.
    pe: [Vector<S>; 3],
    /// `F^T P c` times `inverse`.
    gain: [Vector<S>; 3],
    /// By how much the dynamics are missed, and `P` times that.
    miss: [Vector<S>; 2],
    pr: [Vector<S>; 3],
}

/// `P y`.
#[inline(always)]
fn times<S: Simd>(p: &[Vector<S>; 6], y: [Vector<S>; 3]) -> [Vector<S>; 3] {
    let [xx, xv, xa, vv, va, aa] = *p;
    [
        xx * y[0] + xv * y[1] + xa * y[2],
        xv * y[0] + vv * y[1] + va * y[2],
        xa * y[0] + va * y[1] + aa * y[2],
    ]
}

/// One over each of `values`, with one division for two of them.
#[inline(always)]
pub fn inverses<S: Simd>(chain: &Chain<S>, values: &[Vector<S>; ROWS]) -> [Vector<S>; ROWS] {
    let mut inverses = *values;
    for pair in 0..ROWS / 2 {
        let [a, b] = [values[2 * pair], values[2 * pair + 1]];
        let both = chain.splat(1.0) / (a * b);
        (inverses[2 * pair], inverses[2 * pair + 1]) = (both * b, both * a);
    }
    inverses
}

/// `F^T y`: what a slope at the end of a cell is at its start.
#[inline(always)]
fn back<S: Simd>(t: Vector<S>, y: [Vector<S>; 3]) -> [Vector<S>; 3] {
    [y[0], t * y[0] + y[1], t * t * y[0] * 0.5 + t * y[1] + y[2]]
}

impl<S: Simd> Value<S> {
    #[inline(always)]
    fn new(chain: &Chain<S>) -> Self {
        let zero = chain.splat(0.0);
        Self {
            p: [zero; 6],
            columns: [[zero; 3]; COLUMNS],
            m: [[zero; COLUMNS]; COLUMNS],
            costate: [zero; 3],
            gradient: zero,
            dual: zero,
            primal: zero,
            sum: zero,
            product: zero,
            slopes: [zero; COLUMNS],
            controls: [zero; COLUMNS],
        }
    }

    /// Takes up the multipliers of segment `i` at its end. Returns the end of the columns.
    #[inline(always)]
    fn enter(
        &mut self,
        chain: &Chain<S>,
        point: &Iterate,
        i: usize,
        mu: f64,
        stored: &mut [Lanes; 2],
    ) -> usize {
        let (zero, one) = (chain.splat(0.0), chain.splat(1.0));
        let n = chain.segments;
        let local = n + 1;
        let last = i + 1 == n;
        let active = local + if last { 3 } else { 1 };
        for row in self.m[local..active].iter_mut() {
            *row = [zero; COLUMNS];
        }
        let lambda = chain.load(&point.lambda[chain.group * n + i]);
        if let Some(room) = chain.room(i) {
            self.deviate(chain, &room, lambda, mu, stored);
        } else {
            self.p[0] = zero;
            self.p[1] = zero;
            self.p[2] = zero;
            for column in self.columns.iter_mut().take(local) {
                column[0] = zero;
            }
            self.columns[local] = [one, zero, zero];
            self.costate[0] = lambda;
        }
        if last {
            let [v, a] = &point.goal[chain.group];
            self.costate[1] = chain.load(v);
            self.costate[2] = chain.load(a);
            self.columns[local + 1] = [zero, one, zero];
            // Where acceleration may jump, that at the goal is free: its multiplier is zero.
            let smooth = chain.limits.smooth;
            self.columns[local + 2] = [zero, zero, smooth];
            self.m[local + 2][local + 2] = smooth - one;
        }
        self.gradient = zero;
        active
    }

    /// Takes up the bounds on deviations where there is room, and the multiplier of the way where there is none; keeps
    /// the slacks' inverses.
    #[inline(always)]
    fn deviate(
        &mut self,
        chain: &Chain<S>,
        room: &Room<S>,
        lambda: Vector<S>,
        mu: f64,
        stored: &mut [Lanes; 2],
    ) {
        let (zero, one) = (chain.splat(0.0), chain.splat(1.0));
        let local = chain.segments + 1;
        let Room { open, slack, z } = room;
        let inverse = slack.map(|slack| one / slack);
        for (inverse, slot) in inverse.iter().zip(stored) {
            inverse.store(slot, chain.part);
        }
        let only = |value: Vector<S>| open.select(value, zero);
        for value in &mut self.p[..3] {
            *value = only(*value);
        }
        for column in self.columns.iter_mut().take(local) {
            column[0] = only(column[0]);
        }
        self.p[0] = self.p[0] + only(z[0] * inverse[0] + z[1] * inverse[1]);
        self.columns[0][0] = self.columns[0][0] + only((inverse[1] - inverse[0]) * mu);
        self.costate[0] = open.select(self.costate[0] + z[1] - z[0], lambda);
        let given = open.select(zero, one);
        self.columns[local] = [given, zero, zero];
        self.m[local][local] = given - one;
        for (z, slack) in z.iter().zip(slack) {
            self.product = self.product.max(only(*z * *slack));
        }
    }

    /// Adds the limits of velocity and acceleration at the end of cell `c`.
    #[inline(always)]
    fn knot(&mut self, chain: &Chain<S>, c: usize, barrier: &Barrier<S>) {
        let Barrier { z, pull, w } = barrier;
        if chain.counts(c, 4) {
            self.p[3] = self.p[3] + w[4] + w[5];
            self.columns[0][1] = self.columns[0][1] + pull[4] - pull[5];
            self.costate[1] = self.costate[1] + z[4] - z[5];
        }
        self.p[5] = self.p[5] + w[2] + w[3];
        self.columns[0][2] = self.columns[0][2] + pull[2] - pull[3];
        self.costate[2] = self.costate[2] + z[2] - z[3];
    }

    /// Barrier terms of cell `c`, and what it adds to the residuals; keeps the slacks' inverses.
    #[inline(always)]
    fn barrier(
        &mut self,
        chain: &Chain<S>,
        c: usize,
        view: &View<S>,
        mu: f64,
        stored: &mut [Lanes; ROWS],
    ) -> Barrier<S> {
        let zero = chain.splat(0.0);
        let mut barrier = Barrier { z: [zero; ROWS], pull: [zero; ROWS], w: [zero; ROWS] };
        let slack = view.slack(&chain.limits);
        let inverses = inverses(chain, &slack);
        for row in 0..ROWS {
            let z = chain.multiplier(c, row);
            inverses[row].store(&mut stored[row], chain.part);
            barrier.z[row] = z;
            barrier.pull[row] = inverses[row] * mu;
            barrier.w[row] = z * inverses[row];
            if chain.counts(c, row) {
                self.product = self.product.max(z * slack[row] * chain.limits.real);
            }
        }
        barrier
    }

    /// How the end of the cell moves, and `P` before the cell.
    #[inline(always)]
    fn state(&mut self, chain: &Chain<S>, view: &View<S>, barrier: &Barrier<S>) -> Moves<S> {
        let View { share, t, a, middle, .. } = *view;
        let w = &barrier.w;
        let [bx, bv] = view.along_duration(&chain.limits);
        let [cx, cv] = view.along_change(&chain.limits);
        let weight = w[0] + w[1];
        let lean = chain.limits.derivatives[2] * share * ((w[0] - w[1]) / weight);
        let e = [bx * share + cx * lean, bv * share + cv * lean, lean];
        let p = &self.p;
        let pc = times(p, [cx, cv, chain.splat(1.0)]);
        let pe = times(p, e);
        let miss = view.residual(&chain.limits);
        let pr = times(p, [miss[0], miss[1], chain.splat(0.0)]);
        let inverse = chain.splat(1.0) / (cx * pc[0] + cv * pc[1] + pc[2] + weight);
        let h = back(t, pc);
        let gain = [h[0] * inverse, h[1] * inverse, h[2] * inverse];
        let middle = [t * middle, a * middle];
        let wm = w[6] + w[7];
        let x = back(t, [p[0], p[1], p[2]]);
        let v = back(t, [t * p[0] + p[1], t * p[1] + p[3], t * p[2] + p[4]]);
        let half = t * t * 0.5;
        let end = [
            half * p[0] + t * p[1] + p[2],
            half * p[1] + t * p[3] + p[4],
            half * p[2] + t * p[4] + p[5],
        ];
        let aa = back(t, end)[2];
        self.p = [
            p[0] - h[0] * gain[0],
            x[1] - h[0] * gain[1],
            x[2] - h[0] * gain[2],
            v[1] + wm - h[1] * gain[1],
            v[2] + wm * middle[0] - h[1] * gain[2],
            aa + wm * middle[0] * middle[0] - h[2] * gain[2],
        ];
        Moves { c: [cx, cv], e, middle, weight, inverse, pe, gain, miss, pr }
    }

    /// What the own duration's column and row of `M` gain in a cell of segment `i`, beside
    /// what all columns gain. Returns the slope and the curvature along velocity,
    /// acceleration and `u`.
    #[inline(always)]
    fn own_duration(
        &mut self,
        chain: &Chain<S>,
        i: usize,
        view: &View<S>,
        barrier: &Barrier<S>,
        moves: &Moves<S>,
    ) -> [Vector<S>; 3] {
        let View { share, t, d, a, middle: in_middle, .. } = *view;
        let Barrier { z, pull, w } = barrier;
        let Moves { e, middle, miss, pe, .. } = moves;
        let own = i + 1;
        let jerk = chain.limits.derivatives[2] * share;
        let [in_position, in_velocity] = chain.limits.change;
        let [lambda, costate, _] = self.costate;
        let wm = w[6] + w[7];
        let middle_t = middle[1] * share;
        let along_u = (t * lambda * (in_position * 2.0) + in_velocity * costate) * share;
        let along_v = lambda * share + wm * middle_t;
        let along_a =
            (lambda * t + costate + (z[6] - z[7]) * in_middle) * share + wm * middle_t * middle[0];
        let known = self.columns[0];
        let column = self.columns[own];
        let slope = e[0] * known[0]
            + e[1] * known[1]
            + e[2] * known[2]
            + pe[0] * miss[0]
            + pe[1] * miss[1]
            + (pull[6] - pull[7]) * middle_t
            + (pull[0] - pull[1]) * e[2]
            - jerk * (pull[0] + pull[1]);
        let along = e[0] * column[0] + e[1] * column[1] + e[2] * column[2];
        let curvature = e[0] * pe[0]
            + e[1] * pe[1]
            + e[2] * pe[2]
            + along * 2.0
            + jerk * jerk * (w[0] * w[1] / moves.weight) * 4.0
            + wm * middle_t * middle_t
            + lambda * (a + d * in_position * 2.0) * share * share
            + along_u * e[2] * 2.0;
        self.m[own][0] = self.m[own][0] + slope;
        self.m[own][own] = self.m[own][own] + curvature;
        [along_v, along_a, along_u]
    }

    /// Brings all columns and `M` before a cell of segment `i`, and stores the columns of `u`.
    #[inline(always)]
    fn columns(
        &mut self,
        chain: &Chain<S>,
        (i, active): (usize, usize),
        view: &View<S>,
        barrier: &Barrier<S>,
        moves: &Moves<S>,
        stored: &mut [Lanes],
    ) {
        let own = i + 1;
        let Moves { c, e, miss, gain, inverse, .. } = moves;
        let bend = self.own_duration(chain, i, view, barrier, moves);
        let pull = &barrier.pull;
        for column in std::iter::once(0).chain(own..active) {
            let mut p = self.columns[column];
            if column == 0 {
                p = [p[0] + moves.pr[0], p[1] + moves.pr[1], p[2] + moves.pr[2]];
            } else {
                self.m[column][0] = self.m[column][0] + p[0] * miss[0] + p[1] * miss[1];
                if column == own {
                    p = [p[0] + moves.pe[0], p[1] + moves.pe[1], p[2] + moves.pe[2]];
                } else {
                    let along = p[0] * e[0] + p[1] * e[1] + p[2] * e[2];
                    self.m[column][own] = self.m[column][own] + along;
                }
            }
            let mut before = back(view.t, p);
            let mut slope = c[0] * p[0] + c[1] * p[1] + p[2];
            if column == 0 {
                let middle = pull[6] - pull[7];
                before[1] = before[1] + middle;
                before[2] = before[2] + middle * moves.middle[0];
                slope = slope + pull[0] - pull[1];
            } else if column == own {
                before[1] = before[1] + bend[0];
                before[2] = before[2] + bend[1];
                slope = slope + bend[2];
            }
            let control = slope * *inverse;
            control.store(&mut stored[column], chain.part);
            (self.slopes[column], self.controls[column]) = (slope, control);
            self.columns[column] = [
                before[0] - gain[0] * slope,
                before[1] - gain[1] * slope,
                before[2] - gain[2] * slope,
            ];
        }
        for row in own..active {
            let slope = self.slopes[row];
            self.m[row][0] = self.m[row][0] - slope * self.controls[0];
            for column in own..=row {
                self.m[row][column] = self.m[row][column] - slope * self.controls[column];
            }
        }
    }

    /// Eliminates the multipliers of segment `i` before its start.
    #[inline(always)]
    fn leave(&mut self, chain: &Chain<S>, (i, active): (usize, usize), stored: &mut [Elimination]) {
        let zero = chain.splat(0.0);
        let local = chain.segments + 1;
        for row in (local..active).rev() {
            let inverse = zero - chain.splat(1.0) / self.m[row][row];
            let slot = &mut stored[row - local];
            let [px, pv, pa] = self.columns[row];
            let state = [px * inverse, pv * inverse, pa * inverse];
            for (value, slot) in state.iter().zip(&mut slot.state) {
                value.store(slot, chain.part);
            }
            self.p[0] = self.p[0] + px * state[0];
            self.p[1] = self.p[1] + px * state[1];
            self.p[2] = self.p[2] + px * state[2];
            self.p[3] = self.p[3] + pv * state[1];
            self.p[4] = self.p[4] + pv * state[2];
            self.p[5] = self.p[5] + pa * state[2];
            let mut shares = [zero; COLUMNS];
            for column in std::iter::once(0).chain(i + 1..row) {
                let factor = self.m[row][column];
                shares[column] = factor * inverse;
                shares[column].store(&mut slot.columns[column], chain.part);
                let [x, v, a] = &mut self.columns[column];
                *x = *x + px * shares[column];
                *v = *v + pv * shares[column];
                *a = *a + pa * shares[column];
                if column > 0 {
                    self.m[column][0] = self.m[column][0] + factor * shares[0];
                    for other in i + 1..=column {
                        self.m[column][other] = self.m[column][other] + factor * shares[other];
                    }
                }
            }
        }
    }

    /// The slope of the Lagrangian over the cell, and its costate before the cell.
    #[inline(always)]
    fn lagrangian(
        &mut self,
        chain: &Chain<S>,
        view: &View<S>,
        barrier: &Barrier<S>,
        moves: &Moves<S>,
    ) {
        let View { share, t, .. } = *view;
        let Barrier { z, .. } = barrier;
        let [_, reach, jerk] = chain.limits.derivatives;
        let [lambda, v, a] = self.costate;
        let [bx, bv] = view.along_duration(&chain.limits);
        let [cx, cv] = moves.c;
        let real = chain.limits.real;
        let zm = z[6] - z[7];
        self.gradient = self.gradient
            + (bx * lambda + bv * v + moves.middle[1] * zm - jerk * (z[0] + z[1])) * share;
        let slope = cx * lambda + cv * v + a + z[0] - z[1];
        self.dual = self.dual.max((slope * (jerk * t).min(reach)).abs() * real);
        self.costate = back(t, self.costate);
        self.costate[1] = self.costate[1] + zm;
        self.costate[2] = self.costate[2] + moves.middle[0] * zm;
        for r in moves.miss {
            self.primal = self.primal.max(r.abs() * real);
            self.sum = self.sum + r.abs() * real;
        }
    }
}

/// Factorises the Newton system of one register of joints and adds what it says about
/// the durations to `work`.
#[inline(always)]
pub fn backward<S: Simd>(chain: &Chain<S>, point: &Iterate, work: &mut Work, mu: f64) -> Residuals {
    let (n, k, all, part) = (chain.segments, chain.cells, chain.all(), chain.part);
    let real = chain.limits.real;
    let stride = work.stride;
    let mut value = Value::new(chain);
    for i in (0..n).rev() {
        let kept = &mut work.berth_inverses[chain.group * n + i];
        let active = value.enter(chain, point, i, mu, kept);
        for c in (i * k..(i + 1) * k).rev() {
            let index = chain.group * all + c;
            let view = chain.view(c);
            let barrier = value.barrier(chain, c, &view, mu, &mut work.inverses[index]);
            value.knot(chain, c, &barrier);
            let moves = value.state(chain, &view, &barrier);
            let stored = &mut work.columns[index * stride..(index + 1) * stride];
            value.columns(chain, (i, active), &view, &barrier, &moves, stored);
            value.lagrangian(chain, &view, &barrier, &moves);
            let gain = &mut work.gains[index];
            for (value, slot) in moves.gain.iter().zip(&mut gain.state) {
                value.store(slot, part);
            }
            moves.e[2].store(&mut gain.lean, part);
        }
        work.gradient[i] += total(value.gradient * real);
        let prices = &mut work.prices[chain.group * n + i];
        for (slope, slot) in value.costate.iter().zip(prices) {
            slope.store(slot, part);
        }
        let first = (chain.group * n + i) * 3;
        value.leave(chain, (i, active), &mut work.eliminations[first..first + 3]);
    }
    for row in 0..n {
        work.slope[row] += total(value.m[row + 1][0] * real);
        for column in 0..=row {
            let curvature = total(value.m[row + 1][column + 1] * real);
            work.curvature[row * n + column] += curvature;
            if row != column {
                work.curvature[column * n + row] += curvature;
            }
        }
    }
    Residuals {
        dual: value.dual.largest(),
        primal: value.primal.largest(),
        sum: total(value.sum),
        product: value.product.largest(),
    }
}
