//! Golden Sine Algorithm (Gold-SA).
//!
//! Tanyildizi and Demir 2017, doi:10.4316/AECE.2017.02010, and their published code. Each
//! candidate moves along a sine of random phase; golden-section coefficients `x1`, `x2` weigh
//! the best against the candidate, and their interval narrows with every evaluation:
//! `x <- x |sin R1| - R2 sin R1 |x1 g - x2 x|`, clamped to the box.
//!
//! Readings: the paper's formula has two independent draws, its code one (`coupled_random`).
//! Chen et al. 2023 print `x1` and `x2` swapped against the code; the code's form is taken.
//! All candidates of a generation are moved before the first is evaluated, so the interval
//! that moved them is that of the generation before. An interval that has collapsed to less
//! than 1e-12 is drawn anew.
//!
//! Mind: `x |sin R1|` draws candidates to the origin, whatever is minimised.

use std::f64::consts::PI;

use pulp::Arch;

use super::entry::{OptimizerEntry, Parameter, SHIFT, Settings, flag, iterations, population};
use super::particles::mean;
use super::{Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "gold_sa",
    title: "Golden Sine Algorithm",
    description: "Candidates move along sines of random phase with golden-section coefficients. \
                  Draws candidates to the origin, whatever is minimised: see shift.",
    source: "Tanyildizi and Demir 2017, doi:10.4316/AECE.2017.02010",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(GoldenSine::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(300.0),
    flag(
        "coupled_random",
        "one random number for both R1 and R2 as in the authors' code, instead of two as in their \
         formula; default true",
        true,
    ),
    SHIFT,
];

struct GoldenSine {
    random: RandomStream,
    coupled: bool,
    section: GoldenSection,
    /// What positions are measured from.
    origin: Vec<f64>,
    started: bool,
    position: Vec<f64>,
    fitness: Vec<f64>,
}

impl GoldenSine {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        let dimension = objective.bounds().dimension();
        Self {
            random: RandomStream::new(seed, 0),
            coupled: settings.flag("coupled_random"),
            section: GoldenSection::default(),
            origin: origin(settings, objective),
            started: false,
            position: vec![0.0; population * dimension],
            fitness: vec![f64::INFINITY; population],
        }
    }

    fn turn(&mut self, evaluator: &Evaluator<'_>) {
        let GoldenSection { x1, x2, .. } = self.section;
        let best = evaluator.best_position();
        for candidate in self.position.chunks_exact_mut(best.len()) {
            let first = self.random.unit();
            let second = if self.coupled { first } else { self.random.unit() };
            let sine = libm::sin(2.0 * PI * first);
            let reach = PI * second * sine;
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for ((x, g), o) in candidate.iter_mut().zip(best).zip(&self.origin) {
                        let (from, to) = (*x - o, g - o);
                        *x = o + (from * sine.abs() - reach * (x1 * to - x2 * from).abs());
                    }
                },
            );
        }
        evaluator.bounds().clamp(&mut self.position);
    }
}

impl Optimizer for GoldenSine {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        let best = evaluator.best();
        if self.started && !evaluator.best_position().is_empty() {
            self.turn(evaluator);
        } else {
            evaluator.bounds().scatter(&mut self.position, &mut self.random);
        }
        evaluator.population(&self.position, &mut self.fitness);
        if self.started {
            self.section.follow(best, &self.fitness, &mut self.random);
        }
        self.started = true;
        Step { mean: mean(&self.fitness), converged: false }
    }
}

/// What positions are measured from: the origin or, shifted, the box's centre.
pub fn origin(settings: &Settings, objective: &dyn Objective) -> Vec<f64> {
    let bounds = objective.bounds();
    if settings.flag("shift") { bounds.centre() } else { vec![0.0; bounds.dimension()] }
}

/// The golden ratio's inverse.
const TAU: f64 = 0.618_033_988_749_894_8;

/// An interval below this has collapsed.
const COLLAPSED: f64 = 1e-12;

/// A golden-section search over the coefficients of the sine step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoldenSection {
    a: f64,
    b: f64,
    /// Weight of the best.
    pub x1: f64,
    /// Weight of the candidate.
    pub x2: f64,
}

impl Default for GoldenSection {
    fn default() -> Self {
        Self::over(-PI, PI)
    }
}

impl GoldenSection {
    fn over(a: f64, b: f64) -> Self {
        Self { a, b, x1: a + (1.0 - TAU) * (b - a), x2: a + TAU * (b - a) }
    }

    /// Narrows the interval once per candidate, in order: from above where the
    /// candidate improves on `best`, from below where it does not.
    pub fn follow(&mut self, mut best: f64, fitness: &[f64], random: &mut RandomStream) {
        for &fitness in fitness {
            let improved = fitness < best;
            best = best.min(fitness);
            self.narrow(improved);
            if (self.x1 - self.x2).abs() < COLLAPSED {
                let (a, b) = (-PI * random.unit(), PI * random.unit());
                *self = Self::over(a, b);
            }
        }
    }

    fn narrow(&mut self, improved: bool) {
        let Self { a, b, x1, x2 } = *self;
        *self = if improved {
            Self { a, b: x2, x1: a + (1.0 - TAU) * (x2 - a), x2: x1 }
        } else {
            Self { a: x1, b, x1: x2, x2: x1 + TAU * (b - x1) }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_section(section: GoldenSection, expected: [f64; 4]) {
        let found = [section.a, section.b, section.x1, section.x2];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{section:?}: {expected}");
        }
    }

    /// Worked out by hand: with `b - a = 2 pi`, `x1 = -pi + 2 pi (1 - tau) = -0.7416...`.
    #[test]
    fn the_section_narrows_from_the_side_that_failed() {
        let mut random = RandomStream::new(1, 0);
        let start = GoldenSection::default();
        assert_section(start, [-PI, PI, -0.741_629_424, 0.741_629_424]);
        let mut section = start;
        section.follow(1.0, &[0.5], &mut random);
        assert_section(section, [-PI, 0.741_629_424, -1.658_333_806, -0.741_629_424]);
        let mut section = start;
        section.follow(1.0, &[1.0], &mut random);
        assert_section(section, [-0.741_629_424, PI, 0.741_629_424, 1.658_333_806]);
    }

    /// The second of two equal improvements is none.
    #[test]
    fn candidates_are_judged_in_order() {
        let mut random = RandomStream::new(1, 0);
        let mut section = GoldenSection::default();
        section.follow(1.0, &[0.5, 0.5], &mut random);
        let mut expected = GoldenSection::default();
        expected.narrow(true);
        expected.narrow(false);
        assert_eq!(section, expected);
    }

    #[test]
    fn a_collapsed_interval_is_drawn_anew() {
        let mut random = RandomStream::new(1, 0);
        let mut section = GoldenSection::default();
        let mut widest = 0.0f64;
        for _ in 0..1000 {
            let before = section;
            section.follow(0.0, &[1.0], &mut random);
            let width = section.b - section.a;
            assert!(width > 0.0 && width.is_finite());
            if width > before.b - before.a {
                widest = widest.max(width);
            }
        }
        assert!(widest > 1.0, "never drawn anew");
    }
}
