//! Smooth objectives under constraints: a logarithmic barrier.
//!
//! What `exact` does where the objective is not the sum of the variables. For
//! `minimise f(x) subject to g_k(x) <= 1`, `f` and `x` positive, Newton steps in
//! `y = ln x` follow the minimum of `ln f - m sum ln(1 - g_k)` while `m` falls
//! (Nocedal and Wright 2006, Numerical Optimization, doi:10.1007/978-0-387-40065-5,
//! section 19.6). The barrier's own curvature is known from gradients; that of
//! `f` and of the constraints is learnt from step to step (damped BFGS, procedure
//! 18.2 there). Starts are the objective's own and a fixed random sample, so the
//! method is deterministic; no proof says that the best valley was among them.

use nalgebra::{DMatrix, DVector};

use super::entry::Settings;
use super::{Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Random directions looked at before the search starts.
const SAMPLES: usize = 96;

/// Step of the difference quotients in `y`.
const DIFFERENCE: f64 = 1e-6;

/// Largest step in any component of `y`.
const LONGEST_STEP: f64 = 0.5;

/// `m` of the first descent, and by how much it falls from one to the next.
const FIRST: f64 = 1e-2;
const FALL: f64 = 0.1;

/// `m` at which valleys are compared.
const COARSE: f64 = 1e-5;

/// Coarse values this near the best may turn out best, relative.
const NEAR: f64 = 1e-3;

/// Coarse results nearer than this in `y` are the same valley.
const SAME: f64 = 1e-3;

/// Steps for one `m`, at most.
const MOST_STEPS: usize = 50;

/// A step that promises less than this share of `m` is not worth making.
const ENOUGH: f64 = 0.1;

/// Halvings of one step, at most.
const MOST_HALVINGS: usize = 40;

/// Rows of the curvature between two looks at the budget.
const ROWS_UNWATCHED: usize = 16;

/// Factors that may move a start away from its constraints.
const INWARDS: [f64; 11] =
    [1.1, 1.03, 1.01, 1.003, 1.001, 1.0001, 1.00001, 0.99999, 0.9999, 0.999, 0.99];

/// The barrier method as an optimizer.
pub struct Interior {
    given: Vec<Vec<f64>>,
    searches: usize,
    tolerance: f64,
    /// Starts in `y`, the best last; none before the first step.
    starts: Option<Vec<DVector<f64>>>,
    valleys: Vec<(f64, Valley)>,
    memory: Memory,
}

/// Buffers of the evaluations.
#[derive(Default)]
struct Memory {
    position: Vec<f64>,
    constraints: Vec<f64>,
}

/// A search in progress.
struct Valley {
    y: DVector<f64>,
    /// Curvature of objective and constraints together, learnt.
    curvature: DMatrix<f64>,
    /// Where the last step began.
    last: Option<Model>,
}

/// Objective and constraints at a point.
struct Sample {
    log: f64,
    constraints: Vec<f64>,
}

/// Their slopes.
struct Model {
    y: DVector<f64>,
    /// Of the objective's logarithm.
    gradient: DVector<f64>,
    /// Of the objective and the barrier.
    total: DVector<f64>,
    /// Which constraints are near, with their distance to 1.
    near: Vec<(usize, f64)>,
    /// Their gradients, one per row.
    slopes: DMatrix<f64>,
}

impl Interior {
    /// With the parameters of `exact`.
    pub fn new(settings: &Settings, objective: &dyn Objective) -> Self {
        Self {
            given: objective.starts(),
            searches: settings.integer("iterations").max(1) as usize,
            tolerance: settings.get("tolerance"),
            starts: None,
            valleys: Vec::new(),
            memory: Memory::default(),
        }
    }

    /// The objective's starts and random directions around the first one,
    /// the best of them strictly within the constraints.
    fn choose_starts(&mut self, evaluator: &mut Evaluator<'_>) -> Vec<DVector<f64>> {
        let n = evaluator.bounds().dimension();
        let mut random = RandomStream::new(0, 0);
        let mut positions: Vec<f64> = self.given.concat();
        positions.extend(std::iter::repeat_n(1.0, n));
        let centre = positions[..n].to_vec();
        for _ in 0..SAMPLES {
            // A sum of three uniform numbers spreads like a bell of deviation 0.5.
            let mut spread = || random.unit() + random.unit() + random.unit() - 1.5;
            positions.extend(centre.iter().map(|x| x * libm::exp(spread())));
        }
        let mut fitness = vec![0.0; positions.len() / n];
        evaluator.population(&positions, &mut fitness);
        let mut order: Vec<usize> =
            (0..fitness.len()).filter(|i| fitness[*i].is_finite()).collect();
        order.sort_by(|a, b| fitness[*a].total_cmp(&fitness[*b]));
        let places = order.into_iter().map(|i| &positions[i * n..(i + 1) * n]);
        let inside = places.filter_map(|place| self.memory.inside(evaluator, place));
        let mut starts: Vec<DVector<f64>> = inside.take(self.searches).collect();
        starts.reverse();
        starts
    }
}

impl Optimizer for Interior {
    /// Every step searches coarsely from one start; the last one goes on from
    /// the best valleys.
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        if self.starts.is_none() {
            self.starts = Some(self.choose_starts(evaluator));
        }
        if let Some(y) = self.starts.as_mut().and_then(Vec::pop) {
            let mut valley = Valley::new(y);
            let value = self.memory.follow(evaluator, &mut valley, FIRST, COARSE);
            let known = self.valleys.iter().any(|(_, other)| (&other.y - &valley.y).amax() < SAME);
            if let (false, Some(value)) = (known, value) {
                self.valleys.push((value, valley));
            }
            return Step { mean: None, converged: false };
        }
        let best = self.valleys.iter().map(|(value, _)| *value).fold(f64::INFINITY, f64::min);
        let least = 1e-2 * self.tolerance;
        for (_, valley) in self.valleys.iter_mut().filter(|(value, _)| *value <= best + NEAR) {
            if self.memory.follow(evaluator, valley, FALL * COARSE, least).is_none() {
                break;
            }
        }
        Step { mean: None, converged: true }
    }
}

impl Memory {
    /// Evaluates at `y`. None once the search has to end.
    fn sample(&mut self, evaluator: &mut Evaluator<'_>, y: &DVector<f64>) -> Option<Sample> {
        self.position.clear();
        self.position.extend(y.iter().map(|y| libm::exp(*y)));
        let value = evaluator.constrained(&self.position, &mut self.constraints)?;
        Some(Sample { log: libm::log(value), constraints: self.constraints.clone() })
    }

    /// The multiple of `direction` furthest from all constraints, of those near
    /// its best one; none if there is none strictly within them.
    fn inside(&mut self, evaluator: &mut Evaluator<'_>, direction: &[f64]) -> Option<DVector<f64>> {
        let scale = evaluator.scale(direction);
        let mut best = (1.0, None);
        for factor in INWARDS {
            let logs = direction.iter().map(|x| libm::log(x * scale * factor));
            let y = DVector::from_iterator(direction.len(), logs);
            let largest = self.sample(evaluator, &y)?.largest();
            if largest < best.0 {
                best = (largest, Some(y));
            }
        }
        best.1
    }

    /// Descends while `m` falls from `first` to `least`, then rates where that
    /// led. None once the search has to end.
    fn follow(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        valley: &mut Valley,
        first: f64,
        least: f64,
    ) -> Option<f64> {
        let mut m = first;
        loop {
            m = m.max(least);
            let ended = self.descend(evaluator, valley, m).is_none();
            self.position.clear();
            self.position.extend(valley.y.iter().map(|y| libm::exp(*y)));
            let mut fitness = [f64::INFINITY];
            evaluator.population(&self.position, &mut fitness);
            if ended || m <= least {
                return (!ended).then(|| libm::log(fitness[0]));
            }
            m *= FALL;
        }
    }

    /// Newton steps on the objective with its barrier. None once the search has
    /// to end.
    fn descend(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        valley: &mut Valley,
        m: f64,
    ) -> Option<()> {
        let mut here = self.sample(evaluator, &valley.y)?;
        for _ in 0..MOST_STEPS {
            let model = self.model(evaluator, &valley.y, &here, m)?;
            valley.learn(&model, m);
            let step = valley.step(evaluator, &model, m)?;
            let promised = -step.dot(&model.total);
            // An error of the order of the barrier's own is good enough.
            if promised <= ENOUGH * m || promised.is_nan() {
                return Some(());
            }
            match self.shorten(evaluator, &valley.y, &here, step, m)? {
                Some((y, there)) => {
                    valley.y = y;
                    valley.last = Some(model);
                    here = there;
                }
                // What was learnt beyond a kink may mislead here: begin afresh once.
                None if valley.last.is_some() => valley.forget(),
                None => return Some(()),
            }
        }
        Some(())
    }

    /// The longest of `step`, its half, its quarter, ... that leads down within
    /// the constraints.
    fn shorten(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        y: &DVector<f64>,
        here: &Sample,
        mut step: DVector<f64>,
        m: f64,
    ) -> Option<Option<(DVector<f64>, Sample)>> {
        let value = here.with_barrier(m);
        for _ in 0..MOST_HALVINGS {
            let trial = y + &step;
            let there = self.sample(evaluator, &trial)?;
            if there.with_barrier(m) < value {
                return Some(Some((trial, there)));
            }
            step *= 0.5;
        }
        Some(None)
    }

    /// Slopes by difference quotients. None once the search has to end.
    fn model(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        y: &DVector<f64>,
        here: &Sample,
        m: f64,
    ) -> Option<Model> {
        let n = y.len();
        // Further away the barrier's curvature is nothing beside the objective's.
        let window = 10.0 * m.sqrt();
        let gaps = here.constraints.iter().map(|g| 1.0 - g).enumerate();
        let near: Vec<(usize, f64)> = gaps.filter(|(_, gap)| *gap < window).collect();
        let mut slopes = DMatrix::zeros(near.len(), n);
        let (mut gradient, mut total) = (DVector::zeros(n), DVector::zeros(n));
        let mut shifted = y.clone();
        for i in 0..n {
            shifted[i] += DIFFERENCE;
            self.position.clear();
            self.position.extend(shifted.iter().map(|y| libm::exp(*y)));
            let value = evaluator.constrained(&self.position, &mut self.constraints)?;
            gradient[i] = (libm::log(value) - here.log) / DIFFERENCE;
            let pairs = self.constraints.iter().zip(&here.constraints);
            let push: f64 = pairs.map(|(there, here)| (there - here) / (1.0 - here)).sum();
            total[i] = gradient[i] + m * push / DIFFERENCE;
            for (row, (k, _)) in near.iter().enumerate() {
                slopes[(row, i)] = (self.constraints[*k] - here.constraints[*k]) / DIFFERENCE;
            }
            shifted[i] = y[i];
        }
        Some(Model { y: y.clone(), gradient, total, near, slopes })
    }
}

impl Sample {
    fn largest(&self) -> f64 {
        let largest = self.constraints.iter().copied().fold(0.0, f64::max);
        if self.log.is_finite() { largest } else { f64::INFINITY }
    }

    /// The objective's logarithm with the barrier; infinite outside.
    fn with_barrier(&self, m: f64) -> f64 {
        // Also where a constraint is not a number.
        if !self.constraints.iter().all(|g| *g < 1.0) {
            return f64::INFINITY;
        }
        // Few logarithms: products of several gaps stay far from zero.
        let logs = self.constraints.chunks(8).map(|some| {
            let product: f64 = some.iter().map(|g| 1.0 - g).product();
            libm::log(product)
        });
        self.log - m * logs.sum::<f64>()
    }
}

impl Valley {
    fn new(y: DVector<f64>) -> Self {
        let n = y.len();
        Self { y, curvature: DMatrix::identity(n, n), last: None }
    }

    fn forget(&mut self) {
        *self = Self::new(std::mem::take(&mut self.y));
    }

    /// Learns the curvature of objective and constraints, these weighted as
    /// now, from how slopes changed over the last step (damped BFGS).
    fn learn(&mut self, here: &Model, m: f64) {
        let Some(before) = &self.last else { return };
        let step = &here.y - &before.y;
        let mut change = &here.gradient - &before.gradient;
        for (row, (k, gap)) in here.near.iter().enumerate() {
            // Constraints are listed in order.
            if let Ok(old) = before.near.binary_search_by_key(k, |(k, _)| *k) {
                let slope = here.slopes.row(row) - before.slopes.row(old);
                change.axpy(m / gap, &slope.transpose(), 1.0);
            }
        }
        let pulled = &self.curvature * &step;
        let bent = step.dot(&pulled);
        let along = step.dot(&change);
        if along < 0.2 * bent {
            let share = 0.8 * bent / (bent - along);
            change = change * share + &pulled * (1.0 - share);
        }
        let along = step.dot(&change);
        if bent > 0.0 && along > 0.0 && along.is_finite() {
            self.curvature.ger(1.0 / along, &change, &change, 1.0);
            self.curvature.ger(-1.0 / bent, &pulled, &pulled, 1.0);
        }
    }

    /// The Newton step, no longer than [`LONGEST_STEP`]. None once the search
    /// has to end.
    fn step(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        model: &Model,
        m: f64,
    ) -> Option<DVector<f64>> {
        let mut curvature = self.curvature.clone();
        for (row, (_, gap)) in model.near.iter().enumerate() {
            // With many variables a row costs as much as many evaluations.
            if row % ROWS_UNWATCHED == 0 && evaluator.stop_reason().is_some() {
                return None;
            }
            let slope = model.slopes.row(row).transpose();
            curvature.ger(m / (gap * gap), &slope, &slope, 1.0);
        }
        let solved = curvature.cholesky().map(|cholesky| -cholesky.solve(&model.total));
        let step = solved.filter(|step| step.amax().is_finite());
        // Rounding can spoil what was learnt; downhill is always right.
        let step = step.unwrap_or_else(|| -&model.total);
        let longest = step.amax();
        Some(if longest > LONGEST_STEP { step * (LONGEST_STEP / longest) } else { step })
    }
}
