//! The lower bound: attacked with prices of every kind, and how near it comes.

use serde_json::Value;
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::{Fastest, fastest};
use takt::trajectory::kernel::KernelLimits;
use takt::trajectory::{Prices, Rooms, lower_bound};

use crate::jerk_limited::{nasty, problem};

/// The bound that `prices` prove, given the durations of the fastest motion known.
fn lower(waypoints: &[Vec<f64>], limits: &[KernelLimits], found: &Fastest, prices: &Prices) -> f64 {
    let way =
        |pair: &[Vec<f64>]| pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect();
    let ways: Vec<Vec<f64>> = waypoints.windows(2).map(way).collect();
    let rows: Vec<[f64; 3]> = limits.iter().map(|limit| limit.derivatives).collect();
    lower_bound(&ways, &rows, Rooms::none(), &found.durations, prices)
}

/// Whatever prices are asked, no bound may exceed the duration of a lawful trajectory.
#[test]
fn no_prices_prove_more_than_a_lawful_trajectory_needs() {
    let mut random = RandomStream::new(11, 0);
    let mut close = 0;
    for seed in 0..60 {
        let (waypoints, limits) = nasty(seed);
        let found = fastest(&waypoints, &limits);
        let duration = found.trajectory.duration();
        for size in [0.0, 0.02, 0.3, 3.0, 100.0] {
            let prices: Prices = found
                .prices
                .iter()
                .map(|row| {
                    row.iter()
                        .map(|price| price.map(|p| p * (1.0 + size * random.uniform(-1.0, 1.0))))
                        .collect()
                })
                .collect();
            let bound = lower(&waypoints, &limits, &found, &prices);
            assert!(bound <= duration * (1.0 + 1e-9), "{seed} {size}: {bound} > {duration}");
            close += usize::from(size > 0.0 && bound > 0.95 * duration);
        }
    }
    assert!(close > 50, "only {close} bounds with wrong prices are near enough to test anything");
}

/// The best known durations come from programmes that share no code with this one.
#[test]
fn bounds_lie_below_independent_optima_and_close_to_them() {
    let problems: Vec<Value> =
        serde_json::from_str(include_str!("../data/random_problems.json")).unwrap();
    let mut gaps: Vec<f64> = problems
        .iter()
        .map(|value| {
            let (waypoints, limits) = problem(value);
            let found = fastest(&waypoints, &limits);
            let bound = found.lower;
            let reference = value["reference"]["free"].as_f64().unwrap();
            assert!(bound <= reference, "{}: {bound} > {reference}", value["name"]);
            found.trajectory.duration() / bound - 1.0
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    assert!(gaps[gaps.len() / 2] < 0.005, "{gaps:?}");
    assert!(gaps[gaps.len() - 1] < 0.01, "{gaps:?}");
}

/// Half of the problems of every kind are within a percent of their bound.
#[test]
fn most_random_problems_are_within_a_percent_of_their_bound() {
    let mut gaps: Vec<f64> = (0..120)
        .map(|seed| {
            let (waypoints, limits) = nasty(seed);
            let found = fastest(&waypoints, &limits);
            let bound = found.lower;
            found.trajectory.duration() / bound - 1.0
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    assert!(gaps[0] > -1e-9 && gaps[gaps.len() / 2] < 0.01, "{gaps:?}");
}

/// Between two waypoints the bound is the optimum itself.
#[test]
fn two_waypoints_leave_no_gap() {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    for derivatives in [[2.0, 4.0, 30.0], [2.0, 4.0, f64::INFINITY], [2.0, f64::INFINITY, 9.0]] {
        let limits = vec![KernelLimits { derivatives, position: free }; 2];
        let waypoints = [vec![0.0, 1.0], vec![2.5, 0.5]];
        let found = fastest(&waypoints, &limits);
        let bound = found.lower;
        let gap = found.trajectory.duration() / bound - 1.0;
        assert!(gap.abs() < 1e-9, "{derivatives:?}: {gap}");
    }
}

/// Nothing depends on units: not the plan's closeness to its bound, nor whether a bound exists.
#[test]
fn other_units_leave_the_gap_as_it_is() {
    for seed in [4, 5, 8, 18, 26] {
        let (waypoints, limits) = nasty(seed);
        let found = fastest(&waypoints, &limits);
        let gap = found.trajectory.duration() / found.lower;
        for (length, time) in [(1e4, 1.0), (1e-4, 1e-2), (1.0, 1e3)] {
            let scaled: Vec<Vec<f64>> =
                waypoints.iter().map(|row| row.iter().map(|x| x * length).collect()).collect();
            let limits: Vec<KernelLimits> = limits
                .iter()
                .map(|limit| {
                    let [v, a, j] = limit.derivatives;
                    let derivatives = [v / time, a / (time * time), j / (time * time * time)];
                    KernelLimits { derivatives: derivatives.map(|x| x * length), ..*limit }
                })
                .collect();
            let found = fastest(&scaled, &limits);
            let again = found.trajectory.duration() / found.lower;
            assert!((again / gap - 1.0).abs() < 1e-3, "{seed} {length} {time}: {again} {gap}");
        }
    }
}

/// Numbers at the end of what a computer holds prove nothing rather than too much.
#[test]
fn extreme_limits_never_prove_too_much() {
    let waypoints = [vec![0.0, 0.0], vec![1.0, 1e-9], vec![0.5, 2e-9], vec![0.7, 0.0]];
    for extreme in [1e-150, 1e-30, 1e30, 1e150, 1e300] {
        for order in 0..3 {
            let mut derivatives = [1.0, 4.0, 30.0];
            derivatives[order] = extreme;
            let position = [f64::NEG_INFINITY, f64::INFINITY];
            let usual = KernelLimits { derivatives: [1.0, 4.0, 30.0], position };
            let limits = [KernelLimits { derivatives, position }, usual];
            let found = fastest(&waypoints, &limits);
            let duration = found.trajectory.duration();
            assert!((0.0..=duration).contains(&found.lower), "{extreme} {order}: {found:?}");
        }
    }
}
