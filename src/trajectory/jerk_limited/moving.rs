//! Ends in motion: where a robot is re-planned on the fly, or hands over at speed.
//!
//! Between two waypoints the closed form of [`state_to_state`](super::state_to_state) is the
//! optimum. Through more, the programme starts and ends with the states given. Such a motion
//! cannot be stretched, because its ends would change with it: one that passes a limit by rounding is planned again within
//! limits that are as much tighter. Short lists are planned backwards, too. The result is compared with one that is always possible: the
//! closed form to rest at the second waypoint, from there the fastest motion from rest to rest,
//! and the closed form again from rest at the last waypoint but one.

use crate::budget::Budget;
use crate::trajectory::Ends;
use crate::trajectory::kernel::KernelLimits;

use super::profile::Motion;
use super::state_to_state::{State, StateFault, between};
use super::windows::{self, Planned};
use super::{
    Fastest, Part, Plan, Route, SECOND_LOOK, Stage, Watch, layout, one_way, stopped, ways,
};

/// What rounding may add to a limit, as a factor of time.
const ROUNDING: f64 = 1e-10;

/// How often limits are tightened before stops are accepted.
const TIGHTENINGS: usize = 3;

/// How much tighter than necessary limits become, as a factor of time.
const MARGIN: f64 = 1e-7;

/// The fastest trajectory found through `waypoints[waypoint][joint]` that begins and ends in the
/// motion of `ends`, as far as `budget` allows; otherwise as [`super::fastest_within`].
///
/// With two waypoints its duration is the least possible, and with more the lower bound is zero: none
/// is proven. On segments next to an end in motion positions may have to leave
/// their limits; nothing is said about that here.
///
/// # Errors
///
/// All that is wrong with the states at the ends.
pub fn fastest_between(
    waypoints: &[Vec<f64>],
    limits: &[KernelLimits],
    ends: &Ends,
    budget: &Budget,
    tell: &mut dyn FnMut(Stage),
) -> Result<Fastest, Vec<StateFault>> {
    let limited = |limit: &KernelLimits| limit.derivatives[1..].iter().any(|l| l.is_finite());
    let proves = waypoints.len() == 2 && limits.iter().all(limited);
    let limits = layout::effective(&ways(waypoints), limits);
    let route = Route { waypoints, limits: &limits, ends };
    let stops = stops(&route)?;
    let mut plan = one_way(&route, &stops, budget, 0, tell);
    if (3..=SECOND_LOOK.1).contains(&waypoints.len()) {
        let other = backwards(&route, &stops, budget, plan.iterations, tell);
        plan.compare(other, &route);
    }
    if let Some(other) = slow_ends(&route, &stops, budget, plan.iterations, tell) {
        plan.compare(other, &route);
    }
    let lower = if proves { plan.motion.duration() } else { 0.0 };
    Ok(plan.finished(waypoints, lower))
}

impl Plan {
    /// Takes the motion of `other`, planned later, if it is faster and stays within the position limits.
    fn compare(&mut self, other: Self, route: &Route) {
        let faster = other.motion.duration() < self.motion.duration();
        if faster && other.motion.stops_within(route.waypoints, route.limits).is_empty() {
            self.motion = other.motion;
            (self.converged, self.moves) = (other.converged, other.moves);
        }
        self.iterations = other.iterations;
    }
}

/// Planned backwards in time: the optimum is the same, but the search takes another way to it.
fn backwards(
    route: &Route,
    stops: &Motion,
    budget: &Budget,
    iterations: usize,
    tell: &mut dyn FnMut(Stage),
) -> Plan {
    let waypoints: Vec<Vec<f64>> = route.waypoints.iter().rev().cloned().collect();
    let ends = route.ends.reversed();
    let back = Route { waypoints: &waypoints, limits: route.limits, ends: &ends };
    let plan = one_way(&back, &stops.clone().reversed(), budget, iterations, tell);
    Plan { motion: plan.motion.reversed(), ..plan }
}

/// The motion that stops at every waypoint between the ends.
fn stops(route: &Route) -> Result<Motion, Vec<StateFault>> {
    let Route { waypoints, limits, ends } = route;
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
            stopped(&ways[segment..=segment], limits)
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

/// The motion with closed forms next to the ends in motion and the fastest between them; none if nothing is
/// between them.
fn slow_ends(
    route: &Route,
    stops: &Motion,
    budget: &Budget,
    iterations: usize,
    tell: &mut dyn FnMut(Stage),
) -> Option<Plan> {
    let [first, last] = route.ends.rests().map(|rests| usize::from(!rests));
    let segments = stops.durations.len();
    let inner = first..segments.checked_sub(last)?;
    if inner.len() < 2 {
        return None;
    }
    let outside = stops.duration() - stops.segments(inner.clone()).duration();
    let rest = Ends::at_rest(route.limits.len());
    let part = Route {
        waypoints: &route.waypoints[inner.start..=inner.end],
        limits: route.limits,
        ends: &rest,
    };
    let mut tell = |stage: Stage| {
        tell(Stage { duration: outside + stage.duration, ..stage });
    };
    let own = stops.segments(inner.clone());
    let plan = one_way(&part, &own, budget, iterations, &mut tell);
    let mut motion = stops.segments(0..inner.start);
    motion.append(plan.motion);
    motion.append(stops.segments(inner.end..segments));
    Some(Plan { motion, ..plan })
}

/// The fastest motion found along `part` that keeps its limits as it is.
pub fn within(part: &Part, watch: &mut Watch) -> Planned {
    let mut limits = part.limits.to_vec();
    let (mut slower, mut iterations) = (1.0, 0);
    for _ in 0..TIGHTENINGS {
        let planned = windows::plan(part, &limits, watch);
        iterations += planned.iterations;
        let ratio = planned.motion.ratio(part.limits);
        if ratio <= 1.0 + ROUNDING {
            return Planned { iterations, ..planned };
        }
        slower *= ratio * (1.0 + MARGIN);
        let joints = part.limits.iter().enumerate();
        limits = joints.map(|(joint, limit)| tightened(limit, &part.ends, joint, slower)).collect();
    }
    Planned { motion: part.stops.clone(), iterations, converged: false }
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
