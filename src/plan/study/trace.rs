//! What is kept of a run: its best value at fixed evaluation counts and when
//! it came near the optimum. The size does not depend on the run's length.

use crate::optimize::ConvergencePoint;

/// Most evaluation counts at which curves are recorded.
const GRID: u64 = 64;

/// Most steps kept of a run's way below the bar.
const STEPS: usize = 128;

/// The evaluation counts at which all methods' curves are recorded, denser at
/// the start, where most happens; the last is `max_evaluations`.
pub fn grid(max_evaluations: u64) -> Vec<u64> {
    let count = |i: u64| {
        let share = i as f64 / GRID as f64;
        (max_evaluations as f64 * share * share).ceil() as u64
    };
    let mut counts: Vec<u64> = (1..=GRID).map(|i| count(i).clamp(1, max_evaluations)).collect();
    counts.dedup();
    counts
}

/// The trace of one run.
#[derive(Debug)]
pub struct Trace<'a> {
    grid: &'a [u64],
    /// Best so far at the counts passed already.
    values: Vec<f64>,
    best: f64,
    /// Values above it are no success whatever is found later.
    bar: f64,
    /// Values above it are penalties: nothing was found yet.
    highest: f64,
    /// Evaluations and value of each improvement below the bar.
    steps: Vec<(u64, f64)>,
}

impl<'a> Trace<'a> {
    /// A trace of values up to `highest` that minds the steps up to `bar`.
    pub fn new(grid: &'a [u64], bar: f64, highest: f64) -> Self {
        let values = Vec::with_capacity(grid.len());
        Self { grid, values, best: f64::INFINITY, bar, highest, steps: Vec::new() }
    }

    /// Takes a generation in. At a count within a generation the best is that
    /// of the generation before: no evaluation counts before it is finished.
    pub fn push(&mut self, point: &ConvergencePoint) {
        let due = self.grid.partition_point(|&count| count < point.evaluations);
        self.fill(due);
        let best = point.best.filter(|best| *best <= self.highest).unwrap_or(f64::INFINITY);
        if best >= self.best {
            return;
        }
        self.best = best;
        if best <= self.bar {
            if self.steps.len() == STEPS {
                // Every second step goes: a threshold between two that are kept
                // counts as reached at the later.
                let mut index = 0;
                self.steps.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
            }
            self.steps.push((point.evaluations, best));
        }
    }

    fn fill(&mut self, due: usize) {
        while self.values.len() < due {
            self.values.push(self.best);
        }
    }

    /// The best value at every count of the grid, and the steps.
    pub fn finish(mut self) -> (Vec<f64>, Vec<(u64, f64)>) {
        self.fill(self.grid.len());
        (self.values, self.steps)
    }
}

/// After how many evaluations a run's steps first reach `threshold`.
pub fn reached(steps: &[(u64, f64)], threshold: f64) -> Option<u64> {
    steps.iter().find(|(_, value)| *value <= threshold).map(|(evaluations, _)| *evaluations)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(evaluations: u64, best: f64) -> ConvergencePoint {
        let best = Some(best).filter(|best| best.is_finite());
        ConvergencePoint { iteration: evaluations, evaluations, elapsed_s: 0.0, best, mean: None }
    }

    #[test]
    fn the_grid_ascends_to_the_last_evaluation() {
        for most in [1, 2, 10, 63, 64, 5000, 30_030, 1_000_000_000] {
            let grid = grid(most);
            assert!(grid.len() <= 64 && grid.windows(2).all(|pair| pair[0] < pair[1]));
            assert_eq!((grid.first() >= Some(&1), grid.last()), (true, Some(&most)));
        }
    }

    #[test]
    fn a_value_counts_once_its_generation_is_finished() {
        let grid = [5, 10, 15, 20, 40];
        let mut trace = Trace::new(&grid, 2.0, 2.9);
        for (evaluations, best) in [(10, 3.0), (20, 2.0), (30, 1.5)] {
            trace.push(&point(evaluations, best));
        }
        let (values, steps) = trace.finish();
        // 3.0 is a penalty.
        let none = f64::INFINITY;
        assert_eq!(values, [none, none, none, 2.0, 1.5]);
        assert_eq!(steps, [(20, 2.0), (30, 1.5)]);
        assert_eq!(reached(&steps, 1.9), Some(30));
        assert_eq!(reached(&steps, 1.0), None);
    }

    #[test]
    fn a_long_way_down_stays_small_and_never_claims_too_early() {
        let mut trace = Trace::new(&[], f64::INFINITY, f64::INFINITY);
        for step in 1..10_000u64 {
            trace.push(&point(step, 1.0 / step as f64));
        }
        let (_, steps) = trace.finish();
        assert!(steps.len() <= STEPS);
        assert_eq!(steps.last(), Some(&(9999, 1.0 / 9999.0)));
        let reached = reached(&steps, 1.0 / 5000.0).unwrap();
        assert!(reached >= 5000);
    }
}
