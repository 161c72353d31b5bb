//! Benchmark functions F1 to F8 of Chen et al. 2023, doi:10.3390/app131810482, Table 2.
//!
//! Misprints are read as the functions they name: F2 and F3 are Schwefel's problems 2.22 and
//! 2.21 (printed with `|x^2|`); F4 is the step function without its floor. All have the least
//! value 0 (F5's noise aside), most of them at the origin, which methods that draw their
//! candidates there make look easy. Shifted, the optimum lies somewhere else.

mod values;

use std::f64::consts::PI;

use pulp::Arch;

use self::values::{Layout, Values};
use super::{Bounds, Candidate, Objective};
use crate::math::random::{RandomStream, derive_seed};

/// A function to measure optimizers on, of any dimension.
#[derive(Debug, PartialEq)]
pub struct Function {
    /// Name in requests.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// The formula, `n` being the dimension.
    pub formula: &'static str,
    /// The search box: every variable from `-range` to `range`.
    pub range: f64,
    /// Every coordinate of the optimum, unless shifted.
    pub optimum: f64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Sphere,
    Schwefel222,
    Schwefel221,
    Step,
    NoisyQuartic,
    Ackley,
    Griewank,
    Penalised2,
}

/// Where the functions come from.
pub const SOURCE: &str = "Chen et al. 2023, doi:10.3390/app131810482, Table 2";

/// All functions, in the paper's order.
pub static FUNCTIONS: &[Function] = &[
    Function {
        name: "f1",
        title: "Sphere",
        formula: "sum x²",
        range: 100.0,
        optimum: 0.0,
        kind: Kind::Sphere,
    },
    Function {
        name: "f2",
        title: "Schwefel 2.22",
        formula: "sum |x| + product |x|",
        range: 10.0,
        optimum: 0.0,
        kind: Kind::Schwefel222,
    },
    Function {
        name: "f3",
        title: "Schwefel 2.21",
        formula: "max |x|",
        range: 100.0,
        optimum: 0.0,
        kind: Kind::Schwefel221,
    },
    Function {
        name: "f4",
        title: "Step without floor",
        formula: "sum (x + 0.5)²",
        range: 100.0,
        optimum: -0.5,
        kind: Kind::Step,
    },
    Function {
        name: "f5",
        title: "Quartic with noise",
        formula: "sum i x⁴ + uniform noise in [0, 1), fresh with every evaluation",
        range: 1.28,
        optimum: 0.0,
        kind: Kind::NoisyQuartic,
    },
    Function {
        name: "f6",
        title: "Ackley",
        formula: "20 + e - 20 exp(-0.2 sqrt(sum x² / n)) - exp(sum cos(2 pi x) / n)",
        range: 32.0,
        optimum: 0.0,
        kind: Kind::Ackley,
    },
    Function {
        name: "f7",
        title: "Griewank",
        formula: "1 + sum x² / 4000 - product cos(x_i / sqrt i)",
        range: 600.0,
        optimum: 0.0,
        kind: Kind::Griewank,
    },
    Function {
        name: "f8",
        title: "Penalised 2",
        formula: "0.1 (sin²(3 pi x_1) + sum (x_i - 1)² (1 + sin²(3 pi x_(i+1))) + (x_n - 1)² \
                  (1 + sin²(2 pi x_n))) + sum u(x, 5, 100, 4)",
        range: 50.0,
        optimum: 1.0,
        kind: Kind::Penalised2,
    },
];

/// The function called `name`.
pub fn function(name: &str) -> Option<&'static Function> {
    FUNCTIONS.iter().find(|function| function.name == name)
}

/// All names, for messages.
pub fn function_names() -> String {
    FUNCTIONS.iter().map(|function| function.name).collect::<Vec<_>>().join(", ")
}

impl Function {
    /// The function of `dimension` variables; `seed` feeds the noise of F5.
    ///
    /// Shifted, the optimum's coordinates move by fixed pseudo-random amounts of
    /// 20 to 40 % of the range, up or down, the same for every seed.
    pub fn objective(
        &'static self,
        dimension: usize,
        shifted: bool,
        seed: u64,
    ) -> FunctionObjective {
        let bounds =
            Bounds { lower: vec![-self.range; dimension], upper: vec![self.range; dimension] };
        let mut random = RandomStream::new(0, 0x5348_4946_5400);
        let mut shift = || {
            let size = random.uniform(0.2, 0.4) * self.range;
            if random.unit() < 0.5 { -size } else { size }
        };
        let factor = |i: usize| match self.kind {
            Kind::NoisyQuartic => (i + 1) as f64,
            // Griewank's angles in half turns, halved: cos(2 a) = 1 - 2 sin² a.
            Kind::Griewank => 0.5 / (PI * ((i + 1) as f64).sqrt()),
            _ => 1.0,
        };
        let shifts: Vec<f64> =
            (0..dimension).map(|_| if shifted { shift() } else { 0.0 }).collect();
        let factors: Vec<f64> = (0..dimension).map(factor).collect();
        // Lanes without a variable stand where they add nothing to any sum.
        let layout = Layout::new(&shifts, &factors, self.optimum);
        FunctionObjective { function: self, bounds, shifts, layout, seed }
    }
}

/// A benchmark function of a certain dimension.
#[derive(Clone, Debug)]
pub struct FunctionObjective {
    function: &'static Function,
    bounds: Bounds,
    shifts: Vec<f64>,
    layout: Layout,
    seed: u64,
}

impl FunctionObjective {
    /// Where the optimum lies.
    pub fn optimum(&self) -> Vec<f64> {
        self.shifts.iter().map(|shift| self.function.optimum + shift).collect()
    }
}

impl Objective for FunctionObjective {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        Box::new(FunctionCandidate { objective: self, rows: Vec::new() })
    }

    fn evaluation_ns(&self) -> f64 {
        10.0 + self.shifts.len() as f64
    }
}

struct FunctionCandidate<'a> {
    objective: &'a FunctionObjective,
    /// Candidates too short for a register, lengthened.
    rows: Vec<f64>,
}

impl Candidate for FunctionCandidate<'_> {
    /// As the first evaluation of a search.
    fn fitness(&mut self, position: &[f64]) -> f64 {
        let mut value = [f64::INFINITY];
        self.batch(0, position, &mut value);
        value[0]
    }

    fn batch(&mut self, first: u64, positions: &[f64], fitness: &mut [f64]) {
        let FunctionObjective { function, layout, seed, .. } = self.objective;
        let rows = layout.rows(positions, &mut self.rows);
        Arch::new().dispatch(Values { kind: function.kind, layout, rows, values: fitness });
        if function.kind == Kind::NoisyQuartic {
            for (evaluation, value) in (first..).zip(fitness) {
                *value += noise(*seed, evaluation);
            }
        }
    }
}

/// Uniform in [0, 1): the noise of evaluation number `evaluation`.
fn noise(seed: u64, evaluation: u64) -> f64 {
    const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
    (derive_seed(seed, evaluation) >> 11) as f64 * SCALE
}

#[cfg(test)]
mod tests {
    use std::f64::consts::E;

    use super::*;

    fn value(name: &str, x: &[f64]) -> f64 {
        let objective = function(name).unwrap().objective(x.len(), false, 1);
        objective.candidate().fitness(x)
    }

    /// The formulas once more, number by number.
    fn plainly(name: &str, x: &[f64]) -> f64 {
        let n = x.len();
        let squares: f64 = x.iter().map(|x| x * x).sum();
        let indexed = || x.iter().enumerate().map(|(i, x)| ((i + 1) as f64, x));
        match name {
            "f1" => squares,
            "f2" => {
                x.iter().map(|x| x.abs()).sum::<f64>() + x.iter().map(|x| x.abs()).product::<f64>()
            }
            "f3" => x.iter().fold(0.0, |most: f64, x| most.max(x.abs())),
            "f4" => x.iter().map(|x| (x + 0.5).powi(2)).sum(),
            "f5" => indexed().map(|(i, x)| i * x.powi(4)).sum::<f64>() + noise(1, 0),
            "f6" => {
                let cosines: f64 = x.iter().map(|x| (2.0 * PI * x).cos()).sum();
                20.0 + E
                    - 20.0 * (-0.2 * (squares / n as f64).sqrt()).exp()
                    - (cosines / n as f64).exp()
            }
            "f7" => {
                1.0 + squares / 4000.0
                    - indexed().map(|(i, x)| (x / i.sqrt()).cos()).product::<f64>()
            }
            "f8" => {
                let sine = |x: f64| (PI * x).sin().powi(2);
                let terms: f64 = (0..n)
                    .map(|i| {
                        let after = if i + 1 < n { 3.0 * x[i + 1] } else { 2.0 * x[i] };
                        (x[i] - 1.0).powi(2) * (1.0 + sine(after))
                    })
                    .sum();
                let penalty: f64 = x.iter().map(|x| 100.0 * (x.abs() - 5.0).max(0.0).powi(4)).sum();
                0.1 * (sine(3.0 * x[0]) + terms) + penalty
            }
            _ => unreachable!(),
        }
    }

    #[test]
    fn values_follow_the_formulas() {
        let mut random = RandomStream::new(3, 0);
        for function in FUNCTIONS {
            for dimension in [1, 2, 7, 8, 9, 30, 33] {
                for _ in 0..50 {
                    let x: Vec<f64> = (0..dimension)
                        .map(|_| random.uniform(-function.range, function.range))
                        .collect();
                    let (found, expected) = (value(function.name, &x), plainly(function.name, &x));
                    let off = (found - expected).abs() / expected.abs().max(1.0);
                    assert!(off < 1e-12, "{} {dimension}: {found} {expected}", function.name);
                }
            }
        }
    }

    #[test]
    fn optima_are_zero_and_where_they_are_said_to_be() {
        for function in FUNCTIONS.iter().filter(|function| function.name != "f5") {
            for shifted in [false, true] {
                let objective = function.objective(30, shifted, 1);
                let optimum = objective.optimum();
                assert_eq!(shifted, optimum.iter().all(|x| (x - function.optimum).abs() > 0.1));
                let inside = optimum.iter().all(|x| x.abs() < 0.5 * function.range);
                assert!(inside, "{}: {optimum:?}", function.name);
                let least = objective.candidate().fitness(&optimum);
                assert!((0.0..2e-15).contains(&least), "{}: {least:e}", function.name);
            }
        }
    }

    /// Noise belongs to the evaluation, not to the place or the thread.
    #[test]
    fn noise_is_fresh_and_repeats() {
        let objective = function("f5").unwrap().objective(3, false, 9);
        let zeros = [0.0; 3 * 100];
        let mut row = [0.0; 100];
        objective.candidate().batch(0, &zeros, &mut row);
        let mut distinct = row.to_vec();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        assert_eq!(distinct.len(), 100);
        let mut part = [0.0; 60];
        objective.candidate().batch(40, &zeros[..3 * 60], &mut part);
        assert_eq!(part, row[40..]);
    }
}
