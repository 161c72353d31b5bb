//! Eight numbers at a time.
//!
//! Plain arrays in fixed-size loops: inside [`vectorized`] the compiler turns
//! them into the widest instructions the machine has. Every lane is computed
//! alone and nothing is fused, so results do not depend on the machine.

use std::ops::{Add, Div, Index, Mul, Neg, Sub};

/// Number of lanes.
pub const WIDTH: usize = 8;

/// Eight independent numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

/// Eight independent truth values.
#[derive(Clone, Copy, Debug)]
pub struct Mask([bool; WIDTH]);

/// Runs `work` with the best instruction set the machine has; everything
/// `work` calls must be inlined into it to profit.
#[inline(always)]
pub fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    struct Work<F>(F);
    impl<F: FnOnce() -> R, R> pulp::NullaryFnOnce for Work<F> {
        type Output = R;
        #[inline(always)]
        fn call(self) -> R {
            (self.0)()
        }
    }
    pulp::Arch::new().dispatch(Work(work))
}

impl Lanes {
    /// All zero.
    pub const ZERO: Self = Self([0.0; WIDTH]);

    /// The same number in every lane.
    #[inline(always)]
    pub const fn splat(value: f64) -> Self {
        Self([value; WIDTH])
    }

    /// Lane by lane from `values`, the missing ones from `fill`.
    pub fn from_slice(values: &[f64], fill: f64) -> Self {
        Self(std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(fill)))
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for value in &mut out.0 {
            *value = f(*value);
        }
        out
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for lane in 0..WIDTH {
            out.0[lane] = f(self.0[lane], other.0[lane]);
        }
        out
    }

    /// Magnitudes.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// The larger of two, `self` where `other` is not a number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if b > a { b } else { a })
    }

    /// The smaller of two, `self` where `other` is not a number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if b < a { b } else { a })
    }

    /// Where `self` is below `other`.
    #[inline(always)]
    pub fn below(self, other: Self) -> Mask {
        let mut out = [false; WIDTH];
        for lane in 0..WIDTH {
            out[lane] = self.0[lane] < other.0[lane];
        }
        Mask(out)
    }

    /// The largest lane.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        // A tree of comparisons, so that they need not wait for each other.
        let v = &self.0;
        let larger = |a: f64, b: f64| if b > a { b } else { a };
        let low = larger(larger(v[0], v[1]), larger(v[2], v[3]));
        let high = larger(larger(v[4], v[5]), larger(v[6], v[7]));
        larger(low, high)
    }
}

impl Mask {
    /// `yes` where true, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Lanes, no: Lanes) -> Lanes {
        let mut out = no;
        for lane in 0..WIDTH {
            out.0[lane] = if self.0[lane] { yes.0[lane] } else { no.0[lane] };
        }
        out
    }

    /// Where both hold.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        let mut out = self;
        for lane in 0..WIDTH {
            out.0[lane] = self.0[lane] & other.0[lane];
        }
        out
    }

    /// True if any lane is.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.iter().fold(false, |any, &lane| any | lane)
    }
}

impl Index<usize> for Lanes {
    type Output = f64;
    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

macro_rules! arithmetic {
    ($($name:ident $method:ident $operator:tt;)*) => {$(
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
                self.map(|a| a $operator other)
            }
        }
    )*};
}

arithmetic! {
    Add add +;
    Sub sub -;
    Mul mul *;
    Div div /;
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
