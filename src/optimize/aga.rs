//! Adaptive genetic algorithm of Lin and Yang.
//!
//! After Srinivas and Patnaik 1994, doi:10.1109/21.286385: good individuals are
//! crossed and mutated less. With merit `F`, its average and its maximum,
//!
//! ```text
//! pc = k1 - (k1 - k2) (F' - Favg) / (Fmax - Favg)   if F' >= Favg, else k1
//! pm = k3 - (k3 - k4) (F  - Favg) / (Fmax - Favg)   if F  >= Favg, else k3
//! ```
//!
//! where `F'` is the better of a pair. Individuals of at least average merit
//! survive, a roulette among them fills the gaps, and all mate in random
//! pairs; the best lives on unchanged. Limits enter through an outer penalty,
//! `f = sum h + eps p` with `p` the sum of squared relative excesses and `eps`
//! growing, where the objective tells both apart (`constraint_handling:
//! penalty`); what counts as the best found is the objective's own fitness, by
//! which no infeasible candidate beats a feasible one.
//!
//! Readings: eq. 5 prints `Favg - f`, which would mutate good individuals
//! more; the sign here is the usual one. The paper minimises `f` but calls larger
//! better; merit is `F = 1 / f`, and `1 / (1 + f - f_min)` where `f` is not
//! positive throughout. A child's `pm` is that of the parent whose place it takes. The
//! prose asks for much crossover early and much mutation late, which the
//! formulas do not do: `generation_factor`. While no individual was feasible all are drawn anew.

use super::entry::{OptimizerEntry, Parameter, Settings, flag, iterations, population, real};
use super::genetic::{Roulette, cross, index, mutate};
use super::particles::mean;
use super::{Appraisal, Bounds, Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "aga",
    title: "Adaptive genetic algorithm of Lin and Yang",
    description: "Genetic algorithm whose crossover and mutation rates fall with an individual's \
                  merit, with an outer penalty that grows. The paper's penalty is \
                  constraint_handling: penalty.",
    source: "Lin and Yang, undated; Srinivas and Patnaik 1994, doi:10.1109/21.286385",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(Adaptive::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    population(100.0),
    iterations(100.0),
    real(
        "crossover_rate_most",
        "k1, crossover rate up to average merit; 0.9 as in Lin and Yang",
        0.9,
        0.0,
        1.0,
    ),
    real(
        "crossover_rate_least",
        "k2, crossover rate of the best; 0.1 as in Lin and Yang",
        0.1,
        0.0,
        1.0,
    ),
    real(
        "mutation_rate_most",
        "k3, mutation rate up to average merit; 0.2 as in Lin and Yang",
        0.2,
        0.0,
        1.0,
    ),
    real(
        "mutation_rate_least",
        "k4, mutation rate of the best; 0.005 as in Lin and Yang",
        0.005,
        0.0,
        1.0,
    ),
    flag(
        "generation_factor",
        "let crossover fall to half and mutation rise from half over the search, as \
                      Lin and Yang's prose asks but their formulas do not; default false",
        false,
    ),
    flag(
        "outer_penalty",
        "select by cost plus eps times the squared relative excess, where the \
                      problem tells them apart, as Lin and Yang do, instead of by the problem's \
                      own fitness; default true",
        true,
    ),
    real("penalty", "eps of the first generation; not printed, 10 is our choice", 10.0, 0.0, 1e12),
    real(
        "penalty_doubling",
        "generations in which eps doubles, up to 40 times; not printed, 20 is our choice",
        20.0,
        1.0,
        1e9,
    ),
];

/// `eps` doubles no more often than this.
const MOST_DOUBLINGS: f64 = 40.0;

/// Merits nearer than this, relative, differ by rounding.
const ALIKE: f64 = 1e-12;

/// Below this the reciprocals of fitnesses would leave the range of numbers.
const LEAST_POSITIVE: f64 = 1e-100;

struct Adaptive {
    random: RandomStream,
    population: usize,
    iterations: u64,
    crossover: [f64; 2],
    mutation: [f64; 2],
    generation_factor: bool,
    outer_penalty: bool,
    penalty: f64,
    penalty_doubling: f64,
    generation: u64,
    position: Vec<f64>,
    next: Vec<f64>,
    appraisals: Vec<Appraisal>,
    next_appraisals: Vec<Appraisal>,
    fitness: Vec<f64>,
    merits: Merits,
    parents: Vec<usize>,
    wheel: Roulette,
}

impl Adaptive {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        let position = vec![0.0; population * objective.bounds().dimension()];
        Self {
            random: RandomStream::new(seed, 0),
            population,
            iterations: settings.integer("iterations"),
            crossover: ["crossover_rate_most", "crossover_rate_least"].map(|k| settings.get(k)),
            mutation: ["mutation_rate_most", "mutation_rate_least"].map(|k| settings.get(k)),
            generation_factor: settings.flag("generation_factor"),
            outer_penalty: settings.flag("outer_penalty"),
            penalty: settings.get("penalty"),
            penalty_doubling: settings.get("penalty_doubling"),
            generation: 0,
            next: position.clone(),
            position,
            appraisals: vec![Appraisal::UNUSABLE; population],
            next_appraisals: vec![Appraisal::UNUSABLE; population],
            fitness: vec![f64::INFINITY; population],
            merits: Merits::default(),
            parents: Vec::with_capacity(population),
            wheel: Roulette::with_capacity(population),
        }
    }

    /// What selection minimises, at the present `eps`.
    fn rate(&mut self) {
        let doublings = (self.generation as f64 / self.penalty_doubling).min(MOST_DOUBLINGS);
        let eps = self.penalty * libm::exp2(doublings);
        for (value, appraisal) in self.fitness.iter_mut().zip(&self.appraisals) {
            let Appraisal { fitness, cost, excess } = *appraisal;
            // An excess of zero costs nothing, whatever the penalty.
            let penalty = if excess > 0.0 { eps * excess } else { 0.0 };
            *value = if self.outer_penalty { cost + penalty } else { fitness };
        }
        self.merits.set(&self.fitness);
    }

    /// The survivors, a roulette among them for the rest, in random order.
    fn select(&mut self) {
        let Merits { values, average, largest, .. } = &self.merits;
        // An average of equal numbers may round to more than each of them.
        let threshold = average.min(*largest);
        let survives = |&individual: &usize| values[individual] >= threshold;
        self.parents.clear();
        self.parents.extend((0..self.population).filter(survives));
        let survivors = self.parents.len();
        self.wheel.set(self.parents.iter().map(|&individual| values[individual]));
        for _ in survivors..self.population {
            let survivor = self.wheel.spin(&mut self.random);
            self.parents.push(self.parents[survivor]);
        }
        for last in (1..self.population).rev() {
            self.parents.swap(last, index(last + 1, &mut self.random));
        }
    }

    /// Puts the next generation in the place of this one, the best first.
    fn breed(&mut self, bounds: &Bounds) {
        self.rate();
        self.select();
        self.generation += 1;
        let dimension = bounds.dimension();
        let best = self.merits.best;
        self.next_appraisals[0] = self.appraisals[best];
        self.next[..dimension]
            .copy_from_slice(&self.position[best * dimension..(best + 1) * dimension]);
        self.mate(bounds);
        std::mem::swap(&mut self.position, &mut self.next);
        std::mem::swap(&mut self.appraisals, &mut self.next_appraisals);
    }

    /// Makes all children but the first, whose place the best takes.
    fn mate(&mut self, bounds: &Bounds) {
        let dimension = bounds.dimension();
        let [crossing, mutating] = self.generation_factors();
        let (random, merits) = (&mut self.random, &self.merits);
        let pairs = self.parents[1..].chunks(2);
        for (pair, children) in pairs.zip(self.next[dimension..].chunks_mut(2 * dimension)) {
            for (&parent, child) in pair.iter().zip(children.chunks_exact_mut(dimension)) {
                child.copy_from_slice(&self.position[parent * dimension..(parent + 1) * dimension]);
            }
            if let [first, second] = *pair {
                let better = merits.values[first].max(merits.values[second]);
                if random.unit() < crossing * merits.rate(self.crossover, better) {
                    let (first, second) = children.split_at_mut(dimension);
                    cross(first, second, random);
                }
            }
            for (&parent, child) in pair.iter().zip(children.chunks_exact_mut(dimension)) {
                let rate = merits.rate(self.mutation, merits.values[parent]);
                if random.unit() < mutating * rate {
                    mutate(child, bounds, random);
                }
            }
        }
    }

    /// Factors on crossover and mutation rates in this generation.
    fn generation_factors(&self) -> [f64; 2] {
        if !self.generation_factor {
            return [1.0, 1.0];
        }
        let done = self.generation as f64 / self.iterations.max(1) as f64;
        [1.0 - 0.5 * done, 0.5 + 0.5 * done]
    }
}

impl Optimizer for Adaptive {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        let bounds = evaluator.bounds();
        let kept = if evaluator.best_position().is_empty() {
            bounds.scatter(&mut self.position, &mut self.random);
            0
        } else {
            self.breed(bounds);
            1
        };
        let new = &self.position[kept * bounds.dimension()..];
        evaluator.appraise(new, &mut self.appraisals[kept..]);
        for (fitness, appraisal) in self.fitness.iter_mut().zip(&self.appraisals) {
            *fitness = appraisal.fitness;
        }
        Step { mean: mean(&self.fitness), converged: false }
    }
}

/// How good the individuals of a generation are; larger is better.
#[derive(Debug, Default)]
struct Merits {
    values: Vec<f64>,
    average: f64,
    largest: f64,
    /// The first individual of the largest merit.
    best: usize,
}

impl Merits {
    fn set(&mut self, fitness: &[f64]) {
        let least = fitness.iter().copied().fold(f64::INFINITY, f64::min);
        let shift = if least >= LEAST_POSITIVE { 0.0 } else { 1.0 - least };
        let merit = |f: &f64| if f.is_finite() { 1.0 / (f + shift) } else { 0.0 };
        self.values.clear();
        self.values.extend(fitness.iter().map(merit));
        self.average = self.values.iter().sum::<f64>() / fitness.len() as f64;
        self.best = 0;
        for (individual, value) in self.values.iter().enumerate() {
            if *value > self.values[self.best] {
                self.best = individual;
            }
        }
        self.largest = self.values[self.best];
    }

    /// `most` up to the average merit, falling to `least` at the largest.
    fn rate(&self, [most, least]: [f64; 2], merit: f64) -> f64 {
        let spread = self.largest - self.average;
        if merit < self.average || spread <= ALIKE * self.largest {
            return most;
        }
        most - (most - least) * (merit - self.average) / spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merits(fitness: &[f64]) -> Merits {
        let mut merits = Merits::default();
        merits.set(fitness);
        merits
    }

    /// Merits 1, 1/2, 1/4 and 1/4 of average 1/2.
    #[test]
    fn rates_fall_from_the_average_to_the_best() {
        let merits = merits(&[1.0, 2.0, 4.0, 4.0]);
        assert_eq!((merits.average, merits.largest, merits.best), (0.5, 1.0, 0));
        let crossover = |merit| merits.rate([0.9, 0.1], merit);
        assert_eq!((crossover(0.25), crossover(0.5)), (0.9, 0.9));
        assert!((crossover(0.75) - 0.5).abs() < 1e-15 && (crossover(1.0) - 0.1).abs() < 1e-15);
        let mutation = |merit| merits.rate([0.2, 0.005], merit);
        assert_eq!((mutation(0.25), mutation(0.5)), (0.2, 0.2));
        assert!((mutation(1.0) - 0.005).abs() < 1e-15);
    }

    #[test]
    fn a_generation_of_equals_has_the_highest_rates() {
        let merits = merits(&[0.3; 7]);
        assert_eq!(merits.rate([0.9, 0.1], merits.largest), 0.9);
    }

    #[test]
    fn merit_falls_with_fitness_whatever_its_sign() {
        for fitness in [[-3.0, 0.0, 1e9, f64::INFINITY], [1e-300, 2.0, 5.0, f64::INFINITY]] {
            let merits = merits(&fitness);
            assert!(merits.values.windows(2).all(|pair| pair[0] > pair[1]), "{merits:?}");
            assert_eq!((merits.largest, merits.values[3]), (1.0, 0.0));
        }
    }

    #[test]
    fn without_anything_feasible_nobody_has_merit() {
        let merits = merits(&[f64::INFINITY; 3]);
        assert_eq!((merits.average, merits.largest), (0.0, 0.0));
        assert_eq!(merits.rate([0.9, 0.1], 0.0), 0.9);
    }
}
