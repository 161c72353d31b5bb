//! Several joints at a time.
//!
//! [`Lanes`] stores eight numbers; its arithmetic is plain loops, which the
//! compiler turns into wide instructions. [`Vector`] is the widest register the
//! machine has, for code with comparisons, where the compiler does not manage
//! alone. Every lane is computed alone and nothing is fused, so results do not
//! depend on the machine.

use std::ops::{Add, Div, Mul, Neg, Sub};

pub use pulp::Simd;

/// Numbers in a [`Lanes`].
pub const WIDTH: usize = 8;

/// Eight independent numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; WIDTH]);

    /// Lane by lane from `values`, the missing ones from `fill`.
    pub fn from_slice(values: &[f64], fill: f64) -> Self {
        Self(std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(fill)))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for lane in 0..WIDTH {
            out.0[lane] = f(self.0[lane], other.0[lane]);
        }
        out
    }

    /// The largest number.
    pub fn largest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::ZERO - self
    }
}

/// `sin²(pi z)` per lane, to within 1e-15.
///
/// A period is taken off exactly, then the Taylor series of `sin(pi y)` on
/// [-1/2, 1/2] leaves less than 3e-17. Meant for |z| below 2^51.
#[inline(always)]
pub fn sin_squared(z: [f64; WIDTH]) -> [f64; WIDTH] {
    /// `(-1)^k pi^(2k+1) / (2k+1)!`
    const SERIES: [f64; 12] = [
        std::f64::consts::PI,
        -5.16771278004997,
        2.5501640398773455,
        -0.5992645293207921,
        0.08214588661112823,
        -0.0073704309457143504,
        0.00046630280576761255,
        -2.1915353447830217e-05,
        7.952054001475513e-07,
        -2.2948428997269873e-08,
        5.392664662608129e-10,
        -1.0518471716932054e-11,
    ];
    // Adding and taking away 3 * 2^51 rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // One loop over the lanes per step of the series: registers hold whole steps.
    let (mut y, mut y2, mut sine) = (z, z, [SERIES[11]; WIDTH]);
    for l in 0..WIDTH {
        y[l] = z[l] - ((z[l] + ROUND) - ROUND);
        y2[l] = y[l] * y[l];
    }
    for factor in SERIES[..11].iter().rev() {
        for l in 0..WIDTH {
            sine[l] = sine[l] * y2[l] + factor;
        }
    }
    for l in 0..WIDTH {
        sine[l] *= y[l];
        sine[l] *= sine[l];
    }
    sine
}

/// One register of numbers, [`Simd::F64_LANES`] wide.
#[derive(Clone, Copy, Debug)]
pub struct Vector<S: Simd> {
    simd: S,
    values: S::f64s,
}

/// One register of truth values.
#[derive(Clone, Copy, Debug)]
pub struct Mask<S: Simd> {
    simd: S,
    values: S::m64s,
}

/// Number of registers that hold the first `used` numbers of a [`Lanes`].
#[inline(always)]
pub fn registers<S: Simd>(used: usize) -> usize {
    used.min(WIDTH).div_ceil(S::F64_LANES)
}

impl<S: Simd> Vector<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, values: simd.splat_f64s(value) }
    }

    /// Register `part` of `lanes`.
    #[inline(always)]
    pub fn load(simd: S, lanes: &Lanes, part: usize) -> Self {
        Self { simd, values: S::as_simd_f64s(&lanes.0).0[part] }
    }

    /// Writes register `part` of `lanes`.
    #[inline(always)]
    pub fn store(self, lanes: &mut Lanes, part: usize) {
        S::as_mut_simd_f64s(&mut lanes.0).0[part] = self.values;
    }

    /// Magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { values: self.simd.abs_f64s(self.values), ..self }
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { values: self.simd.sqrt_f64s(self.values), ..self }
    }

    /// The larger of two; neither may be not-a-number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { values: self.simd.max_f64s(self.values, other.values), ..self }
    }

    /// The smaller of two; neither may be not-a-number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { values: self.simd.min_f64s(self.values, other.values), ..self }
    }

    /// Where `self` is below `other`; false where either is not a number.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask<S> {
        let values = self.simd.less_than_f64s(self.values, other.values);
        Mask { simd: self.simd, values }
    }

    /// Where `self` is not above `other`; false where either is not a number.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> Mask<S> {
        let values = self.simd.less_than_or_equal_f64s(self.values, other.values);
        Mask { simd: self.simd, values }
    }

    /// The largest lane.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.simd.reduce_max_f64s(self.values)
    }
}

impl<S: Simd> Mask<S> {
    /// `yes` where true, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Vector<S>, no: Vector<S>) -> Vector<S> {
        let values = self.simd.select_f64s(self.values, yes.values, no.values);
        Vector { simd: self.simd, values }
    }

    /// Where both hold.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { values: self.simd.and_m64s(self.values, other.values), ..self }
    }

    /// Where either holds.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self { values: self.simd.or_m64s(self.values, other.values), ..self }
    }

    /// True if any lane is.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.simd.first_true_m64s(self.values) < S::F64_LANES
    }
}

macro_rules! arithmetic {
    ($($name:ident $method:ident $operator:tt $simd:ident;)*) => {$(
        impl $name for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }
        impl $name<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.zip(Self([other; WIDTH]), |a, b| a $operator b)
            }
        }
        impl<S: Simd> $name for Vector<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { values: self.simd.$simd(self.values, other.values), ..self }
            }
        }
        impl<S: Simd> $name<f64> for Vector<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(Self::splat(self.simd, other))
            }
        }
    )*};
}

arithmetic! {
    Add add + add_f64s;
    Sub sub - sub_f64s;
    Mul mul * mul_f64s;
    Div div / div_f64s;
}

impl<S: Simd> Neg for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(self.simd, 0.0) - self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squared_sines_are_right_to_rounding() {
        for k in 0..20_000 {
            let z = f64::from(k) * 0.001_37 - 13.0;
            let found = sin_squared([z; WIDTH])[3];
            let turned = z - z.round();
            let expected = libm::sin(std::f64::consts::PI * turned).powi(2);
            assert!((found - expected).abs() < 1e-15, "{z}: {found} {expected}");
        }
        for z in [0.0, 1.0, -7.0, 123_456.0] {
            assert_eq!(sin_squared([z; WIDTH]), [0.0; WIDTH]);
        }
        assert!((sin_squared([0.5; WIDTH])[0] - 1.0).abs() < 1e-15);
    }
}
