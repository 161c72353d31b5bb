//! Candidates that remember the best place each has been to.

use super::{Evaluator, Step};
use crate::math::random::RandomStream;

/// The particles of a swarm; component `d` of particle `i` at `[i * dimension + d]`.
#[derive(Default)]
pub struct Particles {
    /// Where they are.
    pub position: Vec<f64>,
    /// Fitness there.
    pub fitness: Vec<f64>,
    /// Each one's best place so far; where it is while it has been to no feasible one.
    pub own_best: Vec<f64>,
    /// Fitness there.
    pub own_fitness: Vec<f64>,
}

impl Particles {
    /// Particles that have been nowhere yet.
    pub fn new(population: usize, dimension: usize) -> Self {
        Self {
            position: vec![0.0; population * dimension],
            fitness: vec![f64::INFINITY; population],
            own_best: vec![0.0; population * dimension],
            own_fitness: vec![f64::INFINITY; population],
        }
    }

    /// True before the initial generation.
    pub fn is_empty(&self) -> bool {
        self.fitness.is_empty()
    }

    /// Puts all particles at random places, which they remember.
    ///
    /// Serves the start, and again every generation without a feasible
    /// particle yet: nothing pulls them then, and they would stand still.
    pub fn scatter(&mut self, evaluator: &Evaluator<'_>, random: &mut RandomStream) {
        evaluator.bounds().scatter(&mut self.position, random);
        self.own_best.copy_from_slice(&self.position);
    }

    /// Evaluates all and lets each remember a better place.
    pub fn evaluate(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        evaluator.population(&self.position, &mut self.fitness);
        let dimension = evaluator.bounds().dimension();
        let places = self.position.chunks_exact(dimension);
        let bests = self.own_best.chunks_exact_mut(dimension).zip(&mut self.own_fitness);
        for ((place, fitness), (best, own)) in places.zip(&self.fitness).zip(bests) {
            if fitness < own {
                *own = *fitness;
                best.copy_from_slice(place);
            }
        }
        Step { mean: mean(&self.fitness), converged: false }
    }
}

/// Mean of the finite values, if there are any.
pub fn mean(fitness: &[f64]) -> Option<f64> {
    let feasible = fitness.iter().filter(|value| value.is_finite());
    let (count, sum) = feasible.fold((0u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}
