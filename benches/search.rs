//! The cost of whole searches on one core.

use criterion::{Criterion, criterion_group, criterion_main};
use serde_json::{Value, json};
use takt::budget::Budget;
use takt::math::random::RandomStream;
use takt::plan::{PlanRequest, PreparedPlan, scenarios, validate};
use takt::robot::catalogue;

fn prepare(request: Value) -> Option<PreparedPlan> {
    validate(&PlanRequest::parse(request).ok()?, &catalogue::get).ok()
}

fn mcb_ab(optimizer: &Value, handling: &str, interpolation: &str) -> Option<PreparedPlan> {
    let mut request = scenarios::get("mcb-ab")?.request.clone();
    request["task"]["optimizer"] = optimizer.clone();
    request["task"]["constraint_handling"] = json!(handling);
    request["task"]["interpolation"] = json!(interpolation);
    prepare(request)
}

/// A random tour of a six-joint robot.
fn tour(waypoints: usize) -> Option<PreparedPlan> {
    let mut random = RandomStream::new(20, 0);
    let joint = |number: usize| {
        json!({ "name": format!("j{number}"), "type": "revolute",
            "limits": { "velocity": 2.0, "acceleration": 6.0, "jerk": 40.0 } })
    };
    let rows: Vec<Vec<f64>> =
        (0..waypoints).map(|_| (0..6).map(|_| random.uniform(-1.5, 1.5)).collect()).collect();
    let robot = json!({ "joints": (0..6).map(joint).collect::<Vec<_>>() });
    prepare(json!({ "robot": robot, "task": { "type": "waypoints", "waypoints": rows } }))
}

fn search(c: &mut Criterion) {
    let swarm = json!({ "name": "improved_pso", "population": 50, "iterations": 100 });
    let exact = json!({ "name": "exact" });
    let cases = [
        ("improved_pso 50x100 mcb-ab quintic", mcb_ab(&swarm, "repair_uniform", "quintic")),
        ("improved_pso 50x100 mcb-ab quintic_han", mcb_ab(&swarm, "repair_uniform", "quintic_han")),
        (
            "improved_pso 50x100 mcb-ab quintic, segment repair",
            mcb_ab(&swarm, "repair_segment", "quintic"),
        ),
        ("exact mcb-ab quintic", mcb_ab(&exact, "repair_uniform", "quintic")),
        ("exact mcb-ab quintic_han", mcb_ab(&exact, "repair_uniform", "quintic_han")),
        ("exact 20 waypoints", tour(20)),
    ];
    for (name, plan) in cases {
        let Some(plan) = plan else { continue };
        c.bench_function(name, |b| b.iter(|| plan.run(&Budget::default(), &|_| {}).is_ok()));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20)
        .warm_up_time(std::time::Duration::from_millis(500))
        .measurement_time(std::time::Duration::from_secs(3));
    targets = search
}
criterion_main!(benches);
