//! Motions between two states: against Ruckig's durations, and on random problems.

use serde_json::Value;
use takt::math::random::RandomStream;
use takt::trajectory::Certificate;
use takt::trajectory::jerk_limited::state_to_state::{End, State, StateFault, between, brake};
use takt::trajectory::jerk_limited::{Motion, Phase};
use takt::trajectory::kernel::KernelLimits;

use crate::jerk_limited::bounds;

const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

struct Problem {
    start: Vec<State>,
    goal: Vec<State>,
    limits: Vec<KernelLimits>,
}

impl Problem {
    fn solved(&self) -> Motion {
        between(&self.start, &self.goal, &self.limits).unwrap()
    }

    fn joint(&self, joint: usize) -> Self {
        let one = joint..=joint;
        Self {
            start: self.start[one.clone()].to_vec(),
            goal: self.goal[one.clone()].to_vec(),
            limits: self.limits[one].to_vec(),
        }
    }
}

fn triple(row: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| row[i].as_f64().unwrap_or(f64::INFINITY))
}

fn state([position, velocity, acceleration]: [f64; 3]) -> State {
    State { position, velocity, acceleration }
}

fn limited(derivatives: [f64; 3]) -> KernelLimits {
    KernelLimits { derivatives, position: FREE }
}

#[test]
fn takes_as_long_as_ruckig() {
    let all: Vec<Value> =
        serde_json::from_str(include_str!("../data/state_to_state.json")).unwrap();
    assert_eq!(all.len(), 60);
    for (number, value) in all.iter().enumerate() {
        let rows = |name: &str| value[name].as_array().unwrap().iter().map(triple);
        let problem = Problem {
            start: rows("start").map(state).collect(),
            goal: rows("goal").map(state).collect(),
            limits: rows("limits").map(limited).collect(),
        };
        let near = |ours: f64, theirs: &Value, what: &str| {
            let theirs = theirs.as_f64().unwrap();
            assert!((ours - theirs).abs() <= 1e-9 * theirs, "{number} {what}: {ours} {theirs}");
        };
        let motion = problem.solved();
        near(motion.duration(), &value["duration"], "together");
        check(&problem, &motion);
        for joint in 0..problem.start.len() {
            near(problem.joint(joint).solved().duration(), &value["own"][joint], "alone");
        }
    }
}

/// A state from which, and to which, lawful motions exist.
fn lawful_state(random: &mut RandomStream, limits: [f64; 3]) -> [f64; 3] {
    let [velocity, acceleration, jerk] = limits.map(|limit| limit.min(100.0));
    loop {
        let [v, a] = [velocity, acceleration].map(|limit| random.uniform(-limit, limit));
        let a = if limits[2].is_infinite() || random.uniform(0.0, 1.0) < 0.2 { 0.0 } else { a };
        if v.abs() + a * a / (2.0 * jerk) <= velocity {
            return [random.uniform(-1.0, 1.0), v, a];
        }
    }
}

fn random_limits(random: &mut RandomStream) -> [f64; 3] {
    let mut limits = [0; 3].map(|_| libm::pow(10.0, random.uniform(-1.0, 1.0)));
    let free = random.uniform(0.0, 20.0) as usize;
    if free < 3 {
        limits[free] = f64::INFINITY;
    }
    limits
}

/// Meets both states, is continuous, keeps its limits, and lasts as long as it says.
fn check(problem: &Problem, motion: &Motion) {
    let duration = motion.duration();
    for (joint, segments) in motion.phases.iter().enumerate() {
        let (start, goal) = (problem.start[joint], problem.goal[joint]);
        let limits = problem.limits[joint].derivatives;
        let smooth = limits[2].is_finite();
        let mut now = [0.0, start.velocity, start.acceleration];
        let mut time = 0.0;
        for phase in &segments[0] {
            let near = |order: usize| (now[order] - phase.state[order]).abs() <= 1e-9;
            assert!(near(0) && near(1) && (near(2) || !smooth), "{joint} {phase:?} after {now:?}");
            assert!((phase.start - time).abs() <= 1e-12 * duration, "{phase:?} at {time}");
            assert!(phase.length >= 0.0);
            for (peak, limit) in phase.peaks().into_iter().zip(limits) {
                assert!(peak <= limit * (1.0 + 1e-10), "{joint} {phase:?}: {peak} over {limit}");
            }
            let [x, v, a, _] = phase.at(phase.length);
            (now, time) = ([x, v, a], time + phase.length);
        }
        assert!((time - duration).abs() <= 1e-12 * duration, "{joint}: {time} of {duration}");
        let wanted = [goal.position - start.position, goal.velocity, goal.acceleration];
        for (order, (now, wanted)) in now.into_iter().zip(wanted).enumerate() {
            let near = (now - wanted).abs() <= 1e-9;
            assert!(near || order == 2 && !smooth, "{joint}: {now} is not {wanted}");
        }
    }
}

fn random_problem(random: &mut RandomStream) -> Problem {
    let joints = 1 + random.uniform(0.0, 6.0) as usize;
    let mut problem = Problem { start: vec![], goal: vec![], limits: vec![] };
    for _ in 0..joints {
        let limits = random_limits(random);
        problem.start.push(state(lawful_state(random, limits)));
        problem.goal.push(state(lawful_state(random, limits)));
        problem.limits.push(limited(limits));
    }
    problem
}

#[test]
fn meets_states_within_limits_in_a_time_possible_for_all() {
    let mut random = RandomStream::new(41, 0);
    let mut waiting = 0;
    for _ in 0..5000 {
        let problem = random_problem(&mut random);
        let motion = problem.solved();
        check(&problem, &motion);
        let own = |joint: usize| problem.joint(joint).solved().duration();
        let longest = (0..problem.start.len()).map(own).fold(0.0, f64::max);
        assert!(motion.duration() >= longest);
        waiting += usize::from(motion.duration() > longest);
    }
    // Some had to wait for a duration that all joints can have.
    assert!(waiting > 10, "{waiting}");
}

#[test]
fn is_certified_as_a_trajectory() {
    let mut random = RandomStream::new(42, 0);
    for _ in 0..50 {
        let problem = random_problem(&mut random);
        let motion = problem.solved();
        let rows = [&problem.start, &problem.goal]
            .map(|states| states.iter().map(|state| state.position).collect::<Vec<_>>());
        let (trajectory, times) = motion.trajectory(&rows);
        let due: Vec<(f64, &[f64])> =
            times.iter().zip(&rows).map(|(t, row)| (*t, row.as_slice())).collect();
        let certificate = Certificate::new(&trajectory, &bounds(&problem.limits), &due);
        assert!(certificate.lawful, "{:?}", certificate.violations);
        assert!(certificate.waypoint_error.unwrap() <= 1e-9);
    }
}

/// A lawful motion made of random phases, or none.
fn wandering(random: &mut RandomStream, limits: [f64; 3]) -> Option<(Problem, f64)> {
    let [velocity, acceleration, jerk] = limits;
    let start = lawful_state(random, limits);
    let [mut x, mut v, mut a] = start;
    let mut duration = 0.0;
    for _ in 0..1 + random.uniform(0.0, 8.0) as usize {
        let j = jerk * random.uniform(-2.0, 2.0).clamp(-1.0, 1.0);
        let most = (acceleration / jerk).min(libm::sqrt(velocity / jerk));
        let length = random.uniform(0.0, 2.0) * most;
        let phase = Phase { start: 0.0, length, state: [x, v, a, j] };
        let [x1, v1, a1, _] = phase.at(length);
        let [speed, force, _] = phase.peaks();
        if speed <= velocity
            && force <= acceleration
            && v1.abs() + a1 * a1 / (2.0 * jerk) <= velocity
        {
            [x, v, a] = [x1, v1, a1];
            duration += length;
        }
    }
    let problem = Problem {
        start: vec![state(start)],
        goal: vec![state([x, v, a])],
        limits: vec![limited(limits)],
    };
    (duration > 0.0).then_some((problem, duration))
}

#[test]
fn no_lawful_motion_is_faster() {
    let mut random = RandomStream::new(43, 0);
    let (mut attacks, mut equal) = (0, 0);
    while attacks < 50_000 {
        let limits = [0; 3].map(|_| libm::pow(10.0, random.uniform(-1.0, 1.0)));
        let Some((problem, duration)) = wandering(&mut random, limits) else { continue };
        let least = problem.solved().duration();
        assert!(least <= duration * (1.0 + 1e-9), "{least} {duration} {:?}", problem.goal);
        equal += usize::from(least >= duration * (1.0 - 1e-9));
        attacks += 1;
    }
    // Some of them were as fast as can be.
    assert!(equal > 1000, "{equal}");
}

#[test]
fn brakes_to_rest() {
    let mut random = RandomStream::new(44, 0);
    for _ in 0..2000 {
        let mut problem = random_problem(&mut random);
        let motion = brake(&problem.start, &problem.limits).unwrap();
        let mut longest = 0.0f64;
        for (joint, goal) in problem.goal.iter_mut().enumerate() {
            let phases = &motion.phases[joint][0];
            let way = phases.last().map_or(0.0, |last| last.at(last.length)[0]);
            *goal = state([problem.start[joint].position + way, 0.0, 0.0]);
        }
        check(&problem, &motion);
        for joint in 0..problem.start.len() {
            let alone = problem.joint(joint);
            let own = brake(&alone.start, &alone.limits).unwrap().duration();
            // Where it stops cannot be reached at rest any sooner.
            assert!((alone.solved().duration() - own).abs() <= 1e-4 * own);
            longest = longest.max(own);
        }
        assert_eq!(motion.duration(), longest);
    }
    // By hand: acceleration falls for 1 s, holds for 1 s and rises for 1 s.
    let motion = brake(&[state([5.0, 2.0, 0.0])], &[limited([3.0, 1.0, 1.0])]).unwrap();
    assert_eq!(motion.duration(), 3.0);
}

#[test]
fn is_there_where_it_already_is() {
    let limits = [limited([1.0, 2.0, 4.0])];
    for at in [[0.5, 0.0, 0.0], [0.5, 0.3, 0.0], [0.5, 1.0, 0.0], [0.5, 0.2, -1.5]] {
        let motion = between(&[state(at)], &[state(at)], &limits).unwrap();
        assert_eq!(motion.duration(), 0.0, "{at:?}");
        assert_eq!(motion.phases[0][0].len(), 1);
    }
}

#[test]
fn says_what_is_wrong_with_states() {
    let rest = State::default();
    let limits = [limited([1.0, 2.0, 4.0])];
    let fault = |start: State, goal: State| -> Vec<String> {
        let faults = between(&[start], &[goal], &limits).unwrap_err();
        faults.iter().map(StateFault::to_string).collect()
    };
    let at = |v: f64, a: f64| state([0.0, v, a]);
    assert_eq!(fault(at(1.5, 0.0), rest), ["joint 0: start velocity 1.5 is beyond its limit 1"]);
    assert_eq!(
        fault(rest, at(-2.0, 3.0)),
        [
            "joint 0: goal velocity -2 is beyond its limit -1",
            "joint 0: goal acceleration 3 is beyond its limit 2"
        ]
    );
    assert_eq!(
        fault(at(1.0, 2.0), rest),
        [
            "joint 0: start velocity 1 with acceleration 2 means velocity 1.5 at zero acceleration, beyond its limit 1"
        ]
    );
    // The same velocity is lawful where acceleration leads away from the limit.
    assert!(between(&[at(1.0, -2.0)], &[rest], &limits).is_ok());
    let faults = between(&[rest], &[at(1.0, -2.0)], &limits).unwrap_err();
    assert!(matches!(faults[..], [StateFault::Carried { end: End::Goal, peak: 1.5, .. }]));
    assert_eq!(
        fault(at(f64::NAN, 0.0), rest),
        ["joint 0: start velocity NaN must be a finite number"]
    );
}

#[test]
fn says_what_is_wrong_with_limits() {
    let rest = State::default();
    let faults = |limits: [f64; 3]| brake(&[rest], &[limited(limits)]).unwrap_err();
    let unlimited = f64::INFINITY;
    assert_eq!(faults([1.0, unlimited, unlimited]), [StateFault::Unlimited { joint: 0 }]);
    assert_eq!(
        faults([1.0, 0.0, 1.0]),
        [StateFault::Limit { joint: 0, quantity: "acceleration", value: 0.0 }]
    );
    let position = [-1.0, 1.0];
    let limits = [KernelLimits { derivatives: [1.0; 3], position }];
    let far = between(&[rest], &[state([2.0, 0.0, 0.0])], &limits).unwrap_err();
    assert_eq!(far[0].to_string(), "joint 0: goal position 2 is beyond its limit 1");
    let count = between(&[rest, rest], &[rest], &limits).unwrap_err();
    assert_eq!(count, [StateFault::Joints { start: 2, goal: 1, limits: 1 }]);
    let none = between(&[], &[], &[]).unwrap_err();
    assert_eq!(none, [StateFault::Joints { start: 0, goal: 0, limits: 0 }]);
}
