//! Checks what a request means and prepares its plan.

use std::collections::HashSet;
use std::sync::Arc;

use super::objectives::{self, ObjectiveWeights};
use super::prepared::{LEAST_WAY, PreparedPlan, PreparedTask, PreparedWaypoints};
use super::request::{
    Clock, Constraints, DurationGoal, DurationRange, OptimizerChoice, PlanRequest, RobotRef,
    SceneRef, Task, WaypointsTask,
};
use super::{family, limits, motion, path, study};
use crate::fault::{Faults, escape};
use crate::optimize::{OptimizerEntry, Settings, optimizer, optimizer_names};
use crate::robot::Robot;
use crate::scene::{Scene, SceneDescription};
use crate::trajectory::JointBounds;
use crate::trajectory::interpolation::{Interpolation, Timing, interpolation, interpolation_names};

/// Most waypoints of one task, unless its interpolation takes more.
pub const MAX_WAYPOINTS: usize = 500;

/// Most legs of a program.
pub const MAX_LEGS: usize = 100;

/// Most characters of the name of a problem, a method or a member.
const MAX_NAME: usize = 64;

/// Largest position taken, rad or m: beyond it, rounding alone is a visible motion.
const LARGEST_POSITION: f64 = 1e9;

/// Most variables of one population: more would only fill the memory.
const MAX_POPULATION_VARIABLES: f64 = 2e6;

/// Longest durations taken, s: about eleven days.
pub(super) const LONGEST: f64 = 1e6;

/// Shortest durations taken, s.
pub(super) const SHORTEST: f64 = 1e-6;

/// Checks a request; `find_robot` knows the robots that have names.
///
/// # Errors
///
/// Every fault found, with its JSON pointer.
pub fn validate(
    request: &PlanRequest,
    find_robot: &dyn Fn(&str) -> Option<Arc<Robot>>,
) -> Result<PreparedPlan, Faults> {
    let mut faults = Faults::default();
    let robot = match &request.robot {
        None => None,
        // Without its robot nothing can be said about a task.
        Some(robot) => match resolve_robot(robot, find_robot, &mut faults) {
            None => return Err(faults),
            robot => robot,
        },
    };
    let (overrides, scale) = (request.limits.as_ref(), request.limit_scale.as_ref());
    let limits = match &robot {
        Some(robot) => limits::resolve(robot, overrides, scale, &mut faults),
        None => Vec::new(),
    };
    let tcp_speed =
        robot.as_ref().and_then(|robot| limits::tcp_speed(robot, overrides, &mut faults));
    let common = Common { robot: robot.as_ref(), limits: &limits, find_robot };
    let task = match &request.task {
        Task::Family(task) => {
            family::prepare(task, request, &common, &mut faults).map(PreparedTask::Family)
        }
        Task::Comparison(task) => {
            study::refuse_tcp_limit(overrides, &mut faults);
            study::prepare_comparison(task, &common, &mut faults).map(PreparedTask::Study)
        }
        Task::Path(task) => {
            refuse_robot(request, "a path is that of a point", &mut faults);
            path::prepare(task, &mut faults).map(PreparedTask::Path)
        }
        Task::Benchmark(task) => {
            refuse_robot(request, "a benchmark runs on functions", &mut faults);
            study::prepare_benchmark(task, &mut faults).map(PreparedTask::Study)
        }
        Task::Waypoints(_) | Task::Motion(_) | Task::Program(_) if robot.is_none() => {
            faults.add("/robot", "missing field `robot`");
            None
        }
        Task::Waypoints(task) => robot.as_ref().and_then(|robot| {
            let check = Check { robot, limits: &limits, tcp_speed };
            check.waypoints(task, "/task", &mut faults).map(PreparedTask::Waypoints)
        }),
        Task::Motion(task) => robot.as_ref().and_then(|robot| {
            let check = Check { robot, limits: &limits, tcp_speed };
            let scene = resolve_scene(request.scene.as_ref(), &mut faults)?;
            let motion = motion::prepare(task, robot, &scene, &check, &mut faults);
            motion.map(|task| PreparedTask::Motion(Box::new(task)))
        }),
        Task::Program(task) => robot.as_ref().and_then(|robot| {
            let check = Check { robot, limits: &limits, tcp_speed };
            check.program(task, &mut faults).map(PreparedTask::Program)
        }),
    };
    let seed = request.seed;
    // A task that is none has at least one fault.
    let prepared =
        |task| PreparedPlan { robot, limits, tcp_speed, seed, task, side_by_side: false };
    faults.into_result(task)?.map(prepared).ok_or_else(Faults::default)
}

/// Some tasks know neither robot nor limits: who gives them means something else.
fn refuse_robot(request: &PlanRequest, why: &str, faults: &mut Faults) {
    for (name, given) in [
        ("robot", request.robot.is_some()),
        ("limits", request.limits.is_some()),
        ("limit_scale", request.limit_scale.is_some()),
    ] {
        if given {
            faults.add(format!("/{name}"), format!("{why}, without {name}"));
        }
    }
}

/// What a request says for all problems of a comparison or family.
pub(super) struct Common<'a> {
    /// The request's robot, if it has one.
    pub robot: Option<&'a Arc<Robot>>,
    /// Its limits.
    pub limits: &'a [JointBounds],
    /// Knows the robots that have names.
    pub find_robot: &'a dyn Fn(&str) -> Option<Arc<Robot>>,
}

/// A name of 1 to 64 characters that is not taken yet.
pub(super) fn check_name<'a>(
    name: &'a str,
    place: &str,
    taken: &mut HashSet<&'a str>,
    faults: &mut Faults,
) {
    if !(1..=MAX_NAME).contains(&name.chars().count()) {
        faults.add(place, format!("a name has 1 to {MAX_NAME} characters"));
    }
    if !taken.insert(name) {
        faults.add(place, format!("another one is called `{name}`; give each its own"));
    }
}

/// The robot a request names or describes.
pub(super) fn resolve_robot(
    robot: &RobotRef,
    find_robot: &dyn Fn(&str) -> Option<Arc<Robot>>,
    faults: &mut Faults,
) -> Option<Arc<Robot>> {
    match robot {
        RobotRef::Name(name) => {
            let found = find_robot(name);
            if found.is_none() {
                let detail = format!("no robot is called `{name}`; GET /v1/robots lists them");
                faults.add("/robot", detail);
            }
            found
        }
        RobotRef::Inline(description) => match Robot::new(description.as_ref().clone()) {
            Ok(robot) => Some(Arc::new(robot)),
            Err(found) => {
                faults.add_below("/robot", found);
                None
            }
        },
    }
}

/// The scene a request describes; an empty one where it says nothing.
fn resolve_scene(scene: Option<&SceneRef>, faults: &mut Faults) -> Option<Scene> {
    let description = match scene {
        None => SceneDescription::default(),
        Some(SceneRef::Inline(description)) => description.as_ref().clone(),
        Some(SceneRef::Name(name)) => {
            let name = escape(name);
            faults.add("/scene", format!("no scene is called `{name}`; GET /v1/scenes lists them"));
            return None;
        }
    };
    Scene::new(description).map_err(|found| faults.add_below("/scene", found)).ok()
}

/// What a task has to fit.
pub(super) struct Check<'a> {
    pub robot: &'a Robot,
    pub limits: &'a [JointBounds],
    /// Limit of the tool's speed, m/s.
    pub tcp_speed: Option<f64>,
}

impl Check<'_> {
    /// Checks the task at `pointer`.
    pub fn waypoints(
        &self,
        task: &WaypointsTask,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<PreparedWaypoints> {
        let waypoints =
            self.resolve(&task.waypoints, None, &format!("{pointer}/waypoints"), faults);
        self.resolved(task, waypoints, pointer, faults)
    }

    /// Checks the task at `pointer` with the configurations of its waypoints, unless a fault keeps them unknown.
    pub(super) fn resolved(
        &self,
        task: &WaypointsTask,
        waypoints: Option<Vec<Vec<f64>>>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<PreparedWaypoints> {
        let before = faults.0.len();
        let interpolation = interpolation(&task.interpolation);
        let most = interpolation.and_then(|entry| entry.max_segments).unwrap_or(0) + 1;
        let most = most.max(MAX_WAYPOINTS);
        if let Some(waypoints) = &waypoints {
            self.configurations(waypoints, most, &format!("{pointer}/waypoints"), faults);
        }
        let optimizer = self.optimizer(task, pointer, faults);
        let settings = optimizer.map(|entry| {
            entry.settings(&task.optimizer.parameters, &format!("{pointer}/optimizer"), faults)
        });
        let Some(interpolation) = interpolation else {
            let (name, known) = (&task.interpolation, interpolation_names());
            let detail = format!("no interpolation is called `{name}`; known: {known}");
            faults.add(format!("{pointer}/interpolation"), detail);
            return None;
        };
        check_durations(task, pointer, faults);
        objectives::check(task, interpolation.timing.own(), pointer, faults);
        if self.tcp_speed.is_some() && task.pareto.is_some() {
            let detail = "a front knows no limit of the tool's speed: remove /limits/tcp_speed";
            faults.add(format!("{pointer}/pareto"), detail);
        }
        if let Some(settings) = &settings {
            let segments = task.waypoints.len().saturating_sub(1);
            check_population(segments, settings, &format!("{pointer}/optimizer"), faults);
        }
        let sound = waypoints.as_deref().filter(|_| faults.0.len() == before);
        let ends = self.ends(task, interpolation, sound, pointer, faults);
        let via_tolerance = self.via_tolerance(task, interpolation, pointer, faults);
        if let Some(waypoints) = sound {
            self.fit(task, waypoints, interpolation, pointer, faults);
        }
        let (Some(optimizer), Some(settings)) = (optimizer, settings) else { return None };
        Some(PreparedWaypoints {
            waypoints: waypoints?,
            interpolation,
            optimizer,
            settings,
            clock: task.clock,
            handling: task.constraint_handling,
            constraints: task.constraints,
            range: task.durations,
            goal: task.duration,
            weights: task.objective.unwrap_or(ObjectiveWeights::TIME),
            pareto: task.pareto.clone(),
            fixed: task.fixed_durations.clone(),
            ends,
            via_tolerance,
        })
    }

    /// Waypoints on their own: number, length, values, limits, repetition.
    fn configurations(
        &self,
        waypoints: &[Vec<f64>],
        most: usize,
        pointer: &str,
        faults: &mut Faults,
    ) {
        let count = waypoints.len();
        if count < 2 {
            let detail = format!("{count} waypoints; a motion needs at least 2");
            faults.add(pointer, detail);
        }
        if count > most {
            faults.add(pointer, format!("{count} waypoints; at most {most} are taken"));
            return;
        }
        for (index, waypoint) in waypoints.iter().enumerate() {
            let place = format!("{pointer}/{index}");
            if waypoint.len() != self.robot.dof() {
                let (found, dof, name) = (waypoint.len(), self.robot.dof(), self.robot.name());
                let detail =
                    format!("waypoint {index} has {found} values; {name} has {dof} joints");
                faults.add(place, detail);
                continue;
            }
            for (joint, value) in waypoint.iter().enumerate() {
                self.position(
                    &format!("waypoint {index}, "),
                    joint,
                    *value,
                    format!("{place}/{joint}"),
                    faults,
                );
            }
            let ways = |before: &Vec<f64>| {
                before.iter().zip(waypoint).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
            };
            if index > 0 && ways(&waypoints[index - 1]) < LEAST_WAY {
                let before = index - 1;
                let detail = format!(
                    "waypoints {before} and {index} are equal: every segment must move a joint"
                );
                faults.add(place, detail);
            }
        }
    }

    /// One configuration on its own: length, values, limits.
    pub fn configuration(&self, joints: &[f64], pointer: &str, faults: &mut Faults) {
        let (found, dof) = (joints.len(), self.robot.dof());
        if found != dof {
            let name = self.robot.name();
            faults.add(pointer, format!("{found} values; {name} has {dof} joints"));
            return;
        }
        for (joint, value) in joints.iter().enumerate() {
            self.position("", joint, *value, format!("{pointer}/{joint}"), faults);
        }
    }

    /// `owner` says in front whose position it is.
    fn position(&self, owner: &str, joint: usize, value: f64, place: String, faults: &mut Faults) {
        let JointBounds { name, unit, lower, upper, .. } = &self.limits[joint];
        if !value.is_finite() {
            faults.add(place, format!("{owner}{name}: {value} is not a finite number"));
            return;
        }
        if value.abs() > LARGEST_POSITION {
            let detail =
                format!("{owner}{name}: {value:e} {unit} is beyond ±{LARGEST_POSITION:e} {unit}");
            faults.add(place, detail);
            return;
        }
        for (limit, word, broken) in [
            (lower, "below its lower", lower.as_ref().is_some_and(|limit| value < limit.value)),
            (upper, "above its upper", upper.as_ref().is_some_and(|limit| value > limit.value)),
        ] {
            if let (true, Some(limit)) = (broken, limit) {
                let limit = limit.value;
                let detail =
                    format!("{owner}{name}: {value} {unit} is {word} limit of {limit} {unit}");
                faults.add(place.clone(), detail);
            }
        }
    }

    fn optimizer(
        &self,
        task: &WaypointsTask,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<&'static OptimizerEntry> {
        let found = optimizer(&task.optimizer.name);
        if found.is_none() {
            let (name, known) = (escape(&task.optimizer.name), optimizer_names());
            let detail = format!("no optimizer is called `{name}`; known: {known}");
            faults.add(format!("{pointer}/optimizer/name"), detail);
        }
        found
    }

    /// Whether the parts, each fine alone, go together.
    fn fit(
        &self,
        task: &WaypointsTask,
        waypoints: &[Vec<f64>],
        interpolation: &Interpolation,
        pointer: &str,
        faults: &mut Faults,
    ) {
        let (segments, name) = (waypoints.len() - 1, interpolation.name);
        let most = interpolation.max_segments.unwrap_or(usize::MAX);
        if !(interpolation.min_segments..=most).contains(&segments) {
            let detail = match interpolation.max_segments {
                Some(most) if most == interpolation.min_segments => format!(
                    "{name} takes {} waypoints, not {}; quintic takes any number",
                    most + 1,
                    segments + 1
                ),
                _ => format!(
                    "{name} takes at least {} waypoints, not {}; quintic takes any number",
                    interpolation.min_segments + 1,
                    segments + 1
                ),
            };
            faults.add(format!("{pointer}/interpolation"), detail);
        }
        if let Some(own) = interpolation.timing.own() {
            check_unsearched(task, &format!("{name} {own}"), pointer, faults);
        }
        let closed_form = matches!(interpolation.timing, Timing::ClosedForm(_));
        if closed_form && task.constraints == Constraints::VelocityOnly {
            faults
                .add(format!("{pointer}/constraints"), format!("{name} needs acceleration limits"));
        }
        for (joint, limit) in self.limits.iter().enumerate() {
            let moves = waypoints.windows(2).any(|pair| pair[0][joint] != pair[1][joint]);
            if moves {
                self.moving_joint(task, interpolation, limit, closed_form, pointer, faults);
            }
        }
    }

    fn moving_joint(
        &self,
        task: &WaypointsTask,
        interpolation: &Interpolation,
        limit: &JointBounds,
        closed_form: bool,
        pointer: &str,
        faults: &mut Faults,
    ) {
        let full = task.constraints == Constraints::Full;
        let known = limit.derivatives.iter().take(if full { 3 } else { 1 }).flatten().count();
        let (joint, name) = (&limit.name, interpolation.name);
        if known == 0 {
            let kinds = if full { "velocity, acceleration or jerk" } else { "velocity" };
            let detail = format!(
                "{joint} moves but {} knows no {kinds} limit for it; give one in `limits`",
                self.robot.name()
            );
            faults.add("/limits", detail);
        }
        if closed_form && limit.derivatives[1].is_none() {
            faults.add(
                "/limits/acceleration",
                format!("{name} needs an acceleration limit for {joint}"),
            );
        }
        if full && !interpolation.bounded_jerk && limit.derivatives[2].is_some() {
            let detail = format!(
                "acceleration of {name} jumps, which the jerk limit of {joint} forbids; use an \
                 interpolation of bounded jerk, as quintic, or remove the jerk limits with \"limits\": {{\"jerk\": null}}"
            );
            faults.add(format!("{pointer}/interpolation"), detail);
        }
    }
}

/// What an interpolation without a search cannot take; `why` says why not.
fn check_unsearched(task: &WaypointsTask, why: &str, pointer: &str, faults: &mut Faults) {
    if task.optimizer != OptimizerChoice::default() {
        faults.add(format!("{pointer}/optimizer"), format!("{why}: leave out the optimizer"));
    }
    if task.clock == Clock::PerJoint {
        faults.add(format!("{pointer}/clock"), format!("{why} for all joints at once"));
    }
    if task.durations.is_some() {
        faults.add(format!("{pointer}/durations"), format!("{why}: there is no search range"));
    }
}

/// Whether a population of candidates with `variables` each fits the memory;
/// `pointer` is the optimizer's.
pub(super) fn check_population(
    variables: usize,
    settings: &Settings,
    pointer: &str,
    faults: &mut Faults,
) {
    let Some(population) = settings.optional("population") else { return };
    if population * variables as f64 > MAX_POPULATION_VARIABLES {
        let detail = format!(
            "{population} candidates of {variables} variables each are too many; at most \
             {MAX_POPULATION_VARIABLES:e} variables together"
        );
        faults.add(format!("{pointer}/population"), detail);
    }
}

fn check_durations(task: &WaypointsTask, pointer: &str, faults: &mut Faults) {
    if let Some(DurationRange { min, max }) = task.durations {
        let place = format!("{pointer}/durations");
        for (name, value) in [("min", min), ("max", max)] {
            if !(SHORTEST..=LONGEST).contains(&value) {
                let detail = format!("{value} s is outside {SHORTEST} to {LONGEST} s");
                faults.add(format!("{place}/{name}"), detail);
            }
        }
        if min >= max {
            faults.add(place, format!("min {min} s is not below max {max} s"));
        }
    }
    if let Some(goal) = task.duration {
        let (name, value) = match goal {
            DurationGoal::Exactly(value) => ("exactly", value),
            DurationGoal::AtMost(value) => ("at_most", value),
        };
        if !(SHORTEST..=LONGEST).contains(&value) {
            let detail = format!("{value} s is outside {SHORTEST} to {LONGEST} s");
            faults.add(format!("{pointer}/duration/{name}"), detail);
        }
    }
}
