//! Plans members side by side: every member writes its own place, so the
//! result does not depend on how many threads there are.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::json;

use super::prepare::{PreparedFamily, PreparedMember};
use super::result::{FamilyResult, MemberFailure, MemberResult, MostBinding};
use crate::budget::Budget;
use crate::math::statistics::quantile;
use crate::plan::error::{PlanCode, PlanError};
use crate::plan::prepared::{MembersDone, Progress};
use crate::plan::result::{PlanResult, TrajectoryResult};
use crate::plan::side_by_side::side_by_side;

/// Least time between two reports from within members, s.
const REPORT_EVERY_S: f64 = 1e-3;

/// Plans all members.
pub(in crate::plan) fn run(
    family: &PreparedFamily,
    seed: u64,
    budget: &Budget,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<PlanResult, PlanError> {
    let tally = Tally { latest: f64::NEG_INFINITY, ..Tally::default() };
    let evaluations = AtomicU64::new(0);
    let session = Session { family, seed, budget, progress, evaluations, tally: Mutex::new(tally) };
    let rows = side_by_side(family.members.len(), |index| session.member(index));
    session.finish(rows)
}

/// What all members share.
struct Session<'a> {
    family: &'a PreparedFamily,
    seed: u64,
    budget: &'a Budget,
    progress: &'a (dyn Fn(Progress) + Sync),
    evaluations: AtomicU64,
    /// Locked while reporting, so that reports never go back.
    tally: Mutex<Tally>,
}

/// How far all members together have come.
#[derive(Default)]
struct Tally {
    done: usize,
    failed: usize,
    fastest: Option<f64>,
    /// The slowest plan so far and its member's number.
    slowest: Option<(usize, Box<TrajectoryResult>)>,
    /// When something was last reported, s.
    latest: f64,
}

impl Tally {
    /// Takes a plan in; of two equally slow ones the earlier member's is kept,
    /// whichever thread was first.
    fn planned(&mut self, index: usize, result: Box<TrajectoryResult>) {
        let duration = result.duration;
        self.fastest = Some(self.fastest.map_or(duration, |least| least.min(duration)));
        let slower = self.slowest.as_ref().is_none_or(|(first, slowest)| {
            duration > slowest.duration || duration == slowest.duration && index < *first
        });
        if slower {
            self.slowest = Some((index, result));
        }
    }
}

impl Session<'_> {
    /// The member's row; none if the run was ended before it was planned.
    fn member(&self, index: usize) -> Option<MemberResult> {
        if self.budget.stop_reason(0).is_some() {
            return None;
        }
        let member = self.family.members.get(index)?;
        let seen = AtomicU64::new(0);
        let report = |step: Progress| {
            let before = seen.fetch_max(step.evaluations, Ordering::Relaxed);
            let more = step.evaluations.saturating_sub(before);
            self.evaluations.fetch_add(more, Ordering::Relaxed);
            if let Ok(mut tally) = self.tally.try_lock()
                && self.budget.elapsed_s() >= tally.latest + REPORT_EVERY_S
            {
                self.report(member, &mut tally);
            }
        };
        let planned = member.plan.run(self.budget, &report);
        let evaluations = seen.into_inner();
        let row = MemberResult::new(member, &planned, evaluations)?;
        let mut tally = self.tally();
        tally.done += 1;
        match planned {
            Ok(PlanResult::Trajectory(result)) => tally.planned(index, result),
            _ => tally.failed += 1,
        }
        self.report(member, &mut tally);
        Some(row)
    }

    fn tally(&self) -> MutexGuard<'_, Tally> {
        self.tally.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn report(&self, member: &PreparedMember, tally: &mut Tally) {
        tally.latest = self.budget.elapsed_s();
        (self.progress)(Progress {
            iteration: tally.done as u64,
            evaluations: self.evaluations.load(Ordering::Relaxed),
            elapsed_s: tally.latest,
            best: tally.fastest,
            leg: Some(member.name.clone()),
            members: Some(MembersDone {
                done: tally.done,
                of: self.family.members.len(),
                failed: tally.failed,
                slowest: tally.slowest.as_ref().map(|(_, slowest)| slowest.duration),
            }),
            ..Progress::default()
        });
    }

    fn finish(self, rows: Vec<Option<MemberResult>>) -> Result<PlanResult, PlanError> {
        let unfinished = rows.iter().any(Option::is_none);
        let stopped =
            self.budget.stop_reason(0).filter(|_| unfinished).and_then(PlanError::stopped);
        let rows: Vec<MemberResult> = rows.into_iter().flatten().collect();
        let slowest = self.tally().slowest.take();
        let Some((index, worst_case)) = slowest else {
            return Err(stopped.unwrap_or_else(|| all_failed(&rows)));
        };
        let slowest = self.family.members[index].name.clone();
        let result = PlanResult::Family(self.assemble(rows, slowest, worst_case));
        match stopped {
            Some(error) => Err(error.with_partial(result)),
            None => Ok(result),
        }
    }

    fn assemble(
        &self,
        members: Vec<MemberResult>,
        slowest: String,
        worst_case: Box<TrajectoryResult>,
    ) -> FamilyResult {
        let mut planned: Vec<(f64, &str)> =
            members.iter().filter_map(|row| Some((row.duration?, row.name.as_str()))).collect();
        // Stable: of equal ones the first stays first.
        planned.sort_by(|a, b| a.0.total_cmp(&b.0));
        let durations: Vec<f64> = planned.iter().map(|(duration, _)| *duration).collect();
        let median_duration = quantile(&durations, 0.5).unwrap_or(worst_case.duration);
        let (least, fastest) = planned.first().copied().unwrap_or((worst_case.duration, &slowest));
        let failed = members.len() - planned.len();
        let verdict = format!(
            "{} of {} members planned: {least:.4} s (`{fastest}`) to {:.4} s (`{slowest}`), \
             median {median_duration:.4} s",
            planned.len(),
            self.family.members.len(),
            worst_case.duration,
        );
        FamilyResult {
            robot: worst_case.robot.clone(),
            verdict,
            sweep: self.family.sweep.clone(),
            fastest: fastest.to_owned(),
            slowest,
            median_duration,
            failed,
            lawful: members.iter().filter_map(|row| row.lawful).all(|lawful| lawful),
            worst_ratio: members.iter().filter_map(|row| row.worst_ratio).fold(0.0, f64::max),
            evaluations: members.iter().map(|row| row.evaluations).sum(),
            worst_case,
            members,
            planning_s: self.budget.elapsed_s(),
            seed: self.seed,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// The error of a family of which no member can be planned.
fn all_failed(rows: &[MemberResult]) -> PlanError {
    let first = rows.iter().find_map(|row| Some((&row.name, row.failure.as_ref()?)));
    let first = first.map(|(name, failure)| format!("; {name}: {}", failure.message));
    let failures: Vec<_> = rows
        .iter()
        .filter_map(|row| {
            Some(json!({ "name": row.name, "message": row.failure.as_ref()?.message }))
        })
        .collect();
    let message =
        format!("none of {} members can be planned{}", rows.len(), first.unwrap_or_default());
    PlanError::unreachable(message, json!({ "members": failures }))
}

impl MemberResult {
    /// The row of a member; none if it was ended from outside. `evaluations`
    /// are those of a member that failed.
    fn new(
        member: &PreparedMember,
        planned: &Result<PlanResult, PlanError>,
        evaluations: u64,
    ) -> Option<Self> {
        let row = Self {
            name: member.name.clone(),
            values: member.values.clone(),
            duration: None,
            lower_bound: None,
            gap: None,
            lawful: None,
            worst_ratio: None,
            most_binding: None,
            evaluations,
            failure: None,
        };
        match planned {
            Ok(PlanResult::Trajectory(result)) => Some(Self {
                duration: Some(result.duration),
                lower_bound: result.bound.as_ref().map(|bound| bound.lower),
                gap: result.bound.as_ref().map(|bound| bound.gap),
                lawful: Some(result.certificate.lawful),
                worst_ratio: Some(result.certificate.worst_ratio),
                most_binding: MostBinding::of(&result.metrics),
                evaluations: result.evaluations,
                ..row
            }),
            Err(PlanError { code, message, details, .. })
                if *code == PlanCode::LimitsUnreachable =>
            {
                let (code, message) = (code.as_str().to_owned(), message.clone());
                let details = details.clone();
                Some(Self { failure: Some(MemberFailure { code, message, details }), ..row })
            }
            // Validation lets no other task through.
            Ok(_) | Err(_) => None,
        }
    }
}
