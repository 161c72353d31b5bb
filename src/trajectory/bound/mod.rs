//! A proven lower bound on the duration of any lawful trajectory.
//!
//! Two proofs: an elementary one from the length of the ways, and one by prices
//! ([`decomposition`], [`payment`]) that is usually within a percent of the optimum.

mod decomposition;
mod payment;
mod programme;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use decomposition::Prices;
use decomposition::decomposed;

use super::limits::JointBounds;
use super::rest_to_rest::alone;
use super::rooms::Rooms;

/// By how much rounding may lift a closed form above the duration of a trajectory that attains it.
const ROUNDING: f64 = 1e-12;

/// A proven lower bound on the duration of any lawful trajectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LowerBound {
    /// No lawful trajectory through the waypoints is shorter, s.
    pub lower: f64,
    /// How much longer the plan is, relative to `lower`; zero until compared.
    pub gap: f64,
    /// How it was proven.
    pub method: String,
}

impl LowerBound {
    /// What the limits say at once, without any trajectory: see [`elementary`]. None if nothing.
    /// `rests` says whether all joints rest at the start, and at the goal.
    pub fn elementary(
        waypoints: &[Vec<f64>],
        limits: &[JointBounds],
        rooms: Rooms,
        rests: [bool; 2],
    ) -> Option<Self> {
        let method = match rests {
            [true, true] => {
                "way over speed limit, with ramps within acceleration and jerk at both ends"
            }
            [false, false] => "way over speed limit",
            _ => {
                "way over speed limit, with a ramp within acceleration and jerk at the end at rest"
            }
        };
        Self::new(elementary(waypoints, limits, rooms, rests) * (1.0 - ROUNDING), method)
    }

    /// The better of the elementary bound and `lower`, which [`lower_bound`] found or, between
    /// two states of motion, the exact optimum.
    pub fn proven(
        waypoints: &[Vec<f64>],
        limits: &[JointBounds],
        rooms: Rooms,
        rests: [bool; 2],
        lower: f64,
    ) -> Option<Self> {
        let method = match (waypoints.len(), rests) {
            (2, [true, true]) => "the slowest joint's optimum from rest to rest",
            (2, _) => "the shortest duration that every joint can have between the two states",
            _ => "segments priced by the states they share (docs/BOUND.md)",
        };
        let elementary = Self::elementary(waypoints, limits, rooms, rests);
        elementary.filter(|bound| bound.lower > lower).or_else(|| Self::new(lower, method))
    }

    fn new(lower: f64, method: &str) -> Option<Self> {
        let known = lower > 0.0 && lower.is_finite();
        known.then(|| Self { lower, gap: 0.0, method: method.to_owned() })
    }

    /// The same, with the gap of a plan that takes `duration`, s.
    #[must_use]
    pub fn against(self, duration: f64) -> Self {
        Self { gap: duration / self.lower - 1.0, ..self }
    }
}

/// A duration in s below which no trajectory from rest to rest along `ways[segment][joint]`, which may miss waypoints
/// within `rooms`, is lawful, given the durations of one that is, and prices of its states (see [`decomposition`]). Zero if nothing is known.
///
/// `limits` are of velocity, acceleration and jerk, infinite where there is none.
pub fn lower_bound(
    ways: &[Vec<f64>],
    limits: &[[f64; 3]],
    rooms: Rooms,
    durations: &[f64],
    prices: &Prices,
) -> f64 {
    let lower = match ways {
        // The slowest joint's optimum: attained, because every other can be as slow.
        [way] => {
            let times = way.iter().zip(limits).map(|(way, limit)| alone(*way, *limit));
            times.fold(0.0, f64::max) * (1.0 - ROUNDING)
        }
        ways => decomposed(ways, limits, rooms, durations, prices).max(direct(ways, limits, rooms)),
    };
    if lower > 0.0 { lower } else { 0.0 }
}

/// The slowest joint's optimum from the first waypoint straight to the last one, s; worth looking at where there is so much
/// room that nothing else may be left.
fn direct(ways: &[Vec<f64>], limits: &[[f64; 3]], rooms: Rooms) -> f64 {
    if rooms.are_none() {
        return 0.0;
    }
    let of =
        |(joint, limit): (usize, &[f64; 3])| alone(ways.iter().map(|row| row[joint]).sum(), *limit);
    limits.iter().enumerate().map(of).fold(0.0, f64::max) * (1.0 - ROUNDING)
}

/// A bound from the length of the ways alone, s.
///
/// Every segment lasts at least as long as its slowest joint needs with the speed it
/// can have reached, and the whole at least as long as any joint needs for its way
/// from rest to rest, whatever the curve. An end that does not rest has no ramp. Ways lead from one room to
/// the next, where there are some.
fn elementary(
    waypoints: &[Vec<f64>],
    limits: &[JointBounds],
    rooms: Rooms,
    rests: [bool; 2],
) -> f64 {
    let segments = waypoints.len() - 1;
    let [first, last] = rests.map(usize::from);
    let mut by_segments = 0.0;
    let mut ways = vec![0.0; limits.len()];
    for segment in 0..segments {
        let ramps = first * usize::from(segment == 0) + last * usize::from(segment + 1 == segments);
        let mut longest = 0.0f64;
        for (joint, limit) in limits.iter().enumerate() {
            let way = waypoints[segment + 1][joint] - waypoints[segment][joint];
            let [from, to] = [segment, segment + 1].map(|at| rooms.of(at, joint));
            let way = (way + to[0] - from[1]).max(-(way + to[1] - from[0])).max(0.0);
            ways[joint] += way;
            longest = longest.max(shortest(way, limit, ramps));
        }
        by_segments += longest;
    }
    let of = |(way, limit): (&f64, &JointBounds)| shortest(*way, limit, first + last);
    by_segments.max(ways.iter().zip(limits).map(of).fold(0.0, f64::max))
}

/// The least time for `way` when speed is at most `V` and starts (one ramp) or
/// starts and ends (two) at rest, gaining at most `A` per second and at most `J t²/2` in
/// all: the area under such a profile of speed is at least the way.
fn shortest(way: f64, limit: &JointBounds, ramps: usize) -> f64 {
    let [velocity, acceleration, jerk] = [0, 1, 2].map(|order| limit.derivative(order));
    let by_speed = way / velocity;
    if ramps == 0 {
        return by_speed;
    }
    let ramps = ramps as f64;
    // Each ramp covers `J t³/6`; two share the time and the way.
    let by_jerk = ramps * libm::cbrt(6.0 * way / (ramps * jerk));
    let by_acceleration = if acceleration.is_finite() {
        under_ramps(way, velocity, acceleration, ramps)
    } else {
        by_speed
    };
    by_acceleration.max(by_jerk)
}

fn under_ramps(way: f64, velocity: f64, acceleration: f64, ramps: f64) -> f64 {
    // All ramps together cover `ramps V² / 2A` before speed is the limit.
    if ramps * velocity * velocity <= 2.0 * acceleration * way {
        way / velocity + 0.5 * ramps * velocity / acceleration
    } else {
        (2.0 * ramps * way / acceleration).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::limits::Limit;

    fn joint(velocity: f64, acceleration: f64) -> JointBounds {
        let limit = |value| Some(Limit { value, provenance: String::new() });
        JointBounds {
            name: "j".into(),
            unit: "rad",
            lower: None,
            upper: None,
            derivatives: [limit(velocity), limit(acceleration), None],
        }
    }

    /// Rest to rest the bound is the trapezoid's or the triangle's exact time.
    #[test]
    fn is_exact_from_rest_to_rest() {
        let waypoints = |way: f64| [vec![0.0], vec![way]];
        let bound =
            |way: f64| elementary(&waypoints(way), &[joint(2.0, 4.0)], Rooms::none(), [true; 2]);
        assert_eq!(bound(4.0), 2.5);
        assert_eq!(bound(0.25), 0.5);
        let proven = |way: f64| {
            LowerBound::elementary(&waypoints(way), &[joint(2.0, 4.0)], Rooms::none(), [true; 2])
        };
        assert_eq!(proven(0.0), None);
        let lower = proven(4.0).map(|b| b.lower);
        assert!(lower.is_some_and(|lower| (2.5 - 1e-11..2.5).contains(&lower)), "{lower:?}");
    }

    /// Where nothing but jerk is limited, gaining speed alone takes this long.
    #[test]
    fn jerk_alone_bounds_too() {
        let mut joint = joint(2.0, 4.0);
        joint.derivatives = [None, None, Some(Limit { value: 3.0, provenance: String::new() })];
        let waypoints = [vec![0.0], vec![1.0], vec![0.0]];
        let bound = elementary(&waypoints, &[joint], Rooms::none(), [true; 2]);
        // The whole way of 2 in one go from rest to rest: cbrt(24 · 2 / 3); the optimum takes cbrt(32 · 2 / 3).
        assert!((bound - libm::cbrt(16.0)).abs() < 1e-12, "{bound}");
    }
}
