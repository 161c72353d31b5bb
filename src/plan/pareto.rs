//! The front of motions between fast and gentle.
//!
//! Stretching one motion trades time for jerk along `J T³ = const` (energy:
//! `E T⁴`). Other proportions do better: the front lies below the curve of the
//! stretched fastest motion and follows such a curve of its own as soon as the
//! gentlest proportions are within the limits.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::objectives::{ParetoMethod, ParetoRequest};
use super::prepared::Progress;
use super::waypoints::Run;
use crate::budget::{Budget, StopReason};
use crate::optimize::Solution;
use crate::optimize::front::keep_non_dominated;
use crate::optimize::nsga2::{Nsga2, nsga2};
use crate::trajectory::Certificate;
use crate::trajectory::front::FrontProblem;
use crate::trajectory::objective::{Measures, ObjectiveName, Weighting};
use crate::trajectory::timing::TimingProblem;
use crate::trajectory::weighted::WeightedProblem;

/// Motions of which none is better in one objective without being worse in
/// another, by time. Curves are determined by their durations: a request like
/// this one with a point's durations as `fixed_durations`, and without
/// `objective`, `duration`, `durations` and `pareto`, plans exactly its motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ParetoFront {
    /// What the values are.
    pub objectives: Vec<ParetoAxis>,
    /// How it was found.
    pub method: ParetoMethod,
    /// Its points, the fastest first.
    pub points: Vec<ParetoPoint>,
}

/// One objective of a front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ParetoAxis {
    /// Which.
    pub name: ObjectiveName,
    /// Unit of its values; `(rad, m)` where joints of both kinds add up.
    pub unit: String,
}

/// One motion of a front, certified like a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ParetoPoint {
    /// One per objective.
    pub values: Vec<f64>,
    /// Duration of each segment, s.
    pub durations: Vec<f64>,
    /// Largest ratio of a peak to its limit.
    pub worst_ratio: f64,
}

/// Starting points of the search for one point, its neighbour among them.
const SEARCHES: f64 = 3.0;

/// The front that `request` asks for, `fastest` being the fastest motion's
/// durations. What it takes is added to `solution`, the search for the plan.
///
/// A run that has to end leaves the points found so far.
pub(super) fn front(
    run: &Run<'_>,
    problem: &TimingProblem,
    request: &ParetoRequest,
    fastest: &[f64],
    budget: &Budget,
    solution: &mut Solution,
) -> ParetoFront {
    let search = Search { run, problem, request, budget, fastest };
    let mut points = match request.method {
        ParetoMethod::EpsilonConstraint => search.by_time(solution),
        ParetoMethod::Nsga2 => search.by_nsga2(solution),
    };
    keep_non_dominated(&mut points, |point| &point.values);
    points.sort_by(|a, b| a.duration().total_cmp(&b.duration()));
    let units: Vec<String> = run.limits.iter().map(|limit| limit.unit.to_owned()).collect();
    let axis = |name: &ObjectiveName| ParetoAxis { name: *name, unit: name.unit(&units) };
    let objectives = request.objectives.iter().map(axis).collect();
    ParetoFront { objectives, method: request.method, points }
}

struct Search<'a> {
    run: &'a Run<'a>,
    problem: &'a TimingProblem,
    request: &'a ParetoRequest,
    budget: &'a Budget,
    fastest: &'a [f64],
}

impl Search<'_> {
    /// The durations of the fastest and of the longest motion considered, s.
    fn ends(&self) -> [f64; 2] {
        let shortest: f64 = self.fastest.iter().sum();
        let longest = shortest * self.request.max_stretch();
        [shortest, longest.min(self.run.total()[1]).max(shortest)]
    }

    /// Least jerk, or energy, for each of a list of durations (epsilon
    /// constraint on time). The durations lie closer near the fastest one, where
    /// the front is steep; each search also starts from its neighbour.
    fn by_time(&self, solution: &mut Solution) -> Vec<ParetoPoint> {
        let [shortest, longest] = self.ends();
        let asks = |name| f64::from(u8::from(self.request.objectives.contains(&name)));
        let weights = Measures {
            time: 0.0,
            rms_jerk: asks(ObjectiveName::RmsJerk),
            energy: asks(ObjectiveName::Energy),
        };
        let weighting = Weighting::new(&weights, &self.problem.measures(self.fastest));
        let settings = self.run.task.settings.clone().with("iterations", SEARCHES);
        let mut points = Vec::from_iter(self.point(self.fastest.to_vec()));
        let mut neighbour = self.fastest.to_vec();
        let steps = self.request.points() - 1;
        for step in 1..=steps {
            if let Some(reason) = self.budget.stop_reason(solution.evaluations) {
                solution.stop_reason = reason;
                break;
            }
            let share = step as f64 / steps as f64;
            let time = shortest + (longest - shortest) * share * share;
            let starts = vec![neighbour.clone(), self.fastest.to_vec()];
            let weighted = WeightedProblem::new(self.problem, weighting, [time; 2], starts);
            let budget = self.rest(solution);
            let found = self.run.exactly(&weighted, &settings, &budget);
            solution.evaluations += found.evaluations;
            if let Some(position) = found.position {
                neighbour = weighted.decode(&position);
                points.extend(self.point(neighbour.clone()));
            }
            self.report(step as u64, solution);
        }
        points
    }

    fn by_nsga2(&self, solution: &mut Solution) -> Vec<ParetoPoint> {
        let [shortest, longest] = self.ends();
        let names = &self.request.objectives;
        let mut problem = FrontProblem::new(self.problem, names, longest, longest / shortest);
        let settings = Nsga2 {
            population: self.request.population(),
            generations: self.request.generations(),
            points: self.request.points(),
            seed: self.run.seed,
        };
        let starts = [self.fastest, self.problem.natural()].map(|start| problem.encode(start));
        let mut report = |generation, evaluations| {
            let evaluations = solution.evaluations + evaluations;
            self.report(generation + 1, &Solution { evaluations, ..solution.clone() });
        };
        let budget = self.rest(solution);
        let found = nsga2(&mut problem, &settings, &starts, &budget, &mut report);
        solution.evaluations += found.evaluations;
        if found.stop_reason != StopReason::IterationLimit {
            solution.stop_reason = found.stop_reason;
        }
        let positions = found.members.iter().map(|(position, _)| position);
        positions.filter_map(|position| self.point(problem.decode(position))).collect()
    }

    /// The budget with what is left of its evaluations.
    fn rest(&self, solution: &Solution) -> Budget {
        let left = self.budget.evaluations_left(solution.evaluations);
        self.budget.clone().with_max_evaluations(Some(left))
    }

    /// A motion of the front, certified; none if it breaks a limit that the
    /// plan itself would have to keep, or if nobody waits for it any more.
    fn point(&self, durations: Vec<f64>) -> Option<ParetoPoint> {
        if self.run.budget.stop_reason(0).is_some() {
            return None;
        }
        let (durations, trajectory) = self.run.lawful(self.problem, durations);
        trajectory.validate(self.run.limits.len()).ok()?;
        let certificate = Certificate::new(&trajectory, self.run.limits, &[]);
        if self.run.violation(&certificate).is_some() || self.run.check_range(&durations).is_err() {
            return None;
        }
        let measures = Measures::of_trajectory(&trajectory);
        let values = self.request.objectives.iter().map(|name| name.of(&measures)).collect();
        Some(ParetoPoint { values, durations, worst_ratio: certificate.worst_ratio })
    }

    fn report(&self, step: u64, solution: &Solution) {
        (self.run.progress)(Progress {
            iteration: solution.iterations + step,
            evaluations: solution.evaluations,
            elapsed_s: self.budget.elapsed_s(),
            best: Some(solution.fitness),
            ..Progress::default()
        });
    }
}

impl ParetoPoint {
    fn duration(&self) -> f64 {
        self.durations.iter().sum()
    }
}
