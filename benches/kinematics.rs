//! Forward and inverse kinematics on one core: where the tool is, its Jacobian, all branches for a pose, and the
//! nearest to the home position, over a hundred random poses each.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use takt::geometry::Transform;
use takt::math::random::RandomStream;
use takt::robot::inverse::{PoseError, Solutions};
use takt::robot::{Jacobian, LinkFrames, Robot, catalogue};

const ROBOTS: [&str; 7] = [
    "ur5e",
    "rokae_xb4",
    "epson_c4_a601s",
    "kuka_kr6_r900_sixx",
    "epson_t3_401s",
    "woodworking_pprr",
    "franka_panda",
];

fn random_configuration(robot: &Robot, random: &mut RandomStream) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| &joint.limits);
    limits.map(|l| random.uniform(l.lower.unwrap_or(-3.0), l.upper.unwrap_or(3.0))).collect()
}

fn forward(criterion: &mut Criterion) {
    for robot in ROBOTS.iter().filter_map(|name| catalogue::get(name)) {
        let Some(kinematics) = robot.kinematics() else { continue };
        let mut frames = LinkFrames::new(kinematics);
        let mut jacobian = Jacobian::new(robot.dof());
        let configuration = random_configuration(&robot, &mut RandomStream::new(1, 0));
        let name = robot.name();
        criterion.bench_function(&format!("forward/{name}"), |bencher| {
            bencher.iter(|| {
                kinematics.forward(black_box(&configuration), &mut frames);
                black_box(frames.tool().origin.x)
            });
        });
        criterion.bench_function(&format!("forward and jacobian/{name}"), |bencher| {
            bencher.iter(|| {
                kinematics.forward(black_box(&configuration), &mut frames);
                kinematics.jacobian(&frames, &mut jacobian);
                black_box(jacobian.matrix()[(0, 0)])
            });
        });
    }
}

fn inverse(criterion: &mut Criterion) {
    for robot in ROBOTS.iter().filter_map(|name| catalogue::get(name)) {
        let (Some(kinematics), Some(inverse)) = (robot.kinematics(), robot.inverse()) else {
            continue;
        };
        let (home, name) = (inverse.home(), robot.name());
        let mut random = RandomStream::new(3, 0);
        let mut target = || kinematics.tool_transform(&random_configuration(&robot, &mut random));
        let targets: Vec<Transform> = (0..100).map(|_| target()).collect();
        let mut found = Solutions::new(inverse);
        criterion.bench_function(&format!("all branches/{name}"), |bencher| {
            let mut targets = targets.iter().cycle();
            bencher.iter(|| {
                let Some(target) = targets.next() else { return };
                inverse.all(black_box(target), &home, &PoseError::TOLERANCE, &mut found);
                black_box(found.len());
            });
        });
        criterion.bench_function(&format!("nearest/{name}"), |bencher| {
            let mut targets = targets.iter().cycle();
            bencher.iter(|| {
                let Some(target) = targets.next() else { return };
                let reached = inverse.nearest(target, &home, &PoseError::TOLERANCE, &mut found);
                black_box(reached.is_ok());
            });
        });
    }
}

criterion_group!(benches, forward, inverse);
criterion_main!(benches);
