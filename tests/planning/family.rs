//! Families: every member is planned as if it had come alone.

use std::sync::Mutex;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken};
use takt::plan::{
    FamilyResult, PlanCode, PlanError, PlanRequest, PlanResult, PreparedPlan, Progress, validate,
};
use takt::robot::catalogue;

use crate::support::{faults, merge, plan, scenario, timeless};

fn prepared(request: Value) -> PreparedPlan {
    let request = PlanRequest::parse(request).unwrap_or_else(|faults| panic!("{faults}"));
    // What is stored has to be read again as what it was.
    let stored = serde_json::to_value(&request).unwrap();
    assert_eq!(PlanRequest::parse(stored).unwrap(), request);
    validate(&request, &catalogue::get).unwrap_or_else(|faults| panic!("{faults}"))
}

fn try_family(request: Value) -> Result<FamilyResult, PlanError> {
    match prepared(request).run(&Budget::default(), &|_| {})? {
        PlanResult::Family(result) => Ok(result),
        _ => panic!("the task is no family"),
    }
}

fn family(request: Value) -> FamilyResult {
    try_family(request).unwrap_or_else(|error| panic!("{error:?}"))
}

/// A robot of two axes without names to look up.
fn robot() -> Value {
    json!({ "name": "pair", "joints": [
        { "name": "x", "type": "prismatic",
          "limits": { "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4, "jerk": 40 } },
        { "name": "turn", "type": "continuous", "limits": { "velocity": 3, "acceleration": 9, "jerk": 90 } },
    ]})
}

fn waypoints(end: f64) -> Value {
    json!([[0, 0], [1, 2], [end, 1]])
}

/// The base problem's task with `end` as the last waypoint's first joint.
fn task(end: f64) -> Value {
    json!({ "type": "waypoints", "waypoints": waypoints(end) })
}

fn swept(sweep: Value) -> Value {
    json!({ "robot": robot(), "seed": 3,
        "task": { "type": "family", "problem": { "task": task(3.0) }, "sweep": sweep } })
}

fn listed(members: Value) -> Value {
    json!({ "robot": robot(), "seed": 3,
        "task": { "type": "family", "problem": { "task": task(3.0) }, "members": members } })
}

/// Times taken out, whatever else is there.
fn without_times(result: &FamilyResult) -> Value {
    let mut value = serde_json::to_value(result).unwrap();
    let worst: Value = serde_json::from_str(&timeless(&result.worst_case)).unwrap();
    value["worst_case"] = worst;
    value.as_object_mut().unwrap().remove("planning_s");
    value
}

#[test]
fn members_are_planned_as_if_they_came_alone() {
    let pso = json!({ "optimizer": { "name": "pso", "iterations": 20, "population": 20 } });
    let variants = [
        json!({ "task": { "waypoints": waypoints(2.0) } }),
        json!({ "task": { "waypoints": waypoints(5.0), "interpolation": "jerk_limited" } }),
        json!({ "task": pso, "limit_scale": { "velocity": 0.5 } }),
        json!({ "seed": 9, "task": pso }),
        json!({ "limits": { "jerk": [20, 50] }, "task": { "objective": { "time": 1, "rms_jerk": 0.2 } } }),
        json!({ "task": { "clock": "per_joint" } }),
    ];
    let members: Vec<Value> = variants
        .iter()
        .enumerate()
        .map(|(at, set)| json!({ "name": format!("m{at}"), "set": set }))
        .collect();
    let result = family(listed(json!(members)));
    assert_eq!(result.members.len(), variants.len());
    let mut slowest = 0.0;
    for (row, set) in result.members.iter().zip(&variants) {
        let mut alone = json!({ "robot": robot(), "seed": 3, "task": task(3.0) });
        merge(&mut alone, set.clone());
        let alone = plan(alone);
        assert_eq!(row.duration, Some(alone.duration), "{}", row.name);
        assert_eq!(row.lower_bound, alone.bound.as_ref().map(|bound| bound.lower));
        assert_eq!(row.gap, alone.bound.as_ref().map(|bound| bound.gap));
        assert_eq!(row.worst_ratio, Some(alone.certificate.worst_ratio));
        assert_eq!(row.evaluations, alone.evaluations);
        assert!(row.lawful == Some(true), "{row:?}");
        let binds = alone.metrics.binding.iter().any(|binding| {
            let most = row.most_binding.as_ref();
            most.is_some_and(|it| it.joint == binding.joint && it.limit == binding.limit)
        });
        assert_eq!(binds, !alone.metrics.binding.is_empty(), "{row:?}");
        if alone.duration > slowest {
            slowest = alone.duration;
            if row.name == result.slowest {
                assert_eq!(timeless(&result.worst_case), timeless(&alone));
            }
        }
    }
    assert_eq!(result.worst_case.duration, slowest);
    let by_name = |name: &str| result.members.iter().find(|row| row.name == name).unwrap();
    let durations: Vec<f64> = result.members.iter().filter_map(|row| row.duration).collect();
    let least = durations.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(by_name(&result.slowest).duration, Some(slowest));
    assert_eq!(by_name(&result.fastest).duration, Some(least));
    let below = durations.iter().filter(|it| **it < result.median_duration).count();
    assert_eq!(below, durations.len() / 2);
    let evaluations: u64 = result.members.iter().map(|row| row.evaluations).sum();
    assert_eq!(result.evaluations, evaluations);
}

#[test]
fn threads_change_nothing() {
    let request = swept(json!([
        { "path": "/limit_scale/acceleration", "values": [0.2, 0.4, 0.6, 0.8, 1.0] },
        { "path": "/task/interpolation", "values": ["quintic", "jerk_limited"] },
    ]));
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| without_times(&family(request.clone())))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(8));
}

#[test]
fn a_sweep_is_a_product_whose_last_axis_changes_fastest() {
    let result = family(swept(json!([
        { "path": "/limit_scale/velocity", "values": [0.5, 1] },
        { "path": "/limits/velocity", "values": [1.5, null, [1, 1]] },
        { "path": "/task/waypoints/2/0", "values": [4] },
    ])));
    let names: Vec<&str> = result.members.iter().map(|row| row.name.as_str()).collect();
    // Both paths end alike, so names tell the whole paths.
    let name = |scale: &str, limit: &str| {
        format!("limit_scale/velocity={scale}, limits/velocity={limit}, task/waypoints/2/0=4")
    };
    let expected: Vec<String> = ["0.5", "1"]
        .iter()
        .flat_map(|scale| ["1.5", "null", "[1,1]"].map(|limit| name(scale, limit)))
        .collect();
    assert_eq!(names, expected);
    assert_eq!(result.members[4].values, [json!(1), json!(null), json!(4)]);
    assert_eq!(result.sweep.len(), 3);
    assert_eq!(result.worst_case.waypoints[2][0], 4.0);
    // More speed never makes slower, and none at all is the fastest.
    let duration = |at: usize| result.members[at].duration.unwrap();
    assert!(duration(1) <= duration(0) && duration(0) <= duration(2));
    assert!(duration(3) <= duration(0) && duration(5) <= duration(2));
    assert_eq!(duration(1), duration(4));
}

#[test]
fn a_member_that_fails_is_told_and_the_others_are_planned() {
    let impossible = json!({ "task": { "duration": { "at_most": 0.01 } } });
    let result = family(listed(json!([
        { "name": "no", "set": impossible }, { "name": "same" },
        { "name": "far", "set": { "task": { "waypoints": waypoints(9.0) } } } ])));
    let row = &result.members[0];
    let failure = row.failure.as_ref().unwrap();
    assert_eq!(failure.code, "limits_unreachable");
    assert!(failure.message.contains("0.01"), "{}", failure.message);
    assert_eq!((row.duration, row.lawful, row.most_binding.as_ref()), (None, None, None));
    assert_eq!((result.failed, result.members.len()), (1, 3));
    assert_eq!((result.fastest.as_str(), result.slowest.as_str()), ("same", "far"));
    assert!(result.verdict.starts_with("2 of 3 members planned"), "{}", result.verdict);

    let error = try_family(listed(json!([
        { "name": "no", "set": impossible },
        { "name": "neither", "set": { "task": { "duration": { "exactly": 0.02 } } } } ])));
    let error = error.unwrap_err();
    assert_eq!((error.code, error.partial), (PlanCode::LimitsUnreachable, None));
    assert!(error.message.contains("none of 2 members") && error.message.contains("no: "));
    assert_eq!(error.details["members"].as_array().unwrap().len(), 2);
}

#[test]
fn progress_counts_members() {
    let seen = Mutex::new(Vec::<Progress>::new());
    let request = swept(json!([{ "path": "/limit_scale/jerk", "values": [0.1, 0.2, 0.5, 1.0] }]));
    let done = prepared(request).run(&Budget::default(), &|step| seen.lock().unwrap().push(step));
    let Ok(PlanResult::Family(result)) = done else { panic!("a family") };
    let seen = seen.into_inner().unwrap();
    let counts: Vec<usize> = seen.iter().map(|it| it.members.as_ref().unwrap().done).collect();
    assert!(counts.is_sorted(), "{counts:?}");
    assert!((1..=4).all(|count| counts.contains(&count)), "{counts:?}");
    let last = seen.last().unwrap();
    let members = last.members.as_ref().unwrap();
    assert_eq!((members.done, members.of, members.failed), (4, 4, 0));
    assert_eq!(members.slowest, Some(result.worst_case.duration));
    assert_eq!(last.best, result.members[3].duration);
    assert_eq!(last.evaluations, result.evaluations);
}

/// Cancelled once two members are done, a family keeps what it has.
#[test]
fn a_cancelled_family_leaves_the_members_it_planned() {
    let cancel = CancelToken::default();
    let budget = Budget::new(cancel.clone());
    let values: Vec<f64> = (1..=400).map(|step| f64::from(step) / 400.0).collect();
    let request = swept(json!([{ "path": "/limit_scale/jerk", "values": values }]));
    let stop = |step: Progress| {
        if step.members.is_some_and(|members| members.done >= 2) {
            cancel.cancel();
        }
    };
    let error = prepared(request).run(&budget, &stop).unwrap_err();
    assert_eq!(error.code, PlanCode::Cancelled);
    let Some(PlanResult::Family(partial)) = error.partial.map(|partial| *partial) else {
        panic!("no partial result")
    };
    assert!((2..400).contains(&partial.members.len()));
    assert!(partial.members.iter().all(|row| row.duration.is_some()));
    assert!(partial.verdict.contains("of 400 members"));

    let early = CancelToken::default();
    early.cancel();
    let request = swept(json!([{ "path": "/limit_scale/jerk", "values": [0.5] }]));
    let error = prepared(request).run(&Budget::new(early), &|_| {}).unwrap_err();
    assert_eq!((error.code, error.partial), (PlanCode::Cancelled, None));
}

fn pointers(request: Value) -> Vec<String> {
    faults(request).0.into_iter().map(|fault| fault.pointer).collect()
}

#[test]
fn faults_point_into_members_and_name_each_cause_once() {
    let request = listed(json!([
        { "name": "a", "set": { "task": { "waypoints": [[0, 0], [1, "x"]] } } },
        { "name": "a", "set": { "task": { "waypoints": [[0, 0], [99, 1]] } } },
        { "name": "c", "set": { "colour": 1, "robot": "ur5e" } },
        { "name": "d", "set": { "task": { "type": "program", "legs": [] } } },
        { "name": "e", "set": { "limit_scale": { "jerk": 7 } } } ]));
    assert_eq!(
        pointers(request),
        [
            "/task/members/1/name",
            "/task/members/0/set/task/waypoints/1/1",
            "/task/members/1/set/task/waypoints/1/0",
            "/task/members/2/set/robot",
            "/task/members/3/set/task/type",
            "/task/members/4/set/limit_scale/jerk",
        ]
    );
    // What all members share is the problem's fault, or the request's.
    let mut shared = listed(json!([{ "name": "a" }, { "name": "b", "set": { "seed": 4 } }]));
    shared["task"]["problem"]["task"]["interpolation"] = json!("spline");
    shared["limit_scale"] = json!({ "velocity": 2 });
    assert_eq!(pointers(shared), ["/limit_scale/velocity", "/task/problem/task/interpolation"]);
}

#[test]
fn faults_of_a_sweep_name_values() {
    let request = swept(json!([
        { "path": "/limit_scale/jerk", "values": [0.5, 2] },
        { "path": "/task/interpolation", "values": ["quintic", "sextic"] } ]));
    let found = faults(request).0;
    let places: Vec<&str> = found.iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(places, ["/task/sweep/1/values/1", "/task/sweep/0/values/1"]);
    assert!(found[0].detail.starts_with("jerk=0.5, interpolation=sextic: "), "{found:?}");
    // A combination can be wrong where each value alone is right.
    let request = swept(json!([
        { "path": "/task/interpolation", "values": ["quintic", "3-5-3"] },
        { "path": "/task/waypoints", "values": [waypoints(1.234567), [[0, 0], [1, 1], [2, 2], [3, 3]]] } ]));
    let found = faults(request).0;
    assert!(found.iter().all(|fault| fault.pointer == "/task/sweep/0/values/1"), "{found:?}");
    assert!(found.iter().any(|fault| fault.detail.contains("waypoints=#1")), "{found:?}");
}

#[test]
fn what_makes_no_family_is_refused() {
    let axis = |path: &str, values: Value| json!({ "path": path, "values": values });
    for (sweep, expected) in [
        (json!([axis("limit_scale", json!([1]))]), vec!["/task/sweep/0/path"]),
        (json!([axis("", json!([1]))]), vec!["/task/sweep/0/path"]),
        (json!([axis("/seed", json!([]))]), vec!["/task/sweep/0/values"]),
        (json!([axis("/seed", json!([1, 2, 1]))]), vec!["/task/sweep/0/values/2"]),
        (json!([axis("/robot", json!(["ur5e"]))]), vec!["/task/sweep/0/values/0"]),
        (json!([axis("/task/waypoints/7/0", json!([1]))]), vec!["/task/sweep/0/values/0"]),
        (
            json!([axis("/task", json!([1])), axis("/task/clock", json!(["shared"]))]),
            vec!["/task/sweep/1/path"],
        ),
        (
            json!([
                axis("/seed", json!((0..40).collect::<Vec<_>>())),
                axis("/task/waypoints/2/0", json!((0..26).collect::<Vec<_>>()))
            ]),
            vec!["/task/sweep"],
        ),
        (json!([]), vec!["/task"]),
        (
            json!((0..9).map(|at| axis(&format!("/a{at}"), json!([1]))).collect::<Vec<_>>()),
            vec!["/task/sweep"],
        ),
    ] {
        assert_eq!(pointers(swept(sweep.clone())), expected, "{sweep}");
    }
    let mut both = swept(json!([axis("/seed", json!([1]))]));
    both["task"]["members"] = json!([{ "name": "a" }]);
    assert_eq!(pointers(both), ["/task/sweep"]);
    let many: Vec<Value> = (0..1001).map(|at| json!({ "name": format!("{at}") })).collect();
    assert_eq!(pointers(listed(json!(many))), ["/task/members"]);
    let mut nobody = listed(json!([{ "name": "a" }]));
    nobody.as_object_mut().unwrap().remove("robot");
    assert_eq!(pointers(nobody), ["/robot"]);
    let mut wrong = listed(json!([{ "name": "a", "change": {} }]));
    wrong["task"]["problem"]["task"] = json!({ "type": "program", "legs": [] });
    assert_eq!(pointers(wrong), ["/task/members/0/change"]);
    let mut program = listed(json!([{ "name": "a" }]));
    program["task"]["problem"]["task"] = json!({ "type": "program", "legs": [] });
    assert_eq!(pointers(program), ["/task/problem/task"]);
}

/// A problem with its own robot has nothing to do with the request's limits.
#[test]
fn the_problem_inherits_what_it_does_not_say() {
    let sweep = json!([{ "path": "/seed", "values": [1] }]);
    let mut inherits = swept(sweep.clone());
    inherits["limit_scale"] = json!({ "velocity": 0.25 });
    let mut own = inherits.clone();
    own["task"]["problem"]["robot"] = robot();
    let slow = family(inherits).worst_case.duration;
    let fast = family(own).worst_case.duration;
    let plain = family(swept(sweep)).worst_case.duration;
    assert_eq!(fast, plain);
    assert!(slow > 1.1 * plain);
}

#[test]
fn the_ready_made_families_have_the_worst_case_one_expects() {
    let what_if = family(scenario("mcb-ab-what-if", json!({})));
    assert_eq!(what_if.members.len(), 21);
    assert_eq!(what_if.slowest, "acceleration=0.4, jerk=0.5");
    assert_eq!(what_if.fastest, "acceleration=1.0, jerk=1.0");
    let alone = plan(scenario("mcb-ab-fastest", json!({})));
    let full = what_if.members.last().unwrap();
    assert_eq!(full.duration, Some(alone.duration));
    let binding = full.most_binding.as_ref().unwrap();
    let first = &alone.metrics.sensitivities[0];
    assert_eq!((&binding.joint, &binding.limit), (&first.joint, &first.limit));
    assert_eq!(binding.seconds_per_percent, Some(first.seconds_per_percent));

    let places = family(scenario("pallet-places", json!({})));
    assert_eq!((places.members.len(), places.failed), (25, 0));
    // The lowest layer is farthest from the way above the highest.
    assert!(places.slowest.starts_with("1.") && places.fastest.starts_with("5."));
}
