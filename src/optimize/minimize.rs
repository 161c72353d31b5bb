//! The one loop around every optimizer.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Evaluator, Objective, Optimizer};
use crate::budget::{Budget, StopReason};

/// The state of a search after one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ConvergencePoint {
    /// Iterations done; 0 is the initial population.
    pub iteration: u64,
    /// Candidates evaluated so far.
    pub evaluations: u64,
    /// Seconds since the start.
    pub elapsed_s: f64,
    /// Best fitness so far; null while no candidate was feasible.
    pub best: Option<f64>,
    /// Mean fitness of the current generation's feasible candidates; null if there is none.
    pub mean: Option<f64>,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The best candidate; none if no candidate was feasible.
    pub position: Option<Vec<f64>>,
    /// Its fitness; infinite if there is none.
    pub fitness: f64,
    /// How it was reached, thinned to at most [`History::CAPACITY`] points.
    pub convergence: Vec<ConvergencePoint>,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// Iterations done.
    pub iterations: u64,
    /// Candidates evaluated.
    pub evaluations: u64,
}

/// Runs `optimizer` for at most `iterations` generations after the initial one.
///
/// `progress` sees every generation. Memory does not grow with `iterations`.
pub fn minimize(
    objective: &dyn Objective,
    optimizer: &mut dyn Optimizer,
    iterations: u64,
    budget: &Budget,
    progress: &mut dyn FnMut(&ConvergencePoint),
) -> Solution {
    let mut evaluator = Evaluator::new(objective, budget);
    let mut history = History::default();
    let mut iteration = 0;
    let stop_reason = loop {
        let step = optimizer.step(&mut evaluator);
        let point = ConvergencePoint {
            iteration,
            evaluations: evaluator.evaluations(),
            elapsed_s: budget.elapsed_s(),
            best: Some(evaluator.best()).filter(|best| best.is_finite()),
            mean: step.mean,
        };
        history.push(point);
        progress(&point);
        if let Some(reason) = evaluator.stop_reason() {
            break reason;
        }
        if step.converged {
            break StopReason::Converged;
        }
        if iteration == iterations {
            break StopReason::IterationLimit;
        }
        iteration += 1;
    };
    let position = evaluator.best().is_finite().then(|| evaluator.best_position().to_vec());
    Solution {
        position,
        fitness: evaluator.best(),
        convergence: history.into_points(),
        stop_reason,
        iterations: iteration,
        evaluations: evaluator.evaluations(),
    }
}

/// A convergence curve of bounded size: when full, every second point goes and
/// from then on only every second one is kept.
#[derive(Debug)]
pub struct History {
    points: Vec<ConvergencePoint>,
    stride: u64,
    last: Option<ConvergencePoint>,
}

impl Default for History {
    fn default() -> Self {
        Self { points: Vec::new(), stride: 1, last: None }
    }
}

impl History {
    /// Most points kept.
    pub const CAPACITY: usize = 512;

    fn push(&mut self, point: ConvergencePoint) {
        self.last = Some(point);
        if !point.iteration.is_multiple_of(self.stride) {
            return;
        }
        if self.points.len() == Self::CAPACITY - 1 {
            self.stride *= 2;
            self.points.retain(|kept| kept.iteration.is_multiple_of(self.stride));
            if !point.iteration.is_multiple_of(self.stride) {
                return;
            }
        }
        self.points.push(point);
    }

    /// The kept points and, always, the last one.
    fn into_points(mut self) -> Vec<ConvergencePoint> {
        let ends_with_last = self.points.last() == self.last.as_ref();
        self.points.extend(self.last.filter(|_| !ends_with_last));
        self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_history_stays_short_and_keeps_its_ends() {
        let mut history = History::default();
        for iteration in 0..=100_001 {
            let point = ConvergencePoint {
                iteration,
                evaluations: iteration,
                elapsed_s: 0.0,
                best: None,
                mean: None,
            };
            history.push(point);
        }
        let points = history.into_points();
        assert!(points.len() <= History::CAPACITY && points.len() > History::CAPACITY / 4);
        assert_eq!(points.first().map(|point| point.iteration), Some(0));
        assert_eq!(points.last().map(|point| point.iteration), Some(100_001));
        assert!(points.windows(2).all(|pair| pair[0].iteration < pair[1].iteration));
    }
}
