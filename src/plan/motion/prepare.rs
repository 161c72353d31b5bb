//! Checks what a request for a motion means.

use std::sync::Arc;

use super::request::{MotionEnd, MotionTask};
use crate::collision::{CollisionChecker, MotionCheck};
use crate::fault::parameter::Settings;
use crate::fault::{Faults, escape};
use crate::geometry::check_pose;
use crate::plan::path::{ATTEMPTS, check_planner};
use crate::plan::prepare::{Check, MAX_WAYPOINTS};
use crate::plan::prepared::PreparedWaypoints;
use crate::planner::PlannerEntry;
use crate::robot::Robot;
use crate::scene::Scene;
use crate::trajectory::interpolation::interpolation;

/// How much further away paths keep where they can, m: as much may curves leave them.
const ROOMS_M: [f64; 2] = [5e-3, 1e-3];

/// Largest distance that can be asked for, m.
const MOST_CLEARANCE_M: f64 = 10.0;

/// A valid `motion` task.
pub(in crate::plan) struct PreparedMotion {
    pub robot: Arc<Robot>,
    pub checker: CollisionChecker,
    /// The same that keep further away, so that timing has room; the one that keeps furthest away first.
    pub roomy: Vec<CollisionChecker>,
    /// Start and goal.
    pub ends: [MotionEnd; 2],
    pub clearance_m: f64,
    pub planner: &'static PlannerEntry,
    pub settings: Settings,
    /// Random shortcuts that may fail in a row; none where the path is not smoothed.
    pub shortcuts: Option<u64>,
    /// How the path is timed; its waypoints stand for those to come.
    pub timing: PreparedWaypoints,
}

impl PreparedMotion {
    /// Planner and interpolation.
    pub fn method(&self) -> String {
        format!("{}/{}", self.planner.name, self.timing.interpolation.name)
    }
}

/// Checks the task at `/task`.
pub(in crate::plan) fn prepare(
    task: &MotionTask,
    robot: &Arc<Robot>,
    scene: &Scene,
    check: &Check,
    faults: &mut Faults,
) -> Option<PreparedMotion> {
    for (name, end) in [("start", &task.start), ("goal", &task.goal)] {
        check_end(end, robot, check, &format!("/task/{name}"), faults);
    }
    let sound = (0.0..=MOST_CLEARANCE_M).contains(&task.clearance_m);
    if !sound {
        let detail = format!("{} m is outside 0 to {MOST_CLEARANCE_M} m", task.clearance_m);
        faults.add("/task/clearance_m", detail);
    }
    let planner = check_planner(&task.planner, robot.dof(), faults);
    let shortcuts = check_smoothing(task, faults);
    let timing = check_timing(task, check, faults);
    let margin = if sound { task.clearance_m } else { 0.0 };
    let checker =
        |room: f64| CollisionChecker::new(robot, scene, margin + room, MotionCheck::Proven);
    let roomy: Result<Vec<_>, Faults> = ROOMS_M.into_iter().map(checker).collect();
    let checkers = match (checker(0.0), roomy) {
        (Ok(checker), Ok(roomy)) => Some((checker, roomy)),
        (Err(found), _) | (_, Err(found)) => {
            for fault in found.0 {
                let robots = ["/kinematics", "/geometry"].contains(&fault.pointer.as_str());
                let owner = if robots { "/robot" } else { "/scene" };
                faults.add(format!("{owner}{}", fault.pointer), fault.detail);
            }
            None
        }
    };
    let ((planner, settings), (checker, roomy)) = (planner?, checkers?);
    Some(PreparedMotion {
        robot: Arc::clone(robot),
        checker,
        roomy,
        ends: [task.start.clone(), task.goal.clone()],
        clearance_m: margin,
        planner,
        settings,
        shortcuts: shortcuts?,
        timing: timing?,
    })
}

fn check_end(end: &MotionEnd, robot: &Robot, check: &Check, pointer: &str, faults: &mut Faults) {
    match end {
        MotionEnd::Joints(joints) => {
            check.configuration(joints, &format!("{pointer}/joints"), faults)
        }
        MotionEnd::Pose(pose) => {
            check_pose(pose, &format!("{pointer}/pose"), "the tool", faults);
            if robot.inverse().is_none() {
                let detail = format!("a pose needs the kinematics of {}", robot.name());
                faults.add(pointer, detail);
            }
        }
    }
}

fn check_smoothing(task: &MotionTask, faults: &mut Faults) -> Option<Option<u64>> {
    let (name, given) = (&task.smoothing.name, &task.smoothing.parameters);
    match name.as_str() {
        "none" => {
            let none: [&'static crate::fault::parameter::Parameter; 0] = [];
            Settings::read("none", none.into_iter(), given, "/task/smoothing", faults);
            Some(None)
        }
        "shortcut" => {
            let settings = Settings::read(
                "shortcut",
                [&ATTEMPTS].into_iter(),
                given,
                "/task/smoothing",
                faults,
            );
            Some(Some(settings.integer("attempts")))
        }
        other => {
            let detail = format!(
                "a motion takes `shortcut` or `none`, not `{}`: its timing rounds the corners",
                escape(other)
            );
            faults.add("/task/smoothing/name", detail);
            None
        }
    }
}

/// Checks all that is said of timing, with two configurations in place of the path to come.
fn check_timing(
    task: &MotionTask,
    check: &Check,
    faults: &mut Faults,
) -> Option<PreparedWaypoints> {
    if let Some(entry) = interpolation(&task.interpolation)
        && (entry.max_segments.is_some_and(|most| most < MAX_WAYPOINTS - 1)
            || entry.min_segments > 1)
    {
        let detail = format!(
            "{} takes some numbers of waypoints only, and a path may have any; take jerk_limited or quintic",
            entry.name
        );
        faults.add("/task/interpolation", detail);
        return None;
    }
    let place = |share: f64| {
        let position = |limit: &crate::trajectory::JointBounds| {
            let lower = limit.lower.as_ref().map(|limit| limit.value);
            let upper = limit.upper.as_ref().map(|limit| limit.value);
            let lower = lower.unwrap_or_else(|| upper.unwrap_or(0.0) - 1.0);
            let upper = upper.unwrap_or(lower + 1.0);
            lower + share * (upper - lower)
        };
        check.limits.iter().map(position).collect::<Vec<f64>>()
    };
    check.waypoints(&task.through(vec![place(0.4), place(0.6)]), "/task", faults)
}
