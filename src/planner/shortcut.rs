//! Shorter paths from longer ones: corners are cut where the straight way is free.

use super::{ValidityChecker, distance};
use crate::budget::Budget;
use crate::math::random::RandomStream;

/// Cuts corners of a free path until `attempts` cuts in a row were blocked or
/// useless, or the budget ends it. Ends stay; the path stays free and never gets
/// longer.
///
/// First every corner that can be left out is, from the far end; then two points
/// anywhere on the path, drawn at random, are joined where the straight motion
/// between them is free (Geraerts and Overmars 2007,
/// doi:10.1177/0278364907079280).
pub fn shortcut<C: ValidityChecker>(
    path: &mut Vec<Vec<f64>>,
    checker: &mut C,
    attempts: u64,
    seed: u64,
    budget: &Budget,
) {
    leave_out(path, checker, budget);
    let mut random = RandomStream::new(seed, 0);
    let (mut failed, mut made) = (0, 0);
    while failed < attempts && path.len() > 2 && budget.stop_reason(made).is_none() {
        made += 1;
        failed = if cut(path, checker, &mut random) { 0 } else { failed + 1 };
        if made % 64 == 0 {
            leave_out(path, checker, budget);
        }
    }
    leave_out(path, checker, budget);
}

/// Most states up to which every later one is looked at.
const ALL: usize = 256;

/// Joins every state with the furthest later one in sight; on a long path with
/// one that is found by going twice as far each time.
fn leave_out<C: ValidityChecker>(path: &mut Vec<Vec<f64>>, checker: &mut C, budget: &Budget) {
    let mut kept: Vec<Vec<f64>> = Vec::new();
    let (mut at, last) = (0, path.len() - 1);
    while at < last && budget.stop_reason(0).is_none() {
        kept.push(std::mem::take(&mut path[at]));
        let mut sees = |to: usize| checker.is_motion_valid(&kept[kept.len() - 1], &path[to]);
        at = if last - at <= ALL {
            (at + 2..=last).rev().find(|&to| sees(to)).unwrap_or(at + 1)
        } else {
            let twice = (1..).map(|power| at + (1 << power));
            twice.take_while(|&to| to <= last && sees(to)).last().unwrap_or(at + 1)
        };
    }
    kept.extend(path.drain(at..));
    *path = kept;
}

/// Joins two random points of the path if that is free and worth it.
fn cut<C: ValidityChecker>(
    path: &mut Vec<Vec<f64>>,
    checker: &mut C,
    random: &mut RandomStream,
) -> bool {
    let whole = super::length(path);
    let mut places = [random.unit() * whole, random.unit() * whole];
    places.sort_unstable_by(f64::total_cmp);
    let [(first, from), (second, to)] = places.map(|place| point(path, place));
    if first == second || !is_worthwhile(path, (first, &from), (second, &to)) {
        return false;
    }
    // Rounding moves the points off the motions they are taken from.
    let is_free = checker.is_motion_valid(&path[first], &from)
        && checker.is_motion_valid(&from, &to)
        && checker.is_motion_valid(&to, &path[second + 1]);
    if is_free {
        path.splice(first + 1..=second, [from, to]);
    }
    is_free
}

/// Whether the straight way saves more than rounding.
fn is_worthwhile(path: &[Vec<f64>], first: (usize, &[f64]), second: (usize, &[f64])) -> bool {
    let ((first, from), (second, to)) = (first, second);
    let between = super::length(&path[first + 1..=second]);
    let old = distance(from, &path[first + 1]) + between + distance(&path[second], to);
    distance(from, to) < old * (1.0 - 1e-9)
}

/// The segment at a distance along the path, and the point there.
fn point(path: &[Vec<f64>], mut place: f64) -> (usize, Vec<f64>) {
    let last = path.len() - 2;
    for (segment, pair) in path.windows(2).enumerate() {
        let length = distance(&pair[0], &pair[1]);
        if place <= length || segment == last {
            let share = if length > 0.0 { (place / length).min(1.0) } else { 0.0 };
            let ends = pair[0].iter().zip(&pair[1]);
            return (segment, ends.map(|(from, to)| from + (to - from) * share).collect());
        }
        place -= length;
    }
    (last, path[last + 1].clone())
}
