//! The interpolation `jerk_limited` as users plan with it.

use std::sync::Mutex;
use std::time::Duration;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken, StopReason};
use takt::math::random::RandomStream;
use takt::plan::{PlanCode, PlanError, PlanRequest, PlanResult, Progress, validate};
use takt::robot::catalogue;

use crate::support::{faults, merge, plan, scenario, timeless, try_plan};

/// The figures: `mcb-ab` with all limits, `wood` with and without jerk limits.
#[test]
fn scenarios_take_no_longer_than_the_independent_optima() {
    let mut wood = scenario("wood-fastest", json!({}));
    wood["limits"]["jerk"] = Value::Null;
    for (request, most, continuity) in [
        (scenario("mcb-ab-fastest", json!({})), 4.885, 2),
        (scenario("wood-fastest", json!({})), 3.650, 2),
        (wood, 3.362, 1),
    ] {
        let result = plan(request);
        assert!(result.duration <= most, "{} s, not {most} s", result.duration);
        let certificate = &result.certificate;
        assert!(certificate.lawful && certificate.worst_ratio > 1.0 - 1e-9);
        assert_eq!(certificate.continuity, continuity);
        assert!(certificate.waypoint_error.unwrap() < 1e-9);
        // The certificate says that no jerk limit is known.
        let jerk = |joint: &takt::trajectory::JointCertificate| joint.jerk.limit.is_none();
        assert_eq!(certificate.joints.iter().all(jerk), continuity == 1);
        assert!(result.bound.unwrap().lower <= result.duration);
    }
}

#[test]
fn a_result_tells_how_it_was_found() {
    let result = plan(scenario("mcb-ab-fastest", json!({})));
    assert_eq!(result.stop_reason, StopReason::Converged);
    assert!(result.iterations > 20 && result.evaluations == result.iterations);
    let (first, last) = (&result.convergence[0], &result.convergence[1]);
    assert_eq!((first.iteration, first.best), (0, Some(result.metrics.initial_duration)));
    assert_eq!(last.iteration, result.iterations);
    assert!((last.best.unwrap() - result.duration).abs() < 1e-9);
    // Stopping at every waypoint takes much longer.
    assert!(result.metrics.saved > 0.1, "{}", result.metrics.saved);
    assert_eq!(result.durations.len(), 3);
    assert_eq!(result.waypoint_times[3], result.duration);
    // A lone segment is a closed form, and its result as complete.
    let alone =
        plan(scenario("wood-fastest", json!({ "waypoints": [[0, 0, 0, 0], [0.3, 0, 0.2, 1]] })));
    assert_eq!((alone.stop_reason, alone.iterations), (StopReason::Converged, 0));
    assert!(alone.convergence.len() == 2 && alone.metrics.saved.abs() < 1e-12);
}

/// What a search would need and a motion without one cannot take.
#[test]
fn what_only_a_search_can_use_is_refused() {
    let front = json!({ "objectives": ["time", "rms_jerk"] });
    for (member, value, words) in [
        ("optimizer", json!({ "name": "pso" }), "leave out the optimizer"),
        ("optimizer", json!({ "name": "exact", "iterations": 3 }), "leave out the optimizer"),
        ("clock", json!("per_joint"), "for all joints at once"),
        ("durations", json!({ "min": 0.1, "max": 5.0 }), "no search range"),
        ("objective", json!({ "time": 1, "rms_jerk": 1 }), "nothing to weigh"),
        ("pareto", front, "nothing to choose from"),
        ("fixed_durations", json!([1, 1, 1]), "none can be given"),
    ] {
        let found = faults(scenario("mcb-ab-fastest", json!({ member: value })));
        let [fault] = &found.0[..] else { panic!("{found}") };
        assert_eq!(fault.pointer, format!("/task/{member}"));
        let own = "jerk_limited finds its durations itself";
        assert!(fault.detail.contains(own) && fault.detail.contains(words), "{found}");
    }
}

#[test]
fn a_wanted_duration_is_kept_or_told_to_be_too_short() {
    let fastest = plan(scenario("mcb-ab-fastest", json!({})));
    for duration in [json!({ "exactly": 6.0 }), json!({ "at_most": 6.0 })] {
        let exactly = duration.get("exactly").is_some();
        let result = plan(scenario("mcb-ab-fastest", json!({ "duration": duration })));
        assert!(result.certificate.lawful);
        assert_eq!(result.duration, if exactly { 6.0 } else { fastest.duration });
    }
    let short = json!({ "duration": { "at_most": 4.5 } });
    let error = try_plan(scenario("mcb-ab-fastest", short)).unwrap_err();
    assert_eq!(error.code, PlanCode::LimitsUnreachable);
    assert!(error.message.contains("needs 4.8"), "{error}");
}

/// Below the bound no curve exists; between it and the optimum of a family another curve may do.
#[test]
fn a_wanted_duration_that_is_impossible_is_proven_to_be() {
    for name in ["mcb-ab", "mcb-ab-fastest"] {
        let short = json!({ "duration": { "at_most": 4.8 } });
        let error = try_plan(scenario(name, short)).unwrap_err();
        assert!(error.message.contains("no lawful trajectory takes less than 4.87"), "{error}");
        assert!(error.message.contains("because of the velocity limit of joint_6"), "{error}");
        let details = &error.details;
        let lower = details["lower_bound"].as_f64().unwrap();
        assert!((4.87..4.88).contains(&lower), "{lower}");
        assert_eq!(details["binding"][0]["joint"], "joint_6");
    }
    let error = try_plan(scenario("mcb-ab", json!({ "duration": { "at_most": 5.0 } })));
    assert!(error.unwrap_err().message.contains("jerk_limited takes 4.879"));
}

/// The multipliers against what plans with other limits really take, and the sum that the
/// scaling law asks for; also between two waypoints, where a closed form tells.
#[test]
fn sensitivities_are_what_higher_limits_save() {
    let whole = scenario("mcb-ab-fastest", json!({}));
    let mut leg = whole.clone();
    // The middle one, in which joint_6 alone is slow: where two are, more of one limit saves little.
    leg["task"]["waypoints"] = json!(&whole["task"]["waypoints"].as_array().unwrap()[1..3]);
    for request in [whole, leg] {
        let result = plan(request.clone());
        let sensitivities = &result.metrics.sensitivities;
        let share = |limit: &str| match limit {
            "velocity" => 1.0,
            "acceleration" => 2.0,
            _ => 3.0,
        };
        let sum: f64 =
            sensitivities.iter().map(|it| 100.0 * share(&it.limit) * it.seconds_per_percent).sum();
        assert!((sum / result.duration - 1.0).abs() < 2e-3, "{sum} of {}", result.duration);
        for it in sensitivities.iter().take(3) {
            let joint = result.joint_names.iter().position(|name| *name == it.joint).unwrap();
            let mut higher = request.clone();
            let limit = &mut higher["limits"][&it.limit][joint];
            *limit = json!(1.01 * limit.as_f64().unwrap());
            let saved = result.duration - plan(higher).duration;
            let off = (saved - it.seconds_per_percent).abs();
            assert!(off < 0.03 * it.seconds_per_percent + 2e-5, "{it:?} saves {saved}");
        }
    }
}

/// As for every other interpolation, the certificate still checks all limits.
#[test]
fn speed_alone_may_be_limited() {
    let result = plan(scenario("mcb-ab-fastest", json!({ "constraints": "velocity_only" })));
    let peak = |joint: &takt::trajectory::JointCertificate| joint.velocity.ratio.unwrap_or(0.0);
    let fastest = result.certificate.joints.iter().map(peak).fold(0.0, f64::max);
    assert!((fastest - 1.0).abs() < 1e-9 && !result.certificate.lawful);
    assert!(result.duration < 4.0, "{}", result.duration);
}

/// A tour of three joints through `count` waypoints.
fn tour(count: usize, limits: Value) -> Value {
    let mut random = RandomStream::new(3, count as u64);
    let rows: Vec<Vec<f64>> =
        (0..count).map(|_| (0..3).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let joint = |number: usize| {
        let mut joint = json!({ "name": format!("j{number}"), "type": "revolute",
            "limits": { "velocity": 2.0, "acceleration": 8.0, "jerk": 60.0 } });
        merge(&mut joint["limits"], limits.clone());
        joint
    };
    json!({ "robot": { "joints": (0..3).map(joint).collect::<Vec<_>>() },
        "task": { "type": "waypoints", "interpolation": "jerk_limited", "waypoints": rows } })
}

/// Plans within `budget`; `hear` is told the progress.
fn run(
    request: Value,
    budget: &Budget,
    hear: &(dyn Fn(&Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let plan = validate(&PlanRequest::parse(request).unwrap(), &catalogue::get).unwrap();
    plan.run(budget, &|progress| hear(&progress))
}

#[test]
fn long_lists_tell_their_progress() {
    let heard = Mutex::new(Vec::new());
    let hear = |progress: &Progress| {
        heard.lock().unwrap().push((
            progress.iteration,
            progress.best.unwrap(),
            progress.lower_bound,
        ));
    };
    let result = run(tour(60, json!({})), &Budget::default(), &hear).unwrap();
    let PlanResult::Trajectory(result) = result else { panic!("one trajectory") };
    assert!(result.certificate.lawful && result.metrics.saved > 0.05);
    let heard = heard.into_inner().unwrap();
    assert!(heard.len() >= 5, "{heard:?}");
    assert_eq!(heard.len(), result.convergence.len());
    // From stops everywhere downwards, never below what is proven.
    for pair in heard.windows(2) {
        assert!(pair[1].0 >= pair[0].0 && pair[1].1 <= pair[0].1 * (1.0 + 1e-9), "{heard:?}");
        assert!(pair[1].2.unwrap() <= pair[1].1);
    }
}

#[test]
fn a_long_list_ends_soon_after_it_is_cancelled() {
    let (cancel, heard) = (CancelToken::default(), Mutex::new(0));
    let hear = |_: &Progress| {
        let mut heard = heard.lock().unwrap();
        *heard += 1;
        if *heard == 2 {
            cancel.cancel();
        }
    };
    let error = run(tour(2_000, json!({})), &Budget::new(cancel.clone()), &hear).unwrap_err();
    assert_eq!(error.code, PlanCode::Cancelled);
    // The start, the first window, perhaps a second, and the end.
    let heard = *heard.lock().unwrap();
    assert!((2..=4).contains(&heard), "{heard}");
}

/// What was not planned in time stops at every waypoint and is lawful.
#[test]
fn a_late_run_leaves_a_lawful_motion() {
    let late = Budget::default().with_time_limit(Some(Duration::ZERO));
    let error = run(tour(40, json!({})), &late, &|_| {}).unwrap_err();
    assert_eq!(error.code, PlanCode::DeadlineExceeded);
    let Some(PlanResult::Trajectory(partial)) = error.partial.map(|partial| *partial) else {
        panic!("no partial result")
    };
    assert!(partial.certificate.lawful);
    assert_eq!(partial.stop_reason, StopReason::TimeLimit);
    assert!(partial.metrics.saved.abs() < 1e-12);
}

#[test]
fn two_thousand_waypoints_are_taken_and_no_more() {
    let parse = |request: Value| PlanRequest::parse(request).unwrap();
    assert!(validate(&parse(tour(2_000, json!({}))), &catalogue::get).is_ok());
    let found = faults(tour(2_001, json!({})));
    assert!(found.to_string().contains("at most 2000 are taken"), "{found}");
    let mut other = tour(501, json!({}));
    other["task"]["interpolation"] = json!("quintic");
    assert!(faults(other).to_string().contains("at most 500 are taken"));
}

/// Waypoints lie on the limits themselves, where other joints go on moving.
#[test]
fn position_limits_stop_where_they_must() {
    let mut request = tour(30, json!({}));
    let free = plan(request.clone());
    for joint in 0..3 {
        let column = |t: &Vec<f64>| t[joint];
        let rows = free.waypoints.iter().map(column);
        let (lower, upper) = rows.fold((f64::MAX, f64::MIN), |(l, u), x| (l.min(x), u.max(x)));
        merge(
            &mut request["robot"]["joints"][joint]["limits"],
            json!({ "lower": lower, "upper": upper }),
        );
    }
    let bounded = plan(request);
    assert!(bounded.certificate.lawful);
    assert!(bounded.duration > free.duration * (1.0 + 1e-6), "the test is of no use");
    // Few waypoints lie on limits: few stops.
    let (least, most) = (free.duration, free.metrics.initial_duration);
    assert!(bounded.duration < least + 0.5 * (most - least), "{least} {} {most}", bounded.duration);
}

#[test]
fn programs_take_it_leg_by_leg() {
    let leg = |name: &str, rows: Value| {
        json!({ "name": name, "task":
        { "type": "waypoints", "interpolation": "jerk_limited", "waypoints": rows } })
    };
    let mut request = scenario("wood-fastest", json!({}));
    let [a, b, c] =
        [json!([0.8, 1.2, 3.1, 0]), json!([0.6, 0.9, 1.9, 1]), json!([0.7, 0.6, 1.5, 1.8])];
    request["task"] = json!({ "type": "program",
        "legs": [leg("out", json!([a, b, c])), leg("back", json!([c, b, a]))] });
    let result = run(request, &Budget::default(), &|_| {}).unwrap();
    let PlanResult::Program(result) = result else { panic!("a program") };
    assert!(result.lawful);
    // The way back is the way there, backwards in time.
    let [out, back] = [0, 1].map(|leg| result.legs[leg].result.duration);
    assert!((out - back).abs() < 1e-4 * out, "{out} {back}");
}

#[test]
fn results_are_equal_on_any_number_of_threads() {
    let results = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| timeless(&plan(tour(24, json!({})))))
    });
    assert!(results.iter().all(|result| *result == results[0]));
}
