//! The task `program`: legs in order.

use std::cell::Cell;
use std::collections::HashSet;

use super::error::PlanError;
use super::prepare::{Check, MAX_LEGS};
use super::prepared::{PreparedLeg, PreparedPlan, Progress};
use super::request::{Leg, ProgramTask};
use super::result::{LegResult, PlanResult, ProgramResult};
use super::{ends, waypoints};
use crate::budget::Budget;
use crate::fault::Faults;
use crate::math::random::derive_seed;

/// Most characters of a leg's note.
const MAX_NOTE: usize = 200;

impl Check<'_> {
    /// Checks the legs of `task`, each where the one before it ended.
    pub(super) fn program(
        &self,
        task: &ProgramTask,
        faults: &mut Faults,
    ) -> Option<Vec<PreparedLeg>> {
        let count = task.legs.len();
        if count == 0 || count > MAX_LEGS {
            faults.add("/task/legs", format!("{count} legs; 1 to {MAX_LEGS} are taken"));
            return None;
        }
        let mut names = HashSet::new();
        let mut legs = Vec::with_capacity(count);
        let mut before: Option<Vec<Vec<f64>>> = None;
        for (index, leg) in task.legs.iter().enumerate() {
            let place = format!("/task/legs/{index}");
            check_words(leg, &mut names, &place, faults);
            let pointer = format!("{place}/task");
            let end = before.as_ref().and_then(|waypoints| waypoints.last());
            let waypoints = self.resolve(
                &leg.task.waypoints,
                end.map(Vec::as_slice),
                &format!("{pointer}/waypoints"),
                faults,
            );
            if let Some(task) = self.resolved(&leg.task, waypoints.clone(), &pointer, faults) {
                legs.push(PreparedLeg { name: leg.name.clone(), note: leg.note.clone(), task });
            }
            if index > 0 {
                let start = waypoints.as_ref().and_then(|waypoints| waypoints.first());
                self.connection([&task.legs[index - 1], leg], [end, start], &place, faults);
            }
            before = waypoints;
        }
        (legs.len() == count).then_some(legs)
    }

    /// A leg starts where the one before it ended, and as fast; nothing is said of waypoints that are not known.
    fn connection(
        &self,
        [before, leg]: [&Leg; 2],
        [end, start]: [Option<&Vec<f64>>; 2],
        place: &str,
        faults: &mut Faults,
    ) {
        let (Some(end), Some(start)) = (end, start) else { return };
        let apart = end.iter().zip(start).position(|(end, start)| (end - start).abs() > 1e-9);
        if let Some(joint) = apart {
            let name = self.limits.get(joint).map_or("", |limit| &limit.name);
            let detail = format!(
                "leg {} starts with {name} at {}, but leg {} ends at {}",
                leg.name, start[joint], before.name, end[joint]
            );
            faults.add(format!("{place}/task/waypoints/0/{joint}"), detail);
        }
        ends::connection(before, leg, self.limits, place, faults);
    }
}

/// A leg's name and note.
fn check_words<'a>(
    leg: &'a Leg,
    names: &mut HashSet<&'a String>,
    place: &str,
    faults: &mut Faults,
) {
    if leg.name.is_empty() || leg.name.chars().count() > 64 {
        faults.add(format!("{place}/name"), "a leg's name has 1 to 64 characters");
    }
    if !names.insert(&leg.name) {
        faults.add(format!("{place}/name"), format!("another leg is called `{}`", leg.name));
    }
    let length = leg.note.as_ref().map_or(0, |note| note.chars().count());
    if length > MAX_NOTE {
        let detail = format!("{length} characters; a note has at most {MAX_NOTE}");
        faults.add(format!("{place}/note"), detail);
    }
}

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
