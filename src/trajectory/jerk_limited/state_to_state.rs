//! The fastest motion between two states of motion, and to rest.
//!
//! Each joint's lawful durations are those at which its way lies between the farthest and the
//! least displacement ([`Reach`]): intervals that start and end where the way equals one of the two. The
//! smallest duration that lies in an interval of every joint is the motion's.
//! A joint whose way is then one of the extremes takes that extreme motion; any other mixes both
//! in the share that gives its way, which is lawful because limits are convex.
//!
//! The problem is that of Berscheid and Kröger (Jerk-limited Real-time Trajectory Generation with
//! Arbitrary Target States, RSS 2021, doi:10.15607/RSS.2021.XVII.015). Deviation: they list the profiles that
//! may be optimal and solve each; here one curve holds all of them.

use std::ops::Range;

use crate::trajectory::kernel::KernelLimits;

use super::profile::{Motion, Phase};
use super::reach::{NOISE, Reach, Strokes, rise_to_rest};

/// What rounding may add to a limit or take from a duration, relative to it.
const ROUNDING: f64 = 1e-12;

/// A joint's state of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Position, rad or m.
    pub position: f64,
    /// Velocity, rad/s or m/s.
    pub velocity: f64,
    /// Acceleration, rad/s² or m/s². Of no meaning where jerk has no limit.
    pub acceleration: f64,
}

/// Which of both states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Where the motion starts.
    Start,
    /// Where it ends.
    Goal,
}

impl std::fmt::Display for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Goal => "goal",
        })
    }
}

/// Why there is no motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StateFault {
    /// Start, goal and limits are not of the same number of joints, or of none.
    #[error(
        "{start} start states, {goal} goal states and {limits} limits: must be the same number and at least one"
    )]
    Joints {
        /// Number of start states.
        start: usize,
        /// Number of goal states.
        goal: usize,
        /// Number of joints with limits.
        limits: usize,
    },
    /// A limit is not a positive number.
    #[error("joint {joint}: {quantity} limit {value} must be above 0")]
    Limit {
        /// Which joint, from 0.
        joint: usize,
        /// What is limited.
        quantity: &'static str,
        /// The limit.
        value: f64,
    },
    /// Neither acceleration nor jerk has a limit.
    #[error("joint {joint}: acceleration or jerk must have a limit")]
    Unlimited {
        /// Which joint, from 0.
        joint: usize,
    },
    /// A value is not a finite number.
    #[error("joint {joint}: {end} {quantity} {value} must be a finite number")]
    NotFinite {
        /// Which joint, from 0.
        joint: usize,
        /// In which state.
        end: End,
        /// What it is.
        quantity: &'static str,
        /// The value.
        value: f64,
    },
    /// A value is beyond its limit.
    #[error("joint {joint}: {end} {quantity} {value} is beyond its limit {limit}")]
    Beyond {
        /// Which joint, from 0.
        joint: usize,
        /// In which state.
        end: End,
        /// What it is.
        quantity: &'static str,
        /// The value.
        value: f64,
        /// The limit, with its sign.
        limit: f64,
    },
    /// The limit of jerk does not let acceleration come to zero before velocity has passed its
    /// limit (at the goal: come from zero after).
    #[error(
        "joint {joint}: {end} velocity {velocity} with acceleration {acceleration} means velocity {peak} at zero acceleration, beyond its limit {limit}"
    )]
    Carried {
        /// Which joint, from 0.
        joint: usize,
        /// In which state.
        end: End,
        /// Velocity there.
        velocity: f64,
        /// Acceleration there.
        acceleration: f64,
        /// Velocity at zero acceleration.
        peak: f64,
        /// The limit, with its sign.
        limit: f64,
    },
    /// Values so far apart that the motion is no number.
    #[error("the values are too far apart in magnitude to compute with")]
    Overflow,
}

/// The fastest motion from `start` to `goal` within `limits` (which may be infinite, though
/// not of acceleration and jerk both), one segment whose positions count from the start.
///
/// Position limits hold for the ends only: on the way a joint that starts fast may have to leave them.
/// The goal is met to rounding. Where the states allow just one displacement in a while and the next
/// chance is far, what the states' own rounding may change in it counts as met.
///
/// # Errors
///
/// All that is wrong with states and limits.
pub fn between(
    start: &[State],
    goal: &[State],
    limits: &[KernelLimits],
) -> Result<Motion, Vec<StateFault>> {
    let faults = check(start, Some(goal), limits);
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut windows = Windows::default();
    let ends = start.iter().zip(goal).zip(limits);
    let joints: Vec<Joint> = ends.map(|((s, g), l)| Joint::new(s, g, l, &mut windows)).collect();
    let duration = common(joints.iter().map(|joint| &windows.all[joint.windows.clone()]));
    if !duration.is_finite() {
        return Err(vec![StateFault::Overflow]);
    }
    let phases: Vec<_> = joints.iter().map(|joint| vec![joint.phases(duration)]).collect();
    finished(duration, phases)
}

/// The fastest way to rest, wherever that is; a joint that rests before others waits for them.
///
/// # Errors
///
/// All that is wrong with states and limits.
pub fn brake(start: &[State], limits: &[KernelLimits]) -> Result<Motion, Vec<StateFault>> {
    let faults = check(start, None, limits);
    if !faults.is_empty() {
        return Err(faults);
    }
    let stop = |(start, limit): (&State, &KernelLimits)| {
        let scale = Scale::new(limit);
        let [v, a] = scale.motion(start);
        let lag = if scale.ramp > 0.0 { a } else { 0.0 };
        // Whether velocity would stay below zero once acceleration is gone.
        let sign = if v + lag * lag.abs() / 2.0 <= 0.0 { 1.0 } else { -1.0 };
        scale.phases(&rise_to_rest(sign * v, sign * a, scale.ramp), sign, start)
    };
    let mut phases: Vec<_> = start.iter().zip(limits).map(|pair| vec![stop(pair)]).collect();
    let end = |phase: &Phase| phase.start + phase.length;
    let ends = phases.iter().flatten().flatten().map(end);
    let duration = ends.fold(0.0, f64::max);
    for joint in phases.iter_mut().flatten() {
        let Some(last) = joint.last() else { continue };
        let (start, [x, ..]) = (end(last), last.at(last.length));
        if start < duration {
            joint.push(Phase { start, length: duration - start, state: [x, 0.0, 0.0, 0.0] });
        }
    }
    finished(duration, phases)
}

fn finished(duration: f64, phases: Vec<Vec<Vec<Phase>>>) -> Result<Motion, Vec<StateFault>> {
    let whole = |phase: &Phase| phase.state.iter().all(|value| value.is_finite());
    if !duration.is_finite() || !phases.iter().flatten().flatten().all(whole) {
        return Err(vec![StateFault::Overflow]);
    }
    // Nothing follows that could put a price on a state.
    let prices = vec![vec![[0.0; 3]; phases.len()]];
    let gains = vec![vec![[0.0; 3]; phases.len()]];
    Ok(Motion { durations: vec![duration], prices, gains, phases })
}

/// All that is wrong with states and limits; without `goal`, to come to rest anywhere.
pub fn check(start: &[State], goal: Option<&[State]>, limits: &[KernelLimits]) -> Vec<StateFault> {
    let goals = goal.map_or(start.len(), <[State]>::len);
    if start.is_empty() || goals != start.len() || limits.len() != start.len() {
        return vec![StateFault::Joints { start: start.len(), goal: goals, limits: limits.len() }];
    }
    let mut faults = Vec::new();
    for (joint, limit) in limits.iter().enumerate() {
        let before = faults.len();
        limit_faults(joint, limit, &mut faults);
        if faults.len() == before && !Scale::new(limit).length().is_normal() {
            faults.push(StateFault::Overflow);
        }
        if faults.len() > before {
            continue;
        }
        state_faults(joint, End::Start, &start[joint], limit, &mut faults);
        if let Some(goal) = goal {
            state_faults(joint, End::Goal, &goal[joint], limit, &mut faults);
        }
    }
    faults
}

fn limit_faults(joint: usize, limit: &KernelLimits, faults: &mut Vec<StateFault>) {
    for (quantity, value) in ["velocity", "acceleration", "jerk"].into_iter().zip(limit.derivatives)
    {
        if value.is_nan() || value <= 0.0 {
            faults.push(StateFault::Limit { joint, quantity, value });
        }
    }
    let [_, acceleration, jerk] = limit.derivatives;
    if acceleration.is_infinite() && jerk.is_infinite() {
        faults.push(StateFault::Unlimited { joint });
    }
}

fn state_faults(
    joint: usize,
    end: End,
    state: &State,
    limit: &KernelLimits,
    faults: &mut Vec<StateFault>,
) {
    let State { position, velocity, acceleration } = *state;
    let [speed, most, jerk] = limit.derivatives;
    let [lower, upper] = limit.position;
    let before = faults.len();
    let ranges = [
        ("position", position, lower, upper),
        ("velocity", velocity, -speed, speed),
        ("acceleration", acceleration, -most, most),
    ];
    for (quantity, value, lower, upper) in ranges {
        if !value.is_finite() {
            faults.push(StateFault::NotFinite { joint, end, quantity, value });
        } else if value < lower - ROUNDING * lower.abs() {
            faults.push(StateFault::Beyond { joint, end, quantity, value, limit: lower });
        } else if value > upper + ROUNDING * upper.abs() {
            faults.push(StateFault::Beyond { joint, end, quantity, value, limit: upper });
        }
    }
    // Where acceleration comes to zero after the start or did so before the goal.
    let change = acceleration * acceleration.abs() / (2.0 * jerk);
    let peak = if end == End::Start { velocity + change } else { velocity - change };
    if faults.len() == before && peak.abs() > speed * (1.0 + ROUNDING) {
        let limit = libm::copysign(speed, peak);
        faults.push(StateFault::Carried { joint, end, velocity, acceleration, peak, limit });
    }
}

/// The units of [`Reach`].
#[derive(Clone, Copy, Debug)]
struct Scale {
    time: f64,
    acceleration: f64,
    jerk: f64,
    /// As [`Reach::new`] takes it.
    ramp: f64,
}

impl Scale {
    fn new(limit: &KernelLimits) -> Self {
        let [_, acceleration, jerk] = limit.derivatives;
        if jerk.is_infinite() {
            Self { time: 1.0, acceleration, jerk: 0.0, ramp: 0.0 }
        } else if acceleration.is_infinite() {
            Self { time: 1.0, acceleration: jerk, jerk, ramp: acceleration }
        } else {
            Self { time: acceleration / jerk, acceleration, jerk, ramp: 1.0 }
        }
    }

    fn velocity(&self) -> f64 {
        self.acceleration * self.time
    }

    fn length(&self) -> f64 {
        self.velocity() * self.time
    }

    /// Velocity and acceleration in these units.
    fn motion(&self, state: &State) -> [f64; 2] {
        [state.velocity / self.velocity(), state.acceleration / self.acceleration]
    }

    /// The motion of `strokes`, mirrored if `sign` is negative.
    fn phases(&self, strokes: &Strokes, sign: f64, start: &State) -> Vec<Phase> {
        let mut course = Course::new(start);
        for &[length, acceleration, jerk] in strokes {
            if length > 0.0 {
                let rates = [sign * acceleration * self.acceleration, sign * jerk * self.jerk];
                course.push(length * self.time, rates);
            }
        }
        course.phases
    }
}

/// Phases one after the other.
struct Course {
    phases: Vec<Phase>,
    /// As [`Phase::at`] gives it.
    end: [f64; 4],
    time: f64,
}

impl Course {
    fn new(start: &State) -> Self {
        Self {
            phases: Vec::with_capacity(14),
            end: [0.0, start.velocity, f64::NAN, 0.0],
            time: 0.0,
        }
    }

    fn push(&mut self, length: f64, [a, j]: [f64; 2]) {
        let [x, v, before, _] = self.end;
        match self.phases.last_mut() {
            // A joint that waits for others does so in one phase.
            Some(last) if last.state[3] == j && before == a => {
                last.length += length;
                self.end = last.at(last.length);
            }
            _ => {
                let phase = Phase { start: self.time, length, state: [x, v, a, j] };
                self.end = phase.at(length);
                self.phases.push(phase);
            }
        }
        self.time += length;
    }
}

/// One joint's problem, in its units.
struct Joint<'a> {
    start: &'a State,
    scale: Scale,
    way: f64,
    up: Reach,
    /// That of the mirrored states.
    down: Reach,
    windows: Range<usize>,
}

impl<'a> Joint<'a> {
    fn new(start: &'a State, goal: &State, limit: &KernelLimits, windows: &mut Windows) -> Self {
        let scale = Scale::new(limit);
        let ([v0, a0], [v1, a1]) = (scale.motion(start), scale.motion(goal));
        let speed = limit.derivatives[0] / scale.velocity();
        let up = Reach::new([v0, v1], [a0, a1], speed, scale.ramp);
        let down = Reach::new([-v0, -v1], [-a0, -a1], speed, scale.ramp);
        let way = (goal.position - start.position) / scale.length();
        let ([time, noise], other) = (up.noise(), down.noise());
        let positions = (start.position.abs() + goal.position.abs()) / scale.length();
        let slack = 8.0 * f64::EPSILON * positions + noise.max(other[1]);
        let together = time.max(other[0]);
        let windows = windows.add([&up, &down], way, [together, slack], scale.time);
        Self { start, scale, way, up, down, windows }
    }

    /// The motion of exactly `duration`, which must be lawful.
    fn phases(&self, duration: f64) -> Vec<Phase> {
        let time = duration / self.scale.time;
        let most = self.up.displacement(time);
        let least = -self.down.displacement(time);
        let slack = NOISE * (most.abs() + least.abs());
        let mut phases = if self.way >= most - slack {
            self.scale.phases(&self.up.strokes(time), 1.0, self.start)
        } else if self.way <= least + slack {
            self.scale.phases(&self.down.strokes(time), -1.0, self.start)
        } else {
            self.mixed(time, (self.way - least) / (most - least))
        };
        if phases.is_empty() {
            let State { velocity, acceleration, .. } = *self.start;
            let state = [0.0, velocity, acceleration, 0.0];
            phases.push(Phase { start: 0.0, length: duration, state });
        }
        phases
    }

    /// `share` of the farthest motion and the rest of the least.
    fn mixed(&self, time: f64, share: f64) -> Vec<Phase> {
        let (up, down) = (self.up.strokes(time), self.down.strokes(time));
        let mut course = Course::new(self.start);
        let mut next = [0, 0];
        // How much of either stroke is over.
        let mut past = [0.0, 0.0];
        let weights = [share * self.scale.acceleration, (share - 1.0) * self.scale.acceleration];
        let jerks = [share * self.scale.jerk, (share - 1.0) * self.scale.jerk];
        let least = f64::EPSILON * time;
        while next[0] < 7 && next[1] < 7 {
            let (high, low) = (up[next[0]], down[next[1]]);
            let rest = [high[0] - past[0], low[0] - past[1]];
            let over = if rest[0] <= rest[1] { 0 } else { 1 };
            let length = rest[over].max(0.0);
            if length > least {
                let a = weights[0] * (high[1] + high[2] * past[0])
                    + weights[1] * (low[1] + low[2] * past[1]);
                let j = jerks[0] * high[2] + jerks[1] * low[2];
                course.push(length * self.scale.time, [a, j]);
            }
            past[1 - over] += length;
            past[over] = 0.0;
            next[over] += 1;
        }
        course.phases
    }
}

/// Lawful durations of all joints, s.
#[derive(Default)]
pub struct Windows {
    all: Vec<[f64; 2]>,
    up: Vec<[f64; 2]>,
    down: Vec<[f64; 2]>,
}

impl Windows {
    /// Adds a joint's: those at which its way is neither too far nor too near.
    fn add(
        &mut self,
        [up, down]: [&Reach; 2],
        way: f64,
        [together, slack]: [f64; 2],
        unit: f64,
    ) -> Range<usize> {
        let first = self.all.len();
        up.windows(way, slack, &mut self.up);
        down.windows(-way, slack, &mut self.down);
        let (mut i, mut k) = (0, 0);
        while i < self.up.len() && k < self.down.len() {
            let (a, b) = (self.up[i], self.down[k]);
            let (from, to) = (a[0].max(b[0]), a[1].min(b[1]));
            if from <= to * (1.0 + ROUNDING) + together {
                self.all.push([from * unit, to.max(from) * unit]);
            }
            let first_ends = a[1] < b[1];
            i += usize::from(first_ends);
            k += usize::from(!first_ends);
        }
        first..self.all.len()
    }

    /// Only those of one joint from `start` to `goal`, which must be sound.
    pub fn of(&mut self, start: &State, goal: &State, limit: &KernelLimits) -> &[[f64; 2]] {
        self.all.clear();
        Joint::new(start, goal, limit, self);
        &self.all
    }
}

/// The smallest duration that lies in one of every joint's windows; not a number if there is none.
pub fn common<'a>(joints: impl Iterator<Item = &'a [[f64; 2]]> + Clone) -> f64 {
    let mut duration = 0.0;
    loop {
        let before = duration;
        for own in joints.clone() {
            let next = own.iter().find(|window| window[1] * (1.0 + ROUNDING) >= duration);
            duration = next.map_or(f64::NAN, |window| window[0].max(duration));
            if duration.is_nan() {
                return duration;
            }
        }
        if duration == before {
            return duration;
        }
    }
}
