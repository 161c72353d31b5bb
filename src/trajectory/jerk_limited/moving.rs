//! Ends in motion: where a robot is re-planned on the fly, or hands over at speed.
//!
//! Between two waypoints the closed form of [`state_to_state`](super::state_to_state) is the
//! optimum. Through more, [`states`](super::states) finds motions on either side of the gaps that lie next to such
//! ends, and the programme starts from each of them. Of a long list only the segments next to the ends are planned so;
//! the others are planned from rest to rest, and there all waypoints are met exactly even where there is room.
//!
//! A motion that starts or ends at speed cannot be stretched, because its ends would change with it: one that passes a
//! limit by rounding is planned again within limits that are as much tighter.

use crate::budget::Budget;
use crate::trajectory::Ends;
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::rooms::Rooms;

use super::profile::Motion;
use super::speeds::Bounds;
use super::state_to_state::{State, StateFault, between};
use super::states::search;
use super::windows::{self, Planned};
use super::work::MAX_SEGMENTS;
use super::{Demand, Fastest, Part, Stage, Watch, layout, one_way, stopped, ways};

/// What rounding may add to a limit, as a factor of time.
const ROUNDING: f64 = 1e-10;

/// How often limits are tightened before a programme is given up.
const TIGHTENINGS: usize = 3;

/// How much tighter than necessary limits become, as a factor of time.
const MARGIN: f64 = 1e-7;

/// Accelerations below this share of their limit are rounding.
const NOISE: f64 = 1e-9;

/// Segments next to an end in motion of a long list that are planned at once.
const NEAR: usize = 8;

/// A programme whose solution is within this of the motion it started from tells what limits hold that back.
const ALIKE: f64 = 1e-3;

/// The fastest trajectory found that begins and ends in the motion that `demand` asks for, as far as `budget` allows; otherwise as [`super::fastest_within`].
///
/// With two waypoints its duration is the least possible, and with more the lower bound is zero: none
/// is proven. On segments next to an end in motion positions may have to leave
/// their limits; nothing is said about that here.
///
/// # Errors
///
/// All that is wrong with the states at the ends.
pub fn fastest_between(
    demand: &Demand,
    budget: &Budget,
    tell: &mut dyn FnMut(Stage),
) -> Result<Fastest, Vec<StateFault>> {
    let waypoints = demand.waypoints;
    let limited = |limit: &KernelLimits| limit.derivatives[1..].iter().any(|l| l.is_finite());
    let proves = waypoints.len() == 2 && demand.limits.iter().all(limited);
    let limits = layout::effective(&ways(waypoints), demand.limits);
    let demand = Demand { limits: &limits, ..*demand };
    let rest = Ends::at_rest(limits.len());
    let stops = stops(waypoints, &limits, demand.ends.unwrap_or(&rest))?;
    let plan = one_way(&demand, &stops, budget, 0, tell);
    let lower = if proves { plan.motion.duration() } else { 0.0 };
    Ok(plan.finished(waypoints, lower))
}

/// The motion that stops at every waypoint between the ends.
fn stops(
    waypoints: &[Vec<f64>],
    limits: &[KernelLimits],
    ends: &Ends,
) -> Result<Motion, Vec<StateFault>> {
    let [moves_off, arrives] = ends.rests().map(|rests| !rests);
    let (ways, last) = (ways(waypoints), waypoints.len() - 2);
    let mut motion = Motion::empty(limits.len());
    for segment in 0..=last {
        let (first, last) = (segment == 0, segment == last);
        let next = if first && moves_off || last && arrives {
            let own = ends.only(first, last);
            let [from, to] = [(&own.start, segment), (&own.goal, segment + 1)]
                .map(|(end, at)| states(end, &waypoints[at]));
            between(&from, &to, limits)?
        } else {
            stopped(&ways[segment..=segment], Bounds::everywhere(limits))
        };
        motion.append(next);
    }
    Ok(motion)
}

fn states(end: &[[f64; 2]], positions: &[f64]) -> Vec<State> {
    let state = |([velocity, acceleration], position): (&[f64; 2], &f64)| State {
        position: *position,
        velocity: *velocity,
        acceleration: *acceleration,
    };
    end.iter().zip(positions).map(state).collect()
}

/// The fastest motion found along `part`, which moves at an end.
pub fn plan(part: &Part, watch: &mut Watch) -> Planned {
    match part.ways.len() {
        1 => Planned { motion: part.stops.clone(), iterations: 0, converged: true },
        2..=MAX_SEGMENTS => at_once(part, watch),
        _ => near_ends(part, watch),
    }
}

/// The fastest of what programmes lead to that start from the motions searched, and of these themselves;
/// one within the position limits, if there is any.
fn at_once(part: &Part, watch: &mut Watch) -> Planned {
    let mut best = Planned { motion: part.stops.clone(), iterations: 0, converged: false };
    let (mut iterations, mut leaves) = (0, true);
    let guesses = search(part, None, watch).into_iter().map(Some);
    // The last programme starts in haste, where many joints have to pass a waypoint together.
    for guess in guesses.chain([None]) {
        let mut planned = solved(part, guess.as_ref(), watch);
        iterations += planned.iterations;
        let duration = planned.motion.duration();
        if let Some(mut motion) = guess.filter(|guess| guess.duration() < duration) {
            // A programme knows jerk cell by cell and may miss a little of what is exact here.
            if planned.converged && duration < motion.duration() * (1.0 + ALIKE) {
                (motion.prices, motion.gains) = (planned.motion.prices, planned.motion.gains);
            }
            planned.motion = motion;
        }
        let outside = !planned.motion.stops_within(part.waypoints, part.limits).is_empty();
        let faster = planned.motion.duration() < best.motion.duration();
        if leaves && !outside || faster && leaves == outside {
            (best, leaves) = (planned, outside);
            watch.report(iterations, 0, 0.0, &best.motion);
        }
    }
    Planned { iterations, ..best }
}

/// What a programme leads to from `guess` that keeps its limits as it is; else the guess itself, or stops.
fn solved(part: &Part, guess: Option<&Motion>, watch: &mut Watch) -> Planned {
    let mut limits = part.limits.to_vec();
    let (mut slower, mut iterations) = (1.0, 0);
    for _ in 0..TIGHTENINGS {
        let planned = windows::plan(part, &limits, guess, watch);
        iterations += planned.iterations;
        let ratio = planned.motion.ratio(Bounds::everywhere(part.limits));
        if ratio <= 1.0 + ROUNDING {
            return Planned { iterations, ..planned };
        }
        slower *= ratio * (1.0 + MARGIN);
        let joints = part.limits.iter().enumerate();
        limits = joints.map(|(joint, limit)| tightened(limit, &part.ends, joint, slower)).collect();
    }
    Planned { motion: guess.unwrap_or(&part.stops).clone(), iterations, converged: false }
}

/// The limits of a motion `slower` times as slow, but none that an end of `joint` does not keep.
fn tightened(limit: &KernelLimits, ends: &Ends, joint: usize, slower: f64) -> KernelLimits {
    let [velocity, acceleration, jerk] = limit.derivatives;
    let mut needed = [0.0f64; 2];
    for ([v, a], sign) in [(ends.start[joint], 1.0), (ends.goal[joint], -1.0)] {
        // What velocity is where acceleration is zero.
        let carried = v + sign * a * a.abs() / (2.0 * jerk);
        needed = [needed[0].max(v.abs()).max(carried.abs()), needed[1].max(a.abs())];
    }
    let derivatives = [
        (velocity / slower).max(needed[0]).min(velocity),
        (acceleration / (slower * slower)).max(needed[1]).min(acceleration),
        jerk / (slower * slower * slower),
    ];
    KernelLimits { derivatives, position: limit.position }
}

/// Makes the acceleration of `joint` zero where `motion` starts or ends, if it is less than `least`: two motions
/// that meet there agree then on what is only rounding.
fn settle(motion: &mut Motion, joint: usize, at_end: bool, least: f64) {
    let segments = &mut motion.phases[joint];
    let segment = if at_end { segments.last_mut() } else { segments.first_mut() };
    let phase =
        segment.and_then(|phases| if at_end { phases.last_mut() } else { phases.first_mut() });
    let Some(phase) = phase else { return };
    let [_, _, from, jerk] = phase.state;
    let to = from + jerk * phase.length;
    if (if at_end { to } else { from }).abs() < least {
        let [from, to] = if at_end { [from, 0.0] } else { [0.0, to] };
        (phase.state[2], phase.state[3]) = (from, (to - from) / phase.length);
    }
}

/// A long list: from rest to rest first, and then next to every end in motion anew, between that end and
/// the state at a waypoint near it.
fn near_ends(part: &Part, watch: &mut Watch) -> Planned {
    let (segments, limits) = (part.ways.len(), part.limits);
    let rest = Part {
        rooms: Rooms::none(),
        ends: Ends::at_rest(limits.len()),
        stops: stopped(part.ways, Bounds::everywhere(limits)),
        ..*part
    };
    let to_go = watch.to_go.clone();
    let mut silent = Watch { tell: &mut |_| {}, to_go, ..*watch };
    let mut all = windows::plan(&rest, limits, None, &mut silent);
    all.motion.stretch(all.motion.ratio(Bounds::everywhere(limits)));
    let [moves_off, arrives] = part.ends.rests().map(|rests| !rests);
    for (moves, near) in [(moves_off, 0..NEAR), (arrives, segments - NEAR..segments)] {
        if !moves {
            continue;
        }
        let (mut motion, others) = all.motion.clone().split(near.start);
        let (mut old, mut after) = others.split(NEAR);
        for (joint, limit) in limits.iter().enumerate() {
            let least = NOISE * limit.derivatives[1];
            settle(&mut motion, joint, true, least);
            settle(&mut old, joint, true, least);
            settle(&mut after, joint, false, least);
        }
        let mut ends = part.ends.only(near.start == 0, near.end == segments);
        if near.start == 0 {
            ends.goal = old.end();
        } else {
            ends.start = motion.end();
        }
        let waypoints = &part.waypoints[near.start..=near.end];
        let Ok(stops) = stops(waypoints, limits, &ends) else {
            return Planned { motion: part.stops.clone(), converged: false, ..all };
        };
        let (ways, rooms) = (&part.ways[near], Rooms::none());
        let own = Part { ways, waypoints, limits, speeds: &[], rooms, ends, stops };
        let anew = at_once(&own, &mut silent);
        all.iterations += anew.iterations;
        all.converged &= anew.converged;
        motion.append(anew.motion);
        motion.append(after);
        all.motion = motion;
    }
    all
}
