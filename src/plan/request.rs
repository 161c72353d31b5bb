//! What a user asks for.

use std::collections::BTreeMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::family::FamilyTask;
use super::motion::MotionTask;
use super::objectives::{ObjectiveWeights, ParetoRequest};
use super::path::PathTask;
use super::poses::Waypoint;
use super::study::{BenchmarkTask, ComparisonTask};
use crate::fault::{Faults, read};
use crate::robot::RobotDescription;
use crate::scene::SceneDescription;

/// A planning job's content: which robot, what to plan, within which limits.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PlanRequest {
    /// A catalogue or registered robot by name, or a robot object inline. May
    /// be left out of a path and a benchmark, and of a comparison or family whose problems
    /// all name their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotRef>,
    /// What stands around the robot, by registered name or inline; motions keep away from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneRef>,
    /// What to plan.
    pub task: Task,
    /// Seed of every random stream. Equal request and seed give equal results.
    #[serde(default)]
    pub seed: u64,
    /// Limits that replace the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitOverrides>,
    /// Factors on the limits, after `limits` replaced them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_scale: Option<LimitScale>,
}

/// A robot by name or in full.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum RobotRef {
    /// Catalogue or registered name.
    Name(String),
    /// The robot itself.
    Inline(Box<RobotDescription>),
}

/// A scene by name or in full.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum SceneRef {
    /// Registered name.
    Name(String),
    /// The scene itself.
    Inline(Box<SceneDescription>),
}

/// What to plan.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Task {
    /// Pass through joint waypoints in the least time.
    Waypoints(WaypointsTask),
    /// Find a way for a point that touches nothing.
    Path(PathTask),
    /// Move the robot around what stands in its way.
    Motion(MotionTask),
    /// Several tasks in order.
    Program(ProgramTask),
    /// One problem in many variants.
    Family(FamilyTask),
    /// Methods compared on tasks.
    Comparison(ComparisonTask),
    /// Methods compared on mathematical functions.
    Benchmark(BenchmarkTask),
}

/// The names of all tasks, as `type` takes them.
pub const TASKS: &[&str] =
    &["waypoints", "path", "motion", "program", "family", "comparison", "benchmark"];

/// Pass through joint waypoints in the least time, at rest at both ends unless they say otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WaypointsTask {
    /// At least two: configurations in joint order (rad or m), or poses of the tool (`{"pose": {...}}`), for which the
    /// configurations with the least joint travel through all waypoints are taken.
    #[schema(min_items = 2)]
    pub waypoints: Vec<Waypoint>,
    /// Interpolation by registry name.
    #[serde(default = "default_interpolation")]
    pub interpolation: String,
    /// One clock for all joints, or each joint alone.
    #[serde(default)]
    pub clock: Clock,
    /// Optimizer by registry name, with its parameters.
    #[serde(default)]
    pub optimizer: OptimizerChoice,
    /// What becomes of a candidate that breaks a limit.
    #[serde(default)]
    pub constraint_handling: ConstraintHandling,
    /// Which limits the optimizer minds; the certificate always checks all.
    #[serde(default)]
    pub constraints: Constraints,
    /// Search range of each segment's duration, s; default: derived from the problem.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub durations: Option<DurationRange>,
    /// Total duration wanted; default: as short as possible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration: Option<DurationGoal>,
    /// What is minimised; default: time alone. With weights on more, `duration`
    /// bounds the motion's time (`at_most`) or sets it (`exactly`) within the search.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<ObjectiveWeights>,
    /// Asks for a front of motions beside the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pareto: Option<Box<ParetoRequest>>,
    /// Exactly these durations, one per segment, s: nothing is searched, and it
    /// fails if they break a limit. So a front's point is planned again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed_durations: Option<Vec<f64>>,
    /// With `jerk_limited`, the motion at the first waypoint; default: at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<EndMotion>,
    /// With `jerk_limited`, the motion at the last waypoint; default: at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<EndMotion>,
    /// With `jerk_limited`, by how much each joint may miss each waypoint but the first and the last, rad or m; default: not
    /// at all. Position limits hold all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub via_tolerance: Option<ViaTolerance>,
}

/// By how much joints may miss waypoints: the same for every joint, or one value per joint.
///
/// Every joint stays within its own tolerance (the maximum norm: rad and m do not add up).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a number or a list with a number per joint")]
pub enum ViaTolerance {
    /// The same for every joint, rad or m.
    All(f64),
    /// One per joint, rad or m.
    PerJoint(Vec<f64>),
}

/// How the joints move at one end of a motion, as where a robot is re-planned while it moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct EndMotion {
    /// Velocity in joint order, rad/s or m/s; default: zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Acceleration in joint order, rad/s² or m/s²; default: zero. Of no meaning for a joint
    /// without a jerk limit, whose acceleration may jump.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<Vec<f64>>,
}

fn default_interpolation() -> String {
    "quintic".to_owned()
}

/// Several tasks, one after the other; each starts where the one before ended.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ProgramTask {
    /// The legs in order; 1 to 100.
    #[schema(min_items = 1, max_items = 100)]
    pub legs: Vec<Leg>,
}

/// One leg of a program.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Leg {
    /// Name, unique within the program.
    pub name: String,
    /// Free text for whoever carries out the result, such as the gripper to
    /// use; at most 200 characters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_length = 200)]
    pub note: Option<String>,
    /// What to plan; not a program again.
    #[serde(serialize_with = "LegTask::serialize_waypoints")]
    #[schema(value_type = LegTask)]
    pub task: WaypointsTask,
}

/// A leg's task as JSON: it names its type, as every task does.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum LegTask {
    /// Pass through joint waypoints in the least time.
    Waypoints(WaypointsTask),
}

impl LegTask {
    /// Writes the task with its type.
    pub(super) fn serialize_waypoints<S: serde::Serializer>(
        task: &WaypointsTask,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        Self::Waypoints(task.clone()).serialize(serializer)
    }
}

/// How segment durations are shared between joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// All joints at once.
    #[default]
    Shared,
    /// Each joint alone, then per segment the largest time over the joints,
    /// stretched where that breaks a limit (the papers' way).
    PerJoint,
}

/// What becomes of a candidate that breaks a limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ConstraintHandling {
    /// All durations are scaled to the smallest lawful multiple.
    #[default]
    RepairUniform,
    /// Segments over a limit are stretched, up to four sweeps, then uniform repair.
    RepairSegment,
    /// The excess is added to the fitness.
    Penalty,
    /// The candidate never becomes a best.
    Reject,
}

/// Which limits the optimizer minds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Constraints {
    /// Velocity, acceleration and jerk.
    #[default]
    Full,
    /// Velocity alone, for reproducing papers; the result may be unlawful and says so.
    VelocityOnly,
}

/// Search range of one segment's duration, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DurationRange {
    /// Shortest, s.
    pub min: f64,
    /// Longest, s.
    pub max: f64,
}

/// A wish for the total duration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DurationGoal {
    /// Exactly this long, s; fails if the limits need longer.
    Exactly(f64),
    /// As short as possible; fails if that is longer than this, s.
    AtMost(f64),
}

/// An optimizer and its parameters, as its registry entry lists them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct OptimizerChoice {
    /// Registry name.
    pub name: String,
    /// Parameters that differ from their defaults.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

impl Default for OptimizerChoice {
    fn default() -> Self {
        Self { name: "exact".to_owned(), parameters: BTreeMap::new() }
    }
}

/// Limits that replace the robot's. A field left out keeps the robot's, `null`
/// removes it, a number holds for all joints, a list names one value (or
/// `null`) per joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitOverrides {
    /// Lower position limits, rad or m.
    #[serde(default, skip_serializing_if = "LimitOverride::is_keep")]
    #[schema(value_type = Option<LimitValues>)]
    pub lower: LimitOverride,
    /// Upper position limits, rad or m.
    #[serde(default, skip_serializing_if = "LimitOverride::is_keep")]
    #[schema(value_type = Option<LimitValues>)]
    pub upper: LimitOverride,
    /// Velocity limits, rad/s or m/s.
    #[serde(default, skip_serializing_if = "LimitOverride::is_keep")]
    #[schema(value_type = Option<LimitValues>)]
    pub velocity: LimitOverride,
    /// Acceleration limits, rad/s² or m/s².
    #[serde(default, skip_serializing_if = "LimitOverride::is_keep")]
    #[schema(value_type = Option<LimitValues>)]
    pub acceleration: LimitOverride,
    /// Jerk limits, rad/s³ or m/s³.
    #[serde(default, skip_serializing_if = "LimitOverride::is_keep")]
    #[schema(value_type = Option<LimitValues>)]
    pub jerk: LimitOverride,
    /// Highest speed of the tool centre point, m/s; needs a robot with kinematics. Absent or `null`: none.
    /// `limit_scale` leaves it as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0.0, example = 0.25)]
    pub tcp_speed: Option<f64>,
}

/// One kind of limit, replaced or kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Option<LimitValues>", into = "Option<LimitValues>")]
pub enum LimitOverride {
    /// The robot's own limits hold.
    #[default]
    Keep,
    /// No limit of this kind.
    Remove,
    /// These limits hold.
    Replace(LimitValues),
}

impl LimitOverride {
    /// True if the robot's own limits hold.
    pub fn is_keep(&self) -> bool {
        matches!(self, Self::Keep)
    }
}

impl From<Option<LimitValues>> for LimitOverride {
    fn from(values: Option<LimitValues>) -> Self {
        values.map_or(Self::Remove, Self::Replace)
    }
}

impl From<LimitOverride> for Option<LimitValues> {
    fn from(limit: LimitOverride) -> Self {
        match limit {
            LimitOverride::Replace(values) => Some(values),
            LimitOverride::Keep | LimitOverride::Remove => None,
        }
    }
}

/// One value for all joints, or one per joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a number, a list with a number or null per joint, or null")]
pub enum LimitValues {
    /// The same for every joint.
    All(f64),
    /// One per joint; `null` is no limit.
    PerJoint(Vec<Option<f64>>),
}

/// Factors in (0, 1] on the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LimitScale {
    /// Factor on the velocity limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Factor on the acceleration limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<f64>,
    /// Factor on the jerk limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk: Option<f64>,
}

/// [`PlanRequest`] before its parts that stand for several types are read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPlanRequest {
    #[expect(dead_code, reason = "read apart; here only so that it is known")]
    robot: Option<IgnoredAny>,
    #[expect(dead_code, reason = "read apart; here only so that it is known")]
    task: Option<IgnoredAny>,
    #[expect(dead_code, reason = "read apart; here only so that it is known")]
    scene: Option<IgnoredAny>,
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    limits: Option<LimitOverrides>,
    #[serde(default)]
    limit_scale: Option<LimitScale>,
}

impl PlanRequest {
    /// The robots the request names or describes.
    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut RobotRef> {
        let (one, several) = match &mut self.task {
            Task::Family(family) => (family.problem.robot.as_mut(), &mut [][..]),
            Task::Comparison(comparison) => (None, &mut comparison.problems[..]),
            Task::Waypoints(_)
            | Task::Path(_)
            | Task::Motion(_)
            | Task::Program(_)
            | Task::Benchmark(_) => (None, &mut [][..]),
        };
        let several = several.iter_mut().filter_map(|problem| problem.robot.as_mut());
        self.robot.iter_mut().chain(one).chain(several)
    }

    /// Reads a request; the structure only, see
    /// [`validate`](super::validate()) for its meaning.
    ///
    /// # Errors
    ///
    /// Every field that is missing, unknown or of the wrong type.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        // The two members of several types are read apart, so that their
        // faults are found even where others stand beside them.
        let members = ["robot", "scene", "task"].map(|name| {
            let member = value.get(name).cloned();
            let needed = name == "task" || name == "robot" && needs_robot(&value);
            if member.is_none() && needed && value.is_object() {
                faults.add(format!("/{name}"), format!("missing field `{name}`"));
            }
            member
        });
        let raw = read::<RawPlanRequest>(value, "", &mut faults);
        let [robot, scene, task] = members;
        let robot = robot.and_then(|value| RobotRef::parse(value, "/robot", &mut faults));
        let scene = scene.and_then(|value| SceneRef::parse(value, "/scene", &mut faults));
        let task = task.and_then(|value| Task::parse(value, "/task", &mut faults));
        match (raw, task) {
            (Some(raw), Some(task)) => faults.into_result(Self {
                robot,
                scene,
                task,
                seed: raw.seed,
                limits: raw.limits,
                limit_scale: raw.limit_scale,
            }),
            _ => Err(faults),
        }
    }
}

/// True unless the task is of a kind that may do without the request's robot:
/// whether such a one needs it, only its meaning tells.
fn needs_robot(request: &Value) -> bool {
    let task = request.pointer("/task/type").and_then(Value::as_str);
    !matches!(task, Some("path" | "family" | "comparison" | "benchmark"))
}

impl RobotRef {
    /// Reads a name or a robot object that stands at `pointer`.
    pub fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        match value {
            Value::String(name) => Some(Self::Name(name)),
            Value::Object(_) => {
                read(value, pointer, faults).map(|robot| Self::Inline(Box::new(robot)))
            }
            _ => {
                faults.add(pointer, "expected a robot's name or a robot object");
                None
            }
        }
    }
}

impl SceneRef {
    fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        match value {
            Value::String(name) => Some(Self::Name(name)),
            Value::Object(_) => {
                read(value, pointer, faults).map(|scene| Self::Inline(Box::new(scene)))
            }
            _ => {
                faults.add(pointer, "expected a scene's name or a scene object");
                None
            }
        }
    }
}

impl Task {
    /// Reads the task that stands at `pointer`.
    pub fn parse(mut value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        match take_type(&mut value, pointer, "a task", faults)?.as_str() {
            "waypoints" => read(value, pointer, faults).map(Self::Waypoints),
            "path" => PathTask::parse(value, pointer, faults).map(Self::Path),
            "motion" => read(value, pointer, faults).map(Self::Motion),
            "program" => ProgramTask::parse(value, pointer, faults).map(Self::Program),
            "family" => FamilyTask::parse(value, pointer, faults).map(Self::Family),
            "comparison" => ComparisonTask::parse(value, pointer, faults).map(Self::Comparison),
            "benchmark" => read(value, pointer, faults).map(Self::Benchmark),
            other => {
                let known = TASKS.join(", ");
                faults.add(
                    format!("{pointer}/type"),
                    format!("unknown task `{other}`; known: {known}"),
                );
                None
            }
        }
    }

    /// The task's name, as `type` gives it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Waypoints(_) => "waypoints",
            Self::Path(_) => "path",
            Self::Motion(_) => "motion",
            Self::Program(_) => "program",
            Self::Family(_) => "family",
            Self::Comparison(_) => "comparison",
            Self::Benchmark(_) => "benchmark",
        }
    }
}

/// Takes the member `type` out of an object.
pub(super) fn take_type(
    value: &mut Value,
    pointer: &str,
    what: &str,
    faults: &mut Faults,
) -> Option<String> {
    let Value::Object(members) = value else {
        faults.add(pointer, format!("expected {what} object"));
        return None;
    };
    match members.shift_remove("type") {
        Some(Value::String(name)) => Some(name),
        Some(_) => {
            faults.add(format!("{pointer}/type"), "expected a name as a string");
            None
        }
        None => {
            faults.add(format!("{pointer}/type"), "missing field `type`");
            None
        }
    }
}

impl ProgramTask {
    fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            legs: Vec<RawLeg>,
        }
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct RawLeg {
            name: String,
            #[serde(default)]
            note: Option<String>,
            task: Value,
        }
        let raw: Raw = read(value, pointer, faults)?;
        let mut legs = Vec::with_capacity(raw.legs.len());
        let count = raw.legs.len();
        for (index, RawLeg { name, note, task }) in raw.legs.into_iter().enumerate() {
            let place = format!("{pointer}/legs/{index}/task");
            match Task::parse(task, &place, faults) {
                Some(Task::Waypoints(task)) => legs.push(Leg { name, note, task }),
                Some(other) => {
                    faults.add(
                        place,
                        format!("a leg passes waypoints and cannot be a {}", other.name()),
                    );
                }
                None => {}
            }
        }
        (legs.len() == count).then_some(Self { legs })
    }
}
