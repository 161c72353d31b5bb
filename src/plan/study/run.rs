//! Runs methods side by side: every run writes its own place, so the result
//! does not depend on how many threads there are.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::prepare::{PreparedStudy, StudyMethod, StudyProblem, TimingStudy};
use super::result::{BestRun, ComparisonResult, KnownOptimum, ProblemResult};
use super::row::{self, RunRecord};
use super::trace::{Trace, grid};
use crate::budget::Budget;
use crate::math::random::derive_seed;
use crate::optimize::functions::{Function, SOURCE};
use crate::optimize::{
    ConvergencePoint, Objective, OptimizerEntry, SideBySide, Solution, minimize, optimizer,
};
use crate::plan::error::PlanError;
use crate::plan::optimum::Optimum;
use crate::plan::prepared::Progress;
use crate::plan::result::PlanResult;
use crate::plan::side_by_side::side_by_side;
use crate::plan::waypoints::pose;
use crate::trajectory::interpolation::Timing;
use crate::trajectory::kernel::Kernel;
use crate::trajectory::timing::TimingProblem;

/// Least time between two reports, s.
const REPORT_EVERY_S: f64 = 1e-3;

/// Runs a comparison or a benchmark.
pub(in crate::plan) fn run(
    study: &PreparedStudy,
    seed: u64,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let reporter = Reporter::new(progress);
    let grid = grid(study.max_evaluations);
    let session = Session { study, seed, budget, reporter: &reporter, grid: &grid };
    let mut problems = Vec::with_capacity(study.problems.len());
    for problem in &study.problems {
        match session.problem(problem) {
            Ok(result) => problems.push(result),
            Err(error) => return Err(error.with_partial(session.assemble(problems))),
        }
    }
    Ok(session.assemble(problems))
}

/// What all problems share.
struct Session<'a> {
    study: &'a PreparedStudy,
    seed: u64,
    budget: &'a Budget,
    reporter: &'a Reporter<'a>,
    grid: &'a [u64],
}

/// A problem ready to be searched.
enum Posed<'a> {
    Timing {
        study: &'a TimingStudy,
        /// As the exact method sees it.
        exact: Box<TimingProblem>,
        /// As the others do.
        seeded: Box<TimingProblem>,
    },
    Function {
        function: &'static Function,
        dimension: usize,
        shifted: bool,
    },
}

/// The least value found so far, by which job, and where.
type Best = Mutex<Option<(f64, usize, Vec<f64>)>>;

impl Session<'_> {
    fn problem(&self, problem: &StudyProblem) -> Result<ProblemResult, PlanError> {
        let posed = Posed::new(problem)?;
        let lower_bound = posed.lower_bound(self.budget);
        let optimum = self.optimum(&posed, lower_bound)?;
        let tolerance = self.study.tolerance;
        let bar = optimum.as_ref().map_or(f64::INFINITY, |it| row::threshold(it.value, tolerance));
        let jobs: Vec<(&StudyMethod, u32)> = self
            .study
            .methods
            .iter()
            .flat_map(|method| (0..method.runs(self.study.runs)).map(move |run| (method, run)))
            .collect();
        let best = Best::default();
        let records = side_by_side(jobs.len(), |index| {
            let (method, run) = jobs[index];
            self.run(&posed, &Job { index, method, run, bar, lower_bound }, &best)
        });
        self.stopped()?;
        let best = best.into_inner().unwrap_or_else(PoisonError::into_inner);
        let best_run = best.map(|(value, index, position)| BestRun {
            method: jobs[index].0.label.clone(),
            run: jobs[index].1,
            value,
            position: posed.decode(jobs[index].0, position),
        });
        let runs = best_run.iter().map(|best| best.value);
        let best_known = match posed {
            Posed::Timing { .. } => optimum.iter().map(|it| it.value).chain(runs).reduce(f64::min),
            // Nothing but rounding is below a known optimum.
            Posed::Function { .. } => optimum.as_ref().map(|it| it.value),
        };
        let methods = row::rows(self.study, &records, self.grid, best_known);
        Ok(ProblemResult {
            name: posed.name().to_owned(),
            title: posed.title(),
            robot: posed.robot(),
            unit: if matches!(posed, Posed::Timing { .. }) { "s" } else { "" }.to_owned(),
            dimension: posed.dimension(),
            optimum,
            lower_bound,
            best_known,
            best_method: row::best_method(self.study, &methods).map(|at| methods[at].label.clone()),
            best_run,
            methods,
        })
    }

    /// The error of a budget that ended.
    fn stopped(&self) -> Result<(), PlanError> {
        self.budget.stop_reason(0).and_then(PlanError::stopped).map_or(Ok(()), Err)
    }

    /// The optimum to compare with.
    fn optimum(
        &self,
        posed: &Posed<'_>,
        lower_bound: Option<f64>,
    ) -> Result<Option<KnownOptimum>, PlanError> {
        let exact = match posed {
            Posed::Timing { exact, .. } => &**exact,
            Posed::Function { function, dimension, shifted } => {
                let position = function.objective(*dimension, *shifted, 0).optimum();
                let source = SOURCE.to_owned();
                return Ok(Some(KnownOptimum { value: 0.0, position, source }));
            }
        };
        let Some(entry) = optimizer("exact") else { return Ok(None) };
        let settings = entry.settings(&Default::default(), "", &mut Default::default());
        let mut search = (entry.build)(&settings, exact, self.seed);
        let mut watch = Watch::new(self.reporter, posed.name(), "exact", lower_bound, true);
        let mut report = |point: &ConvergencePoint| watch.see(point);
        let iterations = settings.integer("iterations");
        let solution = minimize(exact, search.as_mut(), iterations, self.budget, &mut report);
        self.stopped()?;
        // What no scaling mends is not an optimum.
        let lawful = solution.position.filter(|position| exact.is_lawful(position));
        let found = lawful.map(|position| KnownOptimum {
            value: solution.fitness,
            position: exact.decode(&position),
            source: "exact optimum of the interpolation".to_owned(),
        });
        Ok(found)
    }

    fn run(&self, posed: &Posed<'_>, job: &Job<'_>, best: &Best) -> RunRecord {
        if self.budget.stop_reason(0).is_some() {
            return RunRecord::default();
        }
        let seed = derive_seed(self.seed, u64::from(job.run));
        match posed {
            Posed::Timing { exact, seeded, .. } => {
                let deterministic = job.method.optimizer.is_deterministic();
                let objective: &TimingProblem = if deterministic { exact } else { seeded };
                self.search(posed, job, &SideBySide(objective), Some(objective), seed, best)
            }
            Posed::Function { function, dimension, shifted } => {
                let objective = function.objective(*dimension, *shifted, seed);
                self.search(posed, job, &SideBySide(&objective), None, seed, best)
            }
        }
    }

    fn search(
        &self,
        posed: &Posed<'_>,
        job: &Job<'_>,
        objective: &dyn Objective,
        timing: Option<&TimingProblem>,
        seed: u64,
        best: &Best,
    ) -> RunRecord {
        let StudyMethod { label, optimizer, settings } = job.method;
        let highest = timing.map_or(f64::INFINITY, TimingProblem::highest_duration);
        let mut trace = Trace::new(self.grid, job.bar, highest);
        let first = job.run == 0;
        let mut watch = Watch::new(self.reporter, posed.name(), label, job.lower_bound, first);
        let mut report = |point: &ConvergencePoint| {
            trace.push(point);
            watch.see(point);
        };
        let begun = self.budget.elapsed_s();
        let budget = self.budget.clone().with_max_evaluations(Some(self.study.max_evaluations));
        let mut search = (optimizer.build)(settings, objective, seed);
        let iterations = settings.integer("iterations");
        let solution = minimize(objective, search.as_mut(), iterations, &budget, &mut report);
        let seconds = self.budget.elapsed_s() - begun;
        let Solution { position, fitness, evaluations, .. } = solution;
        let lawful = |position: &Vec<f64>| timing.is_none_or(|problem| problem.is_lawful(position));
        let Some(position) = position.filter(lawful) else {
            return RunRecord::nothing(self.grid.len(), evaluations, seconds);
        };
        offer(best, fitness, job.index, position);
        let (values, steps) = trace.finish();
        RunRecord { value: fitness, values, steps, evaluations, seconds }
    }

    fn assemble(&self, problems: Vec<ProblemResult>) -> PlanResult {
        let PreparedStudy { task, runs, max_evaluations, tolerance, .. } = self.study;
        PlanResult::Comparison(ComparisonResult {
            task: (*task).to_owned(),
            runs: *runs,
            max_evaluations: *max_evaluations,
            success_tolerance: *tolerance,
            test: row::TEST.to_owned(),
            verdict: row::verdict(self.study, &problems),
            problems,
            evaluations: self.reporter.evaluations.load(Ordering::Relaxed),
            planning_s: self.budget.elapsed_s(),
            seed: self.seed,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        })
    }
}

/// One run of one method.
struct Job<'a> {
    index: usize,
    method: &'a StudyMethod,
    run: u32,
    bar: f64,
    lower_bound: Option<f64>,
}

/// Keeps the least value; of equal ones that of the earlier job, whichever
/// thread was first.
fn offer(best: &Best, value: f64, index: usize, position: Vec<f64>) {
    let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
    let better = best
        .as_ref()
        .is_none_or(|(least, first, _)| value < *least || value == *least && index < *first);
    if better {
        *best = Some((value, index, position));
    }
}

impl<'a> Posed<'a> {
    fn new(problem: &'a StudyProblem) -> Result<Self, PlanError> {
        let study = match problem {
            StudyProblem::Function { function, dimension, shifted } => {
                return Ok(Self::Function { function, dimension: *dimension, shifted: *shifted });
            }
            StudyProblem::Timing(study) => &**study,
        };
        let Timing::Search(kernel) = study.task.interpolation.timing else {
            // Validation lets no such task through.
            let message = format!("{} leaves nothing to search", study.task.interpolation.name);
            return Err(PlanError::unreachable(message, serde_json::json!({})));
        };
        let kernel: &'static dyn Kernel = kernel;
        let joints: Vec<usize> = (0..study.limits.len()).collect();
        // The task itself names `exact`: that is its default.
        let posed =
            |entry: &OptimizerEntry| pose(&study.task, &study.limits, kernel, &joints, entry);
        let seeded = crate::optimize::OPTIMIZERS.iter().find(|entry| !entry.is_deterministic());
        let exact = posed(study.task.optimizer);
        let seeded = posed(seeded.unwrap_or(study.task.optimizer));
        Ok(Self::Timing { study, exact: Box::new(exact), seeded: Box::new(seeded) })
    }

    fn name(&self) -> &str {
        match self {
            Self::Timing { study, .. } => &study.name,
            Self::Function { function, .. } => function.name,
        }
    }

    fn title(&self) -> String {
        match self {
            Self::Timing { study, .. } => {
                let points = study.task.waypoints.len();
                let family = study.task.interpolation;
                let jumps = if family.executable { "" } else { ", not executable" };
                format!("{points} waypoints, {}{jumps}", family.title)
            }
            Self::Function { function, shifted, .. } => {
                let shifted = if *shifted { ", shifted" } else { "" };
                format!("{}{shifted}: {}", function.title, function.formula)
            }
        }
    }

    fn robot(&self) -> Option<String> {
        match self {
            Self::Timing { study, .. } => Some(study.robot.clone()),
            Self::Function { .. } => None,
        }
    }

    fn dimension(&self) -> usize {
        match self {
            Self::Timing { study, .. } => study.task.waypoints.len() - 1,
            Self::Function { dimension, .. } => *dimension,
        }
    }

    fn lower_bound(&self, budget: &Budget) -> Option<f64> {
        match self {
            Self::Timing { study, .. } => {
                let optimum = Optimum::find(&study.task, &study.limits, budget);
                optimum.bound.map(|bound| bound.lower)
            }
            Self::Function { .. } => None,
        }
    }

    /// What a candidate of `method` stands for.
    fn decode(&self, method: &StudyMethod, position: Vec<f64>) -> Vec<f64> {
        match self {
            Self::Timing { exact, .. } if method.optimizer.is_deterministic() => {
                exact.decode(&position)
            }
            Self::Timing { seeded, .. } => seeded.decode(&position),
            Self::Function { .. } => position,
        }
    }
}

/// Passes progress on, from all threads: evaluations only ever grow.
struct Reporter<'a> {
    progress: &'a (dyn Fn(Progress) + Sync),
    evaluations: AtomicU64,
    /// When something was last reported, s; locked while reporting.
    latest: Mutex<f64>,
}

impl<'a> Reporter<'a> {
    fn new(progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        let latest = Mutex::new(f64::NEG_INFINITY);
        Self { progress, evaluations: AtomicU64::new(0), latest }
    }
}

/// Watches one run on behalf of the reporter.
struct Watch<'a> {
    reporter: &'a Reporter<'a>,
    problem: &'a str,
    method: &'a str,
    lower_bound: Option<f64>,
    seen: u64,
    /// True until reported once, if that has to happen.
    announce: bool,
}

impl<'a> Watch<'a> {
    fn new(
        reporter: &'a Reporter<'a>,
        problem: &'a str,
        method: &'a str,
        lower_bound: Option<f64>,
        announce: bool,
    ) -> Self {
        Self { reporter, problem, method, lower_bound, seen: 0, announce }
    }

    fn see(&mut self, point: &ConvergencePoint) {
        let more = point.evaluations - self.seen;
        self.reporter.evaluations.fetch_add(more, Ordering::Relaxed);
        self.seen = point.evaluations;
        // Each method is heard at least once; otherwise, whoever finds another
        // thread reporting has nothing to add.
        let announce = std::mem::take(&mut self.announce);
        let mut latest = match self.reporter.latest.try_lock() {
            Ok(latest) => latest,
            Err(_) if !announce => return,
            Err(_) => self.reporter.latest.lock().unwrap_or_else(PoisonError::into_inner),
        };
        if !announce && point.elapsed_s < *latest + REPORT_EVERY_S {
            return;
        }
        *latest = point.elapsed_s;
        (self.reporter.progress)(Progress {
            iteration: point.iteration,
            evaluations: self.reporter.evaluations.load(Ordering::Relaxed),
            elapsed_s: point.elapsed_s,
            best: point.best,
            mean: point.mean,
            lower_bound: self.lower_bound,
            leg: Some(self.problem.to_owned()),
            method: Some(self.method.to_owned()),
            members: None,
        });
    }
}
