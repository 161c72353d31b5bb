//! The limit of the tool's speed: its proven peak, and plans that keep it.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde_json::{Value, json};
use takt::robot::{Robot, catalogue};
use takt::trajectory::{TcpLimit, TcpPeak, Trajectory};

use crate::support::{faults, merge, plan, scenario, timeless, try_plan};

fn inline(value: Value) -> Robot {
    Robot::new(serde_json::from_value(value).unwrap()).unwrap()
}

fn peak(robot: &Robot, trajectory: &Trajectory, speed: f64) -> TcpPeak {
    TcpLimit { kinematics: robot.kinematics().unwrap(), speed }.peak(trajectory)
}

/// The distance the tool moves around `t`, over time, from forward kinematics alone.
fn speed_by_differences(robot: &Robot, trajectory: &Trajectory, t: f64) -> f64 {
    let step = 1e-6 * trajectory.duration();
    let tool = |t: f64| {
        let (piece, local) = trajectory.locate(t);
        let value = |c: &Vec<f64>| c.iter().rev().fold(0.0, |sum, c| sum * local + c);
        let joints: Vec<f64> = trajectory.pieces[piece].iter().map(value).collect();
        robot.kinematics().unwrap().tool_pose(&joints).position
    };
    let (before, after) = (tool(t - step), tool(t + step));
    let way: f64 = before.iter().zip(after).map(|(a, b)| (b - a) * (b - a)).sum();
    way.sqrt() / (2.0 * step)
}

/// Random quintic pieces that meet in position only.
fn random_trajectory(dof: usize, random: &mut Xoshiro256PlusPlus) -> Trajectory {
    let mut number = |size: f64| {
        let unit = (random.next_u64() >> 11) as f64 * (-53_f64).exp2();
        size * (2.0 * unit - 1.0)
    };
    let mut breakpoints = vec![0.0];
    let mut pieces = Vec::new();
    let mut position: Vec<f64> = (0..dof).map(|_| number(1.5)).collect();
    for _ in 0..3 {
        let length = 0.6 + number(0.4);
        let joint = |x: &mut f64| {
            let mut coefficients = vec![*x];
            coefficients.extend((0..5).map(|_| number(1.0)));
            *x = coefficients.iter().rev().fold(0.0, |sum, c| sum * length + c);
            coefficients
        };
        pieces.push(position.iter_mut().map(joint).collect());
        breakpoints.push(breakpoints.last().unwrap() + length);
    }
    Trajectory { breakpoints, pieces }
}

/// No sample is above the upper value, the lower one is a speed that is reached, and both are close.
#[test]
fn the_peak_holds_against_dense_sampling() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
    let mut robots = 0;
    for robot in catalogue::all().iter().filter(|robot| robot.kinematics().is_some()) {
        robots += 1;
        for _ in 0..3 {
            let trajectory = random_trajectory(robot.dof(), &mut random);
            let found = peak(robot, &trajectory, 0.1);
            assert!(found.upper >= found.lower);
            assert!(found.upper - found.lower <= 1.001e-6 * found.lower.max(0.1), "{found:?}");
            let samples = (1..2000).map(|k| f64::from(k) / 2000.0 * trajectory.duration());
            let highest = samples
                .filter(|t| trajectory.breakpoints.iter().all(|b| (t - b).abs() > 1e-4))
                .map(|t| speed_by_differences(robot, &trajectory, t))
                .fold(0.0, f64::max);
            assert!(highest <= found.upper * (1.0 + 1e-7), "{}: {highest} {found:?}", robot.name());
            assert!(highest >= 0.98 * found.lower, "{}: {highest} {found:?}", robot.name());
            let at = found.at.clamp(1e-5, trajectory.duration() - 1e-5);
            let near_breakpoint = trajectory.breakpoints.iter().any(|b| (at - b).abs() < 1e-4);
            if !near_breakpoint {
                let there = speed_by_differences(robot, &trajectory, at);
                assert!((there / found.lower - 1.0).abs() < 1e-5, "{there} {found:?}");
            }
        }
    }
    assert!(robots >= 5, "only {robots} robots have kinematics");
}

fn one_joint(kind: &str, row: Value) -> Value {
    json!({"joints": [{"name": "j", "type": kind,
            "limits": {"velocity": 2.0, "acceleration": 5.0, "jerk": 50.0}}],
        "kinematics": {"convention": "standard_dh", "rows": [row]}})
}

/// The tool of a single turning joint moves at radius times angular velocity, that of a sliding one as it slides.
#[test]
fn one_joint_moves_its_tool_in_closed_form() {
    // 0.3 + 2 t³ - t⁴: the velocity 6 t² - 4 t³ has its peak of 2 at t = 1.
    let coefficients = vec![0.3, 0.0, 0.0, 2.0, -1.0];
    let trajectory =
        Trajectory { breakpoints: vec![0.0, 1.4], pieces: vec![vec![coefficients.clone()]] };
    for (kind, factor) in [("revolute", 0.7), ("prismatic", 1.0)] {
        let robot = inline(one_joint(kind, json!({"a": 0.7, "d": 0.2})));
        let found = peak(&robot, &trajectory, 1.0);
        assert!((found.lower - 2.0 * factor).abs() < 2e-6 * factor, "{kind}: {found:?}");
        assert!(found.upper >= 2.0 * factor * (1.0 - 1e-15), "{kind}: {found:?}");
        assert!((found.at - 1.0).abs() < 2e-3, "{kind}: {found:?}");
    }
    // A speed that never changes is known as closely.
    let steady = Trajectory { breakpoints: vec![0.0, 9.0], pieces: vec![vec![vec![0.0, 0.5]]] };
    let robot = inline(one_joint("revolute", json!({"a": 0.7})));
    let found = peak(&robot, &steady, 1.0);
    assert!((found.upper - 0.35).abs() < 1e-6 && found.lower <= found.upper, "{found:?}");
}

/// Twice as slow is half as fast.
#[test]
fn speed_scales_with_time() {
    let robot = catalogue::get("ur5e").unwrap();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let trajectory = random_trajectory(robot.dof(), &mut random);
    let before = peak(&robot, &trajectory, 0.1);
    let mut slow = trajectory.clone();
    slow.stretch(3.7);
    let after = peak(&robot, &slow, 0.01);
    assert!((after.upper * 3.7 / before.upper - 1.0).abs() < 1e-12, "{before:?} {after:?}");
    assert!((after.at / 3.7 / before.at - 1.0).abs() < 1e-9, "{before:?} {after:?}");
}

fn request(robot: &str, interpolation: &str, speed: Option<f64>) -> Value {
    let waypoints = json!([
        [0.0, -1.2, 1.2, 0.0, 0.5, 0.0],
        [0.6, -1.0, 1.0, 0.3, 0.7, 0.4],
        [1.0, -0.7, 0.6, 0.2, 0.9, 1.0],
        [1.1, -0.6, 0.5, 0.2, 0.9, 1.1]
    ]);
    json!({"robot": robot, "limits": {"tcp_speed": speed},
        "task": {"type": "waypoints", "waypoints": waypoints, "interpolation": interpolation}})
}

fn with_ur5e(interpolation: &str, speed: Option<f64>) -> Value {
    let mut request = request("ur5e", interpolation, speed);
    let jerk = if interpolation == "trapezoidal" { json!(null) } else { json!(80.0) };
    merge(&mut request, json!({"limits": {"acceleration": 8.0}}));
    request["limits"]["jerk"] = jerk;
    request
}

/// Whatever the curve, the plan keeps the limit, uses it, and tells what that costs.
#[test]
fn plans_keep_the_limit() {
    for interpolation in ["quintic", "trapezoidal", "jerk_limited"] {
        let fast = plan(with_ur5e(interpolation, None));
        assert_eq!(fast.certificate.tcp_speed, None);
        assert_eq!(fast.metrics.without_tcp_limit, None);
        let slow = plan(with_ur5e(interpolation, Some(0.25)));
        let certificate = &slow.certificate;
        assert!(certificate.lawful, "{interpolation}: {:?}", certificate.violations);
        let tcp = certificate.tcp_speed.as_ref().unwrap();
        let peak = tcp.peak.unwrap();
        assert!(peak <= 0.25 * (1.0 + 1e-9) && peak > 0.2499, "{interpolation}: {tcp:?}");
        assert_eq!(tcp.limit, Some(0.25));
        assert!((certificate.worst_ratio - tcp.ratio.unwrap()).abs() < 1e-3);
        assert!(slow.duration > 1.5 * fast.duration, "{interpolation}: {}", slow.duration);
        assert_eq!(slow.metrics.without_tcp_limit, Some(fast.duration), "{interpolation}");
        assert!(slow.metrics.binding.iter().any(|it| it.limit == "tcp_speed"));
        let gap = slow.bound.as_ref().unwrap().gap;
        let own = slow.duration / slow.bound.as_ref().unwrap().lower - 1.0;
        assert!((gap - own).abs() < 1e-9, "the gap is told as it is");
        // A limit that is not reached changes nothing but what is said about it.
        let free = plan(with_ur5e(interpolation, Some(50.0)));
        assert_eq!(free.trajectory, fast.trajectory, "{interpolation}");
        assert!(free.certificate.tcp_speed.as_ref().unwrap().ratio.unwrap() < 0.1);
    }
}

/// A wish for the duration that only the tool's limit forbids is refused because of it.
#[test]
fn goals_follow() {
    let slow = plan(with_ur5e("quintic", Some(0.25))).duration;
    let mut request = with_ur5e("quintic", Some(0.25));
    for goal in ["exactly", "at_most"] {
        merge(&mut request, json!({"task": {"duration": null}}));
        request["task"]["duration"] = json!({goal: 0.9 * slow});
        let error = try_plan(request.clone()).unwrap_err();
        assert_eq!(error.code.as_str(), "limits_unreachable");
        assert!(error.message.contains("without the tcp speed limit of 0.25 m/s"), "{error}");
        assert!(error.details["without_tcp_limit"].as_f64().unwrap() < 0.9 * slow);
    }
    request["task"]["duration"] = json!({"exactly": 1.2 * slow});
    let longer = plan(request);
    assert_eq!(longer.duration, 1.2 * slow);
    let ratio = longer.certificate.tcp_speed.unwrap().ratio.unwrap();
    assert!((ratio - 1.0 / 1.2).abs() < 1e-5, "{ratio}");
}

/// Durations that are given are kept, and refused in words.
#[test]
fn given_durations_are_judged() {
    let mut request = with_ur5e("quintic", Some(0.25));
    request["task"]["fixed_durations"] = json!([2.0, 2.0, 2.0]);
    let error = try_plan(request).unwrap_err();
    assert!(error.message.contains("tcp speed reaches 0."), "{error}");
    assert!(error.message.contains("above its limit of 0.25 m/s"), "{error}");
}

#[test]
fn what_cannot_be_limited_is_refused() {
    let pointer = "/limits/tcp_speed";
    for speed in [0.0, -0.1, 1e13] {
        let found = faults(with_ur5e("quintic", Some(speed)));
        assert_eq!(found.0.len(), 1, "{found}");
        assert_eq!(found.0[0].pointer, pointer);
        assert!(found.0[0].detail.contains("not a positive number"), "{found}");
    }
    // JSON holds no such numbers; other doors may let them in.
    for speed in [f64::NAN, f64::INFINITY] {
        let mut request = takt::plan::PlanRequest::parse(with_ur5e("quintic", None)).unwrap();
        request.limits.as_mut().unwrap().tcp_speed = Some(speed);
        let Err(found) = takt::plan::validate(&request, &catalogue::get) else {
            panic!("{speed} is taken");
        };
        assert_eq!(found.0[0].pointer, pointer);
    }
    let mut request = scenario("mcb-ab", json!({}));
    request["robot"] = json!({"name": "bare", "joints": (0..6).map(|index|
        json!({"name": format!("j{index}"), "type": "revolute"})).collect::<Vec<_>>()});
    merge(
        &mut request,
        json!({"limits": {"velocity": 1.0, "acceleration": 2.0, "jerk": 9.0, "tcp_speed": 0.25}}),
    );
    let found = faults(request);
    let detail = &found.0.iter().find(|fault| fault.pointer == pointer).unwrap().detail;
    assert!(detail.contains("bare has no kinematics"), "{detail}");
    let mut request = with_ur5e("quintic", Some(0.25));
    request["task"]["pareto"] = json!({"objectives": ["time", "energy"]});
    assert_eq!(faults(request).0[0].pointer, "/task/pareto");
    let mut request = with_ur5e("quintic", Some(0.25));
    request["task"] = json!({"type": "comparison", "task": request["task"], "methods": ["exact"]});
    assert_eq!(faults(request).0[0].pointer, pointer);
}

/// Same bytes on any number of threads.
#[test]
fn threads_change_nothing() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| timeless(&plan(with_ur5e("jerk_limited", Some(0.25)))))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(8));
}

/// A sweep over the limit is planned member by member, with "none" among the values.
#[test]
fn a_family_sweeps_over_the_limit() {
    let mut request = with_ur5e("quintic", None);
    let limits = request["limits"].take();
    request["limits"] = json!({"acceleration": limits["acceleration"], "jerk": limits["jerk"]});
    request["task"] = json!({"type": "family", "problem": {"task": request["task"]},
        "sweep": [{"path": "/limits/tcp_speed", "values": [0.1, 0.25, null]}]});
    let request = takt::plan::PlanRequest::parse(request).unwrap();
    let plan = takt::plan::validate(&request, &catalogue::get).unwrap_or_else(|it| panic!("{it}"));
    let result = plan.run(&takt::budget::Budget::default(), &|_| {}).unwrap();
    let takt::plan::PlanResult::Family(family) = result else { panic!("a family") };
    let durations: Vec<f64> = family.members.iter().map(|it| it.duration.unwrap()).collect();
    assert!((durations[0] / durations[1] - 2.5).abs() < 1e-5, "{durations:?}");
    assert!(durations[2] < durations[1], "{durations:?}");
    assert_eq!(family.members[0].most_binding.as_ref().unwrap().limit, "tcp_speed");
}

/// Anyone's trajectory is held to the limit, and what exceeds it is told in words.
#[test]
fn verification_takes_the_limit() {
    let fast = plan(with_ur5e("quintic", None));
    let verify = |robot: Value, limits: Value, trajectory: &Value| {
        let request = json!({"robot": robot, "limits": limits, "trajectory": trajectory});
        let request = takt::plan::verify::VerifyRequest::parse(request).unwrap();
        takt::plan::verify::verify(&request, &catalogue::get)
    };
    let trajectory = serde_json::to_value(&fast.trajectory).unwrap();
    let limits = json!({"tcp_speed": 0.25, "acceleration": 8.0, "jerk": 80.0});
    let found = verify(json!("ur5e"), limits, &trajectory).unwrap();
    let tcp = found.tcp_speed.as_ref().unwrap();
    assert!(!found.lawful && tcp.ratio.unwrap() > 1.0 && found.worst_ratio == tcp.ratio.unwrap());
    assert_eq!((found.violations.len(), found.violations[0].joint.as_str()), (1, "tcp"));
    let detail = &found.violations[0].detail;
    assert!(detail.ends_with("s, above its limit of 0.25 m/s"), "{detail}");
    // A joint that jumps takes the tool along.
    let jump = json!({"breakpoints": [0.0, 1.0, 2.0], "pieces": [[[0.0, 0.1]], [[0.5, 0.1]]]});
    let robot = one_joint("revolute", json!({"a": 0.7}));
    let found = verify(robot, json!({"tcp_speed": 0.25}), &jump).unwrap();
    let tcp = found.tcp_speed.unwrap();
    assert_eq!((tcp.peak, tcp.ratio, tcp.at), (None, None, 1.0));
    assert!(found.violations.iter().any(|it| it.limit == "tcp_speed" && it.value.is_none()));
}

/// The fastest of all motions is slowed down where the tool is too fast, and not everywhere.
#[test]
fn only_fast_segments_are_slowed_down() {
    let robot = catalogue::get("ur5e").unwrap();
    let fast = plan(with_ur5e("jerk_limited", None));
    let highest = peak(&robot, &fast.trajectory, 0.25).upper;
    for limit in [0.9 * highest, 0.7 * highest, 0.25] {
        let slow = plan(with_ur5e("jerk_limited", Some(limit)));
        assert!(slow.certificate.lawful, "{:?}", slow.certificate.violations);
        let uniform = fast.duration * highest / limit;
        assert!(slow.duration < 0.97 * uniform, "{limit}: {} of {uniform}", slow.duration);
        assert!(slow.duration > fast.duration);
        assert!(slow.metrics.sensitivities.is_empty());
        let lower = |result: &takt::plan::TrajectoryResult| result.bound.as_ref().unwrap().lower;
        assert_eq!(lower(&slow), lower(&fast), "the bound leaves the tool out");
    }
}

/// Lower speeds hold in their segments only; without any, nothing changes.
#[test]
fn speeds_by_segment_are_kept() {
    use takt::budget::Budget;
    use takt::trajectory::jerk_limited::{Demand, fastest, fastest_at_speeds};
    use takt::trajectory::kernel::KernelLimits;
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let limit = KernelLimits { derivatives: [1.0, 4.0, 40.0], position: free };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(6);
    // Longer than a window.
    let count = 25;
    let mut number = || (random.next_u64() >> 11) as f64 * (-53_f64).exp2();
    let waypoints: Vec<Vec<f64>> = (0..count).map(|_| vec![number(), 2.0 * number()]).collect();
    let limits = [limit; 2];
    let unlimited = fastest(&waypoints, &limits);
    let demand = |speeds| Demand { speeds, ..Demand::new(&waypoints, &limits) };
    let same = vec![vec![f64::INFINITY; 2]; count - 1];
    let found = fastest_at_speeds(&demand(&same), &Budget::default());
    let gap = found.durations.iter().sum::<f64>() / unlimited.durations.iter().sum::<f64>();
    assert!((gap - 1.0).abs() < 0.02, "{gap}");
    let slow = |segment: usize| if segment % 3 == 1 { 0.3 } else { f64::INFINITY };
    let speeds: Vec<Vec<f64>> = (0..count - 1).map(|it| vec![slow(it), 2.0 * slow(it)]).collect();
    let found = fastest_at_speeds(&demand(&speeds), &Budget::default());
    assert!(found.converged && !found.stops);
    let mut state = takt::trajectory::KinematicState::new(2);
    let mut highest = vec![[0.0f64; 2]; count - 1];
    for (segment, ends) in found.times.windows(2).enumerate() {
        for k in 0..=200 {
            let t = ends[0] + (ends[1] - ends[0]) * f64::from(k) / 200.0;
            found.trajectory.sample(t, &mut state);
            for (highest, velocity) in highest[segment].iter_mut().zip(&state.velocity) {
                *highest = highest.max(velocity.abs());
            }
        }
    }
    for (segment, peaks) in highest.iter().enumerate() {
        for (peak, limit) in peaks.iter().zip(&speeds[segment]) {
            assert!(*peak <= limit.min(1.0) * (1.0 + 1e-9), "segment {segment}: {peak} {limit}");
        }
    }
    let slowest = highest.iter().enumerate().filter(|(segment, _)| segment % 3 == 1);
    assert!(slowest.clone().any(|(_, peaks)| peaks[0] > 0.299 || peaks[1] > 0.599));
    assert!(highest.iter().flatten().any(|peak| *peak > 0.9), "others go faster");
}
