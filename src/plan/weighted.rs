//! The motion of the least weighted sum of time, jerk and energy.

use super::error::PlanError;
use super::request::DurationGoal;
use super::waypoints::{Run, no_candidate};
use crate::budget::Budget;
use crate::optimize::{ConvergencePoint, EXACT, Objective, Settings, Solution, minimize};
use crate::trajectory::objective::Weighting;
use crate::trajectory::timing::TimingProblem;
use crate::trajectory::weighted::WeightedProblem;

/// What a weighted search comes to.
pub(super) struct Found {
    /// Durations of the weighted optimum, s.
    pub durations: Vec<f64>,
    /// How they were found.
    pub solution: Solution,
    /// Those of the fastest motion.
    pub fastest: Vec<f64>,
}

impl Run<'_> {
    /// The fastest motion first, to which weights are relative and which tells
    /// whether the wanted duration can be reached; then the weighted optimum.
    pub(super) fn weighted(
        &self,
        problem: &TimingProblem,
        budget: &Budget,
    ) -> Result<Found, PlanError> {
        let settings = if self.task.optimizer.name == "exact" {
            self.task.settings.clone()
        } else {
            EXACT.defaults()
        };
        // Of limited evaluations half are for what is asked.
        let limit = budget.evaluations_left(0);
        let half = budget.clone().with_max_evaluations(Some(limit.div_ceil(2)));
        let first = self.exactly(problem, &settings, &half);
        let Some(position) = &first.position else { return Err(no_candidate(&first)) };
        let fastest = problem.decode(position);
        let weighting = Weighting::new(&self.task.weights.measures(), &problem.measures(&fastest));
        let total = self.total();
        let left = budget.evaluations_left(first.evaluations);
        if left == 0 || fastest.iter().sum::<f64>() > total[1] {
            let solution = rated(first, weighting.weight());
            return Ok(Found { durations: fastest.clone(), solution, fastest });
        }
        let budget = budget.clone().with_max_evaluations(Some(left));
        let weighted = WeightedProblem::new(problem, weighting, total, vec![fastest.clone()]);
        let before = (0, first.evaluations);
        let (position, mut solution) = self.minimize(&weighted, self.seed, &budget, before)?;
        solution.evaluations += first.evaluations;
        for point in &mut solution.convergence {
            point.evaluations += first.evaluations;
        }
        Ok(Found { durations: weighted.decode(&position), solution, fastest })
    }

    /// Searches with the exact method, without reporting progress.
    pub(super) fn exactly(
        &self,
        problem: &dyn Objective,
        settings: &Settings,
        budget: &Budget,
    ) -> Solution {
        let mut optimizer = (EXACT.build)(settings, problem, self.seed);
        let iterations = settings.integer("iterations");
        minimize(problem, optimizer.as_mut(), iterations, budget, &mut |_| {})
    }

    /// Least and greatest total duration wanted, s.
    pub(super) fn total(&self) -> [f64; 2] {
        match self.task.goal {
            None => [0.0, f64::INFINITY],
            Some(DurationGoal::AtMost(longest)) => [0.0, longest],
            Some(DurationGoal::Exactly(duration)) => [duration; 2],
        }
    }
}

/// The search for the fastest motion as one that found nothing better.
fn rated(first: Solution, fitness: f64) -> Solution {
    let last = first.convergence.last().copied();
    let convergence = last.map(|point| ConvergencePoint { best: Some(fitness), ..point });
    Solution { fitness, convergence: convergence.into_iter().collect(), ..first }
}
