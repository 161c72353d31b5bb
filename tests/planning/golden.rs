//! Durations published or computed independently. If these fail, plans are
//! wrong or not optimal, whatever the certificate says.

use serde_json::{Value, json};

use crate::support::{plan, scenario, timeless, without_jerk};

fn assert_near(what: &str, found: f64, expected: f64, relative: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off <= relative, "{what}: {found} is {off:.2e} from {expected}");
}

/// Optima of the families, by differential evolution and Nelder-Mead on the
/// scaling law in another program.
#[test]
fn exact_finds_the_optimum_of_each_family() {
    let with = |interpolation: &str| json!({ "interpolation": interpolation });
    let zero = "cubic_zero_acceleration";
    let cases: [(&str, Value, f64); 14] = [
        ("wood, 3-5-3", scenario("wood", with("3-5-3")), 7.4755),
        ("wood, quintic", scenario("wood", with("quintic")), 4.0869),
        ("wood, cubic", scenario("wood", with("cubic")), 4.2212),
        ("mcb-ab, quintic_han", scenario("mcb-ab", with("quintic_han")), 7.0255),
        ("mcb-ab, quintic", scenario("mcb-ab", with("quintic")), 5.75677),
        ("mcb-ab, quintic without jerk", without_jerk("mcb-ab", with("quintic")), 5.68082),
        ("mcb-ab, cubic without jerk", without_jerk("mcb-ab", with("cubic")), 5.09875),
        ("mcb-ab, han without jerk", without_jerk("mcb-ab", with("quintic_han")), 7.0255),
        ("mcb-ab, 4-3-4", scenario("mcb-ab", with("4-3-4")), 5.969385),
        ("mcb-ab, 4-3-4 without jerk", without_jerk("mcb-ab", with("4-3-4")), 5.231041),
        ("wood, 4-3-4", scenario("wood", with("4-3-4")), 4.480567),
        ("mcb-ab, zero", scenario("mcb-ab", with(zero)), 5.660883),
        ("mcb-ab, zero without jerk", without_jerk("mcb-ab", with(zero)), 5.516457),
        ("wood, zero", scenario("wood", with(zero)), 4.785325),
    ];
    for (what, request, expected) in cases {
        let result = plan(request.clone());
        assert_near(what, result.duration, expected, 2e-4);
        assert!(result.certificate.lawful, "{what}: {:?}", result.certificate.violations);
        let worst = result.certificate.worst_ratio;
        assert!(worst <= 1.0 && worst > 0.999, "{what}: worst ratio {worst}");
        assert!(result.certificate.waypoint_error.unwrap() < 1e-12, "{what}");
        let bound = result.bound.as_ref().unwrap();
        assert!(bound.lower < result.duration, "{what}: bound {}", bound.lower);
        assert_eq!(timeless(&result), timeless(&plan(request)), "{what} does not repeat");
    }
}

/// Chen's joints one by one (their Table 5 claims less for joint 1, which
/// breaks its acceleration limit by 7 %).
#[test]
fn per_joint_optima_of_chen() {
    let result = plan(scenario("wood", json!({ "clock": "per_joint" })));
    let optima = result.per_joint.as_ref().unwrap();
    for (optimum, expected) in optima.iter().zip([7.2401, 7.1906, 6.8804, 6.8672]) {
        assert_near(&optimum.joint, optimum.duration, expected, 2e-4);
    }
    // Optimal splits between segments are not unique, so their composition is
    // only near the 8.2651 s of another set of optima. It is lawful here.
    assert_near("composed", result.duration, 8.2651, 1e-2);
    assert!(result.certificate.lawful);
}

/// Han's joints one by one under the speed limits behind their Table 5.
#[test]
fn per_joint_optima_of_han_under_speed_limits() {
    let mut request = scenario(
        "mcb-ab",
        json!({ "interpolation": "quintic_han", "clock": "per_joint", "constraints": "velocity_only" }),
    );
    request["limits"]["velocity"] = json!([0.5, 0.5, 0.5, 0.5, 0.5, 1.0]);
    let result = plan(request);
    let optima = result.per_joint.as_ref().unwrap();
    let names: Vec<&str> = optima.iter().map(|optimum| optimum.joint.as_str()).collect();
    assert_eq!(names, ["joint_1", "joint_2", "joint_3", "joint_5", "joint_6"]);
    for (optimum, expected) in optima.iter().zip([5.5753, 1.3985, 2.5473, 2.2517, 7.0255]) {
        assert_near(&optimum.joint, optimum.duration, expected, 2e-4);
    }
    // The largest times alone, as the papers take them, break a speed limit:
    // peaks depend on proportions. The plan is stretched until they do not.
    let largest = |segment: usize| {
        optima.iter().map(|optimum| optimum.durations[segment]).fold(0.0, f64::max)
    };
    let composed: f64 = (0..3).map(largest).sum();
    assert_near("composed", composed, 7.5947, 2e-3);
    assert!(result.duration > composed * 1.01);
    let fastest = result.certificate.joints.iter().filter_map(|joint| joint.velocity.ratio);
    assert!(fastest.fold(0.0, f64::max) <= 1.0);
}

/// All joints at Han's published times: the peaks that confirm how the paper's
/// matrix is read.
#[test]
fn peaks_at_published_times() {
    // A fixed proportion is reached by `durations` pinned around it; here the
    // curve is asked for directly through the library.
    use takt::trajectory::interpolation::{Timing, interpolation};
    use takt::trajectory::kernel::{JointLanes, KernelLimits};
    let request = scenario("mcb-ab", json!({}));
    let waypoints: Vec<Vec<f64>> =
        serde_json::from_value(request["task"]["waypoints"].clone()).unwrap();
    let unit = KernelLimits { derivatives: [1.0; 3], position: [f64::NEG_INFINITY, f64::INFINITY] };
    let joints = JointLanes::new(&waypoints, &[unit; 6]);
    let Timing::Search(kernel) = interpolation("quintic_han").unwrap().timing else {
        panic!("quintic_han is searched");
    };
    let mut work = kernel.workspace(&joints);
    let mut peaks = |durations: [f64; 3], joint: Option<usize>| {
        kernel.ratios(&joints, &durations, &mut work);
        let of = |order: usize| {
            let all = (0..3).flat_map(|s| (0..6).map(move |j| (s, j)));
            all.filter(|(_, j)| joint.is_none_or(|joint| joint == *j))
                .map(|(s, j)| work.ratio(&joints, s, j, order))
                .fold(0.0, f64::max)
        };
        [of(0), of(1), of(2)]
    };
    let cases = [
        ([2.79, 3.31, 1.79], None, [0.969, 0.805, 1.544]),
        ([3.0, 6.0, 3.0], Some(5), [0.5915, 0.2496, 0.2416]),
        ([3.0, 6.0, 3.0], Some(0), [0.4229, 0.2221, 0.2831]),
    ];
    for (durations, joint, expected) in cases {
        let found = peaks(durations, joint);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-3, "{durations:?} {joint:?}: {found}");
        }
    }
}

/// The independent references of the random problems, one per family.
#[test]
fn exact_matches_independent_optima_of_random_problems() {
    let problems: Value =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    for problem in problems.as_array().unwrap() {
        for (key, interpolation, jerk) in [
            ("cubic_no_jerk", "cubic", false),
            ("quintic_c4", "quintic", true),
            ("3-5-3_no_jerk", "3-5-3", false),
        ] {
            let Some(expected) = problem["reference"][key].as_f64() else { continue };
            let dof = problem["velocity"].as_array().unwrap().len();
            let joint = |j: usize| {
                json!({ "name": format!("j{j}"), "type": "revolute", "limits": {
                    "velocity": problem["velocity"][j],
                    "acceleration": problem["acceleration"][j],
                    "jerk": if jerk { problem["jerk"][j].clone() } else { Value::Null },
                } })
            };
            let robot = json!({ "joints": (0..dof).map(joint).collect::<Vec<_>>() });
            let task = json!({ "type": "waypoints", "interpolation": interpolation,
                "waypoints": problem["waypoints"] });
            let result = plan(json!({ "robot": robot, "task": task }));
            let what = format!("{} {key}", problem["name"]);
            // A lower lawful value than the reference would be welcome.
            assert!(result.duration <= expected * (1.0 + 2e-5), "{what}: {}", result.duration);
            assert!(result.duration >= expected * (1.0 - 1e-3), "{what}: {}", result.duration);
            assert!(result.certificate.lawful, "{what}");
        }
    }
}

/// The paper's swarm with the paper's parameters, joint by joint: what a user
/// of the published method may expect.
#[test]
fn improved_pso_of_han_reaches_each_joints_optimum() {
    for handling in ["repair_uniform", "repair_segment"] {
        let task = |optimizer: Value| {
            json!({ "interpolation": "quintic_han", "clock": "per_joint",
                "constraint_handling": handling, "optimizer": optimizer })
        };
        let optimum = plan(scenario("mcb-ab", task(json!({ "name": "exact" }))));
        let optima = optimum.per_joint.unwrap();
        let mut excess: Vec<Vec<f64>> = vec![Vec::new(); optima.len()];
        for seed in 0..20 {
            let mut request = scenario(
                "mcb-ab",
                task(json!({ "name": "improved_pso", "population": 50, "iterations": 100 })),
            );
            request["seed"] = json!(seed);
            request["task"]["durations"] = json!({ "min": 0.02, "max": 5.0 });
            let found = plan(request).per_joint.unwrap();
            for (joint, (found, best)) in found.iter().zip(&optima).enumerate() {
                assert_eq!(found.evaluations, 50 * 101);
                assert!(found.duration >= best.duration * (1.0 - 1e-5), "below the optimum");
                excess[joint].push(found.duration / best.duration - 1.0);
            }
        }
        for (joint, excess) in excess.iter_mut().enumerate() {
            excess.sort_by(f64::total_cmp);
            let (median, worst) = (0.5 * (excess[9] + excess[10]), excess[19]);
            let name = &optima[joint].joint;
            println!("{handling} {name}: median {median:.2e}, worst {worst:.2e}, 5050 evaluations");
            assert!(median <= 2e-3, "{handling} {name}: median {median}");
            // The fitness switch as published contracts too early now and then.
            let allowed = if handling == "repair_uniform" { 2e-2 } else { 5e-2 };
            assert!(worst <= allowed, "{handling} {name}: worst {worst}");
        }
    }
}
