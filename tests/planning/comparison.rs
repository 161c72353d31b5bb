//! Comparisons and benchmarks: fair, reproducible, complete, and clear about
//! what they cannot do.

use std::sync::Mutex;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken};
use takt::math::random::derive_seed;
use takt::picture::{bands, page};
use takt::plan::{
    ComparisonResult, PlanCode, PlanError, PlanRequest, PlanResult, Progress, scenarios, validate,
};
use takt::robot::catalogue;

use crate::support::{faults, merge, plan, scenario};

/// A comparison on the section `mcb-ab`.
fn comparison(changes: Value) -> Value {
    let mut request = scenarios::get("mcb-ab").unwrap().request.clone();
    let task = request["task"].take();
    request["task"] = json!({
        "type": "comparison", "task": task, "methods": ["pso", "cfpso", "exact"],
        "runs": 6, "max_evaluations": 600,
    });
    merge(&mut request["task"], changes);
    request
}

fn benchmark(changes: Value) -> Value {
    let mut task = json!({
        "type": "benchmark", "functions": ["f1", "f5"], "dimension": 4, "population": 10,
        "iterations": 30, "runs": 5, "optimizers": ["pso", "golds_pso"],
    });
    merge(&mut task, changes);
    json!({ "seed": 5, "task": task })
}

fn run(
    request: Value,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let request = PlanRequest::parse(request).unwrap_or_else(|faults| panic!("{faults}"));
    let plan = validate(&request, &catalogue::get).unwrap_or_else(|faults| panic!("{faults}"));
    plan.run(budget, progress)
}

fn compare(request: Value) -> ComparisonResult {
    match run(request, &Budget::default(), &|_| {}) {
        Ok(PlanResult::Comparison(result)) => result,
        other => panic!("not compared: {other:?}"),
    }
}

/// The result as text without the fields that tell how long it took.
fn timeless(mut result: ComparisonResult) -> String {
    result.planning_s = 0.0;
    for row in result.problems.iter_mut().flat_map(|problem| &mut problem.methods) {
        row.seconds_per_evaluation = 0.0;
    }
    serde_json::to_string(&result).unwrap()
}

#[test]
fn equal_requests_give_equal_bytes_on_any_number_of_threads() {
    for request in [comparison(json!({})), benchmark(json!({}))] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            timeless(pool.install(|| compare(request.clone())))
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(8));
    }
}

#[test]
fn every_method_gets_its_runs_and_no_more_than_its_evaluations() {
    let result =
        compare(comparison(json!({ "methods": ["pso", "ga", "coa", "exact", "dual_pso"] })));
    let [problem] = &result.problems[..] else { panic!("one problem") };
    let runs: Vec<u32> = problem.methods.iter().map(|row| row.runs).collect();
    assert_eq!(runs, [6, 6, 6, 1, 6]);
    for row in &problem.methods {
        assert!(row.evaluations <= 600 * u64::from(row.runs), "{}: {}", row.label, row.evaluations);
        assert_eq!(row.feasible_runs, row.runs);
        assert_eq!(row.curve.last().unwrap().evaluations, 600);
        assert_eq!(row.curve.last().unwrap().median, row.median, "{}", row.label);
        assert!(row.curve.windows(2).all(|pair| {
            let value = |at: usize| pair[at].median.unwrap_or(f64::INFINITY);
            value(1) <= value(0)
        }));
        let order = [row.best, row.lower_quartile, row.median, row.upper_quartile, row.worst];
        assert!(order.windows(2).all(|pair| pair[0] <= pair[1]), "{order:?}");
        assert!((0.0..=1.0).contains(&row.success_rate));
        assert_eq!(row.success_rate > 0.0, row.evaluations_to_success.is_some());
    }
    // The schedule was fitted to the evaluations: 12 generations of 50.
    assert_eq!(problem.methods[0].parameters["iterations"], 11.0);
    assert_eq!(problem.methods[0].evaluations, 3600);
}

/// A run of a comparison is the plan that its method, seed and budget would give.
#[test]
fn a_row_is_made_of_the_plans_of_its_seeds() {
    let result = compare(comparison(json!({ "methods": ["cfpso"], "runs": 5 })));
    let row = &result.problems[0].methods[0];
    let mut durations: Vec<f64> = (0..5)
        .map(|run| {
            let optimizer = json!({ "name": "cfpso", "iterations": 11, "max_evaluations": 600 });
            let mut request = scenario("mcb-ab", json!({ "optimizer": optimizer }));
            request["seed"] = json!(derive_seed(7, run));
            plan(request).duration
        })
        .collect();
    durations.sort_by(f64::total_cmp);
    let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-9;
    assert!(near(row.best, durations[0]), "{row:?} {durations:?}");
    assert!(near(row.median, durations[2]) && near(row.worst, durations[4]));
    assert!(near(row.mean, durations.iter().sum::<f64>() / 5.0));
    let best = result.problems[0].best_run.as_ref().unwrap();
    assert!((best.position.iter().sum::<f64>() - durations[0]).abs() < 1e-9);
}

#[test]
fn the_optimum_and_the_bound_stand_beside_the_methods() {
    let result = compare(comparison(json!({})));
    let problem = &result.problems[0];
    let exact = plan(scenario("mcb-ab", json!({})));
    let optimum = problem.optimum.as_ref().unwrap();
    assert!((optimum.value - exact.duration).abs() < 1e-9);
    assert!((optimum.position.iter().sum::<f64>() - optimum.value).abs() < 1e-9);
    assert_eq!(problem.lower_bound, exact.bound.map(|bound| bound.lower));
    assert!(problem.best_known.unwrap() <= optimum.value);
    let p_values: Vec<bool> = problem.methods.iter().map(|row| row.p_value.is_some()).collect();
    // The best of those with seeds is compared with the others of them.
    let best = usize::from(problem.methods[1].median < problem.methods[0].median);
    let label = problem.methods[best].label.as_str();
    assert_eq!(problem.best_method.as_deref(), Some(label));
    assert_eq!(p_values, [best == 1, best == 0, false]);
    let verdict = format!("{label} did best on the problem");
    assert!(result.verdict.contains(&verdict), "{}", result.verdict);
}

#[test]
fn benchmarks_need_no_robot_and_know_their_optimum() {
    let result = compare(benchmark(json!({ "shifted": true })));
    assert_eq!((result.task.as_str(), result.max_evaluations), ("benchmark", 310));
    let names: Vec<&str> = result.problems.iter().map(|problem| problem.name.as_str()).collect();
    assert_eq!(names, ["f1", "f5"]);
    for problem in &result.problems {
        assert_eq!((problem.best_known, &problem.robot), (Some(0.0), &None));
        let optimum = problem.optimum.as_ref().unwrap();
        assert!(optimum.position.iter().all(|x| *x != 0.0));
        assert!(problem.methods.iter().all(|row| row.median_gap == row.median));
    }
    let all = compare(benchmark(json!({ "optimizers": [], "functions": [], "runs": 1 })));
    assert_eq!((all.problems.len(), all.problems[0].methods.len()), (8, 11));
}

#[test]
fn a_cancelled_comparison_ends_cancelled_with_what_was_finished() {
    let cancel = CancelToken::default();
    let request = benchmark(json!({ "iterations": 100_000, "runs": 50 }));
    let stop = |progress: Progress| {
        if progress.leg.as_deref() == Some("f1") && progress.evaluations > 1000 {
            cancel.cancel();
        }
    };
    let error = run(request, &Budget::new(cancel.clone()), &stop).unwrap_err();
    assert_eq!(error.code, PlanCode::Cancelled);
    let Some(PlanResult::Comparison(partial)) = error.partial.map(|it| *it) else {
        panic!("no partial result")
    };
    assert!(partial.problems.is_empty());
    assert!(partial.evaluations < 10_000_000, "{}", partial.evaluations);
}

#[test]
fn progress_names_problem_and_method_and_never_goes_back() {
    let seen = Mutex::new(Vec::new());
    let see = |progress: Progress| seen.lock().unwrap().push(progress);
    let Ok(PlanResult::Comparison(result)) = run(comparison(json!({})), &Budget::default(), &see)
    else {
        panic!("not compared");
    };
    let seen = seen.into_inner().unwrap();
    assert!(seen.windows(2).all(|pair| pair[0].evaluations <= pair[1].evaluations));
    assert!(seen.last().unwrap().evaluations <= result.evaluations);
    assert!(seen.iter().all(|progress| progress.leg.as_deref() == Some("task")));
    for method in ["pso", "cfpso", "exact"] {
        assert!(seen.iter().any(|progress| progress.method.as_deref() == Some(method)), "{method}");
    }
}

#[test]
fn a_problem_may_bring_its_own_robot_and_limits() {
    let scenario = scenarios::get("optimizers").unwrap();
    let mut request = scenario.request.clone();
    request["task"]["runs"] = json!(2);
    request["task"]["max_evaluations"] = json!(200);
    let result = compare(request);
    let robots: Vec<_> = result.problems.iter().map(|it| it.robot.as_deref().unwrap()).collect();
    assert_eq!(robots[..3], ["rokae_xb4", "woodworking_pprr", "epson_c4_a601s"]);
    assert_eq!((result.problems.len(), result.problems[0].methods.len()), (6, 12));
}

#[test]
fn every_fault_is_told_with_its_place() {
    let problem = comparison(json!({}))["task"]["task"].clone();
    let named = |name: &str| json!({ "name": name, "task": problem });
    let methods: Vec<String> = (0..33).map(|at| format!("m{at}")).collect();
    let cases = [
        (comparison(json!({ "methods": [] })), "/task/methods", "0 methods"),
        (comparison(json!({ "methods": methods })), "/task/methods", "33 methods"),
        (comparison(json!({ "methods": ["psi"] })), "/task/methods/0/name", "no optimizer"),
        (comparison(json!({ "methods": [7] })), "/task/methods/0", "expected an optimizer's name"),
        (comparison(json!({ "methods": ["ga", "ga"] })), "/task/methods/1/label", "another one"),
        (
            comparison(json!({ "methods": [{ "name": "ga", "population": 1 }] })),
            "/task/methods/0/population",
            "outside 4",
        ),
        (
            comparison(json!({ "methods": [{ "name": "ga", "time_limit_s": 1 }] })),
            "/task/methods/0/time_limit_s",
            "no other limit",
        ),
        (comparison(json!({ "runs": 0 })), "/task/runs", "outside 1 to 1000"),
        (comparison(json!({ "runs": 1001 })), "/task/runs", "outside 1 to 1000"),
        (comparison(json!({ "max_evaluations": 0 })), "/task/max_evaluations", "outside 1"),
        (comparison(json!({ "success_tolerance": 0 })), "/task/success_tolerance", "outside"),
        (
            comparison(json!({ "runs": 1000, "max_evaluations": 1_000_000_000 })),
            "/task",
            "fewer runs",
        ),
        (comparison(json!({ "problems": [named("p")] })), "/task/problems", "exclude"),
        (
            comparison(json!({ "task": null, "problems": [named("p"), named("p")] })),
            "/task/problems/1/name",
            "another one",
        ),
        (comparison(json!({ "task": null })), "/task", "either `task`"),
        (
            comparison(json!({ "task": { "optimizer": { "name": "ga" } } })),
            "/task/task/optimizer",
            "`methods`",
        ),
        (comparison(json!({ "task": { "clock": "per_joint" } })), "/task/task/clock", "shared"),
        (
            comparison(json!({ "task": { "duration": { "exactly": 9 } } })),
            "/task/task/duration",
            "shortest",
        ),
        (
            comparison(json!({ "task": { "constraints": "velocity_only" } })),
            "/task/task/constraints",
            "within all limits",
        ),
        (
            comparison(json!({ "task": { "objective": { "time": 1, "energy": 1 } } })),
            "/task/task/objective",
            "by time alone",
        ),
        (
            json!({ "robot": "rokae_xb4", "task": { "type": "comparison", "methods": ["pso"],
                "task": { "type": "program", "legs": [] } } }),
            "/task/task",
            "not on a program",
        ),
        (benchmark(json!({ "optimizers": ["exact"] })), "/task/optimizers/0", "scaling law"),
        (benchmark(json!({ "functions": ["f9"] })), "/task/functions/0", "known: f1"),
        (benchmark(json!({ "functions": ["f1", "f1"] })), "/task/functions/1", "twice"),
        (benchmark(json!({ "dimension": 0 })), "/task/dimension", "outside 1 to 1000"),
        (benchmark(json!({ "dimension": 1001 })), "/task/dimension", "outside 1 to 1000"),
        (benchmark(json!({ "population": 1 })), "/task/population", "outside 2"),
        (benchmark(json!({ "iterations": 2_000_000 })), "/task/iterations", "outside 0"),
        (benchmark(json!({ "colour": 1 })), "/task/colour", "unknown field"),
        (json!({ "robot": "ur5e", "task": { "type": "benchmark" } }), "/robot", "without robot"),
        (
            json!({ "limits": { "jerk": null }, "task": { "type": "benchmark" } }),
            "/limits",
            "without limits",
        ),
    ];
    for (request, pointer, words) in cases {
        let found = faults(request);
        let named = found.0.iter().any(|it| it.pointer == pointer && it.detail.contains(words));
        assert!(named, "{pointer} {words}: {found:?}");
    }
}

/// What a penalty lifts above every lawful duration is not shown as one.
#[test]
fn penalties_are_no_durations() {
    let penalty = |longest: f64| {
        let durations = json!({ "min": 0.1, "max": longest });
        let task = json!({ "constraint_handling": "penalty", "durations": durations });
        let methods = json!(["pso", "ga"]);
        compare(comparison(json!({ "task": task, "methods": methods, "max_evaluations": 200 })))
    };
    // Three segments of at most 1.95 s hardly hold the optimum of 5.757 s.
    let narrow = penalty(1.95);
    let problem = &narrow.problems[0];
    assert!(problem.methods.iter().all(|row| row.feasible_runs == 0 && row.best.is_none()));
    let values = problem.methods.iter().flat_map(|row| &row.curve).filter_map(|it| it.median);
    assert_eq!(values.count(), 0);
    // Where there is room, what is shown is at least the optimum and at most the range.
    let wide = penalty(4.0);
    let optimum = wide.problems[0].optimum.as_ref().unwrap().value;
    for row in &wide.problems[0].methods {
        assert!(row.feasible_runs > 0, "{}", row.label);
        let lawful = optimum * (1.0 - 1e-9)..=12.0;
        assert!(row.best.is_some_and(|best| lawful.contains(&best)), "{row:?}");
        let shown = row.curve.iter().flat_map(|it| [it.lower_quartile, it.upper_quartile]);
        assert!(shown.flatten().all(|value| lawful.contains(&value)), "{row:?}");
    }
}

#[test]
fn a_robot_is_missed_only_where_one_is_needed() {
    let mut request = comparison(json!({}));
    request.as_object_mut().unwrap().remove("robot");
    let found = faults(request.clone());
    assert_eq!(found.0[0].pointer, "/robot", "{found:?}");
    let own = json!({ "name": "p", "robot": "rokae_xb4", "limits": request["limits"],
        "task": request["task"]["task"] });
    merge(&mut request["task"], json!({ "task": null, "problems": [own], "runs": 1 }));
    assert_eq!(compare(request.clone()).problems[0].robot.as_deref(), Some("rokae_xb4"));
    request["task"]["problems"][0]["limits"]["velocity"] = json!(-1.0);
    let found = faults(request);
    assert_eq!(found.0[0].pointer, "/task/problems/0/limits/velocity", "{found:?}");
}

#[test]
fn pages_and_pictures_stand_alone_and_obey_no_name() {
    let label = "<script>alert(1)</script>";
    let methods = json!([{ "name": "pso", "label": label }, "cfpso", "exact"]);
    let result = compare(comparison(json!({ "methods": methods })));
    let html = page::comparison(&result);
    assert!(!html.contains("<script") && !html.contains("http://www.w3.org/1999/xhtml"));
    assert!(html.contains("&lt;script&gt;"));
    for outside in ["src=", "href=", "@import", "url("] {
        assert!(!html.contains(outside), "{outside}");
    }
    for tag in ["html", "head", "body", "main", "section", "table", "svg", "figure", "tr"] {
        let count = |text: &str| html.matches(text).count();
        let opened = count(&format!("<{tag}>")) + count(&format!("<{tag} "));
        assert_eq!(opened, count(&format!("</{tag}>")), "{tag}");
        assert!(opened > 0, "{tag}");
    }
    assert!(html.contains("prefers-color-scheme: dark") && html.contains("@media print"));
    let verdict = page::escape(&result.verdict).replace("`exact`", "<code>exact</code>");
    assert!(html.contains(&verdict), "{verdict}");
    // A band and a line per method with seeds.
    let svg = bands(&result.problems[0]);
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    assert!(svg.matches("<polygon").count() >= 2 && !svg.contains("NaN") && !svg.contains("inf"));
}
