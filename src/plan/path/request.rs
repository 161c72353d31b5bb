//! What a user asks for when planning the path of a point.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::fault::{Faults, read};
use crate::plan::request::take_type;

/// Find a short way for a point in a box of 2 to 12 dimensions that touches no
/// obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PathTask {
    /// Where the point may be and what stands in its way.
    pub space: Space,
    /// Where the path begins, one number per coordinate.
    pub start: Vec<f64>,
    /// Where it ends.
    pub goal: Vec<f64>,
    /// Planner by registry name, with its parameters.
    pub planner: PlannerChoice,
    /// Smoothing by registry name, with its parameters.
    pub smoothing: SmoothingChoice,
    /// True keeps what the planner grew, for pictures.
    pub trees: bool,
}

/// A box with obstacles, in any unit of length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Space {
    /// Lower ends, one per coordinate; 2 to 12.
    #[schema(min_items = 2, max_items = 12)]
    pub lower: Vec<f64>,
    /// Upper ends, each above its lower end.
    #[schema(min_items = 2, max_items = 12)]
    pub upper: Vec<f64>,
    /// What stands in the way, at most 10,000; to touch it is to hit it.
    #[serde(default)]
    #[schema(max_items = 10_000)]
    pub obstacles: Vec<Obstacle>,
}

/// Something that stands in the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Obstacle {
    /// All points at most a radius from a centre.
    Ball(BallObstacle),
    /// All points between two corners.
    Box(BoxObstacle),
}

/// All points at most `radius` from `center`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BallObstacle {
    /// The middle, one number per coordinate.
    pub center: Vec<f64>,
    /// The radius, not negative.
    #[schema(minimum = 0.0)]
    pub radius: f64,
}

/// All points between two corners, with sides along the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxObstacle {
    /// The corner with the smallest coordinates.
    pub lower: Vec<f64>,
    /// The corner with the largest coordinates.
    pub upper: Vec<f64>,
}

/// A planner and its parameters, as its registry entry lists them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PlannerChoice {
    /// Registry name; `auto` takes what measures best.
    pub name: String,
    /// Parameters that differ from their defaults.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

impl Default for PlannerChoice {
    fn default() -> Self {
        Self { name: "auto".to_owned(), parameters: BTreeMap::new() }
    }
}

/// A smoothing and its parameters, as its registry entry lists them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SmoothingChoice {
    /// Registry name.
    pub name: String,
    /// Parameters that differ from their defaults.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Value>,
}

impl Default for SmoothingChoice {
    fn default() -> Self {
        Self { name: "shortcut".to_owned(), parameters: BTreeMap::new() }
    }
}

impl PathTask {
    /// Reads the task that stands at `pointer`.
    pub(in crate::plan) fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            space: Value,
            start: Vec<f64>,
            goal: Vec<f64>,
            #[serde(default)]
            planner: PlannerChoice,
            #[serde(default)]
            smoothing: SmoothingChoice,
            #[serde(default)]
            trees: bool,
        }
        let Raw { space, start, goal, planner, smoothing, trees } = read(value, pointer, faults)?;
        let space = Space::parse(space, &format!("{pointer}/space"), faults)?;
        Some(Self { space, start, goal, planner, smoothing, trees })
    }
}

impl Space {
    fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            lower: Vec<f64>,
            upper: Vec<f64>,
            #[serde(default)]
            obstacles: Vec<Value>,
        }
        let Raw { lower, upper, obstacles } = read(value, pointer, faults)?;
        let count = obstacles.len();
        // Each is read on its own, so that the faults of all are found.
        let obstacles = obstacles.into_iter().enumerate();
        let obstacles: Vec<Obstacle> = obstacles
            .filter_map(|(index, value)| {
                Obstacle::parse(value, &format!("{pointer}/obstacles/{index}"), faults)
            })
            .collect();
        (obstacles.len() == count).then_some(Self { lower, upper, obstacles })
    }
}

impl Obstacle {
    fn parse(mut value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        match take_type(&mut value, pointer, "an obstacle", faults)?.as_str() {
            "ball" => read(value, pointer, faults).map(Self::Ball),
            "box" => read(value, pointer, faults).map(Self::Box),
            other => {
                let detail = format!("unknown obstacle `{other}`; known: ball, box");
                faults.add(format!("{pointer}/type"), detail);
                None
            }
        }
    }
}
