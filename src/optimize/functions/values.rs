//! Values of the functions, noise aside, in the machine's widest registers.

use std::f64::consts::E;

use pulp::{Simd, WithSimd};

use super::Kind;
use crate::math::lanes::{Lanes, Vector, WIDTH, exp, registers};

type Eight = [f64; WIDTH];

/// How a candidate's variables fill registers of eight. Where they do not fill
/// the last one, it begins with lanes that do not count.
#[derive(Clone, Debug)]
pub struct Layout {
    dimension: usize,
    registers: Vec<Register>,
    /// What lanes that do not count hold.
    filler: f64,
}

/// What belongs to the variables in a register.
#[derive(Clone, Debug)]
struct Register {
    /// Where it begins in a row.
    start: usize,
    /// The first lane that counts.
    first: usize,
    shift: Lanes,
    /// Zero in lanes that do not count.
    factor: Lanes,
}

impl Layout {
    /// For one shift and one positive factor per variable.
    pub fn new(shifts: &[f64], factors: &[f64], filler: f64) -> Self {
        let dimension = shifts.len();
        let register = |index: usize| {
            let end = ((index + 1) * WIDTH).min(dimension);
            let first = (index + 1) * WIDTH - end;
            let lanes = |of: &[f64]| {
                let lane = |l: usize| if l < first { 0.0 } else { of[end + l - WIDTH] };
                Lanes(std::array::from_fn(lane))
            };
            let start = end.saturating_sub(WIDTH);
            Register { start, first, shift: lanes(shifts), factor: lanes(factors) }
        };
        let registers = (0..dimension.div_ceil(WIDTH)).map(register).collect();
        Self { dimension, registers, filler }
    }

    /// The candidates, lengthened at the front where they are shorter than a register.
    pub fn rows<'a>(&self, positions: &'a [f64], longer: &'a mut Vec<f64>) -> &'a [f64] {
        if self.dimension >= WIDTH {
            return positions;
        }
        longer.clear();
        for position in positions.chunks_exact(self.dimension) {
            longer.resize(longer.len() + WIDTH - self.dimension, 0.0);
            longer.extend_from_slice(position);
        }
        longer
    }
}

/// The values of a kind of function at [`Layout::rows`].
pub struct Values<'a> {
    pub kind: Kind,
    pub layout: &'a Layout,
    pub rows: &'a [f64],
    pub values: &'a mut [f64],
}

impl WithSimd for Values<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.kind {
            Kind::Sphere => self.each(simd, |p| p.sum(|x, _| x * x)),
            Kind::Schwefel222 => self.each(simd, |p| p.schwefel_2_22()),
            Kind::Schwefel221 => self.each(simd, |p| p.largest()),
            Kind::Step => self.each(simd, |p| p.sum(|x, _| (x + 0.5) * (x + 0.5))),
            Kind::NoisyQuartic => self.each(simd, |p| p.sum(|x, i| i * (x * x) * (x * x))),
            Kind::Ackley => self.ackley(simd),
            Kind::Griewank => self.each(simd, |p| p.griewank()),
            Kind::Penalised2 => self.each(simd, |p| p.penalised_2()),
        }
    }
}

impl Values<'_> {
    #[inline(always)]
    fn stride(&self) -> usize {
        self.layout.dimension.max(WIDTH)
    }

    #[inline(always)]
    fn each<S: Simd>(self, simd: S, value: impl Fn(Point<'_, S>) -> f64) {
        let rows = self.rows.chunks_exact(self.stride());
        for (row, out) in rows.zip(self.values) {
            *out = value(Point { simd, row, layout: self.layout });
        }
    }

    /// Exponentials are computed for eight candidates at once.
    #[inline(always)]
    fn ackley<S: Simd>(self, simd: S) {
        let (stride, n) = (self.stride(), self.layout.dimension as f64);
        let chunks = self.rows.chunks(WIDTH * stride).zip(self.values.chunks_mut(WIDTH));
        for (rows, values) in chunks {
            let (mut squares, mut sines) = ([0.0; WIDTH], [0.0; WIDTH]);
            for (index, row) in rows.chunks_exact(stride).enumerate() {
                let point = Point { simd, row, layout: self.layout };
                [squares[index], sines[index]] = point.squares_and_sines();
            }
            let (mut distance, mut cosines) = (squares, sines);
            for l in 0..WIDTH {
                distance[l] = -0.2 * (squares[l] / n).sqrt();
                // cos(2 pi x) = 1 - 2 sin²(pi x).
                cosines[l] = 1.0 - 2.0 * sines[l] / n;
            }
            let (far, waves) = (exp(distance), exp(cosines));
            let mut all = [0.0; WIDTH];
            for l in 0..WIDTH {
                // In this order rounding leaves a positive number at the optimum.
                all[l] = -20.0 * far[l] - waves[l] + 20.0 + E;
            }
            values.copy_from_slice(&all[..values.len()]);
        }
    }
}

/// One candidate.
#[derive(Clone, Copy)]
struct Point<'a, S> {
    simd: S,
    row: &'a [f64],
    layout: &'a Layout,
}

impl<S: Simd> Point<'_, S> {
    /// Folds the variables, as seen from the shifted origin, and their factors,
    /// lane by lane.
    #[inline(always)]
    fn fold<const N: usize>(
        self,
        start: [f64; N],
        f: impl Fn([Vector<S>; N], Vector<S>, Vector<S>) -> [Vector<S>; N],
    ) -> [Eight; N] {
        let mut lanes = [Lanes::ZERO; N];
        for part in 0..registers::<S>(WIDTH) {
            let mut folded = start.map(|value| Vector::splat(self.simd, value));
            for register in &self.layout.registers {
                let x = self.variables(register, part);
                folded = f(folded, x, Vector::load(self.simd, &register.factor, part));
            }
            for (folded, lanes) in folded.into_iter().zip(&mut lanes) {
                folded.store(lanes, part);
            }
        }
        lanes.map(|lanes| lanes.0)
    }

    #[inline(always)]
    fn variables(self, register: &Register, part: usize) -> Vector<S> {
        let splat = |value| Vector::splat(self.simd, value);
        let Some(row) = self.row[register.start..].first_chunk() else {
            return splat(self.layout.filler);
        };
        let x = Vector::read(self.simd, row, part) - Vector::load(self.simd, &register.shift, part);
        let factor = Vector::load(self.simd, &register.factor, part);
        splat(0.0).below(factor).select(x, splat(self.layout.filler))
    }

    /// Sum of `f` of variable and factor.
    #[inline(always)]
    fn sum(self, f: impl Fn(Vector<S>, Vector<S>) -> Vector<S>) -> f64 {
        let [sums] = self.fold(
            [0.0],
            #[inline(always)]
            |[sum], x, factor| [sum + f(x, factor)],
        );
        total(sums)
    }

    #[inline(always)]
    fn schwefel_2_22(self) -> f64 {
        let [none, one] = [0.0, 1.0].map(|value| Vector::splat(self.simd, value));
        let [sums, products] = self.fold(
            [0.0, 1.0],
            #[inline(always)]
            |[sum, product], x, factor| {
                let counts = none.below(factor);
                [sum + x.abs(), product * counts.select(x.abs(), one)]
            },
        );
        total(sums) + product(products)
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        let [most] = self.fold(
            [0.0],
            #[inline(always)]
            |[most], x, _| [most.max(x.abs())],
        );
        most.into_iter().fold(0.0, f64::max)
    }

    /// Sums of `x²` and `sin²(pi x)`.
    #[inline(always)]
    fn squares_and_sines(self) -> [f64; 2] {
        let sums = self.fold(
            [0.0; 2],
            #[inline(always)]
            |[squares, sines], x, _| [squares + x * x, sines + x.sin_squared()],
        );
        sums.map(total)
    }

    #[inline(always)]
    fn griewank(self) -> f64 {
        let one = Vector::splat(self.simd, 1.0);
        let [squares, cosines] = self.fold(
            [0.0, 1.0],
            #[inline(always)]
            |[squares, cosines], x, factor| {
                let sine = (x * factor).sin_squared();
                [squares + x * x, cosines * (one - (sine + sine))]
            },
        );
        1.0 + total(squares) / 4000.0 - product(cosines)
    }

    /// A variable's factor holds the sine of the next one, so the walk is from
    /// the last to the first.
    #[inline(always)]
    fn penalised_2(self) -> f64 {
        let mut terms = [0.0; WIDTH];
        let mut after = None;
        for register in self.layout.registers.iter().rev() {
            let (mut x, mut sines, mut ends) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
            for part in 0..registers::<S>(WIDTH) {
                let variables = self.variables(register, part);
                variables.store(&mut x, part);
                (variables * 3.0).sin_squared().store(&mut sines, part);
                (variables * 2.0).sin_squared().store(&mut ends, part);
            }
            let last = after.unwrap_or(ends.0[WIDTH - 1]);
            for (l, (term, x)) in terms.iter_mut().zip(x.0).enumerate() {
                let next = if l + 1 < WIDTH { sines.0[l + 1] } else { last };
                let (off, beyond) = (x - 1.0, x.abs() - 5.0);
                let square = if beyond > 0.0 { beyond * beyond } else { 0.0 };
                *term += 0.1 * (off * off) * (1.0 + next) + 100.0 * (square * square);
            }
            after = Some(sines.0[register.first]);
        }
        0.1 * after.unwrap_or(0.0) + total(terms)
    }
}

#[inline(always)]
fn total([a, b, c, d, e, f, g, h]: Eight) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[inline(always)]
fn product([a, b, c, d, e, f, g, h]: Eight) -> f64 {
    ((a * e) * (c * g)) * ((b * f) * (d * h))
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, Scalar};

    use crate::math::random::RandomStream;
    use crate::optimize::functions::FUNCTIONS;

    use super::*;

    /// Nor do candidates depend on those beside them.
    #[test]
    fn values_do_not_depend_on_the_width_of_registers() {
        let mut random = RandomStream::new(5, 0);
        for function in FUNCTIONS {
            for dimension in [1, 5, 8, 30] {
                let layout = function.objective(dimension, true, 1).layout;
                let mut positions = vec![0.0; 19 * dimension];
                positions.fill_with(|| random.uniform(-function.range, function.range));
                let (mut wide, mut narrow, mut longer) = ([0.0; 19], [0.0; 19], Vec::new());
                let rows = layout.rows(&positions, &mut longer);
                let (kind, layout) = (function.kind, &layout);
                Arch::new().dispatch(Values { kind, layout, rows, values: &mut wide });
                let stride = rows.len() / narrow.len();
                for (row, value) in rows.chunks_exact(stride).zip(narrow.chunks_exact_mut(1)) {
                    Values { kind, layout, rows: row, values: value }.with_simd(Scalar::new());
                }
                assert_eq!(wide, narrow, "{} {dimension}", function.name);
            }
        }
    }
}
