//! The interior point method.

use nalgebra::{DMatrix, SymmetricEigen};
use pulp::{Arch, WithSimd};

use crate::math::lanes::{Lanes, Simd, registers};

use super::newton::{Residuals, Work, backward, forward, trial};
use super::problem::{Iterate, Problem};

/// How a programme is solved.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Barrier parameter at the start and at the end, in units of time.
    pub barrier: [f64; 2],
    /// What the equalities may miss at the end, if a step or two can reach it.
    pub primal: f64,
    /// Most Newton steps.
    pub iterations: usize,
}

/// The barrier parameter falls by this factor once its problem is solved ...
const FALL: f64 = 0.4;

/// ... to this many times the parameter.
const NEARLY: f64 = 30.0;

/// Largest relative change of a segment's duration in one step: beyond, the
/// dynamics are too far from linear.
const REACH: f64 = 0.4;

/// Residuals may grow to this many times those of the start.
const WORST: f64 = 10.0;

#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub iterations: usize,
    pub mu: f64,
    pub primal: f64,
    pub dual: f64,
    pub converged: bool,
}

struct Backward<'a>(&'a Problem, &'a Iterate, &'a mut Work, f64, usize);
impl WithSimd for Backward<'_> {
    type Output = Residuals;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Residuals {
        let Self(problem, point, work, mu, group) = self;
        let mut all = Residuals::default();
        for part in 0..registers::<S>(problem.groups[group].used) {
            all.include(&backward(simd, problem, point, work, group, part, mu));
        }
        all
    }
}
impl Residuals {
    fn include(&mut self, r: &Self) {
        self.dual = self.dual.max(r.dual);
        self.primal = self.primal.max(r.primal);
        self.largest_product = self.largest_product.max(r.largest_product);
        self.sum += r.sum;
        self.complementarity += r.complementarity;
        self.costate = self.costate.max(r.costate);
    }
}
struct Forward<'a>(&'a Problem, &'a Iterate, &'a mut Work, f64, usize);
impl WithSimd for Forward<'_> {
    type Output = [f64; 3];
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let Self(problem, point, work, mu, group) = self;
        let mut all = [0.0f64; 3];
        for part in 0..registers::<S>(problem.groups[group].used) {
            let [a, b, c] = forward(simd, problem, point, work, group, part, mu);
            all = [all[0].max(a), all[1].max(b), all[2] + c];
        }
        all
    }
}
struct Trial<'a>(&'a Problem, &'a Iterate, &'a Iterate, usize);
impl WithSimd for Trial<'_> {
    type Output = [f64; 3];
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let Self(problem, old, new, group) = self;
        let mut all = [0.0f64; 3];
        for part in 0..registers::<S>(problem.groups[group].used) {
            let [a, b, c] = trial(simd, problem, old, new, group, part);
            all = [all[0] + a, all[1].max(b), all[2] + c];
        }
        all
    }
}

/// Steps of the durations by Newton's method.
///
/// Where the curvature is not positive, the magnitudes of its eigenvalues take its place
/// (in shares of the durations, so that short segments count like long ones):
/// the step then follows negative curvature downhill. False if
/// something is not a number.
fn couple(work: &mut Work, durations: &[f64], scratch: &mut [f64]) -> bool {
    let n = durations.len();
    for i in 0..n {
        for l in 0..n {
            scratch[i * n + l] = work.curvature[i * n + l] * durations[i] * durations[l];
        }
        work.durations[i] = -(1.0 + work.slope[i]) * durations[i];
    }
    if scratch.iter().chain(&work.durations).any(|value| !value.is_finite()) {
        return false;
    }
    let largest = (0..n).map(|i| scratch[i * n + i].abs()).fold(1e-300, f64::max);
    let matrix = DMatrix::from_row_slice(n, n, scratch);
    let right: Vec<f64> = work.durations.clone();
    if !eliminate(scratch, &mut work.durations, 1e-9 * largest) {
        let eigen = SymmetricEigen::new(matrix);
        let floor = 1e-8 * eigen.eigenvalues.amax();
        work.durations.fill(0.0);
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let along: f64 = vector.iter().zip(&right).map(|(a, b)| a * b).sum();
            let share = along / value.abs().max(floor);
            for (d, v) in work.durations.iter_mut().zip(vector.iter()) {
                *d += share * v;
            }
        }
    }
    for (d, h) in work.durations.iter_mut().zip(durations) {
        *d *= h;
    }
    true
}

/// Solves `matrix x = right` in place by elimination; false if a pivot is below `least`.
fn eliminate(matrix: &mut [f64], right: &mut [f64], least: f64) -> bool {
    let n = right.len();
    for c in 0..n {
        let pivot = matrix[c * n + c];
        if !(pivot > least) {
            return false;
        }
        for r in c + 1..n {
            let factor = matrix[r * n + c] / pivot;
            for q in c..n {
                matrix[r * n + q] -= factor * matrix[c * n + q];
            }
            right[r] -= factor * right[c];
        }
    }
    for c in (0..n).rev() {
        let mut sum = right[c];
        for l in c + 1..n {
            sum -= matrix[c * n + l] * right[l];
        }
        right[c] = sum / matrix[c * n + c];
    }
    true
}

fn advance(problem: &Problem, old: &Iterate, work: &Work, primal: f64, dual: f64, new: &mut Iterate) {
    let (n, k) = (problem.segments, problem.cells);
    let all = n * k;
    for (index, (new, (old, step))) in new.cells.iter_mut().zip(old.cells.iter().zip(&work.steps)).enumerate() {
        let c = index % all;
        new.s[0] = if (c + 1) % k == 0 { old.s[0] } else { old.s[0] + step.s[0] * primal };
        new.s[1] = if c + 1 == all { old.s[1] } else { old.s[1] + step.s[1] * primal };
        new.s[2] = old.s[2] + step.s[2] * primal;
        for r in 0..8 {
            new.z[r] = old.z[r] + step.z[r] * dual;
        }
    }
    for (i, d) in work.durations.iter().enumerate() {
        new.durations[i] = old.durations[i] + d * primal;
    }
    let mix = |new: &mut Lanes, old: Lanes, full: Lanes| *new = old + (full + (-old)) * primal;
    for i in 0..new.lambda.len() {
        mix(&mut new.lambda[i], old.lambda[i], work.lambda[i]);
    }
    for g in 0..new.goal.len() {
        for e in 0..2 {
            mix(&mut new.goal[g][e], old.goal[g][e], work.goal[g][e]);
        }
    }
}

/// Minimises the sum of durations from `point` on.
pub fn solve(problem: &Problem, point: &mut Iterate, settings: &Settings) -> Outcome {
    let n = problem.segments;
    let groups = problem.groups.len();
    let arch = Arch::new();
    let mut work = Work::new(problem);
    let mut scratch = vec![0.0; n * n];
    let mut mu = settings.barrier[0];
    let mut out = Outcome { iterations: 0, mu, primal: 0.0, dual: 0.0, converged: false };
    let mut filter: Vec<(f64, f64)> = Vec::new();
    let mut phi = 0.0;
    let mut polished = 0;
    let mut theta_small = 0.0;
    let mut theta_most = 0.0;
    let mut next = point.clone();
    for iteration in 0..=settings.iterations {
        let mut r = Residuals::default();
        let mut assemble = |point: &Iterate, work: &mut Work, mu: f64| {
            let mut r = Residuals::default();
            work.curvature.fill(0.0);
            work.slope.fill(0.0);
            work.gradient.fill(0.0);
            for g in 0..groups {
                r.include(&arch.dispatch(Backward(problem, point, work, mu, g)));
            }
            r
        };
        r = assemble(point, &mut work, mu);
        for (i, g) in work.gradient.iter().enumerate() {
            r.dual = r.dual.max((g + 1.0).abs() * point.durations[i]);
        }
        if iteration == 0 {
            theta_small = 1e-4 * r.sum.max(1.0);
            theta_most = WORST * r.sum.max(1.0);
        }
        let error = r.dual.max(r.primal).max(r.largest_product - mu);
        out = Outcome { iterations: iteration, mu, primal: r.primal, dual: r.dual, converged: false };
        if !(r.sum.is_finite() && r.dual.is_finite()) {
            return out;
        }
        if error < NEARLY * mu {
            if mu <= settings.barrier[1] && r.primal > settings.primal && polished < 2 {
                polished += 1;
                // One more step makes the equalities hold better.
            } else if mu <= settings.barrier[1] {
                out.converged = true;
                return out;
            }
            if mu > settings.barrier[1] {
            mu = (mu * FALL).max(settings.barrier[1]);
            filter.clear();
            phi = 0.0;
            assemble(point, &mut work, mu);
            }
        }
        if iteration == settings.iterations
            || !couple(&mut work, &point.durations, &mut scratch)
        {
            return out;
        }
        let mut f = [0.0f64; 3];
        for g in 0..groups {
            let q = arch.dispatch(Forward(problem, point, &mut work, mu, g));
            f = [f[0].max(q[0]), f[1].max(q[1]), f[2] + q[2]];
        }
        let tau = (1.0 - mu).clamp(0.95, 0.999);
        let mut alpha = (tau / f[0].max(1e-300)).min(1.0);
        let dual = (tau / f[1].max(1e-300)).min(1.0);
        for (h, d) in point.durations.iter().zip(&work.durations) {
            alpha = alpha.min(REACH * h / d.abs().max(1e-300));
        }
        let sum_dh: f64 = work.durations.iter().sum();
        let slope_phi = sum_dh - mu * f[2];
        let mut tries = 0;
        loop {
            advance(problem, point, &work, alpha, dual, &mut next);
            let mut t = [0.0f64; 3];
            for g in 0..groups {
                let q = arch.dispatch(Trial(problem, point, &next, g));
                t = [t[0] + q[0], t[1].max(q[1]), t[2] + q[2]];
            }
            tries += 1;
            let change = alpha * sum_dh - mu * t[2];
            let value = phi + change;
            let acceptable = filter.iter().all(|&(theta, phi): &(f64, f64)| {
                t[0] <= 0.99999 * theta || value <= phi - 1e-5 * theta
            });
            // Where the value falls fast enough it decides alone.
            let falling = slope_phi < 0.0 && alpha * libm::pow(-slope_phi, 2.3) > libm::pow(r.sum, 1.1);
            let enough = if falling && r.sum <= theta_small {
                change <= 1e-4 * alpha * slope_phi + 1e-11
            } else {
                t[0] <= 0.99999 * r.sum || change <= -1e-5 * r.sum || r.sum < 1e-9
            };
            let inside = t[1] < 0.9995;
            if inside && t[0] <= theta_most && acceptable && enough {
                if !falling {
                    filter.push((r.sum, phi));
                }
                phi = value;
                break;
            }
            if tries > 8 && inside || tries > 30 {
                filter.clear();
                phi = value;
                break;
            }
            alpha *= 0.5;
        }
        std::mem::swap(point, &mut next);
    }
    out
}
