//! Configurations.

use takt::collision::{BATCH, CollisionChecker, MotionCheck};
use takt::math::random::RandomStream;
use takt::robot::catalogue;

use crate::reference::{ROBOTS, World, random_scene, random_state};

/// The reference is iterative and stops up to some 1e-5 above the truth, m.
const REFERENCE_ERROR: f64 = 5e-5;

/// Checks `count` states per robot, in scenes of a hundred states; free and touching ones, over all robots.
fn compare(count: usize, seed: u64) -> [usize; 2] {
    let mut seen = [0; 2];
    for (stream, name) in ROBOTS.iter().enumerate() {
        let robot = catalogue::get(name).unwrap();
        let mut random = RandomStream::new(seed, stream as u64);
        for _ in 0..count.div_ceil(100) {
            let scene = random_scene(&mut random);
            let checker = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap();
            let mut scratch = checker.scratch();
            let world = World::new(&robot, &scene);
            for _ in 0..100 {
                let state = random_state(&robot, &mut random);
                let free = checker.is_valid(&state, &mut scratch);
                let expected = world.clearance(&state);
                let doubtful = expected > 0.0 && expected <= REFERENCE_ERROR;
                assert!(
                    doubtful || free == (expected > 0.0),
                    "{name}: free {free}, but {expected} m away at {state:?}"
                );
                let clearance = checker.clearance(&state, &mut scratch).unwrap();
                let off = clearance.distance_m.max(0.0) - expected;
                assert!(
                    (-REFERENCE_ERROR..1e-9).contains(&off),
                    "{name}: {clearance:?}, {expected}"
                );
                assert_eq!(checker.contacts(&state, &mut scratch).is_empty(), free);
                seen[usize::from(!free)] += 1;
            }
        }
    }
    seen
}

#[test]
fn states_are_free_where_the_reference_says_so() {
    let [free, touching] = compare(2000, 1);
    assert!(free > 2000 && touching > 1500, "{free} free, {touching} touching");
}

/// `cargo test --release --test collision a_million -- --ignored`
#[test]
#[ignore = "minutes in release; the line above runs it"]
fn a_million_states_are_free_where_the_reference_says_so() {
    let [free, touching] = compare(1_000_000 / ROBOTS.len() + 1, 2);
    println!("{free} free, {touching} touching");
}

/// A batch is free only if all of it is, whichever of its states touches.
#[test]
fn batches_are_free_where_all_of_their_states_are() {
    let robot = catalogue::get("franka_panda").unwrap();
    let mut random = RandomStream::new(3, 0);
    let scene = random_scene(&mut random);
    let checker = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap();
    let mut scratch = checker.scratch();
    let (mut free, mut touching) = (Vec::new(), Vec::new());
    while free.len() < 40 || touching.len() < 40 {
        let state = random_state(&robot, &mut random);
        let valid = checker.is_valid(&state, &mut scratch);
        if valid { free.push(state) } else { touching.push(state) }
    }
    for count in 1..=BATCH {
        let batch = free[count..2 * count].concat();
        assert!(checker.are_valid(&batch, &mut scratch));
        for place in 0..count {
            let mut batch = batch.clone();
            batch[place * 7..(place + 1) * 7].copy_from_slice(&touching[count]);
            assert!(!checker.are_valid(&batch, &mut scratch), "{place} of {count}");
        }
    }
}

#[test]
fn states_that_are_no_numbers_are_not_free() {
    let robot = catalogue::get("ur5e").unwrap();
    let checker =
        CollisionChecker::new(&robot, &Default::default(), 0.0, MotionCheck::Proven).unwrap();
    let mut scratch = checker.scratch();
    assert!(checker.is_valid(&[0.0, -1.5, 0.5, 0.0, 0.0, 0.0], &mut scratch));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(!checker.is_valid(&[0.0, -1.5, 0.5, bad, 0.0, 0.0], &mut scratch));
        assert!(!checker.is_motion_valid(&[0.0; 6], &[bad; 6], &mut scratch));
    }
}
