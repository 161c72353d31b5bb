//! Samples are certified as the curve their consumer runs through them.

use serde_json::{Value, json};
use takt::fault::Faults;
use takt::plan::TrajectoryResult;
use takt::plan::samples::{SampleForm, SampleInterpolation, SampleLists, Samples};
use takt::plan::verify::{VerifyRequest, verify};
use takt::robot::catalogue;
use takt::trajectory::{self, Certificate, Timeline};

use crate::support::{plan, scenario};

fn certify(request: Value) -> Result<Certificate, Faults> {
    verify(&VerifyRequest::parse(request)?, &catalogue::get)
}

fn faults(request: Value) -> Vec<String> {
    let faults = certify(request).unwrap_err();
    faults.0.iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect()
}

/// A slide and a turn.
fn robot() -> Value {
    let limits = json!({ "velocity": 2.0, "acceleration": 5.0, "jerk": 100.0 });
    json!({ "name": "pair", "joints": [
        { "name": "slide", "type": "prismatic", "limits": limits },
        { "name": "turn", "type": "revolute", "limits": limits },
    ] })
}

fn samples(samples: Value) -> Value {
    json!({ "robot": robot(), "samples": samples })
}

/// The result's trajectory as `GET /v1/jobs/{id}/trajectory` samples it.
fn export(result: &TrajectoryResult, rate_hz: f64) -> trajectory::Samples {
    let timeline = Timeline {
        joint_names: &result.joint_names,
        joint_units: &result.joint_units,
        legs: vec![(0.0, &result.trajectory)],
    };
    timeline.sample(rate_hz).unwrap()
}

/// What the rounding of positions near 3 rad, which a short step magnifies, may
/// add to the jerk between samples.
fn noise(rate_hz: f64) -> f64 {
    5e-14 * rate_hz.powi(3)
}

/// Certifies an export as its consumer drives it, within limits 1 % above the
/// plan's own peaks.
fn drive(result: &TrajectoryResult, form: &Value, name: &str, noise: f64) -> Certificate {
    let peaks = |of: fn(&trajectory::JointCertificate) -> &trajectory::Peak| -> Vec<f64> {
        let joints = result.certificate.joints.iter();
        joints.map(|joint| of(joint).peak.unwrap() * 1.01 + noise).collect()
    };
    let mut samples = form.clone();
    samples["interpolation"] = json!(name);
    let limits = json!({ "lower": null, "upper": null, "velocity": peaks(|joint| &joint.velocity),
        "acceleration": peaks(|joint| &joint.acceleration), "jerk": peaks(|joint| &joint.jerk) });
    certify(json!({ "robot": result.robot, "limits": limits, "samples": samples })).unwrap()
}

/// A plan survives its export: quintics through what a controller gets are the
/// plan, straight lines are not, whichever form the export has and whatever its rate.
#[test]
fn quintics_through_an_export_keep_the_plans_peaks() {
    for (name, rate_hz) in
        [("mcb-ab", 250.0), ("mcb-ab", 1_000.0), ("mcb-ab", 10_000.0), ("wood", 250.0)]
    {
        let result = plan(scenario(name, json!({ "interpolation": "quintic" })));
        let export = export(&result, rate_hz);
        let message = serde_json::to_value(export.to_joint_trajectory()).unwrap();
        for form in [serde_json::to_value(&export).unwrap(), message] {
            let what = format!("{name} at {rate_hz} Hz");
            let quintics = drive(&result, &form, "quintic", noise(rate_hz));
            assert!(quintics.lawful, "{what}: {:?}", quintics.violations);
            assert!(quintics.continuity >= 2 && quintics.starts_at_rest && quintics.ends_at_rest);
            for (driven, planned) in quintics.joints.iter().zip(&result.certificate.joints) {
                let [a, b] = [driven, planned].map(|joint| {
                    [&joint.velocity, &joint.acceleration, &joint.jerk]
                        .map(|peak| peak.peak.unwrap())
                });
                for (order, tolerance) in [1e-9, 1e-4, 1e-2].into_iter().enumerate() {
                    let close =
                        (a[order] - b[order]).abs() <= tolerance * b[order] + noise(rate_hz);
                    assert!(close, "{what}, order {}: {a:?} for {b:?}", order + 1);
                }
            }
            let lines = drive(&result, &form, "linear", noise(rate_hz));
            assert!(!lines.lawful && lines.continuity == 0, "{what}");
            let moving =
                lines.joints.iter().filter(|joint| joint.position.max > joint.position.min);
            assert!(moving.clone().count() > 0);
            for joint in moving {
                assert!(joint.acceleration.peak.is_none() && joint.jerk.peak.is_none(), "{what}");
                let named = |limit: &str| {
                    let of = |v: &&trajectory::Violation| v.joint == joint.name && v.limit == limit;
                    lines.violations.iter().find(of).unwrap()
                };
                assert!(named("acceleration").detail.contains("velocity jumps by"), "{what}");
            }
        }
    }
}

/// The curves, by hand: one joint goes one metre in a second.
#[test]
fn each_interpolation_has_the_peaks_of_its_curve() {
    let rows = |last: f64| json!([[0.0, 0.3], [last, 0.3], [last, 0.3]]);
    let still = rows(0.0);
    let peaks = |name: &str| {
        let certificate = certify(samples(json!({ "interpolation": name, "times": [0, 1, 2],
            "positions": rows(1.0), "velocities": still, "accelerations": still })));
        let certificate = certificate.unwrap();
        let slide = &certificate.joints[0];
        let values = [&slide.velocity, &slide.acceleration, &slide.jerk].map(|peak| peak.peak);
        let details: Vec<String> =
            certificate.violations.iter().map(|violation| violation.detail.clone()).collect();
        (values, certificate.continuity, details)
    };
    let (values, continuity, details) = peaks("linear");
    assert_eq!((values, continuity), ([Some(1.0), None, None], 0));
    assert_eq!(details.len(), 2, "{details:?}");
    assert_eq!(
        details[0],
        "slide acceleration is infinite at 1.000000 s, where velocity jumps by 1.000000 m/s, \
         above its limit of 5 m/s²"
    );
    let (values, continuity, details) = peaks("cubic");
    assert_eq!((values, continuity), ([Some(1.5), Some(6.0), None], 1));
    assert!(details[1].contains("acceleration jumps by 6.000000 m/s²"), "{details:?}");
    let (values, continuity, details) = peaks("quintic");
    let expected = [1.875, 10.0 / 3f64.sqrt(), 60.0];
    for (value, expected) in values.iter().zip(expected) {
        assert!((value.unwrap() - expected).abs() < 1e-12 * expected, "{values:?}");
    }
    assert_eq!(continuity, 2);
    assert!(details[0].starts_with("slide acceleration reaches 5.773503 m/s²"), "{details:?}");
}

/// Columns go to the joints they name, as ROS reads them.
#[test]
fn joints_are_matched_by_name() {
    let request = |names: Value| {
        samples(json!({ "interpolation": "linear", "joint_names": names, "times": [0, 1],
            "positions": [[0.25, 0.0], [0.25, 1.0]] }))
    };
    let speeds = |names: Value| -> Vec<f64> {
        let joints = certify(request(names)).unwrap().joints;
        joints.iter().map(|joint| joint.velocity.peak.unwrap()).collect()
    };
    assert_eq!(speeds(json!(null)), [0.0, 1.0]);
    assert_eq!(speeds(json!(["slide", "turn"])), [0.0, 1.0]);
    assert_eq!(speeds(json!(["turn", "slide"])), [1.0, 0.0]);
    let missing = "/samples/joint_names: joint `turn` of pair is missing";
    assert_eq!(faults(request(json!(["slide", "slide"]))), [missing]);
    let few = faults(request(json!(["slide"])));
    assert_eq!(few, ["/samples/joint_names: 1 names for the 2 joints of pair", missing]);
}

/// All faults come together, each where it stands in the form that was sent.
#[test]
fn faults_name_sample_and_list() {
    assert_eq!(
        faults(samples(json!({ "interpolation": "quintic", "times": [0.5, 1, 1],
            "positions": [[0, 0], [1], [1, 1]], "velocities": [[0, 0]] }))),
        [
            "/samples/times/0: 0.5 s; the first sample's time is 0",
            "/samples/times/2: 1 s does not come after 1 s; times ascend",
            "/samples/positions/1: 1 values for 2 joints",
            "/samples/velocities: 1 rows for 3 times",
            "/samples/accelerations: missing accelerations: the interpolation named needs them",
        ]
    );
    let at = |sec: i32, nanosec: u32| json!({ "sec": sec, "nanosec": nanosec });
    assert_eq!(
        faults(samples(json!({ "interpolation": "cubic", "joint_names": ["slide", "turn"],
            "header": { "frame_id": "base" }, "points": [
                { "positions": [0, 0], "time_from_start": at(0, 0) },
                { "positions": [0, 0, 0], "time_from_start": at(0, 500_000_000) },
                { "positions": [0, 0], "time_from_start": at(0, 500_000_000) },
            ] }))),
        [
            "/samples/points/2/time_from_start: 0.5 s does not come after 0.5 s; times ascend",
            "/samples/points/1/positions: 3 values for 2 joints",
            "/samples/points: missing velocities: the interpolation named needs them",
        ]
    );
    assert_eq!(
        faults(samples(json!({ "times": [0], "positions": "none", "speeds": [] }))).len(),
        3
    );
    let one = json!({ "interpolation": "linear", "times": [0], "positions": [[0, 0]] });
    assert_eq!(faults(samples(one)), ["/samples/times: 1 samples; 2 to 200000 are taken"]);
    let huge =
        json!({ "interpolation": "linear", "times": [0, 1], "positions": [[0, 0], [1e300, 0]] });
    assert!(faults(samples(huge))[0].starts_with("/samples: piece 0, joint 0: coefficient 1"));
}

/// JSON has no such numbers, a library's caller has.
#[test]
fn numbers_that_are_none_and_too_many_samples_are_refused() {
    let faults = |times: Vec<f64>, positions: Vec<Vec<f64>>| {
        let mut request = VerifyRequest::parse(samples(json!({
            "interpolation": "linear", "times": [], "positions": [] })))
        .unwrap();
        let (joint_names, velocities, accelerations) = (None, None, None);
        let lists = SampleLists { joint_names, times, positions, velocities, accelerations };
        let interpolation = SampleInterpolation::Linear;
        request.samples = Some(Samples { interpolation, form: SampleForm::Lists(lists) });
        verify(&request, &catalogue::get).unwrap_err().to_string()
    };
    let still = |count: usize| vec![vec![0.0, 0.0]; count];
    assert_eq!(faults(vec![0.0, f64::NAN], still(2)), "/samples/times/1: NaN s is not a time");
    assert_eq!(
        faults(vec![0.0, 1.0], vec![vec![0.0, 0.0], vec![0.0, f64::INFINITY]]),
        "/samples/positions/1/1: inf is not finite"
    );
    let many = trajectory::MAX_SAMPLES + 1;
    assert_eq!(
        faults((0..many).map(|k| k as f64).collect(), still(many)),
        "/samples/times: 200001 samples; 2 to 200000 are taken"
    );
}
