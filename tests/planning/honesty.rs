//! Trajectories that try to slip through the certificate.

use serde_json::{Value, json};
use takt::fault::Faults;
use takt::plan::verify::{VerifyRequest, verify};
use takt::robot::catalogue;
use takt::trajectory::Certificate;

use crate::support::plan;

fn certify(breakpoints: Value, pieces: Value) -> Result<Certificate, Faults> {
    let robot = json!({ "joints": [{ "name": "x", "type": "prismatic", "limits":
        { "velocity": 1.0, "acceleration": 1.0, "jerk": 1.0 } }] });
    let request = json!({ "robot": robot,
        "trajectory": { "breakpoints": breakpoints, "pieces": pieces } });
    verify(&VerifyRequest::parse(request).unwrap(), &catalogue::get)
}

/// Where the arithmetic overflows or vanishes nothing is certified.
#[test]
fn numbers_beyond_computing_are_refused() {
    for (length, c) in [
        // Terms that cancel, but overflow before they do.
        (1e10, vec![0.0, 1e308, -1e298]),
        (1e200, vec![0.5, 0.0, 0.0, 0.0]),
        (1e120, vec![0.0, 0.0, 0.0, 1e-300]),
        // A jerk of 6e6 whose power of the duration vanishes.
        (1e-150, vec![0.0, 0.0, 0.0, 1e6]),
    ] {
        let faults = certify(json!([0.0, length]), json!([[c]])).unwrap_err();
        assert!(faults.0[0].pointer.starts_with("/trajectory"), "{length}: {faults}");
    }
}

/// A jump counts against the motion, not against how far from zero it happens.
#[test]
fn an_offset_hides_no_jump() {
    // 1 mm at 1 km: a jump, wherever it is.
    for offset in [0.0, 1.0, 1000.0, 1e5] {
        let certificate =
            certify(json!([0.0, 1.0, 2.0]), json!([[[offset]], [[offset + 1e-3]]])).unwrap();
        assert!(!certificate.lawful, "offset {offset}");
        assert!(certificate.joints[0].velocity.peak.is_none());
    }
    // Rounding of a position that large is none.
    let slope = |offset: f64| {
        let pieces: Vec<_> =
            (0..100).map(|k| json!([[offset + 0.1 * f64::from(k), 0.1]])).collect();
        let breakpoints: Vec<f64> = (0..=100).map(f64::from).collect();
        certify(json!(breakpoints), json!(pieces)).unwrap()
    };
    for offset in [0.0, 1.0, 1000.0, 1e5] {
        let certificate = slope(offset);
        assert!(certificate.lawful, "offset {offset}: {:?}", certificate.violations);
        assert_eq!(certificate.continuity, 1);
    }
}

/// A waypoint on a position limit is lawful, whatever rounding makes of it.
#[test]
fn waypoints_may_lie_on_position_limits() {
    for (number, (lower, upper)) in
        [(0.1, 0.3), (-2.87979, 2.87979), (0.7, 1.9), (-0.3, 1.1), (100.1, 100.7)]
            .iter()
            .enumerate()
    {
        let limits = json!({ "lower": lower, "upper": upper,
            "velocity": 1.3, "acceleration": 1.7, "jerk": 3.1 });
        let robot = json!({ "joints": [{ "name": "x", "type": "prismatic", "limits": limits }] });
        let middle = lower + 0.37 * (upper - lower);
        for waypoints in [
            json!([[lower], [upper]]),
            json!([[upper], [lower]]),
            json!([[lower], [middle], [upper]]),
            json!([[upper], [middle], [lower]]),
        ] {
            for optimizer in ["exact", "pso"] {
                let task = json!({ "type": "waypoints", "waypoints": waypoints,
                    "optimizer": { "name": optimizer }, "constraint_handling": "reject" });
                let result = plan(json!({ "robot": robot, "task": task }));
                assert!(result.certificate.lawful, "{number} {optimizer}");
            }
        }
    }
}
