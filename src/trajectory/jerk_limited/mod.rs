//! The fastest trajectory through waypoints under limits on velocity, acceleration and jerk.
//!
//! For every joint jerk is constant piece by piece (acceleration, where jerk has no limit). All
//! joints meet the waypoints at the same times; what they do in between is each joint's own.
//!
//! # The programme
//!
//! A segment of duration `h` is divided into cells; cell `c` lasts `T = phi h`, its share `phi` is
//! each joint's own. With acceleration linear in a cell, `d` its change,
//!
//! ```text
//! x' = x + T v + T² (a/2 + d/6),   v' = v + T (a + d/2),   a' = a + d,
//! ```
//!
//! minimise the sum of `h` so that `|d| <= J T`, `|a'| <= A`, `|v'| <= V` and
//! `|v + T a/2| <= V`. The last is the middle control point of velocity in Bernstein
//! form: with it, speed keeps its limit over the whole cell and not only at its ends.
//! Where jerk is free, acceleration jumps at a cell's start: `d` counts fully from there.
//!
//! # Its solution
//!
//! A primal-dual interior point method (Wächter and Biegler, Mathematical Programming 106, 2006,
//! doi:10.1007/s10107-004-0559-y, whose filter and reduction of the barrier parameter we keep, simplified).
//! For given durations every joint's problem is convex and a chain of cells, so that a
//! Newton step is a Riccati recursion (Rao, Wright and Rawlings, JOTA 99, 1998,
//! doi:10.1023/A:1021711402723). Durations enter as parameters of the recursion; what remains is
//! one small system in the durations, the only place where curvature can be
//! negative. There the magnitudes of its eigenvalues replace them, see [`interior_point`].
//!
//! First a segment has few cells, equal but for joints with short ramps. Then those in which the jerk
//! switches are halved again and again ([`refine`]), and the second solution starts from the first.
//!
//! # Rooms
//!
//! Where a joint has room at a waypoint (`via_tolerance`, [`Rooms`]), its deviation from the waypoint is a variable with two more
//! bounds: the position is carried over the waypoint as velocity and acceleration are, and the segment's way needs
//! no multiplier of its own. Joints with and without room share a register; a mask tells them apart. [`profile`] restores the
//! positions that the programme chose. Stops, and the search of states, meet waypoints exactly, which is always within the rooms. Where
//! the result is far from its bound, the demand without rooms is planned, too.
//!
//! # What is delivered
//!
//! The solution misses the equalities by rounding and keeps the limits strictly. [`profile`] joins cells of
//! equal jerk, restores the equalities, finds exact peaks and uses the limits exactly by the scaling law.
//! No result is slower than [`stopping`] at every waypoint, which is always possible.
//!
//! Ends in motion ([`moving`]) are given to the programme as they are: velocity and acceleration before its first
//! cell, and at the end of its last.
//!
//! Limits of velocity may be lower in some segments ([`speeds`]): where two meet, the lower one holds.
//!
//! Long lists are planned in [`windows`]. Position limits between waypoints are not in the programme: a motion
//! that leaves them is divided at the nearest waypoints, and its parts are planned as motions from rest to
//! rest. From one waypoint to the next no such motion leaves them. A list whose programme is not
//! solved is divided in the same way, in the middle.

#![expect(
    clippy::needless_range_loop,
    reason = "rows and columns of matrices are known by their numbers"
)]

mod berths;
mod chain;
mod interior_point;
mod layout;
mod moving;
mod newton;
mod problem;
mod profile;
mod reach;
mod refine;
mod speeds;
pub mod state_to_state;
mod states;
mod step;
mod stopping;
mod windows;
mod work;

pub use moving::fastest_between;
pub use profile::{Motion, Phase};

use std::ops::Range;

use speeds::Bounds;

use super::bound::lower_bound;
use super::kernel::KernelLimits;
use super::rooms::Rooms;
use super::{Ends, Prices, Trajectory};
use crate::budget::Budget;

/// A fastest trajectory.
#[derive(Clone, Debug)]
pub struct Fastest {
    /// Cubic pieces (quadratic where jerk is free), within all limits.
    pub trajectory: Trajectory,
    /// Duration of each segment between waypoints, s.
    pub durations: Vec<f64>,
    /// When each waypoint is reached, s.
    pub times: Vec<f64>,
    /// No lawful trajectory is shorter, s; position limits aside. Zero if nothing is known.
    pub lower: f64,
    /// How long it would take with a stop at every waypoint, s.
    pub stopping: f64,
    /// Newton steps.
    pub iterations: usize,
    /// Whether every programme was solved to its end.
    pub converged: bool,
    /// Whether the result stops at every waypoint because nothing faster was found.
    pub stops: bool,
    /// Multipliers of the programmes solved: prices that prove a lower bound.
    pub prices: Prices,
    /// `[segment][joint]`: what the limits of velocity, acceleration and jerk hold back there, in s per
    /// relative change: a limit higher by one percent saves a hundredth of it. From rest to rest, since time
    /// scales with them, once velocity's, twice acceleration's and three times jerk's
    /// add up to the whole duration.
    pub gains: Vec<Vec<[f64; 3]>>,
}

/// How far planning has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Newton steps so far.
    pub iterations: usize,
    /// Duration of the best motion known: what is planned, and stops behind it, s.
    pub duration: f64,
}

/// Says how far planning has come and whether it may go on.
struct Watch<'a> {
    budget: &'a Budget,
    tell: &'a mut dyn FnMut(Stage),
    /// Time from each waypoint to the goal with stops, s.
    to_go: Vec<f64>,
    /// The waypoint that the present list starts from, when, and Newton steps before it.
    first: usize,
    start: f64,
    iterations: usize,
    best: f64,
}

impl<'a> Watch<'a> {
    /// Before anything is planned but `stops`; `iterations` went before.
    fn new(
        stops: &Motion,
        budget: &'a Budget,
        iterations: usize,
        tell: &'a mut dyn FnMut(Stage),
    ) -> Self {
        let mut to_go = vec![0.0; stops.durations.len() + 1];
        for (segment, duration) in stops.durations.iter().enumerate().rev() {
            to_go[segment] = to_go[segment + 1] + duration;
        }
        let best = to_go[0];
        Self { budget, tell, to_go, first: 0, start: 0.0, iterations, best }
    }

    /// Whether time is up.
    fn is_over(&self) -> bool {
        self.budget.stop_reason(0).is_some()
    }

    /// Tells that of the present list `segments` are planned, which take `duration`; `ahead` is
    /// a motion from there to rest at some waypoint.
    fn report(&mut self, iterations: usize, segments: usize, duration: f64, ahead: &Motion) {
        let reached = self.first + segments + ahead.durations.len();
        let total = self.start + duration + ahead.duration() + self.to_go[reached];
        self.best = self.best.min(total);
        let iterations = self.iterations + iterations;
        (self.tell)(Stage { iterations, duration: self.best });
    }
}

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Demand<'a> {
    /// `[waypoint][joint]`, rad or m; neighbours differ in at least one joint.
    pub waypoints: &'a [Vec<f64>],
    /// By joint; infinite where there is none.
    pub limits: &'a [KernelLimits],
    /// Lower limits of velocity, `[segment][joint]` in rad/s or m/s and positive: infinite where the joint's own holds,
    /// and empty where it does everywhere.
    pub speeds: &'a [Vec<f64>],
    /// By how much inner waypoints may be missed.
    pub rooms: Rooms<'a>,
    /// Motion at the ends; none if they are at rest.
    pub ends: Option<&'a Ends>,
}

impl<'a> Demand<'a> {
    /// Through all waypoints exactly, from rest to rest within the joints' limits.
    pub fn new(waypoints: &'a [Vec<f64>], limits: &'a [KernelLimits]) -> Self {
        Self { waypoints, limits, speeds: &[], rooms: Rooms::none(), ends: None }
    }
}

/// The fastest trajectory through `waypoints[waypoint][joint]`, from rest to rest.
///
/// Limits that do not exist are infinite. Neighbouring waypoints differ in at least one joint.
pub fn fastest(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Fastest {
    fastest_within(&Demand::new(waypoints, limits), &Budget::default(), &mut |_| {})
}

/// The same for any demand whose ends are at rest, as far as `budget` allows: what is not planned by then stops at
/// every waypoint. `tell` hears how planning proceeds: at the start, after every window of a long list, and at the end.
pub fn fastest_within(demand: &Demand, budget: &Budget, tell: &mut dyn FnMut(Stage)) -> Fastest {
    let rows: Vec<[f64; 3]> = demand.limits.iter().map(|limit| limit.derivatives).collect();
    let limits = layout::effective(&ways(demand.waypoints), demand.limits);
    let demand = Demand { limits: &limits, ..*demand };
    // What is known of the first plan stays known while others are tried.
    let mut known = f64::INFINITY;
    let tell: &mut dyn FnMut(Stage) = &mut |stage| {
        known = known.min(stage.duration);
        tell(Stage { duration: known, ..stage });
    };
    let (plan, lower) = looked_at(&demand, &rows, 0, budget, tell);
    plan.finished(demand.waypoints, lower)
}

/// The best of several looks at a demand from rest to rest, and its lower bound within limits of velocity, acceleration
/// and jerk, `rows`; `iterations` went before.
fn looked_at(
    demand: &Demand,
    rows: &[[f64; 3]],
    iterations: usize,
    budget: &Budget,
    tell: &mut dyn FnMut(Stage),
) -> (Plan, f64) {
    let Demand { waypoints, limits, rooms, .. } = *demand;
    let bound = |plan: &Plan, Demand { waypoints, rooms, .. }: &Demand| {
        let Motion { durations, prices, .. } = &plan.motion;
        lower_bound(&ways(waypoints), rows, *rooms, durations, prices)
    };
    let plan_from = |demand: &Demand, iterations: usize, tell: &mut dyn FnMut(Stage)| {
        let stops = stopped(&ways(demand.waypoints), Bounds::everywhere(limits));
        one_way(demand, &stops, budget, iterations, tell)
    };
    let mut plan = plan_from(demand, iterations, tell);
    let mut lower = bound(&plan, demand);
    let short = (3..=SECOND_LOOK.1).contains(&waypoints.len());
    if short && plan.motion.duration() > SECOND_LOOK.0 * lower {
        // Backwards in time the optimum is the same, but the search takes another way to it.
        let reversed: Vec<Vec<f64>> = waypoints.iter().rev().cloned().collect();
        let table = rooms.reversed();
        let reversed = Demand { waypoints: &reversed, rooms: Rooms::new(&table), ..*demand };
        let back = plan_from(&reversed, plan.iterations, tell);
        lower = lower.max(bound(&back, &reversed));
        let iterations = back.iterations;
        if back.motion.duration() < plan.motion.duration() {
            plan = Plan { motion: back.motion.reversed(), ..back };
        }
        plan.iterations = iterations;
    }
    if !rooms.are_none() && plan.motion.duration() > SECOND_LOOK.0 * lower {
        // To meet all waypoints exactly is lawful, too, and where it is faster a start for better.
        let exact = Demand { rooms: Rooms::none(), ..*demand };
        let (exact, _) = looked_at(&exact, rows, plan.iterations, budget, tell);
        plan.iterations = exact.iterations;
        if exact.motion.duration() < plan.motion.duration() {
            let start = exact.motion.clone();
            plan = exact;
            plan.improve(demand, budget, tell, |_, _| vec![start]);
            lower = lower.max(bound(&plan, demand));
        }
    }
    let values = 2 * limits.len() * waypoints.len().saturating_sub(2);
    if short && values <= THIRD_LOOK.1 && plan.motion.duration() > THIRD_LOOK.0 * lower {
        let known = plan.motion.clone();
        plan.improve(demand, budget, tell, |part, watch| states::search(part, Some(&known), watch));
        lower = lower.max(bound(&plan, demand));
    }
    (plan, lower)
}

/// The same where limits of velocity differ by segment. The lower bound is zero: what is known without them holds on.
pub fn fastest_at_speeds(demand: &Demand, budget: &Budget) -> Fastest {
    let ways = ways(demand.waypoints);
    let limits = layout::effective(&ways, demand.limits);
    let stops = stopped(&ways, Bounds::new(&limits, demand.speeds));
    let demand = Demand { limits: &limits, ..*demand };
    one_way(&demand, &stops, budget, 0, &mut |_| {}).finished(demand.waypoints, 0.0)
}

/// A motion is planned once more, backwards, where it takes more than this many times its lower bound, and
/// has at most so many waypoints; and without room, however many it has.
const SECOND_LOOK: (f64, usize) = (1.02, 40);

/// Where it still takes more than this many times its lower bound, and has at most so many velocities and accelerations at
/// waypoints, these are searched.
const THIRD_LOOK: (f64, usize) = (1.05, 100);

fn ways(waypoints: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let way =
        |pair: &[Vec<f64>]| pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect();
    waypoints.windows(2).map(way).collect()
}

/// A motion and how it was found.
struct Plan {
    motion: Motion,
    iterations: usize,
    converged: bool,
    /// False if it stops at every waypoint because nothing faster was found.
    moves: bool,
    /// How long it would take with a stop at every waypoint, s.
    stopping: f64,
}

impl Plan {
    /// Takes over what a programme leads to that starts from one of `starts`, if it is faster.
    ///
    /// The motions that a search finds are joined from one closed form per segment and exact only to the rounding of
    /// each; a programme's solution is continuous and meets the waypoints.
    fn improve(
        &mut self,
        demand: &Demand,
        budget: &Budget,
        tell: &mut dyn FnMut(Stage),
        starts: impl FnOnce(&Part, &Watch) -> Vec<Motion>,
    ) {
        let Demand { waypoints, limits, speeds, rooms, .. } = *demand;
        let ways = ways(waypoints);
        let stops = stopped(&ways, Bounds::new(limits, speeds));
        let mut watch = Watch::new(&stops, budget, self.iterations, tell);
        let ends = Ends::at_rest(limits.len());
        let part = Part { ways: &ways, waypoints, limits, speeds, rooms, ends, stops };
        for start in starts(&part, &watch) {
            let mut found = windows::plan(&part, limits, Some(&start), &mut watch);
            self.iterations += found.iterations;
            found.motion.stretch(found.motion.ratio(Bounds::new(limits, speeds)));
            let inside = found.motion.stops_within(waypoints, limits).is_empty();
            if found.converged && inside && found.motion.duration() < self.motion.duration() {
                (self.motion, self.moves) = (found.motion, true);
            }
        }
    }

    fn finished(self, waypoints: &[Vec<f64>], lower: f64) -> Fastest {
        let (trajectory, times) = self.motion.trajectory(waypoints);
        Fastest {
            trajectory,
            durations: self.motion.durations,
            prices: self.motion.prices,
            gains: self.motion.gains,
            times,
            lower,
            stopping: self.stopping,
            iterations: self.iterations,
            converged: self.converged,
            stops: !self.moves,
        }
    }
}

/// A part of what is demanded that is planned at once; see [`Demand`].
struct Part<'a> {
    ways: &'a [Vec<f64>],
    waypoints: &'a [Vec<f64>],
    limits: &'a [KernelLimits],
    speeds: &'a [Vec<f64>],
    rooms: Rooms<'a>,
    ends: Ends,
    /// The motion that stops at every waypoint between the ends.
    stops: Motion,
}

/// Plans forwards; `stops` stops at every waypoint between the ends, and `iterations` went before.
fn one_way(
    demand: &Demand,
    stops: &Motion,
    budget: &Budget,
    iterations: usize,
    tell: &mut dyn FnMut(Stage),
) -> Plan {
    let Demand { waypoints, limits, speeds, rooms, ends } = *demand;
    let ways = ways(waypoints);
    let ends = ends.cloned().unwrap_or_else(|| Ends::at_rest(limits.len()));
    let mut watch = Watch::new(stops, budget, iterations, tell);
    let stopping = watch.best;
    (watch.tell)(Stage { iterations, duration: stopping });
    let mut motion = Motion::empty(limits.len());
    let (mut converged, mut moves) = (true, ways.len() == 1);
    // The list's parts between stops, the first one last.
    let mut parts: Vec<Range<usize>> = std::iter::once(0..ways.len()).collect();
    while let Some(part) = parts.pop() {
        (watch.first, watch.start) = (part.start, motion.duration());
        let own = Part {
            ways: &ways[part.clone()],
            waypoints: &waypoints[part.start..=part.end],
            limits,
            speeds: speeds.get(part.clone()).unwrap_or_default(),
            rooms: rooms.between(part.start, part.end),
            ends: ends.only(part.start == 0, part.end == ways.len()),
            stops: stops.segments(part.clone()),
        };
        let planned = if own.ends.are_at_rest() {
            windows::plan(&own, limits, None, &mut watch)
        } else {
            moving::plan(&own, &mut watch)
        };
        watch.iterations += planned.iterations;
        converged &= planned.converged;
        match judge(planned, own, &watch) {
            Ok((found, stops)) => {
                moves |= !stops;
                motion.append(found);
            }
            Err(stops) => divide(part, &stops, &mut parts),
        }
    }
    (watch.tell)(Stage { iterations: watch.iterations, duration: motion.duration() });
    Plan { motion, iterations: watch.iterations, converged, moves, stopping }
}

/// A part's motion and whether it stops everywhere; or waypoints of the part at which
/// it has to stop, and then be planned anew.
fn judge(
    planned: windows::Planned,
    part: Part,
    watch: &Watch,
) -> Result<(Motion, bool), Vec<usize>> {
    let mut motion = planned.motion;
    if part.ends.are_at_rest() {
        motion.stretch(motion.ratio(Bounds::new(part.limits, part.speeds)));
    }
    if motion.duration() < part.stops.duration() {
        let stops = motion.stops_within(part.waypoints, part.limits);
        return if stops.is_empty() { Ok((motion, false)) } else { Err(stops) };
    }
    if planned.converged || part.ways.len() == 1 || watch.is_over() {
        Ok((part.stops, true))
    } else {
        Err(vec![part.ways.len() / 2])
    }
}

/// Puts the pieces of `part` between `stops` on top of `parts`, the first one last.
fn divide(part: Range<usize>, stops: &[usize], parts: &mut Vec<Range<usize>>) {
    let mut end = part.end;
    for stop in stops.iter().rev() {
        parts.push(part.start + stop..end);
        end = part.start + stop;
    }
    parts.push(part.start..end);
}

/// The motion that stops at every waypoint, at the limits exactly.
fn stopped(ways: &[Vec<f64>], limits: Bounds) -> Motion {
    let mut motion = stopping::stopping(ways, limits);
    motion.stretch(motion.ratio(limits));
    motion
}
