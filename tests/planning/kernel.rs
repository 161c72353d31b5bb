//! The kernel against the certificate: two independent ways to the same peaks.
//! If these fail, an optimizer works with figures the certificate refutes.

use takt::math::random::RandomStream;
use takt::trajectory::interpolation::{INTERPOLATIONS, Interpolation, Timing};
use takt::trajectory::kernel::{JointLanes, Kernel, KernelLimits};
use takt::trajectory::timing::{Handling, TimingProblem};
use takt::trajectory::{Certificate, JointBounds, Limit};

const PROBLEMS: usize = 300;

struct Problem {
    waypoints: Vec<Vec<f64>>,
    limits: Vec<KernelLimits>,
    durations: Vec<f64>,
}

/// 1 to 20 joints, of which some rest in some segments or throughout, and
/// durations from nearly equal to 1:1000.
fn random_problem(random: &mut RandomStream, segments: usize) -> Problem {
    let dof = 1 + (random.unit() * 20.0) as usize;
    let offset = if random.unit() < 0.2 { 100.0 } else { 0.0 };
    let mut waypoints: Vec<Vec<f64>> =
        vec![(0..dof).map(|_| offset + random.uniform(-3.0, 3.0)).collect()];
    let lively: Vec<f64> = (0..dof).map(|_| random.unit()).collect();
    for segment in 0..segments {
        let row: Vec<f64> = (0..dof)
            .map(|joint| {
                let moves = lively[joint] > 0.2 && random.unit() < lively[joint];
                let before = waypoints[segment][joint];
                if moves { offset + random.uniform(-3.0, 3.0) } else { before }
            })
            .collect();
        waypoints.push(row);
    }
    let limits = (0..dof)
        .map(|joint| {
            let xs = || waypoints.iter().map(|row| row[joint]);
            let (low, high) = (xs().fold(f64::MAX, f64::min), xs().fold(f64::MIN, f64::max));
            KernelLimits {
                derivatives: [0; 3].map(|_| 10f64.powf(random.uniform(-2.0, 2.0))),
                position: [low - random.unit() * 0.5, high + random.unit() * 0.5],
            }
        })
        .collect();
    let spread = random.uniform(0.0, 1.5);
    let durations = (0..segments).map(|_| 10f64.powf(random.uniform(-spread, spread))).collect();
    Problem { waypoints, limits, durations }
}

fn certify(problem: &Problem, timing: &TimingProblem, durations: &[f64]) -> Certificate {
    let trajectory = timing.trajectory(durations);
    trajectory.validate(problem.limits.len()).unwrap();
    let limit = |value| Some(Limit { value, provenance: String::new() });
    let bounds: Vec<JointBounds> = problem
        .limits
        .iter()
        .map(|limits| JointBounds {
            name: "j".into(),
            unit: "rad",
            lower: limit(limits.position[0]),
            upper: limit(limits.position[1]),
            derivatives: limits.derivatives.map(limit),
        })
        .collect();
    Certificate::new(&trajectory, &bounds, &[])
}

fn each_problem(check: impl Fn(&str, &'static dyn Kernel, &Interpolation, &Problem)) {
    for (stream, entry) in INTERPOLATIONS.iter().enumerate() {
        let Timing::Search(kernel) = entry.timing else { continue };
        let mut random = RandomStream::new(23, stream as u64);
        for number in 0..PROBLEMS {
            let most = entry.max_segments.unwrap_or(20);
            let choice = (most - entry.min_segments + 1) as f64;
            let segments = entry.min_segments + (random.unit() * choice) as usize;
            let problem = random_problem(&mut random, segments);
            check(&format!("{} {number}", entry.name), kernel, entry, &problem);
        }
    }
}

#[test]
fn kernel_ratios_are_the_certificates() {
    each_problem(|what, kernel, entry, problem| {
        let Problem { waypoints, limits, durations } = problem;
        let timing = TimingProblem::new(kernel, waypoints, limits, Handling::RepairUniform, None);
        let certificate = certify(problem, &timing, durations);
        let lanes = JointLanes::new(waypoints, limits);
        let mut work = kernel.workspace(&lanes);
        kernel.ratios(&lanes, durations, &mut work);
        let mut scale = 0.0f64;
        for (joint, certified) in certificate.joints.iter().enumerate() {
            let peaks = [&certified.velocity, &certified.acceleration, &certified.jerk];
            for (order, peak) in peaks.iter().enumerate() {
                let what = format!("{what} joint {joint} order {order}");
                let ratios = (0..durations.len()).map(|s| work.ratio(&lanes, s, joint, order));
                let found = ratios.fold(0.0, f64::max);
                scale = scale.max(found.powf(1.0 / (order + 1) as f64));
                let Some(expected) = peak.ratio else {
                    let jerk = order == 2 && !entry.bounded_jerk;
                    let jump = order >= 1 && !entry.executable;
                    assert!(jerk || jump, "{what}: infinite, kernel {found}");
                    continue;
                };
                assert!((found - expected).abs() <= 1e-7 * expected, "{what}: {found} {expected}");
            }
        }
        let found = kernel.scale(&lanes, durations, &mut work);
        assert!((found / scale - 1.0).abs() <= 1e-9 || scale == 0.0, "{what}: {found} {scale}");
    });
}

#[test]
fn kernel_position_excess_is_the_certificates() {
    each_problem(|what, kernel, _, problem| {
        let Problem { waypoints, limits, durations } = problem;
        let timing = TimingProblem::new(kernel, waypoints, limits, Handling::RepairUniform, None);
        let certificate = certify(problem, &timing, durations);
        let lanes = JointLanes::new(waypoints, limits);
        let mut work = kernel.workspace(&lanes);
        kernel.trajectory(&lanes, durations, &mut work);
        let excess = kernel.position_excess(&lanes, &work);
        let mut expected = f64::NEG_INFINITY;
        let mut size = 1.0f64;
        for (certified, limit) in certificate.joints.iter().zip(limits) {
            let range = &certified.position;
            size = size.max(range.min.abs()).max(range.max.abs());
            expected =
                expected.max(limit.position[0] - range.min).max(range.max - limit.position[1]);
        }
        let same = (excess.max(0.0) - expected.max(0.0)).abs() <= 1e-8 * size;
        assert!(same, "{what}: {excess} {expected}");
        // What the kernel lets pass, the certificate lets pass.
        let position = certificate.violations.iter().any(|v| v.limit == "position");
        assert!(excess > 0.0 || !position, "{what}: {excess} {expected}");
    });
}
