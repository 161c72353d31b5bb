//! Methods compared: what is asked for and what comes out.

use super::{MessageForm, Place};
use crate::fault::Faults;
use crate::grpc::proto;
use crate::plan::{
    BenchmarkTask, BestRun, ComparedProblem, ComparisonResult, ComparisonTask, CurvePoint,
    EvaluationQuartiles, KnownOptimum, MethodChoice, MethodResult, ProblemResult,
};

message_form!(ComparedProblem { name, robot, limits, limit_scale, task: Required });

message_form!(MethodChoice { name, label, parameters });

message_form!(ComparisonResult {
    task,
    runs,
    max_evaluations,
    success_tolerance,
    test,
    verdict,
    problems,
    evaluations,
    planning_s,
    seed,
    version,
});

message_form!(ProblemResult {
    name,
    title,
    robot,
    unit,
    dimension,
    optimum,
    lower_bound,
    best_known,
    best_method,
    best_run,
    methods,
});

message_form!(KnownOptimum { value, position, source });

message_form!(BestRun { method, run, value, position });

message_form!(MethodResult {
    label,
    optimizer,
    parameters,
    runs,
    feasible_runs,
    best,
    mean,
    worst,
    standard_deviation,
    lower_quartile,
    median,
    upper_quartile,
    median_gap,
    success_rate,
    evaluations_to_success,
    p_value,
    evaluations,
    seconds_per_evaluation,
    curve,
});

message_form!(EvaluationQuartiles { lower_quartile, median, upper_quartile });

message_form!(CurvePoint { evaluations, lower_quartile, median, upper_quartile });

impl MessageForm<proto::ComparisonTask> for ComparisonTask {
    fn into_message(self) -> proto::ComparisonTask {
        let Self { task, problems, methods, runs, max_evaluations, success_tolerance } = self;
        proto::ComparisonTask {
            task: task.into_message(),
            problems: problems.into_message(),
            methods: methods.into_message(),
            runs: Some(runs),
            max_evaluations: Some(max_evaluations),
            success_tolerance: Some(success_tolerance),
        }
    }

    fn from_message(message: proto::ComparisonTask, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::ComparisonTask {
            task,
            problems,
            methods,
            runs,
            max_evaluations,
            success_tolerance,
        } = message;
        let tolerance = success_tolerance.unwrap_or(Self::DEFAULT_TOLERANCE);
        let at = place.field("success_tolerance");
        Self {
            task: MessageForm::from_message(task, place.field("task"), faults),
            problems: MessageForm::from_message(problems, place.field("problems"), faults),
            methods: MessageForm::from_message(methods, place.field("methods"), faults),
            runs: runs.unwrap_or(Self::DEFAULT_RUNS),
            max_evaluations: max_evaluations.unwrap_or(Self::DEFAULT_EVALUATIONS),
            success_tolerance: f64::from_message(tolerance, at, faults),
        }
    }
}

impl MessageForm<proto::BenchmarkTask> for BenchmarkTask {
    fn into_message(self) -> proto::BenchmarkTask {
        let Self { functions, dimension, population, iterations, runs, optimizers, shifted } = self;
        proto::BenchmarkTask {
            functions,
            dimension: Some(dimension),
            population: Some(population),
            iterations: Some(iterations),
            runs: Some(runs),
            optimizers: optimizers.into_message(),
            shifted,
        }
    }

    fn from_message(message: proto::BenchmarkTask, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::BenchmarkTask {
            functions,
            dimension,
            population,
            iterations,
            runs,
            optimizers,
            shifted,
        } = message;
        let default = Self::default();
        Self {
            functions,
            dimension: dimension.unwrap_or(default.dimension),
            population: population.unwrap_or(default.population),
            iterations: iterations.unwrap_or(default.iterations),
            runs: runs.unwrap_or(default.runs),
            optimizers: MessageForm::from_message(optimizers, place.field("optimizers"), faults),
            shifted,
        }
    }
}
