//! What makes poses and shapes valid.

use nalgebra::Vector3;

use super::{Pose, Shape};
use crate::fault::Faults;

/// Beyond this a length is surely not in metres.
const MAX_LENGTH_M: f64 = 1000.0;
/// Below this an extent is surely not meant: a micrometre.
const MIN_EXTENT_M: f64 = 1e-6;
/// How far from 1 the norm of a quaternion may be.
const NORM_TOLERANCE: f64 = 1e-6;
/// More points than this make a hull too slow to check.
const MAX_HULL_POINTS: usize = 10_000;

/// What is wrong with a length in m, if anything is: it must be finite and within ±1000 m.
pub fn length_problem(value: f64) -> Option<String> {
    if !value.is_finite() {
        Some("must be a finite number".to_owned())
    } else if value.abs() > MAX_LENGTH_M {
        Some(format!("must be within ±{MAX_LENGTH_M} m; are these millimetres?"))
    } else {
        None
    }
}

/// Adds what is wrong with `pose`, which stands at `pointer` and is `name`'s.
pub fn check_pose(pose: &Pose, pointer: &str, name: &str, faults: &mut Faults) {
    for (index, &value) in pose.position.iter().enumerate() {
        if let Some(problem) = length_problem(value) {
            faults.add(
                format!("{pointer}/position/{index}"),
                format!("position {value} m of {name} {problem}"),
            );
        }
    }
    let norm = pose.orientation.iter().map(|component| component * component).sum::<f64>().sqrt();
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        faults.add(
            format!("{pointer}/orientation"),
            format!(
                "quaternion {:?} of {name} has norm {norm}, but must have norm 1 within {NORM_TOLERANCE:e}",
                pose.orientation
            ),
        );
    }
}

/// Adds what is wrong with `shape`, which stands at `pointer` and is `name`'s.
pub fn check_shape(shape: &Shape, pointer: &str, name: &str, faults: &mut Faults) {
    let mut extent = |field: &str, value: f64, least: f64| {
        if let Some(problem) = extent_problem(value, least) {
            let word = field.split('/').next().unwrap_or(field);
            let detail = format!("{word} {value} m of {name} {problem}");
            faults.add(format!("{pointer}/{field}"), detail);
        }
    };
    match shape {
        Shape::Sphere { radius } => extent("radius", *radius, MIN_EXTENT_M),
        Shape::Capsule { radius, length } => {
            extent("radius", *radius, MIN_EXTENT_M);
            extent("length", *length, 0.0);
        }
        Shape::Cylinder { radius, length } => {
            extent("radius", *radius, MIN_EXTENT_M);
            extent("length", *length, MIN_EXTENT_M);
        }
        Shape::Box { size } => {
            for (axis, &value) in size.iter().enumerate() {
                extent(&format!("size/{axis}"), value, MIN_EXTENT_M);
            }
        }
        Shape::ConvexHull { points } => check_hull(points, pointer, name, faults),
    }
}

fn extent_problem(value: f64, least: f64) -> Option<String> {
    length_problem(value).or_else(|| {
        let small = value < least;
        small.then(|| match least {
            0.0 => "must not be negative".to_owned(),
            _ => format!("must be positive, at least {least:e} m"),
        })
    })
}

fn check_hull(points: &[[f64; 3]], pointer: &str, name: &str, faults: &mut Faults) {
    let pointer = format!("{pointer}/points");
    let count = points.len();
    if !(4..=MAX_HULL_POINTS).contains(&count) {
        let detail = format!("{count} points of {name}, but must be 4 to {MAX_HULL_POINTS}");
        faults.add(pointer, detail);
        return;
    }
    let mut usable = true;
    for (index, point) in points.iter().enumerate() {
        for (axis, &value) in point.iter().enumerate() {
            if let Some(problem) = length_problem(value) {
                usable = false;
                let detail = format!("coordinate {value} m of {name} {problem}");
                faults.add(format!("{pointer}/{index}/{axis}"), detail);
            }
        }
    }
    if usable && thickness(points) < MIN_EXTENT_M {
        let detail = format!("the points of {name} lie in one plane; a hull needs a volume");
        faults.add(pointer, detail);
    }
}

/// How far the points leave a plane that is laid through three of them, far from each other.
fn thickness(points: &[[f64; 3]]) -> f64 {
    let points = || points.iter().map(|&point| Vector3::from(point));
    let furthest = |measure: &dyn Fn(&Vector3<f64>) -> f64| {
        points().max_by(|a, b| measure(a).total_cmp(&measure(b))).unwrap_or_default()
    };
    let first = points().next().unwrap_or_default();
    let second = furthest(&|p| (p - first).norm());
    let along = (second - first).try_normalize(0.0).unwrap_or_default();
    let third = furthest(&|p| (p - first).cross(&along).norm());
    let normal = (third - first).cross(&along).try_normalize(0.0).unwrap_or_default();
    let fourth = furthest(&|p| (p - first).dot(&normal).abs());
    (fourth - first).dot(&normal).abs()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn faults_of(value: serde_json::Value) -> Faults {
        let shape: Shape = serde_json::from_value(value).unwrap();
        let mut faults = Faults::default();
        check_shape(&shape, "/obstacles/3/shape", "obstacle \"table\"", &mut faults);
        faults
    }

    #[test]
    fn each_fault_is_found_where_it_is_and_named() {
        let tetrahedron = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        for valid in [
            json!({"type": "sphere", "radius": 0.1}),
            json!({"type": "capsule", "radius": 0.1, "length": 0}),
            json!({"type": "convex_hull", "points": tetrahedron}),
        ] {
            assert!(faults_of(valid).is_empty());
        }
        let square = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]];
        for (value, pointer, words) in [
            (json!({"type": "sphere", "radius": 0}), "/shape/radius", "radius 0 m"),
            (json!({"type": "sphere", "radius": -1}), "/shape/radius", "must be positive"),
            (json!({"type": "sphere", "radius": 2000}), "/shape/radius", "millimetres"),
            (json!({"type": "capsule", "radius": 1, "length": -0.5}), "/shape/length", "negative"),
            (json!({"type": "cylinder", "radius": 1, "length": 0}), "/shape/length", "positive"),
            (json!({"type": "box", "size": [1, 0, 1]}), "/shape/size/1", "size 0 m"),
            (json!({"type": "convex_hull", "points": square}), "/shape/points", "one plane"),
            (json!({"type": "convex_hull", "points": [[0, 0, 0]]}), "/shape/points", "1 points"),
        ] {
            let faults = faults_of(value);
            assert_eq!(faults.0.len(), 1, "{faults}");
            assert_eq!(faults.0[0].pointer, format!("/obstacles/3{pointer}"), "{faults}");
            assert!(faults.0[0].detail.contains(words), "{faults}");
            assert!(faults.0[0].detail.contains("\"table\""), "{faults}");
        }
    }

    #[test]
    fn numbers_that_json_cannot_write_are_refused_as_well() {
        let mut faults = Faults::default();
        let shape = Shape::Box { size: [f64::NAN, f64::INFINITY, 1.0] };
        check_shape(&shape, "", "it", &mut faults);
        assert_eq!(faults.0.len(), 2, "{faults}");
        let pose = Pose { position: [0.0, f64::NAN, 0.0], orientation: [0.0; 4] };
        check_pose(&pose, "/pose", "it", &mut faults);
        assert_eq!(faults.0.len(), 4, "{faults}");
    }
}
