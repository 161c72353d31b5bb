//! The task `program`: legs in order.

use std::cell::Cell;

use super::error::PlanError;
use super::prepared::{PreparedLeg, PreparedPlan, Progress};
use super::result::{LegResult, PlanResult, ProgramResult};
use super::waypoints;
use crate::budget::Budget;
use crate::math::random::derive_seed;

/// Plans every leg; fails with the first that fails.
pub fn plan(
    plan: &PreparedPlan,
    legs: &[PreparedLeg],
    budget: &Budget,
    progress: &dyn Fn(Progress),
) -> Result<PlanResult, PlanError> {
    let mut done: Vec<LegResult> = Vec::with_capacity(legs.len());
    let (mut start, mut evaluations) = (0.0, 0);
    for (index, PreparedLeg { name, note, task }) in legs.iter().enumerate() {
        let seed = derive_seed(plan.seed, index as u64);
        let latest = Cell::new(0);
        let report = |step: Progress| {
            latest.set(step.evaluations);
            let evaluations = evaluations + step.evaluations;
            progress(Progress { leg: Some(name.clone()), evaluations, ..step });
        };
        let hints = hints(&done, task.waypoints.len() - 1);
        match waypoints::plan_from(plan, task, &hints, seed, budget, &report) {
            Ok(result) => {
                evaluations += result.evaluations;
                let duration = result.duration;
                done.push(LegResult { name: name.clone(), note: note.clone(), start, result });
                start += duration;
            }
            Err(error) => {
                let partial = assemble(plan, done, start, evaluations + latest.get(), budget);
                return Err(error.in_leg(name).with_partial(partial));
            }
        }
    }
    Ok(assemble(plan, done, start, evaluations, budget))
}

/// Durations of the leg before, where it has as many segments: a cell repeats
/// its motions, forth and back.
fn hints(done: &[LegResult], segments: usize) -> Vec<Vec<f64>> {
    let before = done.last().map(|leg| &leg.result.durations);
    before.filter(|durations| durations.len() == segments).cloned().into_iter().collect()
}

fn assemble(
    plan: &PreparedPlan,
    legs: Vec<LegResult>,
    duration: f64,
    evaluations: u64,
    budget: &Budget,
) -> PlanResult {
    let certificates = || legs.iter().map(|leg| &leg.result.certificate);
    PlanResult::Program(ProgramResult {
        robot: plan.robot_name().to_owned(),
        joint_names: plan.limits.iter().map(|limit| limit.name.clone()).collect(),
        duration,
        lawful: certificates().all(|certificate| certificate.lawful),
        worst_ratio: certificates().map(|c| c.worst_ratio).fold(0.0, f64::max),
        evaluations,
        planning_s: budget.elapsed_s(),
        seed: plan.seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        legs,
    })
}
