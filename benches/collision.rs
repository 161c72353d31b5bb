//! What collision checks cost: the Panda, covered by spheres, before the shelf of a MotionBenchMaker problem.

#![expect(clippy::unwrap_used, reason = "a bench that cannot go on says where")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use takt::collision::{BATCH, CollisionChecker, CollisionScratch, MotionCheck};
use takt::math::random::RandomStream;
use takt::robot::{LinkFrames, Robot, RobotDescription};
use takt::scene::{Scene, SceneDescription};

fn description() -> RobotDescription {
    serde_json::from_str(include_str!("data/panda_spheres.json")).unwrap()
}

fn shelf() -> Scene {
    let problem: serde_json::Value =
        serde_json::from_str(include_str!("data/bookshelf_small.json")).unwrap();
    let obstacles = serde_json::from_value(problem["obstacles"].clone()).unwrap();
    Scene::new(SceneDescription { obstacles, ..SceneDescription::default() }).unwrap()
}

fn random_state(robot: &Robot, random: &mut RandomStream) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| &joint.limits);
    limits.map(|l| random.uniform(l.lower.unwrap(), l.upper.unwrap())).collect()
}

/// The first free ones of random states.
fn free_states(
    robot: &Robot,
    checker: &CollisionChecker,
    scratch: &mut CollisionScratch,
    count: usize,
) -> Vec<Vec<f64>> {
    let mut random = RandomStream::new(1, 0);
    let mut free = Vec::new();
    while free.len() < count {
        let state = random_state(robot, &mut random);
        if checker.is_valid(&state, scratch) {
            free.push(state);
        }
    }
    free
}

fn forward_kinematics(c: &mut Criterion) {
    let mut description = description();
    let robot = Robot::new(description.clone()).unwrap();
    let state = [0.3, -0.7, 0.2, -2.0, 0.4, 1.5, 0.7];
    let mut frames = LinkFrames::new(robot.kinematics().unwrap());
    c.bench_function("forward kinematics, one state", |b| {
        b.iter(|| robot.kinematics().unwrap().forward(black_box(&state), &mut frames));
    });
    // One sphere at the flange and nothing to hit: what is left is the kernel's forward kinematics.
    description.geometry.drain(..description.geometry.len() - 1);
    let robot = Robot::new(description).unwrap();
    let checker =
        CollisionChecker::new(&robot, &Scene::default(), 0.0, MotionCheck::Proven).unwrap();
    let mut scratch = checker.scratch();
    let states = state.repeat(BATCH);
    c.bench_function("forward kinematics, sixteen states", |b| {
        b.iter(|| checker.are_valid(black_box(&states), &mut scratch));
    });
}

fn checks(c: &mut Criterion) {
    let robot = Robot::new(description()).unwrap();
    let scene = shelf();
    let resolution = MotionCheck::Resolution(32.0);
    let checker = CollisionChecker::new(&robot, &scene, 0.0, resolution).unwrap();
    let mut scratch = checker.scratch();
    let free = free_states(&robot, &checker, &mut scratch, 1024);
    for count in [8, 16] {
        let batches: Vec<_> = free.chunks_exact(count).map(<[_]>::concat).collect();
        let mut next = batches.iter().cycle();
        c.bench_function(&format!("{count} free states"), |b| {
            b.iter(|| checker.are_valid(black_box(next.next().unwrap()), &mut scratch));
        });
    }
    let mut random = RandomStream::new(2, 0);
    let batches: Vec<Vec<f64>> = (0..64)
        .map(|_| (0..BATCH).flat_map(|_| random_state(&robot, &mut random)).collect())
        .collect();
    let mut next = batches.iter().cycle();
    c.bench_function("16 random states", |b| {
        b.iter(|| checker.are_valid(black_box(next.next().unwrap()), &mut scratch));
    });
    let nearby = |state: &Vec<f64>| {
        let mut moved = |q: &f64| q + random.uniform(-0.1, 0.1);
        (state.clone(), state.iter().map(&mut moved).collect::<Vec<_>>())
    };
    let motions: Vec<_> = free.iter().map(nearby).collect();
    for (name, proven) in [("sixteen samples", false), ("proven", true)] {
        let is_free = |from: &[f64], to: &[f64], scratch: &mut CollisionScratch| match proven {
            true => checker.is_motion_proven_free(from, to, scratch),
            false => checker.is_motion_valid(from, to, scratch),
        };
        let motions: Vec<_> =
            motions.iter().filter(|(from, to)| is_free(from, to, &mut scratch)).collect();
        let mut next = motions.iter().cycle();
        c.bench_function(&format!("free short motion, {name}"), |b| {
            b.iter(|| {
                let (from, to) = next.next().unwrap();
                is_free(black_box(from), black_box(to), &mut scratch)
            });
        });
    }
    c.bench_function("checker of a scene", |b| {
        b.iter(|| CollisionChecker::new(&robot, black_box(&scene), 0.0, resolution));
    });
}

criterion_group!(benches, forward_kinematics, checks);
criterion_main!(benches);
