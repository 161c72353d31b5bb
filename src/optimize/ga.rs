//! Real-coded genetic algorithm.
//!
//! The textbook method; Han et al. 2022 and Lin and Yang compare with one and
//! give no details of it. The best individuals live on unchanged and are not
//! evaluated again; pairs of selected parents make the others by crossover and
//! mutation. While no individual was feasible all are drawn anew, because
//! selection has nothing to choose from.

use std::cmp::Ordering;

use super::entry::{
    OptimizerEntry, Parameter, ParameterKind, Settings, flag, iterations, population, real,
};
use super::genetic::{Roulette, blend, cross, index, mutate};
use super::particles::mean;
use super::{Bounds, Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "ga",
    title: "Genetic algorithm",
    description: "Real-coded genetic algorithm: tournament or roulette selection, single-point or \
                  arithmetic crossover, single-point mutation, elitism.",
    source: "textbook method, as in Goldberg 1989, ISBN 0-201-15767-5",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(Genetic::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    // One more than the elite can be, so that every generation has children.
    Parameter { min: 4.0, ..population(100.0) },
    iterations(100.0),
    Parameter {
        name: "elite",
        description: "best individuals that live on unchanged; 1 or 2 are usual",
        kind: ParameterKind::Integer,
        default: Some(2.0),
        min: 0.0,
        max: 3.0,
    },
    Parameter {
        name: "tournament",
        description: "individuals drawn, of which the best becomes a parent; 2 is usual",
        kind: ParameterKind::Integer,
        default: Some(2.0),
        min: 1.0,
        max: 100.0,
    },
    flag(
        "roulette",
        "select parents in proportion to 1 / (1 + f - f_min) instead of by \
                      tournament; default false",
        false,
    ),
    flag(
        "blend",
        "cross by moving both parents towards each other by a random share instead \
                      of at a single point; default false",
        false,
    ),
    real("crossover_rate", "share of pairs that are crossed; 0.8 is usual", 0.8, 0.0, 1.0),
    real(
        "mutation_rate",
        "share of children of which one gene is drawn anew; 0.05 is usual",
        0.05,
        0.0,
        1.0,
    ),
];

struct Genetic {
    random: RandomStream,
    population: usize,
    elite: usize,
    tournament: usize,
    roulette: bool,
    blend: bool,
    crossover_rate: f64,
    mutation_rate: f64,
    /// Individuals one after the other, and room for one more: the second
    /// child of the last pair may be one too many.
    position: Vec<f64>,
    next: Vec<f64>,
    fitness: Vec<f64>,
    next_fitness: Vec<f64>,
    /// Individuals; the elite come first once they are looked for.
    order: Vec<usize>,
    wheel: Roulette,
}

impl Genetic {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        let room = (population + 1) * objective.bounds().dimension();
        Self {
            random: RandomStream::new(seed, 0),
            population,
            elite: settings.integer("elite") as usize,
            tournament: settings.integer("tournament") as usize,
            roulette: settings.flag("roulette"),
            blend: settings.flag("blend"),
            crossover_rate: settings.get("crossover_rate"),
            mutation_rate: settings.get("mutation_rate"),
            position: vec![0.0; room],
            next: vec![0.0; room],
            fitness: vec![f64::INFINITY; population],
            next_fitness: vec![f64::INFINITY; population],
            order: (0..population).collect(),
            wheel: Roulette::with_capacity(population),
        }
    }

    /// Puts the next generation in the place of this one.
    fn breed(&mut self, bounds: &Bounds) {
        self.keep_elite(bounds.dimension());
        if self.roulette {
            let best = self.fitness.iter().copied().fold(f64::INFINITY, f64::min);
            self.wheel.set(self.fitness.iter().map(|&fitness| merit(fitness, best)));
        }
        for child in (self.elite..self.population).step_by(2) {
            let parents = [self.select(), self.select()];
            self.mate(parents, child, bounds);
        }
        std::mem::swap(&mut self.position, &mut self.next);
        std::mem::swap(&mut self.fitness, &mut self.next_fitness);
    }

    fn keep_elite(&mut self, dimension: usize) {
        if self.elite == 0 {
            return;
        }
        let fitness = &self.fitness;
        let by_fitness = |a: &usize, b: &usize| -> Ordering {
            fitness[*a].total_cmp(&fitness[*b]).then(a.cmp(b))
        };
        self.order.select_nth_unstable_by(self.elite - 1, by_fitness);
        self.order[..self.elite].sort_unstable_by(by_fitness);
        for (place, &best) in self.order[..self.elite].iter().enumerate() {
            self.next_fitness[place] = self.fitness[best];
            let best = &self.position[best * dimension..(best + 1) * dimension];
            self.next[place * dimension..(place + 1) * dimension].copy_from_slice(best);
        }
    }

    fn select(&mut self) -> usize {
        if self.roulette {
            return self.wheel.spin(&mut self.random);
        }
        let mut winner = index(self.population, &mut self.random);
        for _ in 1..self.tournament {
            let rival = index(self.population, &mut self.random);
            if self.fitness[rival] < self.fitness[winner] {
                winner = rival;
            }
        }
        winner
    }

    /// Makes children `child` and `child + 1`.
    fn mate(&mut self, parents: [usize; 2], child: usize, bounds: &Bounds) {
        let dimension = bounds.dimension();
        let children = &mut self.next[child * dimension..(child + 2) * dimension];
        for (parent, child) in parents.into_iter().zip(children.chunks_exact_mut(dimension)) {
            child.copy_from_slice(&self.position[parent * dimension..(parent + 1) * dimension]);
        }
        let random = &mut self.random;
        let (first, second) = children.split_at_mut(dimension);
        if random.unit() < self.crossover_rate {
            if self.blend {
                blend(first, second, random);
            } else {
                cross(first, second, random);
            }
        }
        for child in [first, second] {
            if random.unit() < self.mutation_rate {
                mutate(child, bounds, random);
            }
        }
    }
}

/// Weight on the wheel: `1 / (1 + f - f_min)`, nothing for the infeasible.
fn merit(fitness: f64, best: f64) -> f64 {
    if fitness.is_finite() { 1.0 / (1.0 + (fitness - best)) } else { 0.0 }
}

impl Optimizer for Genetic {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        let bounds = evaluator.bounds();
        let end = self.population * bounds.dimension();
        let kept = if evaluator.best_position().is_empty() {
            bounds.scatter(&mut self.position[..end], &mut self.random);
            0
        } else {
            self.breed(bounds);
            self.elite
        };
        let new = &self.position[kept * bounds.dimension()..end];
        evaluator.population(new, &mut self.fitness[kept..]);
        Step { mean: mean(&self.fitness), converged: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merit_is_one_for_the_best_and_nothing_for_the_infeasible() {
        assert_eq!(merit(3.0, 3.0), 1.0);
        assert_eq!(merit(6.0, 3.0), 0.25);
        assert_eq!(merit(-1.0, -2.0), 0.5);
        assert_eq!(merit(f64::INFINITY, 3.0), 0.0);
        assert_eq!(merit(f64::INFINITY, f64::INFINITY), 0.0);
    }
}
