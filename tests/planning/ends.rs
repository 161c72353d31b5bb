//! Ends in motion as requests.

use serde_json::{Value, json};
use takt::budget::Budget;

use crate::support::{faults, merge, plan, timeless, try_plan};

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
