//! What a motion costs: its time, its jerk and its energy.
//!
//! With the joints' accelerations `a` and jerks `j` of a motion of `T` seconds,
//! `rms_jerk = sqrt(1/T ∫ |j|² dt)` and `energy = 1/T ∫ |a|² dt`, where `|·|²`
//! sums over the joints and a metre counts like a radian. Both follow in closed
//! form from the polynomials. The scaling law holds for them as it does for
//! peaks: `s` times the durations divide `rms_jerk` by `s³` and `energy` by `s⁴`.
//!
//! Several of them become one number as a weighted sum, each relative to what
//! it is for a reference motion (Gasparetto and Zanotto 2008,
//! doi:10.1016/j.rcim.2007.04.001, weigh time and jerk so, but add the joints'
//! root mean squares instead of their squares).

use pulp::{Arch, WithSimd};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kernel::{JointLanes, Kernel, Piece, Workspace};
use super::polynomial_trajectory::Trajectory;
use crate::math::lanes::{Lanes, Simd};
use crate::math::polynomial::{derivative, integral_of_square};

/// A motion's time, jerk and energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Measures {
    /// Total duration, s.
    pub time: f64,
    /// Root mean square over time of the length of the jerk vector, rad/s³; a
    /// metre counts like a radian. Where acceleration jumps, the jump is not counted.
    pub rms_jerk: f64,
    /// Mean square over time of the length of the acceleration vector, rad²/s⁴;
    /// a metre counts like a radian.
    pub energy: f64,
}

/// One of the [`Measures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ObjectiveName {
    /// Total duration, s.
    Time,
    /// Root mean square jerk.
    RmsJerk,
    /// Mean squared acceleration.
    Energy,
}

impl ObjectiveName {
    /// The name as users see it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::RmsJerk => "rms_jerk",
            Self::Energy => "energy",
        }
    }

    /// Its value among `measures`.
    pub fn of(self, measures: &Measures) -> f64 {
        match self {
            Self::Time => measures.time,
            Self::RmsJerk => measures.rms_jerk,
            Self::Energy => measures.energy,
        }
    }

    /// Its unit, for joints whose positions are in `joint_units`.
    pub fn unit(self, joint_units: &[String]) -> String {
        let base = match joint_units {
            [first, rest @ ..] if rest.iter().all(|unit| unit == first) => first.as_str(),
            _ => "(rad, m)",
        };
        match self {
            Self::Time => "s".to_owned(),
            Self::RmsJerk => format!("{base}/s³"),
            Self::Energy => format!("{base}²/s⁴"),
        }
    }
}

impl Measures {
    /// Of the curve that `work` holds, fitted by `kernel` to `durations`, s.
    pub fn of_curve(
        kernel: &dyn Kernel,
        joints: &JointLanes,
        durations: &[f64],
        work: &Workspace,
    ) -> Self {
        let pieces = &work.pieces;
        let integrals = Integrals { pieces, groups: joints.groups(), durations, kernel };
        Self::from_integrals(durations.iter().sum(), Arch::new().dispatch(integrals))
    }

    /// Of a finished trajectory.
    pub fn of_trajectory(trajectory: &Trajectory) -> Self {
        let mut integrals = [0.0; 2];
        for (piece, ends) in trajectory.pieces.iter().zip(trajectory.breakpoints.windows(2)) {
            let length = ends[1] - ends[0];
            for coefficients in piece {
                let acceleration = derivative(&derivative(coefficients));
                integrals[0] += integral_of_square(&acceleration, length);
                integrals[1] += integral_of_square(&derivative(&acceleration), length);
            }
        }
        Self::from_integrals(trajectory.duration(), integrals)
    }

    fn from_integrals(time: f64, [acceleration, jerk]: [f64; 2]) -> Self {
        Self { time, rms_jerk: (jerk / time).sqrt(), energy: acceleration / time }
    }

    /// Of the same motion, `scale` times as long.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        let square = scale * scale;
        Self {
            time: self.time * scale,
            rms_jerk: self.rms_jerk / (square * scale),
            energy: self.energy / (square * square),
        }
    }
}

/// Nodes and weights on [0, 1] of Gauss' rule with four points, exact to degree 7.
const FOUR_POINTS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The same with three points, exact to degree 5.
const THREE_POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Integrals over time of squared acceleration and squared jerk, all joints
/// together.
///
/// A quintic's squared acceleration is of degree 6 and its squared jerk of
/// degree 4, so Gauss' rules are exact, and sums of squares lose no digits.
struct Integrals<'a> {
    pieces: &'a [Piece],
    groups: usize,
    durations: &'a [f64],
    kernel: &'a dyn Kernel,
}

impl WithSimd for Integrals<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 2] {
        let mut sums = [Lanes::ZERO; 2];
        let mut rows = self.pieces.chunks_exact(self.groups);
        for (segment, duration) in self.durations.iter().enumerate() {
            for share in self.kernel.shares(segment, self.durations.len()) {
                add_row(&mut sums, rows.next().unwrap_or_default(), share * duration);
            }
        }
        // Lane after lane, so that the sum does not depend on the registers.
        [sums[0].0.iter().sum(), sums[1].0.iter().sum()]
    }
}

/// Adds the integrals over one piece of all joints, which lasts `length`.
#[inline(always)]
fn add_row(sums: &mut [Lanes; 2], row: &[Piece], length: f64) {
    let inverse = 1.0 / length;
    let cube = inverse * inverse * inverse;
    for [_, _, c2, c3, c4, c5] in row {
        for (u, weight) in FOUR_POINTS {
            let a = ((*c5 * (20.0 * u) + *c4 * 12.0) * u + *c3 * 6.0) * u + *c2 * 2.0;
            sums[0] = sums[0] + a * a * (weight * cube);
        }
        for (u, weight) in THREE_POINTS {
            let j = (*c5 * (60.0 * u) + *c4 * 24.0) * u + *c3 * 6.0;
            sums[1] = sums[1] + j * j * (weight * cube * inverse * inverse);
        }
    }
}

/// A weighted sum of measures, each relative to a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighting {
    /// Weights over reference values.
    rates: Measures,
    /// Sum of the weights.
    weight: f64,
}

impl Weighting {
    /// Weighs measures relative to those of `reference`.
    pub fn new(weights: &Measures, reference: &Measures) -> Self {
        let rate = |weight: f64, value: f64| if value > 0.0 { weight / value } else { 0.0 };
        let rates = Measures {
            time: rate(weights.time, reference.time),
            rms_jerk: rate(weights.rms_jerk, reference.rms_jerk),
            energy: rate(weights.energy, reference.energy),
        };
        Self { rates, weight: weights.time + weights.rms_jerk + weights.energy }
    }

    /// The weighted sum of the reference itself: all weights together.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The weighted sum.
    pub fn value(&self, measures: &Measures) -> f64 {
        let Measures { time, rms_jerk, energy } = self.rates;
        time * measures.time + rms_jerk * measures.rms_jerk + energy * measures.energy
    }

    /// The sum without its part for time.
    pub(super) fn without_time(self) -> Self {
        Self { rates: Measures { time: 0.0, ..self.rates }, ..self }
    }

    /// The multiple between `lowest` and `highest` of a motion with these
    /// measures for which the weighted sum is least; `lowest` where that is
    /// the larger.
    ///
    /// The sum `α s + β/s³ + γ/s⁴` is convex in `s`, and its derivative
    /// vanishes with `α s⁵ - 3 β s - 4 γ`, which rises convexly from the root on.
    pub fn best_scale(&self, measures: &Measures, lowest: f64, highest: f64) -> f64 {
        let alpha = self.rates.time * measures.time;
        let beta = 3.0 * self.rates.rms_jerk * measures.rms_jerk;
        let gamma = 4.0 * self.rates.energy * measures.energy;
        if alpha <= 0.0 {
            return highest.max(lowest);
        }
        // With each of the two terms at most half of the first, this is above
        // the root, and Newton's steps fall to it.
        let mut scale = (2.0 * beta / alpha).sqrt().sqrt().max(libm::pow(2.0 * gamma / alpha, 0.2));
        if scale <= lowest {
            return lowest;
        }
        for _ in 0..64 {
            let fourth = scale * scale * scale * scale;
            let rise = 5.0 * alpha * fourth - beta;
            let next = scale - (scale * (alpha * fourth - beta) - gamma) / rise;
            if !(next < scale && next > 0.0) {
                break;
            }
            scale = next;
        }
        scale.min(highest).max(lowest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;

    #[test]
    fn the_best_scale_is_the_minimum() {
        let mut random = RandomStream::new(5, 0);
        for case in 0..500 {
            let mut draw = || 10f64.powf(random.uniform(-4.0, 4.0));
            let measures = Measures { time: draw(), rms_jerk: draw(), energy: draw() };
            let mut weights = Measures { time: draw(), rms_jerk: draw(), energy: draw() };
            if case % 3 == 0 {
                weights.rms_jerk = 0.0;
            } else if case % 3 == 1 {
                weights.energy = 0.0;
            }
            let weighting =
                Weighting::new(&weights, &Measures { time: 1.0, rms_jerk: 1.0, energy: 1.0 });
            let value = |scale: f64| weighting.value(&measures.scaled(scale));
            let best = weighting.best_scale(&measures, 0.0, f64::INFINITY);
            for factor in [0.5, 0.99, 0.9999, 1.0001, 1.01, 2.0] {
                assert!(value(best) <= value(best * factor), "case {case}, factor {factor}");
            }
            assert_eq!(weighting.best_scale(&measures, 2.0 * best, 3.0 * best), 2.0 * best);
            assert_eq!(weighting.best_scale(&measures, 0.1 * best, 0.5 * best), 0.5 * best);
            assert_eq!(weighting.without_time().best_scale(&measures, 1.0, 7.0), 7.0);
        }
    }

    /// Closed forms of one quintic from rest to rest: `∫a² = 120/7 D²/T³` and
    /// `∫j² = 720 D²/T⁵`.
    #[test]
    fn measures_of_a_minimum_jerk_motion() {
        let (way, length) = (0.7, 1.6);
        let c = |power: i32, factor: f64| factor * way / f64::powi(length, power);
        let coefficients = vec![0.1, 0.0, 0.0, c(3, 10.0), c(4, -15.0), c(5, 6.0)];
        let trajectory =
            Trajectory { breakpoints: vec![0.0, length], pieces: vec![vec![coefficients]] };
        let measures = Measures::of_trajectory(&trajectory);
        assert!((measures.energy / (120.0 / 7.0 * way * way / length.powi(4)) - 1.0).abs() < 1e-12);
        assert!((measures.rms_jerk / (720f64.sqrt() * way / length.powi(3)) - 1.0).abs() < 1e-12);
        assert_eq!(measures.scaled(2.0).energy, measures.energy / 16.0);
    }
}
