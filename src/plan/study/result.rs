//! What a user gets when comparing methods.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Methods compared, problem by problem: the result of a `comparison` or a
/// `benchmark`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparisonResult {
    /// `comparison` or `benchmark`.
    pub task: String,
    /// Runs of each method on each problem; deterministic methods ran once.
    pub runs: u32,
    /// Evaluations each run could use.
    pub max_evaluations: u64,
    /// How near the best known value a run has to come to succeed: a share of
    /// it, or the distance itself where it is zero.
    pub success_tolerance: f64,
    /// The test behind every `p_value`.
    pub test: String,
    /// In words: which method did best, and by how much.
    pub verdict: String,
    /// A result per problem or function.
    pub problems: Vec<ProblemResult>,
    /// Candidates evaluated, by all methods and for the exact optima.
    pub evaluations: u64,
    /// Planning time, s. With `seconds_per_evaluation` the only field that may
    /// differ between equal requests.
    pub planning_s: f64,
    /// The request's seed.
    pub seed: u64,
    /// Version of Takt that planned it.
    pub version: String,
}

/// One problem, and how the methods did on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProblemResult {
    /// The problem's name, or the function's.
    pub name: String,
    /// What it is, in words.
    pub title: String,
    /// The robot's name; null for a function.
    pub robot: Option<String>,
    /// Unit of every value: `s`, or empty for a function.
    pub unit: String,
    /// Number of variables.
    pub dimension: usize,
    /// The optimum to compare with: the family's exact one, or the function's
    /// known one; null if there is none within the problem's search range.
    pub optimum: Option<KnownOptimum>,
    /// No lawful trajectory through the waypoints is shorter, s; null for a function.
    pub lower_bound: Option<f64>,
    /// The least of the optimum and all runs, or a function's known optimum;
    /// successes and gaps refer to it.
    pub best_known: Option<f64>,
    /// The method with the least median among those with seeds, or else among all.
    pub best_method: Option<String>,
    /// The best run of all.
    pub best_run: Option<BestRun>,
    /// A row per method, in the request's order.
    pub methods: Vec<MethodResult>,
}

/// An optimum that is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KnownOptimum {
    /// Its value.
    pub value: f64,
    /// Where it is: durations of the segments, s, or a function's variables.
    pub position: Vec<f64>,
    /// Where it comes from.
    pub source: String,
}

/// The best run of all methods on a problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BestRun {
    /// The method's label.
    pub method: String,
    /// Number of the run, from 0.
    pub run: u32,
    /// What it found.
    pub value: f64,
    /// Durations of the segments, s, or a function's variables.
    pub position: Vec<f64>,
}

/// How one method did on one problem. Statistics are over the runs that found
/// anything feasible and null if none did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MethodResult {
    /// The method's label.
    pub label: String,
    /// Optimizer by registry name.
    pub optimizer: String,
    /// The parameters it ran with, given and defaults.
    pub parameters: BTreeMap<String, f64>,
    /// Runs made.
    pub runs: u32,
    /// Runs that found anything feasible.
    pub feasible_runs: u32,
    /// Least value.
    pub best: Option<f64>,
    /// Mean value.
    pub mean: Option<f64>,
    /// Largest value.
    pub worst: Option<f64>,
    /// Sample standard deviation; null below two runs.
    pub standard_deviation: Option<f64>,
    /// A quarter of the values is below.
    pub lower_quartile: Option<f64>,
    /// Half of the values is below.
    pub median: Option<f64>,
    /// Three quarters of the values are below.
    pub upper_quartile: Option<f64>,
    /// How far the median is above the best known value: a share of it, or the
    /// distance itself where it is zero.
    pub median_gap: Option<f64>,
    /// Share of the runs that came within `success_tolerance` of the best known value.
    pub success_rate: f64,
    /// Evaluations the successful runs needed for that; null if none succeeded.
    pub evaluations_to_success: Option<EvaluationQuartiles>,
    /// How likely so large a difference from the problem's best method is if
    /// there is none; null for that method itself and for deterministic methods.
    pub p_value: Option<f64>,
    /// Candidates evaluated over all runs.
    pub evaluations: u64,
    /// Mean time of an evaluation with all that the method does about it, s.
    pub seconds_per_evaluation: f64,
    /// How the best value so far fell, at the same evaluation counts for all methods.
    pub curve: Vec<CurvePoint>,
}

/// Quartiles of a number of evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EvaluationQuartiles {
    /// A quarter of the runs needed fewer.
    pub lower_quartile: f64,
    /// Half of the runs needed fewer.
    pub median: f64,
    /// Three quarters of the runs needed fewer.
    pub upper_quartile: f64,
}

/// The best value so far after a number of evaluations, over all runs; null
/// where too many runs had found nothing feasible yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CurvePoint {
    /// Evaluations of each run so far.
    pub evaluations: u64,
    /// A quarter of the runs was better.
    pub lower_quartile: Option<f64>,
    /// Half of the runs was better.
    pub median: Option<f64>,
    /// Three quarters of the runs were better.
    pub upper_quartile: Option<f64>,
}
