//! How far joints move within a stretch of a trajectory, without sampling it.

use crate::collision::JointMotion;
use crate::math::polynomial::{derivative_at, value};
use crate::trajectory::Trajectory;

/// A trajectory as proofs of clearance see it.
pub struct Travelled<'a>(pub &'a Trajectory);

impl JointMotion for Travelled<'_> {
    fn duration(&self) -> f64 {
        self.0.duration()
    }

    fn position(&self, time: f64, position: &mut [f64]) {
        let (piece, local) = self.0.locate(time);
        for (position, coefficients) in position.iter_mut().zip(&self.0.pieces[piece]) {
            *position = value(coefficients, local);
        }
    }

    /// What of the stretch lies in one piece is no further from its own middle than the magnitudes of its Taylor terms
    /// there add up to, and that middle is known.
    fn travel(&self, start: f64, end: f64, travel: &mut [f64]) {
        let trajectory = self.0;
        let (middle_piece, middle) = trajectory.locate(0.5 * (start + end));
        let [(first, from), (last, to)] = [start, end].map(|t| trajectory.locate(t));
        for (joint, travel) in travel.iter_mut().enumerate() {
            let center = value(&trajectory.pieces[middle_piece][joint], middle);
            *travel = 0.0;
            for piece in first..=last {
                let length = trajectory.breakpoints[piece + 1] - trajectory.breakpoints[piece];
                let enter = if piece == first { from } else { 0.0 };
                let leave = if piece == last { to } else { length };
                let coefficients = &trajectory.pieces[piece][joint];
                *travel = travel.max(excursion(coefficients, [enter, leave], center));
            }
        }
    }
}

/// A part of a motion, from `start` to `end`.
pub struct Part<'a, M> {
    pub motion: &'a M,
    pub start: f64,
    pub end: f64,
}

impl<M: JointMotion> JointMotion for Part<'_, M> {
    fn duration(&self) -> f64 {
        self.end - self.start
    }

    fn position(&self, time: f64, position: &mut [f64]) {
        self.motion.position(self.start + time, position);
    }

    fn travel(&self, start: f64, end: f64, travel: &mut [f64]) {
        self.motion.travel(self.start + start, self.start + end, travel);
    }
}

/// A bound on how far a polynomial is from `center` between two times.
fn excursion(coefficients: &[f64], [enter, leave]: [f64; 2], center: f64) -> f64 {
    let (middle, half) = (0.5 * (enter + leave), 0.5 * (leave - enter).abs());
    let mut bound = (value(coefficients, middle) - center).abs();
    let mut power = 1.0;
    for order in 1..coefficients.len() {
        power *= half / order as f64;
        bound += derivative_at(coefficients, order, middle).abs() * power;
    }
    // Rounding must not make a bound smaller.
    bound * (1.0 + 1e-12) + 1e-15 * center.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::jerk_limited::fastest;
    use crate::trajectory::kernel::KernelLimits;

    #[test]
    fn no_joint_goes_further_than_its_travel_and_short_stretches_are_tight() {
        let waypoints = [vec![0.0, 0.3], vec![1.0, -0.5], vec![0.4, 0.9], vec![-1.2, 0.2]];
        let limits = KernelLimits {
            derivatives: [1.5, 6.0, 40.0],
            position: [f64::NEG_INFINITY, f64::INFINITY],
        };
        let trajectory = fastest(&waypoints, &[limits; 2]).trajectory;
        let motion = Travelled(&trajectory);
        let duration = motion.duration();
        let (mut middle, mut there, mut travel) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for parts in [1, 3, 16, 300, 5000] {
            let mut looseness = 0.0f64;
            for part in 0..parts {
                let [start, end] =
                    [part, part + 1].map(|part| duration * f64::from(part) / f64::from(parts));
                motion.position(0.5 * (start + end), &mut middle);
                motion.travel(start, end, &mut travel);
                let mut furthest = [0.0f64; 2];
                for sample in 0..=40 {
                    motion.position(start + (end - start) * f64::from(sample) / 40.0, &mut there);
                    for joint in 0..2 {
                        let gone = (there[joint] - middle[joint]).abs();
                        furthest[joint] = furthest[joint].max(gone);
                        assert!(gone <= travel[joint], "{gone} {travel:?}");
                    }
                }
                for joint in 0..2 {
                    looseness = looseness.max(travel[joint] - furthest[joint]);
                }
            }
            assert!(parts < 5000 || looseness < 1e-5, "{looseness}");
        }
    }
}
