//! Forward and inverse kinematics, one configuration at a time.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use takt::robot::{Jacobian, LinkFrames, catalogue};

fn forward(criterion: &mut Criterion) {
    for name in ["ur5e", "rokae_xb4", "franka_panda"] {
        let Some(robot) = catalogue::get(name) else { continue };
        let Some(kinematics) = robot.kinematics() else { continue };
        let mut frames = LinkFrames::new(kinematics);
        let mut jacobian = Jacobian::new(robot.dof());
        let configuration: Vec<f64> = (0..robot.dof()).map(|i| 0.3 + 0.1 * i as f64).collect();
        criterion.bench_function(&format!("forward/{name}"), |bencher| {
            bencher.iter(|| {
                kinematics.forward(black_box(&configuration), &mut frames);
                black_box(frames.tool().origin.x)
            });
        });
        criterion.bench_function(&format!("jacobian/{name}"), |bencher| {
            bencher.iter(|| {
                kinematics.forward(black_box(&configuration), &mut frames);
                kinematics.jacobian(&frames, &mut jacobian);
                black_box(jacobian.matrix()[(0, 0)])
            });
        });
    }
}

criterion_group!(benches, forward);
criterion_main!(benches);
