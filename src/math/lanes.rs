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

/// Adding and taking away 3 * 2^51 rounds to a whole number.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `e^x` per lane, to within three units in the last place, for |x| up to 700.
///
/// `e^x = 2^k e^r` with `|r|` at most half of `ln 2`, where the polynomial that
/// meets `(e^r - 1 - r) / r²` in the Chebyshev nodes leaves less than 2e-17.
#[inline(always)]
pub fn exp(x: [f64; WIDTH]) -> [f64; WIDTH] {
    const POLYNOMIAL: [f64; 10] = [
        0.5,
        0.16666666666666669,
        0.041666666666624164,
        0.008333333333330133,
        0.0013888888917197213,
        0.00019841269862854032,
        2.480152132131787e-05,
        2.755726867396628e-06,
        2.7620076394757365e-07,
        2.510030767357192e-08,
    ];
    /// The leading bits of `ln 2`: multiples by whole numbers are exact.
    const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    const ONE: u64 = 1.0f64.to_bits();
    const FRACTION_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    let (mut r, mut power) = (x, x);
    for l in 0..WIDTH {
        let rounded = x[l] * std::f64::consts::LOG2_E + ROUND;
        let k = rounded - ROUND;
        r[l] = (x[l] - k * LN_2_HIGH) - k * LN_2_LOW;
        // The last bits of `rounded` are those of `k`.
        power[l] = f64::from_bits((rounded.to_bits() << FRACTION_BITS).wrapping_add(ONE));
    }
    let mut e = [POLYNOMIAL[9]; WIDTH];
    // One loop over the lanes per step: registers hold whole steps.
    for coefficient in POLYNOMIAL[..9].iter().rev() {
        for l in 0..WIDTH {
            e[l] = e[l] * r[l] + coefficient;
        }
    }
    for l in 0..WIDTH {
        e[l] = power[l] * (1.0 + (r[l] + r[l] * r[l] * e[l]));
    }
    e
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
        Self::read(simd, &lanes.0, part)
    }

    /// Register `part` of eight numbers that need not be aligned.
    #[inline(always)]
    pub fn read(simd: S, numbers: &[f64; WIDTH], part: usize) -> Self {
        Self { simd, values: S::as_simd_f64s(numbers).0[part] }
    }

    /// Writes register `part` of `lanes`.
    #[inline(always)]
    pub fn store(self, lanes: &mut Lanes, part: usize) {
        self.write(&mut lanes.0, part);
    }

    /// Writes register `part` of eight numbers that need not be aligned.
    #[inline(always)]
    pub fn write(self, numbers: &mut [f64; WIDTH], part: usize) {
        S::as_mut_simd_f64s(numbers).0[part] = self.values;
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

    /// `sin²(pi z)`, to within 1e-15, for |z| below 2^51.
    ///
    /// A period is taken off exactly; on [-1/2, 1/2] the polynomial that meets
    /// `sin(pi y) / y` in the Chebyshev nodes of `y²` leaves less than 2e-16.
    #[inline(always)]
    pub fn sin_squared(self) -> Self {
        const POLYNOMIAL: [f64; 7] = [
            3.141_592_653_589_792_7,
            -5.167_712_780_049_785_5,
            2.550_164_039_861_869_5,
            -0.599_264_528_825_271,
            0.082_145_878_816_891_41,
            -0.007_370_364_330_162_337,
            0.000_465_987_026_923_645_3,
        ];
        let y = self - ((self + ROUND) - ROUND);
        let y2 = y * y;
        let mut sine = Self::splat(self.simd, -2.113_364_059_293_787e-5);
        for coefficient in POLYNOMIAL.into_iter().rev() {
            sine = sine * y2 + coefficient;
        }
        sine = sine * y;
        sine * sine
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

    /// Where `self` is the same number as `other`.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Mask<S> {
        let values = self.simd.equal_f64s(self.values, other.values);
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
    use pulp::WithSimd;

    use super::*;

    struct SquaredSines(Lanes);

    impl WithSimd for SquaredSines {
        type Output = Lanes;

        fn with_simd<S: Simd>(self, simd: S) -> Lanes {
            let mut found = self.0;
            for part in 0..registers::<S>(WIDTH) {
                Vector::load(simd, &self.0, part).sin_squared().store(&mut found, part);
            }
            found
        }
    }

    #[test]
    fn squared_sines_are_right_to_rounding() {
        let sin_squared = |z: f64| {
            let found = pulp::Arch::new().dispatch(SquaredSines(Lanes([z; WIDTH])));
            // No register is so narrow or wide that it says otherwise.
            assert_eq!(found, SquaredSines(Lanes([z; WIDTH])).with_simd(pulp::Scalar::new()));
            found.0[3]
        };
        for k in 0..20_000 {
            let z = f64::from(k) * 0.001_37 - 13.0;
            let turned = z - z.round();
            let expected = libm::sin(std::f64::consts::PI * turned).powi(2);
            let found = sin_squared(z);
            assert!((found - expected).abs() < 1e-15, "{z}: {found} {expected}");
        }
        for z in [0.0, 1.0, -7.0, 123_456.0] {
            assert_eq!(sin_squared(z), 0.0);
        }
        assert!((sin_squared(0.5) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn exponentials_are_right_to_rounding() {
        for k in 0..20_000 {
            let x = f64::from(k) * 0.07 - 700.0;
            let (found, expected) = (exp([x; WIDTH])[5], libm::exp(x));
            let off = (found / expected - 1.0).abs();
            assert!(off < 3.0 * f64::EPSILON, "{x}: {found} {expected}");
        }
        assert_eq!(exp([0.0; WIDTH]), [1.0; WIDTH]);
    }
}
