//! Evaluates candidates, counts them and remembers the best.

use rayon::prelude::*;

use super::{Appraisal, Bounds, Candidate, Objective, Ratios};
use crate::budget::{Budget, StopReason};

/// Work below this is not worth waking another thread, ns.
const PARALLEL_NS: f64 = 200_000.0;

/// Most candidates a thread evaluates between two looks at the budget.
const CHUNK: usize = 64;

/// Most time it should take over them, ns: how late a cancelled search may end.
const CHUNK_NS: f64 = 1e6;

/// The objective as an optimizer sees it.
pub struct Evaluator<'a> {
    objective: &'a dyn Objective,
    budget: &'a Budget,
    /// One per thread that ever evaluated.
    candidates: Vec<Box<dyn Candidate + 'a>>,
    evaluations: u64,
    best: f64,
    best_position: Vec<f64>,
    stopped: Option<StopReason>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator that has seen nothing yet.
    pub fn new(objective: &'a dyn Objective, budget: &'a Budget) -> Self {
        Self {
            objective,
            budget,
            candidates: vec![objective.candidate()],
            evaluations: 0,
            best: f64::INFINITY,
            best_position: Vec::new(),
            stopped: None,
        }
    }

    /// The search box.
    pub fn bounds(&self) -> &'a Bounds {
        self.objective.bounds()
    }

    /// Candidates evaluated so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The best fitness so far; infinite if none was feasible.
    pub fn best(&self) -> f64 {
        self.best
    }

    /// The candidate with the best fitness; empty if none was feasible.
    pub fn best_position(&self) -> &[f64] {
        &self.best_position
    }

    /// Why the search has to end, if it has to.
    pub fn stop_reason(&mut self) -> Option<StopReason> {
        self.stopped = self.stopped.or_else(|| self.budget.stop_reason(self.evaluations));
        self.stopped
    }

    /// Moves a candidate to a feasible one nearby, if the objective can.
    pub fn repair(&mut self, position: &mut [f64]) {
        self.candidates[0].repair(position);
    }

    /// [`Candidate::homogeneous`], counted as one evaluation; none once the
    /// search has to end. The very first evaluation is always made: a search
    /// without any time still has something to show.
    pub fn homogeneous(&mut self, position: &[f64], ratios: &mut Ratios) -> Option<f64> {
        if self.evaluations > 0 && self.stop_reason().is_some() {
            return None;
        }
        self.evaluations += 1;
        Some(self.candidates[0].homogeneous(position, ratios))
    }

    /// [`Candidate::constrained`], counted as one evaluation; none once the
    /// search has to end.
    pub fn constrained(&mut self, position: &[f64], constraints: &mut Vec<f64>) -> Option<f64> {
        if self.stop_reason().is_some() {
            return None;
        }
        self.evaluations += 1;
        Some(self.candidates[0].constrained(position, constraints))
    }

    /// The multiple of a candidate that its fitness speaks of.
    pub fn scale(&mut self, position: &[f64]) -> f64 {
        self.candidates[0].scale(position)
    }

    /// Offers a candidate whose fitness the optimizer worked out itself.
    pub fn offer(&mut self, position: &[f64], fitness: f64) {
        if fitness < self.best {
            self.best = fitness;
            self.best_position.clear();
            self.best_position.extend_from_slice(position);
        }
    }

    /// Evaluates a population, `positions[i * dimension..]` being candidate `i`.
    ///
    /// Runs in several threads where that pays; the result does not depend on
    /// it. Candidates beyond the budget get an infinite fitness, and so do those
    /// whose fitness is not a number; the very first ones are evaluated even
    /// without any time.
    pub fn population(&mut self, positions: &[f64], fitness: &mut [f64]) {
        self.evaluate(positions, fitness, f64::INFINITY, |candidate, first, positions, fitness| {
            candidate.batch(first, positions, fitness);
            for fitness in fitness.iter_mut().filter(|fitness| fitness.is_nan()) {
                *fitness = f64::INFINITY;
            }
        });
        let dimension = self.bounds().dimension();
        for (position, &fitness) in positions.chunks_exact(dimension).zip(fitness.iter()) {
            self.offer(position, fitness);
        }
    }

    /// Like [`population`](Self::population), with what the fitnesses are made of.
    pub fn appraise(&mut self, positions: &[f64], appraisals: &mut [Appraisal]) {
        let dimension = self.bounds().dimension();
        self.evaluate(
            positions,
            appraisals,
            Appraisal::UNUSABLE,
            |candidate, _, positions, all| {
                for (position, appraisal) in positions.chunks_exact(dimension).zip(all) {
                    let Appraisal { fitness, cost, excess } = candidate.appraise(position);
                    if !(fitness.is_nan() || cost.is_nan() || excess.is_nan()) {
                        *appraisal = Appraisal { fitness, cost, excess };
                    }
                }
            },
        );
        for (position, appraisal) in positions.chunks_exact(dimension).zip(appraisals.iter()) {
            self.offer(position, appraisal.fitness);
        }
    }

    /// Has `all` write what it says about every candidate, a chunk at a time,
    /// the first of which is evaluation number so and so of the search; leaves
    /// `unusable` about those beyond the budget.
    fn evaluate<T: Copy + Send>(
        &mut self,
        positions: &[f64],
        values: &mut [T],
        unusable: T,
        all: impl Fn(&mut dyn Candidate, u64, &[f64], &mut [T]) + Sync,
    ) {
        values.fill(unusable);
        let dimension = self.bounds().dimension();
        let work = self.objective.evaluation_ns() * values.len() as f64;
        let pays = work >= PARALLEL_NS && self.objective.may_use_threads();
        let threads = if pays { rayon::current_num_threads() } else { 1 };
        while self.candidates.len() < threads {
            self.candidates.push(self.objective.candidate());
        }
        let chunk = ((CHUNK_NS / self.objective.evaluation_ns()) as usize).clamp(1, CHUNK);
        let mut done = 0;
        while done < values.len() && (self.evaluations == 0 || self.stop_reason().is_none()) {
            // To the number, so that a limit gives the same result on any
            // number of threads.
            let left = self.budget.evaluations_left(self.evaluations);
            let left = usize::try_from(left).unwrap_or(usize::MAX);
            let round = (chunk * threads).min(values.len() - done).min(left);
            let positions = &positions[done * dimension..(done + round) * dimension];
            let values = &mut values[done..done + round];
            let before = self.evaluations;
            if threads == 1 {
                all(self.candidates[0].as_mut(), before, positions, values);
            } else {
                self.candidates
                    .par_iter_mut()
                    .zip(positions.par_chunks(chunk * dimension))
                    .zip(values.par_chunks_mut(chunk))
                    .enumerate()
                    .for_each(|(at, ((candidate, positions), values))| {
                        all(candidate.as_mut(), before + (at * chunk) as u64, positions, values);
                    });
            }
            self.evaluations += round as u64;
            done += round;
        }
    }
}
