//! The JSON that users program against. A changed snapshot is a changed API.

use serde_json::json;
use takt::budget::Budget;
use takt::plan::verify::{VerifyRequest, verify};
use takt::plan::{PlanRequest, PlanResult, validate};

use crate::support::{faults, plan};

/// One axis from rest to rest: every number can be checked by hand.
#[test]
fn a_result() {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic",
        "limits": { "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4 },
        "provenance": { "velocity": "measured" } }] });
    let task =
        json!({ "type": "waypoints", "interpolation": "trapezoidal", "waypoints": [[0], [4]] });
    let mut result = plan(json!({ "robot": robot, "task": task }));
    result.planning_s = 0.0;
    result.convergence.iter_mut().for_each(|point| point.elapsed_s = 0.0);
    result.version = "0".to_owned();
    insta::assert_json_snapshot!(result);
}

/// The same axis with more and more acceleration; the first member cannot be in time.
#[test]
fn a_family() {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic",
        "limits": { "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4 } }] });
    let task = json!({ "type": "waypoints", "interpolation": "trapezoidal",
        "waypoints": [[0], [4]], "duration": { "at_most": 3.5 } });
    let request = json!({ "robot": robot, "task": { "type": "family", "problem": { "task": task },
        "sweep": [{ "path": "/limit_scale/acceleration", "values": [0.25, 0.5, 1] }] } });
    let request = PlanRequest::parse(request).unwrap();
    let plan = validate(&request, &|_| None).unwrap();
    let Ok(PlanResult::Family(mut result)) = plan.run(&Budget::default(), &|_| {}) else {
        panic!("a family")
    };
    // The worst case is a result like any other.
    let worst = (result.worst_case.duration, result.worst_case.robot.clone());
    assert_eq!(worst, (3.0, "axis".to_owned()));
    let mut result = {
        result.planning_s = 0.0;
        result.version = "0".to_owned();
        serde_json::to_value(result).unwrap()
    };
    result["worst_case"] = json!("as of any plan");
    insta::assert_json_snapshot!(result);
}

/// The same axis held against a waypoint that it misses by more than may be.
#[test]
fn a_missed_waypoint() {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic",
        "limits": { "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4 } }] });
    let trajectory = json!({ "breakpoints": [0, 1], "pieces": [[[1]]] });
    let due = json!([{ "time": 0, "position": [1] }, { "time": 0.5, "position": [1.25] }]);
    let request = json!({ "robot": robot, "trajectory": trajectory, "waypoints": due,
        "via_tolerance": [0.125] });
    let request = VerifyRequest::parse(request).unwrap();
    insta::assert_json_snapshot!(verify(&request, &|_| None).unwrap());
}

/// Faults are read by people: their words are part of the service.
#[test]
fn faults_in_words() {
    let request = json!({ "robot": "woodworking_pprr", "seed": -1, "colour": "red",
        "task": { "type": "waypoints", "waypoints": [[0, 0, 0], "x"], "clock": "sundial" } });
    insta::assert_json_snapshot!(faults(request).0);
    let request = json!({ "robot": "woodworking_pprr",
        "task": { "type": "waypoints", "waypoints": [[0, 0, 0, 0], [0, 0, 0, 0], [9, 0, 0, 0]],
            "duration": { "exactly": -1 }, "optimizer": { "name": "pso", "population": 1 } } });
    insta::assert_json_snapshot!(faults(request).0);
}
