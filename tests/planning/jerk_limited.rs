//! The fastest trajectory: against independent optima, and on random problems of every kind.

use std::ops::Range;
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

pub fn bounds(limits: &[KernelLimits]) -> Vec<JointBounds> {
    let limit =
        |value: f64| value.is_finite().then(|| Limit { value, provenance: "the test".to_owned() });
    let joint = |(number, limits): (usize, &KernelLimits)| JointBounds {
        name: format!("j{number}"),
        unit: "rad",
        lower: None,
        upper: None,
        derivatives: limits.derivatives.map(limit),
    };
    limits.iter().enumerate().map(joint).collect()
}

/// What is wrong with the result, if anything.
fn fault(waypoints: &[Vec<f64>], limits: &[KernelLimits], found: &Fastest) -> Option<String> {
    if let Err(error) = found.trajectory.validate(limits.len()) {
        return Some(error.to_string());
    }
    let due: Vec<(f64, &[f64])> =
        found.times.iter().zip(waypoints).map(|(t, row)| (*t, row.as_slice())).collect();
    let certificate = Certificate::new(&found.trajectory, &bounds(limits), &due);
    let smooth = limits.iter().all(|limit| limit.derivatives[2].is_finite());
    let error = certificate.waypoint_error.unwrap();
    if !certificate.lawful {
        Some(format!("{:?}", certificate.violations))
    } else if !(certificate.starts_at_rest && certificate.ends_at_rest) {
        Some("is not at rest at both ends".to_owned())
    } else if certificate.continuity < if smooth { 2 } else { 1 } {
        Some(format!("is continuous only up to derivative {}", certificate.continuity))
    } else {
        (error > 1e-9).then(|| format!("misses a waypoint by {error}"))
    }
}

/// Certifies the result and returns its duration.
fn certified(name: &str, waypoints: &[Vec<f64>], limits: &[KernelLimits], found: &Fastest) -> f64 {
    assert_eq!(fault(waypoints, limits, found), None, "{name}");
    found.trajectory.duration()
}

pub fn problem(value: &Value) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
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

/// Waypoints of a scenario of a paper, with one row of limits for all its joints.
fn paper(name: &str, rows: &[[f64; 3]]) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
    let request = &scenarios::get(name).unwrap().request;
    let waypoints = serde_json::from_value(request["task"]["waypoints"].clone()).unwrap();
    (waypoints, limits(rows))
}

/// The papers' problems with their limits, with and without jerk; references in s.
#[test]
fn reaches_the_independent_optima_of_the_papers_problems() {
    let mut han = [[0.9, 0.9, 2.0]; 6];
    han[4] = [0.95, 0.9, 2.0];
    han[5] = [1.0, 1.0, 2.0];
    let mut wood = [[0.6, 0.8, 3.2]; 4];
    wood[2] = [1.8, 2.4, 9.6];
    wood[3] = [1.8, 2.4, 9.6];
    for (name, mut rows, references) in
        [("mcb-ab", han.to_vec(), [4.8803, 4.2605]), ("wood", wood.to_vec(), [3.6472, 3.3597])]
    {
        for reference in references {
            let (waypoints, limits) = paper(name, &rows);
            let found = fastest(&waypoints, &limits);
            let ratio = certified(name, &waypoints, &limits, &found) / reference;
            assert!((0.998..=1.0001).contains(&ratio), "{name}: {ratio} of the reference");
            rows.iter_mut().for_each(|row| row[2] = f64::INFINITY);
        }
    }
}

/// From rest to rest the fastest way is known in closed form: jerk, acceleration and
/// speed at their limits in turn.
#[test]
fn two_waypoints_take_the_closed_form_time() {
    // Way, limits, and the sum of the phases' durations.
    for (way, limit, expected) in [
        (0.1, [9.0, 9.0, 5.0], 4.0 * (0.1f64 / 10.0).cbrt()),
        (1.0, [9.0, 1.0, 5.0], 0.2 + (0.04f64 + 4.0).sqrt()),
        (2.0, [0.5, 1.0, 5.0], 4.0 + 0.5 + 0.2),
        (2.0, [0.5, 1.0, f64::INFINITY], 4.0 + 0.5),
        (0.5, [f64::INFINITY, f64::INFINITY, 4.0], 4.0 * (0.5f64 / 8.0).cbrt()),
    ] {
        let (waypoints, limits) = (vec![vec![3.0], vec![3.0 - way]], limits(&[limit]));
        let found = fastest(&waypoints, &limits);
        let duration = certified("two waypoints", &waypoints, &limits, &found);
        assert!((duration / expected - 1.0).abs() < 1e-9, "{limit:?}: {duration}, not {expected}");
    }
}

/// What makes planning hard: joints that never move, coincident coordinates, segments a thousand times
/// shorter than others, limits spread over decades, limits missing.
pub fn nasty(seed: u64) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
    let mut random = RandomStream::new(41, seed);
    let joints = 1 + (random.unit() * 9.0) as usize;
    let count = 2 + (random.unit() * 11.0) as usize;
    let (spread, missing) = (random.unit() < 0.5, random.unit() < 0.3);
    let still: Vec<bool> = (0..joints).map(|joint| joint > 0 && random.unit() < 0.15).collect();
    let mut waypoints: Vec<Vec<f64>> = vec![vec![0.3; joints]];
    while waypoints.len() < count {
        let scale = if random.unit() < 0.15 { 1e-3 } else { 1.0 };
        let mut row = waypoints[waypoints.len() - 1].clone();
        for (value, still) in row.iter_mut().zip(&still) {
            if !still && random.unit() < 0.9 {
                *value += scale * random.uniform(-1.5, 1.5);
            }
        }
        if row != waypoints[waypoints.len() - 1] {
            waypoints.push(row);
        }
    }
    let mut limit = |typical: f64| {
        let exponent = random.uniform(-1.0, 1.0) * if spread { 1.5 } else { 0.5 };
        let gone = missing && random.unit() < 0.3;
        if gone { f64::INFINITY } else { typical * 10f64.powf(exponent) }
    };
    let rows: Vec<[f64; 3]> = (0..joints).map(|_| [1.0, 4.0, 30.0].map(&mut limit)).collect();
    (waypoints, limits(&rows))
}

/// The longest of the joints' closed-form times, segment by segment.
fn stopping(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> f64 {
    let legs = waypoints.windows(2);
    legs.map(|leg| fastest(leg, limits).trajectory.duration()).sum()
}

/// What came of many problems.
#[derive(Debug, Default)]
struct Survey {
    /// Unlawful, slower than stopping, or faster than its bound says is possible.
    faults: Vec<String>,
    /// Seeds of problems that were not solved to the end.
    unsolved: Vec<u64>,
    /// Seeds of problems for which nothing was found but to stop everywhere.
    stops: Vec<u64>,
    /// How much longer each plan is than its bound.
    gaps: Vec<f64>,
}

/// Plans the problems of `seeds`.
fn survey(seeds: Range<u64>) -> Survey {
    let mut survey = Survey::default();
    for seed in seeds {
        let (waypoints, limits) = nasty(seed);
        let found = fastest(&waypoints, &limits);
        let (duration, stops) = (found.trajectory.duration(), stopping(&waypoints, &limits));
        let slow = || {
            (duration > stops * (1.0 + 1e-9)).then(|| format!("{duration}, but {stops} with stops"))
        };
        let impossible =
            || (found.lower > duration).then(|| format!("{duration}, but bound {}", found.lower));
        survey.gaps.push(duration / found.lower - 1.0);
        if let Some(fault) = fault(&waypoints, &limits, &found).or_else(slow).or_else(impossible) {
            survey.faults.push(format!("problem {seed}: {fault}"));
        }
        if !found.converged {
            survey.unsolved.push(seed);
        }
        if found.stops {
            survey.stops.push(seed);
        }
    }
    survey
}

#[test]
fn no_random_problem_fails_or_is_slower_than_stopping() {
    let Survey { faults, unsolved, .. } = survey(0..60);
    assert!(faults.is_empty() && unsolved.is_empty(), "{faults:#?}, unsolved: {unsolved:?}");
}

/// `cargo test --release --test planning ten_thousand -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes; the line above runs it"]
fn ten_thousand_random_problems_are_lawful_and_no_slower_than_stopping() {
    let halves = [0..5_000, 5_000..10_000];
    let found: Vec<Survey> = thread::scope(|scope| {
        let runs = halves.map(|seeds| scope.spawn(|| survey(seeds)));
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    let faults: Vec<&String> = found.iter().flat_map(|half| &half.faults).collect();
    let unsolved: Vec<u64> = found.iter().flat_map(|half| half.unsolved.clone()).collect();
    let stops: Vec<u64> = found.iter().flat_map(|half| half.stops.clone()).collect();
    println!("{} unsolved: {unsolved:?}; {} stop: {stops:?}", unsolved.len(), stops.len());
    let mut gaps: Vec<f64> = found.iter().flat_map(|half| half.gaps.clone()).collect();
    gaps.sort_by(f64::total_cmp);
    let quantiles = [0.25, 0.5, 0.75, 0.9].map(|at| gaps[(at * gaps.len() as f64) as usize]);
    println!("gaps to the bound, quartiles and nine tenths: {quantiles:?}");
    assert!(quantiles[1] < 0.02, "{quantiles:?}");
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(unsolved.len() <= 20, "{} were not solved to the end", unsolved.len());
}

#[test]
fn long_lists_keep_moving() {
    let mut random = RandomStream::new(7, 0);
    let waypoints: Vec<Vec<f64>> =
        (0..40).map(|_| (0..9).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let limits = limits(&[[2.0, 6.0, 40.0]; 9]);
    let found = fastest(&waypoints, &limits);
    let duration = certified("a tour", &waypoints, &limits, &found);
    assert!(duration < 0.9 * stopping(&waypoints, &limits), "{duration}");
    assert!(found.converged && !found.stops);
}

/// A list of one joint that is searched although it is longer than a window.
#[test]
fn a_long_list_of_one_joint_may_be_hard() {
    let mut random = RandomStream::new(94, 5);
    let mut position = || random.uniform(-1.0, 1.0) * if random.unit() < 0.5 { 1e-3 } else { 1.0 };
    let waypoints: Vec<Vec<f64>> = (0..22).map(|_| vec![position()]).collect();
    let limits = limits(&[[f64::INFINITY, 3.0, 30.0]]);
    let found = fastest(&waypoints, &limits);
    let duration = certified("one joint", &waypoints, &limits, &found);
    assert!(duration > 1.05 * found.lower, "the test is of no use: {} {duration}", found.lower);
    assert!(duration <= stopping(&waypoints, &limits));
}

/// A joint that turns round at a waypoint would pass it by; its position limit forbids that.
#[test]
fn position_limits_hold_between_waypoints() {
    let waypoints = vec![vec![0.0, 0.0], vec![1.0, 1.0], vec![0.98, 2.0], vec![0.0, 3.0]];
    let mut limits = limits(&[[1.0, 2.0, 10.0]; 2]);
    let free = fastest(&waypoints, &limits);
    limits[0].position = [0.0, 1.0];
    let found = fastest(&waypoints, &limits);
    let [highest, bounded] = [&free, &found].map(|found| {
        certified("a turn", &waypoints, &limits, found);
        let certificate = Certificate::new(&found.trajectory, &bounds(&limits), &[]);
        certificate.joints[0].position.max
    });
    assert!(highest > 1.001, "the test is of no use: {highest}");
    assert!(bounded <= 1.0 + 1e-9, "{bounded}");
}

#[test]
fn results_repeat_on_any_thread() {
    let (waypoints, limits) = nasty(3);
    let alone = fastest(&waypoints, &limits).trajectory.sha256();
    let (waypoints, limits) = (&waypoints, &limits);
    thread::scope(|scope| {
        let runs: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| fastest(waypoints, limits).trajectory.sha256()))
            .collect();
        for run in runs {
            assert_eq!(run.join().unwrap(), alone);
        }
    });
}
