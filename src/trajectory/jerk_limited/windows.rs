//! Plans part by part: short lists in one part, long ones through moving windows.
//!
//! A window ends at rest at its last waypoint, the last one as the goal demands. Only its first segments
//! are kept; the next window starts where they end, in motion, and looks as far ahead. So every kept segment
//! is planned with at least [`AHEAD`] segments behind it, and whatever is kept can always go on: at
//! worst as the window that it came from.

use crate::trajectory::Ends;
use crate::trajectory::kernel::KernelLimits;

use super::interior_point::{Settings, solve};
use super::layout::{follow, hasten, leads_to_goal, pose};
use super::problem::Window;
use super::profile::{Motion, motion};
use super::refine::refine;
use super::speeds::Bounds;
use super::stopping::stopping;
use super::work::MAX_SEGMENTS;
use super::{Part, Watch};

/// Segments that a window plans ahead of what is kept of it.
const AHEAD: usize = 6;

/// Among how many more segments the end of what is kept is chosen.
const CHOICE: usize = 3;

/// Cells per segment, at first and after each refinement. Where a division fails, the next
/// leads along another path to the solution.
const CELLS: [[usize; 3]; 4] = [[16, 32, 48], [24, 32, 48], [12, 32, 48], [32, 40, 48]];

/// Barrier parameters: at the start, and where each division is left.
const BARRIER: [f64; 4] = [1e-2, 1e-5, 1e-6, 1e-7];

/// Barrier parameter at the start where a part of the motion is known.
const WARM: f64 = 1e-3;

/// Most Newton steps with each division.
const STEPS: [usize; 3] = [150, 150, 60];

/// Divisions tried from a hasty start.
const HASTY: usize = 2;

/// Divisions that must have been solved before no other is tried.
const ENOUGH: usize = 2;

/// By how much a motion may pass a limit, as a factor of time, and still count as solved.
const NEARLY_LAWFUL: f64 = 1e-4;

/// A motion and how it was found.
pub struct Planned {
    pub motion: Motion,
    /// Newton steps.
    pub iterations: usize,
    pub converged: bool,
}

/// The fastest motion found along `part` within `limits`; the first window starts from `guess`, a lawful motion
/// along all or the first of the segments.
///
/// Once `watch` says that time is up, what is not yet planned stops at every waypoint.
pub fn plan(
    part: &Part,
    limits: &[KernelLimits],
    guess: Option<&Motion>,
    watch: &mut Watch,
) -> Planned {
    let (ways, bounds) = (part.ways, Bounds::new(limits, part.speeds));
    if ways.len() == 1 {
        // The closed form is the optimum.
        return Planned { motion: part.stops.clone(), iterations: 0, converged: true };
    }
    let mut all = Planned { motion: Motion::empty(limits.len()), iterations: 0, converged: true };
    let mut ends = part.ends.only(true, false);
    // By how much the next window starts off its first waypoint.
    let mut from = vec![0.0; limits.len()];
    // What the last window planned beyond what was kept of it.
    let mut ahead: Option<Motion> = guess.cloned();
    let mut first = 0;
    while first < ways.len() {
        if watch.is_over() {
            all.converged = false;
            let planned = ahead.as_ref().map_or(0, |ahead| ahead.durations.len());
            all.motion.append(ahead.unwrap_or_else(|| Motion::empty(limits.len())));
            all.motion.append(part.stops.segments(first + planned..ways.len()));
            break;
        }
        let last = ways.len().min(first + MAX_SEGMENTS);
        if last == ways.len() {
            ends.goal.clone_from(&part.ends.goal);
        }
        let (limits, rooms) = (bounds.from(first), part.rooms.between(first, last));
        let window = Window { ways: &ways[first..last], limits, rooms, ends: &ends, from: &from };
        let (found, iterations) = attempt(&window, ahead.as_ref(), watch);
        all.iterations += iterations;
        all.converged &= found.as_ref().is_some_and(|(_, converged)| *converged);
        let motion = match (found, ahead.take()) {
            (Some((found, _)), _) => found,
            (None, Some(planned)) => planned,
            (None, None) => part.stops.segments(first..last),
        };
        let planned = motion.durations.len();
        let kept = if first + planned == ways.len() { planned } else { keep(&motion, limits) };
        let (kept_part, others) = motion.split(kept);
        ends = Ends::at_rest(limits.len());
        if kept < planned {
            ends.start = kept_part.end();
        }
        from = others.deviations(0);
        all.motion.append(kept_part);
        first += kept;
        if kept < planned {
            watch.report(all.iterations, first, all.motion.duration(), &others);
            ahead = Some(others);
        }
    }
    all
}

/// How many segments of a window to keep: at least [`AHEAD`] remain, and the next
/// window starts where its first cell is least likely to pass a speed limit.
fn keep(motion: &Motion, limits: Bounds) -> usize {
    let planned = motion.durations.len();
    let mut best = (f64::NEG_INFINITY, planned);
    for kept in planned.saturating_sub(AHEAD + CHOICE).max(1)..=planned.saturating_sub(AHEAD) {
        let length = motion.durations[kept] / CELLS[0][0] as f64;
        let mut margin = f64::INFINITY;
        for (joint, phases) in motion.phases.iter().enumerate() {
            let [_, v, a, _] = phases[kept].first().map_or([0.0; 4], |phase| phase.state);
            let most = v.abs().max((v + 0.5 * length * a).abs());
            margin = margin.min((1.0 - most / limits.of(kept, joint)[0]).min(0.0));
        }
        if margin >= best.0 {
            best = (margin, kept);
        }
    }
    best.1
}

/// The best of what the divisions lead to, and whether it was solved to the end.
fn attempt(
    window: &Window,
    guess: Option<&Motion>,
    watch: &Watch,
) -> (Option<(Motion, bool)>, usize) {
    let Window { ways, limits, ends, .. } = *window;
    let mut best: Option<Motion> = None;
    let rests = ends.are_at_rest();
    let bound = if rests { stopping(ways, limits).duration() } else { f64::INFINITY };
    let mut steps = 0;
    let mut converged = false;
    // Ends in motion of which nothing is known are tried in haste first, and then not.
    let hasty = if rests || guess.is_some() { 0 } else { HASTY };
    let starts = CELLS[..hasty].iter().map(|cells| (*cells, true));
    for (cells, hastily) in starts.chain(CELLS.map(|cells| (cells, false))) {
        if hastily && best.is_some() {
            continue;
        }
        if watch.is_over() {
            break;
        }
        let (mut problem, mut point, units) = pose(window, cells[0], BARRIER[0]);
        if hastily && !hasten(&problem, &mut point, BARRIER[0]) {
            continue;
        }
        let mut barrier = BARRIER;
        if let Some(guess) = guess {
            let mut near = point.clone();
            if follow(&problem, &units, guess, &mut near, WARM) {
                point = near;
                barrier[0] = WARM;
            }
        }
        if !leads_to_goal(&problem, &point) {
            continue;
        }
        let mut solved = 0;
        for stage in 0..cells.len() {
            if stage > 0 {
                (problem, point) = refine(&problem, &point, cells[stage], BARRIER[stage]);
            }
            let outcome = solve(
                &problem,
                &mut point,
                &Settings {
                    barrier: [barrier[stage], barrier[stage + 1]],
                    primal: if stage + 1 < cells.len() { 1e-6 } else { 1e-13 },
                    iterations: STEPS[stage],
                },
            );
            steps += outcome.iterations;
            if !outcome.converged {
                break;
            }
            let mut found = motion(&problem, &point, &outcome.prices, &units);
            let ratio = found.ratio(limits);
            // A motion that starts or ends at speed cannot simply be slowed down.
            let lawful = if rests { ratio.is_finite() } else { ratio <= 1.0 + NEARLY_LAWFUL };
            if rests && lawful && ratio > 1.0 {
                found.stretch(ratio);
            }
            if lawful && best.as_ref().is_none_or(|best| found.duration() < best.duration()) {
                best = Some(found);
            } else if let Some(best) = &mut best {
                // The finer programme's multipliers are the better ones.
                (best.prices, best.gains) = (found.prices, found.gains);
            }
            solved += 1;
        }
        converged |= solved >= ENOUGH;
        // What is no faster than stopping everywhere may be a poor local optimum.
        let fast = best.as_ref().is_some_and(|best| best.duration() < bound);
        if converged && fast {
            break;
        }
    }
    (best.map(|best| (best, converged)), steps)
}
