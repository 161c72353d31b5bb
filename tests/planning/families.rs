//! Each family of curves against its defining conditions, written down and
//! solved here in other ways. If these fail, a family is not the curve it says.

use nalgebra::{DMatrix, DVector};
use serde_json::json;
use takt::math::random::RandomStream;
use takt::trajectory::interpolation::{INTERPOLATIONS, Timing, interpolation};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::timing::{Handling, TimingProblem};
use takt::trajectory::{Certificate, Trajectory};

use crate::support::{bounds, faults, plan, scenario, try_plan, without_jerk};

const UNIT: KernelLimits =
    KernelLimits { derivatives: [1.0; 3], position: [f64::NEG_INFINITY, f64::INFINITY] };

fn curve(name: &str, waypoints: &[Vec<f64>], durations: &[f64]) -> Trajectory {
    let Timing::Search(kernel) = interpolation(name).unwrap().timing else {
        panic!("{name} is searched");
    };
    let limits = vec![UNIT; waypoints[0].len()];
    TimingProblem::new(kernel, waypoints, &limits, Handling::RepairUniform, None)
        .trajectory(durations)
}

fn random_waypoints(random: &mut RandomStream, segments: usize, dof: usize) -> Vec<Vec<f64>> {
    (0..=segments).map(|_| (0..dof).map(|_| random.uniform(-3.0, 3.0)).collect()).collect()
}

/// Nearly equal to 1:1000.
fn random_durations(random: &mut RandomStream, segments: usize) -> Vec<f64> {
    let spread = random.uniform(0.0, 1.5);
    (0..segments).map(|_| 10f64.powf(random.uniform(-spread, spread))).collect()
}

/// `d`-th derivative of `t^power`.
fn power(power: usize, d: usize, t: f64) -> f64 {
    if d > power {
        return 0.0;
    }
    (power + 1 - d..=power).product::<usize>() as f64 * t.powi((power - d) as i32)
}

/// A piece of the dense system: its duration, its degree, and the waypoints at
/// its start and end; a virtual point has none.
type Part = (f64, usize, [Option<usize>; 2]);

/// The C2 curve of these pieces through the waypoints of one joint, with
/// velocity and acceleration zero at both ends, by one square system in all
/// coefficients. Each piece is written in its own time from 0 to 1 to keep the
/// system solvable for any ratio of durations.
fn dense(parts: &[Part], waypoints: &[f64]) -> Vec<Vec<f64>> {
    let offsets: Vec<usize> = parts
        .iter()
        .scan(0, |next, part| {
            let offset = *next;
            *next += part.1 + 1;
            Some(offset)
        })
        .collect();
    let size: usize = parts.iter().map(|part| part.1 + 1).sum();
    let mut rows: Vec<(DVector<f64>, f64)> = Vec::new();
    let derivative = |part: usize, d: usize, u: f64, factor: f64| {
        let mut row = DVector::zeros(size);
        for k in 0..=parts[part].1 {
            row[offsets[part] + k] = factor * power(k, d, u) / parts[part].0.powi(d as i32);
        }
        row
    };
    for (index, (_, _, ends)) in parts.iter().enumerate() {
        for (end, waypoint) in ends.iter().enumerate() {
            if let Some(waypoint) = waypoint {
                rows.push((derivative(index, 0, end as f64, 1.0), waypoints[*waypoint]));
            }
        }
        if index + 1 < parts.len() {
            for d in usize::from(ends[1].is_some())..=2 {
                let scale = parts[index].0.min(parts[index + 1].0).powi(d as i32);
                let jump = derivative(index, d, 1.0, scale) - derivative(index + 1, d, 0.0, scale);
                rows.push((jump, 0.0));
            }
        }
    }
    let last = parts.len() - 1;
    for d in 1..=2 {
        rows.push((derivative(0, d, 0.0, parts[0].0.powi(d as i32)), 0.0));
        rows.push((derivative(last, d, 1.0, parts[last].0.powi(d as i32)), 0.0));
    }
    assert_eq!(rows.len(), size, "the system is not square");
    let matrix = DMatrix::from_fn(size, size, |row, column| rows[row].0[column]);
    let right = DVector::from_iterator(size, rows.iter().map(|row| row.1));
    let solution = matrix.full_piv_lu().solve(&right).unwrap();
    let piece = |(offset, part): (&usize, &Part)| {
        let own = solution.rows(*offset, part.1 + 1);
        own.iter().enumerate().map(|(k, c)| c / part.0.powi(k as i32)).collect()
    };
    offsets.iter().zip(parts).map(piece).collect()
}

fn parts_434(durations: &[f64]) -> Vec<Part> {
    let last = durations.len() - 1;
    let part = |(segment, h): (usize, &f64)| {
        let degree = if segment == 0 || segment == last { 4 } else { 3 };
        (*h, degree, [Some(segment), Some(segment + 1)])
    };
    durations.iter().enumerate().map(part).collect()
}

fn parts_virtual(durations: &[f64]) -> Vec<Part> {
    let last = durations.len() - 1;
    if last == 0 {
        let h = durations[0];
        return vec![
            (0.25 * h, 3, [Some(0), None]),
            (0.5 * h, 3, [None, None]),
            (0.25 * h, 3, [None, Some(1)]),
        ];
    }
    let split = |(segment, h): (usize, &f64)| {
        let (from, to) = (Some(segment), Some(segment + 1));
        if segment == 0 || segment == last {
            vec![(0.5 * h, 3, [from, None]), (0.5 * h, 3, [None, to])]
        } else {
            vec![(*h, 3, [from, to])]
        }
    };
    durations.iter().enumerate().flat_map(split).collect()
}

/// The O(n) solutions are those of the full systems: `4n + 2` equations for
/// 4-3-4, `4 (n + 2)` with virtual points.
#[test]
fn tridiagonal_solutions_are_the_dense_ones() {
    let mut random = RandomStream::new(41, 0);
    for number in 0..400 {
        for (name, parts_of, least) in [
            ("4-3-4", parts_434 as fn(&[f64]) -> Vec<Part>, 2),
            ("cubic_zero_acceleration", parts_virtual, 1),
        ] {
            let segments = least + number % (7 - least);
            let waypoints = random_waypoints(&mut random, segments, 3);
            let mut durations = random_durations(&mut random, segments);
            if number % 10 == 0 {
                durations[0] *= 1e-3;
                durations[segments / 2] *= 1e3;
            }
            let trajectory = curve(name, &waypoints, &durations);
            let parts = parts_of(&durations);
            assert_eq!(trajectory.pieces.len(), parts.len());
            for joint in 0..3 {
                let xs: Vec<f64> = waypoints.iter().map(|row| row[joint]).collect();
                let expected = dense(&parts, &xs);
                for (piece, expected) in expected.iter().enumerate() {
                    let found = &trajectory.pieces[piece][joint];
                    // What each power contributes by the end of the piece.
                    let h = parts[piece].0;
                    let term = |c: &[f64], k: usize| c.get(k).unwrap_or(&0.0) * h.powi(k as i32);
                    let size = (0..5).map(|k| term(expected, k).abs()).fold(1.0, f64::max);
                    for k in 0..5 {
                        let (found, expected) = (term(found, k), term(expected, k));
                        assert!(
                            (found - expected).abs() <= 1e-8 * size,
                            "{name} {durations:?} piece {piece} u^{k}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}

/// Between the ends both are the same cubics.
#[test]
fn a_quartic_and_a_virtual_point_leave_the_same_cubics() {
    let mut random = RandomStream::new(43, 0);
    let waypoints = random_waypoints(&mut random, 5, 2);
    let durations = random_durations(&mut random, 5);
    let quartic = curve("4-3-4", &waypoints, &durations);
    let split = curve("cubic_zero_acceleration", &waypoints, &durations);
    for piece in 1..4 {
        for joint in 0..2 {
            let (a, b) = (&quartic.pieces[piece][joint], &split.pieces[piece + 1][joint]);
            assert_eq!(a[..4], b[..4]);
            assert_eq!(a[4], 0.0);
        }
    }
}

/// Constant jerk `32 D/h³` in turns: the classic peaks of that motion.
#[test]
fn one_segment_holds_both_virtual_points() {
    let trajectory = curve("cubic_zero_acceleration", &[vec![1.0], vec![4.0]], &[2.0]);
    assert_eq!(trajectory.breakpoints, [0.0, 0.5, 1.5, 2.0]);
    let certificate = Certificate::new(&trajectory, &[bounds(100.0)], &[]);
    let joint = &certificate.joints[0];
    for (peak, expected) in
        [(&joint.velocity, 3.0), (&joint.acceleration, 6.0), (&joint.jerk, 12.0)]
    {
        assert!((peak.peak.unwrap() / expected - 1.0).abs() < 1e-14, "{peak:?}");
    }
}

/// What the registry says of each family, at the waypoints and at the ends.
#[test]
fn every_family_keeps_its_word() {
    for (stream, entry) in INTERPOLATIONS.iter().enumerate() {
        let Timing::Search(_) = entry.timing else { continue };
        let mut random = RandomStream::new(47, stream as u64);
        for number in 0..100 {
            let most = entry.max_segments.unwrap_or(8);
            let segments = entry.min_segments + number % (most - entry.min_segments + 1);
            let waypoints = random_waypoints(&mut random, segments, 10);
            let durations = random_durations(&mut random, segments);
            let trajectory = curve(entry.name, &waypoints, &durations);
            trajectory.validate(10).unwrap();
            let times: Vec<f64> = std::iter::once(0.0)
                .chain(durations.iter().scan(0.0, |t, h| {
                    *t += h;
                    Some(*t)
                }))
                .collect();
            let due: Vec<(f64, &[f64])> =
                times.iter().copied().zip(waypoints.iter().map(Vec::as_slice)).collect();
            let certificate = Certificate::new(&trajectory, &vec![bounds(1.0); 10], &due);
            let what = format!("{} {durations:?}", entry.name);
            // A quintic through durations this uneven swings out far.
            let reach = certificate.joints.iter().map(|j| j.position.max.max(-j.position.min));
            let reach = reach.fold(1.0, f64::max);
            assert!(certificate.waypoint_error.unwrap() < 1e-11 * reach, "{what}");
            assert!(certificate.continuity >= entry.continuity, "{what}");
            assert!(certificate.starts_at_rest && certificate.ends_at_rest, "{what}");
            let finite = certificate.joints.iter().all(|joint| joint.jerk.peak.is_some());
            assert!(finite || !entry.bounded_jerk, "{what}");
            if entry.executable {
                assert!(certificate.joints.iter().all(|j| j.acceleration.peak.is_some()), "{what}");
            }
            assert!(times.iter().all(|t| trajectory.breakpoints.contains(t)), "{what}");
        }
    }
}

/// `s` times the durations: the same path, the d-th derivative over `s^d`.
#[test]
fn every_family_keeps_the_scaling_law() {
    for (stream, entry) in INTERPOLATIONS.iter().enumerate() {
        let Timing::Search(_) = entry.timing else { continue };
        let mut random = RandomStream::new(53, stream as u64);
        for _ in 0..50 {
            let segments = entry.max_segments.unwrap_or(4);
            let waypoints = random_waypoints(&mut random, segments, 2);
            let durations = random_durations(&mut random, segments);
            // A power of two scales without rounding.
            let slower: Vec<f64> = durations.iter().map(|h| 4.0 * h).collect();
            let mut expected = curve(entry.name, &waypoints, &durations);
            expected.stretch(4.0);
            let found = curve(entry.name, &waypoints, &slower);
            assert_eq!(found.breakpoints, expected.breakpoints, "{}", entry.name);
            for (piece, joints) in expected.pieces.iter().enumerate() {
                let h = found.breakpoints[piece + 1] - found.breakpoints[piece];
                for (joint, c) in joints.iter().enumerate() {
                    for (k, c) in c.iter().enumerate() {
                        let off = (found.pieces[piece][joint][k] - c).abs() * h.powi(k as i32);
                        assert!(off < 1e-9, "{} piece {piece} power {k}: {off}", entry.name);
                    }
                }
            }
        }
    }
}

#[test]
fn a_bspline_is_the_clamped_spline() {
    let task = |name: &str| json!({ "interpolation": name });
    let bspline = plan(without_jerk("mcb-ab", task("bspline")));
    let cubic = plan(without_jerk("mcb-ab", task("cubic")));
    assert_eq!(bspline.trajectory, cubic.trajectory);
    assert_eq!(bspline.interpolation, "bspline");
    // Lin and Yang's basis with equal durations is that curve, too.
    let mut random = RandomStream::new(59, 0);
    let waypoints = random_waypoints(&mut random, 6, 3);
    let equal = [0.5; 6];
    assert_eq!(curve("bspline_uniform", &waypoints, &equal), curve("cubic", &waypoints, &[0.5; 6]));
}

/// Positions from the control points and the basis as published (corrected).
#[test]
fn the_uniform_bspline_has_the_published_control_points() {
    let mut random = RandomStream::new(61, 0);
    for segments in 1..9 {
        let m = segments + 1;
        let waypoints = random_waypoints(&mut random, segments, 1);
        let durations = random_durations(&mut random, segments);
        let trajectory = curve("bspline_uniform", &waypoints, &durations);
        // V_0 to V_{m+1}.
        let mut matrix = DMatrix::zeros(m + 2, m + 2);
        let mut right = DVector::zeros(m + 2);
        for i in 1..=m {
            matrix.row_mut(i).columns_mut(i - 1, 3).copy_from_slice(&[1.0, 4.0, 1.0]);
            right[i] = 6.0 * waypoints[i - 1][0];
        }
        (matrix[(0, 0)], matrix[(0, 2)]) = (1.0, -1.0);
        (matrix[(m + 1, m + 1)], matrix[(m + 1, m - 1)]) = (1.0, -1.0);
        let v = matrix.lu().solve(&right).unwrap();
        for (segment, h) in durations.iter().enumerate() {
            for k in 0..=10 {
                let u = f64::from(k) / 10.0;
                let basis = [
                    (1.0 - u).powi(3),
                    3.0 * u.powi(3) - 6.0 * u * u + 4.0,
                    -3.0 * u.powi(3) + 3.0 * u * u + 3.0 * u + 1.0,
                    u.powi(3),
                ];
                let expected: f64 = (0..4).map(|j| v[segment + j] * basis[j] / 6.0).sum();
                let c = &trajectory.pieces[segment][0];
                let found: f64 = (0..4).map(|k| c[k] * (u * h).powi(k as i32)).sum();
                assert!((found - expected).abs() < 1e-12, "{segments} {segment} {u}");
            }
        }
    }
}

/// The job succeeds and the certificate tells what no robot can follow: joint,
/// time and size of the jump. Inside the segments every limit is kept and
/// reached, so nothing was stretched for the jumps' sake.
#[test]
fn a_uniform_bspline_is_planned_and_found_unlawful() {
    for clock in ["shared", "per_joint"] {
        for optimizer in ["exact", "pso"] {
            let task = json!({ "interpolation": "bspline_uniform", "clock": clock,
                "optimizer": { "name": optimizer } });
            let result = plan(without_jerk("mcb-ab", task));
            let certificate = &result.certificate;
            assert!(!certificate.lawful);
            assert_eq!(certificate.continuity, 0);
            assert!(certificate.violations.iter().all(|v| v.value.is_none()));
            assert!(certificate.violations.iter().all(|v| v.limit == "acceleration"));
            // Joint 4 rests: only it has nothing to jump.
            assert_eq!(certificate.violations.len(), 5);
        }
    }
    let result = plan(without_jerk("mcb-ab", json!({ "interpolation": "bspline_uniform" })));
    for violation in &result.certificate.violations {
        let joint = result.joint_names.iter().position(|name| *name == violation.joint).unwrap();
        let jump = |knot: usize| {
            let [before, after] =
                [&result.trajectory.pieces[knot - 1], &result.trajectory.pieces[knot]];
            let h = result.durations[knot - 1];
            let c = &before[joint];
            (c[1] + 2.0 * c[2] * h + 3.0 * c[3] * h * h - after[joint][1]).abs()
        };
        let knot = if jump(1) > jump(2) { 1 } else { 2 };
        assert_eq!(violation.at, result.waypoint_times[knot]);
        let words = format!(
            "{} acceleration is infinite at {:.6} s, where velocity jumps by {:.6} rad/s",
            violation.joint,
            violation.at,
            jump(knot)
        );
        assert!(violation.detail.starts_with(&words), "{} {words}", violation.detail);
    }
    // Each segment is as short as its own limits allow, whatever the others do.
    let Timing::Search(kernel) = interpolation("bspline_uniform").unwrap().timing else {
        panic!("bspline_uniform is searched");
    };
    let limits: Vec<KernelLimits> = result
        .certificate
        .joints
        .iter()
        .map(|joint| KernelLimits {
            derivatives: [
                joint.velocity.limit.unwrap(),
                joint.acceleration.limit.unwrap(),
                f64::INFINITY,
            ],
            position: UNIT.position,
        })
        .collect();
    let lanes = takt::trajectory::kernel::JointLanes::new(&result.waypoints, &limits);
    let mut work = kernel.workspace(&lanes);
    kernel.ratios(&lanes, &result.durations, &mut work);
    for segment in 0..3 {
        let [velocity, acceleration, _] = work.segment_ratios(&lanes, segment);
        let worst = velocity.max(acceleration.sqrt());
        assert!((1.0 - 1e-4..=1.0 + 1e-9).contains(&worst), "segment {segment}: {worst}");
    }
}

/// A position beyond its limit is no jump: no plan is delivered.
#[test]
fn a_uniform_bspline_keeps_position_limits() {
    let robot = json!({ "name": "axis", "joints": [{ "name": "x", "type": "prismatic", "limits":
        { "lower": 0.0, "upper": 1.0, "velocity": 1.0, "acceleration": 4.0 } }] });
    let task = json!({ "type": "waypoints", "interpolation": "bspline_uniform",
        "waypoints": [[0.0], [0.99], [0.98], [0.2]] });
    let error = try_plan(json!({ "robot": &robot, "task": task })).unwrap_err();
    assert_eq!(error.code.as_str(), "limits_unreachable");
    let task = json!({ "type": "waypoints", "interpolation": "bspline_uniform",
        "waypoints": [[0.0], [0.7], [0.6], [0.2]] });
    assert!(!plan(json!({ "robot": robot, "task": task })).certificate.lawful);
}

#[test]
fn too_few_waypoints_are_told_with_a_way_out() {
    let mut request = scenario("mcb-ab", json!({ "interpolation": "4-3-4" }));
    request["task"]["waypoints"].as_array_mut().unwrap().truncate(2);
    let found = faults(request).to_string();
    assert!(found.contains("4-3-4 takes at least 3 waypoints, not 2; quintic"), "{found}");
}
