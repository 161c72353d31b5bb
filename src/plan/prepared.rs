//! A valid request, ready to run.

use std::iter;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::family::PreparedFamily;
use super::motion::PreparedMotion;
use super::objectives::{ObjectiveWeights, ParetoMethod, ParetoRequest};
use super::path::PreparedPath;
use super::request::{Clock, ConstraintHandling, Constraints, DurationGoal, DurationRange};
use super::study::PreparedStudy;
use crate::optimize::{OptimizerEntry, Settings};
use crate::robot::Robot;
use crate::trajectory::interpolation::{Interpolation, Timing};
use crate::trajectory::{Ends, JointBounds, TcpLimit};

/// A change of position below this counts as none, rad or m.
pub(super) const LEAST_WAY: f64 = 1e-12;

/// How long `jerk_limited` needs for a segment of eight joints, roughly, s.
const FREE_SEGMENT_S: f64 = 5e-3;

/// How long a motion around obstacles needs, roughly, s.
const MOTION_S: f64 = 2e-2;

/// How far planning has come.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Progress {
    /// Iterations done in this leg; of a family, members done.
    pub iteration: u64,
    /// Candidates evaluated so far, over all legs.
    pub evaluations: u64,
    /// Seconds since the start of the run.
    pub elapsed_s: f64,
    /// Best duration so far, s, best weighted objective or length of a path; of a family, that
    /// of the fastest member; null while no candidate is feasible.
    pub best: Option<f64>,
    /// Mean fitness of the current generation.
    pub mean: Option<f64>,
    /// Proven lower bound on the duration, s.
    pub lower_bound: Option<f64>,
    /// The program's leg or the family's member being planned, or the problem
    /// methods are compared on.
    pub leg: Option<String>,
    /// The method being run, where several are compared.
    #[serde(default)]
    pub method: Option<String>,
    /// How many members of a family are done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub members: Option<MembersDone>,
}

/// How far a family has come.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MembersDone {
    /// Members planned or failed.
    pub done: usize,
    /// Members in all.
    pub of: usize,
    /// Members that could not be planned.
    pub failed: usize,
    /// Duration of the slowest member so far, s.
    pub slowest: Option<f64>,
}

impl Progress {
    /// The same with absent instead of infinite or undefined values, which
    /// JSON cannot hold: live and stored events then stay equal.
    pub fn finite(self) -> Self {
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Self {
            elapsed_s: if self.elapsed_s.is_finite() { self.elapsed_s } else { 0.0 },
            best: finite(self.best),
            mean: finite(self.mean),
            lower_bound: finite(self.lower_bound),
            ..self
        }
    }
}

/// A valid request, ready to run.
pub struct PreparedPlan {
    /// None if the task is about no robot, or about several.
    pub(super) robot: Option<Arc<Robot>>,
    pub(super) limits: Vec<JointBounds>,
    /// Limit of the tool's speed, m/s.
    pub(super) tcp_speed: Option<f64>,
    pub(super) seed: u64,
    pub(super) task: PreparedTask,
    /// True if other plans run beside it and keep the threads busy.
    pub(super) side_by_side: bool,
}

pub(super) enum PreparedTask {
    Waypoints(PreparedWaypoints),
    Path(PreparedPath),
    Motion(Box<PreparedMotion>),
    Program(Vec<PreparedLeg>),
    Family(PreparedFamily),
    Study(PreparedStudy),
}

/// A valid leg of a program.
pub(super) struct PreparedLeg {
    pub name: String,
    pub note: Option<String>,
    pub task: PreparedWaypoints,
}

/// A valid `waypoints` task.
#[derive(Clone)]
pub(super) struct PreparedWaypoints {
    pub waypoints: Vec<Vec<f64>>,
    pub interpolation: &'static Interpolation,
    pub optimizer: &'static OptimizerEntry,
    pub settings: Settings,
    pub clock: Clock,
    pub handling: ConstraintHandling,
    pub constraints: Constraints,
    pub range: Option<DurationRange>,
    pub goal: Option<DurationGoal>,
    pub weights: ObjectiveWeights,
    pub pareto: Option<Box<ParetoRequest>>,
    /// Durations that leave nothing to search.
    pub fixed: Option<Vec<f64>>,
    /// None if both are at rest.
    pub ends: Option<Ends>,
    /// By how much each joint may miss inner waypoints, rad or m; none if they are just met.
    pub via_tolerance: Option<Vec<f64>>,
}

impl PreparedPlan {
    /// Roughly how long planning takes on one core, s.
    pub fn estimate_s(&self) -> f64 {
        match &self.task {
            PreparedTask::Study(study) => study.estimate_s(),
            PreparedTask::Path(task) => task.estimate_s(),
            PreparedTask::Motion(_) => MOTION_S,
            _ => self.tasks().map(PreparedWaypoints::estimate_s).sum(),
        }
    }

    /// The task's name.
    pub fn task(&self) -> &'static str {
        match &self.task {
            PreparedTask::Waypoints(_) => "waypoints",
            PreparedTask::Path(_) => "path",
            PreparedTask::Motion(_) => "motion",
            PreparedTask::Program(_) => "program",
            PreparedTask::Family(_) => "family",
            PreparedTask::Study(study) => study.task,
        }
    }

    /// Interpolation and optimizer, those of a program's legs or a family's members, planner and
    /// smoothing, or how many are compared.
    pub fn method(&self) -> String {
        match &self.task {
            PreparedTask::Study(study) => return format!("{} methods", study.methods.len()),
            PreparedTask::Path(task) => return task.method(),
            PreparedTask::Motion(task) => return task.method(),
            _ => {}
        }
        let mut methods: Vec<String> = Vec::new();
        for task in self.tasks() {
            let method = format!("{}/{}", task.optimizer.name, task.interpolation.name);
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        methods.join(",")
    }

    /// The robot's name; `-` if the task is about no robot, or about several.
    pub fn robot_name(&self) -> &str {
        if let PreparedTask::Family(PreparedFamily { members, .. }) = &self.task {
            return members.first().map_or("-", |member| member.plan.robot_name());
        }
        self.robot.as_ref().map_or("-", |robot| robot.name())
    }

    /// The limit of the tool's speed, if there is one.
    pub(super) fn tcp_limit(&self) -> Option<TcpLimit<'_>> {
        let kinematics = self.robot.as_ref()?.kinematics()?;
        self.tcp_speed.map(|speed| TcpLimit { kinematics, speed })
    }

    /// All `waypoints` tasks that are to be planned.
    pub(super) fn tasks(&self) -> Box<dyn Iterator<Item = &PreparedWaypoints> + '_> {
        match &self.task {
            PreparedTask::Waypoints(task) => Box::new(iter::once(task)),
            PreparedTask::Program(legs) => Box::new(legs.iter().map(|leg| &leg.task)),
            PreparedTask::Family(family) => {
                Box::new(family.members.iter().flat_map(|member| member.plan.tasks()))
            }
            PreparedTask::Path(_) | PreparedTask::Motion(_) | PreparedTask::Study(_) => {
                Box::new(iter::empty())
            }
        }
    }
}

impl PreparedWaypoints {
    /// Whether all joints rest at the start, and at the goal.
    pub fn rests(&self) -> [bool; 2] {
        self.ends.as_ref().map_or([true; 2], Ends::rests)
    }

    /// The same through other waypoints.
    pub fn through(&self, waypoints: Vec<Vec<f64>>) -> Self {
        Self { waypoints, ..self.clone() }
    }

    /// Roughly how long one evaluation takes, s.
    pub fn evaluation_s(&self) -> f64 {
        let (segments, dof) = (self.waypoints.len() - 1, self.waypoints[0].len());
        let groups = if self.clock == Clock::PerJoint { 1 } else { dof.div_ceil(8) };
        let sweeps = if self.handling == ConstraintHandling::RepairSegment { 4.0 } else { 1.0 };
        1e-6 * (0.2 + 0.3 * (segments * groups) as f64) * sweeps
    }

    fn estimate_s(&self) -> f64 {
        let (segments, dof) = (self.waypoints.len() - 1, self.waypoints[0].len());
        match self.interpolation.timing {
            Timing::Search(_) if self.fixed.is_none() => {}
            Timing::Search(_) | Timing::ClosedForm(_) => return 0.0,
            Timing::Free => return FREE_SEGMENT_S * (segments * dof.div_ceil(8)) as f64,
        }
        let searches = if self.clock == Clock::PerJoint { dof } else { 1 };
        let evaluations = match self.settings.optional("population") {
            Some(population) => population * (1.0 + self.settings.get("iterations")),
            None => 100.0 * self.settings.get("iterations") * (segments + 2) as f64,
        };
        let evaluations = evaluations * if self.weights.is_weighted() { 2.0 } else { 1.0 };
        let evaluations = evaluations + self.front_evaluations(segments);
        let limit = self.settings.optional("max_evaluations").unwrap_or(f64::INFINITY);
        let estimate = evaluations.min(limit) * self.evaluation_s() * searches as f64;
        estimate.min(self.settings.optional("time_limit_s").unwrap_or(f64::INFINITY))
    }

    fn front_evaluations(&self, segments: usize) -> f64 {
        let Some(pareto) = &self.pareto else { return 0.0 };
        match pareto.method {
            ParetoMethod::EpsilonConstraint => (300 * pareto.points() * (segments + 2)) as f64,
            ParetoMethod::Nsga2 => pareto.population() as f64 * (1.0 + pareto.generations() as f64),
        }
    }
}
