//! What every optimizer of the registry promises, on real timing problems and
//! on plain functions.

use std::collections::{BTreeMap, HashSet};
use std::time::Duration;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken, StopReason};
use takt::fault::Faults;
use takt::optimize::{
    ConvergencePoint, OPTIMIZERS, Objective, OptimizerEntry, Settings, Solution, minimize,
    optimizer,
};
use takt::trajectory::interpolation::{Timing, interpolation};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::timing::{Handling, TimingProblem};

use crate::watched::{Answer, Plain, Watched};

/// Few enough for many runs, enough to leave the initial population behind.
const ITERATIONS: u64 = 12;

fn timing(waypoints: &[[f64; 2]], handling: Handling, range: Option<[f64; 2]>) -> TimingProblem {
    let Timing::Search(kernel) = interpolation("quintic").unwrap().timing else {
        panic!("quintic is searched");
    };
    let waypoints: Vec<Vec<f64>> = waypoints.iter().map(|row| row.to_vec()).collect();
    let limit = KernelLimits {
        derivatives: [1.5, 4.0, 30.0],
        position: [f64::NEG_INFINITY, f64::INFINITY],
    };
    TimingProblem::new(kernel, &waypoints, &[limit; 2], handling, range)
}

const WAYPOINTS: [[f64; 2]; 4] = [[0.0, 0.0], [0.7, 0.2], [0.9, -0.4], [0.1, -0.5]];

fn problem() -> TimingProblem {
    timing(&WAYPOINTS, Handling::RepairUniform, None)
}

/// Many valleys, the deepest off the centre; negative there.
fn rugged(x: &[f64]) -> f64 {
    let valley = |(d, x): (usize, &f64)| {
        let y = x - 0.7 + 0.1 * d as f64;
        y * y - 0.3 * (6.0 * y).cos()
    };
    x.iter().enumerate().map(valley).sum()
}

/// What an optimizer is tried on: its name and the problem.
fn objectives(entry: &OptimizerEntry) -> Vec<(&'static str, Box<dyn Objective>)> {
    let mut objectives: Vec<(&'static str, Box<dyn Objective>)> = vec![
        ("repaired durations", Box::new(problem())),
        ("penalized durations", Box::new(timing(&WAYPOINTS, Handling::Penalty, None))),
    ];
    // It promises something for problems with a scaling law only.
    if entry.name != "exact" {
        objectives.push(("rugged", Box::new(Plain::new(5, [-2.0, 3.0], rugged))));
    }
    objectives
}

/// Every optimizer with everything it is tried on.
fn cases() -> impl Iterator<Item = (&'static OptimizerEntry, String, Box<dyn Objective>)> {
    OPTIMIZERS.iter().flat_map(|entry| {
        let named = move |(name, objective)| (entry, format!("{}, {name}", entry.name), objective);
        objectives(entry).into_iter().map(named)
    })
}

fn settings(entry: &OptimizerEntry, given: Value) -> Settings {
    let given: BTreeMap<String, Value> = serde_json::from_value(given).unwrap();
    let mut faults = Faults::default();
    let settings = entry.settings(&given, "", &mut faults);
    assert!(faults.is_empty(), "{faults}");
    settings
}

/// A search, and all the progress it reported.
fn watch(
    entry: &OptimizerEntry,
    objective: &dyn Objective,
    seed: u64,
    iterations: u64,
    budget: &Budget,
) -> (Solution, Vec<ConvergencePoint>) {
    // A schedule over the iterations ends with the search; `exact` takes fewer.
    let settings = settings(entry, json!({ "iterations": iterations.min(1000) }));
    let mut optimizer = (entry.build)(&settings, objective, seed);
    let mut seen = Vec::new();
    let mut progress = |point: &ConvergencePoint| seen.push(*point);
    let solution = minimize(objective, optimizer.as_mut(), iterations, budget, &mut progress);
    (solution, seen)
}

fn run(entry: &OptimizerEntry, objective: &dyn Objective, seed: u64, iterations: u64) -> Solution {
    watch(entry, objective, seed, iterations, &Budget::default()).0
}

fn in_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Everything a solution says but how long it took, to the bit.
fn bits(solution: &Solution) -> Vec<u64> {
    let position = solution.position.iter().flatten().copied();
    let curve = solution.convergence.iter().flat_map(|point| [point.best, point.mean]);
    let numbers = position.chain(curve.map(|value| value.unwrap_or(f64::NAN)));
    numbers.map(f64::to_bits).chain([solution.iterations, solution.evaluations]).collect()
}

#[test]
fn the_best_comes_near_the_optimum() {
    let problem = problem();
    let optimum = run(optimizer("exact").unwrap(), &problem, 0, 8).fitness;
    for entry in OPTIMIZERS {
        let solution = run(entry, &problem, 5, 40);
        let excess = solution.fitness / optimum - 1.0;
        assert!((-1e-6..0.05).contains(&excess), "{}: {excess}", entry.name);
    }
}

#[test]
fn the_best_never_worsens_and_is_what_it_says() {
    for (entry, case, objective) in cases() {
        let (solution, progress) = watch(entry, objective.as_ref(), 5, 30, &Budget::default());
        let best: Vec<f64> = progress.iter().filter_map(|point| point.best).collect();
        assert_eq!(best.len(), progress.len(), "{case}");
        assert!(best.windows(2).all(|pair| pair[1] <= pair[0]), "{case}: {best:?}");
        assert_eq!(best.last().copied(), Some(solution.fitness), "{case}");
        if entry.name == "exact" {
            // Its candidates lie on their limits, rounding to either side.
            continue;
        }
        let again = objective.candidate().fitness(solution.position.as_ref().unwrap());
        assert_eq!(again, solution.fitness, "{case}");
        let first = best[0];
        assert!(solution.fitness < first, "{case}: nothing better than {first} was found");
    }
}

#[test]
fn a_seed_repeats_to_the_bit_on_any_number_of_threads() {
    for (entry, case, objective) in cases() {
        let alone = bits(&run(entry, objective.as_ref(), 9, ITERATIONS));
        for threads in [1, 2, 8] {
            let mut watched = Watched::new(objective.as_ref());
            // Dear enough for threads to be used.
            watched.evaluation_ns = 1e5;
            let solution = in_threads(threads, || run(entry, &watched, 9, ITERATIONS));
            assert_eq!(bits(&solution), alone, "{case}, {threads} threads");
            let candidates = watched.candidates();
            let serial = entry.name == "exact";
            assert_eq!(candidates, if serial { 1 } else { threads }, "{case}");
        }
        let other = bits(&run(entry, objective.as_ref(), 10, ITERATIONS));
        // Only the deterministic method does without its seed.
        assert_eq!(entry.name == "exact", alone == other, "{case}");
    }
}

#[test]
fn dear_candidates_are_evaluated_in_several_threads() {
    for (entry, case, objective) in cases() {
        if entry.name == "exact" {
            continue;
        }
        let mut watched = Watched::new(objective.as_ref());
        watched.evaluation_ns = 1e5;
        watched.threads_awaited = 2;
        in_threads(2, || run(entry, &watched, 1, 1));
        assert_eq!(watched.threads(), 2, "{case}");
    }
}

#[test]
fn evaluation_limits_are_kept_to_the_number() {
    for (entry, case, objective) in cases() {
        for (limit, threads) in [(1, 1), (2, 1), (37, 2), (300, 1), (300, 8)] {
            let mut watched = Watched::new(objective.as_ref());
            watched.evaluation_ns = 1e5;
            let budget = Budget::default().with_max_evaluations(Some(limit));
            let search = || watch(entry, &watched, 1, 1_000_000, &budget).0;
            let solution = in_threads(threads, search);
            assert_eq!(solution.stop_reason, StopReason::EvaluationLimit, "{case}");
            assert_eq!((solution.evaluations, watched.evaluations()), (limit, limit), "{case}");
        }
    }
}

#[test]
fn iteration_limits_are_kept_and_every_generation_reports() {
    for (entry, case, objective) in cases() {
        for limit in [0, 1, 7] {
            let (solution, progress) =
                watch_defaults(entry, objective.as_ref(), limit, &Budget::default());
            assert_eq!(solution.stop_reason, StopReason::IterationLimit, "{case}");
            assert_eq!(solution.iterations, limit, "{case}");
            let iterations: Vec<u64> = progress.iter().map(|point| point.iteration).collect();
            assert_eq!(iterations, (0..=limit).collect::<Vec<_>>(), "{case}");
            let evaluations: Vec<u64> = progress.iter().map(|point| point.evaluations).collect();
            assert!(evaluations[0] > 0, "{case}");
            assert!(evaluations.windows(2).all(|pair| pair[0] < pair[1]), "{case}");
            assert_eq!(evaluations.last(), Some(&solution.evaluations), "{case}");
        }
    }
}

/// With the entry's own number of iterations in its settings.
fn watch_defaults(
    entry: &OptimizerEntry,
    objective: &dyn Objective,
    iterations: u64,
    budget: &Budget,
) -> (Solution, Vec<ConvergencePoint>) {
    let mut optimizer = (entry.build)(&settings(entry, json!({})), objective, 1);
    let mut seen = Vec::new();
    let mut progress = |point: &ConvergencePoint| seen.push(*point);
    let solution = minimize(objective, optimizer.as_mut(), iterations, budget, &mut progress);
    (solution, seen)
}

#[test]
fn a_time_limit_ends_the_search_with_something_found() {
    for (entry, case, objective) in cases() {
        let over = Budget::default().with_time_limit(Some(Duration::ZERO));
        let (solution, _) = watch(entry, objective.as_ref(), 1, 1_000_000, &over);
        assert_eq!(solution.stop_reason, StopReason::TimeLimit, "{case}");
        assert_eq!(solution.iterations, 0, "{case}");
        assert!(solution.position.is_some(), "{case}");

        let mut watched = Watched::new(objective.as_ref());
        watched.evaluation_ns = 1e6;
        watched.pause = Duration::from_millis(1);
        let soon = Budget::default().with_time_limit(Some(Duration::from_millis(20)));
        let (solution, _) = watch(entry, &watched, 1, 1_000_000, &soon);
        assert_eq!(solution.stop_reason, StopReason::TimeLimit, "{case}");
        assert!(solution.position.is_some(), "{case}");
        // Each takes a millisecond at least, in at most as many threads.
        let most = 21 * rayon::current_num_threads() as u64;
        assert!(solution.evaluations <= most, "{case}: {}", solution.evaluations);
    }
}

/// What runs on after a search was cancelled is a millisecond's work at most.
#[test]
fn a_cancelled_search_ends_within_a_millisecond() {
    for (entry, case, objective) in cases() {
        for (evaluation_ns, threads) in [(2e4, 1), (1e5, 1), (1e5, 2), (3e6, 2)] {
            // In the initial generation and, for most, in a later one.
            for at in [3, 150] {
                let token = CancelToken::default();
                let mut watched = Watched::new(objective.as_ref());
                watched.evaluation_ns = evaluation_ns;
                watched.cancel = Some((at, token.clone()));
                let budget = Budget::new(token);
                let search = || watch(entry, &watched, 1, 1_000_000, &budget).0;
                let solution = in_threads(threads, search);
                assert_eq!(solution.stop_reason, StopReason::Cancelled, "{case}");
                let after = watched.evaluations() - at;
                let most = threads as u64 * ((1e6 / evaluation_ns) as u64).max(1) - 1;
                assert!(after <= most, "{case}: {after} evaluations of {evaluation_ns} ns");
                assert_eq!(solution.evaluations, watched.evaluations(), "{case}");
            }
        }
    }
}

#[test]
fn a_search_cancelled_before_it_began_ends_at_once() {
    for (entry, case, objective) in cases() {
        let token = CancelToken::default();
        token.cancel();
        let (solution, _) = watch(entry, objective.as_ref(), 1, 1_000_000, &Budget::new(token));
        assert_eq!(solution.stop_reason, StopReason::Cancelled, "{case}");
        assert_eq!(solution.iterations, 0, "{case}");
    }
}

#[test]
fn candidates_stay_in_the_box() {
    for (entry, case, objective) in cases() {
        let watched = Watched::new(objective.as_ref());
        let solution = run(entry, &watched, 3, 50);
        assert_eq!(watched.outside(), 0, "{case}");
        assert_eq!(watched.evaluations(), solution.evaluations, "{case}");
    }
}

#[test]
fn where_nothing_is_feasible_nothing_is_found() {
    for (entry, case, objective) in cases() {
        for value in [f64::INFINITY, f64::NAN] {
            let mut watched = Watched::new(objective.as_ref());
            watched.answer = Answer::Always(value);
            let (solution, progress) = watch(entry, &watched, 2, ITERATIONS, &Budget::default());
            assert_eq!(solution.position, None, "{case}, {value}");
            assert_eq!(solution.fitness, f64::INFINITY, "{case}, {value}");
            let silent = |point: &ConvergencePoint| point.best.is_none() && point.mean.is_none();
            assert!(progress.iter().all(silent), "{case}, {value}");
            assert!(solution.evaluations > ITERATIONS, "{case}, {value}");
            assert_eq!(watched.outside(), 0, "{case}, {value}");
        }
    }
}

#[test]
fn what_is_no_number_is_passed_over() {
    for (entry, case, objective) in cases() {
        let mut watched = Watched::new(objective.as_ref());
        watched.answer = Answer::NanEveryOther;
        let (solution, progress) = watch(entry, &watched, 2, ITERATIONS, &Budget::default());
        assert!(solution.fitness.is_finite(), "{case}");
        let position = solution.position.unwrap();
        assert!(position.iter().all(|x| x.is_finite()), "{case}");
        assert!(progress.iter().filter_map(|p| p.mean).all(f64::is_finite), "{case}");
        assert_eq!(watched.outside(), 0, "{case}");
    }
}

#[test]
fn a_flat_function_is_survived() {
    for (entry, case, objective) in cases() {
        let mut watched = Watched::new(objective.as_ref());
        watched.answer = Answer::Always(4.0);
        let solution = run(entry, &watched, 2, 50);
        assert!(solution.position.is_some(), "{case}");
        assert_eq!(watched.outside(), 0, "{case}");
        if entry.name != "exact" {
            assert_eq!(solution.fitness, 4.0, "{case}");
        }
    }
}

#[test]
fn one_variable_and_a_hair_wide_box_are_searched() {
    let narrow = [2.0, 2.0 + 1e-9];
    for entry in OPTIMIZERS {
        let mut objectives: Vec<Box<dyn Objective>> = vec![
            Box::new(timing(&WAYPOINTS[..2], Handling::RepairUniform, None)),
            Box::new(timing(&WAYPOINTS[..2], Handling::Penalty, Some(narrow))),
            Box::new(timing(&WAYPOINTS, Handling::Penalty, Some(narrow))),
        ];
        if entry.name != "exact" {
            objectives.push(Box::new(Plain::new(1, [-2.0, 3.0], rugged)));
            objectives.push(Box::new(Plain::new(1, narrow, rugged)));
            objectives.push(Box::new(Plain::new(5, narrow, rugged)));
            objectives.push(Box::new(Plain::new(5, [-1e-9, 0.0], rugged)));
        }
        for (case, objective) in objectives.iter().enumerate() {
            let watched = Watched::new(objective.as_ref());
            let solution = run(entry, &watched, 2, ITERATIONS);
            let name = format!("{}, case {case}", entry.name);
            assert!(solution.fitness.is_finite(), "{name}");
            assert_eq!(watched.outside(), 0, "{name}");
        }
    }
}

/// What the registry tells users is what it takes: every default is lawful and
/// every bound is enforced.
#[test]
fn declared_parameters_are_what_is_taken() {
    for entry in OPTIMIZERS {
        let info = serde_json::to_value(entry.info()).unwrap();
        for parameter in info["parameters"].as_array().unwrap() {
            let name = parameter["name"].as_str().unwrap();
            let read = |value: Value| {
                let mut faults = Faults::default();
                entry.settings(&BTreeMap::from([(name.to_owned(), value)]), "", &mut faults);
                faults.is_empty()
            };
            let default = &parameter["default"];
            assert!(default.is_null() || read(default.clone()), "{}: {name}", entry.name);
            let above = parameter["max"].as_f64().unwrap() * 2.0 + 1.0;
            assert!(!read(json!(above)), "{}: {name} takes {above}", entry.name);
            assert!(!read(json!("x")) && !read(json!([1])), "{}: {name}", entry.name);
        }
    }
}

#[test]
fn the_registry_is_in_alphabetical_order() {
    let names: Vec<&str> = OPTIMIZERS.iter().map(|entry| entry.name).collect();
    assert!(names.is_sorted() && names.len() == names.iter().collect::<HashSet<_>>().len());
}

/// Every reading of a source that a method offers keeps what the method promises.
#[test]
fn options_keep_the_promises() {
    let options = [
        ("ga", json!({ "roulette": true, "elite": 0 })),
        ("ga", json!({ "blend": true, "tournament": 7, "population": 5 })),
        ("aga", json!({ "generation_factor": true, "outer_penalty": false, "population": 3 })),
        ("aga", json!({ "penalty": 0.0, "penalty_doubling": 1 })),
        ("dual_pso", json!({ "h2_repair": false, "h2_from_position": true })),
        ("coa", json!({ "first_wave_patience": 1, "second_wave_patience": 1, "population": 2 })),
    ];
    for (name, given) in options {
        let entry = optimizer(name).unwrap();
        for handling in [Handling::RepairUniform, Handling::Penalty, Handling::Reject] {
            let problem = timing(&WAYPOINTS, handling, None);
            let watched = Watched::new(&problem);
            let run = || {
                let mut optimizer = (entry.build)(&settings(entry, given.clone()), &watched, 4);
                minimize(&watched, optimizer.as_mut(), 40, &Budget::default(), &mut |_| {})
            };
            let solution = run();
            assert_eq!(bits(&solution), bits(&run()), "{name} {given}");
            let again = problem.candidate().fitness(solution.position.as_ref().unwrap());
            assert_eq!(again, solution.fitness, "{name} {given} {handling:?}");
            assert_eq!(watched.outside(), 0, "{name} {given} {handling:?}");
        }
    }
}

/// One joint goes 1 rad in 1 s at a peak of 1.875 rad/s where 1.5 are allowed:
/// a quarter too fast.
#[test]
fn penalties_tell_cost_and_squared_excess_apart() {
    let Timing::Search(kernel) = interpolation("quintic").unwrap().timing else {
        panic!("quintic is searched");
    };
    let limit = KernelLimits {
        derivatives: [1.5, f64::INFINITY, f64::INFINITY],
        position: [f64::NEG_INFINITY, f64::INFINITY],
    };
    let waypoints = [vec![0.0], vec![1.0]];
    let appraise = |handling, duration: f64| {
        let problem = TimingProblem::new(kernel, &waypoints, &[limit], handling, Some([0.1, 5.0]));
        let mut candidate = problem.candidate();
        let appraisal = candidate.appraise(&[duration]);
        assert_eq!(appraisal.fitness, candidate.fitness(&[duration]));
        appraisal
    };
    let fast = appraise(Handling::Penalty, 1.0);
    assert_eq!(fast.cost, 1.0);
    assert!((fast.excess - 0.0625).abs() < 1e-12, "{fast:?}");
    // Five seconds, the most a lawful candidate can take, and more.
    assert!((fast.fitness - (1.0 + 5.0 + 5.0 * 0.25)).abs() < 1e-12, "{fast:?}");
    let slow = appraise(Handling::Penalty, 2.0);
    assert_eq!((slow.fitness, slow.cost, slow.excess), (2.0, 2.0, 0.0));
    let repaired = appraise(Handling::RepairUniform, 1.0);
    assert_eq!((repaired.cost, repaired.excess), (repaired.fitness, 0.0));
}

/// The adaptive algorithm's own penalty may prefer what breaks a limit a
/// little; what it finds keeps all of them.
#[test]
fn no_penalty_lets_an_infeasible_candidate_win() {
    let problem = timing(&WAYPOINTS, Handling::Penalty, None);
    for penalty in [0.0, 0.1, 10.0] {
        let entry = optimizer("aga").unwrap();
        let given = json!({ "penalty": penalty });
        let mut optimizer = (entry.build)(&settings(entry, given), &problem, 1);
        let budget = Budget::default();
        let solution = minimize(&problem, optimizer.as_mut(), 100, &budget, &mut |_| {});
        let position = solution.position.unwrap();
        assert_eq!(solution.fitness, position.iter().sum::<f64>(), "eps {penalty}");
        assert!(problem.scale(&position) <= 1.0, "eps {penalty}");
    }
}

/// A repaired candidate is one that a rejecting problem takes, to the last bit.
#[test]
fn repaired_candidates_are_lawful() {
    let problem = timing(&WAYPOINTS, Handling::Reject, None);
    let mut candidate = problem.candidate();
    let mut random = takt::math::random::RandomStream::new(1, 0);
    let bounds = problem.bounds();
    for _ in 0..2000 {
        let ends = bounds.lower.iter().zip(&bounds.upper);
        let mut x: Vec<f64> = ends.map(|(&l, &u)| random.uniform(l, 0.5 * (l + u))).collect();
        candidate.repair(&mut x);
        // The box may be too short for some proportions.
        if x.iter().zip(&bounds.upper).all(|(x, upper)| x < upper) {
            assert!(
                candidate.fitness(&x).is_finite(),
                "{x:?}, scale {:e}",
                problem.scale(&x) - 1.0
            );
        }
    }
}
