//! Solids ready for distances.

use std::sync::Arc;

use nalgebra::Vector3;

use super::closest::Segment;
use super::gjk;
use super::{Pose, Shape, Transform};

type Point = Vector3<f64>;

/// What a solid is drawn around: all points within its radius of its core.
///
/// Cores are centred in their own frame, lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// The origin.
    Point,
    /// Along z.
    Segment {
        /// Half the length.
        half_length: f64,
    },
    /// Along the axes.
    Box {
        /// Half the extents.
        half_size: Vector3<f64>,
    },
    /// Round about z.
    Cylinder {
        /// Of the round.
        radius: f64,
        /// Half the length along z.
        half_length: f64,
    },
    /// The convex hull of points.
    Hull {
        /// At least four.
        points: Arc<[Point]>,
    },
}

/// A core in a place, with a radius around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// The shape without its radius.
    pub core: Core,
    /// Of the core, in the frame of whoever holds the solid.
    pub frame: Transform,
    /// Around the core, m.
    pub radius: f64,
}

impl Solid {
    /// A valid shape with its origin and axes at `pose`.
    pub fn new(shape: &Shape, pose: &Pose) -> Self {
        let frame = Transform::from(pose);
        let (core, radius) = match shape {
            Shape::Sphere { radius } => (Core::Point, *radius),
            Shape::Capsule { radius, length } => {
                (Core::Segment { half_length: 0.5 * length }, *radius)
            }
            Shape::Cylinder { radius, length } => {
                (Core::Cylinder { radius: *radius, half_length: 0.5 * length }, 0.0)
            }
            Shape::Box { size } => (Core::Box { half_size: Point::from(*size) * 0.5 }, 0.0),
            Shape::ConvexHull { points } => (
                Core::Hull { points: points.iter().map(|&point| Point::from(point)).collect() },
                0.0,
            ),
        };
        Self { core, frame, radius }
    }

    /// The same solid, its frame given in the outer one.
    pub fn moved(&self, outer_from_frame: &Transform) -> Self {
        Self { frame: *outer_from_frame * self.frame, ..self.clone() }
    }

    /// The distance of two solids in the same frame, m; not positive where they touch or overlap.
    ///
    /// Exact to rounding while their cores are apart, and for spheres in boxes and cylinders as well. Otherwise,
    /// where cores overlap, they are at least as deep in each other as told.
    pub fn distance(&self, other: &Self) -> f64 {
        self.core_distance(other) - self.radius - other.radius
    }

    fn core_distance(&self, other: &Self) -> f64 {
        match (self.segment(), other.segment()) {
            (Some(own), Some(others)) => own.distance_to_segment(&others),
            (Some(_), None) if other.has_projection() => self.distance_to_box_or_round(other),
            (None, Some(_)) if self.has_projection() => other.distance_to_box_or_round(self),
            _ => gjk::distance_from_origin(|along| self.support(along) - other.support(&-along)),
        }
    }

    /// The core as a segment, where it is one or a point.
    fn segment(&self) -> Option<Segment> {
        let half_length = match self.core {
            Core::Point => 0.0,
            Core::Segment { half_length } => half_length,
            _ => return None,
        };
        let half = self.frame.z * half_length;
        Some(Segment { start: self.frame.origin - half, along: half * 2.0 })
    }

    fn has_projection(&self) -> bool {
        matches!(self.core, Core::Box { .. } | Core::Cylinder { .. })
    }

    /// From this point or segment to a box or a cylinder.
    fn distance_to_box_or_round(&self, other: &Self) -> f64 {
        let half = match self.core {
            Core::Segment { half_length } => {
                other.frame.inverse_direction(&self.frame.z) * half_length
            }
            _ => Point::zeros(),
        };
        let center = other.frame.inverse_point(&self.frame.origin);
        match (&self.core, &other.core) {
            (Core::Point, Core::Box { half_size }) => to_box(&center, half_size),
            (Core::Point, Core::Cylinder { radius, half_length }) => {
                to_cylinder(&center, *radius, *half_length)
            }
            (_, Core::Box { half_size }) => Segment { start: center - half, along: half * 2.0 }
                .distance_to_convex(|point| point.sup(&-half_size).inf(half_size)),
            (_, Core::Cylinder { radius, half_length }) => {
                Segment { start: center - half, along: half * 2.0 }
                    .distance_to_convex(|point| onto_cylinder(point, *radius, *half_length))
            }
            // `has_projection` lets nothing else through; this would be right for it, too.
            _ => gjk::distance_from_origin(|along| self.support(along) - other.support(&-along)),
        }
    }

    /// The core's furthest point along `along`.
    fn support(&self, along: &Point) -> Point {
        let local = self.frame.inverse_direction(along);
        let furthest = match &self.core {
            Core::Point => Point::zeros(),
            Core::Segment { half_length } => Point::z() * half_length.copysign(local.z),
            Core::Box { half_size } => half_size.zip_map(&local, f64::copysign),
            Core::Cylinder { radius, half_length } => {
                let norm = local.xy().norm();
                let round = if norm > 0.0 { local.xy() * (radius / norm) } else { local.xy() };
                Point::new(round.x, round.y, half_length.copysign(local.z))
            }
            Core::Hull { points } => *points
                .iter()
                .max_by(|a, b| a.dot(&local).total_cmp(&b.dot(&local)))
                .unwrap_or(&self.frame.origin),
        };
        self.frame.point(&furthest)
    }

    /// The half extents and the centre of the smallest box along the frame's axes that holds the core, both in the
    /// core's own frame.
    pub fn core_box(&self) -> (Vector3<f64>, Vector3<f64>) {
        match &self.core {
            Core::Point => (Point::zeros(), Point::zeros()),
            Core::Segment { half_length } => (Point::z() * *half_length, Point::zeros()),
            Core::Box { half_size } => (*half_size, Point::zeros()),
            Core::Cylinder { radius, half_length } => {
                (Point::new(*radius, *radius, *half_length), Point::zeros())
            }
            Core::Hull { points } => {
                let infinite = Point::repeat(f64::INFINITY);
                let (low, high) = points
                    .iter()
                    .fold((infinite, -infinite), |(low, high), p| (low.inf(p), high.sup(p)));
                ((high - low) * 0.5, (high + low) * 0.5)
            }
        }
    }

    /// A radius about the frame's origin within which all of the solid lies, m.
    pub fn reach(&self) -> f64 {
        let core = match &self.core {
            Core::Cylinder { radius, half_length } => {
                (radius * radius + half_length * half_length).sqrt()
            }
            Core::Hull { points } => points.iter().map(Point::norm).fold(0.0, f64::max),
            _ => self.core_box().0.norm(),
        };
        core + self.radius
    }
}

/// Signed distance of `point` to the surface of a box about the origin.
fn to_box(point: &Point, half_size: &Point) -> f64 {
    let beyond = point.abs() - half_size;
    let inside = beyond.max().min(0.0);
    beyond.sup(&Point::zeros()).norm() + inside
}

/// Signed distance of `point` to the surface of a cylinder about the origin.
fn to_cylinder(point: &Point, radius: f64, half_length: f64) -> f64 {
    let (sideways, along) = (point.xy().norm() - radius, point.z.abs() - half_length);
    Point::new(sideways.max(0.0), along.max(0.0), 0.0).norm() + sideways.max(along).min(0.0)
}

fn onto_cylinder(point: &Point, radius: f64, half_length: f64) -> Point {
    let norm = point.xy().norm();
    let shrink = if norm > radius { radius / norm } else { 1.0 };
    Point::new(point.x * shrink, point.y * shrink, point.z.clamp(-half_length, half_length))
}
