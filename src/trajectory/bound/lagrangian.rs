//! A lower bound from prices: every segment is paid for alone.
//!
//! A joint must enter a segment as it left the one before. A price on that turns one problem into one per
//! segment: the least `h + sum over joints of (p · s - p' · s')` over all durations `h` and all lawful curves of that
//! duration, `s` and `s'` being the states at its ends. What one segment pays the next gets back, so that the sum of
//! these least payments is below the duration of every lawful trajectory, whatever the prices (Lagrangian
//! duality). For given `h` the joints pay independently, see [`super::segment`]; over `h` the least payment
//! is found by dividing its range.

use super::segment::{Case, Minorant, minorants};

/// Prices of the states at waypoints; any are valid, good ones are the multipliers of a good trajectory.
///
/// `[segment][joint]`: what velocity and acceleration cost where a segment starts, s per rad/s and per
/// rad/s². Those of the first segment do not count.
pub type Prices = Vec<Vec<[f64; 2]>>;

/// Durations tried first, relative to those of the trajectory.
const FIRST: [f64; 6] = [0.9, 0.97, 1.0, 1.03, 1.12, 1.5];

/// Rounds in which durations are added where the bound is lowest.
const ROUNDS: usize = 6;

/// Durations added in a round.
const MORE: usize = 3;

/// What a segment's bound may be below the payment at the trajectory's own duration, as a share of that.
const TOLERANCE: f64 = 5e-4;

/// The payment for one segment, bounded below by minorants.
struct Payment<'a> {
    /// One per joint.
    cases: &'a [Case],
    /// By duration.
    minorants: Vec<Minorant>,
    range: [f64; 2],
    /// The bound at the trajectory's own duration: no more can be proven.
    goal: f64,
}

impl Payment<'_> {
    /// Adds minorants made at `durations` where they are in range; drops those that
    /// are below others where they were made.
    fn add(&mut self, durations: &[f64]) {
        let [shortest, longest] = self.range;
        let inside = durations.iter().filter(|h| **h > shortest && **h < longest);
        let cases: Vec<Case> = inside
            .flat_map(|&duration| self.cases.iter().map(move |case| Case { duration, ..*case }))
            .collect();
        let found = minorants(&cases);
        self.minorants.extend(found.chunks(self.cases.len()).map(Minorant::sum));
        self.minorants.sort_by(|a, b| a.duration.total_cmp(&b.duration));
        let all = self.minorants.clone();
        let highest = |m: &Minorant| all.iter().all(|o| o.at(m.duration) <= m.at(m.duration));
        self.minorants.retain(highest);
    }

    /// The least value between minorants `at - 1` and `at`, and a duration between.
    fn interval(&self, at: usize) -> (f64, f64) {
        let count = self.minorants.len();
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

    /// The proven bound, and durations where more would raise it.
    fn bound(&self) -> (f64, Vec<f64>) {
        if self.minorants.is_empty() {
            return (f64::NEG_INFINITY, Vec::new());
        }
        let enough = self.goal * (1.0 - TOLERANCE);
        let mut low: Vec<(f64, f64)> =
            (0..=self.minorants.len()).map(|at| self.interval(at)).collect();
        let bound = low.iter().map(|low| low.0).fold(f64::INFINITY, f64::min);
        low.retain(|low| low.0 < enough);
        low.sort_by(|a, b| a.0.total_cmp(&b.0));
        low.truncate(MORE);
        (bound, low.into_iter().map(|low| low.1).collect())
    }

    /// Adds minorants until the bound is as high as it gets.
    fn least(mut self, own: f64) -> f64 {
        self.add(&FIRST.map(|factor| factor * own));
        let found = self.minorants.iter().find(|m| m.duration == own);
        self.goal = found.map_or(0.0, |m| m.at(own));
        for _ in 0..ROUNDS {
            let (_, more) = self.bound();
            if more.is_empty() {
                break;
            }
            self.add(&more);
        }
        if std::env::var("GAP").is_ok() {
            let b = self.bound().0;
            eprintln!("goal {:.5} bound {b:.5} own {own:.4} range {:?} n {}", self.goal, self.range, self.minorants.len());
            if self.goal - b > 0.003 * own {
                for (i, m) in self.minorants.iter().enumerate() { eprintln!("   {:.4} : {:.5} | {:.5}", m.duration / own, m.at(m.duration), self.interval(i).0); }
                eprintln!("   end {:.5}", self.interval(self.minorants.len()).0);
            }
        }
        self.bound().0
    }
}

/// A duration below which no lawful trajectory along `ways[segment][joint]` exists, from rest
/// to rest, if one of these `durations` exists.
pub fn bound(ways: &[Vec<f64>], limits: &[[f64; 3]], durations: &[f64], prices: &Prices) -> f64 {
    let upper: f64 = durations.iter().sum();
    let limits: Vec<[f64; 3]> = limits.iter().map(|limit| implied(*limit, upper)).collect();
    let least: Vec<f64> = ways
        .iter()
        .map(|row| row.iter().zip(&limits).map(|(w, l)| w.abs() / l[0]).fold(0.0, f64::max))
        .collect();
    let all_least: f64 = least.iter().sum();
    let segment = |segment: usize| {
        let cases: Vec<Case> =
            (0..limits.len()).map(|joint| case(ways, &limits, prices, segment, joint)).collect();
        let range = [least[segment], upper - (all_least - least[segment])];
        let payment = Payment { cases: &cases, minorants: Vec::new(), range, goal: 0.0 };
        payment.least(durations[segment])
    };
    // Whatever is not shorter than the trajectory need not be bounded.
    (0..ways.len()).map(segment).sum::<f64>().min(upper)
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
    prices: &Prices,
    segment: usize,
    joint: usize,
) -> Case {
    // Where jerk has no limit, acceleration at a waypoint means nothing.
    let smooth = if limits[joint][2].is_finite() { 1.0 } else { 0.0 };
    let state = |segment: usize| {
        let [v, a] = prices[segment][joint];
        [v, a * smooth]
    };
    let last = segment + 1 == ways.len();
    let (way, limits) = (ways[segment][joint], limits[joint]);
    let rest = [0.0; 2];
    match (segment > 0, last) {
        (false, _) => {
            let leave = if last { rest } else { state(1) };
            Case { duration: 0.0, way, limits, enter: rest, leave, from_rest: true }
        }
        (true, false) => Case {
            duration: 0.0,
            way,
            limits,
            enter: state(segment),
            leave: state(segment + 1),
            from_rest: false,
        },
        (true, true) => {
            // Backwards in time it starts at rest.
            let [v, a] = state(segment);
            Case { duration: 0.0, way: -way, limits, enter: rest, leave: [v, -a], from_rest: true }
        }
    }
}
