//! The JSON that users program against. A changed snapshot is a changed API.

use serde_json::json;

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
