//! The timing problem with several objectives at once.

use super::objective::{Measures, ObjectiveName};
use super::timing::{TimingCandidate, TimingProblem};
use crate::optimize::Bounds;
use crate::optimize::nsga2::MultiObjective;

/// Search for motions between fast and gentle.
///
/// Variables are the logarithms of the durations' proportions and, last, by how
/// much the motion is slower than these proportions allow at best: so every
/// candidate keeps the derivative limits.
pub struct FrontProblem<'a> {
    timing: &'a TimingProblem,
    candidate: TimingCandidate<'a>,
    objectives: &'a [ObjectiveName],
    /// Longest motion, s.
    longest: f64,
    bounds: Bounds,
    durations: Vec<f64>,
}

impl<'a> FrontProblem<'a> {
    /// Poses the problem over the curves, limits and range of `timing`, for
    /// motions that last at most `longest`, s, and stretch their proportions by
    /// at most `stretch`.
    pub fn new(
        timing: &'a TimingProblem,
        objectives: &'a [ObjectiveName],
        longest: f64,
        stretch: f64,
    ) -> Self {
        use crate::optimize::Objective;
        let logs = |bounds: &[f64], last: f64| -> Vec<f64> {
            bounds.iter().map(|x| libm::log(*x)).chain([last]).collect()
        };
        let Bounds { lower, upper } = timing.bounds();
        let bounds = Bounds { lower: logs(lower, 1.0), upper: logs(upper, stretch) };
        let candidate = TimingCandidate::new(timing);
        Self { timing, candidate, objectives, longest, bounds, durations: Vec::new() }
    }

    /// The position of `durations` at their smallest lawful multiple.
    pub fn encode(&self, durations: &[f64]) -> Vec<f64> {
        durations.iter().map(|t| libm::log(*t)).chain([1.0]).collect()
    }

    /// The durations a candidate stands for.
    pub fn decode(&self, position: &[f64]) -> Vec<f64> {
        let (proportions, stretch) = position.split_at(position.len() - 1);
        let durations: Vec<f64> = proportions.iter().map(|y| libm::exp(*y)).collect();
        let scale = self.timing.scale(&durations) * stretch[0];
        durations.iter().map(|t| t * scale).collect()
    }
}

impl MultiObjective for FrontProblem<'_> {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn objectives(&self) -> usize {
        self.objectives.len()
    }

    fn evaluate(&mut self, position: &[f64], values: &mut [f64]) -> f64 {
        let (proportions, stretch) = position.split_at(position.len() - 1);
        self.durations.clear();
        self.durations.extend(proportions.iter().map(|y| libm::exp(*y)));
        let scale = self.candidate.scale(&self.durations) * stretch[0];
        let measures: Measures = self.candidate.measures(&self.durations).scaled(scale);
        for (value, name) in values.iter_mut().zip(self.objectives) {
            *value = name.of(&measures);
        }
        let late = measures.time / self.longest - 1.0 - 1e-9;
        self.candidate.violation(&self.durations, scale).max(late)
    }
}
