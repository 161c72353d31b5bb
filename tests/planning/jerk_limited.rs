//! The fastest trajectory: against independent optima, and on random problems of every kind.

use std::thread;

use serde_json::Value;
use takt::math::random::RandomStream;
use takt::plan::scenarios;
use takt::trajectory::jerk_limited::{Fastest, fastest};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{Certificate, JointBounds, Limit};

const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn limits(rows: &[[f64; 3]]) -> Vec<KernelLimits> {
    rows.iter().map(|&derivatives| KernelLimits { derivatives, position: FREE }).collect()
}

fn bounds(limits: &[KernelLimits]) -> Vec<JointBounds> {
    let limit = |value: f64| {
        value.is_finite().then(|| Limit { value, provenance: "the test".to_owned() })
    };
    let joint = |(number, limits): (usize, &KernelLimits)| JointBounds {
        name: format!("j{number}"),
        unit: "rad",
        lower: None,
        upper: None,
        derivatives: limits.derivatives.map(limit),
    };
    limits.iter().enumerate().map(joint).collect()
}

/// Certifies the result and returns its duration.
fn certified(name: &str, waypoints: &[Vec<f64>], limits: &[KernelLimits], found: &Fastest) -> f64 {
    found.trajectory.validate(limits.len()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let due: Vec<(f64, &[f64])> =
        found.times.iter().zip(waypoints).map(|(t, row)| (*t, row.as_slice())).collect();
    let certificate = Certificate::new(&found.trajectory, &bounds(limits), &due);
    assert!(certificate.lawful, "{name}: {:?}", certificate.violations);
    assert!(certificate.starts_at_rest && certificate.ends_at_rest, "{name}");
    let smooth = limits.iter().all(|limit| limit.derivatives[2].is_finite());
    assert!(certificate.continuity >= if smooth { 2 } else { 1 }, "{name}");
    let error = certificate.waypoint_error.unwrap();
    assert!(error <= 1e-9, "{name} misses a waypoint by {error}");
    found.trajectory.duration()
}

fn problem(value: &Value) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
    let row = |row: &Value| -> Vec<f64> {
        row.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    let waypoints = value["waypoints"].as_array().unwrap().iter().map(row).collect();
    let [v, a, j] = ["velocity", "acceleration", "jerk"].map(|name| row(&value[name]));
    let rows: Vec<[f64; 3]> = (0..v.len()).map(|joint| [v[joint], a[joint], j[joint]]).collect();
    (waypoints, limits(&rows))
}

/// The references are lawful curves found by linear programmes, up to 0.12 %
/// above the optimum: none may be missed by more than 0.01 %.
#[test]
fn reaches_the_independent_optima_of_the_random_problems() {
    let problems: Vec<Value> =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    for value in &problems {
        let name = value["name"].as_str().unwrap();
        let (waypoints, limits) = problem(value);
        let found = fastest(&waypoints, &limits);
        let ratio = certified(name, &waypoints, &limits, &found)
            / value["reference"]["free"].as_f64().unwrap();
        assert!(found.converged, "{name}");
        assert!((0.998..=1.0001).contains(&ratio), "{name}: {ratio} of the reference");
    }
}

/// `mcb-ab` and `wood` with the limits of their papers; references in s.
#[test]
fn reaches_the_independent_optima_of_the_papers_problems() {
    let wood_jerk = [3.2, 3.2, 9.6, 9.6];
    for (name, jerk, reference) in [
        ("mcb-ab", Some(vec![2.0; 6]), 4.8803),
        ("mcb-ab", None, 4.2605),
        ("wood", Some(wood_jerk.map(|j| 4.0 * j / 4.0).to_vec()), 3.6472),
        ("wood", None, 3.3597),
    ] {
        let (waypoints, limits) = paper(name, jerk);
        let found = fastest(&waypoints, &limits);
        let ratio = certified(name, &waypoints, &limits, &found) / reference;
        assert!((0.998..=1.0001).contains(&ratio), "{name}: {ratio} of the reference");
    }
}
