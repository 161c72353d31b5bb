//! Sixteen states at a time, in single precision.
//!
//! [`Singles`] stores sixteen numbers, [`SingleVector`] is the widest register the machine has, a part of them. Unlike in
//! [`lanes`](super::lanes), products and sums are fused: what is computed here decides nothing where rounding could.

use std::ops::{Add, Mul, Neg, Sub};

pub use pulp::Simd;

/// Numbers in a [`Singles`].
pub const SINGLES: usize = 16;

/// Sixteen independent numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Singles(pub [f32; SINGLES]);

impl Singles {
    /// All zero.
    pub const ZERO: Self = Self([0.0; SINGLES]);
}

/// One register of numbers, [`Simd::F32_LANES`] wide.
#[derive(Clone, Copy, Debug)]
pub struct SingleVector<S: Simd> {
    simd: S,
    values: S::f32s,
}

/// One register of truth values.
#[derive(Clone, Copy, Debug)]
pub struct SingleMask<S: Simd> {
    simd: S,
    values: S::m32s,
}

/// Number of registers that hold a [`Singles`].
#[inline(always)]
pub const fn single_registers<S: Simd>() -> usize {
    SINGLES / S::F32_LANES
}

impl<S: Simd> SingleVector<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self { simd, values: simd.splat_f32s(value) }
    }

    /// Register `part` of `singles`.
    #[inline(always)]
    pub fn load(simd: S, singles: &Singles, part: usize) -> Self {
        Self { simd, values: S::as_simd_f32s(&singles.0).0[part] }
    }

    /// Writes register `part` of `singles`.
    #[inline(always)]
    pub fn store(self, singles: &mut Singles, part: usize) {
        S::as_mut_simd_f32s(&mut singles.0).0[part] = self.values;
    }

    /// `self * factor + addend`, rounded once.
    #[inline(always)]
    pub fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self { values: self.simd.mul_add_f32s(self.values, factor.values, addend.values), ..self }
    }

    /// `self * factor + addend`, rounded once.
    #[inline(always)]
    pub fn mul_add_number(self, factor: f32, addend: Self) -> Self {
        self.mul_add(Self::splat(self.simd, factor), addend)
    }

    /// Magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { values: self.simd.abs_f32s(self.values), ..self }
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { values: self.simd.sqrt_f32s(self.values), ..self }
    }

    /// The larger of each and `number`; none may be not-a-number.
    #[inline(always)]
    pub fn at_least(self, number: f32) -> Self {
        let number = self.simd.splat_f32s(number);
        Self { values: self.simd.max_f32s(self.values, number), ..self }
    }

    /// The smaller of each and `number`; none may be not-a-number.
    #[inline(always)]
    pub fn no_more_than(self, number: f32) -> Self {
        let number = self.simd.splat_f32s(number);
        Self { values: self.simd.min_f32s(self.values, number), ..self }
    }

    /// Where `self` is not above `other`; false where either is not a number.
    #[inline(always)]
    pub fn at_most(self, other: Self) -> SingleMask<S> {
        let values = self.simd.less_than_or_equal_f32s(self.values, other.values);
        SingleMask { simd: self.simd, values }
    }

    /// Sine and cosine, each to within 6e-7, for magnitudes up to [`MAX_ANGLE`].
    ///
    /// A period is taken off in two parts. Of the half angle, within ±pi/2, the polynomials that meet `sin(h) / h` and
    /// `cos(h)` in the Chebyshev nodes of `h²` leave less than 1e-8; doubling is `sin 2h = 2 sin h cos h`,
    /// `cos 2h = 1 - 2 sin² h`.
    #[inline(always)]
    pub fn sin_cos(self) -> (Self, Self) {
        const TURN: f32 = std::f32::consts::TAU;
        /// What `TURN` leaves of 2 pi.
        const REST: f32 = -1.748_455_6e-7;
        /// Adding and taking away 3 * 2^22 rounds to a whole number.
        const ROUND: f32 = 12_582_912.0;
        let turns = self.mul_add_number(1.0 / TURN, Self::splat(self.simd, ROUND))
            - Self::splat(self.simd, ROUND);
        let angle = turns.mul_add_number(-TURN, self);
        let angle = turns.mul_add_number(-REST, angle);
        let half = angle * 0.5;
        let square = half * half;
        let mut sine = Self::splat(self.simd, SINE[SINE.len() - 1]);
        for &coefficient in SINE[..SINE.len() - 1].iter().rev() {
            sine = sine.mul_add(square, Self::splat(self.simd, coefficient));
        }
        let mut cosine = Self::splat(self.simd, COSINE[COSINE.len() - 1]);
        for &coefficient in COSINE[..COSINE.len() - 1].iter().rev() {
            cosine = cosine.mul_add(square, Self::splat(self.simd, coefficient));
        }
        let sine = sine * half;
        let twice = sine + sine;
        (twice * cosine, (-twice).mul_add(sine, Self::splat(self.simd, 1.0)))
    }
}

/// Largest angle of [`SingleVector::sin_cos`], rad.
pub const MAX_ANGLE: f32 = 64.0;

/// `sin(h) / h` in powers of `h²`.
const SINE: [f32; 5] =
    [0.999_999_996, -0.166_666_58, 0.008_333_05, -1.980_901_7e-4, 2.605_107_7e-6];

/// `cos(h)` in powers of `h²`.
const COSINE: [f32; 6] =
    [0.999_999_999_8, -0.5, 0.041_666_634, -0.001_388_836_1, 2.476_011e-5, -2.605_065_7e-7];

impl<S: Simd> SingleMask<S> {
    /// True if any lane is.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.simd.first_true_m32s(self.values) < S::F32_LANES
    }

    /// Bit i is lane i of the register.
    pub fn bits(self) -> u32 {
        let (one, zero) = (self.simd.splat_f32s(1.0), self.simd.splat_f32s(0.0));
        let mut lanes = Singles::ZERO;
        S::as_mut_simd_f32s(&mut lanes.0).0[0] = self.simd.select_f32s(self.values, one, zero);
        let bit = |(lane, &value): (usize, &f32)| u32::from(value > 0.0) << lane;
        lanes.0.iter().enumerate().map(bit).sum()
    }
}

macro_rules! arithmetic {
    ($($name:ident $method:ident $simd:ident;)*) => {$(
        impl<S: Simd> $name for SingleVector<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { values: self.simd.$simd(self.values, other.values), ..self }
            }
        }
        impl<S: Simd> $name<f32> for SingleVector<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f32) -> Self {
                self.$method(Self::splat(self.simd, other))
            }
        }
    )*};
}

arithmetic! {
    Add add add_f32s;
    Sub sub sub_f32s;
    Mul mul mul_f32s;
}

impl<S: Simd> Neg for SingleVector<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { values: self.simd.neg_f32s(self.values), ..self }
    }
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;

    struct SinesAndCosines(Singles);

    impl WithSimd for SinesAndCosines {
        type Output = (Singles, Singles);

        fn with_simd<S: Simd>(self, simd: S) -> (Singles, Singles) {
            let (mut sines, mut cosines) = (Singles::ZERO, Singles::ZERO);
            for part in 0..single_registers::<S>() {
                let (sine, cosine) = SingleVector::load(simd, &self.0, part).sin_cos();
                sine.store(&mut sines, part);
                cosine.store(&mut cosines, part);
            }
            (sines, cosines)
        }
    }

    /// Robots' poses rest on this bound.
    #[test]
    fn sines_and_cosines_keep_their_bound_up_to_the_largest_angle() {
        let mut worst = 0.0f64;
        for k in -32_000i16..=32_000 {
            let angle = f32::from(k) * (MAX_ANGLE / 32_000.0);
            let (sines, cosines) =
                pulp::Arch::new().dispatch(SinesAndCosines(Singles([angle; 16])));
            let exact = f64::from(angle);
            worst = worst.max((f64::from(sines.0[5]) - libm::sin(exact)).abs());
            worst = worst.max((f64::from(cosines.0[15]) - libm::cos(exact)).abs());
        }
        assert!(worst < 6e-7, "{worst:e}");
    }

    struct Small(Singles);

    impl WithSimd for Small {
        type Output = Vec<u32>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<u32> {
            let one = SingleVector::splat(simd, 1.0);
            let part = |part| SingleVector::load(simd, &self.0, part).at_most(one);
            (0..single_registers::<S>()).map(|index| part(index).bits()).collect()
        }
    }

    #[test]
    fn masks_tell_their_lanes() {
        let mut singles = Singles([2.0; SINGLES]);
        (singles.0[0], singles.0[13]) = (1.0, 0.5);
        let bits = pulp::Arch::new().dispatch(Small(singles));
        let width = SINGLES / bits.len();
        let all = bits.iter().enumerate().map(|(part, bits)| bits << (part * width)).sum::<u32>();
        assert_eq!(all, 1 | 1 << 13);
    }
}
