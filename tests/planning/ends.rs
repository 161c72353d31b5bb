//! Ends in motion: cut out of fastest motions, random ones, and as requests.

use serde_json::{Value, json};
use takt::budget::Budget;
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::{Fastest, fastest, fastest_between};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{Certificate, Ends, KinematicState};

use crate::jerk_limited::{bounds, problem};
use crate::support::{faults, merge, plan, timeless, try_plan};

fn planned(waypoints: &[Vec<f64>], limits: &[KernelLimits], ends: &Ends) -> Fastest {
    fastest_between(waypoints, limits, ends, &Budget::default(), &mut |_| {}).unwrap()
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
            found_again += usize::from(found.trajectory.duration() <= 1.0001 * expected);
        }
    }
    assert!(cases == 30 && found_again >= 24, "{found_again} of {cases}");
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
        let limits: Vec<KernelLimits> = (0..joints)
            .map(|_| KernelLimits {
                derivatives: [1.0, 4.0, 30.0].map(|typical| typical * random.uniform(0.3, 3.0)),
                position: [f64::NEG_INFINITY, f64::INFINITY],
            })
            .collect();
        let row =
            |random: &mut RandomStream| (0..joints).map(|_| random.uniform(-1.5, 1.5)).collect();
        let waypoints: Vec<Vec<f64>> = (0..count).map(|_| row(&mut random)).collect();
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

/// A task for two joints through three waypoints.
fn request(task: Value) -> Value {
    let joint = |number: usize| {
        json!({ "name": format!("j{number}"), "type": "revolute",
            "limits": { "lower": -3.0, "upper": 3.0, "velocity": 2.0, "acceleration": 8.0, "jerk": 60.0 } })
    };
    let mut request = json!({ "robot": { "joints": [joint(1), joint(2)] },
        "task": { "type": "waypoints", "interpolation": "jerk_limited",
            "waypoints": [[0.0, 0.0], [1.0, -0.5], [0.5, 1.0]] } });
    merge(&mut request["task"], task);
    request
}

#[test]
fn a_request_in_motion_is_certified_and_told_truly() {
    let start = json!({ "velocity": [1.5, -0.5], "acceleration": [0.0, 3.0] });
    let rest = plan(request(json!({})));
    let result = plan(request(json!({ "start": start })));
    assert!(result.certificate.lawful && result.duration < rest.duration);
    assert!(!result.certificate.starts_at_rest && result.certificate.ends_at_rest);
    assert_eq!(result.certificate.continuity, 2);
    // The bound knows only what holds for ends in motion, too.
    let bound = result.bound.unwrap();
    assert!(
        bound.lower <= result.duration && bound.method.contains("the end at rest"),
        "{bound:?}"
    );
    // Two waypoints: the optimum, proven.
    let two = json!({ "waypoints": [[0.0, 0.0], [1.0, -0.5]], "start": start,
        "goal": { "velocity": [0.5, 0.0] } });
    let result = plan(request(two));
    let bound = result.bound.unwrap();
    assert_eq!((bound.lower, bound.gap), (result.duration, 0.0));
    assert!(result.certificate.lawful && !result.certificate.ends_at_rest);
    // Acceleration without speed is motion, too: it does not jump at the start.
    let pushed = plan(request(json!({ "start": { "acceleration": [5.0, 0.0] } })));
    assert!(pushed.certificate.lawful, "{:?}", pushed.certificate.violations);
    // Zeros are rest.
    let zeros = json!({ "start": { "velocity": [0, 0] }, "goal": {} });
    assert_eq!(timeless(&plan(request(zeros))), timeless(&rest));
}

#[test]
fn a_motion_that_must_leave_the_position_limits_fails_and_says_so() {
    let task =
        json!({ "waypoints": [[2.99, 0.0], [1.0, -0.5]], "start": { "velocity": [1.9, 0.0] } });
    let error = try_plan(request(task)).unwrap_err();
    assert!(error.message.contains("leaves the position limits"), "{error}");
}

#[test]
fn what_ends_cannot_be_is_refused_where_it_stands() {
    for (task, pointer, words) in [
        (json!({ "start": { "velocity": [1.0] } }), "/start/velocity", "1 values"),
        (
            json!({ "goal": { "acceleration": [0, 9.0] } }),
            "/goal/acceleration/1",
            "j2: acceleration 9 rad/s² is beyond its limit of 8",
        ),
        (json!({ "goal": { "velocity": [-2.5, 0] } }), "/goal/velocity/0", "limit of 2 rad/s"),
        (
            json!({ "start": { "velocity": [1.9, 0], "acceleration": [8.0, 0] } }),
            "/start/acceleration/0",
            "will be",
        ),
        (
            json!({ "goal": { "velocity": [1.9, 0], "acceleration": [-8.0, 0] } }),
            "/goal/acceleration/0",
            "was",
        ),
        (json!({ "interpolation": "quintic", "start": {} }), "/start", "only jerk_limited"),
        (
            json!({ "start": { "velocity": [1, 0] }, "duration": { "exactly": 9.0 } }),
            "/duration/exactly",
            "cannot be stretched",
        ),
        (
            json!({ "start": { "velocity": [1, 0] }, "constraints": "velocity_only" }),
            "/constraints",
            "within all limits",
        ),
        (json!({ "start": { "speed": [1, 0] } }), "/start/speed", "unknown field"),
    ] {
        let found = faults(request(task));
        let [fault] = &found.0[..] else { panic!("{found}") };
        assert_eq!(fault.pointer, format!("/task{pointer}"), "{found}");
        assert!(fault.detail.contains(words), "{found}");
    }
    let mut free = request(json!({ "start": { "velocity": [1, 0] } }));
    free["limits"] = json!({ "acceleration": null, "jerk": null });
    let found = faults(free);
    assert!(found.0.iter().all(|fault| fault.pointer == "/limits"), "{found}");
    assert!(found.to_string().contains("acceleration or jerk limit"), "{found}");
}

/// Legs hand over in motion, or not at all.
#[test]
fn legs_meet_at_speed() {
    let leg = |name: &str, rows: Value, task: Value| {
        let mut leg = json!({ "name": name, "task": { "type": "waypoints", "interpolation": "jerk_limited", "waypoints": rows } });
        merge(&mut leg["task"], task);
        leg
    };
    let speed = json!({ "velocity": [0.5, 0.0] });
    let mut program = request(json!({}));
    let first = leg("AB", json!([[0, 0], [1, 0.5]]), json!({ "goal": speed }));
    program["task"] = json!({ "type": "program", "legs": [first, leg("BC", json!([[1, 0.5], [0, 1]]), json!({}))] });
    let found = faults(program.clone());
    assert_eq!(found.0.len(), 1, "{found}");
    assert_eq!(found.0[0].pointer, "/task/legs/1/task/start/velocity/0");
    program["task"]["legs"][1]["task"]["start"] = speed;
    let parsed = takt::plan::PlanRequest::parse(program).unwrap();
    let prepared = takt::plan::validate(&parsed, &takt::robot::catalogue::get).unwrap();
    let result = prepared.run(&Budget::default(), &|_| {}).unwrap();
    let takt::plan::PlanResult::Program(result) = result else { panic!("a program") };
    assert!(result.lawful && result.legs.len() == 2);
}
