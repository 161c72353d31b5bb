//! Motions whose durations no optimizer searches.

use serde_json::json;

use super::error::PlanError;
use super::optimum::Optimum;
use super::prepared::Progress;
use super::waypoints::{Run, Timed, required_scale, times};
use crate::budget::StopReason;
use crate::optimize::{ConvergencePoint, Solution};
use crate::trajectory::interpolation::{Profile, ProfileLimits};
use crate::trajectory::jerk_limited::state_to_state::StateFault;
use crate::trajectory::jerk_limited::{Demand, Stage, fastest_between, fastest_within};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::{Rooms, Trajectory};

/// Rounds in which a motion loses what rounding left above a limit.
const ROUNDINGS: usize = 4;

impl Run<'_> {
    /// Stops at every waypoint, with a profile known in closed form.
    pub(super) fn closed_form(&self, profile: fn(&[f64], &[ProfileLimits]) -> Profile) -> Timed {
        let limits: Vec<ProfileLimits> = self
            .limits
            .iter()
            .map(|limit| ProfileLimits {
                velocity: limit.derivative(0),
                acceleration: limit.derivative(1),
            })
            .collect();
        let (mut pieces, mut lengths, mut durations) = (Vec::new(), Vec::new(), Vec::new());
        for pair in self.task.waypoints.windows(2) {
            let way: Vec<f64> = pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect();
            let mut duration = 0.0;
            for (length, coefficients) in profile(&way, &limits).pieces {
                let joint = |(start, way): (&f64, &f64)| {
                    let mut scaled: Vec<f64> = coefficients.iter().map(|c| c * way).collect();
                    scaled[0] += start;
                    scaled
                };
                pieces.push(pair[0].iter().zip(&way).map(joint).collect());
                lengths.push(length);
                duration += length;
            }
            durations.push(duration);
        }
        let breakpoints = times(&lengths, lengths.iter().sum());
        let mut trajectory = Trajectory { breakpoints, pieces };
        let scale = required_scale(&trajectory, self.limits, 2);
        if scale > 1.0 {
            let factor = scale * (1.0 + f64::EPSILON);
            trajectory.stretch(factor);
            durations.iter_mut().for_each(|t| *t *= factor);
        }
        let total = durations.iter().sum();
        Timed {
            durations,
            trajectory,
            initial_duration: total,
            solution: self.unsearched(total),
            per_joint: None,
            reference: None,
            front: None,
            optimum: None,
            without_tcp_limit: None,
        }
    }

    /// What a search would tell that had nothing to search.
    pub(super) fn unsearched(&self, duration: f64) -> Solution {
        let point = ConvergencePoint {
            iteration: 0,
            evaluations: 1,
            elapsed_s: self.budget.elapsed_s(),
            best: Some(duration),
            mean: None,
        };
        Solution {
            position: None,
            fitness: duration,
            convergence: vec![point],
            stop_reason: StopReason::Converged,
            iterations: 0,
            evaluations: 1,
        }
    }

    /// The fastest motion of all. Its iterations are Newton steps.
    pub(super) fn fastest(&self) -> Result<Timed, PlanError> {
        let limits: Vec<KernelLimits> =
            self.limits.iter().map(|limit| limit.kernel(self.orders())).collect();
        let lower_bound = self.lower_bound();
        let mut convergence = Vec::new();
        let mut tell = |stage: Stage| {
            let point = ConvergencePoint {
                iteration: stage.iterations as u64,
                evaluations: stage.iterations as u64,
                elapsed_s: self.budget.elapsed_s(),
                best: Some(stage.duration),
                mean: None,
            };
            (self.progress)(Progress {
                iteration: point.iteration,
                evaluations: point.evaluations,
                elapsed_s: point.elapsed_s,
                best: point.best,
                mean: None,
                lower_bound,
                ..Progress::default()
            });
            convergence.push(point);
        };
        let (waypoints, budget, rooms) =
            (&self.task.waypoints, self.budget, self.task.rooms(self.limits));
        let (rooms, ends) = (Rooms::new(&rooms), self.task.ends.as_ref());
        let demand = Demand { rooms, ends, ..Demand::new(waypoints, &limits) };
        let found = match ends {
            None => fastest_within(&demand, budget, &mut tell),
            Some(_) => fastest_between(&demand, budget, &mut tell)
                .map_err(|faults| state_error(&faults))?,
        };
        self.still_wanted()?;
        // With fewer limits than there are the motion says nothing about lawful ones.
        let optimum = (self.orders() == 3)
            .then(|| Optimum::of(&found, waypoints, self.limits, rooms, self.task.rests()));
        let without_tcp_limit = self.tcp_limit.map(|_| found.trajectory.duration());
        let found = self.slowed_where_needed(found, &demand)?;
        let (mut trajectory, mut durations) = (found.trajectory, found.durations);
        // Ends in motion would not stand it, and what they leave to rounding is within its tolerance.
        let rounds = if self.task.ends.is_none() { ROUNDINGS } else { 0 };
        for _ in 0..rounds {
            let scale = required_scale(&trajectory, self.limits, self.orders());
            if scale <= 1.0 {
                break;
            }
            let factor = scale * (1.0 + f64::EPSILON);
            trajectory.stretch(factor);
            durations.iter_mut().for_each(|t| *t *= factor);
        }
        let ended =
            if found.converged { StopReason::Converged } else { StopReason::IterationLimit };
        let solution = Solution {
            position: None,
            fitness: trajectory.duration(),
            convergence,
            stop_reason: self.budget.stop_reason(0).unwrap_or(ended),
            iterations: found.iterations as u64,
            evaluations: found.iterations as u64,
        };
        Ok(Timed {
            durations,
            trajectory,
            initial_duration: found.stopping,
            solution,
            per_joint: None,
            reference: None,
            front: None,
            optimum,
            without_tcp_limit,
        })
    }
}

/// States at the ends that validation let through although nothing can be computed from them.
fn state_error(faults: &[StateFault]) -> PlanError {
    let faults: Vec<String> = faults.iter().map(StateFault::to_string).collect();
    PlanError::unreachable(faults.join("; "), json!({ "faults": faults }))
}
