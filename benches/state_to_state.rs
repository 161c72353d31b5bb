//! The cost of the fastest motion between two states, six joints, on one core.

use criterion::{Criterion, criterion_group, criterion_main};
use takt::math::random::RandomStream;
use takt::trajectory::jerk_limited::state_to_state::{State, between};
use takt::trajectory::kernel::KernelLimits;

const PROBLEMS: usize = 2000;
const JOINTS: usize = 6;

type Problem = (Vec<State>, Vec<State>, Vec<KernelLimits>);

/// A random position, at rest or in a motion that limits allow.
fn state(random: &mut RandomStream, limits: [f64; 3], moving: bool) -> State {
    let [velocity, acceleration, jerk] = limits;
    let position = random.uniform(-3.0, 3.0);
    if !moving {
        return State { position, ..State::default() };
    }
    loop {
        let v = random.uniform(-velocity, velocity);
        let a = random.uniform(-acceleration, acceleration);
        if v.abs() + a * a / (2.0 * jerk) <= velocity {
            return State { position, velocity: v, acceleration: a };
        }
    }
}

fn problem(random: &mut RandomStream, moving: bool) -> Problem {
    let mut problem: Problem = Default::default();
    for _ in 0..JOINTS {
        let derivatives =
            [random.uniform(0.5, 3.0), random.uniform(1.0, 15.0), random.uniform(5.0, 100.0)];
        problem.0.push(state(random, derivatives, moving));
        problem.1.push(state(random, derivatives, moving));
        let position = [f64::NEG_INFINITY, f64::INFINITY];
        problem.2.push(KernelLimits { derivatives, position });
    }
    problem
}

/// All problems in turn: a processor learns a single one by heart.
fn motions(c: &mut Criterion) {
    let mut group = c.benchmark_group("2000 motions between two states");
    for (name, moving) in [("at rest", false), ("moving", true)] {
        let mut random = RandomStream::new(21, 0);
        let problems: Vec<Problem> = (0..PROBLEMS).map(|_| problem(&mut random, moving)).collect();
        let duration = |(start, goal, limits): &Problem| {
            between(start, goal, limits).map_or(f64::NAN, |motion| motion.duration())
        };
        group.throughput(criterion::Throughput::Elements(PROBLEMS as u64));
        group.bench_function(name, |b| b.iter(|| problems.iter().map(duration).sum::<f64>()));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(500))
        .measurement_time(std::time::Duration::from_secs(3));
    targets = motions
}
criterion_main!(benches);
