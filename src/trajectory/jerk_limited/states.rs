//! A search over the states at waypoints, by exact durations from one to the next.
//!
//! Next to an end in motion the lawful durations of a segment are no interval: a waypoint can be met
//! in passing, then for long not at all, and again once a joint has swung back. Descent along a
//! programme stays on its side of such gaps. Here every segment takes the least duration that
//! [`state_to_state`](super::state_to_state) finds on any side, and what varies are velocity and acceleration of
//! every joint at every waypoint between the ends: from many starts, one value after the other, in steps that
//! are halved where none gains (a pattern search: Hooke and Jeeves, Journal of the ACM 8, 1961,
//! doi:10.1145/321062.321069). What it finds is lawful and where the programme starts.

use crate::math::random::RandomStream;

use super::profile::Motion;
use super::state_to_state::{State, StateFault, Windows, between, common};
use super::{Part, Watch};

/// Starts of a search times the values it varies, and the least and the largest number of starts.
const EFFORT: [usize; 3] = [6000, 96, 768];

/// By what the number of starts is divided where a motion is known.
const FEWER: usize = 4;

/// One in so many starts is followed further, and at least so many are.
const BEST: [usize; 2] = [8, 12];

/// How many results that differ are followed to the end.
const RESULTS: usize = 3;

/// From which difference results differ, as a share of a value's range.
const DIFFERENT: f64 = 0.1;

/// Steps as shares of a value's range: at first, where starts are compared, where those are that are followed
/// further, and at the end.
const STEPS: [f64; 4] = [0.5, 0.25, 0.1, 0.01];

/// What every joint's own duration counts beside that of the segment, so that it is worth to
/// make one of several slowest joints faster.
const ALONE: f64 = 1e-2;

/// Durations of a start's segments compared with those of a motion that stops: logarithms.
const HASTE: [f64; 2] = [-3.0, 0.5];

/// So many segments next to an end in motion, less one at least, are crossed at its speed at a start.
const PASSED: f64 = 4.0;

/// Rounds in which the velocities of a spline are found; each leaves at most half of what is wrong.
const ROUNDS: usize = 8;

/// The motions found along `part`, the fastest first. None once `watch` says that time is up. Where a motion
/// is `known` it is one of the starts, and there are fewer others.
pub fn search(part: &Part, known: Option<&Motion>, watch: &Watch) -> Vec<Motion> {
    let ranges = ranges(part);
    let mut scratch = Scratch::default();
    let mut random = RandomStream::new(0, 0);
    let values = 2 * ranges.len() * (part.ways.len() - 1);
    let all = (EFFORT[0] / values).clamp(EFFORT[1], EFFORT[2]);
    let starts = if known.is_some() { all / FEWER } else { all };
    let mut courses: Vec<Course> = Vec::with_capacity(starts);
    for number in 0..starts {
        if watch.is_over() {
            break;
        }
        let states = match number {
            0 => known.map_or_else(|| resting(part), |motion| states_of(part, motion)),
            _ if number % 2 == 0 => scattered(part, &ranges, &mut random),
            _ => splines(part, &ranges, &mut random),
        };
        let mut course = Course::new(part, states, &mut scratch);
        course.descend([STEPS[0], STEPS[1]], &ranges, &mut scratch);
        courses.push(course);
    }
    courses.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    courses.truncate((starts / BEST[0]).max(BEST[1]));
    for course in &mut courses {
        course.descend([STEPS[1], STEPS[2]], &ranges, &mut scratch);
    }
    courses.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    let mut results: Vec<Course> = Vec::with_capacity(RESULTS);
    for mut course in courses {
        if results.len() < RESULTS && results.iter().all(|other| course.differs(other, &ranges)) {
            course.descend([STEPS[2], STEPS[3]], &ranges, &mut scratch);
            results.push(course);
        }
    }
    results.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
    results.iter().filter_map(|course| course.motion().ok()).collect()
}

/// States at all waypoints, and how long the segments between them take.
struct Course<'a> {
    part: &'a Part<'a>,
    /// `[waypoint][joint]`.
    states: Vec<Vec<State>>,
    /// Lawful durations, `[segment][joint]`.
    windows: Vec<Vec<Vec<[f64; 2]>>>,
    /// What [`cost`] says of each segment.
    costs: Vec<f64>,
}

/// What a segment costs whose joints have these lawful durations.
fn cost(joints: &[Vec<[f64; 2]>]) -> f64 {
    let all = common(joints.iter().map(Vec::as_slice));
    let alone = joints.iter().filter_map(|windows| windows.first()).map(|window| window[0]);
    let cost = all + ALONE * alone.sum::<f64>() / joints.len() as f64;
    if cost.is_nan() { f64::INFINITY } else { cost }
}

/// Memory that candidates share.
#[derive(Default)]
struct Scratch {
    windows: Windows,
    kept: [Vec<[f64; 2]>; 2],
}

impl<'a> Course<'a> {
    fn new(part: &'a Part<'a>, states: Vec<Vec<State>>, scratch: &mut Scratch) -> Self {
        let mut course = Self { part, states, windows: vec![], costs: vec![] };
        for segment in 0..part.ways.len() {
            let joints = 0..part.limits.len();
            let row: Vec<Vec<[f64; 2]>> =
                joints.map(|joint| course.lawful(segment, joint, scratch).to_vec()).collect();
            course.costs.push(cost(&row));
            course.windows.push(row);
        }
        course
    }

    fn cost(&self) -> f64 {
        self.costs.iter().sum()
    }

    /// Lawful durations of `joint` in `segment`.
    fn lawful<'s>(&self, segment: usize, joint: usize, scratch: &'s mut Scratch) -> &'s [[f64; 2]] {
        let [from, to] = [segment, segment + 1].map(|at| &self.states[at][joint]);
        scratch.windows.of(from, to, &self.part.limits[joint])
    }

    /// Lets `joint` pass waypoint `at` in `state` if that is faster; says whether.
    fn take(&mut self, at: usize, joint: usize, state: State, scratch: &mut Scratch) -> bool {
        let before = std::mem::replace(&mut self.states[at][joint], state);
        let around = [at - 1, at];
        for (side, segment) in around.into_iter().enumerate() {
            let mut own = std::mem::take(&mut scratch.kept[side]);
            own.clear();
            own.extend_from_slice(self.lawful(segment, joint, scratch));
            scratch.kept[side] = std::mem::replace(&mut self.windows[segment][joint], own);
        }
        let costs = around.map(|segment| cost(&self.windows[segment]));
        let old = self.costs[at - 1] + self.costs[at];
        let faster = costs[0] + costs[1] < old * (1.0 - f64::EPSILON);
        if faster {
            self.costs[at - 1..=at].copy_from_slice(&costs);
        } else {
            self.states[at][joint] = before;
            for (side, segment) in around.into_iter().enumerate() {
                std::mem::swap(&mut self.windows[segment][joint], &mut scratch.kept[side]);
            }
        }
        faster
    }

    /// Varies all states until no step gains that is at least `steps[1]`; the first one is `steps[0]`.
    fn descend(&mut self, steps: [f64; 2], ranges: &[[f64; 2]], scratch: &mut Scratch) {
        let mut step = steps[0];
        while step >= steps[1] {
            let mut faster = false;
            for at in 1..self.costs.len() {
                for (joint, range) in ranges.iter().enumerate() {
                    let [v, a] = range.map(|range| step * range);
                    for [v, a] in [[v, 0.0], [-v, 0.0], [0.0, a], [0.0, -a]] {
                        let mut state = self.states[at][joint];
                        state.velocity += v;
                        state.acceleration += a;
                        keep(&mut state, self.part, joint);
                        faster |= self.take(at, joint, state, scratch);
                    }
                }
            }
            if !faster {
                step *= 0.5;
            }
        }
    }

    /// Whether any value differs from that of `other`.
    fn differs(&self, other: &Self, ranges: &[[f64; 2]]) -> bool {
        let rows = self.states.iter().zip(&other.states);
        rows.into_iter().any(|(own, other)| {
            own.iter().zip(other).zip(ranges).any(|((own, other), [velocity, acceleration])| {
                (own.velocity - other.velocity).abs() > DIFFERENT * velocity
                    || (own.acceleration - other.acceleration).abs() > DIFFERENT * acceleration
            })
        })
    }

    fn motion(&self) -> Result<Motion, Vec<StateFault>> {
        let mut motion = Motion::empty(self.part.limits.len());
        for pair in self.states.windows(2) {
            motion.append(between(&pair[0], &pair[1], self.part.limits)?);
        }
        Ok(motion)
    }
}

/// How fast each joint may be at a waypoint, and its acceleration there: its limits, or what its ways
/// and ends admit.
fn ranges(part: &Part) -> Vec<[f64; 2]> {
    let range = |joint: usize| {
        let [velocity, acceleration, jerk] = part.limits[joint].derivatives;
        let way = part.ways.iter().map(|row| row[joint].abs()).fold(0.0, f64::max);
        let ends = [part.ends.start[joint], part.ends.goal[joint]];
        let given = ends.iter().map(|end| end[0].abs()).fold(0.0, f64::max);
        let gained = libm::sqrt(acceleration * way).min(libm::cbrt(jerk * way * way));
        let speed = (given + gained).min(velocity);
        [speed, libm::sqrt(2.0 * jerk * speed).min(acceleration)]
    };
    (0..part.limits.len()).map(range).collect()
}

/// Brings `state` within what the limits of `joint` allow before it and after.
fn keep(state: &mut State, part: &Part, joint: usize) {
    let [velocity, acceleration, jerk] = part.limits[joint].derivatives;
    state.velocity = state.velocity.max(-velocity).min(velocity);
    let spare = libm::sqrt(2.0 * jerk * (velocity - state.velocity.abs()));
    let most = if jerk.is_finite() { acceleration.min(spare) } else { 0.0 };
    state.acceleration = state.acceleration.max(-most).min(most);
}

/// A start at rest at all waypoints but the ends.
fn resting(part: &Part) -> Vec<Vec<State>> {
    let last = part.ways.len();
    let row = |(at, row): (usize, &Vec<f64>)| {
        let one = |(joint, position): (usize, &f64)| {
            let [velocity, acceleration] = match at {
                0 => part.ends.start[joint],
                _ if at == last => part.ends.goal[joint],
                _ => [0.0; 2],
            };
            State { position: *position, velocity, acceleration }
        };
        row.iter().enumerate().map(one).collect()
    };
    part.waypoints.iter().enumerate().map(row).collect()
}

/// The states of a motion along `part`.
fn states_of(part: &Part, motion: &Motion) -> Vec<Vec<State>> {
    let mut states = resting(part);
    for (at, row) in states[..part.ways.len()].iter_mut().enumerate().skip(1) {
        for (joint, state) in row.iter_mut().enumerate() {
            if let Some(phase) = motion.phases[joint][at].first() {
                [_, state.velocity, state.acceleration, _] = phase.state;
                keep(state, part, joint);
            }
        }
    }
    states
}

/// A start anywhere.
fn scattered(part: &Part, ranges: &[[f64; 2]], random: &mut RandomStream) -> Vec<Vec<State>> {
    let mut states = resting(part);
    let share = random.unit();
    for row in &mut states[1..part.ways.len()] {
        for (joint, (state, [velocity, acceleration])) in row.iter_mut().zip(ranges).enumerate() {
            state.velocity = share * velocity * random.uniform(-1.0, 1.0);
            state.acceleration = share * acceleration * random.uniform(-1.0, 1.0);
            keep(state, part, joint);
        }
    }
    states
}

/// A start along cubic splines between the velocities at the ends, their durations anywhere: what all joints
/// do at a waypoint belongs together. Some of the segments next to an end in motion are crossed as they come.
fn splines(part: &Part, ranges: &[[f64; 2]], random: &mut RandomStream) -> Vec<Vec<State>> {
    let mut rate = |stop: &f64| 1.0 / (stop * libm::exp(random.uniform(HASTE[0], HASTE[1])));
    let rates: Vec<f64> = part.stops.durations.iter().map(&mut rate).collect();
    let mut states = resting(part);
    let mut free = 1..part.ways.len();
    for at_goal in [false, true] {
        let passed = random.uniform(0.0, PASSED) as usize;
        let haste = 0.3 * libm::pow(random.uniform(-1.0, 1.0), 3.0);
        for _ in 0..passed.min(free.len()) {
            let [from, to] =
                if at_goal { [free.end, free.end - 1] } else { [free.start - 1, free.start] };
            if !cross(part, ranges, [from, to], libm::exp(haste), &mut states) {
                break;
            }
            free = if at_goal { free.start..to } else { to + 1..free.end };
        }
    }
    for joint in 0..part.limits.len() {
        let mean = |at: usize| rates[at] * part.ways[at][joint];
        for _ in 0..ROUNDS {
            for at in free.clone() {
                let [from, to] = [rates[at - 1], rates[at]];
                let [last, next] = [at - 1, at + 1].map(|at| states[at][joint].velocity);
                let around = from * (3.0 * mean(at - 1) - last) + to * (3.0 * mean(at) - next);
                states[at][joint].velocity = around / (2.0 * (from + to));
            }
        }
        for at in free.clone() {
            let [v, next] = [at, at + 1].map(|at| states[at][joint].velocity);
            states[at][joint].acceleration = rates[at] * (6.0 * mean(at) - 4.0 * v - 2.0 * next);
        }
        for at in 1..part.ways.len() {
            keep(&mut states[at][joint], part, joint);
        }
    }
    states
}

/// Lets joints go on from waypoint `from` to its neighbour `to` with constant jerk, for about the time in which
/// most of them get there without any, times `slower`. False if they go the wrong way.
fn cross(
    part: &Part,
    ranges: &[[f64; 2]],
    [from, to]: [usize; 2],
    slower: f64,
    states: &mut [Vec<State>],
) -> bool {
    let forwards = if to > from { 1.0 } else { -1.0 };
    let way = |joint: usize| part.waypoints[to][joint] - part.waypoints[from][joint];
    // Backwards in time it is negative.
    let mut time = 0.0;
    for _ in 0..ROUNDS {
        let (mut along, mut speed) = (0.0, 0.0);
        for (joint, (state, [range, _])) in states[from].iter().zip(ranges).enumerate() {
            let mean = (state.velocity + 0.5 * time * state.acceleration) / range;
            along += mean * way(joint) / range;
            speed += mean * mean;
        }
        time = along / speed;
        if !(time * forwards > 0.0 && time.is_finite()) {
            return false;
        }
    }
    time *= slower;
    for joint in 0..ranges.len() {
        let State { velocity, acceleration, .. } = states[from][joint];
        let miss = way(joint) - time * (velocity + 0.5 * time * acceleration);
        let most = part.limits[joint].derivatives[2];
        let jerk = (6.0 * miss / (time * time * time)).max(-most).min(most);
        let state = &mut states[to][joint];
        state.velocity = velocity + time * (acceleration + 0.5 * time * jerk);
        state.acceleration = acceleration + time * jerk;
        keep(state, part, joint);
    }
    true
}
