//! The particle swarm that `pso` and its relatives share.

use super::entry::Settings;
use super::{Evaluator, Optimizer, Step};
use crate::math::random::RandomStream;

/// How the swarm's momentum changes from iteration to iteration.
pub trait Schedule {
    /// Inertia weight `w` and the factor `phi` on the whole velocity, in
    /// iteration `k` of 1 to `iterations`.
    fn weights(&self, k: u64, iterations: u64) -> Weights;

    /// True if initial particles are first moved to feasible places.
    fn repairs_initial(&self) -> bool {
        false
    }
}

/// Factors of the velocity update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// On the velocity before.
    pub inertia: f64,
    /// On the sum of all three terms.
    pub compression: f64,
}

/// A particle swarm (Kennedy and Eberhart 1995, doi:10.1109/ICNN.1995.488968).
///
/// `v <- phi (w v + c1 r1 (p - x) + c2 r2 (g - x))`, clamped to a share of the
/// box, then `x <- x + v`, clamped to the box; a component that leaves the box
/// loses its velocity there. Fresh `r1`, `r2` per particle and component.
pub struct Swarm<S> {
    schedule: S,
    random: RandomStream,
    population: usize,
    iterations: u64,
    cognitive: f64,
    social: f64,
    velocity_share: f64,
    iteration: u64,
    pub(super) position: Vec<f64>,
    velocity: Vec<f64>,
    pub(super) fitness: Vec<f64>,
    pub(super) own_best: Vec<f64>,
    pub(super) own_fitness: Vec<f64>,
}

impl<S: Schedule> Swarm<S> {
    /// A swarm with the parameters every relative shares.
    pub fn new(schedule: S, settings: &Settings, seed: u64) -> Self {
        Self {
            schedule,
            random: RandomStream::new(seed, 0),
            population: settings.integer("population") as usize,
            iterations: settings.integer("iterations"),
            cognitive: settings.get("cognitive_coefficient"),
            social: settings.get("social_coefficient"),
            velocity_share: settings.get("max_velocity"),
            iteration: 0,
            position: Vec::new(),
            velocity: Vec::new(),
            fitness: Vec::new(),
            own_best: Vec::new(),
            own_fitness: Vec::new(),
        }
    }

    fn initialize(&mut self, evaluator: &mut Evaluator<'_>) {
        let bounds = evaluator.bounds();
        let dimension = bounds.dimension();
        self.position.reserve(self.population * dimension);
        for _ in 0..self.population {
            for (&lower, &upper) in bounds.lower.iter().zip(&bounds.upper) {
                self.position.push(self.random.uniform(lower, upper));
            }
        }
        if self.schedule.repairs_initial() {
            for particle in self.position.chunks_exact_mut(dimension) {
                if evaluator.stop_reason().is_some() {
                    break;
                }
                evaluator.repair(particle);
            }
        }
        self.velocity = vec![0.0; self.position.len()];
        self.own_best = self.position.clone();
        self.fitness = vec![f64::INFINITY; self.population];
        self.own_fitness = self.fitness.clone();
    }

    /// Draws all particles anew: without a feasible one yet nothing pulls
    /// them, and they would stand still for ever.
    fn scatter(&mut self, evaluator: &Evaluator<'_>) {
        let bounds = evaluator.bounds();
        for particle in self.position.chunks_exact_mut(bounds.dimension()) {
            for (x, (&lower, &upper)) in
                particle.iter_mut().zip(bounds.lower.iter().zip(&bounds.upper))
            {
                *x = self.random.uniform(lower, upper);
            }
        }
        self.own_best.copy_from_slice(&self.position);
    }

    fn fly(&mut self, evaluator: &Evaluator<'_>) {
        let bounds = evaluator.bounds();
        let dimension = bounds.dimension();
        let Weights { inertia: w, compression: phi } =
            self.schedule.weights(self.iteration, self.iterations);
        let (c1, c2) = (self.cognitive, self.social);
        let best = evaluator.best_position();
        for particle in 0..self.population {
            for (d, g) in best.iter().enumerate() {
                let index = particle * dimension + d;
                let (lower, upper) = (bounds.lower[d], bounds.upper[d]);
                let fastest = self.velocity_share * (upper - lower);
                let x = self.position[index];
                let (r1, r2) = (self.random.unit(), self.random.unit());
                let pull = c1 * r1 * (self.own_best[index] - x) + c2 * r2 * (g - x);
                let v = (phi * (w * self.velocity[index] + pull)).clamp(-fastest, fastest);
                let moved = x + v;
                self.position[index] = moved.clamp(lower, upper);
                let left = moved < lower || moved > upper;
                self.velocity[index] = if left { 0.0 } else { v };
            }
        }
    }

    fn remember(&mut self, dimension: usize) {
        for particle in 0..self.population {
            if self.fitness[particle] < self.own_fitness[particle] {
                self.own_fitness[particle] = self.fitness[particle];
                let place = particle * dimension..(particle + 1) * dimension;
                self.own_best[place.clone()].copy_from_slice(&self.position[place]);
            }
        }
    }
}

impl<S: Schedule> Optimizer for Swarm<S> {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        if self.position.is_empty() {
            self.initialize(evaluator);
        } else {
            self.iteration += 1;
            if evaluator.best_position().is_empty() {
                self.scatter(evaluator);
            } else {
                self.fly(evaluator);
            }
        }
        evaluator.population(&self.position, &mut self.fitness);
        self.remember(evaluator.bounds().dimension());
        Step { mean: mean(&self.fitness), converged: false }
    }
}

/// Mean of the finite values, if there are any.
pub(super) fn mean(fitness: &[f64]) -> Option<f64> {
    let feasible = fitness.iter().filter(|value| value.is_finite());
    let (count, sum) = feasible.fold((0u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}
