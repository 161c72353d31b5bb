//! Inverse kinematics: the configurations that bring the tool to a pose.
//!
//! What kind of arm it is follows from its lines alone, never from a name. Arms with a closed form
//! give all their branches; others are searched. One file per kind.

mod error;
mod gantry;
mod miss;
mod numeric;
mod range;
mod redundant;
mod scara;
mod screws;
mod six_axis;
mod solutions;
mod spherical_wrist;
#[cfg(test)]
mod tests;
mod three_parallel;
mod turn;

use nalgebra::Vector3;

use super::{Joint, Kinematics, Robot};
use crate::geometry::Transform;
use crate::math::random::RandomStream;
pub use error::PoseError;
use gantry::Gantry;
pub use miss::{LimitMiss, Miss};
use numeric::Scratch;
use range::Range;
use redundant::{Redundant, spread};
use scara::Scara;
use screws::{EXACTLY, NEARLY};
use six_axis::SixAxis;
pub use solutions::Solutions;

/// Above this (m, and rad) a closed form's answer is worth a step of refinement.
const ROUNDING: f64 = 1e-12;
/// An error beyond this is none that refinement would mend.
const REFINABLE: f64 = 0.1;
/// Positions of the held joint that are tried first, and at most.
const HELD: [usize; 2] = [16, 2048];
/// Other seeds that a closed form is tried with.
const OTHER_SEEDS: usize = 64;
/// Starts of a search.
const STARTS: u64 = 100;
/// As many solutions as a search lists: a six-axis arm has at most sixteen.
const MOST: usize = 16;

/// Finds configurations for poses; built once per robot.
#[derive(Clone, Debug)]
pub struct InverseKinematics {
    kinematics: Kinematics,
    ranges: Vec<Range>,
    /// From the tool at 0 to the world.
    tool_from_world_at_zero: Transform,
    solver: Solver,
    /// True if the solver's arm is the ideal one and this one differs a little.
    approximate: bool,
}

#[derive(Clone, Debug)]
enum Solver {
    SixAxis(Box<SixAxis>),
    Redundant(Box<Redundant>),
    Scara(Box<Scara>),
    Gantry(Box<Gantry>),
    Numeric,
}

impl InverseKinematics {
    /// Looks at the lines of `kinematics` and chooses how to solve it.
    pub(super) fn new(kinematics: &Kinematics, joints: &[Joint]) -> Self {
        let at_zero = kinematics.tool_transform(&vec![0.0; kinematics.dof()]);
        let (solver, approximate) = Solver::new(kinematics, at_zero.origin);
        Self {
            kinematics: kinematics.clone(),
            ranges: joints.iter().map(Range::new).collect(),
            tool_from_world_at_zero: at_zero.inverse(),
            solver,
            approximate,
        }
    }

    /// How it is solved: `spherical_wrist`, `spherical_shoulder`, `three_parallel_axes`, `redundant`, `scara`, `gantry` or
    /// `numeric`.
    pub fn kind(&self) -> &'static str {
        match &self.solver {
            Solver::SixAxis(arm) => arm.name(),
            Solver::Redundant(_) => "redundant",
            Solver::Scara(_) => "scara",
            Solver::Gantry(_) => "gantry",
            Solver::Numeric => "numeric",
        }
    }

    /// True if [`all`](Self::all) finds every branch; false where there are infinitely many, a search finds them, or the
    /// closed form is that of an arm a little different.
    pub fn is_complete(&self) -> bool {
        !self.approximate && !matches!(self.solver, Solver::Redundant(_) | Solver::Numeric)
    }

    /// A configuration within the limits to start from if nobody says: every joint at 0 or, where its limits exclude
    /// that, in their middle.
    pub fn home(&self) -> Vec<f64> {
        self.ranges.iter().map(Range::home).collect()
    }

    /// Every position of joint `joint` that is within its limits and the same as `position` but for whole turns, in
    /// ascending order. Of a joint without limits it is `position` alone.
    pub fn same_positions(&self, joint: usize, position: f64) -> impl Iterator<Item = f64> + use<> {
        self.ranges[joint].same(position)
    }

    /// Finds every configuration within the limits that brings the tool to `target` within `tolerance`.
    ///
    /// Joints that could make whole turns are as near to `seed` as their limits allow; where a singular place leaves a
    /// joint free, it takes the seed's position. Redundant arms have infinitely many solutions: then the
    /// held joint is tried at evenly spread positions, at least 16.
    ///
    /// # Panics
    ///
    /// If `seed` has another number of joints, or `found` is another robot's.
    pub fn all(
        &self,
        target: &Transform,
        seed: &[f64],
        tolerance: &PoseError,
        found: &mut Solutions,
    ) {
        found.clear();
        let motion = *target * self.tool_from_world_at_zero;
        for tolerance in [&PoseError::EXACT, tolerance] {
            let keep = |joints: &[f64], found: &mut Solutions| {
                self.keep(joints, seed, target, tolerance, found);
            };
            match &self.solver {
                Solver::Redundant(arm) => {
                    let window = self.ranges[arm.held()].window(seed[arm.held()]);
                    for (index, position) in spread(window).take(HELD[1]).enumerate() {
                        if index >= HELD[0] && !found.is_empty() {
                            break;
                        }
                        arm.solve(&motion, position, seed, |joints| keep(&joints, found));
                    }
                }
                Solver::Numeric => self.search(target, seed, tolerance, MOST, found),
                _ => self.branches(&motion, seed, |joints| keep(joints, found)),
            }
            if found.is_empty() {
                self.look_elsewhere(target, &motion, seed, tolerance, found);
            }
            if !found.is_empty() {
                return;
            }
        }
    }

    /// Keeps `joints` if they are within the limits, right, and new.
    #[inline]
    fn keep(
        &self,
        joints: &[f64],
        seed: &[f64],
        target: &Transform,
        tolerance: &PoseError,
        found: &mut Solutions,
    ) {
        let mut fitted = [0.0; Robot::MAX_DOF];
        let fitted = &mut fitted[..joints.len()];
        if self.fit(joints, seed, fitted)
            && let Some(error) = self.check(target, tolerance, fitted, &mut found.scratch)
            && !found.holds(fitted)
        {
            found.push(fitted, error);
        }
    }

    /// Finds the configuration within the limits that brings the tool to `target` within `tolerance` and is nearest to
    /// `seed`, by the sum of the joints' squared distances. `found` then holds it alone.
    ///
    /// Redundant arms: the nearest of a search along the held joint. Arms without a closed form: the
    /// one that a descent from the seed leads to or, if it fails, the first of other starts.
    ///
    /// # Errors
    ///
    /// The nearest pose that can be reached, and the limit that stands in the way if one does.
    ///
    /// # Panics
    ///
    /// If `seed` has another number of joints, or `found` is another robot's.
    pub fn nearest(
        &self,
        target: &Transform,
        seed: &[f64],
        tolerance: &PoseError,
        found: &mut Solutions,
    ) -> Result<(), Box<Miss>> {
        found.clear();
        let motion = *target * self.tool_from_world_at_zero;
        for tolerance in [&PoseError::EXACT, tolerance] {
            let mut best = Best::default();
            match &self.solver {
                Solver::Redundant(arm) => {
                    self.nearest_along(arm, target, &motion, seed, tolerance, &mut best, found);
                }
                Solver::Numeric => {}
                _ => self.branches(&motion, seed, |joints| {
                    best.offer(self, joints, seed, target, tolerance, found);
                }),
            }
            if found.is_empty() {
                self.look_elsewhere(target, &motion, seed, tolerance, found);
            }
            if !found.is_empty() {
                return Ok(());
            }
        }
        let miss = miss::explain(self, target, seed, tolerance);
        if !miss.error.within(tolerance) {
            return Err(Box::new(miss));
        }
        // The search for the nearest pose came upon the pose itself.
        found.push(&miss.configuration, miss.error);
        Ok(())
    }

    /// Shows `see` the branches of arms that have a closed form for all joints, limits aside.
    #[inline]
    fn branches(&self, motion: &Transform, seed: &[f64], mut see: impl FnMut(&[f64])) {
        match &self.solver {
            Solver::SixAxis(arm) => {
                let seed = std::array::from_fn(|joint| seed[joint]);
                arm.solve(motion, &seed, |joints| see(&joints));
            }
            Solver::Scara(arm) => arm.solve(motion, seed, |joints| see(&joints[..seed.len()])),
            Solver::Gantry(machine) => {
                machine.solve(motion, seed, |joints| see(&joints[..seed.len()]));
            }
            Solver::Redundant(_) | Solver::Numeric => {}
        }
    }

    /// Searches along the held joint of `arm` for the solution nearest to `seed`.
    #[expect(clippy::too_many_arguments, reason = "what a search needs")]
    fn nearest_along(
        &self,
        arm: &Redundant,
        target: &Transform,
        motion: &Transform,
        seed: &[f64],
        tolerance: &PoseError,
        best: &mut Best,
        found: &mut Solutions,
    ) {
        let held = arm.held();
        let window = self.ranges[held].window(seed[held]);
        let mut look = |position: f64, best: &mut Best| {
            // No solution here is nearer than the held joint alone.
            let apart = position - seed[held];
            if apart * apart < best.squared {
                arm.solve(motion, position, seed, |joints| {
                    best.offer(self, &joints, seed, target, tolerance, found);
                });
            }
        };
        look(seed[held].max(window[0]).min(window[1]), best);
        let mut tried = 1;
        for position in spread(window).take(HELD[1]) {
            // Only a whole round is even.
            if tried >= HELD[0] && best.squared.is_finite() && tried.is_power_of_two() {
                break;
            }
            look(position, best);
            tried += 1;
        }
        let mut step = (window[1] - window[0]) / tried as f64;
        for _ in 0..REFINEMENTS {
            let (centre, before) = (best.joints[held], best.squared);
            if before.is_infinite() {
                break;
            }
            for position in [centre - step, centre + step] {
                if (window[0]..=window[1]).contains(&position) {
                    look(position, best);
                }
            }
            if best.squared >= before {
                step *= 0.4;
            }
        }
    }

    /// Brings a configuration within the limits, whole turns as near to `seed` as can be; false if that is impossible.
    #[inline]
    fn fit(&self, joints: &[f64], seed: &[f64], fitted: &mut [f64]) -> bool {
        for (index, range) in self.ranges.iter().enumerate() {
            match range.fit(joints[index], seed[index]) {
                Some(position) => fitted[index] = position,
                None => return false,
            }
        }
        true
    }

    /// How far the tool is from `target`; none beyond `tolerance`. Refines `joints` where rounding left something.
    #[inline]
    fn check(
        &self,
        target: &Transform,
        tolerance: &PoseError,
        joints: &mut [f64],
        scratch: &mut Scratch,
    ) -> Option<PoseError> {
        let mut error = PoseError::between(&self.kinematics.tool_transform(joints), target);
        if error.largest() > ROUNDING && error.largest() < REFINABLE {
            let steps = if self.approximate { 8 } else { 2 };
            numeric::descend(&self.kinematics, &self.ranges, target, joints, scratch, Some(steps));
            error = PoseError::between(&self.kinematics.tool_transform(joints), target);
        }
        error.within(tolerance).then_some(error)
    }

    /// Finds one solution where the first look found none.
    ///
    /// Of a closed form: with other seeds. In a singular place a joint that takes the seed's position can leave the others
    /// without a lawful one, though another position of it would not. Then by descents.
    fn look_elsewhere(
        &self,
        target: &Transform,
        motion: &Transform,
        seed: &[f64],
        tolerance: &PoseError,
        found: &mut Solutions,
    ) {
        if !self.is_complete() {
            return self.search(target, seed, tolerance, 1, found);
        }
        let mut best = Best::default();
        let mut other = [0.0; Robot::MAX_DOF];
        let other = &mut other[..seed.len()];
        for share in spread([0.0, 1.0]).take(OTHER_SEEDS) {
            for ((other, range), seed) in other.iter_mut().zip(&self.ranges).zip(seed) {
                let [lower, upper] = range.window(*seed);
                *other = lower + share * (upper - lower);
            }
            self.branches(motion, other, |joints| {
                best.offer(self, joints, seed, target, tolerance, found);
            });
        }
        // What fewer joints cannot reach exactly, descents cannot either.
        if found.is_empty() && matches!(self.solver, Solver::SixAxis(_)) {
            self.search(target, seed, tolerance, 1, found);
        }
    }

    /// Descends from `seed` and from random starts until `most` solutions are found.
    fn search(
        &self,
        target: &Transform,
        seed: &[f64],
        tolerance: &PoseError,
        most: usize,
        found: &mut Solutions,
    ) {
        let Self { kinematics, ranges, .. } = self;
        let mut joints = [0.0; Robot::MAX_DOF];
        let joints = &mut joints[..ranges.len()];
        for start in 0..STARTS {
            self.start(start, seed, joints);
            numeric::descend(kinematics, ranges, target, joints, &mut found.scratch, None);
            let error = PoseError::between(&kinematics.tool_transform(joints), target);
            if error.within(tolerance) && !found.holds(joints) {
                found.push(joints, error);
                if found.len() >= most {
                    break;
                }
            }
        }
    }

    /// Where descent `start` begins: at the seed, then anywhere within the limits.
    fn start(&self, start: u64, seed: &[f64], joints: &mut [f64]) {
        let mut random = RandomStream::new(0, start);
        for ((joint, range), seed) in joints.iter_mut().zip(&self.ranges).zip(seed) {
            let [lower, upper] = range.window(*seed);
            *joint = if start == 0 {
                seed.max(range.lower).min(range.upper)
            } else {
                random.uniform(lower, upper)
            };
        }
    }
}

/// Rounds of refinement along the held joint: the step shrinks to less than a thousandth of the range.
const REFINEMENTS: usize = 8;

/// The nearest solution so far.
struct Best {
    /// Its squared distance from the seed.
    squared: f64,
    joints: [f64; Robot::MAX_DOF],
}

impl Default for Best {
    fn default() -> Self {
        Self { squared: f64::INFINITY, joints: [0.0; Robot::MAX_DOF] }
    }
}

impl Best {
    /// Takes `joints` if they are within the limits, right, and nearer to `seed`.
    #[inline]
    fn offer(
        &mut self,
        inverse: &InverseKinematics,
        joints: &[f64],
        seed: &[f64],
        target: &Transform,
        tolerance: &PoseError,
        found: &mut Solutions,
    ) {
        let mut fitted = [0.0; Robot::MAX_DOF];
        let fitted = &mut fitted[..joints.len()];
        if !inverse.fit(joints, seed, fitted) {
            return;
        }
        let squared = fitted.iter().zip(seed).map(|(joint, seed)| (joint - seed).powi(2)).sum();
        if squared < self.squared
            && let Some(error) = inverse.check(target, tolerance, fitted, &mut found.scratch)
        {
            self.squared = squared;
            self.joints[..fitted.len()].copy_from_slice(fitted);
            found.clear();
            found.push(fitted, error);
        }
    }
}

impl Solver {
    /// How to solve a chain whose tool is at `tool` with every joint at 0, and whether its lines are only
    /// nearly what that takes.
    fn new(kinematics: &Kinematics, tool: Vector3<f64>) -> (Self, bool) {
        let Some(screws) = screws::of(kinematics) else { return (Self::Numeric, false) };
        let closed = |tolerance: f64| match screws.len() {
            3 | Scara::MOST => Scara::new(&screws, tolerance).map(|arm| Self::Scara(Box::new(arm))),
            6 => {
                let arm = screws[..].try_into().ok().and_then(|six| SixAxis::new(six, tolerance));
                arm.map(|arm| Self::SixAxis(Box::new(arm)))
            }
            Redundant::COUNT => {
                Redundant::new(&screws, tolerance).map(|arm| Self::Redundant(Box::new(arm)))
            }
            _ => None,
        };
        let gantry = || Gantry::new(&screws, tool).map(|machine| Self::Gantry(Box::new(machine)));
        if let Some(exact) = closed(EXACTLY).or_else(gantry) {
            return (exact, false);
        }
        closed(NEARLY).map_or((Self::Numeric, false), |near| (near, true))
    }
}
