//! What every optimizer of the registry promises, on a real timing problem.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken, StopReason};
use takt::fault::Faults;
use takt::optimize::{
    Bounds, Candidate, OPTIMIZERS, Objective, OptimizerEntry, Ratios, Settings, Solution, minimize,
};
use takt::trajectory::interpolation::{Timing, interpolation};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::timing::{Handling, TimingProblem};

fn problem() -> TimingProblem {
    let Timing::Search(kernel) = interpolation("quintic").unwrap().timing else {
        panic!("quintic is searched");
    };
    let waypoints: Vec<Vec<f64>> =
        [[0.0, 0.0], [0.7, 0.2], [0.9, -0.4], [0.1, -0.5]].map(|row| row.to_vec()).to_vec();
    let limit = KernelLimits {
        derivatives: [1.5, 4.0, 30.0],
        position: [f64::NEG_INFINITY, f64::INFINITY],
    };
    TimingProblem::new(kernel, &waypoints, &[limit; 2], Handling::RepairUniform, None)
}

fn settings(entry: &OptimizerEntry, given: Value) -> Settings {
    let given: BTreeMap<String, Value> = serde_json::from_value(given).unwrap();
    let mut faults = Faults::default();
    let settings = entry.settings(&given, "", &mut faults);
    assert!(faults.is_empty(), "{faults}");
    settings
}

fn run(entry: &OptimizerEntry, seed: u64, iterations: u64, budget: &Budget) -> Solution {
    let problem = problem();
    // A schedule over the iterations ends with the search; `exact` takes fewer.
    let settings = settings(entry, json!({ "iterations": iterations.min(1000) }));
    let mut optimizer = (entry.build)(&settings, &problem, seed);
    minimize(&problem, optimizer.as_mut(), iterations, budget, &mut |_| {})
}

fn bits(solution: &Solution) -> Vec<u64> {
    solution.position.iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn the_best_never_worsens_and_comes_near_the_optimum() {
    let optimum = run(&OPTIMIZERS[0], 0, 8, &Budget::default()).fitness;
    for entry in OPTIMIZERS {
        let solution = run(entry, 5, 40, &Budget::default());
        let best: Vec<f64> = solution.convergence.iter().filter_map(|point| point.best).collect();
        assert!(best.windows(2).all(|pair| pair[1] <= pair[0]), "{}: {best:?}", entry.name);
        assert_eq!(best.last().copied(), Some(solution.fitness), "{}", entry.name);
        let excess = solution.fitness / optimum - 1.0;
        assert!((-1e-6..0.05).contains(&excess), "{}: {excess}", entry.name);
    }
}

#[test]
fn a_seed_repeats_to_the_bit() {
    for entry in OPTIMIZERS {
        let [first, second] = [9, 9].map(|seed| bits(&run(entry, seed, 20, &Budget::default())));
        assert_eq!(first, second, "{}", entry.name);
        let other = bits(&run(entry, 10, 20, &Budget::default()));
        // Only the deterministic method does without its seed.
        assert_eq!(entry.name == "exact", first == other, "{}", entry.name);
    }
}

#[test]
fn budgets_and_cancellation_end_the_search() {
    for entry in OPTIMIZERS {
        let limited = Budget::default().with_max_evaluations(Some(300));
        let solution = run(entry, 1, 1_000_000, &limited);
        assert_eq!(solution.stop_reason, StopReason::EvaluationLimit, "{}", entry.name);
        assert!(solution.evaluations < 300 + 64, "{}: {}", entry.name, solution.evaluations);

        let cancel = CancelToken::default();
        cancel.cancel();
        let solution = run(entry, 1, 1_000_000, &Budget::new(cancel));
        assert_eq!(solution.stop_reason, StopReason::Cancelled, "{}", entry.name);
        assert!(solution.iterations <= 1, "{}", entry.name);
    }
}

/// Counts candidates outside the search range.
struct Watching<'a> {
    inner: Box<dyn Candidate + 'a>,
    bounds: &'a Bounds,
    seen_outside: Arc<AtomicUsize>,
}

impl Candidate for Watching<'_> {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        let inside = position.iter().zip(&self.bounds.lower).zip(&self.bounds.upper);
        if !inside.into_iter().all(|((x, lower), upper)| (lower..=upper).contains(&x)) {
            self.seen_outside.fetch_add(1, Ordering::Relaxed);
        }
        self.inner.fitness(position)
    }

    fn repair(&mut self, position: &mut [f64]) {
        self.inner.repair(position);
    }

    fn homogeneous(&mut self, position: &[f64], ratios: &mut Ratios) -> f64 {
        self.inner.homogeneous(position, ratios)
    }
}

struct Watched {
    inner: TimingProblem,
    seen_outside: Arc<AtomicUsize>,
}

impl Objective for Watched {
    fn bounds(&self) -> &Bounds {
        self.inner.bounds()
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        let seen_outside = self.seen_outside.clone();
        Box::new(Watching { inner: self.inner.candidate(), bounds: self.bounds(), seen_outside })
    }

    fn evaluation_ns(&self) -> f64 {
        self.inner.evaluation_ns()
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        self.inner.starts()
    }

    fn is_homogeneous(&self) -> bool {
        true
    }
}

#[test]
fn candidates_stay_in_the_search_range() {
    for entry in OPTIMIZERS {
        let watched = Watched { inner: problem(), seen_outside: Default::default() };
        let settings = settings(entry, json!({}));
        let mut optimizer = (entry.build)(&settings, &watched, 3);
        minimize(&watched, optimizer.as_mut(), 50, &Budget::default(), &mut |_| {});
        let outside = watched.seen_outside.load(Ordering::Relaxed);
        assert_eq!(outside, 0, "{}", entry.name);
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
