//! The Newton step itself, forwards over the cells, and what a part of it leads to.

use crate::math::lanes::{Lanes, Simd, Vector};

use super::chain::{Chain, ROWS, Room, View, total};
use super::newton::inverses;
use super::work::{COLUMNS, Work};

/// What the full step would do.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outlook {
    /// Largest share of a slack that it would use up.
    pub slack: f64,
    /// Largest share of a multiplier.
    pub multiplier: f64,
    /// Sum of changes of slacks over slacks.
    pub shares: f64,
}

/// Steps of all cells of one register of joints, given the durations' in `work`.
#[inline(always)]
pub fn forward<S: Simd>(chain: &Chain<S>, work: &mut Work, mu: f64) -> Outlook {
    let (n, k, all, part) = (chain.segments, chain.cells, chain.all(), chain.part);
    let zero = chain.splat(0.0);
    let mut state = [zero; 3];
    let mut parameters = [zero; COLUMNS];
    parameters[0] = chain.splat(1.0);
    for i in 0..n {
        parameters[i + 1] = chain.splat(work.durations[i]);
    }
    let mut found = [zero; 3];
    for i in 0..n {
        let before = if i > 0 { chain.room(i - 1) } else { None };
        state[0] = before.map_or(zero, |room| room.open.select(state[0], zero));
        let active = multipliers(chain, work, i, state, &mut parameters);
        for c in i * k..(i + 1) * k {
            let index = chain.group * all + c;
            let gain = &work.gains[index];
            let columns = &work.columns[index * work.stride..(index + 1) * work.stride];
            let mut u = chain.load(&columns[0]);
            for (gain, state) in gain.state.iter().zip(state) {
                u = u + chain.load(gain) * state;
            }
            for column in i + 1..active {
                u = u + chain.load(&columns[column]) * parameters[column];
            }
            let change = chain.load(&gain.lean) * parameters[i + 1] - u;
            let view = chain.view(c);
            let (end, slack) = follow(chain, &view, state, change, parameters[i + 1]);
            let step = &mut work.steps[index];
            for (value, slot) in end.iter().zip(&mut step.s) {
                value.store(slot, part);
            }
            let dz = rows(chain, c, &work.inverses[index], slack, mu, &mut found);
            for (value, slot) in dz.iter().zip(&mut step.z) {
                value.store(slot, part);
            }
            state = end;
        }
        if let Some(room) = chain.room(i) {
            let dz = deviate(chain, &room, state[0], mu, &mut found);
            for (value, slot) in dz.iter().zip(&mut work.berths[chain.group * n + i]) {
                value.store(slot, part);
            }
        }
    }
    Outlook { slack: found[0].largest(), multiplier: found[1].largest(), shares: total(found[2]) }
}

/// New multipliers of segment `i`, where its first state's step is `state`.
#[inline(always)]
fn multipliers<S: Simd>(
    chain: &Chain<S>,
    work: &mut Work,
    i: usize,
    state: [Vector<S>; 3],
    parameters: &mut [Vector<S>; COLUMNS],
) -> usize {
    let (n, part) = (chain.segments, chain.part);
    let local = n + 1;
    let last = i + 1 == n;
    let active = local + if last { 3 } else { 1 };
    for row in local..active {
        let elimination = &work.eliminations[(chain.group * n + i) * 3 + row - local];
        let [x, v, a] = &elimination.state;
        let mut value = chain.load(&elimination.columns[0])
            + chain.load(v) * state[1]
            + chain.load(a) * state[2]
            + chain.load(x) * state[0];
        for column in i + 1..row {
            value = value + chain.load(&elimination.columns[column]) * parameters[column];
        }
        parameters[row] = value;
    }
    parameters[local].store(&mut work.lambda[chain.group * n + i], part);
    if last {
        let [v, a] = &mut work.goal[chain.group];
        parameters[local + 1].store(v, part);
        parameters[local + 2].store(a, part);
    }
    active
}

/// Steps of the state at a cell's end and of its slacks.
#[inline(always)]
fn follow<S: Simd>(
    chain: &Chain<S>,
    view: &View<S>,
    [dx, dv, da]: [Vector<S>; 3],
    change: Vector<S>,
    duration: Vector<S>,
) -> ([Vector<S>; 3], [Vector<S>; ROWS]) {
    let View { share, t, a, middle, .. } = *view;
    let zero = chain.splat(0.0);
    let dt = share * duration;
    let miss = view.residual(&chain.limits);
    let [bx, bv] = view.along_duration(&chain.limits);
    let [cx, cv] = view.along_change(&chain.limits);
    let x = dx + t * dv + t * t * 0.5 * da + bx * dt + cx * change + miss[0];
    let v = dv + t * da + bv * dt + cv * change + miss[1];
    let a1 = da + change;
    let m = dv + (t * da + a * dt) * middle;
    let most = chain.limits.derivatives[2] * dt;
    ([x, v, a1], [most - change, most + change, zero - a1, a1, zero - v, v, zero - m, m])
}

/// Steps of a cell's multipliers, given one over each of its `slacks`; keeps the largest shares in `found`.
#[inline(always)]
fn rows<S: Simd>(
    chain: &Chain<S>,
    c: usize,
    slacks: &[Lanes; ROWS],
    step: [Vector<S>; ROWS],
    mu: f64,
    found: &mut [Vector<S>; 3],
) -> [Vector<S>; ROWS] {
    let zero = chain.splat(0.0);
    let real = chain.limits.real;
    let mut z = [zero; ROWS];
    for row in 0..ROWS {
        z[row] = chain.multiplier(c, row);
    }
    let inverses = inverses(chain, &z);
    let mut dz = [zero; ROWS];
    for row in 0..ROWS {
        let inverse = chain.load(&slacks[row]);
        let share = step[row] * inverse;
        dz[row] = inverse * mu - z[row] - z[row] * share;
        if chain.counts(c, row) {
            found[0] = found[0].max((zero - share) * real);
            found[1] = found[1].max((zero - dz[row] * inverses[row]) * real);
            found[2] = found[2] + share * real;
        }
    }
    dz
}

/// Steps of the multipliers of deviations that change by `step`; keeps the largest shares in `found`.
#[inline(always)]
fn deviate<S: Simd>(
    chain: &Chain<S>,
    room: &Room<S>,
    step: Vector<S>,
    mu: f64,
    found: &mut [Vector<S>; 3],
) -> [Vector<S>; 2] {
    let zero = chain.splat(0.0);
    let Room { open, slack, z } = room;
    let mut dz = [zero; 2];
    for (side, step) in [step, zero - step].into_iter().enumerate() {
        let inverse = chain.splat(1.0) / slack[side];
        let share = open.select(step * inverse, zero);
        let change = inverse * mu - z[side] - z[side] * share;
        dz[side] = open.select(change, zero);
        found[0] = found[0].max(zero - share);
        found[1] = found[1].max(open.select(zero - change / z[side], zero));
        found[2] = found[2] + share;
    }
    dz
}

/// Where a part of the step leads.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trial {
    /// Sum of all misses of the dynamics.
    pub sum: f64,
    /// Largest share of a slack lost.
    pub lost: f64,
    /// Sum of the logarithms of the shares of slacks kept.
    pub logarithms: f64,
}

/// Looks at a new point of one register of joints; `work` has one over the slacks at the old one.
#[inline(always)]
pub fn trial<S: Simd>(new: &Chain<S>, work: &Work) -> Trial {
    let (zero, one) = (new.splat(0.0), new.splat(1.0));
    let limits = &new.limits;
    let (mut sum, mut lost, mut product) = (zero, zero, one);
    let mut logarithms = 0.0;
    for c in 0..new.all() {
        let after = new.view(c);
        for miss in after.residual(limits) {
            sum = sum + miss.abs() * limits.real;
        }
        let before = &work.inverses[new.group * new.all() + c];
        for (row, slack) in after.slack(limits).into_iter().enumerate() {
            if new.counts(c, row) {
                let change = (slack * new.load(&before[row]) - one) * limits.real;
                lost = lost.max(zero - change);
                product = product * (change + one);
            }
        }
        // One logarithm for several cells: the product stays far from overflow.
        if c % 4 == 3 || c + 1 == new.all() {
            add_logarithms(product, &mut logarithms);
            product = one;
        }
    }
    for i in 0..new.segments {
        let Some(after) = new.room(i) else { continue };
        let before = &work.berth_inverses[new.group * new.segments + i];
        for (slack, before) in after.slack.into_iter().zip(before) {
            let change = slack * new.load(before) - one;
            lost = lost.max(zero - change);
            product = product * (change + one);
        }
        add_logarithms(product, &mut logarithms);
        product = one;
    }
    Trial { sum: total(sum), lost: lost.largest(), logarithms }
}

/// Adds the logarithms of a register's lanes, in order.
#[inline(always)]
fn add_logarithms<S: Simd>(product: Vector<S>, sum: &mut f64) {
    let mut lanes = Lanes([1.0; 8]);
    product.store(&mut lanes, 0);
    for lane in lanes.0 {
        *sum += libm::log(lane);
    }
}
