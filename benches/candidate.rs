//! The cost of one candidate: curve and exact peaks.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use takt::trajectory::interpolation::{Timing, interpolation};
use takt::trajectory::kernel::{JointLanes, KernelLimits};

fn mcb_ab() -> JointLanes {
    let degrees: [[f64; 6]; 4] = [
        [0.0, -35.1, -29.8, 0.0, -25.1, 0.0],
        [-24.0, -37.7, -30.6, 0.0, -21.7, 23.96],
        [-43.7, -52.2, -4.14, 0.0, -33.6, 135.3],
        [-30.0, -58.3, -2.11, 0.0, -29.6, 125.0],
    ];
    let waypoints: Vec<Vec<f64>> =
        degrees.iter().map(|row| row.iter().map(|d| d.to_radians()).collect()).collect();
    let velocity = [0.9, 0.9, 0.9, 0.9, 0.95, 1.0];
    let acceleration = [0.9, 0.9, 0.9, 0.9, 0.9, 1.0];
    let limits: Vec<KernelLimits> = (0..6)
        .map(|j| KernelLimits {
            derivatives: [velocity[j], acceleration[j], 2.0],
            position: [f64::NEG_INFINITY, f64::INFINITY],
        })
        .collect();
    JointLanes::new(&waypoints, &limits)
}

fn candidate(c: &mut Criterion) {
    let joints = mcb_ab();
    // `bspline` is `cubic`.
    for name in [
        "quintic",
        "quintic_han",
        "3-5-3",
        "4-3-4",
        "cubic",
        "cubic_zero_acceleration",
        "bspline_uniform",
    ] {
        let Some(Timing::Search(kernel)) = interpolation(name).map(|entry| &entry.timing) else {
            continue;
        };
        let mut work = kernel.workspace(&joints);
        let durations = [2.0, 3.1, 1.9];
        c.bench_function(&format!("mcb-ab/{name}/all peaks"), |b| {
            b.iter(|| kernel.ratios(&joints, black_box(&durations), &mut work));
        });
        c.bench_function(&format!("mcb-ab/{name}/scale"), |b| {
            b.iter(|| black_box(kernel.scale(&joints, black_box(&durations), &mut work)));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(300)).measurement_time(std::time::Duration::from_secs(1));
    targets = candidate
}
criterion_main!(benches);
