//! The primal-dual interior point method.
//!
//! For a falling barrier parameter `mu` the sum of durations minus `mu` times the logarithms of
//! all slacks is minimised by Newton's method. A step is cut where a slack or a multiplier would
//! lose more than nearly all of itself, and halved until a filter accepts it
//! (Wächter and Biegler, doi:10.1007/s10107-004-0559-y, section 2.3): it must improve the misses of the
//! dynamics or the barrier function against every point kept so far. We have no
//! restoration phase; a step that is still refused after eight halvings is taken.
//!
//! Slacks are no variables: points stay strictly inside all limits from the start.

use nalgebra::{DMatrix, SymmetricEigen};
use pulp::{Arch, WithSimd};

use crate::math::lanes::{Lanes, Simd, WIDTH, registers};

use super::chain::Chain;
use super::newton::backward;
use super::problem::{Iterate, Problem};
use super::step::{Outlook, Trial, forward, trial};
use super::work::{Residuals, Work};

/// How a programme is solved.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Barrier parameter at the start and at the end, in units of time.
    pub barrier: [f64; 2],
    /// What the dynamics may be missed by at the end, if a step or two can reach it.
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

/// Misses may grow to this many times those of the start (of one, where those are smaller).
const WORST: f64 = 10.0;

/// Below this share of that, the barrier function alone decides where it falls.
const SMALL: f64 = 1e-4;

/// Improvement that counts, relative to the misses.
const GAIN: f64 = 1e-5;

/// Halvings after which a refused step is taken all the same; after as many more again, even
/// a point outside the limits ends the search.
const HALVINGS: [usize; 2] = [8, 30];

/// How a solution ended.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The Lagrangian's slopes at the end, see [`Work::prices`].
    pub prices: Vec<[Lanes; 3]>,
    /// Newton steps taken.
    pub iterations: usize,
    /// Whether the last barrier problem was solved.
    pub converged: bool,
}

struct Factorise<'a>(&'a Problem, &'a Iterate, &'a mut Work, f64, usize);

impl WithSimd for Factorise<'_> {
    type Output = Residuals;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Residuals {
        let Self(problem, point, work, mu, group) = self;
        let mut all = Residuals::default();
        for part in 0..registers::<S>(problem.groups[group].used) {
            let chain = Chain::new(simd, problem, point, group, part);
            all.include(&backward(&chain, point, work, mu));
        }
        all
    }
}

struct Substitute<'a>(&'a Problem, &'a Iterate, &'a mut Work, f64, usize);

impl WithSimd for Substitute<'_> {
    type Output = Outlook;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Outlook {
        let Self(problem, point, work, mu, group) = self;
        let mut all = Outlook::default();
        for part in 0..registers::<S>(problem.groups[group].used) {
            let one = forward(&Chain::new(simd, problem, point, group, part), work, mu);
            all.slack = all.slack.max(one.slack);
            all.multiplier = all.multiplier.max(one.multiplier);
            all.shares += one.shares;
        }
        all
    }
}

struct Compare<'a>(&'a Problem, &'a Iterate, &'a Work, usize);

impl WithSimd for Compare<'_> {
    type Output = Trial;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Trial {
        let Self(problem, point, work, group) = self;
        let mut all = Trial::default();
        for part in 0..registers::<S>(problem.groups[group].used) {
            let one = trial(&Chain::new(simd, problem, point, group, part), work);
            all.sum += one.sum;
            all.lost = all.lost.max(one.lost);
            all.logarithms += one.logarithms;
        }
        all
    }
}

/// Steps of the durations by Newton's method, relative to the durations so that short
/// segments count like long ones.
///
/// Where the curvature is not positive, the magnitudes of its eigenvalues take its place:
/// the step then follows negative curvature downhill. False if something is not a number.
fn couple(work: &mut Work, durations: &[f64]) -> bool {
    let n = durations.len();
    let scaled = |i: usize, l: usize| work.curvature[i * n + l] * durations[i] * durations[l];
    let mut matrix: Vec<f64> = (0..n * n).map(|e| scaled(e / n, e % n)).collect();
    let right: Vec<f64> = (0..n).map(|i| -(1.0 + work.slope[i]) * durations[i]).collect();
    if matrix.iter().chain(&right).any(|value| !value.is_finite()) {
        return false;
    }
    let whole = DMatrix::from_row_slice(n, n, &matrix);
    work.durations.copy_from_slice(&right);
    if !eliminate(&mut matrix, &mut work.durations) {
        let eigen = SymmetricEigen::new(whole);
        let floor = (1e-8 * eigen.eigenvalues.amax()).max(f64::MIN_POSITIVE);
        work.durations.fill(0.0);
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let along: f64 = vector.iter().zip(&right).map(|(a, b)| a * b).sum();
            let share = along / value.abs().max(floor);
            for (step, component) in work.durations.iter_mut().zip(vector.iter()) {
                *step += share * component;
            }
        }
    }
    for (step, duration) in work.durations.iter_mut().zip(durations) {
        *step *= duration;
    }
    true
}

/// Solves `matrix x = right` in place by elimination; false unless it is clearly
/// positive definite.
fn eliminate(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let n = right.len();
    let largest = (0..n).map(|i| matrix[i * n + i].abs()).fold(0.0, f64::max);
    for c in 0..n {
        let pivot = matrix[c * n + c];
        if pivot <= 1e-9 * largest || pivot.is_nan() {
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
        let known: f64 = (c + 1..n).map(|l| matrix[c * n + l] * right[l]).sum();
        right[c] = (right[c] - known) / matrix[c * n + c];
    }
    true
}

/// A part of the step: `primal` of the variables', `dual` of the inequalities' multipliers'.
fn advance(
    problem: &Problem,
    old: &Iterate,
    work: &Work,
    [primal, dual]: [f64; 2],
    new: &mut Iterate,
) {
    let k = problem.cells;
    let all = problem.segments * k;
    let steps = old.cells.iter().zip(&work.steps);
    for (index, (new, (old, step))) in new.cells.iter_mut().zip(steps).enumerate() {
        let c = index % all;
        // Positions at waypoints are given where there is no room, and so is rest at the goal, but
        // for acceleration that may jump.
        let goal = c + 1 == all;
        new.s[0] = match (&problem.berths[index / k], (c + 1).is_multiple_of(k)) {
            (_, false) => old.s[0] + step.s[0] * primal,
            (Some(berth), true) => old.s[0] + step.s[0] * primal * berth.open,
            (None, true) => old.s[0],
        };
        new.s[1] = if goal { old.s[1] } else { old.s[1] + step.s[1] * primal };
        let mut change = step.s[2] * primal;
        if goal {
            change = change * (Lanes([1.0; WIDTH]) - problem.groups[index / all].smooth);
        }
        new.s[2] = old.s[2] + change;
        for (new, (old, step)) in new.z.iter_mut().zip(old.z.iter().zip(&step.z)) {
            *new = *old + *step * dual;
        }
    }
    for (new, (old, step)) in new.berths.iter_mut().zip(old.berths.iter().zip(&work.berths)) {
        for side in 0..2 {
            new[side] = old[side] + step[side] * dual;
        }
    }
    for (i, step) in work.durations.iter().enumerate() {
        new.durations[i] = old.durations[i] + step * primal;
    }
    let mix = |new: &mut Lanes, old: Lanes, full: Lanes| *new = old + (full + (-old)) * primal;
    for i in 0..new.lambda.len() {
        mix(&mut new.lambda[i], old.lambda[i], work.lambda[i]);
    }
    for (g, new) in new.goal.iter_mut().enumerate() {
        for e in 0..2 {
            mix(&mut new[e], old.goal[g][e], work.goal[g][e]);
        }
    }
}

/// One run of the method.
struct Run<'a> {
    problem: &'a Problem,
    arch: Arch,
    work: Work,
    /// Barrier parameter.
    mu: f64,
    /// Misses and barrier function that a step must improve on, one or the other.
    filter: Vec<[f64; 2]>,
    /// Barrier function, counted from the last change of `mu`.
    value: f64,
    /// Misses at the start, at least one.
    scale: f64,
}

impl Run<'_> {
    /// Factorises at `point` and says how far it is from the barrier problem's solution.
    fn factorise(&mut self, point: &Iterate) -> Residuals {
        let mut all = Residuals::default();
        self.work.curvature.fill(0.0);
        self.work.slope.fill(0.0);
        self.work.gradient.fill(0.0);
        for group in 0..self.problem.groups.len() {
            let part = Factorise(self.problem, point, &mut self.work, self.mu, group);
            all.include(&self.arch.dispatch(part));
        }
        for (slope, duration) in self.work.gradient.iter().zip(&point.durations) {
            all.dual = all.dual.max((slope + 1.0).abs() * duration);
        }
        all
    }

    /// Lowers the barrier parameter.
    fn lower(&mut self, point: &Iterate, end: f64) {
        self.mu = (self.mu * FALL).max(end);
        self.filter.clear();
        self.value = 0.0;
        self.factorise(point);
    }

    /// Largest parts of the step, and the slope of the barrier function along it.
    fn outlook(&mut self, point: &Iterate) -> ([f64; 2], f64) {
        let mut all = Outlook::default();
        for group in 0..self.problem.groups.len() {
            let part = Substitute(self.problem, point, &mut self.work, self.mu, group);
            let one = self.arch.dispatch(part);
            all.slack = all.slack.max(one.slack);
            all.multiplier = all.multiplier.max(one.multiplier);
            all.shares += one.shares;
        }
        let most = (1.0 - self.mu).clamp(0.95, 0.999);
        let part = |share: f64| if share > most { most / share } else { 1.0 };
        let mut parts = [part(all.slack), part(all.multiplier)];
        for (duration, step) in point.durations.iter().zip(&self.work.durations) {
            if step.abs() > REACH * duration {
                parts[0] = parts[0].min(REACH * duration / step.abs());
            }
        }
        (parts, self.work.durations.iter().sum::<f64>() - self.mu * all.shares)
    }

    /// Moves `point` along the step as far as the filter allows; `sum` are its misses.
    /// False if no part of the step stays inside the limits.
    fn search(&mut self, point: &mut Iterate, next: &mut Iterate, sum: f64) -> bool {
        let ([mut primal, dual], slope) = self.outlook(point);
        let way: f64 = self.work.durations.iter().sum();
        for halvings in 0..=HALVINGS[1] {
            advance(self.problem, point, &self.work, [primal, dual], next);
            let mut trial = Trial::default();
            for group in 0..self.problem.groups.len() {
                let one = self.arch.dispatch(Compare(self.problem, next, &self.work, group));
                trial.sum += one.sum;
                trial.lost = trial.lost.max(one.lost);
                trial.logarithms += one.logarithms;
            }
            let change = primal * way - self.mu * trial.logarithms;
            let falls = slope < 0.0 && primal * libm::pow(-slope, 2.3) > libm::pow(sum, 1.1);
            let inside = trial.lost < 0.9995;
            let accepted = self.accepts([sum, trial.sum], change, falls.then_some(primal * slope));
            if inside && (accepted || halvings >= HALVINGS[0]) {
                if !accepted {
                    self.filter.clear();
                } else if !falls {
                    self.filter.push([sum, self.value]);
                }
                self.value += change;
                std::mem::swap(point, next);
                return true;
            }
            primal *= 0.5;
        }
        false
    }

    /// Whether a step from misses `before` to `after`, with this `change` of the barrier
    /// function, is good enough; `expected` is that change to first order where it decides.
    fn accepts(&self, [before, after]: [f64; 2], change: f64, expected: Option<f64>) -> bool {
        let value = self.value + change;
        let enough = match expected {
            Some(expected) if before <= SMALL * self.scale => change <= 1e-4 * expected + 1e-11,
            _ => after <= (1.0 - GAIN) * before || change <= -GAIN * before || before < 1e-9,
        };
        let better =
            |kept: &[f64; 2]| after <= (1.0 - GAIN) * kept[0] || value <= kept[1] - GAIN * kept[0];
        enough && after <= WORST * self.scale && self.filter.iter().all(better)
    }
}

/// Minimises the sum of durations from `point` on.
pub fn solve(problem: &Problem, point: &mut Iterate, settings: &Settings) -> Outcome {
    let [start, end] = settings.barrier;
    let mut run = Run {
        problem,
        arch: Arch::new(),
        work: Work::new(problem),
        mu: start,
        filter: Vec::new(),
        value: 0.0,
        scale: 1.0,
    };
    let mut next = point.clone();
    // Steps that may yet bring the misses below what is asked for.
    let mut polish = 2;
    for iterations in 0..=settings.iterations {
        let residuals = run.factorise(point);
        let Residuals { dual, primal, sum, product } = residuals;
        let failed = |run: Run| Outcome { prices: run.work.prices, iterations, converged: false };
        if !(sum.is_finite() && dual.is_finite()) {
            return failed(run);
        }
        if iterations == 0 {
            run.scale = sum.max(1.0);
        }
        if dual.max(primal).max(product - run.mu) < NEARLY * run.mu {
            if run.mu > end {
                run.lower(point, end);
            } else if primal <= settings.primal || polish == 0 {
                return Outcome { prices: run.work.prices, iterations, converged: true };
            } else {
                polish -= 1;
            }
        }
        let last = iterations == settings.iterations;
        if last || !couple(&mut run.work, &point.durations) || !run.search(point, &mut next, sum) {
            return failed(run);
        }
    }
    Outcome { prices: run.work.prices, iterations: settings.iterations, converged: false }
}
