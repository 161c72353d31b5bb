//! Straight and timed motions.

use takt::collision::{CollisionChecker, CollisionScratch, JointMotion, MotionCheck};
use takt::math::random::RandomStream;
use takt::robot::{Robot, catalogue};

use crate::reference::{ROBOTS, World, random_scene, random_state};

/// From a free state to one that is not far and mostly free.
fn ends(
    robot: &Robot,
    checker: &CollisionChecker,
    scratch: &mut CollisionScratch,
    random: &mut RandomStream,
) -> [Vec<f64>; 2] {
    let step = random.uniform(0.05, 3.0);
    loop {
        let from = random_state(robot, random);
        let to: Vec<_> = from.iter().map(|q| q + random.uniform(-step, step)).collect();
        let free = checker.is_valid(&to, scratch) || random.unit() < 0.2;
        if free && checker.is_valid(&from, scratch) {
            return [from, to];
        }
    }
}

fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(from, to)| from + share * (to - from)).collect()
}

/// The least clearance in `steps` steps, or the first that is none.
fn stepped(world: &World, from: &[f64], to: &[f64], steps: usize) -> f64 {
    let mut least = f64::INFINITY;
    for step in 0..=steps {
        least = least.min(world.clearance(&between(from, to, step as f64 / steps as f64)));
        if least <= 0.0 {
            break;
        }
    }
    least
}

/// Checks `count` motions per robot against fine steps; proven free, blocked, and blocked though steps found
/// more than `DOUBT` of room.
fn compare(count: usize, seed: u64) -> [usize; 3] {
    /// A proof gives up at a tenth of a millimetre, and steps miss a little.
    const DOUBT: f64 = 5e-4;
    let mut seen = [0; 3];
    for (stream, name) in ROBOTS.iter().enumerate() {
        let robot = catalogue::get(name).unwrap();
        let mut random = RandomStream::new(seed, stream as u64);
        for _ in 0..count.div_ceil(20) {
            let scene = random_scene(&mut random);
            let checker = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap();
            let mut scratch = checker.scratch();
            let world = World::new(&robot, &scene);
            for _ in 0..20 {
                let [from, to] = ends(&robot, &checker, &mut scratch, &mut random);
                let proven = checker.is_motion_valid(&from, &to, &mut scratch);
                let length = to.iter().zip(&from).map(|(a, b)| (a - b).abs());
                let steps = (length.fold(0.0, f64::max) / 0.01).ceil() as usize + 1;
                let least = stepped(&world, &from, &to, steps);
                assert!(!proven || least > 0.0, "{name}: false free from {from:?} to {to:?}");
                seen[usize::from(!proven)] += 1;
                let doubtful =
                    !proven && least > DOUBT && stepped(&world, &from, &to, 20 * steps) > DOUBT;
                seen[2] += usize::from(doubtful);
                // What is proven free is free at any resolution.
                let sampled = checker.is_motion_free_at(32.0, &from, &to, &mut scratch);
                assert!(sampled || !proven, "{name}: from {from:?} to {to:?}");
            }
        }
    }
    seen
}

#[test]
fn no_motion_is_called_free_that_fine_steps_find_blocked() {
    let [free, blocked, doubtful] = compare(200, 1);
    assert!(free > 100 && blocked > 100, "{free} {blocked}");
    assert_eq!(doubtful, 0);
}

/// `cargo test --release --test collision none_of_a_hundred -- --ignored`
#[test]
#[ignore = "many minutes in release; the line above runs it"]
fn none_of_a_hundred_thousand_motions_is_called_free_that_fine_steps_find_blocked() {
    let [free, blocked, doubtful] = compare(100_000 / ROBOTS.len() + 1, 2);
    println!("{free} free, {blocked} blocked, {doubtful} of them without a reason found");
}

/// Turns of several rounds are divided, and end where they should.
#[test]
fn long_turns_are_checked_over_all_their_length() {
    let robot = catalogue::get("ur5e").unwrap();
    let scene = serde_json::json!({"name": "post", "obstacles": [
        {"name": "post", "shape": {"type": "cylinder", "radius": 0.05, "length": 2},
            "pose": {"position": [-0.6, -0.3, 0]}}]});
    let scene = takt::scene::Scene::new(serde_json::from_value(scene).unwrap()).unwrap();
    let checker = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap();
    let mut scratch = checker.scratch();
    let mut from = [0.0, -0.4, 0.8, -0.4, 0.0, 0.0];
    from[0] = 1.0;
    assert!(checker.is_valid(&from, &mut scratch));
    let mut to = from;
    to[5] += 40.0;
    for check in [MotionCheck::Proven, MotionCheck::Resolution(32.0)] {
        let checker = CollisionChecker::new(&robot, &scene, 0.0, check).unwrap();
        assert!(checker.is_motion_valid(&from, &to, &mut scratch));
        let mut round = from;
        round[0] += 8.0 * std::f64::consts::PI;
        assert!(!checker.is_motion_valid(&from, &round, &mut scratch), "{check:?}");
    }
}

/// A joint-space cubic from rest to rest.
struct Ramp {
    from: Vec<f64>,
    to: Vec<f64>,
}

impl Ramp {
    fn share(time: f64) -> f64 {
        let u = time / 2.0;
        u * u * (3.0 - 2.0 * u)
    }
}

impl JointMotion for Ramp {
    fn duration(&self) -> f64 {
        2.0
    }

    fn position(&self, time: f64, position: &mut [f64]) {
        position.copy_from_slice(&between(&self.from, &self.to, Self::share(time)));
    }

    fn travel(&self, start: f64, end: f64, travel: &mut [f64]) {
        // The share is monotone, so the ends are furthest.
        let middle = Self::share(0.5 * (start + end));
        let share = (middle - Self::share(start)).max(Self::share(end) - middle);
        for (joint, travel) in travel.iter_mut().enumerate() {
            *travel = share * (self.to[joint] - self.from[joint]).abs();
        }
    }
}

#[test]
fn a_timed_motions_clearance_is_no_larger_than_any_step_finds_it() {
    let mut random = RandomStream::new(7, 0);
    let mut touching = 0;
    for name in ROBOTS {
        let robot = catalogue::get(name).unwrap();
        let scene = random_scene(&mut random);
        let checker = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap();
        let mut scratch = checker.scratch();
        let world = World::new(&robot, &scene);
        for _ in 0..10 {
            let [from, to] = ends(&robot, &checker, &mut scratch, &mut random);
            let ramp = Ramp { from, to };
            let found = checker.proven_clearance(&ramp, 1e-3, &mut scratch).unwrap().unwrap();
            let least = stepped(&world, &ramp.from, &ramp.to, 300);
            if found.smallest_m <= 0.0 {
                touching += 1;
                continue;
            }
            assert!(found.proven_m <= least + 1e-7, "{name}: {found:?}, but {least}");
            assert!(found.smallest_m - found.proven_m <= 1e-3, "{name}: {found:?}");
            let mut at = vec![0.0; robot.dof()];
            ramp.position(found.at, &mut at);
            assert!((world.clearance(&at) - found.smallest_m).abs() < 5e-5);
        }
    }
    assert!(touching > 3, "{touching}");
}
