//! Motions that start and end in motion: certified, found again in larger ones, and held against an independent search.

use serde_json::Value;
use takt::budget::Budget;
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::state_to_state::{State, between};
use takt::trajectory::jerk_limited::{Demand, Fastest, fastest, fastest_between};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{Certificate, Ends, KinematicState};

use crate::jerk_limited::{bounds, problem};

/// Velocity and acceleration of every joint at a waypoint.
type Motions = Vec<[f64; 2]>;

/// A search that shares only the closed form between two states with the planner: it varies what joints do at
/// the waypoints between the ends, one joint and all together, and keeps what makes the sum of durations less.
pub struct Attack<'a> {
    waypoints: &'a [Vec<f64>],
    limits: &'a [KernelLimits],
    /// At every waypoint.
    motions: Vec<Motions>,
    /// Of the segments: what [`Self::cost`] says.
    costs: Vec<f64>,
}

impl<'a> Attack<'a> {
    /// The shortest duration found from so many `starts`: the motions of `found` at the waypoints, rest, and
    /// random ones.
    pub fn best(
        waypoints: &'a [Vec<f64>],
        limits: &'a [KernelLimits],
        ends: &Ends,
        found: &Fastest,
        starts: usize,
        random: &mut RandomStream,
    ) -> f64 {
        let mut best = f64::INFINITY;
        for start in 0..starts {
            let mut motions: Vec<Motions> = match start {
                0 => found.times.iter().map(|t| cut(found, *t, limits.len()).1).collect(),
                1 => vec![vec![[0.0; 2]; limits.len()]; waypoints.len()],
                _ => {
                    let share = 0.3 * (start - 1) as f64;
                    let row = |_: &Vec<f64>| random_motions(random, limits, share);
                    waypoints.iter().map(row).collect()
                }
            };
            motions[0].clone_from(&ends.start);
            motions[waypoints.len() - 1].clone_from(&ends.goal);
            let costs = vec![f64::INFINITY; waypoints.len() - 1];
            let mut attack = Self { waypoints, limits, motions, costs };
            attack.descend(if start == 0 { 0.1 } else { 0.5 }, random);
            best = best.min((0..attack.costs.len()).map(|segment| attack.duration(segment)).sum());
        }
        best
    }

    fn states(&self, at: usize) -> Vec<State> {
        let state = |([velocity, acceleration], position): (&[f64; 2], &f64)| State {
            position: *position,
            velocity: *velocity,
            acceleration: *acceleration,
        };
        self.motions[at].iter().zip(&self.waypoints[at]).map(state).collect()
    }

    fn duration(&self, segment: usize) -> f64 {
        let (from, to) = (self.states(segment), self.states(segment + 1));
        between(&from, &to, self.limits).map_or(f64::INFINITY, |motion| motion.durations[0])
    }

    /// The duration and, so that any joint's gain counts, a little of what each joint needs alone.
    fn cost(&self, segment: usize) -> f64 {
        let (from, to) = (self.states(segment), self.states(segment + 1));
        let alone = |j: usize| {
            between(&from[j..=j], &to[j..=j], &self.limits[j..=j])
                .map_or(f64::INFINITY, |motion| motion.durations[0])
        };
        let mean = (0..from.len()).map(alone).sum::<f64>() / from.len() as f64;
        self.duration(segment) + 1e-3 * mean
    }

    /// Takes `motions` at waypoint `at` if that costs less.
    fn attempt(&mut self, at: usize, motions: Motions) -> bool {
        let old = std::mem::replace(&mut self.motions[at], motions);
        let costs = [self.cost(at - 1), self.cost(at)];
        let better = costs[0] + costs[1] < (self.costs[at - 1] + self.costs[at]) * (1.0 - 1e-12);
        if better {
            self.costs[at - 1..=at].copy_from_slice(&costs);
        } else {
            self.motions[at] = old;
        }
        better
    }

    /// The motions at waypoint `at` with one value a step up or down, by `number`, and then with all of them anywhere near.
    fn stepped(&self, at: usize, number: usize, step: f64, random: &mut RandomStream) -> Motions {
        let mut motions = self.motions[at].clone();
        let values = motions.iter_mut().flatten();
        let limits = self.limits.iter().flat_map(|limit| &limit.derivatives[..2]);
        for (index, (value, most)) in values.zip(limits).enumerate() {
            let share = if number >= 4 * self.limits.len() {
                random.uniform(-1.0, 1.0)
            } else if number / 2 == index {
                [1.0, -1.0][number % 2]
            } else {
                0.0
            };
            *value = (*value + share * step * most).clamp(-most, *most);
        }
        motions
    }

    /// Steps as shares of the limits, halved where none gains.
    fn descend(&mut self, mut step: f64, random: &mut RandomStream) {
        self.costs = (0..self.costs.len()).map(|segment| self.cost(segment)).collect();
        while step > 1e-3 {
            let mut better = false;
            for at in 1..self.costs.len() {
                for number in 0..4 * self.limits.len() + 6 {
                    let motions = self.stepped(at, number, step, random);
                    better |= self.attempt(at, motions);
                }
            }
            if !better {
                step *= 0.5;
            }
        }
    }
}

/// What joints within their limits may do at a waypoint; `share` is about how fast they are.
fn random_motions(random: &mut RandomStream, limits: &[KernelLimits], share: f64) -> Motions {
    let mut one = |limit: &KernelLimits| {
        let [velocity, acceleration, jerk] = limit.derivatives;
        let a = acceleration * random.uniform(-1.0, 1.0);
        let v = velocity * random.uniform(-share, share).clamp(-1.0, 1.0);
        if v.abs() + a * a / (2.0 * jerk) <= velocity { [v, a] } else { [v, 0.0] }
    };
    limits.iter().map(&mut one).collect()
}

/// Joints with typical limits, and waypoints up to `spread` from zero.
fn random_problem(
    random: &mut RandomStream,
    joints: usize,
    count: usize,
    spread: f64,
) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
    let limits: Vec<KernelLimits> = (0..joints)
        .map(|_| KernelLimits {
            derivatives: [1.0, 4.0, 30.0].map(|typical| typical * random.uniform(0.3, 3.0)),
            position: [f64::NEG_INFINITY, f64::INFINITY],
        })
        .collect();
    let mut row = |_| (0..joints).map(|_| random.uniform(-spread, spread)).collect();
    ((0..count).map(&mut row).collect(), limits)
}

/// How much longer the plan of problem `number` takes than the best that the attack finds.
fn loss(number: usize, starts: usize) -> f64 {
    let mut random = RandomStream::new(77, number as u64);
    let (joints, count) = (1 + number % 6, 3 + number / 6 % 4);
    let spread = [0.3, 1.5][number % 2];
    let (waypoints, limits) = random_problem(&mut random, joints, count, spread);
    let ends = random_ends(&mut random, &limits, number / 24 % 3);
    let found = planned(&waypoints, &limits, &ends);
    check(&waypoints, &limits, &ends, &found);
    let best = Attack::best(&waypoints, &limits, &ends, &found, starts, &mut random);
    found.trajectory.duration() / best - 1.0
}

/// No other motion through the waypoints is much faster that a search of another kind finds: some of the
/// problems that the next test takes all of.
#[test]
fn an_independent_search_finds_little_that_is_faster() {
    let losses: Vec<f64> = (0..72).step_by(5).map(|number| loss(number, 4)).collect();
    let beaten = |by: f64| losses.iter().filter(|loss| **loss > by).count();
    assert!(beaten(0.005) == 0 && beaten(0.0005) <= 1, "{losses:?}");
}

/// `cargo test --release --test planning two_hundred -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes; the line above runs it"]
fn two_hundred_motions_are_hardly_beaten() {
    let losses: Vec<f64> = (0..216).map(|number| loss(number, 8)).collect();
    let beaten = |by: f64| losses.iter().filter(|loss| **loss > by).count();
    println!("of 216 beaten by 0.05, 0.5 and 2 %: {:?}", [0.0005, 0.005, 0.02].map(beaten));
    assert!(beaten(0.005) == 0 && beaten(0.0005) <= 6, "{losses:?}");
}

/// Planned without any limit of time.
fn planned(waypoints: &[Vec<f64>], limits: &[KernelLimits], ends: &Ends) -> Fastest {
    let demand = Demand { ends: Some(ends), ..Demand::new(waypoints, limits) };
    fastest_between(&demand, &Budget::default(), &mut |_| {}).unwrap()
}

/// Certified and at both states to 1e-9.
fn check(waypoints: &[Vec<f64>], limits: &[KernelLimits], ends: &Ends, found: &Fastest) {
    let due: Vec<(f64, &[f64])> =
        found.times.iter().zip(waypoints).map(|(t, row)| (*t, row.as_slice())).collect();
    found.trajectory.validate(limits.len()).unwrap();
    let certificate = Certificate::joined(&found.trajectory, &bounds(limits), &due, Some(ends));
    assert!(certificate.lawful, "{:?}", certificate.violations);
    assert!(certificate.waypoint_error.unwrap() <= 1e-9);
    let mut state = KinematicState::new(limits.len());
    for (t, end) in [(0.0, &ends.start), (found.trajectory.duration(), &ends.goal)] {
        found.trajectory.sample(t, &mut state);
        for (joint, [v, a]) in end.iter().enumerate() {
            let [velocity, acceleration] = [state.velocity[joint], state.acceleration[joint]];
            assert!((velocity - v).abs() <= 1e-9, "{t}: {velocity} {v}");
            assert!((acceleration - a).abs() <= 1e-9, "{t}: {acceleration} {a}");
        }
    }
}

/// The motion of `found` at `t`: positions, and velocities with accelerations.
fn cut(found: &Fastest, t: f64, joints: usize) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut state = KinematicState::new(joints);
    found.trajectory.sample(t, &mut state);
    let ends = state.velocity.iter().zip(&state.acceleration).map(|(v, a)| [*v, *a]);
    (state.position.clone(), ends.collect())
}

/// A part of a fastest motion takes no longer than it did in the whole, up to gaps that hide it from
/// the search: in most cases the part is found again.
#[test]
fn parts_of_fastest_motions_are_found_again() {
    let problems: Vec<Value> =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    let mut random = RandomStream::new(7, 0);
    let (mut cases, mut found_again) = (0, 0);
    for value in &problems {
        let (waypoints, limits) = problem(value);
        if limits.iter().any(|limit| limit.derivatives[2].is_infinite()) {
            continue;
        }
        let (whole, n) = (fastest(&waypoints, &limits), waypoints.len());
        let total = whole.trajectory.duration();
        let from = random.uniform(0.0, 0.9) * whole.times[1];
        let to = total - random.uniform(0.0, 0.9) * (total - whole.times[n - 2]);
        for (moves_off, arrives) in [(true, false), (false, true), (true, true)] {
            let (mut rows, mut ends) = (waypoints.clone(), Ends::at_rest(limits.len()));
            let mut expected = total;
            if moves_off {
                (rows[0], ends.start) = cut(&whole, from, limits.len());
                expected -= from;
            }
            if arrives {
                (rows[n - 1], ends.goal) = cut(&whole, to, limits.len());
                expected -= total - to;
            }
            let found = planned(&rows, &limits, &ends);
            check(&rows, &limits, &ends, &found);
            assert!(found.trajectory.duration() <= found.stopping && found.lower == 0.0);
            cases += 1;
            found_again += usize::from(found.trajectory.duration() <= 1.001 * expected);
        }
    }
    assert!(cases == 30 && found_again >= 26, "{found_again} of {cases}");
}

/// States that joints can have within their limits, at both ends or at one.
fn random_ends(random: &mut RandomStream, limits: &[KernelLimits], which: usize) -> Ends {
    let mut end = |moves: bool, sign: f64| -> Vec<[f64; 2]> {
        let one = |limit: &KernelLimits| {
            let [velocity, acceleration, jerk] = limit.derivatives.map(|limit| limit.min(100.0));
            // A third of the joints goes as fast as it may, as a robot on its way does.
            let a = acceleration * random.uniform(-1.0, 1.0);
            let v = velocity * random.uniform(-1.5, 1.5).clamp(-1.0, 1.0);
            let carried = v + sign * a * a.abs() / (2.0 * jerk);
            if carried.abs() <= velocity { [v, a] } else { [v, 0.0] }
        };
        if moves { limits.iter().map(one).collect() } else { vec![[0.0; 2]; limits.len()] }
    };
    Ends { start: end(which != 1, 1.0), goal: end(which != 0, -1.0) }
}

/// Never slower than the closed forms next to the ends with the fastest motion between them.
#[test]
fn random_ends_are_met_within_limits_and_no_slower_than_with_stops() {
    let mut random = RandomStream::new(8, 0);
    let mut faster = 0;
    for number in 0..150 {
        let (joints, count) = (1 + number % 4, 2 + number % 7);
        let (waypoints, limits) = random_problem(&mut random, joints, count, 1.5);
        let ends = random_ends(&mut random, &limits, number % 3);
        let found = planned(&waypoints, &limits, &ends);
        check(&waypoints, &limits, &ends, &found);
        let duration = found.trajectory.duration();
        if count == 2 {
            assert_eq!((duration, found.iterations), (found.lower, 0));
            continue;
        }
        let head = planned(&waypoints[..2], &limits, &ends.only(true, false));
        let rest = planned(&waypoints[1..], &limits, &ends.only(false, true));
        let stops = head.trajectory.duration() + rest.trajectory.duration();
        if number % 3 == 0 {
            // The rest is planned in two directions here, and with stops in one: they end within this.
            assert!(duration <= stops * (1.0 + 1e-4), "{number}: {duration} {stops}");
        }
        faster += usize::from(duration < 0.999 * stops);
    }
    assert!(faster > 70, "{faster}");
}

/// Where the programme tells what limits hold back, higher limits save that much.
#[test]
fn gains_of_motions_between_ends_in_motion_are_what_higher_limits_save() {
    let (mut told, mut random) = (0, RandomStream::new(9, 0));
    for number in 0..12 {
        let (waypoints, limits) = random_problem(&mut random, 1 + number % 3, 4, 1.5);
        let ends = random_ends(&mut random, &limits, number % 3);
        let found = planned(&waypoints, &limits, &ends);
        let duration = found.trajectory.duration();
        for order in 0..3 {
            let gain: f64 = found.gains.iter().flatten().map(|gains| gains[order]).sum();
            let mut higher = limits.clone();
            higher.iter_mut().for_each(|limit| limit.derivatives[order] *= 1.01);
            let saved = duration - planned(&waypoints, &higher, &ends).trajectory.duration();
            if gain > 0.02 * duration {
                told += 1;
                let told = 0.01 * gain;
                assert!(
                    (saved - told).abs() <= 0.2 * told + 2e-4 * duration,
                    "{number} {order}: {told} {saved}"
                );
            }
        }
    }
    assert!(told > 15, "{told}");
}

/// A list longer than a programme.
#[test]
fn long_lists_are_met_in_motion_at_both_ends() {
    let mut random = RandomStream::new(10, 0);
    for count in [18, 19, 40] {
        let (waypoints, limits) = random_problem(&mut random, 3, count, 1.5);
        let ends = random_ends(&mut random, &limits, 2);
        let found = planned(&waypoints, &limits, &ends);
        check(&waypoints, &limits, &ends, &found);
        // Not much longer than from rest to rest, which has to get up to speed but goes where it likes.
        let (duration, rest) = (found.trajectory.duration(), fastest(&waypoints, &limits));
        let brakes = 2.0
            * (0..3)
                .map(|joint| limits[joint].derivatives[0] / limits[joint].derivatives[1])
                .fold(0.0, f64::max);
        assert!(duration < rest.trajectory.duration() + 4.0 * brakes, "{count}: {duration}");
    }
}
