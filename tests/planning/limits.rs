//! What a request may ask for, and what it is told if it may not.

use serde_json::json;

use crate::support::{faults, merge, plan, scenario, timeless, try_plan};

/// A wish for a duration is met exactly or refused with the figure.
#[test]
fn duration_goals() {
    let exactly = plan(scenario("mcb-ab", json!({ "duration": { "exactly": 8.0 } })));
    assert_eq!(exactly.duration, 8.0);
    assert!(exactly.certificate.lawful && exactly.certificate.worst_ratio < 0.8);
    assert!((exactly.durations.iter().sum::<f64>() - 8.0).abs() < 1e-12);
    let at_most = plan(scenario("mcb-ab", json!({ "duration": { "at_most": 8.0 } })));
    assert!(at_most.duration < 5.76);
    for goal in ["exactly", "at_most"] {
        let error = try_plan(scenario("mcb-ab", json!({ "duration": { goal: 5.0 } }))).unwrap_err();
        assert_eq!(error.code.as_str(), "limits_unreachable");
        assert!(error.message.contains("5.756"), "{error}");
    }
}

/// Every handling of broken limits ends with a lawful plan, and none below the
/// optimum.
#[test]
fn every_constraint_handling_ends_lawful() {
    for optimizer in ["pso", "pso_linear", "improved_pso"] {
        for handling in ["repair_uniform", "repair_segment", "penalty", "reject"] {
            let task =
                json!({ "optimizer": { "name": optimizer }, "constraint_handling": handling });
            let result = plan(scenario("mcb-ab", task));
            let what = format!("{optimizer} {handling}: {}", result.duration);
            assert!(result.certificate.lawful, "{what}");
            assert!(result.duration > 5.7567 && result.duration < 7.5, "{what}");
            assert_eq!(result.evaluations, 50 * 101, "{what}");
        }
    }
}

/// Same request and seed, same bytes, on any number of threads; another seed,
/// another search.
#[test]
fn results_repeat_on_any_number_of_threads() {
    // Big enough for the population to be evaluated in parallel.
    let request = |seed: u64| {
        let task = json!({ "optimizer": { "name": "pso", "population": 600, "iterations": 20 } });
        let mut request = scenario("mcb-ab", task);
        request["seed"] = json!(seed);
        request
    };
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| timeless(&plan(request(3))))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(5));
    assert_ne!(one, timeless(&plan(request(4))));
}

/// A search range is kept, or the plan says that it cannot be.
#[test]
fn a_search_range_is_kept() {
    let task = json!({ "durations": { "min": 2.0, "max": 3.0 } });
    let result = plan(scenario("mcb-ab", task));
    assert!(
        result.durations.iter().all(|t| (2.0..=3.0 + 1e-9).contains(t)),
        "{:?}",
        result.durations
    );
    assert!(result.duration > 5.7568);
    let narrow = json!({ "durations": { "min": 0.1, "max": 0.5 } });
    let error = try_plan(scenario("mcb-ab", narrow)).unwrap_err();
    assert_eq!(error.code.as_str(), "limits_unreachable");
}

/// The scaling law: limits s, s², s³ times as high make the plan s times as fast.
#[test]
fn scaled_limits_scale_the_plan() {
    let mut request = scenario("mcb-ab", json!({}));
    let full = plan(request.clone());
    merge(
        &mut request,
        json!({ "limit_scale": { "velocity": 0.5, "acceleration": 0.25, "jerk": 0.125 } }),
    );
    let slow = plan(request);
    assert!((slow.duration / full.duration - 2.0).abs() < 1e-5);
    let provenance = slow.certificate.joints[0].jerk.provenance.as_deref();
    assert_eq!(provenance, Some("request × 0.125"));
}

/// An unknown limit stays unknown: not enforced, and the certificate says so.
#[test]
fn unknown_limits_are_reported_as_such() {
    let mut request = scenario("mcb-ab", json!({}));
    request["limits"]["jerk"] = json!([2.0, null, 2.0, 2.0, 2.0, 2.0]);
    let result = plan(request);
    let jerk = &result.certificate.joints[1].jerk;
    assert!(jerk.limit.is_none() && jerk.ratio.is_none() && jerk.provenance.is_none());
    assert!(jerk.peak.is_some());
}

/// A curve that swings beyond a position limit between waypoints is refused
/// with joint, time and limit, and the plan as far as it goes.
#[test]
fn position_limits_hold_between_waypoints() {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic", "limits":
        { "lower": 0.0, "upper": 1.0, "velocity": 1.0, "acceleration": 4.0, "jerk": 40.0 } }] });
    // The curve turns round near the limit: touching it at rest would do.
    let task = json!({ "type": "waypoints", "waypoints": [[0.0], [0.99], [0.98], [0.2]] });
    match try_plan(json!({ "robot": robot, "task": task })) {
        Ok(result) => {
            let range = &result.certificate.joints[0].position;
            assert!(result.certificate.lawful && range.max <= 1.0 + 1e-9, "{range:?}");
        }
        Err(error) => {
            assert!(error.message.contains("x reaches") && error.message.contains("limit of 1 m"));
            assert!(error.partial.is_some());
        }
    }
}

/// Joints that rest in a segment or throughout do not disturb the others.
#[test]
fn resting_joints_take_the_others_time() {
    let joint = |name: &str| {
        json!({ "name": name, "type": "revolute",
        "limits": { "velocity": 1.0, "acceleration": 2.0, "jerk": 10.0 } })
    };
    let robot = json!({ "joints": [joint("a"), joint("b"), joint("still")] });
    let waypoints = json!([[0, 0, 0.3], [1, 0, 0.3], [1, 1, 0.3], [0, 1, 0.3]]);
    for clock in ["shared", "per_joint"] {
        let task = json!({ "type": "waypoints", "waypoints": waypoints, "clock": clock });
        let result = plan(json!({ "robot": robot, "task": task }));
        assert!(result.certificate.lawful, "{clock}");
        assert_eq!(result.metrics.path_length[2], 0.0);
        if let Some(optima) = &result.per_joint {
            let names: Vec<&str> = optima.iter().map(|optimum| optimum.joint.as_str()).collect();
            assert_eq!(names, ["a", "b"]);
        }
    }
}

/// All faults of a request together, each at its place.
#[test]
fn reports_all_faults_together() {
    let request = json!({ "robot": "rokae_xb4", "task": { "type": "waypoints",
        "waypoints": [[0, 0, 0, 0, 0, 9], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]],
        "interpolation": "quintics", "optimizer": { "name": "pso", "populations": 3, "iterations": 1.5 },
        "durations": { "min": 2, "max": 1 } },
        "limits": { "velocity": 0, "jerk": [1, 2] }, "limit_scale": { "velocity": 1.5 } });
    let found = faults(request);
    let expected = [
        "/task/waypoints/0/5",
        "/task/waypoints/1",
        "/task/waypoints/3",
        "/task/interpolation",
        "/task/optimizer/populations",
        "/task/optimizer/iterations",
        "/limits/velocity",
        "/limits/jerk",
        "/limit_scale/velocity",
    ];
    for pointer in expected {
        assert!(found.0.iter().any(|fault| fault.pointer == pointer), "{pointer} not in {found}");
    }
    assert!(found.to_string().contains("joint_6: 9 rad is above its upper limit of 6.19"));
}

/// The cubic's acceleration steps at start and stop: a jerk limit forbids it.
#[test]
fn a_jerk_limit_excludes_curves_without_bounded_jerk() {
    for interpolation in ["cubic", "bspline", "bspline_uniform", "trapezoidal"] {
        let found = faults(scenario("mcb-ab", json!({ "interpolation": interpolation })));
        assert!(found.to_string().contains("remove the jerk limits"), "{found}");
    }
}

/// Stopping at each waypoint, every segment takes exactly what the closed form
/// says, and the limits are touched but not exceeded.
#[test]
fn trapezoidal_stops_at_every_waypoint() {
    let result =
        plan(crate::support::without_jerk("mcb-ab", json!({ "interpolation": "trapezoidal" })));
    assert!(result.certificate.lawful && result.certificate.worst_ratio > 1.0 - 1e-12);
    assert_eq!(result.certificate.continuity, 1);
    let mut state = takt::trajectory::KinematicState::new(6);
    for t in &result.waypoint_times {
        result.trajectory.sample(*t, &mut state);
        assert!(state.velocity.iter().all(|v| v.abs() < 1e-9));
    }
    // Segment 2: joint 6 travels 1.943 rad at 1 rad/s, 1 rad/s².
    let way = (135.3f64 - 23.96).to_radians();
    assert!((result.durations[1] - (way + 1.0)).abs() < 1e-9);
}
