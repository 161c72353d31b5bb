//! One Newton step: a Riccati recursion backwards over the cells, forwards again.

use crate::math::lanes::{Lanes, Simd, Vector};

use super::problem::{Cell, Group, Iterate, Problem};

/// Most segments of one programme.
pub const MAX_SEGMENTS: usize = 16;

/// Columns: what is known, one per duration, three multipliers.
const COLUMNS: usize = MAX_SEGMENTS + 4;

/// What the forward pass needs of a cell beside its columns.
#[derive(Clone, Copy)]
struct Gain {
    state: [Lanes; 3],
    /// Acceleration that goes with the duration: `sigma J share`.
    lean: Lanes,
}

/// Working memory for one problem.
pub struct Work {
    gains: Vec<Gain>,
    columns: Vec<Lanes>,
    /// `[(group * segments + segment) * 3 + local]`: columns, then v and a.
    multipliers: Vec<[Lanes; COLUMNS + 2]>,
    /// Curvature over durations `[row * segments + column]`, summed over joints.
    pub curvature: Vec<f64>,
    /// Slope over durations, summed over joints.
    pub slope: Vec<f64>,
    /// The Lagrangian's own slope over durations, without the objective.
    pub gradient: Vec<f64>,
    /// Steps of the cells.
    pub steps: Vec<Cell>,
    /// Steps of the durations.
    pub durations: Vec<f64>,
    /// New multipliers.
    pub lambda: Vec<Lanes>,
    pub goal: Vec<[Lanes; 2]>,
    stride: usize,
}

impl Work {
    pub fn new(problem: &Problem) -> Self {
        let (n, groups) = (problem.segments, problem.groups.len());
        let cells = n * problem.cells * groups;
        let zero = Lanes::ZERO;
        let stride = n + 4;
        Self {
            gains: vec![Gain { state: [zero; 3], lean: zero }; cells],
            columns: vec![zero; cells * stride],
            multipliers: vec![[zero; COLUMNS + 2]; n * groups * 3],
            curvature: vec![0.0; n * n],
            slope: vec![0.0; n],
            gradient: vec![0.0; n],
            steps: vec![Cell::ZERO; cells],
            durations: vec![0.0; n],
            lambda: vec![zero; n * groups],
            goal: vec![[zero; 2]; groups],
            stride,
        }
    }
}

/// One register of a [`Group`].
#[derive(Clone, Copy)]
pub struct Part<S: Simd> {
    pub limits: [Vector<S>; 3],
    pub real: Vector<S>,
    pub smooth: Vector<S>,
    /// Shares of a change of acceleration: in `T² δ` of the position, in `T δ` of velocity.
    pub into_position: Vector<S>,
    pub into_velocity: Vector<S>,
    /// Share of `T a` in the middle control point of velocity.
    pub into_middle: Vector<S>,
    pub ends: [[Vector<S>; 2]; 2],
}

impl<S: Simd> Part<S> {
    #[inline(always)]
    pub fn load(simd: S, group: &Group, part: usize) -> Self {
        let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
        let smooth = load(&group.smooth);
        let half = Vector::splat(simd, 0.5);
        Self {
            limits: [load(&group.limits[0]), load(&group.limits[1]), load(&group.limits[2])],
            real: load(&group.real),
            smooth,
            into_position: half - smooth * (1.0 / 3.0),
            into_velocity: Vector::splat(simd, 1.0) - smooth * 0.5,
            into_middle: smooth * 0.5,
            ends: [
                [load(&group.ends[0][0]), load(&group.ends[0][1])],
                [load(&group.ends[1][0]), load(&group.ends[1][1])],
            ],
        }
    }
}

/// A cell's quantities in registers.
#[derive(Clone, Copy)]
pub struct View<S: Simd> {
    pub share: Vector<S>,
    pub t: Vector<S>,
    pub d: Vector<S>,
    pub x: Vector<S>,
    pub v: Vector<S>,
    pub a: Vector<S>,
    /// State at the end.
    pub s1: [Vector<S>; 3],
    /// Share of `T a` in the middle control point of velocity; none in the first
    /// cell, whose start is given and may lie on a limit.
    pub into_middle: Vector<S>,
}

impl<S: Simd> View<S> {
    /// Cell `c` of the joints whose `cells` and `shares` are given.
    #[inline(always)]
    pub fn new(
        simd: S,
        problem: &Problem,
        limits: &Part<S>,
        durations: &[f64],
        cells: &[Cell],
        shares: &[Lanes],
        c: usize,
        part: usize,
    ) -> Self {
        let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
        let (v, a) = if c == 0 {
            (limits.ends[0][0], limits.ends[0][1])
        } else {
            (load(&cells[c - 1].s[1]), load(&cells[c - 1].s[2]))
        };
        let x = if c % problem.cells == 0 {
            Vector::splat(simd, 0.0)
        } else {
            load(&cells[c - 1].s[0])
        };
        let s1 = [load(&cells[c].s[0]), load(&cells[c].s[1]), load(&cells[c].s[2])];
        let share = load(&shares[c]);
        let into_middle = if c == 0 { Vector::splat(simd, 0.0) } else { limits.into_middle };
        let t = share * durations[c / problem.cells];
        Self { share, t, d: s1[2] - a, x, v, a, s1, into_middle }
    }

    /// Residuals of the dynamics.
    #[inline(always)]
    pub fn residual(&self, limits: &Part<S>) -> [Vector<S>; 2] {
        let Self { t, d, x, v, a, s1, .. } = *self;
        [
            x + t * (v + t * (a * 0.5 + d * limits.into_position)) - s1[0],
            v + t * (a + d * limits.into_velocity) - s1[1],
        ]
    }

    /// The left sides of the eight inequalities `g > 0`.
    #[inline(always)]
    pub fn slack(&self, limits: &Part<S>) -> [Vector<S>; 8] {
        let middle = self.v + self.t * self.a * self.into_middle;
        let [_, v1, a1] = self.s1;
        let [velocity, acceleration, jerk] = limits.limits;
        let most = jerk * self.t;
        [
            most - self.d,
            most + self.d,
            acceleration - a1,
            acceleration + a1,
            velocity - v1,
            velocity + v1,
            velocity - middle,
            velocity + middle,
        ]
    }
}

/// What the backward pass finds out about the point itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Residuals {
    pub dual: f64,
    pub primal: f64,
    pub sum: f64,
    pub complementarity: f64,
    pub largest_product: f64,
    pub costate: f64,
}

#[inline(always)]
pub fn total<S: Simd>(vector: Vector<S>) -> f64 {
    let mut lanes = Lanes::ZERO;
    vector.store(&mut lanes, 0);
    let mut sum = 0.0;
    for lane in lanes.0 {
        sum += lane;
    }
    sum
}

/// Backward pass over one register of a group.
#[inline(always)]
pub fn backward<S: Simd>(
    simd: S,
    problem: &Problem,
    point: &Iterate,
    work: &mut Work,
    group: usize,
    part: usize,
    mu: f64,
) -> Residuals {
    let n = problem.segments;
    let k = problem.cells;
    let all = n * k;
    let limits = Part::load(simd, &problem.groups[group], part);
    let cells = &point.cells[group * all..(group + 1) * all];
    let shares = &problem.shares[group * all..(group + 1) * all];
    let zero = Vector::splat(simd, 0.0);
    let one = Vector::splat(simd, 1.0);
    let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
    let real = limits.real;
    let jerk = limits.limits[2];
    let reach = limits.limits[1];
    let mut p = [zero; 6];
    let mut cols = [[zero; 3]; COLUMNS];
    let mut m = [[zero; COLUMNS]; COLUMNS];
    let (mut pi_v, mut pi_a) = (zero, zero);
    let (mut dual, mut primal, mut sum) = (zero, zero, zero);
    let (mut products, mut largest_product) = (zero, zero);
    let mut costate = zero;
    let stride = work.stride;
    for i in (0..n).rev() {
        let local = n + 1;
        let last = i + 1 == n;
        let active = local + if last { 3 } else { 1 };
        let lambda = load(&point.lambda[group * n + i]);
        p[0] = zero;
        p[1] = zero;
        p[2] = zero;
        for col in cols.iter_mut().take(local) {
            col[0] = zero;
        }
        cols[local] = [one, zero, zero];
        for row in m[local..active].iter_mut() {
            *row = [zero; COLUMNS];
        }
        if last {
            pi_v = load(&point.goal[group][0]);
            pi_a = load(&point.goal[group][1]);
            cols[local + 1] = [zero, one, zero];
            cols[local + 2] = [zero, zero, limits.smooth];
            m[local + 2][local + 2] = limits.smooth - one;
        }
        let mut gradient = zero;
        for q in (0..k).rev() {
            let c = i * k + q;
            let cell = &cells[c];
            let at = View::new(simd, problem, &limits, &point.durations, cells, shares, c, part);
            let g = at.slack(&limits);
            let mut z = [zero; 8];
            let mut inv = [zero; 8];
            let mut w = [zero; 8];
            let end = c + 1 == all;
            for r in 0..8 {
                z[r] = load(&cell.z[r]);
                inv[r] = one / g[r];
                w[r] = z[r] * inv[r];
                if !(end && (4..6).contains(&r)) {
                    let product = z[r] * g[r] * real;
                    products = products + product;
                    largest_product = largest_product.max(product);
                }
            }
            if !end {
                p[3] = p[3] + w[4] + w[5];
                cols[0][1] = cols[0][1] + (inv[4] - inv[5]) * mu;
                pi_v = pi_v + z[4] - z[5];
            }
            p[5] = p[5] + w[2] + w[3];
            cols[0][2] = cols[0][2] + (inv[2] - inv[3]) * mu;
            pi_a = pi_a + z[2] - z[3];
            let View { share, t, d, v, a, into_middle, .. } = at;
            let r = at.residual(&limits);
            for r in &r {
                primal = primal.max(r.abs() * real);
                sum = sum + r.abs() * real;
            }
            let [pxx, pxv, pxa, pvv, pva, paa] = p;
            let half_tt = t * t * 0.5;
            // How the end moves with duration (per share) and with acceleration.
            let bx = v + t * (a + d * limits.into_position * 2.0);
            let bv = a + d * limits.into_velocity;
            let cx = t * t * limits.into_position;
            let cv = t * limits.into_velocity;
            let mid_a = t * into_middle;
            let mid_t = a * into_middle;
            // Duration with the acceleration that goes with it.
            let weight = w[0] + w[1];
            let lean = jerk * share * ((w[0] - w[1]) / weight);
            let ex = bx * share + cx * lean;
            let ev = bv * share + cv * lean;
            let ea = lean;
            let wm = w[6] + w[7];
            let zm = z[6] - z[7];
            // Pc and Pe.
            let yc = [
                pxx * cx + pxv * cv + pxa,
                pxv * cx + pvv * cv + pva,
                pxa * cx + pva * cv + paa,
            ];
            let ye = [
                pxx * ex + pxv * ev + pxa * ea,
                pxv * ex + pvv * ev + pva * ea,
                pxa * ex + pva * ev + paa * ea,
            ];
            let h = cx * yc[0] + cv * yc[1] + yc[2] + weight;
            let inverse = one / h;
            let hs = [yc[0], t * yc[0] + yc[1], half_tt * yc[0] + t * yc[1] + yc[2]];
            // F^T P F.
            let fv = [t * pxx + pxv, t * pxv + pvv, t * pxa + pva];
            let fa = [
                half_tt * pxx + t * pxv + pxa,
                half_tt * pxv + t * pvv + pva,
                half_tt * pxa + t * pva + paa,
            ];
            let gain = [hs[0] * inverse, hs[1] * inverse, hs[2] * inverse];
            p = [
                pxx - hs[0] * gain[0],
                fv[0] - hs[0] * gain[1],
                fa[0] - hs[0] * gain[2],
                t * fv[0] + fv[1] + wm - hs[1] * gain[1],
                t * fa[0] + fa[1] + wm * mid_a - hs[1] * gain[2],
                half_tt * fa[0] + t * fa[1] + fa[2] + wm * mid_a * mid_a - hs[2] * gain[2],
            ];
            let index = group * all + c;
            let stored = &mut work.gains[index];
            for s in 0..3 {
                gain[s].store(&mut stored.state[s], part);
            }
            lean.store(&mut stored.lean, part);
            // The Lagrangian's curvature: everything bends with the duration only.
            let w_td = (t * lambda * (limits.into_position * 2.0) + limits.into_velocity * pi_v) * share;
            let w_tv = lambda * share;
            let w_ta = (lambda * t + pi_v + zm * into_middle) * share;
            let w_tt = lambda * (a + d * limits.into_position * 2.0) * share * share;
            let cm = (inv[6] - inv[7]) * mu;
            let pull = (inv[0] - inv[1]) * mu;
            let own = i + 1;
            let mut gs_of = [zero; COLUMNS];
            let mut ys_of = [zero; COLUMNS];
            let known = cols[0];
            for col in 0..active {
                if col > 0 && col <= i {
                    continue;
                }
                let [mut px, mut pv, mut pa] = cols[col];
                if col > 0 {
                    m[col][0] = m[col][0] + px * r[0] + pv * r[1];
                    if col == own {
                        let along = px * ex + pv * ev + pa * ea;
                        let base = ex * known[0] + ev * known[1] + ea * known[2]
                            + ye[0] * r[0] + ye[1] * r[1];
                        let stage = cm * mid_t * share + pull * lean
                            - jerk * share * (inv[0] + inv[1]) * mu;
                        m[own][0] = m[own][0] + base + stage;
                        let mid = mid_t * share;
                        m[own][own] = m[own][own] + ex * ye[0] + ev * ye[1] + ea * ye[2]
                            + along * 2.0
                            + jerk * share * jerk * share * (w[0] * w[1] / weight) * 4.0
                            + wm * mid * mid
                            + w_tt
                            + w_td * lean * 2.0;
                        px = px + ye[0];
                        pv = pv + ye[1];
                        pa = pa + ye[2];
                    } else {
                        let along = px * ex + pv * ev + pa * ea;
                        // Rows are the larger index.
                        m[col][own] = m[col][own] + along;
                    }
                } else {
                    px = px + pxx * r[0] + pxv * r[1];
                    pv = pv + pxv * r[0] + pvv * r[1];
                    pa = pa + pxa * r[0] + pva * r[1];
                }
                let mut gs = [px, t * px + pv, half_tt * px + t * pv + pa];
                let mut gd = cx * px + cv * pv + pa;
                if col == 0 {
                    gs[1] = gs[1] + cm;
                    gs[2] = gs[2] + cm * mid_a;
                    gd = gd + pull;
                }
                if col == own {
                    let mid = wm * mid_t * share;
                    gs[1] = gs[1] + w_tv + mid;
                    gs[2] = gs[2] + w_ta + mid * mid_a;
                    gd = gd + w_td;
                }
                gs_of[col] = gd;
                ys_of[col] = gd * inverse;
                ys_of[col].store(&mut work.columns[index * stride + col], part);
                cols[col] = [gs[0] - gain[0] * gd, gs[1] - gain[1] * gd, gs[2] - gain[2] * gd];
            }
            for row in own..active {
                m[row][0] = m[row][0] - gs_of[row] * ys_of[0];
                for col in own..=row {
                    m[row][col] = m[row][col] - gs_of[row] * ys_of[col];
                }
            }
            // The Lagrangian's own gradient.
            gradient = gradient
                + (bx * lambda + bv * pi_v + mid_t * zm - jerk * (z[0] + z[1])) * share;
            costate = costate.max(pi_v.abs() * real).max(lambda.abs() * real);
            let slope = cx * lambda + cv * pi_v + pi_a + z[0] - z[1];
            dual = dual.max((slope * (jerk * t).min(reach)).abs() * real);
            pi_a = half_tt * lambda + t * pi_v + pi_a + mid_a * zm;
            pi_v = t * lambda + pi_v + zm;
        }
        work.gradient[i] += total(gradient * real);
        // Eliminate the local multipliers.
        for e in (local..active).rev() {
            let inverse = zero - one / m[e][e];
            let slot = &mut work.multipliers[(group * n + i) * 3 + e - local];
            let [_, pv, pa] = cols[e];
            let mut row = [zero; COLUMNS];
            for col in 0..e {
                if col > 0 && col <= i {
                    continue;
                }
                row[col] = m[e][col] * inverse;
                row[col].store(&mut slot[col], part);
            }
            let (rv, ra) = (pv * inverse, pa * inverse);
            rv.store(&mut slot[COLUMNS], part);
            ra.store(&mut slot[COLUMNS + 1], part);
            p[3] = p[3] + pv * rv;
            p[4] = p[4] + pv * ra;
            p[5] = p[5] + pa * ra;
            for col in 0..e {
                if col > 0 && col <= i {
                    continue;
                }
                cols[col][1] = cols[col][1] + pv * row[col];
                cols[col][2] = cols[col][2] + pa * row[col];
                let factor = m[e][col];
                if col > 0 {
                    m[col][0] = m[col][0] + factor * row[0];
                    for other in i + 1..=col {
                        m[col][other] = m[col][other] + factor * row[other];
                    }
                }
            }
        }
    }
    for row in 0..n {
        work.slope[row] += total(m[row + 1][0] * real);
        for col in 0..=row {
            let value = total(m[row + 1][col + 1] * real);
            work.curvature[row * n + col] += value;
            if row != col {
                work.curvature[col * n + row] += value;
            }
        }
    }
    Residuals {
        dual: dual.largest(),
        primal: primal.largest(),
        sum: total(sum),
        complementarity: total(products),
        largest_product: largest_product.largest(),
        costate: costate.largest(),
    }
}

/// Forward pass: steps of all cells, given the steps of the durations.
///
/// Returns the largest shares of a slack and of a multiplier that the full step
/// would use up, and the sum of `step / slack`.
#[inline(always)]
pub fn forward<S: Simd>(
    simd: S,
    problem: &Problem,
    point: &Iterate,
    work: &mut Work,
    group: usize,
    part: usize,
    mu: f64,
) -> [f64; 3] {
    let n = problem.segments;
    let k = problem.cells;
    let all = n * k;
    let limits = Part::load(simd, &problem.groups[group], part);
    let cells = &point.cells[group * all..(group + 1) * all];
    let shares = &problem.shares[group * all..(group + 1) * all];
    let zero = Vector::splat(simd, 0.0);
    let one = Vector::splat(simd, 1.0);
    let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
    let real = limits.real;
    let (mut dv, mut da) = (zero, zero);
    let mut params = [zero; COLUMNS];
    params[0] = one;
    for i in 0..n {
        params[i + 1] = Vector::splat(simd, work.durations[i]);
    }
    let (mut primal, mut dual, mut slope) = (zero, zero, zero);
    let stride = work.stride;
    for i in 0..n {
        let local = n + 1;
        let active = local + if i + 1 == n { 3 } else { 1 };
        for e in local..active {
            let row = &work.multipliers[(group * n + i) * 3 + e - local];
            let mut value = load(&row[0]) + load(&row[COLUMNS]) * dv + load(&row[COLUMNS + 1]) * da;
            for col in i + 1..e {
                value = value + load(&row[col]) * params[col];
            }
            params[e] = value;
        }
        params[local].store(&mut work.lambda[group * n + i], part);
        if i + 1 == n {
            params[local + 1].store(&mut work.goal[group][0], part);
            params[local + 2].store(&mut work.goal[group][1], part);
        }
        let mut dx = zero;
        for q in 0..k {
            let c = i * k + q;
            let index = group * all + c;
            let gain = &work.gains[index];
            let columns = &work.columns[index * stride..(index + 1) * stride];
            let mut u = load(&columns[0])
                + load(&gain.state[0]) * dx
                + load(&gain.state[1]) * dv
                + load(&gain.state[2]) * da;
            for col in i + 1..active {
                u = u + load(&columns[col]) * params[col];
            }
            let dd = load(&gain.lean) * params[i + 1] - u;
            let at = View::new(simd, problem, &limits, &point.durations, cells, shares, c, part);
            let r = at.residual(&limits);
            let View { share, t, d, v, a, into_middle, .. } = at;
            let dt = share * params[i + 1];
            let dm = dv + (t * da + a * dt) * into_middle;
            let half_tt = t * t * 0.5;
            let nx = dx + t * dv + half_tt * da
                + (v + t * (a + d * limits.into_position * 2.0)) * dt
                + t * t * limits.into_position * dd
                + r[0];
            let nv = dv + t * da + (a + d * limits.into_velocity) * dt + t * limits.into_velocity * dd + r[1];
            let na = da + dd;
            let g = at.slack(&limits);
            let most = limits.limits[2] * dt;
            let dg = [most - dd, most + dd, zero - na, na, zero - nv, nv, zero - dm, dm];
            let end = c + 1 == all;
            let step = &mut work.steps[index];
            for row in 0..8 {
                let z = load(&cells[c].z[row]);
                let inv = one / g[row];
                let ratio = dg[row] * inv;
                let dz = inv * mu - z - z * ratio;
                dz.store(&mut step.z[row], part);
                if !(end && (4..6).contains(&row)) {
                    primal = primal.max((zero - ratio) * real);
                    dual = dual.max((zero - dz / z) * real);
                    slope = slope + ratio * real;
                }
            }
            nx.store(&mut step.s[0], part);
            nv.store(&mut step.s[1], part);
            na.store(&mut step.s[2], part);
            (dx, dv, da) = (nx, nv, na);
        }
    }
    [primal.largest(), dual.largest(), total(slope)]
}

/// What a trial step leads to: residuals, largest share of a slack lost, and
/// the sum of the logarithms of the shares kept.
#[inline(always)]
pub fn trial<S: Simd>(
    simd: S,
    problem: &Problem,
    old: &Iterate,
    new: &Iterate,
    group: usize,
    part: usize,
) -> [f64; 3] {
    let all = problem.segments * problem.cells;
    let limits = Part::load(simd, &problem.groups[group], part);
    let zero = Vector::splat(simd, 0.0);
    let one = Vector::splat(simd, 1.0);
    let real = limits.real;
    let olds = &old.cells[group * all..(group + 1) * all];
    let news = &new.cells[group * all..(group + 1) * all];
    let shares = &problem.shares[group * all..(group + 1) * all];
    let mut sum = zero;
    let mut lost = zero;
    let mut logs = 0.0;
    let mut products = one;
    for c in 0..all {
        let before = View::new(simd, problem, &limits, &old.durations, olds, shares, c, part);
        let after = View::new(simd, problem, &limits, &new.durations, news, shares, c, part);
        for r in after.residual(&limits) {
            sum = sum + r.abs() * real;
        }
        let (g0, g1) = (before.slack(&limits), after.slack(&limits));
        let end = c + 1 == all;
        for row in 0..8 {
            if !(end && (4..6).contains(&row)) {
                let change = (g1[row] / g0[row] - one) * real;
                lost = lost.max(zero - change);
                products = products * (change + one);
            }
        }
        if c % 4 == 3 || end {
            let mut lanes = Lanes([1.0; 8]);
            products.store(&mut lanes, 0);
            for lane in lanes.0 {
                logs += libm::log(lane);
            }
            products = one;
        }
    }
    [total(sum), lost.largest(), logs]
}
