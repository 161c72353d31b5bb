//! The cost of the fastest trajectory on one core.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::fastest;
use takt::trajectory::kernel::KernelLimits;

/// Random waypoints of seven joints with limits of their own.
fn tour(waypoints: usize) -> (Vec<Vec<f64>>, Vec<KernelLimits>) {
    let mut random = RandomStream::new(20, waypoints as u64);
    let rows =
        (0..waypoints).map(|_| (0..7).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let mut joint = || KernelLimits {
        derivatives: [
            random.uniform(0.5, 3.0),
            random.uniform(1.0, 15.0),
            random.uniform(5.0, 100.0),
        ],
        position: [f64::NEG_INFINITY, f64::INFINITY],
    };
    (rows, (0..7).map(|_| joint()).collect())
}

fn plans(c: &mut Criterion) {
    let mut group = c.benchmark_group("fastest, seven joints");
    for waypoints in [2, 4, 6, 17, 50, 1000] {
        let (rows, limits) = tour(waypoints);
        group.sample_size(if waypoints > 100 { 10 } else { 20 });
        group.bench_function(BenchmarkId::from_parameter(waypoints), |b| {
            b.iter(|| fastest(&rows, &limits).iterations)
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(500))
        .measurement_time(std::time::Duration::from_secs(3));
    targets = plans
}
criterion_main!(benches);
