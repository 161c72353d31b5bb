//! The task `waypoints`: through joint waypoints in the least time.

use serde_json::json;

use super::error::PlanError;
use super::metrics::metrics;
use super::optimum::Optimum;
use super::pareto::{self, ParetoFront};
use super::prepared::{LEAST_WAY, PreparedPlan, PreparedWaypoints, Progress};
use super::request::{Clock, ConstraintHandling, Constraints, DurationGoal, DurationRange};
use super::result::{JointOptimum, PlanMetrics, PlanResult, TrajectoryResult};
use crate::budget::{Budget, StopReason};
use crate::math::random::derive_seed;
use crate::optimize::{
    ConvergencePoint, Objective, OptimizerEntry, SideBySide, Solution, minimize,
};
use crate::trajectory::interpolation::Timing;
use crate::trajectory::kernel::Kernel;
use crate::trajectory::objective::Measures;
use crate::trajectory::timing::{Handling, TimingProblem};
use crate::trajectory::{
    Certificate, JointBounds, LowerBound, Rooms, TcpLimit, Trajectory, Violation,
};

/// Polynomials a plan may have to be certified even though it was cancelled:
/// more would delay the end by more than a few hundredths of a second.
const SHOWN_WHEN_CANCELLED: usize = 2_000;

/// How far rounding may carry a duration out of its range, relative.
const RANGE_TOLERANCE: f64 = 1e-9;

/// Plans one waypoint task.
pub fn plan(
    plan: &PreparedPlan,
    task: &PreparedWaypoints,
    seed: u64,
    budget: &Budget,
    progress: &dyn Fn(Progress),
) -> Result<TrajectoryResult, PlanError> {
    plan_from(plan, task, &[], seed, budget, progress)
}

/// Plans one waypoint task, starting also from `hints`: durations that were
/// best for similar waypoints.
pub fn plan_from(
    plan: &PreparedPlan,
    task: &PreparedWaypoints,
    hints: &[Vec<f64>],
    seed: u64,
    budget: &Budget,
    progress: &dyn Fn(Progress),
) -> Result<TrajectoryResult, PlanError> {
    // The fastest motion itself says how short any could be.
    let tells = matches!(task.interpolation.timing, Timing::Free) && orders(task) == 3;
    let optimum = (!tells).then(|| Optimum::find(task, &plan.limits, budget));
    let (limits, side_by_side) = (&plan.limits[..], plan.side_by_side);
    let tcp_limit = plan.tcp_limit();
    let run = Run { task, limits, tcp_limit, side_by_side, hints, seed, budget, progress, optimum };
    let stopped = || budget.stop_reason(0).and_then(PlanError::stopped);
    let timed = match &task.interpolation.timing {
        Timing::Search(kernel) => run.search(*kernel)?,
        Timing::ClosedForm(profile) => run.closed_form(*profile),
        Timing::Free => run.fastest()?,
    };
    let timed = run.keep_tcp_speed(timed);
    // A search that was ended says nothing about what the limits admit.
    let timed = run.reach_goal(timed).map_err(|error| stopped().unwrap_or(error))?;
    run.check_computable(&timed)?;
    let range = run.check_range(&timed.durations);
    let result = run.assemble(plan, timed);
    let beyond = run.violation(&result.certificate).map(violation_error);
    match stopped().or(beyond).or(range.err()) {
        Some(error) => Err(error.with_partial(PlanResult::Trajectory(Box::new(result)))),
        None => Ok(result),
    }
}

/// How many derivatives the optimizer minds.
fn orders(task: &PreparedWaypoints) -> usize {
    match task.constraints {
        Constraints::Full => 3,
        Constraints::VelocityOnly => 1,
    }
}

/// Poses the timing problem of some of a task's joints for `optimizer`.
pub(super) fn pose(
    task: &PreparedWaypoints,
    limits: &[JointBounds],
    kernel: &'static dyn Kernel,
    joints: &[usize],
    optimizer: &OptimizerEntry,
) -> TimingProblem {
    let pick = |row: &Vec<f64>| joints.iter().map(|&joint| row[joint]).collect();
    let waypoints: Vec<Vec<f64>> = task.waypoints.iter().map(pick).collect();
    let limits: Vec<_> = joints.iter().map(|&joint| limits[joint].kernel(orders(task))).collect();
    // The exact method, and weights, know no other way than the scaling law.
    let by_scaling = optimizer.is_deterministic() || task.weights.is_weighted();
    let handling = if by_scaling { Handling::RepairUniform } else { handling(task.handling) };
    let range = task.range.map(|range| [range.min, range.max]);
    TimingProblem::new(kernel, &waypoints, &limits, handling, range)
}

/// One task being planned.
pub(super) struct Run<'a> {
    pub(super) task: &'a PreparedWaypoints,
    pub(super) limits: &'a [JointBounds],
    pub(super) tcp_limit: Option<TcpLimit<'a>>,
    /// True if other plans keep the threads busy.
    pub(super) side_by_side: bool,
    pub(super) hints: &'a [Vec<f64>],
    pub(super) seed: u64,
    pub(super) budget: &'a Budget,
    pub(super) progress: &'a dyn Fn(Progress),
    /// What the limits admit, unless the plan itself will tell.
    pub(super) optimum: Option<Optimum>,
}

/// A plan in seconds, before it is certified.
pub(super) struct Timed {
    /// Duration of each segment between waypoints.
    pub(super) durations: Vec<f64>,
    pub(super) trajectory: Trajectory,
    pub(super) initial_duration: f64,
    pub(super) solution: Solution,
    pub(super) per_joint: Option<Vec<JointOptimum>>,
    /// Measures of the fastest motion, where they were needed.
    pub(super) reference: Option<Measures>,
    pub(super) front: Option<ParetoFront>,
    /// What the limits admit, where planning told.
    pub(super) optimum: Option<Optimum>,
    /// How long the motion would take without the limit of the tool's speed, s, where there is one.
    pub(super) without_tcp_limit: Option<f64>,
}

/// Segment durations, how they were found, and each joint's own.
type Found = (Vec<f64>, Solution, Option<Vec<JointOptimum>>);

impl Run<'_> {
    pub(super) fn orders(&self) -> usize {
        orders(self.task)
    }

    /// No lawful trajectory is shorter, s, as far as known before planning.
    pub(super) fn lower_bound(&self) -> Option<f64> {
        let (task, limits) = (self.task, self.limits);
        let rooms = task.rooms(limits);
        let elementary =
            || LowerBound::elementary(&task.waypoints, limits, Rooms::new(&rooms), task.rests());
        let bound = self.optimum.as_ref().map_or_else(elementary, |it| it.bound.clone());
        bound.map(|bound| bound.lower)
    }

    fn problem(&self, kernel: &'static dyn Kernel, joints: &[usize]) -> TimingProblem {
        pose(self.task, self.limits, kernel, joints, self.task.optimizer)
    }

    /// The run's budget within the optimizer's own limits, from now.
    fn search_budget(&self) -> Budget {
        let settings = &self.task.settings;
        let time_limit = settings.optional("time_limit_s").map(std::time::Duration::from_secs_f64);
        let evaluations = settings.optional("max_evaluations").map(|limit| limit as u64);
        self.budget.clone().with_time_limit(time_limit).with_max_evaluations(evaluations)
    }

    /// Searches with the task's optimizer, whose generations count from
    /// `before`.
    pub(super) fn minimize(
        &self,
        problem: &dyn Objective,
        seed: u64,
        budget: &Budget,
        before: (u64, u64),
    ) -> Result<(Vec<f64>, Solution), PlanError> {
        let settings = &self.task.settings;
        let alone = SideBySide(problem);
        let problem = if self.side_by_side { &alone } else { problem };
        let mut optimizer = (self.task.optimizer.build)(settings, problem, seed);
        // A bound on the duration says nothing about a weighted sum.
        let lower = self.lower_bound().filter(|_| !self.task.weights.is_weighted());
        let mut report = |point: &ConvergencePoint| {
            (self.progress)(Progress {
                iteration: before.0 + point.iteration,
                evaluations: before.1 + point.evaluations,
                elapsed_s: point.elapsed_s,
                best: point.best,
                mean: point.mean,
                lower_bound: lower,
                ..Progress::default()
            });
        };
        let iterations = settings.integer("iterations");
        let solution = minimize(problem, optimizer.as_mut(), iterations, budget, &mut report);
        match &solution.position {
            Some(position) => Ok((position.clone(), solution)),
            None => Err(PlanError::stopped(solution.stop_reason)
                .filter(|_| self.budget.stop_reason(0).is_some())
                .unwrap_or_else(|| no_candidate(&solution))),
        }
    }

    fn search(&self, kernel: &'static dyn Kernel) -> Result<Timed, PlanError> {
        let all: Vec<usize> = (0..self.limits.len()).collect();
        let problem = self.problem(kernel, &all).with_hints(self.hints);
        let natural = problem.natural();
        let initial_duration = problem.scale(natural) * natural.iter().sum::<f64>();
        if let Some(durations) = &self.task.fixed {
            return Ok(self.fixed(&problem, durations, initial_duration));
        }
        let budget = self.search_budget();
        let mut fastest = None;
        let (durations, solution, per_joint) = match self.task.clock {
            Clock::Shared if self.task.weights.is_weighted() => {
                let found = self.weighted(&problem, &budget)?;
                fastest = Some(found.fastest);
                (found.durations, found.solution, None)
            }
            Clock::Shared => {
                let (position, solution) = self.minimize(&problem, self.seed, &budget, (0, 0))?;
                (problem.decode(&position), solution, None)
            }
            Clock::PerJoint => self.each_joint_alone(kernel, &problem, &budget)?,
        };
        self.still_wanted()?;
        let reference = fastest.as_ref().map(|durations| problem.measures(durations));
        let (durations, trajectory) = self.lawful(&problem, durations);
        let mut timed = Timed {
            durations,
            trajectory,
            initial_duration,
            solution,
            per_joint,
            reference,
            front: None,
            optimum: None,
            without_tcp_limit: None,
        };
        if let Some(request) = &self.task.pareto {
            let fastest = fastest.unwrap_or_else(|| timed.durations.clone());
            timed.front = Some(pareto::front(
                self,
                &problem,
                request,
                &fastest,
                &budget,
                &mut timed.solution,
            ));
        }
        Ok(timed)
    }

    /// The motion with given durations.
    fn fixed(&self, problem: &TimingProblem, durations: &[f64], initial_duration: f64) -> Timed {
        let trajectory = problem.trajectory(durations);
        let solution = self.unsearched(trajectory.duration());
        Timed {
            durations: durations.to_vec(),
            trajectory,
            initial_duration,
            solution,
            per_joint: None,
            reference: None,
            front: None,
            optimum: None,
            without_tcp_limit: None,
        }
    }

    /// A limit that the plan has to keep and does not.
    pub(super) fn violation<'c>(&self, certificate: &'c Certificate) -> Option<&'c Violation> {
        let full = self.task.constraints == Constraints::Full;
        // What is not executable breaks limits where it jumps, and says so; no other
        // excess is excused.
        let jumps = |v: &Violation| !self.task.interpolation.executable && v.value.is_none();
        certificate.violations.iter().find(|v| v.limit == "position" || full && !jumps(v))
    }

    /// A run that was interrupted is planned again, and one that was cancelled
    /// has to end soon: neither is worth certifying a large plan.
    pub(super) fn still_wanted(&self) -> Result<(), PlanError> {
        let large = self.task.waypoints.len() * self.limits.len() > SHOWN_WHEN_CANCELLED;
        let unwanted = self.budget.stop_reason(0).filter(|reason| match reason {
            StopReason::Interrupted => true,
            StopReason::Cancelled => large,
            _ => false,
        });
        unwanted.and_then(PlanError::stopped).map_or(Ok(()), Err)
    }

    /// Each joint alone, then per segment the largest time over the joints that
    /// move in it (Han, Chen, Shu), stretched where that breaks a limit: peaks
    /// depend on proportions, so the largest times alone prove nothing.
    fn each_joint_alone(
        &self,
        kernel: &'static dyn Kernel,
        shared: &TimingProblem,
        budget: &Budget,
    ) -> Result<Found, PlanError> {
        let waypoints = &self.task.waypoints;
        let mut durations = vec![0.0f64; waypoints.len() - 1];
        let mut optima = Vec::new();
        let mut total: Option<Solution> = None;
        for (joint, limit) in self.limits.iter().enumerate() {
            let way = |at: usize| (waypoints[at + 1][joint] - waypoints[at][joint]).abs();
            let moves = |segment: usize| way(segment) >= LEAST_WAY;
            if !(0..durations.len()).any(moves) {
                continue;
            }
            self.still_wanted()?;
            let before = total.as_ref().map_or((0, 0), |t| (t.iterations, t.evaluations));
            let problem = self.problem(kernel, &[joint]);
            let seed = derive_seed(self.seed, joint as u64);
            let (position, solution) = self.minimize(&problem, seed, budget, before)?;
            let alone = problem.decode(&position);
            for (segment, (longest, t)) in durations.iter_mut().zip(&alone).enumerate() {
                if moves(segment) {
                    *longest = longest.max(*t);
                }
            }
            optima.push(JointOptimum {
                joint: limit.name.clone(),
                duration: alone.iter().sum(),
                durations: alone,
                evaluations: solution.evaluations,
            });
            total = Some(match total {
                Some(total) => join(total, solution),
                None => solution,
            });
        }
        let Some(solution) = total else {
            // Validation lets no request through in which nothing moves.
            return Err(PlanError::unreachable("no joint moves".to_owned(), json!({})));
        };
        let scale = shared.scale(&durations);
        if scale > 1.0 {
            durations.iter_mut().for_each(|t| *t *= scale);
        }
        Ok((durations, solution, Some(optima)))
    }

    /// The trajectory for `durations`, stretched by rounding's share where the
    /// certificate would find a peak above its limit.
    pub(super) fn lawful(
        &self,
        problem: &TimingProblem,
        mut durations: Vec<f64>,
    ) -> (Vec<f64>, Trajectory) {
        for _ in 0..4 {
            let trajectory = problem.trajectory(&durations);
            let scale = required_scale(&trajectory, self.limits, self.orders());
            if scale <= 1.0 {
                return (durations, trajectory);
            }
            durations.iter_mut().for_each(|t| *t *= scale * (1.0 + f64::EPSILON));
        }
        let trajectory = problem.trajectory(&durations);
        (durations, trajectory)
    }

    /// Stretches to the duration asked for, or says that it cannot be reached.
    fn reach_goal(&self, mut timed: Timed) -> Result<Timed, PlanError> {
        let shortest = timed.trajectory.duration();
        let (wanted, exactly) = match self.task.goal {
            None => return Ok(timed),
            Some(DurationGoal::Exactly(wanted)) => (wanted, true),
            Some(DurationGoal::AtMost(wanted)) => (wanted, false),
        };
        if shortest > wanted * (1.0 + 1e-12) {
            return Err(self.goal_missed(wanted, shortest, &timed));
        }
        if exactly {
            let factor = wanted / shortest;
            timed.trajectory.stretch(factor);
            timed.durations.iter_mut().for_each(|t| *t *= factor);
            // The user's number, not the sum of rounded ones.
            if let Some(end) = timed.trajectory.breakpoints.last_mut() {
                *end = wanted;
            }
        }
        Ok(timed)
    }

    /// Why the plan takes longer than was wanted: no trajectory can do it, or only this one cannot.
    fn goal_missed(&self, wanted: f64, shortest: f64, timed: &Timed) -> PlanError {
        let task = self.task;
        let by = match task.interpolation.timing {
            Timing::Search(_) => {
                format!("{} with {}", task.interpolation.name, task.optimizer.name)
            }
            _ => task.interpolation.name.to_owned(),
        };
        let mut message = format!(
            "{by} needs {shortest:.6} s within the limits, more than the {wanted} s asked for"
        );
        let optimum = timed.optimum.as_ref().or(self.optimum.as_ref());
        let lower = optimum.and_then(|it| it.bound.as_ref()).map(|bound| bound.lower);
        let binding = optimum.map_or(&[][..], |it| &it.sensitivities);
        // Of joints' limits alone: with one on the tool it tells nothing.
        let optimum = optimum.filter(|_| self.tcp_limit.is_none());
        let fastest = optimum.map_or(shortest, |it| it.duration.min(shortest));
        if let Some(lower) = lower.filter(|lower| *lower > wanted) {
            message +=
                &format!("; no lawful trajectory takes less than {lower:.6} s, whatever its curve");
            if let Some(first) = binding.first() {
                message += &format!(
                    ", most of all because of the {} limit of {}",
                    first.limit, first.joint
                );
            }
        } else if fastest <= wanted {
            message += &format!("; jerk_limited takes {fastest:.6} s");
        }
        let mut details = json!({
            "duration": shortest, "wanted": wanted, "lower_bound": lower, "fastest": fastest,
            "binding": binding,
        });
        if let (Some(without), Some(limit)) = (timed.faster_without_tcp_limit(), &self.tcp_limit) {
            message += &format!(
                "; without the tcp speed limit of {} m/s it would take {without:.6} s",
                limit.speed
            );
            details["without_tcp_limit"] = json!(without);
        }
        PlanError::unreachable(message, details)
    }

    /// Some plans are right on paper but nothing a computer can follow, as
    /// where a segment is too short for time to go on.
    fn check_computable(&self, timed: &Timed) -> Result<(), PlanError> {
        let valid = timed.trajectory.validate(self.limits.len());
        valid.map_err(|error| {
            let message = format!(
                "the durations differ too much, or are too extreme, to compute with: {error}"
            );
            PlanError::unreachable(message, json!({ "durations": timed.durations }))
        })
    }

    /// The search keeps its range; what follows it may have to leave it.
    pub(super) fn check_range(&self, durations: &[f64]) -> Result<(), PlanError> {
        let Some(DurationRange { min, max }) = self.task.range else { return Ok(()) };
        let lawful = min * (1.0 - RANGE_TOLERANCE)..=max * (1.0 + RANGE_TOLERANCE);
        let outside = durations.iter().enumerate().find(|(_, t)| !lawful.contains(*t));
        let Some((segment, t)) = outside else { return Ok(()) };
        let message = format!(
            "segment {segment} would last {t:.6} s, outside the search range of {min} to {max} s; \
             widen `durations`"
        );
        let details = json!({ "segment": segment, "duration": t, "min": min, "max": max });
        Err(PlanError::unreachable(message, details))
    }

    fn assemble(&self, plan: &PreparedPlan, timed: Timed) -> TrajectoryResult {
        let slowed = timed.faster_without_tcp_limit().is_some();
        let Timed {
            durations,
            trajectory,
            initial_duration,
            solution,
            per_joint,
            reference,
            front,
            optimum,
            without_tcp_limit,
        } = timed;
        let waypoints = &self.task.waypoints;
        let waypoint_times = times(&durations, trajectory.duration());
        let due: Vec<(f64, &[f64])> =
            waypoint_times.iter().copied().zip(waypoints.iter().map(Vec::as_slice)).collect();
        let ends = self.task.ends.as_ref();
        let certificate = Certificate::joined(&trajectory, self.limits, &due, ends)
            .with_tcp_limit(&trajectory, self.tcp_limit.as_ref())
            .with_via_tolerance(&trajectory, self.limits, &due, self.task.via_tolerance.as_deref());
        let duration = trajectory.duration();
        let bound = optimum.as_ref().or(self.optimum.as_ref()).and_then(|it| it.bound.clone());
        let bound = bound.map(|bound| bound.against(duration));
        // What limits of joints hold back is not known where the tool's limit holds the motion back.
        let optimum = optimum.filter(|_| !slowed);
        let mut metrics = PlanMetrics {
            sensitivities: optimum.map(|it| it.sensitivities).unwrap_or_default(),
            without_tcp_limit,
            objective: Measures::of_trajectory(&trajectory),
            reference,
            ..metrics(&trajectory, self.limits, &waypoint_times, initial_duration)
        };
        metrics.binding.extend(self.tcp_bindings(&trajectory, &waypoint_times));
        metrics.binding.sort_by_key(|binding| binding.segment);
        TrajectoryResult {
            robot: plan.robot_name().to_owned(),
            joint_names: self.limits.iter().map(|limit| limit.name.clone()).collect(),
            joint_units: self.limits.iter().map(|limit| limit.unit.to_owned()).collect(),
            duration,
            durations,
            waypoint_times,
            waypoints: waypoints.clone(),
            trajectory,
            certificate,
            bound,
            metrics,
            motion: None,
            pareto: front,
            per_joint,
            convergence: solution.convergence,
            interpolation: self.task.interpolation.name.to_owned(),
            optimizer: self.task.optimizer.name.to_owned(),
            stop_reason: solution.stop_reason,
            iterations: solution.iterations,
            evaluations: solution.evaluations,
            planning_s: self.budget.elapsed_s(),
            seed: self.seed,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

fn handling(handling: ConstraintHandling) -> Handling {
    match handling {
        ConstraintHandling::RepairUniform => Handling::RepairUniform,
        ConstraintHandling::RepairSegment => Handling::RepairSegment,
        ConstraintHandling::Penalty => Handling::Penalty,
        ConstraintHandling::Reject => Handling::Reject,
    }
}

pub(super) fn no_candidate(solution: &Solution) -> PlanError {
    let evaluations = solution.evaluations;
    let message = format!(
        "none of {evaluations} candidates kept the limits; widen `durations`, raise the optimizer's \
         budget, use constraint_handling repair_uniform or another interpolation"
    );
    PlanError::unreachable(message, json!({ "evaluations": evaluations }))
}

/// Two searches one after the other, as one: the curve of the later follows.
fn join(mut first: Solution, second: Solution) -> Solution {
    let (iterations, evaluations) = (first.iterations, first.evaluations);
    first.convergence.extend(second.convergence.into_iter().map(|point| ConvergencePoint {
        iteration: point.iteration + iterations,
        evaluations: point.evaluations + evaluations,
        ..point
    }));
    Solution {
        fitness: first.fitness.max(second.fitness),
        iterations: iterations + second.iterations,
        evaluations: evaluations + second.evaluations,
        stop_reason: second.stop_reason,
        ..first
    }
}

/// Running sums from 0; the last is `total`.
pub(super) fn times(durations: &[f64], total: f64) -> Vec<f64> {
    let sums = durations.iter().scan(0.0, |sum, duration| {
        *sum += duration;
        Some(*sum)
    });
    let mut times: Vec<f64> = std::iter::once(0.0).chain(sums).collect();
    if let Some(last) = times.last_mut() {
        *last = total;
    }
    times
}

/// By what factor the trajectory must be stretched to keep the first `orders`
/// derivative limits, from the exact peaks the certificate will see.
pub(super) fn required_scale(
    trajectory: &Trajectory,
    limits: &[JointBounds],
    orders: usize,
) -> f64 {
    let certificate = Certificate::new(trajectory, limits, &[]);
    let mut scale = 0.0f64;
    for joint in &certificate.joints {
        let peaks = [&joint.velocity, &joint.acceleration, &joint.jerk];
        let roots: [fn(f64) -> f64; 3] = [|ratio| ratio, f64::sqrt, libm::cbrt];
        for (peak, root) in peaks.iter().zip(roots).take(orders) {
            let ratio = peak.ratio.unwrap_or(0.0);
            // The root of a ratio just above 1 may round to 1.
            let needed = root(ratio).max(if ratio > 1.0 { 1.0 + f64::EPSILON } else { 0.0 });
            scale = scale.max(needed);
        }
    }
    scale
}

/// A limit the finished plan exceeds, as an error.
fn violation_error(violation: &Violation) -> PlanError {
    let what = if violation.limit == "position" {
        "the curve leaves the position limits between waypoints"
    } else {
        "the plan cannot be made lawful"
    };
    PlanError::unreachable(format!("{what}: {}", violation.detail), json!(violation))
}
