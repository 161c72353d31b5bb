//! Sines and cosines of several angles at once, the same on every machine.
//!
//! Additions and multiplications only, in a fixed order, and no branch per angle: the compiler makes
//! the loop wide, and no library of the machine has a say in the last digit.

use super::lanes::WIDTH;

/// Within this an angle is reduced here; `libm` takes those beyond it.
const LARGEST: f64 = 1e6;

/// A half circle's half, in three parts; the first two have 33 bits, so that their products with
/// the number of quarter turns are exact (Cody and Waite).
const QUARTER: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Adding and subtracting this rounds to a whole number, which then stands in the lowest bits.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// `(sin r - r) / r³` in powers of `r²`, interpolated in Chebyshev nodes: within 1.4e-17 of `sin r`.
const SINE: [f64; 6] = [
    -0.166_666_666_666_666_66,
    8.333_333_333_330_925e-3,
    -1.984_126_983_672_243_7e-4,
    2.755_731_608_382_574e-6,
    -2.505_112_794_596_564e-8,
    1.591_784_866_512_194e-10,
];

/// `(cos r - 1 + r²/2) / r⁴` likewise: within 1e-18 of `cos r`.
const COSINE: [f64; 6] = [
    4.166_666_666_666_666_4e-2,
    -1.388_888_888_888_738_2e-3,
    2.480_158_729_874_308e-5,
    -2.755_731_726_001_471e-7,
    2.087_614_382_921_393_5e-9,
    -1.138_245_686_584_048_3e-11,
];

/// The sines and the cosines of `angles` (rad), each within 3e-16.
#[inline]
pub fn sin_cos(angles: &[f64; WIDTH]) -> ([f64; WIDTH], [f64; WIDTH]) {
    let (mut sines, mut cosines) = ([0.0; WIDTH], [0.0; WIDTH]);
    for lane in 0..WIDTH {
        (sines[lane], cosines[lane]) = reduced(angles[lane]);
    }
    // Also true where an angle is not a number.
    if !angles.iter().all(|angle| angle.abs() <= LARGEST) {
        for lane in 0..WIDTH {
            (sines[lane], cosines[lane]) = libm::sincos(angles[lane]);
        }
    }
    (sines, cosines)
}

/// Sine and cosine of an angle within [`LARGEST`].
#[inline(always)]
fn reduced(angle: f64) -> (f64, f64) {
    let shifted = angle * std::f64::consts::FRAC_2_PI + ROUNDING;
    let quarters = shifted - ROUNDING;
    let r = angle - quarters * QUARTER[0] - quarters * QUARTER[1] - quarters * QUARTER[2];
    let z = r * r;
    let polynomial = |[a, b, c, d, e, f]: [f64; 6]| {
        let (z2, z4) = (z * z, z * z * z * z);
        (a + b * z) + (c + d * z) * z2 + (e + f * z) * z4
    };
    let sine = r + r * z * polynomial(SINE);
    let cosine = 1.0 - (0.5 * z - z * z * polynomial(COSINE));
    // After an odd number of quarter turns the two change places; the second bit of the number
    // turns the sine's sign, of the number plus one the cosine's.
    let count = shifted.to_bits();
    let odd = 0_u64.wrapping_sub(count & 1);
    let (s, c) = (sine.to_bits(), cosine.to_bits());
    let exchange = (s ^ c) & odd;
    let sign = |number: u64| (number & 2) << 62;
    (
        f64::from_bits((s ^ exchange) ^ sign(count)),
        f64::from_bits((c ^ exchange) ^ sign(count.wrapping_add(1))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;

    #[track_caller]
    fn assert_right(angles: &[f64; WIDTH]) {
        let (sines, cosines) = sin_cos(angles);
        for lane in 0..WIDTH {
            let (sine, cosine) = libm::sincos(angles[lane]);
            assert!((sines[lane] - sine).abs() <= 3e-16, "sin {}", angles[lane]);
            assert!((cosines[lane] - cosine).abs() <= 3e-16, "cos {}", angles[lane]);
        }
    }

    #[test]
    fn sines_and_cosines_are_right_to_rounding() {
        let mut random = RandomStream::new(1, 0);
        for reach in [1e-9, 0.8, 3.2, 7.0, 100.0, 1e6, 1e15] {
            for _ in 0..2000 {
                assert_right(&std::array::from_fn(|_| random.uniform(-reach, reach)));
            }
        }
        for quarters in 0..40 {
            let angle = f64::from(quarters - 20) * std::f64::consts::FRAC_PI_2;
            assert_right(&std::array::from_fn(|lane| angle + (lane as f64 - 4.0) * 1e-9));
        }
    }

    #[test]
    fn what_is_not_finite_stays_visible() {
        let (sines, cosines) = sin_cos(&[0.0, f64::NAN, f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!((sines[0], cosines[0]), (0.0, 1.0));
        assert!(sines[1].is_nan() && cosines[2].is_nan());
    }
}
