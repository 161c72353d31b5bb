//! Plans part by part: short lists in one part, long ones through moving windows.
//!
//! A window ends at rest at its last waypoint. Only its first segments are kept; the next window
//! starts where they end, in motion, and looks as far ahead. So every kept segment is planned
//! with at least [`AHEAD`] segments behind it, and whatever is kept can always go on: at
//! worst as the window that it came from.

use crate::trajectory::kernel::KernelLimits;

use super::interior_point::{Settings, solve};
use super::layout::pose;
use super::newton::MAX_SEGMENTS;
use super::profile::{Motion, motion};
use super::refine::refine;
use super::stopping::stopping;

/// Segments that a window plans ahead of what is kept of it.
const AHEAD: usize = 6;

/// Cells per segment, at first and where it matters; if that fails, another division
/// leads along another path to the solution.
const CELLS: [[usize; 2]; 3] = [[12, 32], [20, 40], [32, 48]];

/// Barrier parameters at the start, at the refinement and at the end.
const BARRIER: [f64; 3] = [1e-2, 1e-5, 1e-7];

/// By how much a motion may pass a limit, as a factor of time, and still count as solved.
const NEARLY_LAWFUL: f64 = 1e-4;

/// A motion and how it was found.
pub struct Planned {
    pub motion: Motion,
    pub iterations: usize,
    pub converged: bool,
}

/// The fastest motion found along `ways[segment][joint]`, from rest to rest.
pub fn plan(ways: &[Vec<f64>], limits: &[KernelLimits]) -> Planned {
    let rest = vec![[0.0; 2]; limits.len()];
    let mut all = Planned {
        motion: Motion { durations: vec![], phases: vec![vec![]; limits.len()] },
        iterations: 0,
        converged: true,
    };
    let mut states = rest.clone();
    // What the last window planned beyond what was kept of it.
    let mut ahead: Option<Motion> = None;
    let mut first = 0;
    while first < ways.len() {
        let last = ways.len().min(first + MAX_SEGMENTS);
        let window = &ways[first..last];
        let (found, iterations) = attempt(window, limits, &states);
        all.iterations += iterations;
        let motion = match (found, ahead.take()) {
            (Some((found, converged)), _) => {
                all.converged &= converged;
                found
            }
            (None, Some(planned)) => {
                all.converged = false;
                planned
            }
            (None, None) => {
                all.converged = false;
                stopping(window, limits)
            }
        };
        let planned = motion.durations.len();
        let kept = if first + planned == ways.len() || planned <= AHEAD {
            planned
        } else {
            planned - AHEAD
        };
        let (keep, rest_of_it) = motion.split(kept);
        states = if kept == planned { rest.clone() } else { keep.end() };
        ahead = (kept < planned).then_some(rest_of_it);
        all.motion.append(keep);
        first += kept;
    }
    all
}

/// The best of what the divisions lead to, and whether it was solved to the end.
fn attempt(
    ways: &[Vec<f64>],
    limits: &[KernelLimits],
    states: &[[f64; 2]],
) -> (Option<(Motion, bool)>, usize) {
    let mut best: Option<Motion> = None;
    let mut steps = 0;
    for [coarse, fine] in CELLS {
        let settings = Settings { barrier: [BARRIER[0], BARRIER[1]], primal: 1.0, iterations: 150 };
        let (problem, mut point, units) = pose(ways, limits, states, coarse, BARRIER[0]);
        let first = solve(&problem, &mut point, &settings);
        steps += first.iterations;
        if !first.converged {
            continue;
        }
        let rough = motion(&problem, &point, &units);
        let (problem, mut point) = refine(&problem, &point, fine, BARRIER[1]);
        let settings = Settings { barrier: [BARRIER[1], BARRIER[2]], primal: 1e-9, iterations: 80 };
        let second = solve(&problem, &mut point, &settings);
        steps += second.iterations;
        for found in [motion(&problem, &point, &units), rough] {
            // A motion that starts at speed cannot simply be slowed down.
            let lawful = found.ratio(limits) <= 1.0 + NEARLY_LAWFUL;
            if lawful && best.as_ref().is_none_or(|best| found.duration() < best.duration()) {
                best = Some(found);
            }
        }
        if second.converged && best.is_some() {
            return (best.map(|best| (best, true)), steps);
        }
    }
    (best.map(|best| (best, false)), steps)
}
