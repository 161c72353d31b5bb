//! Distances of two solids.

use parry3d_f64::math::{Pose as ParryPose, Vector};
use takt::geometry::{Pose, Shape, Solid};
use takt::math::random::RandomStream;

use crate::reference::{self, parry_pose, random_pose, random_shape};

/// The reference is iterative and stops up to some 1e-5 above the truth.
const REFERENCE_ERROR: f64 = 5e-5;

#[test]
fn distances_of_all_pairs_of_shapes_agree() {
    let mut random = RandomStream::new(11, 0);
    let (mut apart, mut touching) = (0, 0);
    for case in 0..20_000 {
        let (a, b) = (case % 5, case / 5 % 5);
        let shapes = [random_shape(&mut random, a, 0.5), random_shape(&mut random, b, 0.5)];
        let poses = [random_pose(&mut random, 0.5), random_pose(&mut random, 0.5)];
        let own = Solid::new(&shapes[0], &poses[0]).distance(&Solid::new(&shapes[1], &poses[1]));
        let identity = ParryPose::identity();
        let expected = reference::Solid::new(&shapes[0], &poses[0]).distance(
            &identity,
            &reference::Solid::new(&shapes[1], &poses[1]),
            &identity,
        );
        let off = own.max(0.0) - expected;
        assert!(
            (-REFERENCE_ERROR..1e-9).contains(&off),
            "{own} is not {expected}: {shapes:?} {poses:?}"
        );
        if expected > 0.0 { apart += 1 } else { touching += 1 }
    }
    assert!(apart > 5000 && touching > 1000, "{apart} {touching}");
}

/// From a capsule's line the reference measures points in closed form; the least of them is sought here by golden section.
fn least_along(capsule: (&Shape, &Pose), other: &reference::Solid) -> f64 {
    let (Shape::Capsule { radius, length }, pose) = capsule else { panic!("a capsule") };
    let frame = parry_pose(pose);
    let point = Shape::Sphere { radius: *radius };
    let ball = reference::Solid::new(&point, &Pose::default());
    let at = |share: f64| {
        let along = Vector::new(0.0, 0.0, (share - 0.5) * length);
        let frame = frame * ParryPose::from_translation(along);
        ball.distance(&frame, other, &ParryPose::identity())
    };
    let golden = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..80 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if at(a) < at(b) { high = b } else { low = a }
    }
    at(0.5 * (low + high)).min(at(0.0)).min(at(1.0))
}

#[test]
fn capsules_are_exact_to_rounding() {
    let mut random = RandomStream::new(12, 0);
    for case in 0..4000 {
        let (line, other) =
            (random_shape(&mut random, 1, 0.5), random_shape(&mut random, case, 0.5));
        if matches!(other, Shape::ConvexHull { .. } | Shape::Capsule { .. }) {
            continue;
        }
        let poses = [random_pose(&mut random, 0.6), random_pose(&mut random, 0.6)];
        let own = Solid::new(&line, &poses[0]).distance(&Solid::new(&other, &poses[1]));
        let expected = least_along((&line, &poses[0]), &reference::Solid::new(&other, &poses[1]));
        assert!(
            (own.max(0.0) - expected).abs() < 1e-9,
            "{own} is not {expected}: {line:?} {other:?}"
        );
    }
}

#[test]
fn two_capsules_are_exact_to_rounding_even_where_nearly_parallel() {
    let mut random = RandomStream::new(13, 0);
    for case in 0..4000 {
        let shapes = [random_shape(&mut random, 1, 0.5), random_shape(&mut random, 1, 0.5)];
        let poses = [random_pose(&mut random, 0.6), random_pose(&mut random, 0.6)];
        let mut poses = poses;
        if case % 2 == 0 {
            let tilt = random.uniform(0.0, 1.0).powi(8) * 1e-3;
            poses[1].orientation = poses[0].orientation;
            poses[1].orientation[case % 3] += tilt;
            let norm = poses[1].orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
            poses[1].orientation.iter_mut().for_each(|component| *component /= norm);
        }
        let own = Solid::new(&shapes[0], &poses[0]).distance(&Solid::new(&shapes[1], &poses[1]));
        // Of two lines, each point of one is measured against the other in closed form.
        let Shape::Capsule { radius, length } = &shapes[1] else { panic!("a capsule") };
        let frame = parry_pose(&poses[1]);
        let ends = [-0.5, 0.5].map(|end| frame * Vector::new(0.0, 0.0, end * length));
        let segment = parry3d_f64::shape::Segment::new(ends[0], ends[1]);
        let Shape::Capsule { radius: own_radius, length: own_length } = &shapes[0] else {
            panic!("a capsule")
        };
        let own_frame = parry_pose(&poses[0]);
        let at = |share: f64| {
            let point = own_frame * Vector::new(0.0, 0.0, (share - 0.5) * own_length);
            let nearest =
                parry3d_f64::query::PointQuery::project_local_point(&segment, point, true);
            (nearest.point - point).length()
        };
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..80 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if at(a) < at(b) { high = b } else { low = a }
        }
        let expected = at(0.5 * (low + high)).min(at(0.0)).min(at(1.0)) - radius - own_radius;
        assert!((own - expected).abs() < 1e-9, "{own} is not {expected}");
    }
}

/// Projecting to and fro comes down to the distance, and each projection is the reference's, in closed form.
#[test]
fn cylinders_and_boxes_are_exact_to_rounding() {
    let mut random = RandomStream::new(14, 0);
    let (mut worst, mut compared) = (0.0f64, 0);
    for case in 0..400 {
        let shapes =
            [2 + case % 2, 2 + case / 2 % 2].map(|kind| random_shape(&mut random, kind, 0.4));
        let poses = [random_pose(&mut random, 0.7), random_pose(&mut random, 0.7)];
        let own = Solid::new(&shapes[0], &poses[0]).distance(&Solid::new(&shapes[1], &poses[1]));
        let solids = [0, 1].map(|index| reference::Solid::new(&shapes[index], &poses[index]));
        let mut points = [Vector::ZERO; 2];
        let mut before = f64::INFINITY;
        for step in 0..20_000 {
            points[step % 2] = solids[step % 2].nearest(points[(step + 1) % 2]);
            let found = (points[0] - points[1]).length();
            // Slow ones say nothing.
            if step % 1000 == 999 && found == before {
                worst = worst.max((found - own.max(0.0)).abs());
                compared += 1;
                break;
            }
            before = found;
        }
        let found = (points[0] - points[1]).length();
        assert!(own <= found + 1e-9, "{own} is more than {found}");
    }
    assert!(worst < 1e-9 && compared > 200, "{worst:e} of {compared}");
}
