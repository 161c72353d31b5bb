//! One piece's exact extrema, for as many joints as a register holds.
//!
//! Everything is inlined into the kernel's dispatched functions: a call left
//! behind would cost ten times the work.

use super::kernel::{Family, Piece};
use crate::math::lanes::{Simd, Vector};

/// The smallest and the largest value of something.
#[derive(Clone, Copy)]
pub(super) struct Range<S: Simd> {
    pub low: Vector<S>,
    pub high: Vector<S>,
}

impl<S: Simd> Range<S> {
    #[inline(always)]
    pub(super) fn between(a: Vector<S>, b: Vector<S>) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }

    #[inline(always)]
    pub(super) fn with(self, value: Vector<S>) -> Self {
        Self { low: self.low.min(value), high: self.high.max(value) }
    }

    #[inline(always)]
    pub(super) fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The largest magnitude.
    #[inline(always)]
    pub(super) fn peak(self) -> Vector<S> {
        self.high.max(-self.low)
    }
}

/// Derivatives of a piece in `u`: velocity `v0 + v1 u + ...`, acceleration
/// `a0 + ... + a3 u^3`.
pub(super) struct Curve<S: Simd> {
    simd: S,
    position: [Vector<S>; 6],
    velocity: [Vector<S>; 5],
    acceleration: [Vector<S>; 4],
}

impl<S: Simd> Curve<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, piece: &Piece, part: usize) -> Self {
        let mut c = [Vector::splat(simd, 0.0); 6];
        for (c, lanes) in c.iter_mut().zip(piece) {
            *c = Vector::load(simd, lanes, part);
        }
        Self {
            simd,
            position: c,
            velocity: [c[1], c[2] * 2.0, c[3] * 3.0, c[4] * 4.0, c[5] * 5.0],
            acceleration: [c[2] * 2.0, c[3] * 6.0, c[4] * 12.0, c[5] * 20.0],
        }
    }

    #[inline(always)]
    pub(super) fn splat(&self, value: f64) -> Vector<S> {
        Vector::splat(self.simd, value)
    }

    /// Jerk at `u`.
    #[inline(always)]
    pub(super) fn jerk(&self, u: Vector<S>) -> Vector<S> {
        let [_, a1, a2, a3] = self.acceleration;
        (a3 * 3.0 * u + a2 * 2.0) * u + a1
    }

    /// Where acceleration turns, ascending; zero where it does not inside (0, 1).
    #[inline(always)]
    pub(super) fn turns(&self) -> [Vector<S>; 2] {
        let [_, a1, a2, a3] = self.acceleration;
        self.quadratic_roots([a1, a2, a3 * 3.0])
    }

    /// Real roots of `c + 2 b u + a u^2`, given as `[c, b, a]`, ascending; zero
    /// where they do not lie inside (0, 1).
    #[inline(always)]
    fn quadratic_roots(&self, [c, b, a]: [Vector<S>; 3]) -> [Vector<S>; 2] {
        let discriminant = b * b - c * a;
        let root = discriminant.max(self.splat(0.0)).sqrt();
        // The two sums of equal signs: nothing cancels.
        let negative = b.below(self.splat(0.0));
        let q = negative.select(root - b, -(root + b));
        let first = self.inside(q / a);
        let second = self.inside(c / q);
        [first.min(second), first.max(second)]
    }

    /// Ranges that cost no iteration: velocity at the ends, acceleration, jerk.
    #[inline(always)]
    pub(super) fn cheap_ranges<F: Family>(&self) -> [Range<S>; 3] {
        let one = self.splat(1.0);
        let [a0, a1, a2, a3] = self.acceleration;
        let velocity = Range::between(self.velocity[0], horner(&self.velocity, one));
        if F::DEGREE == 3 {
            return [velocity, Range::between(a0, a0 + a1), Range::between(a1, a1)];
        }
        if F::DEGREE == 4 {
            let vertex = self.inside(-a1 / (a2 * 2.0));
            let acceleration =
                Range::between(a0, a0 + a1 + a2).with((a2 * vertex + a1) * vertex + a0);
            return [velocity, acceleration, Range::between(a1, a2 * 2.0 + a1)];
        }
        let mut acceleration = Range::between(a0, horner(&self.acceleration, one));
        for turn in self.turns() {
            acceleration = acceleration.with(horner(&self.acceleration, turn));
        }
        let vertex = self.inside(-a2 / (a3 * 3.0));
        let jerk = Range::between(a1, self.jerk(one)).with(self.jerk(vertex));
        [velocity, acceleration, jerk]
    }

    /// Velocity inside the piece, where acceleration is zero.
    #[inline(always)]
    pub(super) fn velocity_range<F: Family>(&self) -> Range<S> {
        let [first, second, third] = self.acceleration_roots::<F>();
        let there = horner(&self.velocity, first);
        match F::DEGREE {
            3 => Range::between(there, there),
            4 => Range::between(there, horner(&self.velocity, second)),
            _ => Range::between(there, horner(&self.velocity, second))
                .with(horner(&self.velocity, third)),
        }
    }

    /// Roots of acceleration, in ascending order but for places where there is
    /// none: those are an end of the interval that was searched. Only as many as
    /// the degree admits count; the others are one.
    #[inline(always)]
    pub(super) fn acceleration_roots<F: Family>(&self) -> [Vector<S>; 3] {
        let [a0, a1, a2, _] = self.acceleration;
        let one = self.splat(1.0);
        if F::DEGREE == 3 {
            return [self.inside(-a0 / a1), one, one];
        }
        if F::DEGREE == 4 {
            let [first, second] = self.quadratic_roots([a0, a1 * 0.5, a2]);
            return [first, second, one];
        }
        let [low, high] = self.turns();
        let breaks = [self.splat(0.0), low, high, self.splat(1.0)];
        monotone_roots(self.simd, &self.acceleration, breaks)
    }

    /// The control points of speed (Bernstein form) bound it.
    #[inline(always)]
    pub(super) fn velocity_bound(&self) -> Vector<S> {
        let [v0, v1, v2, v3, v4] = self.velocity;
        let b1 = v0 + v1 * 0.25;
        let b2 = v0 + v1 * 0.5 + v2 * (1.0 / 6.0);
        let b3 = v0 + v1 * 0.75 + v2 * 0.5 + v3 * 0.25;
        let b4 = v0 + v1 + v2 + v3 + v4;
        v0.abs().max(b1.abs()).max(b2.abs()).max(b3.abs()).max(b4.abs())
    }

    /// Smallest and largest position, from the roots of velocity.
    #[inline(always)]
    pub(super) fn position_range<F: Family>(&self) -> [Vector<S>; 2] {
        let one = self.splat(1.0);
        let piece = &self.position;
        let end = horner(piece, one);
        let mut range = [piece[0].min(end), piece[0].max(end)];
        let [r0, r1, r2] = self.acceleration_roots::<F>();
        let breaks = [self.splat(0.0), r0, r0.max(r1), r0.max(r1).max(r2), one];
        let roots: [Vector<S>; 4] = monotone_roots(self.simd, &self.velocity, breaks);
        for root in roots {
            let position = horner(piece, root);
            range = [range[0].min(position), range[1].max(position)];
        }
        range
    }

    /// The control points of position (Bernstein form) enclose it.
    #[inline(always)]
    pub(super) fn position_hull(&self) -> [Vector<S>; 2] {
        let c = &self.position;
        let points = [
            c[0] + c[1] * 0.2,
            c[0] + c[1] * 0.4 + c[2] * 0.1,
            c[0] + c[1] * 0.6 + c[2] * 0.3 + c[3] * 0.1,
            c[0] + c[1] * 0.8 + c[2] * 0.6 + c[3] * 0.4 + c[4] * 0.2,
            c[0] + c[1] + c[2] + c[3] + c[4] + c[5],
        ];
        let mut hull = [c[0], c[0]];
        for point in points {
            hull = [hull[0].min(point), hull[1].max(point)];
        }
        hull
    }

    /// `u` where it lies inside (0, 1), else zero; not-a-number counts as outside.
    #[inline(always)]
    pub(super) fn inside(&self, u: Vector<S>) -> Vector<S> {
        let zero = self.splat(0.0);
        zero.below(u).and(u.below(self.splat(1.0))).select(u, zero)
    }
}

#[inline(always)]
fn horner<S: Simd, const N: usize>(c: &[Vector<S>; N], u: Vector<S>) -> Vector<S> {
    let mut sum = c[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum * u + c[k];
    }
    sum
}

/// Value and slope at `u`.
#[inline(always)]
fn horner_slope<S: Simd, const N: usize>(
    c: &[Vector<S>; N],
    u: Vector<S>,
) -> (Vector<S>, Vector<S>) {
    let mut slope = c[N - 1];
    let mut sum = c[N - 1] * u + c[N - 2];
    for k in (0..N - 2).rev() {
        slope = slope * u + sum;
        sum = sum * u + c[k];
    }
    (sum, slope)
}

/// How far a root in `u` may be off.
const ROOT_TOLERANCE: f64 = 1e-8;

/// The root in each interval between neighbouring `breaks`, where the
/// polynomial is monotone; the interval's start where the sign does not change.
///
/// Newton's method inside a shrinking bracket, for all intervals side by side.
/// The roots serve as places of extrema, where an error of `e` shifts the value
/// by the order of `e^2`: at [`ROOT_TOLERANCE`] the extremum is exact to rounding.
#[inline(always)]
fn monotone_roots<S: Simd, const N: usize, const B: usize, const R: usize>(
    simd: S,
    c: &[Vector<S>; N],
    breaks: [Vector<S>; B],
) -> [Vector<S>; R] {
    const { assert!(B == R + 1) };
    let [zero, one, tolerance] = [0.0, 1.0, ROOT_TOLERANCE].map(|value| Vector::splat(simd, value));
    let mut low = [zero; R];
    let mut high = [zero; R];
    let mut u = [zero; R];
    // +1 where the polynomial rises, -1 where it falls: its sign is then
    // negative before the root everywhere.
    let mut rising = [zero; R];
    let mut crossing = zero.below(zero);
    let mut before = horner(c, breaks[0]);
    for r in 0..R {
        let after = horner(c, breaks[r + 1]);
        rising[r] = before.below(after).select(one, -one);
        let crosses = (before * rising[r]).below(zero).and(zero.below(after * rising[r]));
        crossing = crossing.or(crosses);
        low[r] = breaks[r];
        high[r] = crosses.select(breaks[r + 1], breaks[r]);
        let secant = low[r] - before * (high[r] - low[r]) / (after - before);
        u[r] = crosses.select(secant, low[r]);
        before = after;
    }
    if !crossing.any() {
        return low;
    }
    for _ in 0..60 {
        let mut widest = zero;
        for r in 0..R {
            let (value, slope) = horner_slope(c, u[r]);
            let under = (value * rising[r]).below(zero);
            low[r] = under.select(u[r], low[r]);
            high[r] = under.select(high[r], u[r]);
            let step = value / slope;
            let newton = u[r] - step;
            // A root at an end of the bracket is left by rounding alone: stay.
            let arrived = step.abs().below(tolerance);
            let lawful = low[r].at_most(newton).and(newton.at_most(high[r]));
            let middle = (low[r] + high[r]) * 0.5;
            let next = lawful.select(newton, arrived.select(u[r], middle));
            widest = widest.max((next - u[r]).abs());
            u[r] = next;
        }
        if widest.largest() < ROOT_TOLERANCE {
            break;
        }
    }
    u
}
