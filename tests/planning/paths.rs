//! The task `path` from request to result: what is refused, what fails and why,
//! and that what is delivered touches nothing.

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken};
use takt::plan::path::{Obstacle, PathResult};
use takt::plan::{PlanError, PlanRequest, PlanResult, scenarios, validate};
use takt::planner::{PLANNERS, distance, length};

fn request(task: Value) -> Value {
    let mut whole = json!({
        "type": "path", "start": [10, 50], "goal": [90, 50],
        "space": {"lower": [0, 0], "upper": [100, 100], "obstacles": [
            {"type": "ball", "center": [50, 50], "radius": 20},
            {"type": "box", "lower": [70, 20], "upper": [80, 60]}]},
    });
    whole.as_object_mut().unwrap().extend(task.as_object().unwrap().clone());
    json!({ "task": whole, "seed": 3 })
}

fn run_within(request: Value, budget: &Budget) -> Result<PathResult, PlanError> {
    let request = PlanRequest::parse(request).unwrap();
    let prepared = validate(&request, &|_| None).unwrap();
    match prepared.run(budget, &|_| {})? {
        PlanResult::Path(result) => Ok(*result),
        other => panic!("a path, not {other:?}"),
    }
}

fn run(request: Value) -> Result<PathResult, PlanError> {
    run_within(request, &Budget::default())
}

fn faults(request: Value) -> Vec<String> {
    let parsed = PlanRequest::parse(request);
    let checked = parsed.and_then(|request| validate(&request, &|_| None).map(|_| ()));
    checked.unwrap_err().0.into_iter().map(|fault| fault.pointer).collect()
}

/// Points of the polyline at small steps, by distances alone.
fn assert_free(path: &[Vec<f64>], result: &PathResult, case: &str) {
    for pair in path.windows(2) {
        for step in 0..=500 {
            let share = f64::from(step) / 500.0;
            let ends = pair[0].iter().zip(&pair[1]);
            let at: Vec<f64> = ends.map(|(a, b)| a + share * (b - a)).collect();
            for obstacle in &result.space.obstacles {
                let hit = match obstacle {
                    Obstacle::Ball(ball) => distance(&at, &ball.center) < ball.radius,
                    Obstacle::Box(block) => {
                        let ends = block.lower.iter().zip(&block.upper);
                        at.iter().zip(ends).all(|(x, (lower, upper))| (lower..=upper).contains(&x))
                    }
                };
                assert!(!hit, "{case}: {at:?} in {obstacle:?}");
            }
        }
    }
}

#[test]
fn every_planner_and_smoothing_delivers_a_free_path() {
    let names = PLANNERS.iter().map(|entry| entry.name).chain(["auto"]);
    for name in names {
        for smoothing in ["none", "shortcut", "bezier"] {
            let task = json!({ "planner": {"name": name}, "smoothing": {"name": smoothing} });
            let mut request = request(task);
            if name != "auto" {
                request["task"]["planner"]["iterations"] = json!(2000);
            }
            let result = run(request).unwrap();
            let case = format!("{name}, {smoothing}");
            assert_free(&result.path, &result, &case);
            let off = (length(&result.path) / result.length - 1.0).abs();
            assert!(off < 1e-12, "{case}: {off}");
            assert_eq!(result.straight_length, 80.0, "{case}");
            assert_eq!(result.smoothing, smoothing);
            assert_eq!(result.smoothed_path.is_some(), smoothing != "none", "{case}");
            assert_eq!(result.curve.is_some(), smoothing == "bezier", "{case}");
            assert!(result.clearance.unwrap() > 0.0, "{case}");
            let best = result.best_path();
            assert_free(best, &result, &case);
            assert_eq!([&best[0][..], &best[best.len() - 1]], [&[10.0, 50.0], &[90.0, 50.0]]);
            if smoothing == "shortcut" {
                assert!(result.smoothed_length.unwrap() <= result.length, "{case}");
            }
            assert_eq!(result.convergence.last().unwrap().best, Some(result.length), "{case}");
        }
    }
}

#[test]
fn equal_requests_give_equal_results() {
    let again = || {
        let mut result = run(request(json!({ "trees": true }))).unwrap();
        result.planning_s = 0.0;
        result.convergence.iter_mut().for_each(|point| point.elapsed_s = 0.0);
        assert!(!result.tree_edges.is_empty() && result.tree_edges.len() <= 2000);
        serde_json::to_string(&result).unwrap()
    };
    assert_eq!(again(), again());
    assert!(run(request(json!({}))).unwrap().tree_edges.is_empty());
}

#[test]
fn all_faults_of_a_request_are_told_together() {
    let space = json!({ "lower": [0, 0], "upper": [100], "obstacles": [
        {"type": "ball", "center": [1, 2, 3], "radius": -1},
        {"type": "box", "lower": [5, 5], "upper": [4, 6]}] });
    let found = faults(request(json!({
        "space": space, "goal": [90, 500],
        "planner": {"name": "rrt_star", "range": 0, "stride": 1},
        "smoothing": {"name": "spline"},
    })));
    let expected = [
        "/task/space/upper",
        "/task/space/obstacles/0/center",
        "/task/space/obstacles/0/radius",
        "/task/space/obstacles/1/upper/0",
        "/task/planner/stride",
        "/task/planner/range",
        "/task/smoothing/name",
    ];
    assert_eq!(found, expected);
    let structural = json!({ "space": {"lower": [0, 0], "upper": [1, 1], "obstacles": [
        {"type": "ball", "center": [0.5, 0.5]}, {"type": "cone"}, {"type": "box", "lower": 1}, 7,
        {"type": "ball", "center": [0.5, 0.5], "radius": 1, "colour": "red"}] } });
    let found = faults(request(structural));
    for expected in ["/0/radius", "/1/type", "/2/lower", "/3", "/4/colour"] {
        let expected = format!("/task/space/obstacles{expected}");
        assert!(found.contains(&expected), "{expected} not in {found:?}");
    }
    let mut with_robot = request(json!({ "goal": [90, 500] }));
    with_robot["limit_scale"] = json!({ "velocity": 0.5 });
    assert_eq!(faults(with_robot), ["/limit_scale", "/task/goal/1"]);
    let flat = json!({ "space": {"lower": [0, 0], "upper": [100, 0]} });
    assert_eq!(faults(request(flat)), ["/task/space/upper/1", "/task/start/1", "/task/goal/1"]);
    let one = json!({ "space": {"lower": [0], "upper": [1]}, "start": [0], "goal": [1] });
    assert_eq!(faults(request(one)), ["/task/space/lower"]);
    let degree = json!({ "smoothing": {"name": "bezier", "degree": 4} });
    assert_eq!(faults(request(degree)), ["/task/smoothing/degree"]);
    let huge = json!({ "start": [1e300, 50], "planner": {"name": "dijkstra"} });
    assert_eq!(faults(request(huge)), ["/task/start/0", "/task/planner/name"]);
}

#[test]
fn an_end_in_an_obstacle_says_which_and_how_deep() {
    for (name, end, obstacle, depth) in [
        ("start", [50.0, 65.0], 0, 5.0),
        ("goal", [72.0, 40.0], 1, 2.0),
        ("goal", [70.0, 40.0], 1, 0.0),
        ("start", [50.0, 70.0], 0, 0.0),
    ] {
        let error = run(request(json!({ name: end }))).unwrap_err();
        assert_eq!(error.code.as_str(), format!("{name}_in_collision"));
        let expected = json!({
            "end": name, "obstacle": obstacle, "kind": if obstacle == 0 { "ball" } else { "box" },
            "depth": depth, "pointer": format!("/task/space/obstacles/{obstacle}"),
        });
        assert_eq!(error.details, expected);
    }
}

#[test]
fn a_way_that_is_barred_fails_with_how_far_it_came() {
    let space = json!({ "lower": [0, 0], "upper": [100, 100], "obstacles": [
        {"type": "box", "lower": [50, 0], "upper": [60, 100]}] });
    let planner = json!({ "name": "rrt_connect", "iterations": 3000 });
    let error = run(request(json!({ "space": space, "planner": planner }))).unwrap_err();
    assert_eq!(error.code.as_str(), "no_path");
    assert_eq!(error.details["iterations"], 3000);
    assert_eq!(error.details["stop_reason"], "iteration_limit");
    let near = error.details["nearest_to_goal"].as_f64().unwrap();
    assert!((40.0..42.0).contains(&near), "{near}");
    let near = error.details["nearest_to_start"].as_f64().unwrap();
    assert!((50.0..52.0).contains(&near), "{near}");
}

#[test]
fn a_cancelled_search_hands_back_the_path_it_has() {
    let token = CancelToken::default();
    let task = json!({ "planner": {"name": "rrt_star", "iterations": 100_000_000} });
    let request = PlanRequest::parse(request(task)).unwrap();
    let prepared = validate(&request, &|_| None).unwrap();
    let cancel = token.clone();
    let found = prepared.run(&Budget::new(token), &|progress| {
        if progress.best.is_some() && progress.iteration > 500 {
            cancel.cancel();
        }
    });
    let error = found.unwrap_err();
    assert_eq!(error.code.as_str(), "cancelled");
    let Some(PlanResult::Path(partial)) = error.partial.map(|partial| *partial) else {
        panic!("a path")
    };
    assert_free(&partial.path, &partial, "cancelled");
}

#[test]
fn results_read_back_as_paths() {
    let result = PlanResult::Path(Box::new(run(request(json!({ "trees": true }))).unwrap()));
    let text = serde_json::to_string(&result).unwrap();
    assert_eq!(serde_json::from_str::<PlanResult>(&text).unwrap(), result);
}

/// Shortest ways as far as they are known.
#[test]
fn scenarios_find_short_ways() {
    for (name, least, most) in [
        ("zhang-plane-1", 113.2, 117.0),
        ("zhang-plane-2", 141.0, 145.0),
        ("zhang-box", 924.0, 990.0),
    ] {
        let result = run(scenarios::get(name).unwrap().request.clone()).unwrap();
        assert_free(result.best_path(), &result, name);
        let found = [result.length, result.best_length()];
        assert!(found.iter().all(|length| (least..most).contains(length)), "{name}: {found:?}");
    }
}
