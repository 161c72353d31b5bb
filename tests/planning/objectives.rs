//! Weights and fronts: the optimum they promise, what a front may never be,
//! and every request that makes no sense.

use std::sync::Mutex;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken, StopReason};
use takt::math::random::RandomStream;
use takt::plan::{ParetoFront, PlanRequest, PlanResult, TrajectoryResult, validate};
use takt::robot::catalogue;
use takt::trajectory::interpolation::{INTERPOLATIONS, Timing};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::objective::{Measures, Weighting};
use takt::trajectory::timing::{Handling, TimingProblem};

use crate::support::{faults, plan, scenario, timeless, try_plan};

fn near(what: &str, found: f64, expected: f64, relative: f64) {
    let off = found / expected - 1.0;
    assert!(off.abs() <= relative, "{what}: {found} is {off:.2e} from {expected}");
}

fn front(result: &TrajectoryResult) -> &ParetoFront {
    result.pareto.as_ref().unwrap()
}

fn times_of(front: &ParetoFront) -> Vec<f64> {
    front.points.iter().map(|point| point.values[0]).collect()
}

/// Optima by differential evolution and Nelder-Mead over proportions in another
/// program, curves by dense linear systems and peaks by companion matrices there.
#[test]
fn weighted_optima_match_an_independent_program() {
    let cases = [
        ("wood", "3-5-3", [1.0, 1.0, 0.0], 1.745_870_77),
        ("wood", "3-5-3", [1.0, 0.0, 0.5], 1.390_778_69),
        ("wood", "quintic", [1.0, 1.0, 0.0], 1.707_053),
        ("wood", "quintic", [1.0, 0.1, 0.0], 1.099_899),
        ("wood", "quintic", [1.0, 0.0, 0.5], 1.402_222),
        ("wood", "quintic", [1.0, 0.02, 0.02], 1.039_920),
    ];
    for (name, interpolation, [time, rms_jerk, energy], expected) in cases {
        let objective = json!({ "time": time, "rms_jerk": rms_jerk, "energy": energy });
        let task = json!({ "interpolation": interpolation, "objective": objective });
        let result = plan(scenario(name, task.clone()));
        let what = format!("{name}, {task}");
        let reference = result.metrics.reference.unwrap();
        let weights = Measures { time, rms_jerk, energy };
        let value = Weighting::new(&weights, &reference).value(&result.metrics.objective);
        near(&what, value, expected, 3e-6);
        near(&what, result.convergence.last().unwrap().best.unwrap(), value, 1e-9);
        assert!(result.certificate.lawful, "{what}");
        let fastest = plan(scenario(name, json!({ "interpolation": interpolation })));
        assert_eq!(fastest.metrics.objective.time, fastest.duration);
        near(&what, reference.time, fastest.duration, 1e-12);
        assert_eq!(timeless(&result), timeless(&plan(scenario(name, task))), "{what}");
    }
}

/// The same program's least jerk and energy for a given duration.
#[test]
fn gentlest_motions_of_a_given_duration_match_an_independent_program() {
    let cases = [
        ("3-5-3", "rms_jerk", 7.498047437656783, 2.666685193),
        ("3-5-3", "energy", 7.625132987447577, 1.877285252),
        ("3-5-3", "rms_jerk", 8.223182633521898, 2.000260111208627),
        ("3-5-3", "energy", 9.718306748707697, 0.6490151621951884),
        ("quintic", "rms_jerk", 4.099136585671289, 4.764215428),
        ("quintic", "energy", 4.168613476953853, 3.463876711),
        ("quintic", "rms_jerk", 4.495563553577685, 3.26827029849661),
        ("quintic", "energy", 5.312938745137264, 1.2431937161228799),
    ];
    for (interpolation, objective, duration, expected) in cases {
        let task = json!({ "interpolation": interpolation, "objective": { objective: 2.5 },
            "duration": { "exactly": duration } });
        let result = plan(scenario("wood", task.clone()));
        assert_eq!(result.duration, duration);
        let measures = result.metrics.objective;
        let found = if objective == "energy" { measures.energy } else { measures.rms_jerk };
        near(&task.to_string(), found, expected, 3e-8);
        assert!(result.certificate.lawful);
        // At most that long: longer would be gentler, so it is used up.
        let mut at_most = task;
        at_most["duration"] = json!({ "at_most": duration });
        near("at most", plan(scenario("wood", at_most)).duration, duration, 1e-9);
    }
}

/// Where hardly any time is to spare few proportions are lawful, and gentle
/// ones that are not must not be taken for a plan.
#[test]
fn little_time_to_spare_is_used() {
    let problems: Value =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    for problem in problems.as_array().unwrap() {
        let dof = problem["velocity"].as_array().unwrap().len();
        let joint = |j: usize| {
            json!({ "name": format!("j{j}"), "type": "revolute", "limits": {
                "velocity": problem["velocity"][j], "acceleration": problem["acceleration"][j],
                "jerk": problem["jerk"][j] } })
        };
        let robot = json!({ "joints": (0..dof).map(joint).collect::<Vec<_>>() });
        let request = |more: Value| {
            let mut task = json!({ "type": "waypoints", "waypoints": problem["waypoints"] });
            crate::support::merge(&mut task, more);
            json!({ "robot": robot, "task": task })
        };
        let fastest = plan(request(json!({})));
        let mut before = fastest.metrics.objective.energy;
        for factor in [1.0001, 1.001, 1.01, 1.1] {
            let duration = json!({ "exactly": factor * fastest.duration });
            let objective = json!({ "energy": 1 });
            let result = plan(request(json!({ "objective": objective, "duration": duration })));
            let energy = result.metrics.objective.energy;
            let stretched = fastest.metrics.objective.energy / f64::powi(factor, 4);
            assert!(energy <= stretched && energy < before, "{}: {energy}", problem["name"]);
            assert!(result.certificate.lawful);
            before = energy;
        }
    }
}

/// A weight on time may leave some of the longest duration unused.
#[test]
fn at_most_binds_only_where_longer_would_be_better() {
    let task = |most: f64| {
        let objective = json!({ "time": 1, "rms_jerk": 1 });
        scenario("wood", json!({ "objective": objective, "duration": { "at_most": most } }))
    };
    let free = plan(scenario("wood", json!({ "objective": { "time": 1, "rms_jerk": 1 } })));
    near("unused", plan(task(2.0 * free.duration)).duration, free.duration, 1e-6);
    near("used up", plan(task(0.9 * free.duration)).duration, 0.9 * free.duration, 1e-9);
    let error = try_plan(task(7.0)).unwrap_err();
    assert!(error.message.contains("7.4756") && error.message.contains("7 s"), "{error}");
    // A search range bounds the slowest motion as well.
    let range = json!({ "objective": { "energy": 1 }, "durations": { "min": 0.1, "max": 4.0 } });
    let result = plan(scenario("wood", range));
    near("longest segment", result.durations.iter().copied().fold(0.0, f64::max), 4.0, 1e-9);
}

/// Position limits are kept also where weights alone would leave them.
#[test]
fn weights_mind_position_limits() {
    let request = |upper: f64| {
        json!({
            "robot": { "joints": [{ "name": "x", "type": "prismatic", "limits":
                { "lower": -1, "upper": upper, "velocity": 1, "acceleration": 2, "jerk": 20 } }] },
            "task": { "type": "waypoints", "waypoints": [[0.0], [0.9], [0.85]],
                "objective": { "time": 1, "rms_jerk": 0.2 },
                "pareto": { "objectives": ["time", "energy"], "points": 5 } },
        })
    };
    let highest = |result: &TrajectoryResult| result.certificate.joints[0].position.max;
    let free = plan(request(3.0));
    let beyond = highest(&free) - 0.9;
    assert!(beyond > 1e-4, "{beyond}");
    let upper = 0.9 + 0.3 * beyond;
    let bounded = plan(request(upper));
    assert!(highest(&bounded) <= upper + 1e-9 && bounded.certificate.lawful);
    let best = |result: &TrajectoryResult| result.convergence.last().unwrap().best.unwrap();
    assert!(best(&bounded) > 0.5 && bounded.duration != free.duration);
    assert!(!front(&bounded).points.is_empty());
}

/// Any optimizer serves; the exact one is not beaten.
#[test]
fn swarms_weigh_too() {
    let task = |optimizer: Value| {
        scenario(
            "mcb-ab",
            json!({ "objective": { "time": 1, "rms_jerk": 0.3 }, "optimizer": optimizer }),
        )
    };
    let best = |result: &TrajectoryResult| result.convergence.last().unwrap().best.unwrap();
    let exact = best(&plan(task(json!({ "name": "exact" }))));
    for name in ["pso", "pso_linear", "improved_pso"] {
        let result = plan(task(json!({ "name": name, "iterations": 60 })));
        let excess = best(&result) / exact - 1.0;
        assert!((-1e-9..5e-3).contains(&excess), "{name}: {excess}");
        assert!(result.certificate.lawful && result.optimizer == name);
    }
}

/// Integrals by Gauss' rule in the kernel against the polynomials' own.
#[test]
fn measures_of_the_kernel_are_those_of_the_trajectory() {
    let mut random = RandomStream::new(11, 0);
    let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
    for dof in [1, 5, 8, 11] {
        let limits = vec![KernelLimits { derivatives: [1.0; 3], position: unbounded }; dof];
        let waypoints: Vec<Vec<f64>> =
            (0..4).map(|_| (0..dof).map(|_| random.uniform(-2.0, 2.0)).collect()).collect();
        for entry in INTERPOLATIONS {
            let Timing::Search(kernel) = entry.timing else { continue };
            let problem =
                TimingProblem::new(kernel, &waypoints, &limits, Handling::RepairUniform, None);
            let durations: Vec<f64> = (0..3).map(|_| random.uniform(0.2, 3.0)).collect();
            let trajectory = problem.trajectory(&durations);
            let (found, expected) =
                (problem.measures(&durations), Measures::of_trajectory(&trajectory));
            let what = format!("{} with {dof} joints", entry.name);
            near(&what, found.time, expected.time, 1e-14);
            near(&what, found.rms_jerk, expected.rms_jerk, 1e-10);
            near(&what, found.energy, expected.energy, 1e-10);
            // The scaling law.
            let longer: Vec<f64> = durations.iter().map(|t| 1.7 * t).collect();
            let scaled = found.scaled(1.7);
            near(&what, problem.measures(&longer).rms_jerk, scaled.rms_jerk, 1e-9);
            near(&what, problem.measures(&longer).energy, scaled.energy, 1e-9);
        }
    }
}

fn fronts() -> [(Value, f64); 4] {
    let task = |name: &str, other: &str, interpolation: &str| {
        scenario(
            name,
            json!({ "interpolation": interpolation,
            "pareto": { "objectives": ["time", other], "points": 12 } }),
        )
    };
    [
        (task("wood", "rms_jerk", "3-5-3"), 3.0),
        (task("wood", "energy", "quintic"), 4.0),
        (task("mcb-ab", "rms_jerk", "quintic"), 3.0),
        (task("mcb-ab", "energy", "quintic_han"), 4.0),
    ]
}

/// A front that stretching the fastest motion beats, or whose points beat each
/// other, is none. Its points are lawful, and can be planned again to the bit.
#[test]
fn fronts_dominate_the_stretched_fastest_motion() {
    for (request, power) in fronts() {
        let result = plan(request.clone());
        let front = front(&result);
        assert_eq!(front.points.len(), 12);
        assert_eq!(front.points[0].durations, result.durations, "the fastest comes first");
        let [fastest, most] = [front.points[0].values[0], front.points[0].values[1]];
        near("longest", front.points[11].values[0], 1.5 * fastest, 1e-9);
        for pair in front.points.windows(2) {
            assert!(pair[0].values[0] < pair[1].values[0], "{pair:?}");
            assert!(pair[0].values[1] > pair[1].values[1], "{pair:?}");
        }
        for (index, point) in front.points.iter().enumerate() {
            let stretched = most * (fastest / point.values[0]).powf(power);
            // All but the first are better, not only as good.
            let share = if index == 0 { 1.0 + 1e-12 } else { 0.999 };
            assert!(point.values[1] <= share * stretched, "{index}: {point:?} {stretched}");
            assert!(point.worst_ratio <= 1.0);
            let mut again = request.clone();
            let task = again["task"].as_object_mut().unwrap();
            task.remove("pareto");
            task.insert("fixed_durations".into(), json!(point.durations));
            let again = plan(again);
            assert_eq!(again.durations, point.durations);
            assert!(again.certificate.lawful && again.evaluations == 1);
            assert_eq!(again.certificate.worst_ratio, point.worst_ratio);
            near("time", again.metrics.objective.time, point.values[0], 1e-15);
            let measures = again.metrics.objective;
            let value = if power == 3.0 { measures.rms_jerk } else { measures.energy };
            assert_eq!(value, point.values[1]);
        }
        let alone = plan_without_front(request.clone());
        assert_eq!(alone.certificate.sha256, result.certificate.sha256, "the plan is the same");
        assert_eq!(timeless(&result), timeless(&plan(request)));
    }
}

fn plan_without_front(mut request: Value) -> TrajectoryResult {
    request["task"].as_object_mut().unwrap().remove("pareto");
    plan(request)
}

#[test]
fn nsga2_comes_near_the_precise_front_and_takes_three_objectives() {
    let task = |pareto: Value| scenario("mcb-ab", json!({ "pareto": pareto }));
    let precise = plan(task(json!({ "objectives": ["time", "rms_jerk"], "points": 100 })));
    let near_time = |time: f64| {
        let points = &front(&precise).points;
        let next = points.iter().position(|point| point.values[0] >= time).unwrap_or(99).max(1);
        let [a, b] = [&points[next - 1].values, &points[next].values];
        a[1] + (b[1] - a[1]) * (time - a[0]) / (b[0] - a[0])
    };
    let two = json!({ "objectives": ["time", "rms_jerk"], "method": "nsga2", "points": 15 });
    let found = plan(task(two.clone()));
    assert!(front(&found).points.len() > 12);
    for point in &front(&found).points {
        let excess = point.values[1] / near_time(point.values[0]) - 1.0;
        assert!((-2e-3..0.03).contains(&excess), "{point:?}: {excess}");
        assert!(point.worst_ratio <= 1.0);
    }
    assert_eq!(timeless(&found), timeless(&plan(task(two.clone()))));
    let mut other = task(two);
    other["seed"] = json!(8);
    assert_ne!(times_of(front(&plan(other))), times_of(front(&found)), "the seed counts");

    let three = json!({ "objectives": ["time", "rms_jerk", "energy"], "method": "nsga2" });
    let found = plan(task(three));
    let points = &front(&found).points;
    let units: Vec<&str> = front(&found).objectives.iter().map(|axis| &*axis.unit).collect();
    assert_eq!(units, ["s", "rad/s³", "rad²/s⁴"]);
    assert!(points.len() >= 15 && points.iter().all(|point| point.values.len() == 3));
    for a in points {
        let beaten =
            points.iter().any(|b| a != b && b.values.iter().zip(&a.values).all(|(b, a)| b <= a));
        assert!(!beaten, "{a:?}");
    }
}

#[test]
fn a_front_keeps_to_the_longest_duration_wanted() {
    let pareto = json!({ "objectives": ["time", "rms_jerk"], "points": 6, "max_stretch": 5 });
    for method in ["epsilon_constraint", "nsga2"] {
        let mut task = json!({ "pareto": pareto, "duration": { "at_most": 6.5 } });
        task["pareto"]["method"] = json!(method);
        let result = plan(scenario("mcb-ab", task));
        let times = times_of(front(&result));
        assert!(
            times.len() >= 5 && times.iter().all(|time| *time <= 6.5 * (1.0 + 1e-9)),
            "{times:?}"
        );
        assert!(times[times.len() - 1] > 6.4);
    }
}

/// Weights choose the plan, the front stands beside it; both are the same on
/// any number of threads.
#[test]
fn weights_and_fronts_repeat_on_any_number_of_threads() {
    let pareto = json!({ "objectives": ["time", "energy"], "method": "nsga2", "generations": 20 });
    let mut request = scenario("mcb-assembly", json!({}));
    for leg in request["task"]["legs"].as_array_mut().unwrap() {
        leg["task"]["objective"] = json!({ "time": 1, "energy": 0.3 });
        leg["task"]["pareto"] = pareto.clone();
    }
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let plan =
            validate(&PlanRequest::parse(request.clone()).unwrap(), &catalogue::get).unwrap();
        match pool.install(|| plan.run(&Budget::default(), &|_| {})).unwrap() {
            PlanResult::Program(program) => {
                program.legs.iter().map(|leg| timeless(&leg.result)).collect::<Vec<_>>()
            }
            _ => panic!("a program"),
        }
    };
    let one = run(1);
    assert!(one.iter().all(|leg| leg.contains("\"pareto\"")));
    assert_eq!(one, run(2));
    assert_eq!(one, run(8));
}

#[test]
fn budgets_end_fronts_and_progress_tells_of_them() {
    for method in ["epsilon_constraint", "nsga2"] {
        let pareto = json!({ "objectives": ["time", "rms_jerk"], "method": method });
        let limited =
            json!({ "pareto": pareto, "optimizer": { "name": "exact", "max_evaluations": 6000 } });
        let result = plan(scenario("mcb-ab", limited));
        assert_eq!(result.stop_reason, StopReason::EvaluationLimit, "{method}");
        assert!(result.evaluations <= 6000 + 64 && !front(&result).points.is_empty());

        let request = PlanRequest::parse(scenario("mcb-ab", json!({ "pareto": pareto }))).unwrap();
        let prepared = validate(&request, &catalogue::get).unwrap();
        let cancel = CancelToken::default();
        let seen = Mutex::new(Vec::new());
        let error = prepared
            .run(&Budget::new(cancel.clone()), &|progress| {
                seen.lock().unwrap().push((progress.iteration, progress.evaluations));
                // `exact` takes eight steps and the last; what follows is the front's.
                if progress.iteration == 11 {
                    cancel.cancel();
                }
            })
            .unwrap_err();
        assert_eq!(error.code.as_str(), "cancelled");
        let seen = seen.into_inner().unwrap();
        assert!(seen.windows(2).all(|pair| pair[0].1 < pair[1].1), "{method}: {seen:?}");
        assert!(seen.last().unwrap().0 <= 12, "{method}: {seen:?}");
        let Some(PlanResult::Trajectory(partial)) = error.partial.as_deref() else {
            panic!("the plan itself was there");
        };
        assert!(partial.pareto.is_some());
    }
}

/// Durations that are given are not searched, bettered or stretched.
#[test]
fn fixed_durations_are_planned_as_they_are() {
    // Han's published times.
    let result = plan(scenario(
        "mcb-ab",
        json!({ "interpolation": "quintic_han",
        "fixed_durations": [3.0, 4.0, 3.0] }),
    ));
    assert_eq!(result.durations, [3.0, 4.0, 3.0]);
    assert_eq!((result.duration, result.evaluations), (10.0, 1));
    let hasty =
        try_plan(scenario("mcb-ab", json!({ "fixed_durations": [1.0, 1.0, 1.0] }))).unwrap_err();
    assert_eq!(hasty.code.as_str(), "limits_unreachable");
    let Some(PlanResult::Trajectory(partial)) = hasty.partial.as_deref() else { panic!("a plan") };
    assert!(!partial.certificate.lawful && partial.duration == 3.0);
}

#[test]
fn senseless_objectives_are_refused_by_name() {
    let cases: &[(Value, &str, &str)] = &[
        (json!({ "objective": {} }), "/task/objective", "all weights are 0"),
        (json!({ "objective": { "time": 0, "energy": 0 } }), "/task/objective", "all weights"),
        (json!({ "objective": { "time": -1 } }), "/task/objective/time", "-1"),
        (json!({ "objective": { "time": 1, "energy": 1e10 } }), "/task/objective/energy", "1e9"),
        (json!({ "objective": { "time": "much" } }), "/task/objective/time", "string"),
        (json!({ "objective": { "comfort": 1 } }), "/task/objective/comfort", "unknown field"),
        (json!({ "objective": { "rms_jerk": 1 } }), "/task/objective/time", "slowest"),
        (
            json!({ "objective": { "time": 1, "rms_jerk": 1 }, "clock": "per_joint" }),
            "/task/clock",
            "shared",
        ),
        (
            json!({ "objective": { "time": 1, "rms_jerk": 1 }, "optimizer": { "name": "pso" },
                "constraint_handling": "penalty" }),
            "/task/constraint_handling",
            "repair_uniform",
        ),
        (
            json!({ "objective": { "time": 1, "energy": 1 }, "interpolation": "trapezoidal" }),
            "/task/objective",
            "quintic is searched",
        ),
        (json!({ "pareto": { "objectives": ["time"] } }), "/task/pareto/objectives", "2 or 3"),
        (
            json!({ "pareto": { "objectives": ["energy", "rms_jerk"] } }),
            "/task/pareto/objectives",
            "time is missing",
        ),
        (
            json!({ "pareto": { "objectives": ["time", "time"] } }),
            "/task/pareto/objectives/1",
            "more than once",
        ),
        (
            json!({ "pareto": { "objectives": ["time", "torque"] } }),
            "/task/pareto/objectives/1",
            "`torque`",
        ),
        (
            json!({ "pareto": { "objectives": ["time", "rms_jerk", "energy"] } }),
            "/task/pareto/method",
            "nsga2 takes three",
        ),
        (pareto("points", json!(1)), "/task/pareto/points", "2 to 200"),
        (pareto("points", json!(1e9)), "/task/pareto/points", "floating point"),
        (pareto("method", json!("magic")), "/task/pareto/method", "`magic`"),
        (pareto("max_stretch", json!(1)), "/task/pareto/max_stretch", "above 1"),
        (pareto("max_stretch", json!(1e300)), "/task/pareto/max_stretch", "at most 10"),
        (pareto("population", json!(50)), "/task/pareto/population", "nsga2"),
        (pareto("colour", json!(1)), "/task/pareto/colour", "unknown field"),
        (
            json!({ "pareto": { "objectives": ["time", "energy"], "method": "nsga2",
                "population": 4, "generations": 0 } }),
            "/task/pareto/generations",
            "1 to 10000",
        ),
        (with_front("clock", json!("per_joint")), "/task/clock", "shared"),
        (with_front("optimizer", json!({ "name": "pso" })), "/task/optimizer", "pareto.method"),
        (with_front("duration", json!({ "exactly": 9 })), "/task/duration", "at_most"),
        (with_front("interpolation", json!("trapezoidal")), "/task/pareto", "quintic is searched"),
        (json!({ "fixed_durations": [1, 2] }), "/task/fixed_durations", "2 durations for 3"),
        (json!({ "fixed_durations": [] }), "/task/fixed_durations", "0 durations for 3"),
        (json!({ "fixed_durations": [1, 0, 1] }), "/task/fixed_durations/1", "0 s"),
        (
            json!({ "fixed_durations": [1, 1, 1], "durations": { "min": 1, "max": 2 } }),
            "/task/durations",
            "nothing is searched",
        ),
    ];
    for (task, pointer, words) in cases {
        let found = faults(scenario("wood", task.clone()));
        let right =
            found.0.iter().any(|fault| fault.pointer == *pointer && fault.detail.contains(words));
        assert!(right, "{task}: {pointer} {words} not in {found}");
    }
}

fn pareto(name: &str, value: Value) -> Value {
    let mut pareto = json!({ "objectives": ["time", "energy"] });
    pareto[name] = value;
    json!({ "pareto": pareto })
}

fn with_front(name: &str, value: Value) -> Value {
    let mut task = pareto("points", json!(5));
    task[name] = value;
    task
}
