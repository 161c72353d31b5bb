//! Spheres that stand for a solid: they cover it, and each knows how much of it surely is solid.

use nalgebra::Vector3;

use super::travel::Arms;
use crate::geometry::{Core, Solid, Transform};

type Point = Vector3<f64>;

/// A sphere in the frame of its solid's link.
#[derive(Clone, Copy, Debug)]
pub(super) struct CoverSphere {
    pub(super) center: Point,
    /// With the others it covers the solid.
    pub(super) outer: f64,
    /// As much around the centre lies within the solid; negative if the centre does not.
    pub(super) inner: f64,
    /// Of the sphere and of the part of the solid that it covers.
    pub(super) arms: Arms,
}

/// How far spheres may bulge from a long solid, as a share of its thickness.
const BULGE: f64 = 0.1;
/// Most parts along one axis.
const MAX_PARTS: usize = 16;

/// Spheres that cover `solid`: one for a sphere, a row along capsules and cylinders, a grid otherwise.
pub(super) fn cover(solid: &Solid) -> Vec<CoverSphere> {
    let (half, middle) = solid.core_box();
    // A part of half-length h bulges by sqrt(r² + h²) - r.
    let along = |thickness: f64, half_length: f64| {
        parts(half_length, thickness * ((1.0 + BULGE) * (1.0 + BULGE) - 1.0).sqrt())
    };
    let (counts, outer) = match &solid.core {
        Core::Point => ([1, 1, 1], solid.radius),
        Core::Segment { half_length } => {
            return row(solid, *half_length, along(solid.radius, *half_length));
        }
        Core::Cylinder { radius, half_length } => {
            let count = along(*radius, *half_length);
            let part = half_length / count as f64;
            ([1, 1, count], (radius * radius + part * part).sqrt())
        }
        Core::Box { .. } | Core::Hull { .. } => {
            let part = half.min().max(half.max() / MAX_PARTS as f64);
            let counts = [parts(half.x, part), parts(half.y, part), parts(half.z, part)];
            (counts, half.zip_map(&Point::from(counts.map(|n| n as f64)), |h, n| h / n).norm())
        }
    };
    let part = half.zip_map(&Point::from(counts.map(|count| count as f64)), |h, count| h / count);
    let spheres = cells(counts).map(|cell| {
        let steps = Point::from(cell.map(|index| (2 * index + 1) as f64));
        sphere(solid, middle - half + part.component_mul(&steps), outer)
    });
    // A grid around a hull has cells outside of it.
    spheres.filter(|sphere| sphere.inner >= -sphere.outer).collect()
}

/// A row along a capsule, its first and last sphere in the centres of the caps.
fn row(solid: &Solid, half_length: f64, parts: usize) -> Vec<CoverSphere> {
    let gap = 2.0 * half_length / parts as f64;
    let outer = (solid.radius * solid.radius + 0.25 * gap * gap).sqrt();
    let count = if half_length > 0.0 { parts + 1 } else { 1 };
    let local = |index: usize| Point::new(0.0, 0.0, index as f64 * gap - half_length);
    (0..count).map(|index| sphere(solid, local(index), outer)).collect()
}

/// The sphere around a point of the solid's own frame.
fn sphere(solid: &Solid, local: Point, outer: f64) -> CoverSphere {
    let center = solid.frame.point(&local);
    // What the sphere covers of a capsule is a shorter one, whose line reaches so far from the centre.
    let line = (outer * outer - solid.radius * solid.radius).max(0.0).sqrt();
    let (along, across) = match &solid.core {
        Core::Point => (0.0, 0.0),
        Core::Segment { .. } => (line, line * solid.frame.z.xy().norm()),
        _ => (outer, outer),
    };
    let arms = Arms { whole: center.norm() + along, about_axis: center.xy().norm() + across };
    CoverSphere { center, outer, inner: -solid.distance(&ball(center, 0.0)), arms }
}

fn parts(length: f64, part: f64) -> usize {
    ((length / part).ceil() as usize).clamp(1, MAX_PARTS)
}

fn cells([x, y, z]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..x).flat_map(move |i| (0..y).flat_map(move |j| (0..z).map(move |k| [i, j, k])))
}

/// A sphere as a solid.
pub(super) fn ball(center: Point, radius: f64) -> Solid {
    Solid { core: Core::Point, frame: Transform { origin: center, ..Transform::IDENTITY }, radius }
}

/// Sorts spheres into clusters of neighbours, and tells where each ends: halved along their longest extent until
/// at most [`CLUSTER`] are left.
pub(super) fn cluster<T>(spheres: &mut [T], center: &impl Fn(&T) -> Point) -> Vec<usize> {
    if spheres.len() <= CLUSTER {
        return vec![spheres.len()];
    }
    let infinite = Point::repeat(f64::INFINITY);
    let (low, high) = spheres
        .iter()
        .map(center)
        .fold((infinite, -infinite), |(low, high), p| (low.inf(&p), high.sup(&p)));
    let axis = (high - low).imax();
    spheres.sort_by(|a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    let half = spheres.len().div_ceil(2);
    let (left, right) = spheres.split_at_mut(half);
    let mut ends = cluster(left, center);
    ends.extend(cluster(right, center).into_iter().map(|end| half + end));
    ends
}

/// Most spheres in one cluster.
const CLUSTER: usize = 4;

/// A small sphere around all `spheres`: centre and radius.
///
/// Moves from the mean towards the furthest sphere in ever smaller steps.
/// Source: Bădoiu and Clarkson, 2003, doi:10.5555/644108.644240.
pub(super) fn enclose(spheres: impl Iterator<Item = CoverSphere> + Clone) -> (Point, f64) {
    let distance = |center: &Point, s: &CoverSphere| (s.center - center).norm() + s.outer;
    let furthest = |center: &Point| {
        let distances = spheres.clone().map(|s| (distance(center, &s), s.center));
        distances.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let count = spheres.clone().count().max(1) as f64;
    let mut center = spheres.clone().map(|sphere| sphere.center).sum::<Point>() / count;
    let (mut radius, mut towards) = furthest(&center);
    let mut best = (center, radius);
    for step in 1..=ENCLOSING_STEPS {
        center += (towards - center) / (step + 1) as f64;
        (radius, towards) = furthest(&center);
        if radius < best.1 {
            best = (center, radius);
        }
    }
    best
}

const ENCLOSING_STEPS: usize = 100;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Shape};
    use crate::math::random::RandomStream;

    fn solids() -> Vec<Solid> {
        let pose = Pose { position: [0.1, -0.2, 0.3], orientation: [0.5, -0.5, 0.1, 0.7] };
        let points = vec![[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.1, 0.1, 0.4]];
        [
            Shape::Sphere { radius: 0.1 },
            Shape::Capsule { radius: 0.05, length: 0.4 },
            Shape::Cylinder { radius: 0.05, length: 0.3 },
            Shape::Cylinder { radius: 0.2, length: 0.02 },
            Shape::Box { size: [0.3, 0.1, 0.05] },
            Shape::ConvexHull { points },
        ]
        .iter()
        .map(|shape| Solid::new(shape, &pose))
        .collect()
    }

    /// A point of the solid that no sphere covers could touch unseen; a point of an inner sphere outside of the solid
    /// would be a false alarm.
    #[test]
    fn spheres_cover_their_solid_and_their_insides_lie_within() {
        let mut random = RandomStream::new(3, 0);
        for solid in solids() {
            let spheres = cover(&solid);
            let (center, radius) = enclose(spheres.iter().copied());
            let mut inside = 0;
            for _ in 0..20_000 {
                let point = center + Point::from_fn(|_, _| random.uniform(-radius, radius));
                let depth = -solid.distance(&ball(point, 0.0));
                let away = |sphere: &CoverSphere| (sphere.center - point).norm();
                if depth >= 0.0 {
                    inside += 1;
                    assert!(
                        spheres.iter().any(|s| away(s) <= s.outer),
                        "{:?} at {point}",
                        solid.core
                    );
                    assert!((point - center).norm() <= radius);
                }
                if spheres.iter().any(|sphere| away(sphere) < sphere.inner) {
                    assert!(depth >= -1e-12, "{:?} at {point}", solid.core);
                }
            }
            assert!(inside > 100);
        }
    }
}
