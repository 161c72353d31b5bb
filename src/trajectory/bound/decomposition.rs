//! A lower bound from prices: every segment pays for itself.
//!
//! A joint must enter a segment as it left the one before. A price on that turns one problem into one
//! per segment: the least `h + sum over joints of (p · s - p' · s')` over all durations `h` and
//! all lawful curves of that duration, `s` and `s'` being the states at its ends. What one
//! segment gets back the next pays, so that the sum of these least payments is below the
//! duration of every lawful trajectory, whatever the prices (Lagrangian duality). For given
//! `h` the joints pay independently, see [`super::payment`]; over `h` the least payment is bounded by
//! dividing its range. `docs/BOUND.md` has the proof.

use super::payment::{Case, Minorant, Near, minorants};
use crate::trajectory::rooms::Rooms;

/// Prices of the states at waypoints; any are valid, good ones are the multipliers of a good trajectory.
///
/// `[segment][joint]`: what position, velocity and acceleration cost where a segment starts, in s per rad, per rad/s
/// and per rad/s² (or m). Those of the first segment do not count.
pub type Prices = Vec<Vec<[f64; 3]>>;

/// Durations tried first, relative to those of the trajectory.
const FIRST: [f64; 6] = [0.9, 0.97, 1.0, 1.03, 1.12, 1.5];

/// Rounds in which durations are added where the bound is lowest, and how many in each.
const ROUNDS: usize = 6;
const MORE: usize = 3;

/// What a segment's bound may be below the payment at the trajectory's own duration, as a share of that.
const TOLERANCE: f64 = 5e-4;

/// Halvings that find where two minorants cross.
const HALVINGS: usize = 12;

/// What rounding may have added to the bound, relative to the trajectory's duration.
const ROUNDING: f64 = 1e-9;

/// A duration in s below which no trajectory from rest to rest along `ways[segment][joint]`, which may miss
/// waypoints within `rooms`, is lawful, given that a lawful one with these `durations` exists.
///
/// `limits` are of velocity, acceleration and jerk, infinite where there is none.
pub fn decomposed(
    ways: &[Vec<f64>],
    limits: &[[f64; 3]],
    rooms: Rooms,
    durations: &[f64],
    prices: &Prices,
) -> f64 {
    let upper: f64 = durations.iter().sum();
    let limits: Vec<[f64; 3]> = limits.iter().map(|limit| implied(*limit, upper)).collect();
    let all = Segments { ways, limits: &limits, rooms, prices };
    let cases = |segment: usize| -> Vec<Case> {
        (0..limits.len()).map(|joint| all.case(segment, joint)).collect()
    };
    let least: Vec<f64> = (0..ways.len()).map(|segment| at_full_speed(&cases(segment))).collect();
    let all_least: f64 = least.iter().sum();
    let segment = |segment: usize| {
        let cases = cases(segment);
        // Longer segments belong to trajectories that are no faster than the one we have.
        let range = [least[segment], upper - (all_least - least[segment])];
        // Where deviations can make up for all ways, nothing else bounds the shortest durations.
        let near = (range[0] == 0.0).then(|| Near::new(&cases));
        Payment { cases: &cases, near, minorants: Vec::new(), range }.least(durations[segment])
    };
    let sum: f64 = (0..ways.len()).map(segment).sum();
    // Not-a-number must not pass for a bound.
    if sum.is_nan() { 0.0 } else { sum.min(upper) - ROUNDING * upper }
}

/// The limits, and what they and a whole duration of `upper` imply for those that do not exist: from rest
/// to rest half the time is left to gain what the other half takes away.
fn implied([velocity, acceleration, jerk]: [f64; 3], upper: f64) -> [f64; 3] {
    let acceleration = acceleration.min(0.5 * jerk * upper);
    [velocity.min(0.5 * acceleration * upper), acceleration, jerk]
}

/// No joint is faster than its speed limit all the way, from one room to the next.
fn at_full_speed(cases: &[Case]) -> f64 {
    let of = |case: &Case| {
        let way = case.way.abs() - case.rooms[0] - case.rooms[1];
        way.max(0.0) / case.limits[0]
    };
    cases.iter().map(of).fold(0.0, f64::max)
}

/// What the payments are made for.
struct Segments<'a> {
    ways: &'a [Vec<f64>],
    limits: &'a [[f64; 3]],
    rooms: Rooms<'a>,
    prices: &'a Prices,
}

impl Segments<'_> {
    /// What one joint pays for one segment; the duration is open.
    fn case(&self, segment: usize, joint: usize) -> Case {
        let last = segment + 1 == self.ways.len();
        let price = |segment: usize| {
            let [x, v, a] = self.prices[segment][joint];
            let [_, acceleration, jerk] = self.limits[joint].map(f64::is_finite);
            // What has no limit on its change may jump at a waypoint.
            [x, if acceleration { v } else { 0.0 }, if jerk { a } else { 0.0 }]
        };
        let [enter, leave] = [
            if segment > 0 { price(segment) } else { [0.0; 3] },
            if last { [0.0; 3] } else { price(segment + 1) },
        ];
        // Deviations count from the middles of rooms.
        let rooms = [segment, segment + 1].map(|at| self.rooms.of(at, joint));
        let [from, to] = rooms.map(|[lower, upper]| 0.5 * (lower + upper));
        let case = Case {
            duration: 0.0,
            way: self.ways[segment][joint] + to - from,
            limits: self.limits[joint],
            enter: [enter[1], enter[2]],
            leave: [leave[1], leave[2]],
            from_rest: segment == 0,
            rooms: rooms.map(|[lower, upper]| 0.5 * (upper - lower)),
            positions: [enter[0], leave[0]],
        };
        if last && segment > 0 { case.backwards() } else { case }
    }
}

/// The payment of all joints for one segment, bounded below by minorants.
struct Payment<'a> {
    /// One per joint.
    cases: &'a [Case],
    /// Good for the shortest durations, where these are none at all.
    near: Option<Near>,
    /// By duration.
    minorants: Vec<Minorant>,
    /// Shortest and longest duration.
    range: [f64; 2],
}

impl Payment<'_> {
    /// A lower bound on the payment over all durations, starting around `own`.
    fn least(mut self, own: f64) -> f64 {
        self.add(&FIRST.map(|factor| factor * own));
        let goal = self.minorants.iter().map(|m| m.at(own)).fold(f64::NEG_INFINITY, f64::max);
        let enough = goal * (1.0 - TOLERANCE);
        for _ in 0..ROUNDS {
            let mut low = self.intervals();
            low.retain(|(value, _)| *value < enough);
            if low.is_empty() {
                break;
            }
            low.sort_by(|a, b| a.0.total_cmp(&b.0));
            let more: Vec<f64> = low.iter().take(MORE).map(|(_, between)| *between).collect();
            self.add(&more);
        }
        self.intervals().into_iter().map(|(value, _)| value).fold(f64::INFINITY, f64::min)
    }

    /// Adds minorants made at `durations` where they are in range, and drops those that are below
    /// others where they were made.
    fn add(&mut self, durations: &[f64]) {
        let [shortest, longest] = self.range;
        let inside = durations.iter().filter(|h| (shortest..=longest).contains(*h));
        let cases: Vec<Case> = inside
            .flat_map(|&duration| self.cases.iter().map(move |case| Case { duration, ..*case }))
            .collect();
        let found = minorants(&cases);
        let sums = found.chunks(self.cases.len()).map(Minorant::sum);
        self.minorants.extend(sums.filter(Minorant::is_finite));
        self.minorants.sort_by(|a, b| a.duration.total_cmp(&b.duration));
        let all = self.minorants.clone();
        let highest = |m: &Minorant| all.iter().all(|o| o.at(m.duration) <= m.at(m.duration));
        self.minorants.retain(highest);
    }

    /// A lower bound between neighbouring minorants and from the outer ones to the ends of the range,
    /// with a duration there.
    fn intervals(&self) -> Vec<(f64, f64)> {
        let (Some(first), Some(last)) = (self.minorants.first(), self.minorants.last()) else {
            return vec![(f64::NEG_INFINITY, self.range[0])];
        };
        let outer = |near: &Minorant, end: f64| {
            (near.at(end).min(near.at(near.duration)), (end * near.duration).sqrt())
        };
        let mut all = vec![match &self.near {
            Some(near) => between([self.range[0], first.duration], |h| near.at(h), |h| first.at(h)),
            None => outer(first, self.range[0]),
        }];
        all.extend(self.minorants.windows(2).map(|pair| {
            let [low, high] = [&pair[0], &pair[1]];
            between([low.duration, high.duration], |h| low.at(h), |h| high.at(h))
        }));
        all.push(outer(last, self.range[1]));
        all
    }
}

/// A lower bound between two durations from two that are concave, and where these cross.
fn between(
    [shortest, longest]: [f64; 2],
    low: impl Fn(f64) -> f64,
    high: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let (mut from, mut to) = (shortest, longest);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if low(middle) > high(middle) { from = middle } else { to = middle }
    }
    // Left of `from` we take one, right of it the other. Each is concave there, so that its least
    // value is at an end.
    let left = low(shortest).min(low(from));
    let right = high(from).min(high(longest));
    (left.min(right), 0.5 * (from + to))
}
