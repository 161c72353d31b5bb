//! What a user asks for when planning the path of a point.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A box with obstacles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Space {
    /// Lower ends, one per coordinate; 2 to 12.
    #[schema(min_items = 2, max_items = 12)]
    pub lower: Vec<f64>,
    /// Upper ends, each above its lower end.
    #[schema(min_items = 2, max_items = 12)]
    pub upper: Vec<f64>,
    /// What stands in the way; to touch it is to hit it.
    #[serde(default)]
    pub obstacles: Vec<Obstacle>,
}

/// Something that stands in the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Obstacle {
    /// All points at most `radius` from `center`.
    Ball {
        /// The middle.
        center: Vec<f64>,
        /// The radius, not negative.
        radius: f64,
    },
    /// All points between two corners, with sides along the axes.
    Box {
        /// The corner with the smallest coordinates.
        lower: Vec<f64>,
        /// The corner with the largest coordinates.
        upper: Vec<f64>,
    },
}
