//! An independent search for motions faster than the planned ones.
//!
//! It knows nothing of cells, barriers or windows. Its variables are velocity and acceleration of every joint at every
//! waypoint between the ends, its law is the exact motion between two states
//! ([`between`], itself tested against published code), its method is descent along slopes found by
//! differences, over a maximum smoothed less and less. It starts from the plan, from rest and from speeds that
//! a person would guess, so it finds both small improvements and other valleys.

use std::ops::Range;
use std::thread;

use takt::math::random::RandomStream;
use takt::trajectory::KinematicState;
use takt::trajectory::jerk_limited::state_to_state::{State, between};
use takt::trajectory::jerk_limited::{Fastest, fastest};
use takt::trajectory::kernel::KernelLimits;

use crate::jerk_limited::nasty;

/// Steps of one descent.
const STEPS: u32 = 200;

/// `[waypoint][joint]`: position, velocity, acceleration.
type States = Vec<Vec<State>>;

/// Waypoints, limits, and each joint's units of velocity and acceleration.
struct Attack<'a> {
    waypoints: &'a [Vec<f64>],
    limits: &'a [KernelLimits],
    units: Vec<[f64; 2]>,
}

impl<'a> Attack<'a> {
    /// Units are the plan's peaks where there are no lower limits.
    fn new(waypoints: &'a [Vec<f64>], limits: &'a [KernelLimits], plan: &Fastest) -> Self {
        let mut units: Vec<[f64; 2]> =
            limits.iter().map(|limit| [limit.derivatives[0], limit.derivatives[1]]).collect();
        let mut peaks = vec![[1e-9f64; 2]; limits.len()];
        let mut sample = KinematicState::new(limits.len());
        for step in 0..=200 {
            plan.trajectory
                .sample(plan.trajectory.duration() * f64::from(step) / 200.0, &mut sample);
            for (joint, [v, a]) in peaks.iter_mut().enumerate() {
                *v = v.max(sample.velocity[joint].abs());
                *a = a.max(sample.acceleration[joint].abs());
            }
        }
        for (unit, peak) in units.iter_mut().zip(peaks) {
            *unit = [unit[0].min(peak[0]), unit[1].min(peak[1])];
        }
        Self { waypoints, limits, units }
    }

    /// States at rest.
    fn rest(&self) -> States {
        let state = |&position: &f64| State { position, ..State::default() };
        self.waypoints.iter().map(|row| row.iter().map(state).collect()).collect()
    }

    /// How long one joint takes over one segment, infinite if its states are unlawful.
    fn alone(&self, states: &States, segment: usize, joint: usize) -> f64 {
        let [start, goal] = [states[segment][joint], states[segment + 1][joint]];
        let motion = between(&[start], &[goal], &self.limits[joint..=joint]);
        motion.map_or(f64::INFINITY, |motion| motion.duration())
    }

    /// How long all joints take together.
    fn duration(&self, states: &States) -> f64 {
        let segment = |pair: &[Vec<State>]| {
            let motion = between(&pair[0], &pair[1], self.limits);
            motion.map_or(f64::INFINITY, |motion| motion.duration())
        };
        states.windows(2).map(segment).sum()
    }

    /// Each joint's share in a smooth maximum over the joints of a segment, for slopes.
    fn shares(&self, times: &[Vec<f64>], sharpness: f64) -> Vec<Vec<f64>> {
        let share = |row: &Vec<f64>| {
            let most = row.iter().copied().fold(0.0, f64::max);
            let weights = row.iter().map(|t| (sharpness * (t / most - 1.0)).exp());
            let weights: Vec<f64> = weights.collect();
            let sum: f64 = weights.iter().sum();
            weights.iter().map(|weight| weight / sum).collect()
        };
        times.iter().map(share).collect()
    }

    /// Slopes of the smoothed duration over velocities and accelerations, in their units.
    fn slopes(&self, states: &mut States, sharpness: f64) -> Vec<f64> {
        let (segments, joints) = (self.waypoints.len() - 1, self.limits.len());
        let row = |segment| (0..joints).map(|j| self.alone(states, segment, j)).collect();
        let times: Vec<Vec<f64>> = (0..segments).map(row).collect();
        let shares = self.shares(&times, sharpness);
        let mut slopes = Vec::new();
        for waypoint in 1..segments {
            for joint in 0..joints {
                for order in 0..2 {
                    let step = 1e-5 * self.units[joint][order];
                    let kept = states[waypoint][joint];
                    let value = |sign: f64, states: &mut States| {
                        let mut state = kept;
                        *[&mut state.velocity, &mut state.acceleration][order] += sign * step;
                        states[waypoint][joint] = state;
                        shares[waypoint - 1][joint] * self.alone(states, waypoint - 1, joint)
                            + shares[waypoint][joint] * self.alone(states, waypoint, joint)
                    };
                    let slope = (value(1.0, states) - value(-1.0, states)) / 2e-5;
                    states[waypoint][joint] = kept;
                    slopes.push(if slope.is_finite() { slope } else { 0.0 });
                }
            }
        }
        slopes
    }

    /// The shortest duration met on a descent from `states` (Kingma and Ba, Adam, arXiv:1412.6980, with
    /// falling steps).
    fn descend(&self, mut states: States) -> f64 {
        let mut best = self.duration(&states);
        let joints = self.limits.len();
        let count = (self.waypoints.len() - 2) * joints * 2;
        let (mut mean, mut square) = (vec![0.0; count], vec![0.0; count]);
        for step in 0..STEPS {
            let progress = f64::from(step) / f64::from(STEPS);
            let slopes = self.slopes(&mut states, 20.0 * 1000f64.powf(progress));
            let rate = 0.05 * 1e-4f64.powf(progress);
            for (index, slope) in slopes.iter().enumerate() {
                mean[index] = 0.8 * mean[index] + 0.2 * slope;
                square[index] = 0.95 * square[index] + 0.05 * slope * slope;
                let change = -rate * mean[index] / (square[index].sqrt() + 1e-12);
                let (joint, order) = (index / 2 % joints, index % 2);
                let state = &mut states[1 + index / 2 / joints][joint];
                *[&mut state.velocity, &mut state.acceleration][order] +=
                    change * self.units[joint][order];
            }
            self.confine(&mut states);
            best = best.min(self.duration(&states));
        }
        best
    }

    /// Brings every state back to those from which and to which a lawful motion exists.
    fn confine(&self, states: &mut States) {
        for row in states {
            for (state, limit) in row.iter_mut().zip(self.limits) {
                let [velocity, acceleration, jerk] = limit.derivatives;
                state.acceleration = state.acceleration.clamp(-acceleration, acceleration);
                let carried = if jerk.is_finite() {
                    let most = (2.0 * jerk * velocity * 0.999).sqrt();
                    state.acceleration = state.acceleration.clamp(-most, most);
                    state.acceleration * state.acceleration / (2.0 * jerk)
                } else {
                    0.0
                };
                let most = (velocity * (1.0 - 1e-9) - carried).max(0.0);
                state.velocity = state.velocity.clamp(-most, most);
            }
        }
    }

    /// The states of a plan.
    fn of(&self, found: &Fastest) -> States {
        let mut states = self.rest();
        let mut sample = KinematicState::new(self.limits.len());
        let last = states.len() - 1;
        for (row, t) in states[1..last].iter_mut().zip(&found.times[1..last]) {
            found.trajectory.sample(*t, &mut sample);
            for (joint, state) in row.iter_mut().enumerate() {
                state.velocity = sample.velocity[joint];
                state.acceleration = sample.acceleration[joint];
            }
        }
        self.confine(&mut states);
        states
    }

    /// States a person would guess: where both neighbours lie on different sides, some share of
    /// the speed that leads from one to the other.
    fn guess(&self, durations: &[f64], random: &mut RandomStream) -> States {
        let mut states = self.rest();
        let last = states.len() - 1;
        for (waypoint, row) in states.iter_mut().enumerate().take(last).skip(1) {
            for (joint, state) in row.iter_mut().enumerate() {
                let at = |waypoint: usize| self.waypoints[waypoint][joint];
                let [before, after] =
                    [at(waypoint) - at(waypoint - 1), at(waypoint + 1) - at(waypoint)];
                let time = durations[waypoint - 1] + durations[waypoint];
                let through = if before * after > 0.0 { (before + after) / time } else { 0.0 };
                state.velocity = through * random.uniform(0.5, 2.0);
                state.acceleration = self.units[joint][1] * random.uniform(-0.2, 0.2);
            }
        }
        self.confine(&mut states);
        states
    }
}

/// What the search found, relative to the plan's duration.
struct Found {
    /// The best of all.
    best: f64,
    /// The best that does not come from the plan.
    elsewhere: f64,
}

/// Searches from the plan and from elsewhere.
fn search(waypoints: &[Vec<f64>], limits: &[KernelLimits], seed: u64) -> Found {
    let plan = fastest(waypoints, limits);
    let attack = Attack::new(waypoints, limits, &plan);
    let mut random = RandomStream::new(5, seed);
    let starts = [
        attack.rest(),
        attack.guess(&plan.durations, &mut random),
        attack.guess(&plan.durations, &mut random),
    ];
    let duration = plan.trajectory.duration();
    let elsewhere = starts.map(|states| attack.descend(states)).into_iter();
    let elsewhere = elsewhere.fold(f64::INFINITY, f64::min) / duration;
    let near = attack.descend(attack.of(&plan)) / duration;
    Found { best: elsewhere.min(near), elsewhere }
}

/// Limits with which motions between states exist: speed alone lets velocity jump.
fn with_ramps(mut limits: Vec<KernelLimits>) -> Vec<KernelLimits> {
    for limit in &mut limits {
        if limit.derivatives[1].is_infinite() && limit.derivatives[2].is_infinite() {
            limit.derivatives[1] = 1e3;
        }
    }
    limits
}

/// Searches for the problems of `seeds` with more than two waypoints; returns those that are beaten by more than 0.5 %
/// and the share of problems in which the search comes within 1 % of the plan from elsewhere.
fn survey(seeds: Range<u64>) -> (Vec<String>, f64) {
    let (mut beaten, mut near, mut count) = (Vec::new(), 0, 0);
    for seed in seeds {
        let (waypoints, limits) = nasty(seed);
        if waypoints.len() < 3 {
            continue;
        }
        let found = search(&waypoints, &with_ramps(limits), seed);
        if found.best < 1.0 / 1.005 {
            beaten.push(format!("problem {seed}: {} of the plan", found.best));
        }
        near += usize::from(found.elsewhere < 1.01);
        count += 1;
    }
    (beaten, f64::from(u32::try_from(near).unwrap()) / f64::from(count))
}

#[test]
fn no_search_beats_a_plan() {
    let (beaten, near) = survey(0..24);
    assert!(beaten.is_empty(), "{beaten:#?}");
    assert!(near > 0.5, "the search is of no use: it comes near {near} of the plans");
}

/// `cargo test --release --test planning no_long_search -- --ignored --nocapture`
#[test]
#[ignore = "takes half an hour; the line above runs it"]
fn no_long_search_beats_ten_thousand_plans() {
    let halves = [0..5_000, 5_000..10_000];
    let found: Vec<(Vec<String>, f64)> = thread::scope(|scope| {
        let runs = halves.map(|seeds| scope.spawn(|| survey(seeds)));
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    for (beaten, near) in &found {
        println!("comes near {near} of the plans, beats {}: {beaten:#?}", beaten.len());
    }
    assert!(found.iter().all(|(beaten, _)| beaten.is_empty()));
}
