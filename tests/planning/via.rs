//! A tolerance at inner waypoints: what it saves, what it may not touch, and that the bound knows it.

use serde_json::{Value, json};
use takt::budget::Budget;
use takt::math::random::RandomStream;
use takt::plan::verify::{VerifyRequest, verify};
use takt::robot::catalogue;
use takt::trajectory::jerk_limited::{Demand, Fastest, fastest, fastest_between, fastest_within};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{
    Certificate, Ends, KinematicState, Prices, Room, Rooms, lower_bound, rooms,
};

use crate::jerk_limited::{bounds, nasty};
use crate::support::{faults, plan, scenario};

/// The fastest motion through `rooms` at `waypoints`.
fn through(waypoints: &[Vec<f64>], limits: &[KernelLimits], table: &[Vec<Room>]) -> Fastest {
    let demand = Demand { rooms: Rooms::new(table), ..Demand::new(waypoints, limits) };
    fastest_within(&demand, &Budget::default(), &mut |_| {})
}

/// By how much each joint deviates from each waypoint at its time.
fn deviations(waypoints: &[Vec<f64>], found: &Fastest) -> Vec<Vec<f64>> {
    let mut state = KinematicState::new(waypoints[0].len());
    let mut row = |(t, waypoint): (&f64, &Vec<f64>)| {
        found.trajectory.sample(*t, &mut state);
        state.position.iter().zip(waypoint).map(|(reached, wanted)| reached - wanted).collect()
    };
    found.times.iter().zip(waypoints).map(&mut row).collect()
}

/// What is wrong with a motion through rooms, if anything.
fn fault(
    waypoints: &[Vec<f64>],
    limits: &[KernelLimits],
    table: &[Vec<Room>],
    found: &Fastest,
) -> Option<String> {
    if let Err(error) = found.trajectory.validate(limits.len()) {
        return Some(error.to_string());
    }
    let certificate = Certificate::new(&found.trajectory, &bounds(limits), &[]);
    if !certificate.lawful || !certificate.starts_at_rest || !certificate.ends_at_rest {
        return Some(format!("{:?}", certificate.violations));
    }
    let rooms = Rooms::new(table);
    for (at, row) in deviations(waypoints, found).iter().enumerate() {
        for (joint, deviation) in row.iter().enumerate() {
            let [lower, upper] = rooms.of(at, joint);
            if !(lower - 1e-11..=upper + 1e-11).contains(deviation) {
                return Some(format!("deviates by {deviation} at {at}, joint {joint}"));
            }
        }
    }
    let duration = found.trajectory.duration();
    (found.lower > duration).then(|| format!("{duration} is below the bound {}", found.lower))
}

fn mcb(tolerance: Value) -> Value {
    scenario("mcb-ab-fastest", json!({ "via_tolerance": tolerance }))
}

/// The problem of the paper: 4.879 s through its waypoints, 4.673 s within 0.05 rad of them.
#[test]
fn a_tolerance_of_a_twentieth_saves_four_percent() {
    let exact = plan(scenario("mcb-ab-fastest", json!({})));
    let result = plan(mcb(json!(0.05)));
    assert!((4.66..4.68).contains(&result.duration), "{}", result.duration);
    let certificate = &result.certificate;
    assert!(certificate.lawful, "{:?}", certificate.violations);
    assert_eq!(certificate.via_tolerance, Some(vec![0.05; 6]));
    let error = certificate.waypoint_error.unwrap();
    assert!((0.049..=0.05).contains(&error), "{error}");
    let mut state = KinematicState::new(6);
    for (at, (t, waypoint)) in result.waypoint_times.iter().zip(&result.waypoints).enumerate() {
        result.trajectory.sample(*t, &mut state);
        let misses = state.position.iter().zip(waypoint).map(|(x, w)| (x - w).abs());
        let largest = misses.fold(0.0, f64::max);
        let inner = at > 0 && at < 3;
        assert!(
            if inner { (0.04..=0.05).contains(&largest) } else { largest < 1e-12 },
            "{at}: {largest}"
        );
    }
    assert_eq!(result.waypoints, exact.waypoints, "what was asked for is told as it was");
    let bound = result.bound.unwrap();
    assert!(bound.lower <= result.duration && bound.gap < 0.003, "{bound:?}");
    // The multipliers still tell all of the time: it scales with the limits.
    let share = |limit: &str| {
        1.0 + f64::from(u8::from(limit != "velocity")) + f64::from(u8::from(limit == "jerk"))
    };
    let all = result.metrics.sensitivities.iter();
    let sum: f64 = all.map(|it| 100.0 * share(&it.limit) * it.seconds_per_percent).sum();
    assert!((sum / result.duration - 1.0).abs() < 2e-3, "{sum} of {}", result.duration);
}

/// More room never takes longer, and none at all is a plan without a tolerance to the bit.
#[test]
fn more_room_is_never_slower_and_none_changes_nothing() {
    let exact = plan(scenario("mcb-ab-fastest", json!({})));
    let none = plan(mcb(json!(0)));
    assert_eq!(none.certificate.via_tolerance, Some(vec![0.0; 6]));
    assert_eq!(none.certificate.sha256, exact.certificate.sha256);
    assert_eq!(none.bound, exact.bound);
    let mut before = exact.duration;
    for tolerance in [1e-9, 1e-4, 1e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 1.0, 1e9] {
        let result = plan(mcb(json!(tolerance)));
        assert!(result.certificate.lawful, "{tolerance}: {:?}", result.certificate.violations);
        assert!(result.duration <= before * (1.0 + 1e-5), "{tolerance}: {}", result.duration);
        assert!(result.bound.unwrap().lower <= result.duration, "{tolerance}");
        before = result.duration;
    }
    // With so much room only the ends are left, and the slowest joint's way between them.
    assert!((before - 3.68166).abs() < 1e-4, "{before}");
}

/// Joints of a robot have tolerances of their own, and one without any meets its waypoints.
#[test]
fn a_joint_without_tolerance_is_exact() {
    let tolerance = [0.05, 0.0, 0.02, 0.0, 0.05, 0.0];
    let result = plan(mcb(json!(tolerance)));
    assert!(result.certificate.lawful);
    assert!(result.duration < plan(scenario("mcb-ab-fastest", json!({}))).duration + 1e-9);
    let mut state = KinematicState::new(6);
    for (t, waypoint) in result.waypoint_times.iter().zip(&result.waypoints) {
        result.trajectory.sample(*t, &mut state);
        for (joint, (reached, wanted)) in state.position.iter().zip(waypoint).enumerate() {
            let miss = (reached - wanted).abs();
            assert!(miss <= tolerance[joint] + 1e-12, "joint {joint}: {miss}");
        }
    }
}

/// Near a position limit there is less room on one side.
#[test]
fn rooms_end_at_the_position_limits() {
    let waypoints = vec![vec![0.0, 0.0], vec![0.98, 1.0], vec![0.0, 2.0]];
    let limits = [[0.0, 1.0], [0.0, 2.0]]
        .map(|position| KernelLimits { derivatives: [1.0, 2.0, 10.0], position });
    let table = rooms(&waypoints, &limits, &[0.05; 2]);
    let [lower, upper] = table[1][0];
    assert!(lower == -0.05 && (upper - 0.02).abs() < 1e-12, "{table:?}");
    assert_eq!((table[0][1], table[2][1]), ([0.0, 0.05], [-0.05, 0.0]), "the ends lie on a limit");
    let found = through(&waypoints, &limits, &table);
    assert_eq!(fault(&waypoints, &limits, &table, &found), None);
    let certificate = Certificate::new(&found.trajectory, &bounds(&limits), &[]);
    let [turn, last] = [0, 1].map(|joint| certificate.joints[joint].position.max);
    assert!((0.93..=1.0 + 1e-9).contains(&turn) && last <= 2.0 + 1e-9, "{turn} {last}");
    let exact = fastest(&waypoints, &limits).trajectory.duration();
    let duration = found.trajectory.duration();
    assert!(duration < 0.98 * exact, "{duration} {exact}");
}

/// Random problems with rooms of every size: lawful, no slower than through the waypoints themselves up to what a
/// programme leaves, never below the bound, and close to it.
#[test]
fn random_problems_gain_and_never_pass_their_bound() {
    let mut gaps = Vec::new();
    let mut gain = 0.0;
    for seed in 0..48 {
        let (waypoints, limits) = nasty(seed);
        let mut random = RandomStream::new(23, seed);
        let mut tolerance =
            || if random.unit() < 0.2 { 0.0 } else { 10f64.powf(random.uniform(-3.0, -0.5)) };
        let tolerance: Vec<f64> = limits.iter().map(|_| tolerance()).collect();
        let table = rooms(&waypoints, &limits, &tolerance);
        let found = through(&waypoints, &limits, &table);
        assert_eq!(fault(&waypoints, &limits, &table, &found), None, "{seed}");
        let (duration, exact) = (found.trajectory.duration(), fastest(&waypoints, &limits));
        let exact = exact.trajectory.duration();
        assert!(duration <= exact * (1.0 + 1e-4), "{seed}: {duration}, but {exact} exactly");
        gain += 1.0 - duration / exact;
        gaps.push(duration / found.lower - 1.0);
    }
    gaps.sort_by(f64::total_cmp);
    assert!(gaps[gaps.len() / 2] < 0.015, "{gaps:?}");
    assert!(gain > 48.0 * 0.03, "{gain}");
}

/// Attack on the bound: no prices, however wrong, may prove more than a plan needs that meets points
/// within the rooms exactly, nor than one in smaller rooms.
#[test]
fn no_bound_with_rooms_passes_a_lawful_motion_within_them() {
    let mut close = 0;
    for seed in (0..60).filter(|seed| (3..8).contains(&nasty(*seed).0.len())) {
        let (waypoints, limits) = nasty(seed);
        let mut random = RandomStream::new(29, seed);
        let size = 10f64.powf(random.uniform(-3.0, 0.0));
        let table = rooms(&waypoints, &limits, &vec![size; limits.len()]);
        let found = through(&waypoints, &limits, &table);
        let mut moved = waypoints.clone();
        let inner = 1..waypoints.len() - 1;
        moved[inner].iter_mut().flatten().for_each(|x| *x += size * random.uniform(-1.0, 1.0));
        let smaller = rooms(&waypoints, &limits, &vec![0.3 * size; limits.len()]);
        let others = [fastest(&moved, &limits), through(&waypoints, &limits, &smaller)];
        let shortest = others.iter().chain([&found]).map(|found| found.trajectory.duration());
        let shortest = shortest.fold(f64::INFINITY, f64::min);
        let way =
            |pair: &[Vec<f64>]| pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect();
        let ways: Vec<Vec<f64>> = waypoints.windows(2).map(way).collect();
        let rows: Vec<[f64; 3]> = limits.iter().map(|limit| limit.derivatives).collect();
        for wrong in [0.0, 0.02, 0.3, 3.0, 100.0] {
            let mut price = |p: f64| p * (1.0 + wrong * random.uniform(-1.0, 1.0));
            let prices: Prices = found
                .prices
                .iter()
                .map(|row| row.iter().map(|prices| prices.map(&mut price)).collect())
                .collect();
            let bound = lower_bound(&ways, &rows, Rooms::new(&table), &found.durations, &prices);
            assert!(bound <= shortest * (1.0 + 1e-9), "{seed} {wrong}: {bound} > {shortest}");
            close += usize::from(wrong > 0.0 && bound > 0.95 * shortest);
        }
    }
    assert!(close > 15, "only {close} bounds with wrong prices are near enough to test anything");
}

/// Windows of a long list join where they deviate.
#[test]
fn long_lists_deviate_all_along() {
    let mut random = RandomStream::new(7, 1);
    let waypoints: Vec<Vec<f64>> =
        (0..50).map(|_| (0..3).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let position = [f64::NEG_INFINITY, f64::INFINITY];
    let limits = vec![KernelLimits { derivatives: [2.0, 6.0, 40.0], position }; 3];
    let table = rooms(&waypoints, &limits, &[0.05; 3]);
    let found = through(&waypoints, &limits, &table);
    assert_eq!(fault(&waypoints, &limits, &table, &found), None);
    let exact = fastest(&waypoints, &limits).trajectory.duration();
    assert!(found.trajectory.duration() < 0.97 * exact && found.converged);
    let deviations = deviations(&waypoints, &found);
    let deviates = |row: &Vec<f64>| row.iter().any(|x| x.abs() > 0.045);
    assert!(deviations[1..49].iter().filter(|row| deviates(row)).count() > 40, "{deviations:?}");
}

/// Waypoints so dense that the rooms of many overlap: segments may vanish, and the motion stays lawful.
#[test]
fn overlapping_rooms_stay_lawful() {
    for count in [5, 12, 40] {
        let along = |at: usize| f64::from(at as u32) / f64::from(count as u32 - 1);
        let waypoints: Vec<Vec<f64>> = (0..count)
            .map(|at| vec![along(at), libm::sin(3.0 * along(at)), 0.01 * f64::from(at as u32 % 2)])
            .collect();
        let position = [f64::NEG_INFINITY, f64::INFINITY];
        let limits = vec![KernelLimits { derivatives: [1.0, 4.0, 30.0], position }; 3];
        let table = rooms(&waypoints, &limits, &[0.1; 3]);
        let found = through(&waypoints, &limits, &table);
        assert_eq!(fault(&waypoints, &limits, &table, &found), None, "{count}");
        let exact = fastest(&waypoints, &limits).trajectory.duration();
        let saved = 1.0 - found.trajectory.duration() / exact;
        assert!(saved > 0.03, "{count}: {saved}");
    }
}

/// With ends in motion a short list may miss its waypoints too; its ends stay as they are.
#[test]
fn motions_that_start_at_speed_may_deviate() {
    let waypoints = vec![vec![0.0, 0.0], vec![0.6, 0.3], vec![0.9, 1.0], vec![0.4, 1.4]];
    let position = [f64::NEG_INFINITY, f64::INFINITY];
    let limits = vec![KernelLimits { derivatives: [1.0, 2.0, 10.0], position }; 2];
    let ends = Ends { start: vec![[0.5, 0.0], [0.2, 0.1]], goal: vec![[0.0; 2]; 2] };
    let table = rooms(&waypoints, &limits, &[0.05; 2]);
    let [exact, found] = [Rooms::none(), Rooms::new(&table)].map(|rooms| {
        let demand = Demand { rooms, ends: Some(&ends), ..Demand::new(&waypoints, &limits) };
        fastest_between(&demand, &Budget::default(), &mut |_| {}).unwrap()
    });
    let certificate = Certificate::joined(&found.trajectory, &bounds(&limits), &[], Some(&ends));
    assert!(certificate.lawful, "{:?}", certificate.violations);
    let largest = |row: &Vec<f64>| row.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let misses: Vec<f64> = deviations(&waypoints, &found).iter().map(largest).collect();
    assert!(misses[0] < 1e-12 && misses[3] < 1e-9, "{misses:?}");
    assert!(misses[1..3].iter().all(|miss| *miss <= 0.05 + 1e-12), "{misses:?}");
    assert!(found.trajectory.duration() < 0.99 * exact.trajectory.duration());
}

/// The tool's limit and a tolerance hold together.
#[test]
fn a_limited_tool_speed_keeps_the_tolerance() {
    let request = |tolerance: Value| {
        json!({ "robot": "ur5e", "limits": { "tcp_speed": 0.25, "acceleration": 8, "jerk": 80 },
            "task": { "type": "waypoints", "interpolation": "jerk_limited", "via_tolerance": tolerance,
                "waypoints": [[0, -1.2, 1.2, 0, 0.5, 0], [0.6, -1, 1, 0.3, 0.7, 0.4],
                    [1, -0.7, 0.6, 0.2, 0.9, 1]] } })
    };
    let [exact, result] = [json!(0), json!(0.03)].map(|tolerance| plan(request(tolerance)));
    let certificate = &result.certificate;
    assert!(certificate.lawful && certificate.waypoint_error.unwrap() <= 0.03, "{certificate:?}");
    assert!(result.duration < exact.duration, "{} {}", result.duration, exact.duration);
}

#[test]
fn a_tolerance_that_cannot_be_is_refused() {
    for (tolerance, pointer, words) in [
        (json!(-0.1), "", "no tolerance"),
        (json!([0.1, 0.1, -1, 0.1, 0.1, 0.1]), "/2", "no tolerance"),
        (json!([0.1, 0.1]), "", "2 values for 6 joints"),
    ] {
        let found = faults(mcb(tolerance));
        let [fault] = &found.0[..] else { panic!("{found}") };
        assert_eq!(fault.pointer, format!("/task/via_tolerance{pointer}"));
        assert!(fault.detail.contains(words), "{found}");
    }
    let found = faults(scenario("mcb-ab", json!({ "via_tolerance": 0.1 })));
    let [fault] = &found.0[..] else { panic!("{found}") };
    assert_eq!(fault.pointer, "/task/via_tolerance");
    assert!(fault.detail.contains("only jerk_limited"), "{found}");
}

/// A certificate judges anyone's trajectory by the tolerance that is asked of it.
#[test]
fn verification_judges_misses() {
    let result = plan(mcb(json!(0.05)));
    let due: Vec<Value> = result
        .waypoint_times
        .iter()
        .zip(&result.waypoints)
        .map(|(time, position)| json!({ "time": time, "position": position }))
        .collect();
    let scenario = scenario("mcb-ab-fastest", json!({}));
    let judged = |tolerance: Value, due: &[Value]| {
        let request = json!({ "robot": scenario["robot"], "limits": scenario["limits"],
            "trajectory": result.trajectory, "waypoints": due, "via_tolerance": tolerance });
        verify(&VerifyRequest::parse(request).unwrap(), &catalogue::get)
    };
    assert!(judged(json!(0.05), &due).unwrap().lawful);
    let refused = judged(json!([0.05, 0.05, 0.05, 0.05, 0.05, 0.01]), &due).unwrap();
    assert!(!refused.lawful && refused.violations.len() == 1, "{:?}", refused.violations);
    let violation = &refused.violations[0];
    assert_eq!((violation.limit.as_str(), violation.limit_value), ("via_tolerance", 0.01));
    assert!(violation.detail.contains("misses the waypoint"), "{violation:?}");
    // Without a tolerance a miss is told and no more.
    assert!(judged(Value::Null, &due).unwrap().lawful);
    let found = judged(json!(0.05), &[]).unwrap_err();
    assert!(found.to_string().contains("/via_tolerance"), "{found}");
    // The ends have none.
    let mut shifted = due.clone();
    shifted[3]["position"][0] = json!(-0.5);
    assert!(!judged(json!(0.05), &shifted).unwrap().lawful);
}
