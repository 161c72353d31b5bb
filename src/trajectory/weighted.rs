//! The timing problem with a weighted objective: time, jerk and energy.

use super::objective::{Measures, Weighting};
use super::timing::{TimingCandidate, TimingProblem};
use crate::optimize::{Bounds, Candidate, Objective};

/// Search for segment durations of the least weighted sum of time, jerk and
/// energy within limits.
///
/// As with time alone, a candidate is a direction: its best lawful multiple is
/// known in closed form, and that is what it is rated by.
pub struct WeightedProblem<'a> {
    timing: &'a TimingProblem,
    weighting: Weighting,
    /// Least and greatest total duration, s.
    total: [f64; 2],
    starts: Vec<Vec<f64>>,
}

impl<'a> WeightedProblem<'a> {
    /// Poses the problem over the curves, limits and range of `timing`, whose
    /// handling of broken limits plays no part. The motion lasts between
    /// `total[0]` and `total[1]`, s; `starts` are durations worth starting from.
    pub fn new(
        timing: &'a TimingProblem,
        weighting: Weighting,
        total: [f64; 2],
        starts: Vec<Vec<f64>>,
    ) -> Self {
        Self { timing, weighting, total, starts }
    }

    /// The durations a candidate stands for: its best lawful multiple.
    pub fn decode(&self, position: &[f64]) -> Vec<f64> {
        let (_, scale, _) = WeightedCandidate::new(self).rate(position);
        position.iter().map(|t| t * scale).collect()
    }
}

impl Objective for WeightedProblem<'_> {
    fn bounds(&self) -> &Bounds {
        self.timing.bounds()
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        Box::new(WeightedCandidate::new(self))
    }

    fn evaluation_ns(&self) -> f64 {
        1.3 * self.timing.evaluation_ns()
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        self.starts.iter().cloned().chain(self.timing.starts()).collect()
    }

    fn is_constrained(&self) -> bool {
        true
    }
}

/// What a candidate that no multiple mends costs, relative to the reference.
const BROKEN: f64 = 1e3;

struct WeightedCandidate<'a> {
    problem: &'a WeightedProblem<'a>,
    timing: TimingCandidate<'a>,
}

impl<'a> WeightedCandidate<'a> {
    fn new(problem: &'a WeightedProblem<'a>) -> Self {
        Self { problem, timing: TimingCandidate::new(problem.timing) }
    }

    /// Measures of a direction, its best multiple, and what no multiple can
    /// mend, positive if broken.
    fn rate(&mut self, position: &[f64]) -> (Measures, f64, f64) {
        let [least, most] = self.problem.total;
        let scale = self.timing.scale(position);
        let measures = self.timing.measures(position);
        let lowest = scale.max(least / measures.time);
        let highest = self.timing.highest_scale(position).min(most / measures.time);
        let scale = self.problem.weighting.best_scale(&measures, lowest, highest);
        let late = scale * measures.time / most - 1.0 - 1e-12;
        (measures, scale, self.timing.violation(position, scale).max(late))
    }
}

impl Candidate for WeightedCandidate<'_> {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        let (measures, scale, violation) = self.rate(position);
        let weighting = &self.problem.weighting;
        // A broken candidate may well be gentle: it must not look like a plan,
        // but how far it is from one still tells where to search.
        let fitness = if violation > 0.0 {
            BROKEN * weighting.weight() * (1.0 + violation)
        } else {
            weighting.value(&measures.scaled(scale))
        };
        if fitness.is_nan() { f64::INFINITY } else { fitness }
    }

    fn repair(&mut self, position: &mut [f64]) {
        self.timing.repair(position);
    }

    fn scale(&mut self, position: &[f64]) -> f64 {
        self.rate(position).1
    }

    fn constrained(&mut self, position: &[f64], constraints: &mut Vec<f64>) -> f64 {
        let [least, most] = self.problem.total;
        self.timing.constraints(position, constraints);
        let measures = self.timing.measures(position);
        if most < f64::INFINITY {
            constraints.push(measures.time / most);
        }
        // A duration that is given leaves nothing to weigh about time.
        let weighting = self.problem.weighting;
        let weighting = if least < most { weighting } else { weighting.without_time() };
        weighting.value(&measures)
    }
}
