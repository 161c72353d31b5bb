//! Which limit holds which instant: known phases, dense samples, and that the
//! fastest motion leaves no instant unused.

use serde_json::{Value, json};
use takt::plan::TrajectoryResult;
use takt::trajectory::{BindingTimeline, KinematicState, LimitTimeline};

use crate::support::{plan, scenario};

fn timeline(result: &TrajectoryResult) -> BindingTimeline {
    BindingTimeline::new(&result.trajectory, &result.certificate.joints)
}

fn axis(limits: Value, interpolation: &str) -> TrajectoryResult {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic", "limits": limits }] });
    let task =
        json!({ "type": "waypoints", "interpolation": interpolation, "waypoints": [[0], [4]] });
    plan(json!({ "robot": robot, "task": task }))
}

fn limit<'a>(timeline: &'a BindingTimeline, name: &str) -> &'a LimitTimeline {
    timeline.joints[0].limits.iter().find(|limit| limit.limit == name).unwrap()
}

#[track_caller]
fn assert_intervals(limit: &LimitTimeline, expected: &[[f64; 2]], tolerance: f64) {
    let found: Vec<_> = limit.intervals.iter().map(|it| [it.start, it.end]).collect();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
    }
}

/// 4 m with 2 m/s and 4 m/s²: half a second each to speed up and to brake. The
/// speed is within 0.1 % of its limit half a millisecond before it is reached.
#[test]
fn a_trapezoid_has_the_phases_everybody_knows() {
    let limits = json!({ "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4 });
    let timeline = timeline(&axis(limits, "trapezoidal"));
    assert!((timeline.duration - 2.5).abs() < 1e-9);
    assert_intervals(limit(&timeline, "acceleration"), &[[0.0, 0.5], [2.0, 2.5]], 1e-9);
    assert_intervals(limit(&timeline, "velocity"), &[[0.4995, 2.0005]], 1e-9);
    assert_eq!(timeline.joints[0].limits.len(), 2, "no jerk limit is known");
    assert!((timeline.held - 1.0).abs() < 1e-9);
    assert!((limit(&timeline, "velocity").share - 1.501 / 2.5).abs() < 1e-9);
}

/// The same with 40 m/s³: seven phases, jerk for 0.1 s at each end of each ramp.
#[test]
fn a_motion_of_seven_phases_has_them() {
    let limits = json!({ "lower": 0, "upper": 10, "velocity": 2, "acceleration": 4, "jerk": 40 });
    let timeline = timeline(&axis(limits, "jerk_limited"));
    // 2 m/s are reached after 0.6 s and 0.6 m; 2.8 m remain.
    assert!((timeline.duration - 2.6).abs() < 2e-3, "{}", timeline.duration);
    let jerk: Vec<[f64; 2]> = vec![[0.0, 0.1], [0.5, 0.6], [2.0, 2.1], [2.5, 2.6]];
    assert_intervals(limit(&timeline, "jerk"), &jerk, 0.02);
    // Acceleration is near its limit a moment before the jerk ends.
    assert_intervals(limit(&timeline, "acceleration"), &[[0.1, 0.5], [2.1, 2.5]], 0.02);
    // Speed approaches its limit with a parabola: √(2 · 0.002 / 40) = 10 ms before.
    assert_intervals(limit(&timeline, "velocity"), &[[0.59, 2.01]], 0.02);
    assert!(timeline.held > 0.98, "{}", timeline.held);
}

#[test]
fn intervals_agree_with_dense_sampling() {
    for name in ["mcb-ab", "mcb-ab-fastest", "wood", "palletizing-points"] {
        let result = plan(scenario(name, json!({})));
        let timeline = timeline(&result);
        let count = 20_000;
        let mut state = KinematicState::new(result.joint_names.len());
        let (mut inside, mut union) = (0, 0);
        for sample in 0..count {
            let t = timeline.duration * (f64::from(sample) + 0.5) / f64::from(count);
            result.trajectory.sample(t, &mut state);
            let mut any = false;
            for (index, (joint, peaks)) in
                timeline.joints.iter().zip(&result.certificate.joints).enumerate()
            {
                for limit in &joint.limits {
                    let (value, peak) = match limit.limit.as_str() {
                        "velocity" => (state.velocity[index], &peaks.velocity),
                        "acceleration" => (state.acceleration[index], &peaks.acceleration),
                        _ => (state.jerk[index], &peaks.jerk),
                    };
                    let ratio = value.abs() / peak.limit.unwrap();
                    let held = limit.intervals.iter().any(|it| it.start <= t && t <= it.end);
                    assert!(
                        held == (ratio >= 0.999) || (ratio - 0.999).abs() < 1e-6,
                        "{name}, {} of {} at {t}: {ratio}, {held}",
                        limit.limit,
                        joint.joint
                    );
                    inside += u32::from(held);
                    any |= held;
                }
            }
            union += u32::from(any);
        }
        let sampled = f64::from(union) / f64::from(count);
        assert!((timeline.held - sampled).abs() < 1e-3, "{name}: {} {sampled}", timeline.held);
        let shares: f64 =
            timeline.joints.iter().flat_map(|joint| &joint.limits).map(|it| it.share).sum();
        let sampled = f64::from(inside) / f64::from(count);
        assert!(sampled > 0.0 && (shares - sampled).abs() < 5e-3, "{name}: {shares} {sampled}");
    }
}

#[test]
fn a_motion_far_from_all_limits_is_held_by_none() {
    let result = plan(scenario("mcb-ab", json!({ "duration": { "exactly": 20.0 } })));
    let timeline = timeline(&result);
    let limits = timeline.joints.iter().flat_map(|joint| &joint.limits);
    assert!(limits.clone().count() > 0);
    assert!(limits.into_iter().all(|limit| limit.intervals.is_empty() && limit.share == 0.0));
    assert_eq!(timeline.held, 0.0);
}

/// The fastest motion wastes no time: some joint is always at a limit.
#[test]
fn every_instant_of_the_fastest_motion_is_held_by_some_joint() {
    for name in ["mcb-ab-fastest", "wood-fastest"] {
        let held = timeline(&plan(scenario(name, json!({})))).held;
        println!("{name}: {held}");
        assert!(held > 0.97, "{name}: {held}");
    }
    // A quintic cannot: it meets its limits at moments.
    let held = timeline(&plan(scenario("mcb-ab", json!({})))).held;
    println!("mcb-ab: {held}");
    assert!(held < 0.3, "{held}");
}
