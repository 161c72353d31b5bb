//! The cost of the fastest trajectory with its lower bound on one core: random lists of seven joints of growing
//! length, and the problems that `benches/peers/run.sh jerk_limited` gives to other programs.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use serde_json::Value;
use takt::math::random::RandomStream;
use takt::plan::scenarios;
use takt::trajectory::jerk_limited::fastest;
use takt::trajectory::kernel::KernelLimits;

type Problem = (Vec<Vec<f64>>, Vec<KernelLimits>);

fn limits(rows: impl IntoIterator<Item = [f64; 3]>) -> Vec<KernelLimits> {
    let position = [f64::NEG_INFINITY, f64::INFINITY];
    rows.into_iter().map(|derivatives| KernelLimits { derivatives, position }).collect()
}

/// The first of many random tours, on which longer lists are measured.
const FIRST: u64 = 20;

/// Random waypoints of seven joints with limits of their own.
fn tour(waypoints: usize, seed: u64) -> Problem {
    let mut random = RandomStream::new(seed, waypoints as u64);
    let rows =
        (0..waypoints).map(|_| (0..7).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let mut joint =
        || [random.uniform(0.5, 3.0), random.uniform(1.0, 15.0), random.uniform(5.0, 100.0)];
    (rows, limits((0..7).map(|_| joint())))
}

/// The papers' problems with their limits.
fn papers() -> Vec<(String, Problem)> {
    let mut han = [[0.9, 0.9, 2.0]; 6];
    han[4] = [0.95, 0.9, 2.0];
    han[5] = [1.0, 1.0, 2.0];
    let mut wood = [[0.6, 0.8, 3.2]; 4];
    (wood[2], wood[3]) = ([1.8, 2.4, 9.6], [1.8, 2.4, 9.6]);
    [("mcb-ab", han.to_vec()), ("wood", wood.to_vec())]
        .into_iter()
        .filter_map(|(name, rows)| {
            let task = &scenarios::get(name)?.request["task"];
            let waypoints = serde_json::from_value(task["waypoints"].clone()).ok()?;
            Some((name.to_owned(), (waypoints, limits(rows))))
        })
        .collect()
}

/// The ten random problems of the tests.
fn randoms() -> Vec<(String, Problem)> {
    let problems: Vec<Value> =
        serde_json::from_str(include_str!("../tests/data/random_problems.json"))
            .unwrap_or_default();
    let list =
        |value: &Value| -> Vec<f64> { serde_json::from_value(value.clone()).unwrap_or_default() };
    problems
        .iter()
        .map(|problem| {
            let waypoints = serde_json::from_value(problem["waypoints"].clone());
            let [v, a, j] = ["velocity", "acceleration", "jerk"].map(|name| list(&problem[name]));
            let rows = (0..v.len()).map(|joint| [v[joint], a[joint], j[joint]]);
            let name = problem["name"].as_str().unwrap_or_default().to_owned();
            (name, (waypoints.unwrap_or_default(), limits(rows)))
        })
        .collect()
}

fn plans(c: &mut Criterion) {
    let mut group = c.benchmark_group("fastest, seven joints");
    for waypoints in [4, 6] {
        // One tour may need twice the Newton steps of another: many in turn.
        let tours: Vec<Problem> = (FIRST..FIRST + 40).map(|seed| tour(waypoints, seed)).collect();
        let mut next = tours.iter().cycle();
        group.sample_size(40);
        group.bench_function(BenchmarkId::new("many tours", waypoints), |b| {
            b.iter(|| next.next().map(|(rows, limits)| black_box(fastest(rows, limits)).lower))
        });
    }
    for waypoints in [2, 4, 6, 17, 50, 100, 1000] {
        let (rows, limits) = tour(waypoints, FIRST);
        group.sample_size(if waypoints > 100 { 10 } else { 20 });
        group.bench_function(BenchmarkId::from_parameter(waypoints), |b| {
            b.iter(|| black_box(fastest(&rows, &limits)).lower)
        });
    }
    group.finish();
    let mut group = c.benchmark_group("fastest");
    group.sample_size(20);
    for (name, (rows, limits)) in papers().into_iter().chain(randoms()) {
        group.bench_function(name, |b| b.iter(|| black_box(fastest(&rows, &limits)).lower));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(2));
    targets = plans
}
criterion_main!(benches);
