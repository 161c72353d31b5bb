//! Time per evaluation of a particle swarm on benchmark functions, with the
//! optimizer's own overhead, on one core. `benches/peers/run.sh swarm pso` runs it
//! beside pyswarms and pygmo.

use std::collections::BTreeMap;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use serde_json::json;
use takt::budget::Budget;
use takt::fault::Faults;
use takt::optimize::{functions, minimize, optimizer};

const POPULATION: u64 = 30;
const DIMENSION: usize = 30;
const ITERATIONS: u64 = 1000;

fn swarm(c: &mut Criterion) {
    let mut group = c.benchmark_group("swarm 30 x 30");
    group.throughput(Throughput::Elements(POPULATION * (ITERATIONS + 1)));
    for (method, function) in [
        ("pso", "f1"),
        ("pso", "f6"),
        ("pso", "f7"),
        ("spso", "f6"),
        ("gold_sa", "f6"),
        ("golds_pso", "f6"),
        ("pso", "f8"),
    ] {
        let (Some(entry), Some(function)) = (optimizer(method), functions::function(function))
        else {
            continue;
        };
        let given = BTreeMap::from([
            ("population".to_owned(), json!(POPULATION)),
            ("iterations".to_owned(), json!(ITERATIONS)),
        ]);
        let settings = entry.settings(&given, "", &mut Faults::default());
        group.bench_function(format!("{method} {}", function.title), |b| {
            let mut seed = 0;
            b.iter(|| {
                seed += 1;
                let objective = function.objective(DIMENSION, false, seed);
                let mut search = (entry.build)(&settings, &objective, seed);
                let budget = Budget::default();
                minimize(&objective, search.as_mut(), ITERATIONS, &budget, &mut |_| {}).fitness
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(300))
        .measurement_time(std::time::Duration::from_secs(2));
    targets = swarm
}
criterion_main!(benches);
