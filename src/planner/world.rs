//! What a planner sees: the problem, its checker, and random states.

use super::{PlanningProblem, ValidityChecker};
use crate::math::random::RandomStream;

/// A problem with its checker, random numbers and a count of checks.
pub(super) struct World<'a, C> {
    pub problem: &'a PlanningProblem,
    checker: &'a mut C,
    /// Motions checked so far.
    pub checks: u64,
    pub random: RandomStream,
    even: Even,
}

impl<'a, C: ValidityChecker> World<'a, C> {
    pub fn new(problem: &'a PlanningProblem, checker: &'a mut C, seed: u64) -> Self {
        let even = Even::new(problem.dimension(), seed);
        Self { problem, checker, checks: 0, random: RandomStream::new(seed, 0), even }
    }

    /// Whether the straight motion between two states is free.
    #[inline(always)]
    pub fn is_free(&mut self, from: &[f64], to: &[f64]) -> bool {
        self.checks += 1;
        self.checker.is_motion_valid(from, to)
    }

    /// Distance to the nearest obstacle; methods that ask are refused where it
    /// is not known.
    pub fn clearance(&mut self, state: &[f64]) -> f64 {
        self.checker.clearance(state).unwrap_or(f64::INFINITY)
    }

    /// Draws a state from the whole box.
    pub fn sample(&mut self, state: &mut [f64]) {
        let ends = self.problem.lower.iter().zip(&self.problem.upper);
        for (x, (&lower, &upper)) in state.iter_mut().zip(ends) {
            *x = self.random.uniform(lower, upper);
        }
    }

    /// Draws a free state; one that is not if none is found soon.
    pub fn sample_free(&mut self, state: &mut [f64]) {
        const TRIES: usize = 64;
        for _ in 0..TRIES {
            self.sample(state);
            if self.checker.is_state_valid(state) {
                return;
            }
        }
    }

    /// Draws the next state of a sequence that fills the box evenly.
    #[inline(always)]
    pub fn sample_evenly(&mut self, state: &mut [f64]) {
        self.even.next(state);
        let ends = self.problem.lower.iter().zip(&self.problem.upper);
        for (x, (&lower, &upper)) in state.iter_mut().zip(ends) {
            *x = lower + (upper - lower) * *x;
        }
    }

    /// The goal with probability `bias`, else a state from the whole box.
    pub fn sample_or_goal(&mut self, bias: f64, state: &mut [f64]) {
        if self.random.unit() < bias {
            state.copy_from_slice(&self.problem.goal);
        } else {
            self.sample_evenly(state);
        }
    }
}

/// The additive recurrence of Roberts: `x_k = frac(x_0 + k a)`, where
/// `a_j = g^-j` and `g > 1` solves `g^(d+1) = g + 1`, the golden ratio's
/// generalisation to `d` coordinates. A random `x_0` makes seeds differ.
///
/// Whole numbers of 2^-64 keep it exact.
struct Even {
    at: Vec<u64>,
    step: Vec<u64>,
}

impl Even {
    fn new(dimension: usize, seed: u64) -> Self {
        let mut random = RandomStream::new(seed, 1);
        // Newton's method from above, where it cannot overshoot.
        let mut golden = 2.0_f64;
        for _ in 0..12 {
            let power = golden.powi(dimension as i32);
            let slope = (dimension as f64 + 1.0) * power - 1.0;
            golden -= (power * golden - golden - 1.0) / slope;
        }
        const TWO_TO_64: f64 = 18_446_744_073_709_551_616.0;
        let step = |axis: usize| (golden.powi(-(axis as i32) - 1) * TWO_TO_64) as u64;
        let at = (0..dimension).map(|_| (random.unit() * TWO_TO_64) as u64).collect();
        Self { at, step: (0..dimension).map(step).collect() }
    }

    /// The next point of the unit cube.
    #[inline(always)]
    fn next(&mut self, point: &mut [f64]) {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        for ((x, at), step) in point.iter_mut().zip(&mut self.at).zip(&self.step) {
            *at = at.wrapping_add(*step);
            *x = (*at >> 11) as f64 * SCALE;
        }
    }
}
