//! Finer cells where a finer curve would gain, and nowhere else.
//!
//! The optimum's jerk is one of a few values and switches between them. A cell in
//! which it switches shows a value between those of its neighbours. Such cells are
//! halved, so the old curve stays a point of the new programme, inside all limits.

use crate::math::lanes::{Lanes, WIDTH};

use super::berths::raise_multipliers;
use super::layout::{before, slack, start_of};
use super::problem::{Cell, Iterate, Problem};

/// A piece of an old cell.
#[derive(Clone, Copy)]
struct Slice {
    /// The old cell, counted in its segment.
    parent: usize,
    /// Where the slice starts and ends in the old cell, as shares of it.
    from: f64,
    to: f64,
    /// What halving it promises.
    gain: f64,
}

/// The same problem and point with `cells` cells per segment, more than before.
pub fn refine(problem: &Problem, point: &Iterate, cells: usize, mu: f64) -> (Problem, Iterate) {
    let (n, k) = (problem.segments, problem.cells);
    let groups = problem.groups.len();
    let mut shares = vec![Lanes([1.0 / cells as f64; WIDTH]); groups * n * cells];
    let mut fine = vec![Cell::ZERO; groups * n * cells];
    let mut slices: Vec<Slice> = Vec::with_capacity(cells);
    for group in 0..groups {
        for lane in 0..WIDTH {
            for segment in 0..n {
                cut(problem, point, group, segment, lane, cells, &mut slices);
                for (q, slice) in slices.iter().enumerate() {
                    let to = (group * n + segment) * cells + q;
                    let from = (group * n + segment) * k + slice.parent;
                    shares[to].0[lane] = problem.shares[from].0[lane] * (slice.to - slice.from);
                    copy(
                        problem,
                        point,
                        group,
                        segment * k + slice.parent,
                        lane,
                        slice,
                        &mut fine[to],
                    );
                }
            }
        }
    }
    let refined = Problem { cells, shares, ..problem.clone() };
    let mut at = Iterate { cells: fine, ..point.clone() };
    // A multiplier that is new, or too small for its slack, starts on the central path.
    let all = n * cells;
    for index in 0..at.cells.len() {
        for lane in 0..WIDTH {
            let g = slack(&refined, &at, index / all, index % all, lane);
            for (z, g) in at.cells[index].z.iter_mut().zip(g) {
                z.0[lane] = z.0[lane].max(mu / g);
            }
        }
    }
    raise_multipliers(&refined, &mut at, mu);
    (refined, at)
}

/// Divides one joint's segment into `cells` slices.
fn cut(
    problem: &Problem,
    point: &Iterate,
    group: usize,
    segment: usize,
    lane: usize,
    cells: usize,
    slices: &mut Vec<Slice>,
) {
    let k = problem.cells;
    let all = problem.segments * k;
    let jerk = |q: usize| {
        let [t, _, a] = before(problem, point, group, segment * k + q, lane);
        let end = point.cells[group * all + segment * k + q].s[2].0[lane];
        if problem.groups[group].smooth.0[lane] > 0.0 { (end - a) / t } else { end }
    };
    slices.clear();
    let mut previous = jerk(0);
    let mut this = previous;
    for q in 0..k {
        let next = if q + 1 < k { jerk(q + 1) } else { this };
        let share = problem.shares[(group * problem.segments + segment) * k + q].0[lane];
        let turn = if q == 0 {
            (next - this).abs()
        } else if q + 1 == k {
            (this - previous).abs()
        } else {
            (next - this).abs().min((this - previous).abs())
        };
        // What the value can reach in the cell: its limit, unless a lower derivative has one
        // that it would pass.
        let t = share * point.durations[segment];
        let [_, acceleration, jerk] = problem.groups[group].limits.map(|l| l.0[lane]);
        let velocity = problem.speeds[group * problem.segments + segment][0].0[lane];
        let most = if problem.groups[group].smooth.0[lane] > 0.0 {
            jerk.min(acceleration / t).min(velocity / (t * t))
        } else {
            acceleration.min(velocity / t)
        };
        let relative = turn / most;
        slices.push(Slice {
            parent: q,
            from: 0.0,
            to: 1.0,
            gain: (relative + 1e-3) * share * share,
        });
        (previous, this) = (this, next);
    }
    // The middles of the first and the last cell are not held to the speed limit. Where one passes it, its
    // parts might, too.
    let limit = problem.speeds[group * problem.segments + segment][0].0[lane];
    for (q, given) in [(0, segment == 0), (k - 1, segment + 1 == problem.segments)] {
        let [t, v, a] = before(problem, point, group, segment * k + q, lane);
        let middle = v + 0.5 * problem.groups[group].smooth.0[lane] * t * a;
        if given && middle.abs() > limit {
            slices[q].gain = 0.0;
        }
    }
    while slices.len() < cells {
        let mut best = 0;
        for (index, slice) in slices.iter().enumerate() {
            if slice.gain > slices[best].gain {
                best = index;
            }
        }
        let slice = &mut slices[best];
        let middle = 0.5 * (slice.from + slice.to);
        slice.gain *= 0.25;
        let second = Slice { from: middle, ..*slice };
        slice.to = middle;
        slices.insert(best + 1, second);
    }
}

/// The state at the end of a slice and its multipliers.
fn copy(
    problem: &Problem,
    point: &Iterate,
    group: usize,
    c: usize,
    lane: usize,
    slice: &Slice,
    fine: &mut Cell,
) {
    let all = problem.segments * problem.cells;
    let old = &point.cells[group * all + c];
    let whole = slice.to == 1.0;
    if whole {
        for e in 0..3 {
            fine.s[e].0[lane] = old.s[e].0[lane];
        }
    } else {
        let [t, v, a] = before(problem, point, group, c, lane);
        let x = start_of(problem, point, group, c, lane);
        let end = old.s[2].0[lane];
        let u = slice.to * t;
        if problem.groups[group].smooth.0[lane] > 0.0 {
            let j = (end - a) / t;
            fine.s[0].0[lane] = x + u * (v + u * (a / 2.0 + u * j / 6.0));
            fine.s[1].0[lane] = v + u * (a + u * j / 2.0);
            fine.s[2].0[lane] = a + u * j;
        } else {
            fine.s[0].0[lane] = x + u * (v + u * end / 2.0);
            fine.s[1].0[lane] = v + u * end;
            fine.s[2].0[lane] = end;
        }
    }
    for r in 0..8 {
        let kept = r < 2 || (r < 6 && whole);
        fine.z[r].0[lane] = if kept { old.z[r].0[lane] } else { 0.0 };
    }
}
