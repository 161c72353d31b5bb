//! Requests and shorthand for the planning tests.

use serde_json::{Value, json};
use takt::budget::Budget;
use takt::fault::Faults;
use takt::plan::{PlanError, PlanRequest, PlanResult, TrajectoryResult, scenarios, validate};
use takt::robot::catalogue;
use takt::trajectory::{JointBounds, Limit};

/// A scenario's request with members of its task replaced or added.
pub fn scenario(name: &str, task: Value) -> Value {
    let mut request = scenarios::get(name).unwrap().request.clone();
    merge(&mut request["task"], task);
    request
}

/// Puts `changes`' members over `value`'s.
pub fn merge(value: &mut Value, changes: Value) {
    match (value, changes) {
        (Value::Object(members), Value::Object(changes)) => {
            for (name, change) in changes {
                merge(members.entry(name).or_insert(Value::Null), change);
            }
        }
        (value, change) => *value = change,
    }
}

/// Like [`scenario`], without jerk limits.
pub fn without_jerk(name: &str, task: Value) -> Value {
    let mut request = scenario(name, task);
    merge(&mut request, json!({ "limits": { "jerk": null } }));
    request
}

/// The faults of a request that is not valid.
pub fn faults(request: Value) -> Faults {
    match PlanRequest::parse(request) {
        Err(faults) => faults,
        Ok(request) => match validate(&request, &catalogue::get) {
            Err(faults) => faults,
            Ok(_) => panic!("the request is valid"),
        },
    }
}

/// Plans a request with one trajectory.
pub fn plan(request: Value) -> TrajectoryResult {
    match try_plan(request) {
        Ok(result) => result,
        Err(error) => panic!("{error}: {}", error.details),
    }
}

/// Plans a valid request with one trajectory.
pub fn try_plan(request: Value) -> Result<TrajectoryResult, PlanError> {
    let request = PlanRequest::parse(request).unwrap_or_else(|faults| panic!("{faults}"));
    let plan = validate(&request, &catalogue::get).unwrap_or_else(|faults| panic!("{faults}"));
    match plan.run(&Budget::default(), &|_| {})? {
        PlanResult::Trajectory(result) => Ok(*result),
        _ => panic!("the task has not one trajectory"),
    }
}

/// The result as JSON without the fields that tell how long planning took.
pub fn timeless(result: &TrajectoryResult) -> String {
    let mut value = serde_json::to_value(result).unwrap();
    value.as_object_mut().unwrap().remove("planning_s");
    for point in value["convergence"].as_array_mut().unwrap() {
        point.as_object_mut().unwrap().remove("elapsed_s");
    }
    value.to_string()
}

/// A joint with the same limit on velocity, acceleration and jerk.
pub fn bounds(limit: f64) -> JointBounds {
    let limit = || Some(Limit { value: limit, provenance: "test".into() });
    JointBounds {
        name: "j".into(),
        unit: "rad",
        lower: None,
        upper: None,
        derivatives: [limit(), limit(), limit()],
    }
}
