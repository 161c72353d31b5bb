//! Waypoints that are poses: which configurations they are passed with, and what is said of those that cannot be.

use serde_json::{Value, json};
use takt::geometry::Pose;
use takt::plan::{PlanRequest, validate};
use takt::robot::{Robot, catalogue};

use crate::support::{faults, plan};

fn request(robot: Value, task: Value) -> Value {
    json!({"robot": robot, "task": task,
        "limits": {"acceleration": 10.0, "velocity": 3.0, "jerk": 100.0}})
}

fn task(waypoints: Value) -> Value {
    json!({"type": "waypoints", "waypoints": waypoints, "interpolation": "jerk_limited"})
}

/// The configurations that a list of waypoints is passed with.
fn resolved(waypoints: Value) -> Vec<Vec<f64>> {
    plan(request(json!("ur5e"), task(waypoints))).waypoints
}

fn pose(robot: &Robot, joints: &[f64]) -> Value {
    let pose: Pose = robot.kinematics().unwrap().tool_pose(joints);
    json!({ "pose": pose })
}

#[track_caller]
fn assert_near(found: &[Vec<f64>], expected: &[&[f64]]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        for (found, expected) in found.iter().zip(*expected) {
            assert!((found - expected).abs() < 1e-9, "{found:?} is not {expected:?}");
        }
    }
}

#[test]
fn poses_are_passed_on_the_branch_of_their_neighbours() {
    let ur = catalogue::get("ur5e").unwrap();
    let way: [[f64; 6]; 4] = [
        [0.3, -1.2, 1.4, -0.9, -1.5, 0.6],
        [0.6, -1.0, 1.2, -1.1, -1.4, 0.2],
        [0.9, -0.9, 1.5, -1.4, -1.2, 0.1],
        [0.5, -1.4, 1.6, -1.2, -1.6, 0.4],
    ];
    let expected: Vec<&[f64]> = way.iter().map(|joints| &joints[..]).collect();
    // One joint list tells the branch, wherever it stands.
    let [a, b, c, d] = way.map(|joints| pose(&ur, &joints));
    assert_near(&resolved(json!([way[0], b, c, d])), &expected);
    assert_near(&resolved(json!([a, b, c, way[3]])), &expected);
    // A seed tells it, too, and whole turns with it.
    let mut seeded = a.clone();
    seeded["seed"] = json!(way[0].map(|joint| joint + 0.1));
    assert_near(&resolved(json!([seeded, b, c, d])), &expected);
    let mut turned = way[3];
    turned[0] -= std::f64::consts::TAU;
    let mut seeded = d.clone();
    seeded["seed"] = json!(turned);
    assert_near(&resolved(json!([way[0], seeded])), &[&way[0], &turned]);
}

#[test]
fn a_program_goes_on_from_where_the_leg_before_it_ended() {
    let rokae = catalogue::get("rokae_xb4").unwrap();
    let [from, over, to] = [
        [0.0, 0.2, -0.3, 0.1, 0.5, 0.0],
        [0.4, 0.4, -0.5, 0.2, 0.6, 0.3],
        [0.8, 0.5, -0.4, 0.3, 0.4, 0.5],
    ];
    let leg = |name: &str, waypoints: Value| json!({"name": name, "task": task(waypoints)});
    let legs = json!([
        leg("there", json!([from, pose(&rokae, &over)])),
        leg("on", json!([pose(&rokae, &over), pose(&rokae, &to)])),
    ]);
    let request = request(json!("rokae_xb4"), json!({"type": "program", "legs": legs}));
    let plan = validate(&PlanRequest::parse(request).unwrap(), &catalogue::get);
    assert!(plan.is_ok(), "{:?}", plan.err());
}

#[test]
fn what_no_configuration_reaches_is_told_where_it_stands() {
    let ur = catalogue::get("ur5e").unwrap();
    let start = [0.3, -1.2, 1.4, -0.9, -1.5, 0.6];
    for (waypoint, pointer, words) in [
        (json!({"pose": {"position": [3, 0, 0]}}), "/pose", "ik_no_solution"),
        (json!({"pose": {"orientation": [0, 0, 0, 9]}}), "/pose/orientation", "norm 9"),
        (json!({"pose": {}, "seed": [1]}), "/seed", "6 joints"),
        (json!({"pose": {}, "turn": 1}), "/turn", "unknown field"),
        (pose(&ur, &start), "", "are equal"),
    ] {
        let faults = faults(request(json!("ur5e"), task(json!([start, waypoint]))));
        let pointer = format!("/task/waypoints/1{pointer}");
        let found = faults.0.iter().any(|f| f.pointer == pointer && f.detail.contains(words));
        assert!(found, "no {words:?} at {pointer} in {faults}");
    }
    let inline = json!({"joints": [{"name": "j", "type": "revolute"}]});
    let faults = faults(request(inline, task(json!([[0], {"pose": {}}]))));
    assert!(faults.to_string().contains("poses need kinematics"), "{faults}");
}

/// Limits of the request count, not only the robot's.
#[test]
fn narrower_limits_exclude_configurations() {
    let ur = catalogue::get("ur5e").unwrap();
    let target = pose(&ur, &[0.3, -1.2, 1.4, -0.9, -1.5, 0.6]);
    let request = |lower: f64| {
        let lower = [Value::Null, Value::Null, json!(lower), Value::Null, Value::Null, Value::Null];
        json!({"robot": "ur5e", "limits": {"lower": lower, "acceleration": 10.0, "jerk": 100.0},
            "task": task(json!([[0.3, -1.2, 2.9, -0.9, -1.5, 0.6], target]))})
    };
    assert!(plan(request(1.0)).waypoints[1][2] >= 1.0);
    let faults = faults(request(2.0));
    assert!(faults.to_string().contains("outside the limits of this request"), "{faults}");
}
