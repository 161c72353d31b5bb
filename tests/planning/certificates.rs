//! Certificates against dense sampling and finite differences by code of the
//! tests' own. If these fail, a line may run beyond its limits.

use rayon::prelude::*;
use serde_json::json;
use takt::math::random::RandomStream;
use takt::plan::verify::{VerifyRequest, verify};
use takt::robot::catalogue;
use takt::trajectory::interpolation::{INTERPOLATIONS, ProfileLimits, Timing};
use takt::trajectory::jerk_limited::fastest;
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::timing::{Handling, TimingProblem};
use takt::trajectory::{Certificate, Trajectory};

use crate::jerk_limited;
use crate::support::{bounds, plan, scenario};

const SAMPLES: usize = 100_000;
const TRAJECTORIES: usize = 1_000;

/// Derivative `order` of one joint, term by term.
fn derivative(coefficients: &[f64], order: usize, t: f64) -> f64 {
    let mut sum = 0.0;
    for (power, c) in coefficients.iter().enumerate().skip(order) {
        let factor: f64 = (0..order).map(|k| (power - k) as f64).product();
        sum += c * factor * t.powi((power - order) as i32);
    }
    sum
}

/// Random waypoints and durations whose ratios reach 1:1000.
fn random_trajectory(timing: &Timing, segments: usize, random: &mut RandomStream) -> Trajectory {
    let waypoints: Vec<Vec<f64>> =
        (0..=segments).map(|_| vec![random.uniform(-3.0, 3.0)]).collect();
    let none = KernelLimits { derivatives: [1.0; 3], position: [f64::NEG_INFINITY, f64::INFINITY] };
    let (pieces, durations): (Vec<_>, Vec<f64>) = match timing {
        Timing::Search(kernel) => {
            let durations: Vec<f64> =
                (0..segments).map(|_| 10f64.powf(random.uniform(-1.5, 1.5))).collect();
            let problem =
                TimingProblem::new(*kernel, &waypoints, &[none], Handling::RepairUniform, None);
            return problem.trajectory(&durations);
        }
        Timing::Free => {
            let derivatives = [0; 3].map(|_| 10f64.powf(random.uniform(-1.0, 1.0)));
            return fastest(&waypoints, &[KernelLimits { derivatives, ..none }]).trajectory;
        }
        Timing::ClosedForm(profile) => {
            let mut pieces = Vec::new();
            let mut durations = Vec::new();
            for pair in waypoints.windows(2) {
                let way = pair[1][0] - pair[0][0];
                let limits = ProfileLimits {
                    velocity: 10f64.powf(random.uniform(-1.0, 1.0)),
                    acceleration: 10f64.powf(random.uniform(-1.0, 1.0)),
                };
                for (length, c) in profile(&[way], &[limits]).pieces {
                    let mut scaled: Vec<f64> = c.iter().map(|c| c * way).collect();
                    scaled[0] += pair[0][0];
                    pieces.push(vec![scaled]);
                    durations.push(length);
                }
            }
            (pieces, durations)
        }
    };
    let mut breakpoints = vec![0.0];
    for duration in durations {
        breakpoints.push(breakpoints[breakpoints.len() - 1] + duration);
    }
    Trajectory { breakpoints, pieces }
}

/// The largest magnitudes of the derivatives 1 to 3 at dense samples, and the
/// largest difference quotients of the derivatives below them.
fn dense(trajectory: &Trajectory) -> ([f64; 3], [f64; 3]) {
    let step = trajectory.duration() / SAMPLES as f64;
    let (mut sampled, mut quotients) = ([0.0f64; 3], [0.0f64; 3]);
    let mut piece = 0;
    let mut before: Option<[f64; 4]> = None;
    for k in 0..=SAMPLES {
        let t = (k as f64 * step).min(trajectory.duration());
        while piece + 1 < trajectory.pieces.len() && t >= trajectory.breakpoints[piece + 1] {
            // Both limits: jerk may jump here, between two samples.
            let length = trajectory.breakpoints[piece + 1] - trajectory.breakpoints[piece];
            for (order, sampled) in sampled.iter_mut().enumerate() {
                let left = derivative(&trajectory.pieces[piece][0], order + 1, length);
                let right = derivative(&trajectory.pieces[piece + 1][0], order + 1, 0.0);
                *sampled = sampled.max(left.abs()).max(right.abs());
            }
            piece += 1;
        }
        let c = &trajectory.pieces[piece][0];
        let here =
            [0, 1, 2, 3].map(|order| derivative(c, order, t - trajectory.breakpoints[piece]));
        for order in 0..3 {
            sampled[order] = sampled[order].max(here[order + 1].abs());
            if let Some(before) = before {
                let quotient = (here[order] - before[order]).abs() / step;
                quotients[order] = quotients[order].max(quotient);
            }
        }
        before = Some(here);
    }
    (sampled, quotients)
}

#[test]
fn certificates_agree_with_dense_sampling() {
    INTERPOLATIONS.par_iter().enumerate().for_each(|(stream, entry)| {
        let mut random = RandomStream::new(11, stream as u64);
        for number in 0..TRAJECTORIES {
            let most = entry.max_segments.unwrap_or(6).min(6);
            let segments = entry.min_segments
                + (random.unit() * (most - entry.min_segments + 1) as f64) as usize;
            let trajectory = random_trajectory(&entry.timing, segments, &mut random);
            let certificate = Certificate::new(&trajectory, &[bounds(1e-9)], &[]);
            let joint = &certificate.joints[0];
            let (sampled, quotients) = dense(&trajectory);
            let peaks = [&joint.velocity, &joint.acceleration, &joint.jerk];
            for (order, peak) in peaks.iter().enumerate() {
                let what = format!("{} {number} order {}", entry.name, order + 1);
                let Some(value) = peak.peak else {
                    // Infinite: the interpolation says so.
                    let jerk = !entry.bounded_jerk && order == 2;
                    assert!(jerk || !entry.executable && order == 1, "{what}: infinite");
                    continue;
                };
                assert!(sampled[order] <= value * (1.0 + 1e-9), "{what}: sampled above peak");
                assert!(sampled[order] >= value * (1.0 - 1e-2), "{what}: peak {value} not seen");
                // Mean value theorem: a quotient never exceeds the derivative.
                let slack = 1.0 + 1e-6;
                assert!(quotients[order] <= value * slack, "{what}: quotient above peak");
                assert!(quotients[order] >= value * (1.0 - 0.1), "{what}: quotient {quotients:?}");
            }
            assert!(certificate.continuity >= entry.continuity, "{} {number}", entry.name);
            assert!(certificate.starts_at_rest && certificate.ends_at_rest);
            assert!(!certificate.lawful && !certificate.violations.is_empty());
        }
    });
}

/// An unlawful trajectory is found unlawful, with joint, limit and time.
#[test]
fn verify_names_joint_limit_and_time() {
    let result = plan(scenario("mcb-ab", json!({})));
    let mut request = json!({ "robot": "rokae_xb4", "trajectory": result.trajectory,
        "limits": { "velocity": [0.9, 0.9, 0.9, 0.9, 0.95, 0.7], "jerk": 2.0,
            "acceleration": 1.0, "lower": null, "upper": null } });
    let certify = |request: &serde_json::Value| {
        let request = VerifyRequest::parse(request.clone()).unwrap();
        verify(&request, &catalogue::get).unwrap()
    };
    let certificate = certify(&request);
    assert!(!certificate.lawful);
    let [violation] = &certificate.violations[..] else {
        panic!("{:?}", certificate.violations);
    };
    assert_eq!((violation.joint.as_str(), violation.limit.as_str()), ("joint_6", "velocity"));
    let mut state = takt::trajectory::KinematicState::new(6);
    result.trajectory.sample(violation.at, &mut state);
    assert!((state.velocity[5].abs() - violation.value.unwrap()).abs() < 1e-9);
    assert!(
        violation.detail.contains("joint_6 velocity reaches")
            && violation.detail.contains("0.7 rad/s")
    );

    request["limits"]["velocity"] = json!(1.0);
    assert!(certify(&request).lawful);
}

/// The hash speaks of every delivered number.
#[test]
fn the_hash_changes_with_any_coefficient() {
    let result = plan(scenario("wood", json!({})));
    let hash = result.trajectory.sha256();
    assert_eq!(hash, result.certificate.sha256);
    assert_eq!(hash.len(), 64);
    let mut other = result.trajectory.clone();
    other.pieces[1][2][4] = f64::from_bits(other.pieces[1][2][4].to_bits() + 1);
    assert_ne!(other.sha256(), hash);
}

/// Two pieces of cruising in which acceleration is nothing but rounding, among pieces in which it is not: what
/// jumps by rounding is continuous, what jumps by more is not.
#[test]
fn rounding_between_cruising_pieces_is_no_jump() {
    let waypoints = [vec![0.0], vec![10.0]];
    let limits = [KernelLimits {
        derivatives: [2.0, 4.0, 16.0],
        position: [f64::NEG_INFINITY, f64::INFINITY],
    }];
    let mut trajectory = fastest(&waypoints, &limits).trajectory;
    let cruising = trajectory.pieces.iter().position(|p| p[0][2] == 0.0 && p[0][3] == 0.0);
    let cruising = cruising.unwrap();
    let half = 0.5 * (trajectory.breakpoints[cruising + 1] - trajectory.breakpoints[cruising]);
    let [x, v] = [0, 1].map(|power| trajectory.pieces[cruising][0][power]);
    trajectory.breakpoints.insert(cruising + 1, trajectory.breakpoints[cruising] + half);
    trajectory.pieces.insert(cruising + 1, vec![vec![x + half * v, v, 0.0, 0.0]]);
    let mut with = |acceleration: f64| {
        trajectory.pieces[cruising + 1][0][2] = 0.5 * acceleration;
        Certificate::new(&trajectory, &jerk_limited::bounds(&limits), &[])
    };
    let certificate = with(3e-12);
    assert!(certificate.lawful && certificate.continuity == 2, "{certificate:?}");
    let certificate = with(5e-12);
    assert!(!certificate.lawful && certificate.continuity == 1, "{certificate:?}");
}
