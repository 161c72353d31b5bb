//! Dual-optimisation particle swarm of Shu et al.
//!
//! A swarm with linearly decreasing inertia (their eqs. 12-13) and, from the
//! first iteration after the initial one, a second search over single
//! components: for every particle the row `min(p, x)`, per component the smaller of
//! the particle's own best before the iteration and its new position, i.e. the
//! shortest duration seen for each segment. A feasible row that is better takes the
//! place of the particle's own best, and so may lead the swarm.
//!
//! The paper's equations are lost; this is reconstructed from its text. Readings:
//! "previous generation" is the own best, or with `h2_from_position` the
//! position before; a row that equals one of its parents is known already and
//! not evaluated again; a row counts as better by its fitness, which for
//! durations within the limits is what "shorter in every segment" comes to.
//! Infeasible is what has an infinite fitness (`constraint_handling: reject`).
//! Initial velocities are zero, as in `pso_linear`; the paper draws them.
//!
//! Under the same seed and parameters the best is never worse than that of
//! `pso_linear` up to the first iteration, where both have seen the same
//! particles. From then on another best leads the swarm other ways, mostly
//! better ones, but no law says so. On substitutes for Shu's lost nodes (22 moving joints,
//! 30 seeds) it ended shorter in 604 of 660 searches of as many iterations and
//! longer in 56. That took 1.4 times the evaluations; given about as many,
//! `pso_linear` still ended longer in 448.

use super::entry::{OptimizerEntry, Parameter, Settings, flag, iterations, population};
use super::pso::{COGNITIVE, MAX_VELOCITY, SOCIAL};
use super::pso_linear::{INERTIA_FIRST, INERTIA_LAST, Linear};
use super::swarm::Swarm;
use super::{Evaluator, Objective, Optimizer, Step};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "dual_pso",
    title: "Dual-optimisation particle swarm of Shu et al.",
    description: "Particle swarm with decreasing inertia and a second search that joins the \
                  shortest durations seen for every segment. The paper drops infeasible \
                  candidates: constraint_handling reject, h2_repair false.",
    source: "Shu, Ge, Wu, Chen and Zhang, Wenzhou University, undated; equations reconstructed",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(DualSwarm::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(15.0),
    INERTIA_FIRST,
    INERTIA_LAST,
    Parameter {
        description: "pull to a particle's own best; 1.96 as in Shu et al.",
        default: Some(1.96),
        ..COGNITIVE
    },
    Parameter {
        description: "pull to the swarm's best; 1.96 as in Shu et al.",
        default: Some(1.96),
        ..SOCIAL
    },
    MAX_VELOCITY,
    flag(
        "h2_repair",
        "repair infeasible rows of the second search and try them again instead of \
                      dropping them as the paper does; default true, because a row of minima is \
                      seldom feasible",
        true,
    ),
    flag(
        "h2_from_position",
        "form the second search's rows from a particle's position before the \
                      iteration instead of its own best; default false",
        false,
    ),
];

struct DualSwarm {
    swarm: Swarm<Linear>,
    repairs: bool,
    from_position: bool,
    /// Of every particle before the iteration; empty before the first.
    parents: Vec<f64>,
    parents_fitness: Vec<f64>,
    /// Rows of the second search that are not known already.
    rows: Rows,
}

/// Candidates that particles may adopt.
#[derive(Default)]
struct Rows {
    position: Vec<f64>,
    /// The particle each belongs to.
    particle: Vec<usize>,
    fitness: Vec<f64>,
}

impl DualSwarm {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        Self {
            swarm: Swarm::new(Linear::new(settings), settings, seed),
            repairs: settings.flag("h2_repair"),
            from_position: settings.flag("h2_from_position"),
            parents: Vec::new(),
            parents_fitness: Vec::new(),
            rows: Rows {
                position: Vec::with_capacity(population * objective.bounds().dimension()),
                particle: Vec::with_capacity(population),
                fitness: Vec::with_capacity(population),
            },
        }
    }

    fn keep_parents(&mut self) {
        let swarm = &self.swarm;
        let (position, fitness) = if self.from_position {
            (&swarm.particles.position, &swarm.particles.fitness)
        } else {
            (&swarm.particles.own_best, &swarm.particles.own_fitness)
        };
        self.parents.clone_from(position);
        self.parents_fitness.clone_from(fitness);
    }

    /// Evaluates the rows; particles adopt what is better than their own best.
    fn try_rows(&mut self, evaluator: &mut Evaluator<'_>) {
        let dimension = evaluator.bounds().dimension();
        let Rows { position, particle, fitness } = &mut self.rows;
        fitness.resize(particle.len(), f64::INFINITY);
        evaluator.population(position, fitness);
        for ((row, &particle), &fitness) in
            position.chunks_exact(dimension).zip(&*particle).zip(&*fitness)
        {
            if fitness < self.swarm.particles.own_fitness[particle] {
                self.swarm.particles.own_fitness[particle] = fitness;
                let own = particle * dimension..(particle + 1) * dimension;
                self.swarm.particles.own_best[own].copy_from_slice(row);
            }
        }
    }

    /// Repairs the infeasible rows and drops all others; false if the search
    /// has to end.
    fn repair_rows(&mut self, evaluator: &mut Evaluator<'_>) -> bool {
        self.rows.keep_infeasible(evaluator.bounds().dimension());
        for row in self.rows.position.chunks_exact_mut(evaluator.bounds().dimension()) {
            if evaluator.stop_reason().is_some() {
                return false;
            }
            evaluator.repair(row);
        }
        true
    }
}

impl Rows {
    /// Per component the smaller of a particle's parent and its new position,
    /// where both are feasible and neither is smaller throughout.
    fn form(&mut self, parents: (&[f64], &[f64]), new: (&[f64], &[f64]), dimension: usize) {
        self.position.clear();
        self.particle.clear();
        let parents = parents.0.chunks_exact(dimension).zip(parents.1);
        let new = new.0.chunks_exact(dimension).zip(new.1);
        for (particle, ((parent, parent_fitness), (x, fitness))) in parents.zip(new).enumerate() {
            if !parent_fitness.is_finite() || !fitness.is_finite() {
                continue;
            }
            let start = self.position.len();
            self.position.extend(parent.iter().zip(x).map(|(parent, x)| parent.min(*x)));
            let row = &self.position[start..];
            if row == parent || row == x {
                self.position.truncate(start);
            } else {
                self.particle.push(particle);
            }
        }
    }

    fn keep_infeasible(&mut self, dimension: usize) {
        let mut kept = 0;
        for row in 0..self.particle.len() {
            if self.fitness[row] == f64::INFINITY {
                self.position.copy_within(row * dimension..(row + 1) * dimension, kept * dimension);
                self.particle[kept] = self.particle[row];
                kept += 1;
            }
        }
        self.position.truncate(kept * dimension);
        self.particle.truncate(kept);
        self.fitness.truncate(kept);
    }
}

impl Optimizer for DualSwarm {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        self.keep_parents();
        let step = self.swarm.step(evaluator);
        let (parents, new) = (
            (self.parents.as_slice(), self.parents_fitness.as_slice()),
            (self.swarm.particles.position.as_slice(), self.swarm.particles.fitness.as_slice()),
        );
        self.rows.form(parents, new, evaluator.bounds().dimension());
        self.try_rows(evaluator);
        if self.repairs && self.repair_rows(evaluator) {
            self.try_rows(evaluator);
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::INFINITY;

    /// Five particles with two segments, worked out by hand.
    #[test]
    fn rows_hold_the_shortest_durations_seen() {
        let mut rows = Rows::default();
        let parents = [1.0, 4.0, 2.0, 2.0, 3.0, 1.0, 1.0, 5.0, 2.0, 2.0];
        let new = [2.0, 3.0, 3.0, 1.0, 2.0, 1.0, 2.0, 2.0, 1.0, 1.5];
        let fitness = [5.0, 4.0, 4.0, NONE, 4.0];
        let new_fitness = [5.0, NONE, 3.0, 4.0, 2.5];
        rows.form((&parents, &fitness), (&new, &new_fitness), 2);
        // Particle 0 mixes; 1 and 3 have an infeasible parent; 2 and 4 only improved.
        assert_eq!(
            (rows.position.as_slice(), rows.particle.as_slice()),
            (&[1.0, 3.0][..], &[0][..])
        );
    }

    #[test]
    fn only_infeasible_rows_are_left_to_repair() {
        let mut rows = Rows {
            position: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            particle: vec![0, 3, 4],
            fitness: vec![NONE, 7.0, NONE],
        };
        rows.keep_infeasible(2);
        assert_eq!(rows.position, [1.0, 2.0, 5.0, 6.0]);
        assert_eq!((rows.particle.as_slice(), rows.fitness.len()), (&[0, 4][..], 2));
    }
}
