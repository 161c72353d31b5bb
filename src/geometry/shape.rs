//! The solids that robots and obstacles are made of.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Pose;

/// A solid around its own origin; lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", deny_unknown_fields, rename_all = "snake_case")]
pub enum Shape {
    /// All points within `radius` of the origin.
    Sphere {
        /// Positive.
        radius: f64,
    },
    /// All points within `radius` of a line along z, centred at the origin.
    Capsule {
        /// Positive.
        radius: f64,
        /// Of the line, without the caps; zero makes a sphere.
        length: f64,
    },
    /// Round, its axis along z, centred at the origin.
    Cylinder {
        /// Positive.
        radius: f64,
        /// From end to end.
        length: f64,
    },
    /// A box along the axes, centred at the origin.
    Box {
        /// Full extents along x, y and z.
        #[schema(min_items = 3, max_items = 3)]
        size: [f64; 3],
    },
    /// The convex hull of points.
    ConvexHull {
        /// At least four that do not lie in one plane.
        #[schema(min_items = 4)]
        points: Vec<[f64; 3]>,
    },
}

/// A shape where it stands, in a frame that its owner names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Placed {
    /// The solid.
    pub shape: Shape,
    /// Of the solid's origin and axes; default the identity.
    #[serde(default)]
    pub pose: Pose,
}
