//! The timing problem: segment durations of one interpolation family.

use crate::optimize::{Appraisal, Bounds, Candidate, Objective, Ratios};

use super::kernel::{JointLanes, Kernel, KernelLimits, Workspace};
use super::objective::Measures;
use super::polynomial_trajectory::Trajectory;
use super::rest_to_rest::quintic;

/// What becomes of a candidate that breaks a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handling {
    /// Scale all durations to the smallest lawful multiple.
    RepairUniform,
    /// Stretch segments over a limit, up to four sweeps, then scale up.
    RepairSegment,
    /// Add the excess to the fitness.
    Penalty,
    /// Make the fitness infinite.
    Reject,
}

/// Search for segment durations of least sum within limits.
///
/// Durations are in seconds, one variable per segment. Segments may be fixed,
/// which the per-joint clock needs for segments in which its joint rests.
pub struct TimingProblem {
    kernel: &'static dyn Kernel,
    joints: JointLanes,
    handling: Handling,
    bounds: Bounds,
    /// The range the user asked for; durations must stay inside.
    range: Option<[f64; 2]>,
    /// Rest-to-rest durations, the natural proportions.
    natural: Vec<f64>,
    /// Scale of position excess, rad or m.
    extent: f64,
    /// Durations that were best for similar waypoints.
    hints: Vec<Vec<f64>>,
}

/// Sweeps of [`Handling::RepairSegment`] before it scales uniformly.
const SWEEPS: usize = 4;

/// Rounds in which a repaired candidate loses what rounding left above a limit.
const ROUNDINGS: usize = 4;

/// What rounding may add to a ratio that was scaled to 1.
const ROUNDING: f64 = 1e-9;

/// The search range around a segment's rest-to-rest duration.
const DEFAULT_RANGE: [f64; 2] = [0.05, 2.0];

impl TimingProblem {
    /// Poses the problem of `waypoints[waypoint][joint]` within `limits`.
    ///
    /// `range` is the user's search range; without one it is derived from the
    /// rest-to-rest duration of each segment.
    pub fn new(
        kernel: &'static dyn Kernel,
        waypoints: &[Vec<f64>],
        limits: &[KernelLimits],
        handling: Handling,
        range: Option<[f64; 2]>,
    ) -> Self {
        let natural = natural_durations(waypoints, limits);
        let bounds = match range {
            Some([min, max]) => {
                Bounds { lower: vec![min; natural.len()], upper: vec![max; natural.len()] }
            }
            None => Bounds {
                lower: natural.iter().map(|t| DEFAULT_RANGE[0] * t).collect(),
                upper: natural.iter().map(|t| DEFAULT_RANGE[1] * t).collect(),
            },
        };
        let extent = waypoints.iter().flatten().fold(0.0f64, |extent, x| extent.max(x.abs()));
        let joints = JointLanes::new(waypoints, limits);
        Self {
            kernel,
            joints,
            handling,
            bounds,
            range,
            natural,
            extent: extent.max(1e-3),
            hints: Vec::new(),
        }
    }

    /// The same problem with `hints`: durations that were best for similar
    /// waypoints, one per segment.
    #[must_use]
    pub fn with_hints(self, hints: &[Vec<f64>]) -> Self {
        Self { hints: hints.to_vec(), ..self }
    }

    /// The durations a candidate stands for, repaired as its fitness assumed.
    pub fn decode(&self, position: &[f64]) -> Vec<f64> {
        let mut candidate = TimingCandidate::new(self);
        let mut durations = position.to_vec();
        match self.handling {
            Handling::RepairUniform => {
                let scale = candidate.scale(position);
                durations.iter_mut().for_each(|t| *t *= scale);
            }
            Handling::RepairSegment => candidate.repair_segments(&mut durations),
            Handling::Penalty | Handling::Reject => {}
        }
        durations
    }

    /// The smallest lawful multiple of `durations`.
    pub fn scale(&self, durations: &[f64]) -> f64 {
        TimingCandidate::new(self).scale(durations)
    }

    /// True if the durations a candidate stands for keep every limit.
    pub fn is_lawful(&self, position: &[f64]) -> bool {
        let durations = self.decode(position);
        let mut candidate = TimingCandidate::new(self);
        let scale = candidate.scale(&durations);
        scale <= 1.0 + ROUNDING && candidate.violation(&durations, 1.0) <= ROUNDING
    }

    /// The largest fitness that can be a duration: a penalty lifts every
    /// candidate that breaks a limit above it.
    pub fn highest_duration(&self) -> f64 {
        match self.handling {
            Handling::Penalty => self.bounds.upper.iter().sum(),
            _ => f64::INFINITY,
        }
    }

    /// Time, jerk and energy of the curve for `durations`.
    pub fn measures(&self, durations: &[f64]) -> Measures {
        let mut candidate = TimingCandidate::new(self);
        // Leaves the curve in the candidate's memory.
        self.kernel.ratios(&self.joints, durations, &mut candidate.work);
        candidate.measures(durations)
    }

    /// The curve for `durations`.
    pub fn trajectory(&self, durations: &[f64]) -> Trajectory {
        let mut work = self.kernel.workspace(&self.joints);
        self.kernel.trajectory(&self.joints, durations, &mut work)
    }

    /// Rest-to-rest durations of the segments, s.
    pub fn natural(&self) -> &[f64] {
        &self.natural
    }
}

/// For each segment the time a quintic from rest to rest would need.
fn natural_durations(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Vec<f64> {
    let segment = |pair: &[Vec<f64>]| {
        let ways = pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from);
        ways.zip(limits).map(|(way, limit)| quintic(way, limit.derivatives)).fold(0.0, f64::max)
    };
    let mut natural: Vec<f64> = waypoints.windows(2).map(segment).collect();
    // A segment in which nothing that is limited moves still needs some time.
    let longest = natural.iter().copied().fold(0.0, f64::max);
    let least = if longest > 0.0 { 1e-2 * longest } else { 1.0 };
    natural.iter_mut().for_each(|t| *t = t.max(least));
    natural
}

impl Objective for TimingProblem {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        Box::new(TimingCandidate::new(self))
    }

    fn evaluation_ns(&self) -> f64 {
        100.0 + 250.0 * (self.joints.segments() * self.joints.groups()) as f64
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        vec![self.natural.clone(), self.natural.iter().map(|t| t.sqrt()).collect()]
    }

    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }

    fn is_homogeneous(&self) -> bool {
        true
    }
}

/// Evaluates durations in one thread.
pub(super) struct TimingCandidate<'a> {
    problem: &'a TimingProblem,
    work: Workspace,
    durations: Vec<f64>,
    ratios: Ratios,
}

impl<'a> TimingCandidate<'a> {
    pub(super) fn new(problem: &'a TimingProblem) -> Self {
        let durations = Vec::with_capacity(problem.joints.segments());
        Self {
            problem,
            work: problem.kernel.workspace(&problem.joints),
            durations,
            ratios: Ratios::default(),
        }
    }

    /// The smallest multiple that keeps the derivative limits and the range's
    /// lower end.
    pub(super) fn scale(&mut self, durations: &[f64]) -> f64 {
        let problem = self.problem;
        let scale = problem.kernel.scale(&problem.joints, durations, &mut self.work);
        // Where nothing limits the curve, or numbers end, nothing is known.
        let scale = if scale > 0.0 { scale } else { f64::INFINITY };
        match problem.range {
            Some([min, _]) => durations.iter().fold(scale, |scale, t| scale.max(min / t)),
            None => scale,
        }
    }

    /// What scaling cannot mend, positive if broken: positions beyond their
    /// limits, relative to the motion's extent, and durations above the range
    /// once `scale` is applied. Speaks of the curve evaluated last.
    pub(super) fn violation(&self, durations: &[f64], scale: f64) -> f64 {
        let problem = self.problem;
        let position = problem.kernel.position_excess(&problem.joints, &self.work) / problem.extent;
        match problem.range {
            Some([_, max]) => {
                durations.iter().fold(position, |worst, t| worst.max(scale * t / max - 1.0 - 1e-12))
            }
            None => position,
        }
    }

    /// The largest multiple that keeps the range's upper end.
    pub(super) fn highest_scale(&self, durations: &[f64]) -> f64 {
        let longest = durations.iter().copied().fold(0.0, f64::max);
        self.problem.range.map_or(f64::INFINITY, |[_, max]| max / longest)
    }

    /// Time, jerk and energy of the curve evaluated last.
    pub(super) fn measures(&self, durations: &[f64]) -> Measures {
        let TimingProblem { kernel, joints, .. } = self.problem;
        Measures::of_curve(*kernel, joints, durations, &self.work)
    }

    /// Everything that has to be at most 1, each of the first degree: roots of
    /// the peaks' ratios, and what the range and position limits ask.
    pub(super) fn constraints(&mut self, durations: &[f64], constraints: &mut Vec<f64>) {
        let problem = self.problem;
        problem.kernel.ratios(&problem.joints, durations, &mut self.work);
        self.work.collect(&problem.joints, &mut self.ratios);
        let roots: [fn(f64) -> f64; 3] = [|ratio| ratio, f64::sqrt, libm::cbrt];
        constraints.clear();
        for (list, root) in self.ratios.iter().zip(roots) {
            constraints.extend(list.iter().map(|ratio| root(*ratio)));
        }
        if let Some([min, max]) = problem.range {
            constraints.extend(durations.iter().map(|t| min / t));
            constraints.extend(durations.iter().map(|t| t / max));
        }
        let excess = problem.kernel.position_excess(&problem.joints, &self.work);
        constraints.push((1.0 + excess / problem.extent).max(0.0));
    }

    /// Han's fitness switch (eqs. 12-15, which leave open how a
    /// duration is enlarged): segments over a
    /// limit are stretched by what their worst ratio asks, up to four sweeps,
    /// because stretching one segment changes its neighbours; what is left is
    /// mended by uniform scaling.
    fn repair_segments(&mut self, durations: &mut [f64]) {
        let problem = self.problem;
        for _ in 0..SWEEPS {
            problem.kernel.ratios(&problem.joints, durations, &mut self.work);
            let mut lawful = true;
            for (segment, t) in durations.iter_mut().enumerate() {
                let [velocity, acceleration, jerk] =
                    self.work.segment_ratios(&problem.joints, segment);
                let factor = velocity.max(acceleration.sqrt()).max(libm::cbrt(jerk));
                if factor > 1.0 {
                    *t *= factor;
                    lawful = false;
                }
            }
            if lawful {
                return;
            }
        }
        let scale = self.scale(durations);
        if scale > 1.0 {
            durations.iter_mut().for_each(|t| *t *= scale);
        }
    }

    /// Sum of the relative excesses of all peaks over their limits.
    fn excess(&mut self, durations: &[f64]) -> f64 {
        let problem = self.problem;
        problem.kernel.ratios(&problem.joints, durations, &mut self.work);
        self.work.collect(&problem.joints, &mut self.ratios);
        self.ratios.iter().flatten().map(|ratio| (ratio - 1.0).max(0.0)).sum()
    }

    /// A candidate that keeps every limit costs its sum; `P0` puts every other
    /// one above all of those.
    fn penalized(&mut self, durations: &[f64], scale: f64) -> f64 {
        let excess = self.excess(durations) + self.violation(durations, 1.0).max(0.0);
        let sum: f64 = durations.iter().sum();
        if scale <= 1.0 && excess <= 0.0 {
            return sum;
        }
        let longest: f64 = self.problem.bounds.upper.iter().sum();
        sum + longest + longest * excess
    }
}

impl Candidate for TimingCandidate<'_> {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        let sum: f64 = position.iter().sum();
        match self.problem.handling {
            Handling::RepairUniform => {
                let scale = self.scale(position);
                let violation = self.violation(position, scale);
                // No multiple is lawful, but some proportions are nearer to it.
                let broken = if violation > 0.0 { 1.0 + 10.0 * violation } else { 0.0 };
                scale * sum * (1.0 + broken)
            }
            Handling::RepairSegment => {
                let mut durations = std::mem::take(&mut self.durations);
                durations.clear();
                durations.extend_from_slice(position);
                self.repair_segments(&mut durations);
                let violation = self.violation(&durations, 1.0);
                let broken = if violation > 0.0 { 1.0 + 10.0 * violation } else { 0.0 };
                let sum: f64 = durations.iter().sum();
                self.durations = durations;
                sum * (1.0 + broken)
            }
            Handling::Penalty => {
                let scale = self.scale(position);
                self.penalized(position, scale)
            }
            Handling::Reject => {
                let scale = self.scale(position);
                let lawful = scale <= 1.0 && self.violation(position, scale) <= 0.0;
                if lawful { sum } else { f64::INFINITY }
            }
        }
    }

    fn appraise(&mut self, position: &[f64]) -> Appraisal {
        let fitness = self.fitness(position);
        if self.problem.handling != Handling::Penalty {
            return Appraisal { fitness, cost: fitness, excess: 0.0 };
        }
        // The fitness has just left this candidate's ratios behind.
        let square = |excess: f64| excess.max(0.0) * excess.max(0.0);
        let ratios = self.ratios.iter().flatten();
        let excess = ratios.map(|ratio| square(ratio - 1.0)).sum::<f64>()
            + square(self.violation(position, 1.0));
        Appraisal { fitness, cost: position.iter().sum(), excess }
    }

    fn repair(&mut self, position: &mut [f64]) {
        self.repair_segments(position);
        // Rounding may leave it a hair above, where a rejecting problem would
        // not take it.
        for _ in 0..ROUNDINGS {
            let scale = self.scale(position);
            if scale <= 1.0 {
                break;
            }
            position.iter_mut().for_each(|t| *t *= scale * (1.0 + 4.0 * f64::EPSILON));
        }
        // A search range ends where it ends: the repaired particle starts on it.
        let bounds = &self.problem.bounds;
        for ((t, lower), upper) in position.iter_mut().zip(&bounds.lower).zip(&bounds.upper) {
            *t = t.clamp(*lower, *upper);
        }
    }

    fn homogeneous(&mut self, position: &[f64], ratios: &mut Ratios) -> f64 {
        let problem = self.problem;
        problem.kernel.ratios(&problem.joints, position, &mut self.work);
        self.work.collect(&problem.joints, ratios);
        if let Some([min, _]) = problem.range {
            ratios[0].extend(position.iter().map(|t| min / t));
        }
        // Only a range needs to know the scale itself.
        let largest = |ratios: &[f64]| ratios.iter().copied().fold(0.0, f64::max);
        let scale = if problem.range.is_some() {
            let [v, a, j] = [&ratios[0], &ratios[1], &ratios[2]].map(|list| largest(list));
            v.max(a.sqrt()).max(libm::cbrt(j))
        } else {
            1.0
        };
        self.violation(position, scale)
    }
}
