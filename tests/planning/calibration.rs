//! GoldS-PSO where its paper's table put it, and where the optimum is moved:
//! Chen et al. 2023, Table 3, and the table of `docs/METHODS.md`.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;
use serde_json::json;
use takt::budget::Budget;
use takt::fault::Faults;
use takt::math::statistics::quantile;
use takt::optimize::{functions, minimize, optimizer};

/// The paper's set-up but for its 30 runs.
const CANDIDATES: u64 = 30;
const DIMENSION: usize = 30;
const ITERATIONS: u64 = 1000;
const RUNS: u64 = 7;

/// Median over runs of the best value found.
fn found(function: &str, shifted: bool) -> f64 {
    let (entry, function) =
        (optimizer("golds_pso").unwrap(), functions::function(function).unwrap());
    let given = BTreeMap::from([
        ("population".to_owned(), json!(CANDIDATES)),
        ("iterations".to_owned(), json!(ITERATIONS)),
    ]);
    let settings = entry.settings(&given, "", &mut Faults::default());
    let run = |seed| {
        let objective = function.objective(DIMENSION, shifted, seed);
        let mut search = (entry.build)(&settings, &objective, seed);
        let budget = Budget::default();
        minimize(&objective, search.as_mut(), ITERATIONS, &budget, &mut |_| {}).fitness
    };
    let mut best: Vec<f64> = (1..=RUNS).into_par_iter().map(run).collect();
    best.sort_by(f64::total_cmp);
    quantile(&best, 0.5).unwrap()
}

fn assert_medians(functions: &[&str], shifted: bool, expected: Range<f64>) {
    for function in functions {
        let median = found(function, shifted);
        assert!(expected.contains(&median), "{function}, shifted {shifted}: {median:e}");
    }
}

#[test]
fn the_printed_orders_of_magnitude_are_met_where_the_optimum_is_central() {
    for function in ["f1", "f2", "f3"] {
        assert_eq!(found(function, false), 0.0, "{function}");
    }
    assert_medians(&["f4", "f5", "f8"], false, 1e-6..1e-3);
}

/// The zeros come of the pull to the origin, not of the search.
#[test]
fn nothing_of_it_is_left_where_the_optimum_is_moved() {
    assert_medians(&["f1", "f4"], true, 5e3..5e4);
    assert_medians(&["f8"], true, 2e6..2e8);
}
