//! Polynomials in ascending powers, their roots in an interval and their
//! exact extrema.

/// The most coefficients [`Extrema`] takes.
pub const MAX_COEFFICIENTS: usize = 16;

/// Value at `t` (Horner).
#[inline]
pub fn value(coefficients: &[f64], t: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, &c| sum * t + c)
}

/// Value and first three derivatives at `t`.
pub fn derivatives(coefficients: &[f64], t: f64) -> [f64; 4] {
    // Horner's scheme for the Taylor coefficients at t.
    let mut taylor = [0.0; 4];
    for &c in coefficients.iter().rev() {
        taylor[3] = taylor[3] * t + taylor[2];
        taylor[2] = taylor[2] * t + taylor[1];
        taylor[1] = taylor[1] * t + taylor[0];
        taylor[0] = taylor[0] * t + c;
    }
    [taylor[0], taylor[1], 2.0 * taylor[2], 6.0 * taylor[3]]
}

/// The smallest and the largest value in an interval, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrema {
    /// Smallest value.
    pub min: f64,
    /// Where it is taken.
    pub min_at: f64,
    /// Largest value.
    pub max: f64,
    /// Where it is taken.
    pub max_at: f64,
}

impl Extrema {
    fn at(t: f64, value: f64) -> Self {
        Self { min: value, min_at: t, max: value, max_at: t }
    }

    fn include(&mut self, t: f64, value: f64) {
        if value < self.min {
            (self.min, self.min_at) = (value, t);
        }
        if value > self.max {
            (self.max, self.max_at) = (value, t);
        }
    }

    /// The largest magnitude and where it is taken.
    pub fn peak(&self) -> (f64, f64) {
        if -self.min > self.max { (-self.min, self.min_at) } else { (self.max, self.max_at) }
    }
}

/// A polynomial on [0, 1] together with all its derivatives, for one pass over
/// their extrema.
///
/// The extrema of each derivative lie at the interval's ends or at roots of
/// the next one. Between neighbouring roots of the next one a polynomial is
/// monotone, so its own roots are bracketed: from the linear derivative
/// upwards every root is found, whatever the degree. No sampling is involved.
pub struct Extremes {
    extrema: Vec<Extrema>,
    /// Where the first derivative changes sign, ascending.
    turns: Vec<f64>,
}

impl Extremes {
    /// Extrema of the polynomial and its first three derivatives with respect
    /// to time on [0, `length`].
    ///
    /// # Panics
    ///
    /// If there are more than [`MAX_COEFFICIENTS`] coefficients.
    pub fn new(coefficients: &[f64], length: f64) -> Self {
        assert!(coefficients.len() <= MAX_COEFFICIENTS, "degree out of range");
        let levels = levels(coefficients, length);
        let mut extrema = Vec::with_capacity(levels.len());
        let mut turns = Vec::new();
        let mut breaks: Vec<f64> = vec![0.0, 1.0];
        for (order, level) in levels.iter().enumerate().rev() {
            let (found, roots) = sweep(level, &breaks);
            extrema.push(found);
            if order == 1 {
                turns = roots.iter().map(|u| u * length).collect();
            }
            breaks = std::iter::once(0.0).chain(roots).chain(std::iter::once(1.0)).collect();
        }
        extrema.reverse();
        for (order, found) in extrema.iter_mut().enumerate() {
            let scale = length.powi(order as i32);
            *found = Extrema {
                min: found.min / scale,
                min_at: found.min_at * length,
                max: found.max / scale,
                max_at: found.max_at * length,
            };
        }
        Self { extrema, turns }
    }

    /// Where the polynomial turns round: the roots of its first derivative.
    pub fn turns(&self) -> &[f64] {
        &self.turns
    }

    /// Number of derivatives, the polynomial itself counted.
    pub fn orders(&self) -> usize {
        self.extrema.len()
    }

    /// Extrema of derivative `order` (0 is the polynomial itself).
    pub fn of(&self, order: usize) -> Extrema {
        self.extrema.get(order).copied().unwrap_or(Extrema::at(0.0, 0.0))
    }
}

/// The polynomial over [0, 1] instead of [0, `length`], and all its derivatives.
///
/// Normalised time u = t / length keeps the roots well scaled however long or
/// short the piece is.
fn levels(coefficients: &[f64], length: f64) -> Vec<Vec<f64>> {
    let mut levels: Vec<Vec<f64>> = Vec::with_capacity(coefficients.len());
    let mut power = 1.0;
    let scaled = coefficients.iter().map(|c| {
        let scaled = c * power;
        power *= length;
        scaled
    });
    levels.push(scaled.collect());
    while let Some(level) = levels.last().filter(|level| level.len() > 1) {
        levels.push(derivative(level));
    }
    levels
}

/// Where the polynomial changes sign between 0 and `length`, ascending. Where
/// it only touches zero may be among them.
pub fn roots(coefficients: &[f64], length: f64) -> Vec<f64> {
    let mut roots = Vec::new();
    for level in levels(coefficients, length).iter().rev() {
        let breaks: Vec<f64> =
            std::iter::once(0.0).chain(roots).chain(std::iter::once(1.0)).collect();
        roots = sweep(level, &breaks).1;
    }
    roots.iter().map(|u| u * length).collect()
}

/// Integral of the square over [0, `length`].
pub fn integral_of_square(coefficients: &[f64], length: f64) -> f64 {
    let mut sum = 0.0;
    for (i, a) in coefficients.iter().enumerate() {
        for (j, b) in coefficients.iter().enumerate() {
            let power = (i + j + 1) as i32;
            sum += a * b * length.powi(power) / f64::from(power);
        }
    }
    sum
}

/// Derivative `order` at `t`.
pub fn derivative_at(coefficients: &[f64], order: usize, t: f64) -> f64 {
    let factor = |power: usize| (power - order + 1..=power).map(|k| k as f64).product::<f64>();
    let terms = coefficients.iter().enumerate().skip(order).rev();
    terms.fold(0.0, |sum, (power, c)| sum * t + c * factor(power))
}

/// Coefficients of the derivative.
pub fn derivative(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect()
}

/// Extrema and roots of a polynomial that is monotone between `breaks`.
fn sweep(coefficients: &[f64], breaks: &[f64]) -> (Extrema, Vec<f64>) {
    let mut left = breaks[0];
    let mut value_left = value(coefficients, left);
    let mut extrema = Extrema::at(left, value_left);
    let mut roots = Vec::new();
    for &right in &breaks[1..] {
        let value_right = value(coefficients, right);
        extrema.include(right, value_right);
        if value_left == 0.0 {
            roots.push(left);
        } else if value_left.signum() * value_right < 0.0 {
            roots.push(bracketed_root(coefficients, left, value_left, right, value_right));
        }
        (left, value_left) = (right, value_right);
    }
    (extrema, roots)
}

/// The root between `a` and `b`, where the values differ in sign.
///
/// Newton's method kept inside the shrinking bracket, bisection where Newton
/// leaves it or is slow: ends when the bracket is two neighbouring numbers or
/// the value is zero.
fn bracketed_root(coefficients: &[f64], a: f64, value_a: f64, b: f64, value_b: f64) -> f64 {
    let (mut a, mut b, negative_a) = (a, b, value_a < 0.0);
    let mut x = a - value_a * (b - a) / (value_b - value_a);
    let mut step_before = b - a;
    for _ in 0..200 {
        if !(x > a && x < b) {
            x = 0.5 * (a + b);
            if x <= a || x >= b {
                return x;
            }
        }
        let [f, slope, ..] = derivatives(coefficients, x);
        if f == 0.0 {
            return x;
        }
        if (f < 0.0) == negative_a {
            a = x
        } else {
            b = x
        }
        let step = f / slope;
        if step.abs() <= 0.25 * f64::EPSILON * x.abs() {
            return x;
        }
        // A step that does not halve the one before counts as slow.
        let next = x - step;
        x = if step.abs() <= 0.5 * step_before.abs() { next } else { 0.5 * (a + b) };
        step_before = step;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;

    #[test]
    fn finds_all_extrema_of_a_chebyshev_polynomial() {
        // T5(2u - 1) touches +-1 six times on [0, 1].
        let t5 = [-1.0, 50.0, -400.0, 1120.0, -1280.0, 512.0];
        let extremes = Extremes::new(&t5, 1.0);
        let position = extremes.of(0);
        assert!((position.min + 1.0).abs() < 1e-12 && (position.max - 1.0).abs() < 1e-12);
        assert!((extremes.of(1).peak().0 - 50.0).abs() < 1e-11);
    }

    #[test]
    fn agrees_with_dense_sampling_and_is_never_below_it() {
        let mut random = RandomStream::new(3, 0);
        for degree in 0..8usize {
            for _ in 0..200 {
                let length = 10f64.powf(random.uniform(-3.0, 2.0));
                let coefficients: Vec<f64> = (0..=degree)
                    .map(|power| random.uniform(-1.0, 1.0) / length.powi(power as i32))
                    .collect();
                let extremes = Extremes::new(&coefficients, length);
                for order in 0..4 {
                    let found = extremes.of(order);
                    let mut sampled: f64 = 0.0;
                    for k in 0..=1000 {
                        let t = length * f64::from(k) / 1000.0;
                        sampled = sampled.max(derivatives(&coefficients, t)[order].abs());
                    }
                    let (peak, at) = found.peak();
                    assert!(peak >= sampled * (1.0 - 1e-12), "degree {degree}, order {order}");
                    assert!(peak <= sampled * 1.001 + 1e-300, "degree {degree}, order {order}");
                    let there = derivatives(&coefficients, at)[order].abs();
                    assert!((there - peak).abs() <= 1e-9 * peak);
                }
            }
        }
    }

    #[test]
    fn finds_the_roots_within_the_interval() {
        // (t - 0.5) (t - 1) (t - 2.5) (t + 1)
        let quartic = [-1.25, 3.0, 0.25, -3.0, 1.0];
        for (length, expected) in [(2.0, &[0.5, 1.0][..]), (3.0, &[0.5, 1.0, 2.5]), (0.25, &[])] {
            let found = roots(&quartic, length);
            assert_eq!(found.len(), expected.len(), "{found:?}");
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        }
        assert!(roots(&[3.0], 1.0).is_empty());
        assert_eq!(roots(&[-3.0, 2.0], 2.0), [1.5]);
    }

    #[test]
    fn derivatives_are_those_of_powers() {
        assert_eq!(derivatives(&[1.0, 2.0, 3.0, 4.0], 2.0), [49.0, 62.0, 54.0, 24.0]);
        assert_eq!(derivatives(&[5.0], 9.0), [5.0, 0.0, 0.0, 0.0]);
    }
}
