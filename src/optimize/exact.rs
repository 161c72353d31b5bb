//! The family's true optimum: minimax over proportions, by the scaling law.
//!
//! For `minimise sum(x) subject to r_k(x) <= 1` with
//! `r_k(s x) = r_k(x) / s^(d_k)`, every direction `x` has one best multiple, so
//! `F(x) = sum(x) max_k r_k(x)^(1 / d_k)` is to be minimised over directions
//! alone: a problem without constraints and with one variable less.
//!
//! In logarithms `y = ln x`, `F` is the sum of a convex function and a maximum
//! of nearly linear ones. A smooth stand-in replaces the maximum by
//! `1/b ln sum exp(b ln r_k / d_k)`; damped Newton steps follow its minimum as
//! `b` grows until both agree. Its curvature is known from gradients, but for
//! that of the constraints themselves, which is learnt from step to step:
//! without it the search stops on the floor of a curved valley. Starts are the
//! objective's own and the best of a fixed random sample, so the method is
//! deterministic: the seed changes nothing. No proof says that the best valley
//! was among them. While the stand-in is blunt most searches end in one place;
//! those that do are not taken any further.

use nalgebra::{DMatrix, DVector};

use super::entry::{OptimizerEntry, Parameter, ParameterKind, Settings, real};
use super::interior::Interior;
use super::{Evaluator, Objective, Optimizer, Ratios, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "exact",
    title: "Exact optimum of the family",
    description: "Deterministic. Minimises over duration proportions with the scaling law, from \
                  several starts, by smoothed minimax with Newton steps; a weighted objective by \
                  a logarithmic barrier. Ignores the seed and constraint_handling.",
    source: "scaling law of rest-to-rest curves; aggregate smoothing of minimax problems as in \
             Xiao and Yu 2010, Applied Mathematics and Computation 216, 1868-1879",
    parameters: PARAMETERS,
    build: |settings, objective, _| {
        if objective.is_constrained() {
            return Box::new(Interior::new(settings, objective));
        }
        Box::new(Exact::new(settings, objective))
    },
};

const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "iterations",
        description: "starting points searched from",
        kind: ParameterKind::Integer,
        default: Some(8.0),
        min: 1.0,
        max: 1000.0,
    },
    real("tolerance", "relative accuracy of the duration", 1e-7, 1e-12, 1e-2),
];

/// Weight of what no scaling can mend, in logarithms of the objective.
const VIOLATION_WEIGHT: f64 = 50.0;

/// Step of the difference quotients in `y`; peaks are exact to rounding, so
/// gradients are good to about 1e-8.
const DIFFERENCE: f64 = 1e-6;

/// Largest Newton step in any component of `y`.
const LONGEST_STEP: f64 = 0.5;

/// `b` of every search, coarse to fine: the stand-in is within `ln(m) / b` of `F`.
const COARSE: [f64; 3] = [30.0, 200.0, 2e3];

/// `b` where a search came near the best.
const FINE: [f64; 3] = [2e4, 2e5, 2e6];

/// Coarse values this near the best may turn out best, relative.
const NEAR: f64 = 3e-3;

/// Searches that are this near in `y`, but for a common multiple, after the
/// first sharpness take the same way from there.
const MET: f64 = 1e-3;

/// Coarse results nearer than this in `y` are the same valley.
const SAME: f64 = 2e-2;

/// Rows of the curvature between two looks at the budget: at most a few
/// milliseconds.
const ROWS_UNWATCHED: usize = 16;

/// Largest difference in `y`: proportions beyond a million to one are out of
/// reach of the arithmetic of curves.
const WIDEST: f64 = 14.0;

/// Steps at one sharpness, at most.
const MOST_STEPS: usize = 60;

/// Random directions looked at before the search starts.
const SAMPLES: usize = 96;

struct Exact {
    objective_starts: Vec<Vec<f64>>,
    /// Searched from in addition, last.
    hints: Vec<Vec<f64>>,
    searches: usize,
    tolerance: f64,
    /// Starts in `y`, the best last; filled by the first step.
    starts: Vec<DVector<f64>>,
    /// Where searches stood after the first sharpness.
    met: Vec<DVector<f64>>,
    /// Coarse results and their `ln F`.
    valleys: Vec<(f64, Valley)>,
    memory: Memory,
}

/// Buffers of the evaluations.
#[derive(Default)]
struct Memory {
    position: Vec<f64>,
    ratios: Ratios,
}

/// A search in progress.
struct Valley {
    y: DVector<f64>,
    /// Curvature of the constraints, weighted by how much they count.
    bend: DMatrix<f64>,
    /// Added to the curvature's diagonal.
    damping: f64,
    /// Where the last step began.
    last: Option<Model>,
}

/// The stand-in around a point.
struct Model {
    y: DVector<f64>,
    gradient: DVector<f64>,
    /// Without the bend of the constraints.
    curvature: DMatrix<f64>,
    /// Degree less one and index of the near constraints.
    names: Vec<(usize, usize)>,
    weights: DVector<f64>,
    /// Their gradients, one per row.
    slopes: DMatrix<f64>,
}

/// The constraints near the largest one at some `y`.
struct Sample {
    /// Degree less one, index and `ln r_k / d_k`.
    near: Vec<(usize, usize, f64)>,
    /// The largest `ln r_k / d_k`.
    largest: f64,
    /// `ln sum(x)`.
    log_sum: f64,
    /// What no scaling can mend.
    violation: f64,
}

impl Exact {
    fn new(settings: &Settings, objective: &dyn Objective) -> Self {
        Self {
            objective_starts: objective.starts(),
            hints: objective.hints().to_vec(),
            searches: settings.integer("iterations").max(1) as usize,
            tolerance: settings.get("tolerance"),
            starts: Vec::new(),
            met: Vec::new(),
            valleys: Vec::new(),
            memory: Memory::default(),
        }
    }

    /// Orders the objective's starts and random directions around them by `F`.
    fn choose_starts(&mut self, evaluator: &mut Evaluator<'_>) {
        let mut random = RandomStream::new(0, 0);
        let dimension = evaluator.bounds().dimension();
        let given = self.objective_starts.iter().map(|x| logarithms(x));
        let mut starts: Vec<DVector<f64>> = given.collect();
        starts.push(DVector::zeros(dimension));
        let centre = starts[0].clone();
        for _ in 0..SAMPLES {
            // A sum of three uniform numbers spreads like a bell of deviation 0.5.
            let mut spread = || random.unit() + random.unit() + random.unit() - 1.5;
            starts.push(centre.map(|y| y + spread()));
        }
        let mut ranked: Vec<(f64, DVector<f64>)> = Vec::with_capacity(starts.len());
        for y in starts {
            let Some(sample) = self.memory.sample(evaluator, &y, 0.0) else { break };
            ranked.push((sample.value(), y));
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.starts = ranked.into_iter().map(|(_, y)| y).take(self.searches).collect();
        self.starts.reverse();
    }

    /// Searches coarsely from `y`, as far as no other search did so.
    fn search(&mut self, evaluator: &mut Evaluator<'_>, y: DVector<f64>) {
        let mut valley = Valley::new(y);
        for sharpness in COARSE {
            self.memory.descend(evaluator, &mut valley, sharpness, self.tolerance);
            if sharpness == COARSE[0] && !self.is_new(&valley.y) {
                return;
            }
        }
        let known = self.valleys.iter().any(|(_, other)| (&other.y - &valley.y).amax() < SAME);
        if let (false, Some(sample)) = (known, self.memory.sample(evaluator, &valley.y, 0.0)) {
            self.valleys.push((sample.value(), valley));
        }
    }

    /// False if another search stood at `y` after the first sharpness.
    fn is_new(&mut self, y: &DVector<f64>) -> bool {
        let apart = |other: &DVector<f64>| {
            let difference = other - y;
            let multiple = difference.mean();
            difference.iter().fold(0.0f64, |apart, d| apart.max((d - multiple).abs()))
        };
        let new = self.met.iter().all(|other| apart(other) >= MET);
        if new {
            self.met.push(y.clone());
        }
        new
    }
}

impl Optimizer for Exact {
    /// Every step searches coarsely from one start; the last one from the hints,
    /// which add to the search and change nothing else, and goes on from the
    /// best valleys.
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        if self.starts.is_empty() && self.valleys.is_empty() {
            self.choose_starts(evaluator);
        }
        if let Some(y) = self.starts.pop() {
            self.search(evaluator, y);
            return Step { mean: None, converged: false };
        }
        for hint in std::mem::take(&mut self.hints) {
            self.search(evaluator, logarithms(&hint));
        }
        let best = self.valleys.iter().map(|(value, _)| *value).fold(f64::INFINITY, f64::min);
        for (_, valley) in self.valleys.iter_mut().filter(|(value, _)| *value <= best + NEAR) {
            for sharpness in FINE {
                self.memory.descend(evaluator, valley, sharpness, self.tolerance);
            }
        }
        Step { mean: None, converged: true }
    }
}

impl Memory {
    /// Evaluates at `y` and offers the scaled candidate to the evaluator.
    /// Constraints further than `window` below the largest are left out. None
    /// once the search has to end.
    fn sample(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        y: &DVector<f64>,
        window: f64,
    ) -> Option<Sample> {
        self.position.clear();
        self.position.extend(y.iter().map(|y| libm::exp(*y)));
        let violation = evaluator.homogeneous(&self.position, &mut self.ratios)?;
        let root = [|r: f64| r, f64::sqrt, libm::cbrt];
        let worst = |list: &Vec<f64>| list.iter().copied().fold(0.0, f64::max);
        let roots = self.ratios.iter().zip(root).map(|(list, root)| root(worst(list)));
        let largest = roots.fold(0.0, f64::max);
        let sum: f64 = self.position.iter().sum();
        let mut near = Vec::new();
        let mut threshold = 1.0;
        for (degree, list) in self.ratios.iter().enumerate() {
            // Logarithms are taken of what can matter only.
            threshold *= largest * libm::exp(-window);
            let order = (degree + 1) as f64;
            let above = list.iter().enumerate().filter(|(_, ratio)| **ratio >= threshold);
            near.extend(above.map(|(index, ratio)| (degree, index, libm::log(*ratio) / order)));
        }
        // Proportions beyond what numbers hold must not look like a plan.
        let lawful = largest > 0.0 && largest.is_finite() && sum.is_finite();
        let violation = if lawful { violation } else { f64::INFINITY };
        let sample =
            Sample { near, largest: libm::log(largest), log_sum: libm::log(sum), violation };
        if violation <= 0.0 {
            for x in &mut self.position {
                *x *= largest;
            }
            evaluator.offer(&self.position, sum * largest);
        }
        Some(sample)
    }

    /// Damped Newton steps (Levenberg and Marquardt) on the smooth stand-in.
    fn descend(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        valley: &mut Valley,
        sharpness: f64,
        tolerance: f64,
    ) {
        let window = 30.0 / sharpness;
        let Some(mut here) = self.sample(evaluator, &valley.y, window) else { return };
        let mut small = 0;
        for _ in 0..MOST_STEPS {
            let Some(model) = self.model(evaluator, &valley.y, &here, sharpness) else { return };
            valley.learn(&model);
            let value = here.smooth(sharpness);
            let mut accepted = None;
            for _ in 0..12 {
                let step = newton_step(
                    &model.gradient,
                    &(&model.curvature + &valley.bend),
                    valley.damping,
                );
                let Some(step) = step else {
                    valley.damping *= 10.0;
                    continue;
                };
                let trial = within_reach(&valley.y + step);
                let Some(there) = self.sample(evaluator, &trial, window) else { return };
                if there.smooth(sharpness) < value {
                    valley.damping = (valley.damping * 0.1).max(1e-8);
                    accepted = Some((trial, there));
                    break;
                }
                valley.damping *= 5.0;
            }
            let Some((trial, there)) = accepted else {
                // What was learnt beyond a kink may mislead here: begin afresh once.
                if valley.last.is_none() {
                    break;
                }
                valley.forget();
                continue;
            };
            let gained = value - there.smooth(sharpness);
            valley.last = Some(model);
            valley.y = trial;
            here = there;
            // One small step may be an unlucky one.
            small = if gained < 0.1 * tolerance { small + 1 } else { 0 };
            if small == 2 {
                break;
            }
        }
    }

    /// Gradient and curvature of the stand-in, from difference quotients. None
    /// once the search has to end.
    fn model(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        y: &DVector<f64>,
        here: &Sample,
        sharpness: f64,
    ) -> Option<Model> {
        let n = y.len();
        let share = DVector::from_iterator(n, y.iter().map(|y| libm::exp(y - here.log_sum)));
        let weights = here.weights(sharpness);
        let mut slopes = DMatrix::zeros(here.near.len(), n);
        let mut gradient = share.clone();
        let mut shifted = y.clone();
        for i in 0..n {
            shifted[i] += DIFFERENCE;
            // Only the raw ratios at the same indices are needed here.
            self.position.clear();
            self.position.extend(shifted.iter().map(|y| libm::exp(*y)));
            let violation = evaluator.homogeneous(&self.position, &mut self.ratios)?;
            for (row, &(degree, index, log)) in here.near.iter().enumerate() {
                let shifted = libm::log(self.ratios[degree][index]) / (degree + 1) as f64;
                slopes[(row, i)] = (shifted - log) / DIFFERENCE;
            }
            if here.violation > 0.0 {
                gradient[i] += VIOLATION_WEIGHT * (violation - here.violation) / DIFFERENCE;
            }
            shifted[i] = y[i];
        }
        let mean = slopes.tr_mul(&weights);
        gradient += &mean;
        let mut curvature = DMatrix::from_diagonal(&share) - &share * share.transpose();
        for (row, weight) in weights.iter().enumerate() {
            // With many variables a row costs as much as many evaluations.
            if row % ROWS_UNWATCHED == 0 && evaluator.stop_reason().is_some() {
                return None;
            }
            let off = slopes.row(row).transpose() - &mean;
            curvature.ger(sharpness * weight, &off, &off, 1.0);
        }
        let names = here.near.iter().map(|&(degree, index, _)| (degree, index)).collect();
        Some(Model { y: y.clone(), gradient, curvature, names, weights, slopes })
    }
}

impl Valley {
    fn new(y: DVector<f64>) -> Self {
        let n = y.len();
        Self { y, bend: DMatrix::zeros(n, n), damping: 1e-2, last: None }
    }

    fn forget(&mut self) {
        *self = Self::new(std::mem::take(&mut self.y));
    }

    /// Learns how the constraints themselves bend from how their slopes changed
    /// over the last step (symmetric rank one, weighted as now).
    fn learn(&mut self, here: &Model) {
        let Some(before) = &self.last else { return };
        let step = &here.y - &before.y;
        let mut change = DVector::zeros(step.len());
        let mut known = 0.0;
        for (row, name) in here.names.iter().enumerate() {
            if here.weights[row] < 1e-6 {
                continue;
            }
            if let Some(old) = before.names.iter().position(|other| other == name) {
                let slope = here.slopes.row(row) - before.slopes.row(old);
                change.axpy(here.weights[row], &slope.transpose(), 1.0);
                known += here.weights[row];
            }
        }
        if known < 0.5 {
            return;
        }
        let off = change / known - &self.bend * &step;
        let along = off.dot(&step);
        // The usual guard: an update that would divide by nearly nothing is left out.
        if along.abs() > 1e-6 * off.norm() * step.norm() {
            self.bend.ger(1.0 / along, &off, &off, 1.0);
        }
    }
}

impl Sample {
    /// `ln F`, with what no scaling can mend added.
    fn value(&self) -> f64 {
        self.log_sum + self.largest + VIOLATION_WEIGHT * self.violation.max(0.0)
    }

    /// The smooth stand-in of [`value`](Self::value).
    fn smooth(&self, sharpness: f64) -> f64 {
        let excess = |log: f64| libm::exp(sharpness * (log - self.largest));
        let sum: f64 = self.near.iter().map(|&(_, _, log)| excess(log)).sum();
        self.value() + libm::log(sum) / sharpness
    }

    /// How much each near constraint counts; sums to 1.
    fn weights(&self, sharpness: f64) -> DVector<f64> {
        let excess =
            |&(_, _, log): &(usize, usize, f64)| libm::exp(sharpness * (log - self.largest));
        let weights = DVector::from_iterator(self.near.len(), self.near.iter().map(excess));
        let sum = weights.sum();
        weights / sum
    }
}

/// `-(curvature + damping)⁻¹ gradient`, no longer than [`LONGEST_STEP`].
fn newton_step(
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let mut damped = curvature.clone();
    for i in 0..gradient.len() {
        // Absolute: along a valley's floor curvature stays of order one however
        // steep its walls become.
        damped[(i, i)] += damping;
    }
    let step = -damped.cholesky()?.solve(gradient);
    let longest = step.amax();
    longest.is_finite().then(|| step * (LONGEST_STEP / longest).min(1.0))
}

/// No proportion beyond [`WIDEST`].
fn within_reach(mut y: DVector<f64>) -> DVector<f64> {
    let least = y.max() - WIDEST;
    y.iter_mut().for_each(|y| *y = y.max(least));
    y
}

fn logarithms(x: &[f64]) -> DVector<f64> {
    DVector::from_iterator(x.len(), x.iter().map(|x| libm::log(*x)))
}
