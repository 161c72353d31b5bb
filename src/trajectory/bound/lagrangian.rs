//! A lower bound from prices: each joint pays for its own durations.
//!
//! All joints must take the same time for a segment, and a joint must leave a segment as it enters the
//! next. Prices on both turn one problem into one per joint and segment: where the rates of a
//! segment sum to one over the joints, the sum of the least payments is a lower bound
//! on the duration of every lawful trajectory (Lagrangian duality).

use super::segment::{Case, Minorant, minorants};

/// Prices of a list of waypoints; any are valid, good ones are the multipliers of a good trajectory.
#[derive(Clone, Debug, Default)]
pub struct Prices {
    /// What a second of each segment costs each joint: `[segment][joint]`.
    pub rates: Vec<Vec<f64>>,
    /// What velocity and acceleration cost each joint where it enters a segment:
    /// `[segment][joint]`, s per rad/s and per rad/s².
    pub states: Vec<Vec<[f64; 2]>>,
}

/// Durations tried first, relative to those of the trajectory.
const FIRST: [f64; 8] = [0.72, 0.9, 0.965, 1.0, 1.035, 1.1, 1.4, 2.2];

/// Rounds in which durations are added where the bound is lowest.
const ROUNDS: usize = 3;

/// What a segment's bound may be below the best value found for it, as a share of its duration.
const TOLERANCE: f64 = 5e-4;

/// The payment of one joint for one segment, bounded below by minorants.
struct Payment {
    case: Case,
    /// By duration.
    minorants: Vec<Minorant>,
    range: [f64; 2],
    /// The bound at the trajectory's own duration: no more can be proven.
    goal: f64,
}

impl Payment {
    /// The least value between minorants `at - 1` and `at`, and a duration between.
    fn interval(&self, at: usize) -> (f64, f64) {
        let count = self.minorants.len();
        if count == 0 { return (f64::NEG_INFINITY, 0.0); }
        if at == 0 || at == count {
            let end = self.range[at.min(1)];
            let near = &self.minorants[at.min(count - 1)];
            let value = near.at(end).min(near.at(near.duration));
            return (value, (end * near.duration).sqrt());
        }
        let [low, high] = [&self.minorants[at - 1], &self.minorants[at]];
        let (mut a, mut b) = (low.duration, high.duration);
        for _ in 0..12 {
            let middle = 0.5 * (a + b);
            if low.at(middle) > high.at(middle) { a = middle } else { b = middle }
        }
        let switch = 0.5 * (a + b);
        let ends = low.at(low.duration).min(high.at(high.duration));
        (ends.min(low.at(switch)).min(high.at(switch)), switch)
    }

    /// Forgets minorants that are below others where they were made.
    fn keep_highest(&mut self) {
        let all = self.minorants.clone();
        let highest = |m: &Minorant| all.iter().all(|o| o.at(m.duration) <= m.at(m.duration));
        self.minorants.retain(highest);
    }

    /// The proven bound, and durations where more would raise it.
    fn bound(&self) -> (f64, Vec<f64>) {
        let enough = self.goal - TOLERANCE * self.case.duration;
        let mut low: Vec<(f64, f64)> =
            (0..=self.minorants.len()).map(|at| self.interval(at)).collect();
        let bound = low.iter().map(|low| low.0).fold(f64::INFINITY, f64::min);
        low.retain(|low| low.0 < enough);
        low.sort_by(|a, b| a.0.total_cmp(&b.0));
        low.truncate(8);
        (bound, low.into_iter().map(|low| low.1).collect())
    }
}

/// The duration below which no lawful trajectory along `ways[segment][joint]` exists, if it has at most
/// `durations` together.
pub fn bound(
    ways: &[Vec<f64>],
    limits: &[[f64; 3]],
    durations: &[f64],
    prices: &Prices,
) -> f64 {
    let upper: f64 = durations.iter().sum();
    let least: Vec<f64> = ways
        .iter()
        .map(|row| row.iter().zip(limits).map(|(w, l)| w.abs() / l[0]).fold(0.0, f64::max))
        .collect();
    let all_least: f64 = least.iter().sum();
    let limits: Vec<[f64; 3]> = limits.iter().map(|limit| implied(*limit, upper)).collect();
    let limits = &limits;
    let mut sum = 0.0;
    for (segment, row) in ways.iter().enumerate() {
        for (joint, way) in row.iter().enumerate() {
            let case = case(ways, limits, durations, prices, segment, joint, *way);
            let free = case.rate == 0.0 && case.enter == [0.0; 2] && case.leave == [0.0; 2];
            if free {
                continue;
            }
            let longest = upper - (all_least - least[segment]);
            let one = payment(case, [way.abs() / limits[joint][0], longest]);
            let one = { let (b, g) = one; if std::env::var("GAP").is_ok() && g - b > 1e-3 { eprintln!("gap {segment} {joint} goal {g:.4} bound {b:.4} {case:?}"); } b };
            sum += one;
        }
    }
    sum.min(upper)
}

/// The limits, and what they and a whole duration of `upper` imply for those that do not exist: from rest
/// to rest half the time is left to gain what the other half takes away.
fn implied([velocity, acceleration, jerk]: [f64; 3], upper: f64) -> [f64; 3] {
    let acceleration = acceleration.min(0.5 * jerk * upper);
    [velocity.min(0.5 * acceleration * upper), acceleration, jerk]
}

fn case(
    ways: &[Vec<f64>],
    limits: &[[f64; 3]],
    durations: &[f64],
    prices: &Prices,
    segment: usize,
    joint: usize,
    way: f64,
) -> Case {
    let last = segment + 1 == ways.len();
    // Where jerk has no limit, acceleration at a waypoint means nothing.
    let smooth = if limits[joint][2].is_finite() { 1.0 } else { 0.0 };
    let state = |segment: usize| {
        let [v, a] = prices.states[segment][joint];
        [v, a * smooth]
    };
    let case = Case {
        duration: durations[segment],
        way,
        limits: limits[joint],
        rate: prices.rates[segment][joint],
        enter: state(segment),
        leave: if last { [0.0; 2] } else { state(segment + 1) },
        from_rest: segment == 0,
    };
    if last && segment > 0 {
        // Backwards in time it starts at rest.
        let [v, a] = case.enter;
        return Case { way: -way, enter: [0.0; 2], leave: [v, -a], from_rest: true, ..case };
    }
    case
}

fn payment(case: Case, range: [f64; 2]) -> (f64, f64) {
    let at = |durations: &[f64]| {
        let cases: Vec<Case> = durations
            .iter()
            .filter(|h| **h > range[0] && **h < range[1])
            .map(|&duration| Case { duration, ..case })
            .collect();
        minorants(&cases)
    };
    let first = FIRST.map(|factor| factor * case.duration);
    let minorants = at(&first);
    let own = minorants.iter().find(|m| m.duration == case.duration);
    let goal = own.map_or(0.0, |m| m.at(case.duration));
    let mut payment = Payment { case, minorants, range, goal };
    payment.keep_highest();
    for _ in 0..ROUNDS {
        let (bound, more) = payment.bound();
        if more.is_empty() {
    if std::env::var("BD").is_ok() { for m in &payment.minorants { eprintln!("{:.5} {:?} {:.5}", m.duration/case.duration, m, m.at(m.duration)); } 
      for i in 0..=payment.minorants.len() { eprintln!("{:?}", payment.interval(i)); } }
            return (bound, goal);
        }
        payment.minorants.extend(at(&more));
        payment.minorants.sort_by(|a, b| a.duration.total_cmp(&b.duration));
        payment.keep_highest();
    }
    if std::env::var("BD").is_ok() { for m in &payment.minorants { eprintln!("{:.5} {:?} {:.5}", m.duration/case.duration, m, m.at(m.duration)); } 
      for i in 0..=payment.minorants.len() { eprintln!("{:?}", payment.interval(i)); } }
    (payment.bound().0, goal)
}
