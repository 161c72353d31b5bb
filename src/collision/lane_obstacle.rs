//! Obstacles as the kernel sees them: is a point within a distance of the solid, for many points at once.

use nalgebra::Vector3;

use crate::geometry::{Core, Solid};
use crate::math::singles::{Simd, SingleMask, SingleVector};

// What the kernel calls is inlined by force, and closures cannot be told: where one is left out, its arithmetic falls back to
// narrow registers and costs five times as much. So there are none here, nor in `lane_chain`.

/// An obstacle in single precision.
#[derive(Clone, Debug)]
pub(super) struct LaneObstacle {
    form: Form,
    /// Around the form, m.
    radius: f32,
    /// True if the form and its radius are the solid itself, false if they only hold it.
    pub(super) exact: bool,
    /// What rounding can make of a distance to it, for points within the extent it was built for, m.
    pub(super) slack: f32,
}

#[derive(Clone, Debug)]
enum Form {
    Point {
        center: [f32; 3],
    },
    Segment {
        center: [f32; 3],
        axis: [f32; 3],
        half_length: f32,
    },
    /// `axes` are the box's own in the world, `center` is the box's along them.
    Box {
        axes: [[f32; 3]; 3],
        center: [f32; 3],
        half_size: [f32; 3],
    },
    Cylinder {
        center: [f32; 3],
        axis: [f32; 3],
        half_length: f32,
        radius: f32,
    },
}

/// Three registers: the coordinates of points.
pub(super) type Points<S> = [SingleVector<S>; 3];

impl LaneObstacle {
    /// `solid` in the world, for points no further than `extent` from the origin.
    pub(super) fn new(solid: &Solid, extent: f64) -> Self {
        let single = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let center = single(&solid.frame.origin);
        let axis = single(&solid.frame.z);
        let form = match &solid.core {
            Core::Point => Form::Point { center },
            Core::Segment { half_length } => {
                Form::Segment { center, axis, half_length: *half_length as f32 }
            }
            Core::Cylinder { radius, half_length } => Form::Cylinder {
                center,
                axis,
                half_length: *half_length as f32,
                radius: *radius as f32,
            },
            Core::Box { .. } | Core::Hull { .. } => {
                let (half, middle) = solid.core_box();
                let middle = solid.frame.point(&middle);
                Form::Box {
                    axes: [single(&solid.frame.x), single(&solid.frame.y), single(&solid.frame.z)],
                    center: single(&solid.frame.inverse_direction(&middle)),
                    half_size: single(&half),
                }
            }
        };
        let exact = !matches!(solid.core, Core::Hull { .. });
        // Every coordinate comes from at most four fused steps on numbers up to the sum of both extents, and the
        // distance from three of them and one comparison of squares: fewer than 32 roundings of that size.
        let size = extent + solid.frame.origin.norm() + solid.reach();
        let slack = (32.0 * UNIT_ROUNDOFF * size) as f32;
        Self { form, radius: solid.radius as f32, exact, slack }
    }

    /// Where `points` are no further from the solid than `radius`, give or take the slack.
    #[inline(always)]
    pub(super) fn within<S: Simd>(
        &self,
        simd: S,
        points: &Points<S>,
        radius: SingleVector<S>,
    ) -> SingleMask<S> {
        let radius = radius + self.radius;
        let square = match &self.form {
            Form::Point { center } => squared(&from(points, center)),
            Form::Segment { center, axis, half_length } => {
                let away = from(points, center);
                let along = dot(&away, axis).at_least(-half_length).no_more_than(*half_length);
                squared(&across(&away, along, axis))
            }
            Form::Box { axes, center, half_size } => {
                let mut beyond = *points;
                for index in 0..3 {
                    let along = SingleVector::splat(simd, -center[index]);
                    let along = points[2].mul_add_number(axes[index][2], along);
                    let along = points[1].mul_add_number(axes[index][1], along);
                    let along = points[0].mul_add_number(axes[index][0], along);
                    beyond[index] = (along.abs() - half_size[index]).at_least(0.0);
                }
                squared(&beyond)
            }
            Form::Cylinder { center, axis, half_length, radius } => {
                let away = from(points, center);
                let along = dot(&away, axis);
                let sideways = squared(&across(&away, along, axis)).sqrt() - *radius;
                let (sideways, along) =
                    (sideways.at_least(0.0), (along.abs() - *half_length).at_least(0.0));
                along.mul_add(along, sideways * sideways)
            }
        };
        square.at_most(radius * radius)
    }
}

/// Half the distance from 1 to the next number in single precision.
pub(super) const UNIT_ROUNDOFF: f64 = 0.5 * f32::EPSILON as f64;

#[inline(always)]
fn from<S: Simd>(points: &Points<S>, center: &[f32; 3]) -> Points<S> {
    [points[0] - center[0], points[1] - center[1], points[2] - center[2]]
}

#[inline(always)]
fn dot<S: Simd>(away: &Points<S>, axis: &[f32; 3]) -> SingleVector<S> {
    let sum = away[1].mul_add_number(axis[1], away[2] * axis[2]);
    away[0].mul_add_number(axis[0], sum)
}

/// What is left of `away` without `along` times `axis`.
#[inline(always)]
fn across<S: Simd>(away: &Points<S>, along: SingleVector<S>, axis: &[f32; 3]) -> Points<S> {
    [
        along.mul_add_number(-axis[0], away[0]),
        along.mul_add_number(-axis[1], away[1]),
        along.mul_add_number(-axis[2], away[2]),
    ]
}

#[inline(always)]
pub(super) fn squared<S: Simd>(away: &Points<S>) -> SingleVector<S> {
    let sum = away[1].mul_add(away[1], away[2] * away[2]);
    away[0].mul_add(away[0], sum)
}
