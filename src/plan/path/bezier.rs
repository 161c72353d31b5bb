//! Paths whose corners are Bezier curves.
//!
//! A corner `P` is replaced by a curve from `A` on the side before it to `B` on
//! the side after it, each a share of its side away from `P`. It touches both
//! sides; where nothing is cut, the straight sides remain.
//!
//! Zhang et al. 2023, doi:10.3390/act12120459, whose text contradicts itself on the degree. Offered:
//!
//! - 2: control points `A`, `P`, `B`. With half of each side cut everywhere, the
//!   quadratic B-spline of the corners.
//! - 3: `A`, `A + k (P - A)`, `B + k (P - B)`, `B`; with `k = 2/3` the curve of degree 2,
//!   sharper for larger `k`.
//! - 5: as 3, with the points half way to the inner ones between: curvature is
//!   zero at both ends, so it is continuous along the whole path.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::smoothing::{ATTEMPTS, Smoothed};
use super::space::PointSpace;
use crate::budget::Budget;
use crate::fault::parameter::{Parameter, Settings, flag, integer, real};
use crate::planner::{distance, shortcut};

/// One piece of a curve: `sum_i C(n, i) u^i (1 - u)^(n - i) P_i` for `u` from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BezierPiece {
    /// The control points `P_0` to `P_n`; two of them are a straight line.
    pub control_points: Vec<Vec<f64>>,
}

pub(super) const PARAMETERS: &[Parameter] = &[
    integer("degree", "2, 3 or 5; with 5 curvature is continuous; default 3", 3.0, 2.0, 5.0),
    real(
        "cut",
        "share of a side that is cut at a corner, halved down to 0.05 where the curve is not \
         free; default 0.5",
        0.5,
        SMALLEST_CUT,
        0.5,
    ),
    real(
        "sharpness",
        "how far inner control points of degrees 3 and 5 lie towards the corner; default 2/3, \
         which makes degree 3 the curve of degree 2",
        2.0 / 3.0,
        0.01,
        1.0,
    ),
    flag("shortcut", "take shortcuts first; default true", true),
    ATTEMPTS,
];

/// Below this share a corner stays one.
const SMALLEST_CUT: f64 = 0.05;

/// Halvings of a curve after which it counts as blocked.
const DEEPEST: u32 = 10;

/// Halvings of a curve at least, so that its points draw it well.
const SHALLOWEST: u32 = 3;

pub(super) fn smooth(
    settings: &Settings,
    space: &mut PointSpace,
    path: &[Vec<f64>],
    seed: u64,
    budget: &Budget,
) -> Option<Smoothed> {
    let mut path = path.to_vec();
    if settings.flag("shortcut") {
        shortcut(&mut path, space, settings.integer("attempts"), seed, budget);
    }
    let shape = Shape {
        degree: settings.integer("degree"),
        sharpness: settings.get("sharpness"),
        cut: settings.get("cut"),
    };
    let mut smoothed = Smoothed { path: vec![path[0].clone()], curve: None, length: 0.0 };
    let mut pieces = Vec::new();
    for corner in 1..path.len() - 1 {
        let corner = &path[corner - 1..=corner + 1];
        if budget.stop_reason(0).is_none() {
            shape.round(corner, space, &mut smoothed, &mut pieces);
        } else {
            straight(corner[1].clone(), &mut smoothed, &mut pieces);
        }
    }
    straight(path[path.len() - 1].clone(), &mut smoothed, &mut pieces);
    smoothed.curve = Some(pieces);
    Some(smoothed)
}

struct Shape {
    degree: u64,
    sharpness: f64,
    cut: f64,
}

impl Shape {
    /// Adds the straight way to a corner's curve and the curve, or the way to the
    /// corner.
    fn round(
        &self,
        corner: &[Vec<f64>],
        space: &PointSpace,
        smoothed: &mut Smoothed,
        pieces: &mut Vec<BezierPiece>,
    ) {
        let mut cut = self.cut;
        while cut >= SMALLEST_CUT {
            let points = self.control_points(corner, cut);
            let mut leaves = Vec::new();
            let last = &smoothed.path[smoothed.path.len() - 1];
            // Rounding moves the ends off the sides they lie on.
            let sides_are_free = space.is_motion_clear(last, &points[0], 0.0)
                && space.is_motion_clear(&points[points.len() - 1], &corner[2], 0.0);
            if sides_are_free && is_curve_free(&points, space, 0, &mut leaves) {
                straight(points[0].clone(), smoothed, pieces);
                for leaf in &leaves {
                    smoothed.length += arc_length(leaf);
                    smoothed.path.push(leaf[leaf.len() - 1].clone());
                }
                pieces.push(BezierPiece { control_points: points });
                return;
            }
            cut *= 0.5;
        }
        straight(corner[1].clone(), smoothed, pieces);
    }

    fn control_points(&self, corner: &[Vec<f64>], cut: f64) -> Vec<Vec<f64>> {
        let [before, corner, after] = corner else { return Vec::new() };
        let (a, b) = (between(corner, before, cut), between(corner, after, cut));
        let k = self.sharpness;
        let (towards_a, towards_b) = (between(&a, corner, k), between(&b, corner, k));
        match self.degree {
            2 => vec![a, corner.clone(), b],
            3 => vec![a, towards_a, towards_b, b],
            _ => {
                let (half_a, half_b) = (between(&a, &towards_a, 0.5), between(&b, &towards_b, 0.5));
                vec![a, half_a, towards_a, towards_b, half_b, b]
            }
        }
    }
}

/// Adds the straight way to a point, unless it is there already.
fn straight(to: Vec<f64>, smoothed: &mut Smoothed, pieces: &mut Vec<BezierPiece>) {
    let from = &smoothed.path[smoothed.path.len() - 1];
    if *from != to {
        smoothed.length += distance(from, &to);
        pieces.push(BezierPiece { control_points: vec![from.clone(), to.clone()] });
        smoothed.path.push(to);
    }
}

/// Whether no obstacle touches a curve, with the parts of it for which that is
/// proven: a curve lies within the hull of its control points, so it is as near
/// to its chord as they are. A part that is not far enough from obstacles is
/// halved; one that is still not after many halvings counts as blocked.
fn is_curve_free(
    points: &[Vec<f64>],
    space: &PointSpace,
    depth: u32,
    leaves: &mut Vec<Vec<Vec<f64>>>,
) -> bool {
    let [first, .., last] = points else { return false };
    if depth >= SHALLOWEST {
        let offs = points.iter().map(|point| distance_to_segment(point, first, last));
        if space.is_motion_clear(first, last, offs.fold(0.0, f64::max)) {
            leaves.push(points.to_vec());
            return true;
        }
    }
    if depth == DEEPEST {
        return false;
    }
    let [left, right] = halves(points);
    is_curve_free(&left, space, depth + 1, leaves)
        && is_curve_free(&right, space, depth + 1, leaves)
}

/// Both halves of a curve (de Casteljau).
fn halves(points: &[Vec<f64>]) -> [Vec<Vec<f64>>; 2] {
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let mut row = points.to_vec();
    while let [first, .., last] = &row[..] {
        left.push(first.clone());
        right.push(last.clone());
        row = row.windows(2).map(|pair| between(&pair[0], &pair[1], 0.5)).collect();
    }
    left.extend(row.iter().cloned());
    right.extend(row);
    right.reverse();
    [left, right]
}

/// Length of a short part of a curve, from chord and control polygon
/// (Gravesen 1997, doi:10.1016/S0925-7721(95)00054-2).
fn arc_length(points: &[Vec<f64>]) -> f64 {
    let degree = (points.len() - 1) as f64;
    let chord = distance(&points[0], &points[points.len() - 1]);
    (2.0 * chord + (degree - 1.0) * crate::planner::length(points)) / (degree + 1.0)
}

fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + (to - from) * share).collect()
}

fn distance_to_segment(point: &[f64], from: &[f64], to: &[f64]) -> f64 {
    let along: f64 = from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum();
    let ends = point.iter().zip(from.iter().zip(to));
    let share: f64 = ends.map(|(p, (a, b))| (p - a) * (b - a)).sum::<f64>();
    let share = if along > 0.0 { (share / along).clamp(0.0, 1.0) } else { 0.0 };
    distance(point, &between(from, to, share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::path::request::{BallObstacle, Obstacle, Space};
    use crate::plan::path::smoothing::smoothing;

    fn value(points: &[Vec<f64>], u: f64) -> Vec<f64> {
        let mut row = points.to_vec();
        while row.len() > 1 {
            row = row.windows(2).map(|pair| between(&pair[0], &pair[1], u)).collect();
        }
        row.swap_remove(0)
    }

    fn smoothed(degree: u32, balls: &[([f64; 2], f64)]) -> (Vec<BezierPiece>, Smoothed) {
        let ball = |&([x, y], radius): &([f64; 2], f64)| {
            Obstacle::Ball(BallObstacle { center: vec![x, y], radius })
        };
        let space = Space {
            lower: vec![0.0; 2],
            upper: vec![10.0; 2],
            obstacles: balls.iter().map(ball).collect(),
        };
        let path = [vec![0.0, 0.0], vec![8.0, 0.0], vec![8.0, 8.0], vec![2.0, 10.0]];
        let entry = smoothing("bezier").unwrap();
        let given = [("degree", degree.into()), ("shortcut", false.into())];
        let given = given.map(|(name, value): (_, serde_json::Value)| (name.to_owned(), value));
        let parameters = entry.parameters.iter();
        let mut faults = crate::fault::Faults::default();
        let settings = Settings::read("bezier", parameters, &given.into(), "", &mut faults);
        let mut space = PointSpace::new(&space);
        let smoothed = entry.apply(&settings, &mut space, &path, 0, &Budget::default()).unwrap();
        (smoothed.curve.clone().unwrap(), smoothed)
    }

    /// Half of a side can be cut, less of it, or, with another ball next to the
    /// corner, nothing.
    #[test]
    fn curves_keep_off_obstacles_and_join_smoothly() {
        for degree in [2, 3, 5] {
            let mut lengths = Vec::new();
            let balls = [([6.0, 2.0], 0.1), ([6.0, 2.0], 1.9), ([7.7, 0.3], 0.29)];
            for balls in [&balls[..1], &balls[1..2], &balls[1..]] {
                let (pieces, smoothed) = smoothed(degree, balls);
                let mut before: Option<(Vec<f64>, Vec<f64>)> = None;
                let mut sum = 0.0;
                for piece in &pieces {
                    let points = &piece.control_points;
                    let count = 2000;
                    let mut last = points[0].clone();
                    for step in 1..=count {
                        let at = value(points, f64::from(step) / f64::from(count));
                        for (center, radius) in balls {
                            assert!(distance(&at, center) > *radius, "{degree} {radius} {at:?}");
                        }
                        sum += distance(&last, &at);
                        last = at;
                    }
                    let tangent = |from: &[f64], to: &[f64]| -> Vec<f64> {
                        let step = distance(from, to);
                        from.iter().zip(to).map(|(a, b)| (b - a) / step).collect()
                    };
                    let arrival = tangent(&points[points.len() - 2], &points[points.len() - 1]);
                    if let Some((end, direction)) = &before {
                        assert_eq!(end, &points[0]);
                        let turn = distance(direction, &tangent(&points[0], &points[1]));
                        assert!(
                            turn < 1e-12 || (balls.len() == 2 && turn > 1.0),
                            "{degree} {turn}"
                        );
                    }
                    before = Some((points[points.len() - 1].clone(), arrival));
                }
                assert!((smoothed.length / sum - 1.0).abs() < 1e-4, "{} {sum}", smoothed.length);
                lengths.push(smoothed.length);
            }
            assert!(lengths[1] > lengths[0] && lengths[2] > lengths[1], "{lengths:?}");
        }
    }

    #[test]
    fn two_thirds_make_the_cubic_a_quadratic() {
        let (quadratic, _) = smoothed(2, &[]);
        let (cubic, _) = smoothed(3, &[]);
        let at = |pieces: &[BezierPiece]| value(&pieces[1].control_points, 0.3);
        assert!(distance(&at(&quadratic), &at(&cubic)) < 1e-12);
    }
}
