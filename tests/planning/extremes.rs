//! Valid requests with extreme values: every outcome is a plan with an honest
//! certificate, or says clearly why there is none.

use serde_json::{Value, json};
use takt::budget::{Budget, StopReason};
use takt::math::random::RandomStream;
use takt::plan::{PlanRequest, PlanResult, TrajectoryResult, validate};
use takt::robot::catalogue;
use takt::trajectory::KinematicState;
use takt::trajectory::interpolation::{INTERPOLATIONS, interpolation};

use crate::support::{faults, plan, scenario, try_plan};

const REQUESTS: usize = 1_500;

fn pick<T: Clone>(random: &mut RandomStream, choices: &[T]) -> T {
    choices[(random.unit() * choices.len() as f64) as usize].clone()
}

fn random_request(random: &mut RandomStream) -> Value {
    let dof = pick(random, &[1, 2, 7, 9, 32]);
    let count = pick(random, &[2, 2, 3, 4, 4, 4, 8, 40]);
    let size = pick(random, &[1.0, 1.0, 1.0, 1e-9, 1e-12, 5e-324, 1e6, 1e9, 1e300]);
    let offset = pick(random, &[0.0, 0.0, 1.0, 1e6]);
    let coordinate = |random: &mut RandomStream| match pick(random, &[0, 0, 0, 1, 2]) {
        0 => offset + size * random.uniform(-1.0, 1.0),
        1 => offset,
        _ => offset + size * 10f64.powf(random.uniform(-9.0, 0.0)),
    };
    let waypoints: Vec<Vec<f64>> =
        (0..count).map(|_| (0..dof).map(|_| coordinate(random)).collect()).collect();
    let limit = |random: &mut RandomStream| match pick(random, &[0, 0, 0, 1, 2]) {
        0 => json!(10f64.powf(random.uniform(-1.0, 1.0))),
        1 => json!(pick(random, &[1e-9, 1e12])),
        _ => Value::Null,
    };
    let mixed = pick(random, &[true, false]);
    let joint = |number: usize, random: &mut RandomStream| {
        let mut limits = json!({ "velocity": 1.0, "acceleration": 2.0 });
        if mixed {
            for kind in ["velocity", "acceleration", "jerk"] {
                limits[kind] = limit(random);
            }
        }
        json!({ "name": format!("j{number}"), "type": "revolute", "limits": limits })
    };
    let joints: Vec<Value> = (0..dof).map(|number| joint(number, random)).collect();
    let entry = pick(random, &INTERPOLATIONS.iter().collect::<Vec<_>>());
    let interpolation = entry.name;
    let searched = entry.timing.own().is_none();
    let mut task =
        json!({ "type": "waypoints", "waypoints": waypoints, "interpolation": interpolation });
    if searched {
        let name = pick(random, &["exact", "pso", "pso_linear", "improved_pso"]);
        task["optimizer"] =
            json!({ "name": name, "max_evaluations": pick(random, &[1, 7, 150, 400]) });
        task["clock"] = pick(random, &["shared", "per_joint"]).into();
        task["constraint_handling"] =
            pick(random, &["repair_uniform", "repair_segment", "penalty", "reject"]).into();
        task["objective"] = pick(
            random,
            &[
                Value::Null,
                Value::Null,
                json!({ "time": 1, "rms_jerk": 0.1 }),
                json!({ "time": 1e-9, "energy": 1e9 }),
                json!({ "energy": 1 }),
            ],
        );
        let objectives = json!(["time", "rms_jerk"]);
        task["pareto"] = pick(
            random,
            &[
                Value::Null,
                Value::Null,
                Value::Null,
                json!({ "objectives": objectives, "points": 3 }),
                json!({ "objectives": objectives, "method": "nsga2", "population": 8, "generations": 2 }),
            ],
        );
        task["constraints"] = pick(random, &["full", "full", "velocity_only"]).into();
        task["durations"] = pick(
            random,
            &[
                Value::Null,
                Value::Null,
                json!({ "min": 1e-6, "max": 1e6 }),
                json!({ "min": 0.1, "max": 10.0 }),
                json!({ "min": 1e-6, "max": 2e-6 }),
                json!({ "min": 1e5, "max": 1e6 }),
            ],
        );
    }
    task["duration"] = pick(
        random,
        &[
            Value::Null,
            Value::Null,
            json!({ "exactly": 1e6 }),
            json!({ "exactly": 8.0 }),
            json!({ "at_most": 1e-6 }),
        ],
    );
    json!({ "robot": { "joints": joints }, "task": task, "seed": (random.unit() * 100.0) as u64 })
}

/// Peaks by sampling alone, which no certificate may be below.
fn check_honest(what: &str, result: &TrajectoryResult) {
    let trajectory = &result.trajectory;
    trajectory.validate(result.joint_names.len()).unwrap_or_else(|e| panic!("{what}: {e}"));
    assert!(result.duration.is_finite() && result.duration > 0.0, "{what}: {}", result.duration);
    assert_eq!(result.duration, trajectory.duration(), "{what}");
    assert_eq!(*result.waypoint_times.last().unwrap(), result.duration, "{what}");
    let size = result.waypoints.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    let error = result.certificate.waypoint_error.unwrap();
    assert!(error <= 1e-6 * size, "{what}: waypoint error {error}");
    let mut state = KinematicState::new(result.joint_names.len());
    for (piece, pair) in trajectory.breakpoints.windows(2).enumerate() {
        for k in 0..20 {
            let t = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 20.0;
            trajectory.sample(t, &mut state);
            for (joint, certified) in result.certificate.joints.iter().enumerate() {
                for (peak, value) in [
                    (&certified.velocity, state.velocity[joint]),
                    (&certified.acceleration, state.acceleration[joint]),
                    (&certified.jerk, state.jerk[joint]),
                ] {
                    assert!(value.is_finite(), "{what}: not finite in piece {piece}");
                    let Some(certified) = peak.peak else { continue };
                    assert!(value.abs() <= certified * (1.0 + 1e-6), "{what}: {value} {certified}");
                }
            }
        }
    }
    let back: TrajectoryResult =
        serde_json::from_str(&serde_json::to_string(result).unwrap()).unwrap();
    assert_eq!(&back, result, "{what}");
}

#[test]
fn extreme_requests_end_clearly() {
    let mut random = RandomStream::new(31, 0);
    let (mut refused, mut failed, mut planned) = (0, 0, 0);
    for number in 0..REQUESTS {
        let request = random_request(&mut random);
        let text = request.to_string();
        let what = format!("{number}: {}", &text[text.len().saturating_sub(600)..]);
        let parsed = PlanRequest::parse(request.clone()).unwrap();
        let prepared = match validate(&parsed, &catalogue::get) {
            Ok(prepared) => prepared,
            Err(faults) => {
                assert!(!faults.is_empty(), "{what}: refused without a fault");
                refused += 1;
                continue;
            }
        };
        match prepared.run(&Budget::default(), &|_| {}) {
            Ok(PlanResult::Trajectory(result)) => {
                planned += 1;
                check_honest(&what, &result);
                if request["task"]["constraints"] != json!("velocity_only") {
                    let jumps = result.certificate.violations.iter().all(|v| v.value.is_none());
                    let executable = interpolation(&result.interpolation).unwrap().executable;
                    assert!(result.certificate.lawful || !executable && jumps, "{what}");
                }
                if let (Some(min), Some(max)) = (
                    request["task"]["durations"]["min"].as_f64(),
                    request["task"]["durations"]["max"].as_f64(),
                ) {
                    let range = min * (1.0 - 1e-8)..=max * (1.0 + 1e-8);
                    assert!(result.durations.iter().all(|t| range.contains(t)), "{what}");
                }
                let limit = request["task"]["optimizer"]["max_evaluations"].as_u64();
                if request["task"]["clock"] == json!("shared") {
                    assert!(result.evaluations <= limit.unwrap(), "{what}");
                }
            }
            Ok(_) => panic!("{what}: one trajectory was asked for"),
            Err(error) => {
                failed += 1;
                assert_eq!(error.code.as_str(), "limits_unreachable", "{what}");
                assert!(!error.message.contains("NaN"), "{what}: {error}");
            }
        }
    }
    println!("{refused} refused, {failed} failed, {planned} planned");
    assert!(refused > REQUESTS / 20 && failed > REQUESTS / 20 && planned > REQUESTS / 20);
}

/// The limit on evaluations is kept to the number, and the result under it is
/// the same on any number of threads.
#[test]
fn evaluations_end_at_their_limit() {
    for optimizer in ["exact", "pso", "improved_pso"] {
        for limit in [1, 2, 49, 50, 51, 333] {
            let optimizer = json!({ "name": optimizer, "max_evaluations": limit });
            let result = plan(scenario("mcb-ab", json!({ "optimizer": optimizer })));
            assert_eq!(result.evaluations, limit, "{optimizer}");
            assert_eq!(result.stop_reason, StopReason::EvaluationLimit, "{optimizer}");
        }
    }
    let optimizer = json!({ "name": "pso", "population": 1000, "max_evaluations": 1500 });
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| plan(scenario("mcb-ab", json!({ "optimizer": optimizer }))).durations)
    };
    assert_eq!(with_threads(1), with_threads(5));
}

/// A search without any time shows its first candidates.
#[test]
fn no_time_still_gives_a_plan() {
    for optimizer in ["exact", "pso"] {
        let optimizer = json!({ "name": optimizer, "time_limit_s": 0.0 });
        for clock in ["shared", "per_joint"] {
            let task = json!({ "optimizer": optimizer, "clock": clock });
            let result = plan(scenario("mcb-ab", task));
            assert!(result.certificate.lawful);
            assert_eq!(result.stop_reason, StopReason::TimeLimit);
        }
    }
}

/// Where no candidate of the first generation is feasible the swarm goes on
/// looking: standing still it would look at the same ones for ever.
#[test]
fn a_swarm_without_a_feasible_particle_goes_on_looking() {
    let request = |iterations: u64, seed: u64| {
        let optimizer = json!({ "name": "pso", "population": 2, "iterations": iterations });
        let task = json!({ "optimizer": optimizer, "constraint_handling": "reject",
            "durations": { "min": 1.0, "max": 4.0 } });
        let mut request = scenario("mcb-ab", task);
        request["seed"] = json!(seed);
        request
    };
    let unlucky: Vec<u64> = (0..20).filter(|seed| try_plan(request(0, *seed)).is_err()).collect();
    assert!(unlucky.len() >= 5, "the test needs infeasible first generations");
    for seed in unlucky {
        assert!(plan(request(400, seed)).certificate.lawful);
    }
}

/// The composed clock stretches what it composes; a range forbids that.
#[test]
fn a_composed_clock_keeps_the_range_or_fails() {
    let mut request = scenario(
        "mcb-ab",
        json!({ "interpolation": "quintic_han", "clock": "per_joint", "constraints": "velocity_only" }),
    );
    request["limits"]["velocity"] = json!([0.5, 0.5, 0.5, 0.5, 0.5, 1.0]);
    let free = plan(request.clone());
    let optima = free.per_joint.unwrap();
    let longest = optima.iter().flat_map(|optimum| &optimum.durations).copied().fold(0.0, f64::max);
    let composed = free.durations.iter().copied().fold(0.0, f64::max);
    assert!(composed > longest * 1.001, "the test needs a stretched segment");
    request["task"]["durations"] = json!({ "min": 0.02, "max": longest * 1.0001 });
    let error = try_plan(request).unwrap_err();
    assert!(error.message.contains("outside the search range"), "{error}");
    assert!(error.partial.is_some());
    // So does a wish that stretches the plan.
    let task = json!({ "durations": { "min": 0.1, "max": 3.0 }, "duration": { "exactly": 20.0 } });
    let error = try_plan(scenario("mcb-ab", task)).unwrap_err();
    assert!(error.message.contains("outside the search range"), "{error}");
}

/// Values without meaning are refused where they stand.
#[test]
fn values_beyond_use_are_refused() {
    let point = |x: f64| json!([x, 0, 0, 0, 0, 0]);
    let request = |waypoints: Value| {
        json!({ "robot": "rokae_xb4", "limits": { "lower": null, "upper": null, "velocity": 1.0 },
            "task": { "type": "waypoints", "waypoints": waypoints } })
    };
    let found = faults(request(json!([point(0.0), point(1e300)])));
    assert_eq!(found.0[0].pointer, "/task/waypoints/1/0");
    let found = faults(request(json!([point(0.0), point(5e-324)])));
    assert_eq!(found.0[0].pointer, "/task/waypoints/1");
    let mut tiny = request(json!([point(0.0), point(1.0)]));
    tiny["limit_scale"] = json!({ "velocity": 1e-300 });
    let found = faults(tiny);
    assert!(found.0.iter().all(|fault| fault.pointer == "/limit_scale/velocity"), "{found}");
    // A population is bounded by what its memory and one generation cost.
    let rows: Vec<_> = (0..500).map(|k| point(0.01 * f64::from(k))).collect();
    let mut large = request(json!(rows));
    large["task"]["optimizer"] = json!({ "name": "pso", "population": 100_000 });
    assert_eq!(faults(large).0[0].pointer, "/task/optimizer/population");
}
