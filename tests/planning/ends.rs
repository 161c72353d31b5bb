//! Ends in motion: cut out of fastest motions, random ones, and as requests.

use serde_json::{Value, json};
use takt::budget::Budget;
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::{Fastest, fastest, fastest_between};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{Certificate, Ends, KinematicState};

use crate::jerk_limited::{bounds, problem};

fn planned(waypoints: &[Vec<f64>], limits: &[KernelLimits], ends: &Ends) -> Fastest {
    fastest_between(waypoints, limits, ends, &Budget::default(), &mut |_| {}).unwrap()
}

/// Certified and at both states to 1e-9.
fn check(waypoints: &[Vec<f64>], limits: &[KernelLimits], ends: &Ends, found: &Fastest) {
    let due: Vec<(f64, &[f64])> =
        found.times.iter().zip(waypoints).map(|(t, row)| (*t, row.as_slice())).collect();
    found.trajectory.validate(limits.len()).unwrap();
    let certificate = Certificate::joined(&found.trajectory, &bounds(limits), &due, Some(ends));
    assert!(certificate.lawful, "{:?}", certificate.violations);
    assert!(certificate.waypoint_error.unwrap() <= 1e-9);
    let mut state = KinematicState::new(limits.len());
    for (t, end) in [(0.0, &ends.start), (found.trajectory.duration(), &ends.goal)] {
        found.trajectory.sample(t, &mut state);
        for (joint, [v, a]) in end.iter().enumerate() {
            let [velocity, acceleration] = [state.velocity[joint], state.acceleration[joint]];
            assert!((velocity - v).abs() <= 1e-9, "{t}: {velocity} {v}");
            assert!((acceleration - a).abs() <= 1e-9, "{t}: {acceleration} {a}");
        }
    }
}

#[test]
fn explore() {
    let problems: Vec<Value> =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    let mut random = RandomStream::new(7, 0);
    for value in &problems {
        let (waypoints, limits) = problem(value);
        if limits.iter().any(|l| l.derivatives[2].is_infinite()) {
            continue;
        }
        let whole = fastest(&waypoints, &limits);
        let n = waypoints.len();
        let total = whole.trajectory.duration();
        let mut state = KinematicState::new(limits.len());
        let mut cut = |t: f64| {
            whole.trajectory.sample(t, &mut state);
            let ends: Vec<[f64; 2]> =
                state.velocity.iter().zip(&state.acceleration).map(|(v, a)| [*v, *a]).collect();
            (state.position.clone(), ends)
        };
        let rest = vec![[0.0; 2]; limits.len()];
        let from = random.uniform(0.0, 0.9) * whole.times[1];
        let to = total - random.uniform(0.0, 0.9) * (total - whole.times[n - 2]);
        let (first, start) = cut(from);
        let (last, goal) = cut(to);
        let mut line = format!("{} n={n}", value["name"]);
        for (s, g) in [(true, false), (false, true), (true, true)] {
            let mut rows = waypoints.clone();
            if s {
                rows[0] = first.clone();
            }
            if g {
                rows[n - 1] = last.clone();
            }
            let ends = Ends {
                start: if s { start.clone() } else { rest.clone() },
                goal: if g { goal.clone() } else { rest.clone() },
            };
            let expected = (if g { to } else { total }) - if s { from } else { 0.0 };
            let t = std::time::Instant::now();
            let found = planned(&rows, &limits, &ends);
            let el = t.elapsed().as_secs_f64();
            check(&rows, &limits, &ends, &found);
            line += &format!(
                " | {:.5} conv {} it {} {:.0}ms",
                found.trajectory.duration() / expected,
                found.converged,
                found.iterations,
                el * 1e3
            );
        }
        println!("{line}");
    }
    let _ = json!({});
}
