//! What a user asks for when comparing methods.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::fault::{Faults, read};
use crate::plan::request::{LegTask, LimitOverrides, LimitScale, RobotRef, Task, WaypointsTask};

/// Most runs of each method on each problem.
pub const MAX_RUNS: u32 = 1000;

/// Most methods compared.
pub const MAX_METHODS: usize = 32;

/// Most problems of a comparison.
pub const MAX_PROBLEMS: usize = 32;

/// Most variables of a benchmark function.
pub const MAX_DIMENSION: u32 = 1000;

/// Compare methods on `waypoints` tasks: the same seeds, the same number of
/// evaluations, the family's exact optimum beside them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ComparisonTask {
    /// The problem, for the request's robot and limits; instead of `problems`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<LegTask>)]
    #[serde(serialize_with = "optional_task")]
    pub task: Option<WaypointsTask>,
    /// Several problems, 1 to 32, each with its own robot if it names one;
    /// instead of `task`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub problems: Vec<ComparedProblem>,
    /// Methods to compare, 1 to 32: an optimizer's name, or an object with its
    /// name, parameters and perhaps a label. A method that sets no `iterations`
    /// gets as many as fill the evaluations.
    #[schema(min_items = 1, max_items = 32, value_type = Vec<MethodForm>)]
    pub methods: Vec<MethodChoice>,
    /// Runs of each method on each problem, 1 to 1000; run `r` of every method
    /// has the same seed. A deterministic method runs once.
    #[schema(minimum = 1, maximum = 1000, default = 30)]
    pub runs: u32,
    /// Evaluations each run may use, the same for every method.
    #[schema(minimum = 1, default = 5000)]
    pub max_evaluations: u64,
    /// A run succeeds once it is within this share of the best known duration.
    #[schema(minimum = 1e-6, maximum = 1.0, default = 0.001)]
    pub success_tolerance: f64,
}

/// One problem of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ComparedProblem {
    /// Name, unique within the comparison.
    pub name: String,
    /// The problem's robot, instead of the request's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotRef>,
    /// Limits that replace the robot's, instead of the request's, which hold
    /// for problems of the request's robot only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitOverrides>,
    /// Factors on the limits, instead of the request's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_scale: Option<LimitScale>,
    /// What is planned; without an optimizer, which `methods` name.
    #[serde(serialize_with = "LegTask::serialize_waypoints")]
    #[schema(value_type = LegTask)]
    pub task: WaypointsTask,
}

/// Compare methods on mathematical functions with a known optimum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BenchmarkTask {
    /// Functions by name, `f1` to `f8`; default all.
    pub functions: Vec<String>,
    /// Number of variables, 1 to 1000.
    #[schema(minimum = 1, maximum = 1000, default = 30)]
    pub dimension: u32,
    /// Candidates per generation of every method that sets none itself.
    #[schema(minimum = 2, maximum = 100_000, default = 30)]
    pub population: u32,
    /// Generations after the initial one of every method that sets none itself.
    /// Every run may use `population` times `iterations + 1` evaluations.
    #[schema(minimum = 0, maximum = 1_000_000, default = 1000)]
    pub iterations: u32,
    /// Runs of each method on each function, 1 to 1000.
    #[schema(minimum = 1, maximum = 1000, default = 30)]
    pub runs: u32,
    /// Optimizers to compare, as `methods` of a comparison; default all that
    /// need no trajectory.
    #[schema(value_type = Vec<MethodForm>)]
    pub optimizers: Vec<MethodChoice>,
    /// True moves the optimum off the origin, which some methods favour.
    pub shifted: bool,
}

impl Default for BenchmarkTask {
    fn default() -> Self {
        Self {
            functions: Vec::new(),
            dimension: 30,
            population: 30,
            iterations: 1000,
            runs: 30,
            optimizers: Vec::new(),
            shifted: false,
        }
    }
}

/// A method to compare.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(from = "RawMethod")]
pub struct MethodChoice {
    /// Optimizer by registry name.
    pub name: String,
    /// What to call the method, unique; default the optimizer's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Parameters that differ from their defaults.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

/// A method by its optimizer's name alone, or with what differs.
#[derive(ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes what is read apart")]
enum MethodForm {
    /// Optimizer by registry name.
    Name(String),
    /// With parameters, a label or both.
    Full(MethodChoice),
}

/// [`MethodChoice`] as it may be written.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected an optimizer's name or an object with its `name`")]
enum RawMethod {
    Name(String),
    Full {
        name: String,
        #[serde(default)]
        label: Option<String>,
        #[serde(flatten)]
        parameters: BTreeMap<String, Value>,
    },
}

impl From<RawMethod> for MethodChoice {
    fn from(raw: RawMethod) -> Self {
        match raw {
            RawMethod::Name(name) => Self { name, label: None, parameters: BTreeMap::new() },
            RawMethod::Full { name, label, parameters } => Self { name, label, parameters },
        }
    }
}

impl MethodChoice {
    /// The optimizer `name` with its defaults.
    pub fn named(name: &str) -> Self {
        Self { name: name.to_owned(), label: None, parameters: BTreeMap::new() }
    }

    /// What results call the method.
    pub fn label(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.name)
    }
}

fn optional_task<S: serde::Serializer>(
    task: &Option<WaypointsTask>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    task.clone().map(LegTask::Waypoints).serialize(serializer)
}

/// [`ComparisonTask`] before the parts that stand for several types are read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawComparison {
    #[serde(default)]
    task: Option<Value>,
    #[serde(default)]
    problems: Vec<RawProblem>,
    methods: Vec<MethodChoice>,
    #[serde(default)]
    runs: Option<u32>,
    #[serde(default)]
    max_evaluations: Option<u64>,
    #[serde(default)]
    success_tolerance: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawProblem {
    name: String,
    #[serde(default)]
    robot: Option<Value>,
    #[serde(default)]
    limits: Option<LimitOverrides>,
    #[serde(default)]
    limit_scale: Option<LimitScale>,
    task: Value,
}

impl ComparisonTask {
    /// Evaluations of each run where the request names none.
    pub const DEFAULT_EVALUATIONS: u64 = 5000;

    /// Runs of each method where the request names none.
    pub const DEFAULT_RUNS: u32 = 30;

    /// Share of the best known duration within which a run succeeds by default.
    pub const DEFAULT_TOLERANCE: f64 = 0.001;

    /// Reads the task that stands at `pointer`.
    pub(in crate::plan) fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        let before = faults.0.len();
        let raw: RawComparison = read(value, pointer, faults)?;
        let task = raw.task.map(|task| waypoints(task, &format!("{pointer}/task"), faults));
        let count = raw.problems.len();
        let problems = raw.problems.into_iter().enumerate();
        let problems: Vec<ComparedProblem> = problems
            .filter_map(|(index, raw)| raw.parse(&format!("{pointer}/problems/{index}"), faults))
            .collect();
        let complete = problems.len() == count && faults.0.len() == before;
        complete.then(|| Self {
            task: task.flatten(),
            problems,
            methods: raw.methods,
            runs: raw.runs.unwrap_or(Self::DEFAULT_RUNS),
            max_evaluations: raw.max_evaluations.unwrap_or(Self::DEFAULT_EVALUATIONS),
            success_tolerance: raw.success_tolerance.unwrap_or(Self::DEFAULT_TOLERANCE),
        })
    }
}

impl RawProblem {
    fn parse(self, pointer: &str, faults: &mut Faults) -> Option<ComparedProblem> {
        let Self { name, robot, limits, limit_scale, task } = self;
        let robot = robot.map(|it| RobotRef::parse(it, &format!("{pointer}/robot"), faults));
        let task = waypoints(task, &format!("{pointer}/task"), faults)?;
        Some(ComparedProblem { name, robot: robot.flatten(), limits, limit_scale, task })
    }
}

fn waypoints(value: Value, pointer: &str, faults: &mut Faults) -> Option<WaypointsTask> {
    let task = Task::parse(value, pointer, faults)?;
    let name = task.name();
    let Task::Waypoints(task) = task else {
        faults.add(pointer, format!("methods are compared on `waypoints` tasks, not on a {name}"));
        return None;
    };
    Some(task)
}
