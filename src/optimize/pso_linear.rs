//! Particle swarm with linearly decreasing inertia.
//!
//! Shi and Eberhart 1998, doi:10.1109/ICEC.1998.699146; the baseline of Shu et
//! al. (their eq. 13): `w(k) = w_max - (w_max - w_min) k / G`.

use super::entry::{OptimizerEntry, Parameter, Settings, iterations, population, real};
use super::pso::{COGNITIVE, MAX_VELOCITY, SOCIAL};
use super::swarm::{Schedule, Swarm, Weights};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "pso_linear",
    title: "Particle swarm with decreasing inertia",
    description: "Particle swarm whose inertia weight falls linearly: wide search first, fine search last.",
    source: "Shi and Eberhart 1998, doi:10.1109/ICEC.1998.699146",
    parameters: PARAMETERS,
    build: |settings, _, seed| Box::new(Swarm::new(Linear::new(settings), settings, seed)),
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(100.0),
    INERTIA_FIRST,
    INERTIA_LAST,
    COGNITIVE,
    SOCIAL,
    MAX_VELOCITY,
];

/// Inertia weight at the start.
pub const INERTIA_FIRST: Parameter =
    real("inertia_first", "inertia weight at the start; 0.9 as in Shu et al.", 0.9, 0.0, 2.0);

/// Inertia weight at the end.
pub const INERTIA_LAST: Parameter =
    real("inertia_last", "inertia weight at the end; 0.4 as in Shu et al.", 0.4, 0.0, 2.0);

/// Inertia that falls linearly with the iterations.
pub struct Linear {
    first: f64,
    last: f64,
}

impl Linear {
    /// Between [`INERTIA_FIRST`] and [`INERTIA_LAST`].
    pub fn new(settings: &Settings) -> Self {
        Self { first: settings.get("inertia_first"), last: settings.get("inertia_last") }
    }
}

impl Schedule for Linear {
    fn weights(&self, k: u64, iterations: u64) -> Weights {
        let done = k as f64 / iterations.max(1) as f64;
        Weights { inertia: self.first - (self.first - self.last) * done, compression: 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertia_falls_from_first_to_last() {
        let schedule = Linear { first: 0.9, last: 0.4 };
        assert_eq!(schedule.weights(0, 15).inertia, 0.9);
        assert!((schedule.weights(15, 15).inertia - 0.4).abs() < 1e-15);
    }
}
