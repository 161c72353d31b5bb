//! Checks what a comparison or a benchmark means.

use std::collections::HashSet;

use super::request::{
    BenchmarkTask, ComparedProblem, ComparisonTask, MAX_DIMENSION, MAX_METHODS, MAX_PROBLEMS,
    MAX_RUNS, MethodChoice,
};
use crate::fault::{Faults, escape};
use crate::optimize::functions::{FUNCTIONS, Function, function, function_names};
use crate::optimize::{OPTIMIZERS, OptimizerEntry, Settings, optimizer, optimizer_names};
use crate::plan::limits;
use crate::plan::prepare::{Check, Common, check_name, check_population, resolve_robot};
use crate::plan::prepared::PreparedWaypoints;
use crate::plan::request::{Clock, Constraints, LimitOverrides, OptimizerChoice, WaypointsTask};
use crate::trajectory::JointBounds;

/// Most evaluations of one run.
const MAX_RUN_EVALUATIONS: u64 = 1_000_000_000;

/// Most evaluations of all runs together: days of one core.
const MAX_EVALUATIONS: f64 = 1e11;

/// A valid comparison or benchmark, ready to run.
pub(in crate::plan) struct PreparedStudy {
    pub task: &'static str,
    pub problems: Vec<StudyProblem>,
    pub methods: Vec<StudyMethod>,
    pub runs: u32,
    pub max_evaluations: u64,
    pub tolerance: f64,
}

/// What methods are compared on.
pub(in crate::plan) enum StudyProblem {
    /// Timing of a motion.
    Timing(Box<TimingStudy>),
    /// A function with a known optimum.
    Function { function: &'static Function, dimension: usize, shifted: bool },
}

/// A `waypoints` task within its robot's limits.
pub(in crate::plan) struct TimingStudy {
    pub name: String,
    pub robot: String,
    pub limits: Vec<JointBounds>,
    pub task: PreparedWaypoints,
}

/// One method.
pub(in crate::plan) struct StudyMethod {
    pub label: String,
    pub optimizer: &'static OptimizerEntry,
    pub settings: Settings,
}

impl StudyMethod {
    /// How often it runs on each problem.
    pub fn runs(&self, runs: u32) -> u32 {
        if self.optimizer.is_deterministic() { 1 } else { runs }
    }
}

impl PreparedStudy {
    /// Roughly how long all runs take on one core, s.
    pub fn estimate_s(&self) -> f64 {
        let evaluation = |problem: &StudyProblem| match problem {
            StudyProblem::Timing(study) => study.task.evaluation_s(),
            StudyProblem::Function { dimension, .. } => 1e-9 * (50.0 + 4.0 * *dimension as f64),
        };
        let runs: f64 = self.methods.iter().map(|method| f64::from(method.runs(self.runs))).sum();
        let per_problem = runs * self.max_evaluations as f64;
        self.problems.iter().map(evaluation).sum::<f64>() * per_problem
    }
}

/// Checks a `comparison`.
pub(in crate::plan) fn prepare_comparison(
    task: &ComparisonTask,
    common: &Common<'_>,
    faults: &mut Faults,
) -> Option<PreparedStudy> {
    let mut problems = Vec::new();
    match (&task.task, &task.problems[..]) {
        (None, []) => faults.add("/task", "either `task` or at least one of `problems` is needed"),
        (Some(_), [_, ..]) => {
            faults.add("/task/problems", "`task` and `problems` exclude each other")
        }
        (Some(only), []) => {
            let problem = shared(common, only, "task", "", "/task/task", faults);
            problems.extend(problem);
        }
        (None, several) => problems.extend(check_problems(several, common, faults)),
    }
    check_range("/task/runs", u64::from(task.runs), 1, u64::from(MAX_RUNS), faults);
    let most = task.max_evaluations;
    check_range("/task/max_evaluations", most, 1, MAX_RUN_EVALUATIONS, faults);
    if !(1e-6..=1.0).contains(&task.success_tolerance) {
        let detail = format!("{} is outside 1e-6 to 1", task.success_tolerance);
        faults.add("/task/success_tolerance", detail);
    }
    let variables = problems.iter().map(|it| it.task.waypoints.len() - 1).max().unwrap_or(1);
    let check = MethodCheck { pointer: "/task/methods", variables, max_evaluations: most };
    let methods = check.all(&task.methods, None, faults);
    let problems = problems.into_iter().map(|it| StudyProblem::Timing(Box::new(it))).collect();
    let study = PreparedStudy {
        task: "comparison",
        problems,
        methods,
        runs: task.runs,
        max_evaluations: most,
        tolerance: task.success_tolerance,
    };
    study.check_work(faults);
    Some(study)
}

/// Checks a `benchmark`.
pub(in crate::plan) fn prepare_benchmark(
    task: &BenchmarkTask,
    faults: &mut Faults,
) -> Option<PreparedStudy> {
    let BenchmarkTask { functions, dimension, population, iterations, runs, .. } = task;
    check_range("/task/dimension", u64::from(*dimension), 1, u64::from(MAX_DIMENSION), faults);
    check_range("/task/population", u64::from(*population), 2, 100_000, faults);
    check_range("/task/iterations", u64::from(*iterations), 0, 1_000_000, faults);
    check_range("/task/runs", u64::from(*runs), 1, u64::from(MAX_RUNS), faults);
    let max_evaluations = u64::from(*population) * (u64::from(*iterations) + 1);
    check_range("/task/iterations", max_evaluations, 2, MAX_RUN_EVALUATIONS, faults);
    let functions = check_functions(functions, faults);
    let chosen = match &task.optimizers[..] {
        [] => {
            let seeded = OPTIMIZERS.iter().filter(|entry| !entry.is_deterministic());
            seeded.map(|entry| MethodChoice::named(entry.name)).collect()
        }
        given => given.to_vec(),
    };
    let dimension = *dimension as usize;
    let check = MethodCheck { pointer: "/task/optimizers", variables: dimension, max_evaluations };
    let methods = check.all(&chosen, Some([*population, *iterations]), faults);
    let problem = |function| StudyProblem::Function { function, dimension, shifted: task.shifted };
    let study = PreparedStudy {
        task: "benchmark",
        problems: functions.into_iter().map(problem).collect(),
        methods,
        runs: *runs,
        max_evaluations,
        tolerance: ComparisonTask::DEFAULT_TOLERANCE,
    };
    study.check_work(faults);
    Some(study)
}

impl PreparedStudy {
    fn check_work(&self, faults: &mut Faults) {
        let runs: f64 = self.methods.iter().map(|method| f64::from(method.runs(self.runs))).sum();
        let all = runs * self.problems.len() as f64 * self.max_evaluations as f64;
        if all > MAX_EVALUATIONS {
            let detail = format!(
                "{runs} runs on each of {} problems with {} evaluations each are {all:e} \
                 evaluations, more than {MAX_EVALUATIONS:e}; ask for fewer runs or evaluations",
                self.problems.len(),
                self.max_evaluations
            );
            faults.add("/task", detail);
        }
    }
}

fn check_range(pointer: &str, value: u64, min: u64, max: u64, faults: &mut Faults) {
    if !(min..=max).contains(&value) {
        faults.add(pointer, format!("{value} is outside {min} to {max}"));
    }
}

fn check_functions(names: &[String], faults: &mut Faults) -> Vec<&'static Function> {
    if names.is_empty() {
        return FUNCTIONS.iter().collect();
    }
    let mut found: Vec<&'static Function> = Vec::new();
    // More than there are would repeat one, which is a fault of its own.
    for (index, name) in names.iter().take(FUNCTIONS.len() + 1).enumerate() {
        let place = format!("/task/functions/{index}");
        match function(name) {
            None => {
                let known = function_names();
                let name = escape(name);
                faults.add(place, format!("no function is called `{name}`; known: {known}"));
            }
            Some(function) if found.contains(&function) => {
                faults.add(place, format!("{name} is named twice"));
            }
            Some(function) => found.push(function),
        }
    }
    found
}

fn check_problems(
    problems: &[ComparedProblem],
    common: &Common<'_>,
    faults: &mut Faults,
) -> Vec<TimingStudy> {
    let count = problems.len();
    if count > MAX_PROBLEMS {
        faults.add("/task/problems", format!("{count} problems; 1 to {MAX_PROBLEMS} are taken"));
        return Vec::new();
    }
    let mut names = HashSet::new();
    let mut prepared = Vec::with_capacity(count);
    for (index, problem) in problems.iter().enumerate() {
        let place = format!("/task/problems/{index}");
        check_name(&problem.name, &format!("{place}/name"), &mut names, faults);
        prepared.extend(check_problem(problem, common, &place, faults));
    }
    prepared
}

fn check_problem(
    problem: &ComparedProblem,
    common: &Common<'_>,
    place: &str,
    faults: &mut Faults,
) -> Option<TimingStudy> {
    let ComparedProblem { name, robot, limits: overrides, limit_scale, task } = problem;
    let own = robot.is_some() || overrides.is_some() || limit_scale.is_some();
    if !own {
        return shared(common, task, name, "", &format!("{place}/task"), faults);
    }
    let mut found = Faults::default();
    let robot = match robot {
        Some(robot) => resolve_robot(robot, common.find_robot, &mut found),
        None => common.robot.cloned(),
    };
    let limits = robot
        .as_ref()
        .map(|robot| limits::resolve(robot, overrides.as_ref(), limit_scale.as_ref(), &mut found));
    refuse_tcp_limit(overrides.as_ref(), &mut found);
    let none = robot.is_none() && found.is_empty();
    faults.add_below(place, found);
    if none {
        faults.add("/robot", format!("missing: problem {name} names no robot of its own"));
    }
    let (robot, limits) = (robot?, limits?);
    let own = Common { robot: Some(&robot), limits: &limits, ..*common };
    shared(&own, task, name, place, &format!("{place}/task"), faults)
}

/// Methods are compared by what they search, and none of them knows the tool.
pub(in crate::plan) fn refuse_tcp_limit(overrides: Option<&LimitOverrides>, faults: &mut Faults) {
    if overrides.is_some_and(|overrides| overrides.tcp_speed.is_some()) {
        let detail = "methods are compared within the joints' limits only";
        faults.add("/limits/tcp_speed", detail);
    }
}

/// The task of a problem for a robot and limits that stand below `origin`.
fn shared(
    common: &Common<'_>,
    task: &WaypointsTask,
    name: &str,
    origin: &str,
    pointer: &str,
    faults: &mut Faults,
) -> Option<TimingStudy> {
    let Some(robot) = common.robot else {
        faults.add("/robot", format!("missing: problem {name} names no robot of its own"));
        return None;
    };
    check_comparable(task, pointer, faults);
    let mut found = Faults::default();
    let check = Check { robot, limits: common.limits, tcp_speed: None };
    let prepared = check.waypoints(task, pointer, &mut found);
    for fault in found.0 {
        // Limits belong to the problem, or to the whole request.
        let below = if fault.pointer.starts_with("/limits") { origin } else { "" };
        faults.add(format!("{below}{}", fault.pointer), fault.detail);
    }
    let task = prepared?;
    let timing = &task.interpolation.timing;
    if let Some(own) = timing.own() {
        let detail = format!("{} {own}: there is no search to compare", task.interpolation.name);
        faults.add(format!("{pointer}/interpolation"), detail);
    }
    let (name, robot, limits) = (name.to_owned(), robot.name().to_owned(), common.limits.to_vec());
    Some(TimingStudy { name, robot, limits, task })
}

/// What a task cannot ask for when methods are compared on it.
fn check_comparable(task: &WaypointsTask, pointer: &str, faults: &mut Faults) {
    if task.optimizer != OptimizerChoice::default() {
        let detail = "a compared task names no optimizer: `methods` does";
        faults.add(format!("{pointer}/optimizer"), detail);
    }
    if task.clock != Clock::Shared {
        let detail = "methods are compared with the shared clock, on one search each";
        faults.add(format!("{pointer}/clock"), detail);
    }
    if task.duration.is_some() {
        let detail = "methods are compared by the shortest duration they find";
        faults.add(format!("{pointer}/duration"), detail);
    }
    if task.constraints != Constraints::Full {
        let detail = "methods are compared within all limits; those that shall not count are \
                      removed with `limits`: null";
        faults.add(format!("{pointer}/constraints"), detail);
    }
    for (name, given) in [
        ("objective", task.objective.is_some()),
        ("pareto", task.pareto.is_some()),
        ("fixed_durations", task.fixed_durations.is_some()),
    ] {
        if given {
            let detail = "methods are compared by time alone, on durations they search";
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
}

/// What every method has to fit.
struct MethodCheck {
    pointer: &'static str,
    /// Most variables of a problem.
    variables: usize,
    max_evaluations: u64,
}

impl MethodCheck {
    /// Checks the methods; a benchmark's population and iterations stand in
    /// where a method sets none.
    fn all(
        &self,
        methods: &[MethodChoice],
        benchmark: Option<[u32; 2]>,
        faults: &mut Faults,
    ) -> Vec<StudyMethod> {
        let count = methods.len();
        if count == 0 || count > MAX_METHODS {
            faults.add(self.pointer, format!("{count} methods; 1 to {MAX_METHODS} are taken"));
            return Vec::new();
        }
        let mut labels = HashSet::new();
        let mut prepared = Vec::with_capacity(count);
        for (index, method) in methods.iter().enumerate() {
            let place = format!("{}/{index}", self.pointer);
            check_name(method.label(), &format!("{place}/label"), &mut labels, faults);
            let Some(entry) = optimizer(&method.name) else {
                let (name, known) = (escape(&method.name), optimizer_names());
                let detail = format!("no optimizer is called `{name}`; known: {known}");
                faults.add(format!("{place}/name"), detail);
                continue;
            };
            if benchmark.is_some() && entry.is_deterministic() {
                let detail = format!(
                    "{} needs the scaling law of trajectories, which a function does not obey",
                    entry.name
                );
                faults.add(place, detail);
                continue;
            }
            let settings = self.settings(method, entry, benchmark, &place, faults);
            check_population(self.variables, &settings, &place, faults);
            let label = method.label().to_owned();
            prepared.push(StudyMethod { label, optimizer: entry, settings });
        }
        prepared
    }

    fn settings(
        &self,
        method: &MethodChoice,
        entry: &OptimizerEntry,
        benchmark: Option<[u32; 2]>,
        place: &str,
        faults: &mut Faults,
    ) -> Settings {
        for name in ["max_evaluations", "time_limit_s"] {
            if method.parameters.get(name).is_some_and(|value| !value.is_null()) {
                let detail = format!(
                    "every method has the same {} evaluations and no other limit",
                    self.max_evaluations
                );
                faults.add(format!("{place}/{name}"), detail);
            }
        }
        let mut given = method.parameters.clone();
        let given_faults = &mut Faults::default();
        if let Some([population, _]) = benchmark {
            given.entry("population".to_owned()).or_insert(population.into());
        }
        let settings = entry.settings(&given, place, given_faults);
        let iterations = match (benchmark, settings.optional("population")) {
            // The schedule of a method ends with the evaluations.
            (_, Some(size)) => Some((self.max_evaluations / size as u64).max(1) - 1),
            (Some([_, iterations]), None) => Some(u64::from(iterations)),
            (None, None) => None,
        };
        if let Some(iterations) = iterations {
            given.entry("iterations".to_owned()).or_insert(iterations.into());
        }
        entry.settings(&given, place, faults)
    }
}
