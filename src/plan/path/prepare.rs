//! Checks what a request for a path means.

use super::request::{Obstacle, PathTask, PlannerChoice, SmoothingChoice, Space};
use super::smoothing::{SmoothingEntry, smoothing, smoothing_names};
use crate::fault::parameter::Settings;
use crate::fault::{Faults, escape};
use crate::planner::{PlannerEntry, PlanningProblem, auto, planner, planner_names};

/// Dimensions of a space.
const DIMENSIONS: std::ops::RangeInclusive<usize> = 2..=12;

/// Most obstacles of a space.
const MAX_OBSTACLES: usize = 10_000;

/// Largest coordinate and radius: beyond it rounding is visible.
const LARGEST: f64 = 1e9;

/// Smallest side of a space.
const SMALLEST_SIDE: f64 = 1e-9;

/// How long an iteration takes, roughly, s.
const ITERATION_S: f64 = 4e-6;

/// A valid `path` task.
pub(in crate::plan) struct PreparedPath {
    pub problem: PlanningProblem,
    pub space: Space,
    pub planner: &'static PlannerEntry,
    pub settings: Settings,
    pub smoothing: &'static SmoothingEntry,
    pub smoothing_settings: Settings,
    pub trees: bool,
}

impl PreparedPath {
    /// Roughly how long planning takes on one core, s.
    pub fn estimate_s(&self) -> f64 {
        if !self.planner.anytime {
            return 1e-3;
        }
        let estimate = self.settings.get("iterations") * ITERATION_S;
        estimate.min(self.settings.optional("time_limit_s").unwrap_or(f64::INFINITY))
    }

    /// Planner and smoothing.
    pub fn method(&self) -> String {
        format!("{}/{}", self.planner.name, self.smoothing.name)
    }
}

/// Checks the task at `/task`.
pub(in crate::plan) fn prepare(task: &PathTask, faults: &mut Faults) -> Option<PreparedPath> {
    let PathTask { space, start, goal, .. } = task;
    check_space(space, faults);
    for (name, end) in [("start", start), ("goal", goal)] {
        check_end(space, name, end, faults);
    }
    let dimension = space.lower.len();
    let planner = check_planner(&task.planner, dimension, faults);
    let smoothing = check_smoothing(&task.smoothing, faults);
    let ((planner, settings), (smoothing, smoothing_settings)) = (planner?, smoothing?);
    let problem = PlanningProblem {
        lower: space.lower.clone(),
        upper: space.upper.clone(),
        start: start.clone(),
        goal: goal.clone(),
    };
    let (space, trees) = (space.clone(), task.trees);
    Some(PreparedPath { problem, space, planner, settings, smoothing, smoothing_settings, trees })
}

fn check_space(space: &Space, faults: &mut Faults) {
    let (dimension, place) = (space.lower.len(), "/task/space");
    if !DIMENSIONS.contains(&dimension) {
        let (least, most) = (DIMENSIONS.start(), DIMENSIONS.end());
        let detail = format!("{dimension} coordinates; a space has {least} to {most}");
        faults.add(format!("{place}/lower"), detail);
    }
    check_point(&space.lower, dimension, &format!("{place}/lower"), faults);
    check_point(&space.upper, dimension, &format!("{place}/upper"), faults);
    for (axis, (lower, upper)) in space.lower.iter().zip(&space.upper).enumerate() {
        // No number is below none.
        if upper - lower < SMALLEST_SIDE {
            let detail = format!(
                "coordinate {axis}: {upper} is not above the lower end {lower} by {SMALLEST_SIDE:e}"
            );
            faults.add(format!("{place}/upper/{axis}"), detail);
        }
    }
    let count = space.obstacles.len();
    if count > MAX_OBSTACLES {
        let detail = format!("{count} obstacles; at most {MAX_OBSTACLES} are taken");
        faults.add(format!("{place}/obstacles"), detail);
        return;
    }
    for (index, obstacle) in space.obstacles.iter().enumerate() {
        check_obstacle(obstacle, dimension, &format!("{place}/obstacles/{index}"), faults);
    }
}

fn check_obstacle(obstacle: &Obstacle, dimension: usize, place: &str, faults: &mut Faults) {
    match obstacle {
        Obstacle::Ball(ball) => {
            check_point(&ball.center, dimension, &format!("{place}/center"), faults);
            if !(0.0..=LARGEST).contains(&ball.radius) {
                let detail = format!("radius {} is outside 0 to {LARGEST:e}", ball.radius);
                faults.add(format!("{place}/radius"), detail);
            }
        }
        Obstacle::Box(block) => {
            check_point(&block.lower, dimension, &format!("{place}/lower"), faults);
            check_point(&block.upper, dimension, &format!("{place}/upper"), faults);
            for (axis, (lower, upper)) in block.lower.iter().zip(&block.upper).enumerate() {
                if upper < lower {
                    let detail =
                        format!("coordinate {axis}: {upper} is below the lower end {lower}");
                    faults.add(format!("{place}/upper/{axis}"), detail);
                }
            }
        }
    }
}

/// Number and values of coordinates.
fn check_point(point: &[f64], dimension: usize, place: &str, faults: &mut Faults) {
    if point.len() != dimension {
        let found = point.len();
        faults.add(place, format!("{found} coordinates; the space's lower end has {dimension}"));
    }
    for (axis, value) in point.iter().enumerate() {
        if !value.is_finite() || value.abs() > LARGEST {
            let detail = format!("coordinate {axis}: {value:e} is no number within ±{LARGEST:e}");
            faults.add(format!("{place}/{axis}"), detail);
        }
    }
}

fn check_end(space: &Space, name: &str, end: &[f64], faults: &mut Faults) {
    let place = format!("/task/{name}");
    let before = faults.0.len();
    check_point(end, space.lower.len(), &place, faults);
    if faults.0.len() > before {
        return;
    }
    let ends = space.lower.iter().zip(&space.upper);
    for (axis, (value, (lower, upper))) in end.iter().zip(ends).enumerate() {
        if !(lower..=upper).contains(&value) {
            let detail = format!(
                "coordinate {axis} of the {name}: {value} is outside the space, {lower} to {upper}"
            );
            faults.add(format!("{place}/{axis}"), detail);
        }
    }
}

/// The planner that was chosen, for `dimension` coordinates, with its parameters.
pub(in crate::plan) fn check_planner(
    choice: &PlannerChoice,
    dimension: usize,
    faults: &mut Faults,
) -> Option<(&'static PlannerEntry, Settings)> {
    let PlannerChoice { name, parameters } = choice;
    let found = if name == "auto" { Some(auto(dimension)) } else { planner(name) };
    let Some(entry) = found else {
        let (name, known) = (escape(name), planner_names());
        let detail = format!("no planner is called `{name}`; known: auto, {known}");
        faults.add("/task/planner/name", detail);
        return None;
    };
    Some((entry, entry.settings(parameters, "/task/planner", faults)))
}

fn check_smoothing(
    choice: &SmoothingChoice,
    faults: &mut Faults,
) -> Option<(&'static SmoothingEntry, Settings)> {
    let SmoothingChoice { name, parameters } = choice;
    let Some(entry) = smoothing(name) else {
        let (name, known) = (escape(name), smoothing_names());
        let detail = format!("no smoothing is called `{name}`; known: {known}");
        faults.add("/task/smoothing/name", detail);
        return None;
    };
    let declared = entry.parameters.iter();
    let settings = Settings::read(entry.name, declared, parameters, "/task/smoothing", faults);
    if settings.optional("degree") == Some(4.0) {
        faults.add("/task/smoothing/degree", "degree is 4; known: 2, 3, 5");
    }
    Some((entry, settings))
}
