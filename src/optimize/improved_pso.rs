//! Improved particle swarm of Han et al. 2022, doi:10.3390/a15080269, eqs. 9-17.
//!
//! Three things are added to the basic swarm: initial particles are moved to
//! feasible places ("first optimisation"), the whole velocity is compressed by
//! a factor that falls from 1 to `1/mu` (eq. 17), and the fitness of a particle
//! over a limit is that of its repaired durations (eqs. 12-15, the "fitness
//! switch"). The last belongs to the problem: `constraint_handling:
//! repair_segment` is the paper's, `repair_uniform` its exact successor.
//!
//! Readings: eq. 17's outer exponent takes the whole bracket,
//! `phi_k = mu^(e^((1-k)/(G+1-k)) - 1)`, because the other one starts at 7; `e`
//! is 10 as printed, Euler's number being an option; the search range excludes
//! 0, where the curve is undefined.

use super::entry::{OptimizerEntry, Parameter, iterations, population, real};
use super::pso::{COGNITIVE, MAX_VELOCITY, SOCIAL};
use super::swarm::{Schedule, Swarm, Weights};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "improved_pso",
    title: "Improved particle swarm of Han et al.",
    description: "Particle swarm with feasible initial particles and an adaptive compression \
                  factor. The paper's fitness switch is constraint_handling: repair_segment.",
    source: "Han et al. 2022, doi:10.3390/a15080269, eqs. 9-17",
    parameters: PARAMETERS,
    build: |settings, _, seed| {
        let schedule = Compressed {
            inertia: settings.get("inertia_weight"),
            mu: settings.get("compression_base"),
            e: settings.get("compression_exponent_base"),
        };
        Box::new(Swarm::new(schedule, settings, seed))
    },
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(100.0),
    real("inertia_weight", "weight of the velocity before; 0.5 as in the paper", 0.5, 0.0, 2.0),
    COGNITIVE,
    SOCIAL,
    MAX_VELOCITY,
    real("compression_base", "mu in eq. 17; 8 as in the paper", 8.0, 1.0, 1000.0),
    real(
        "compression_exponent_base",
        "e in eq. 17; 10 as printed, 2.718281828 compresses more slowly",
        10.0,
        1.0,
        1000.0,
    ),
];

struct Compressed {
    inertia: f64,
    mu: f64,
    e: f64,
}

impl Schedule for Compressed {
    fn weights(&self, k: u64, iterations: u64) -> Weights {
        // Eq. (17), k = 1..G.
        let k = k.clamp(1, iterations.max(1)) as f64;
        let g = iterations.max(1) as f64;
        let exponent = libm::pow(self.e, (1.0 - k) / (g + 1.0 - k)) - 1.0;
        Weights { inertia: self.inertia, compression: libm::pow(self.mu, exponent) }
    }

    fn repairs_initial(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values computed independently for mu = 8, G = 100.
    #[test]
    fn compression_follows_equation_17() {
        let printed = [(1, 1.000), (2, 0.953), (10, 0.655), (20, 0.420), (50, 0.157), (100, 0.125)];
        let euler = [(1, 1.000), (2, 0.979), (10, 0.822), (20, 0.647), (50, 0.277), (100, 0.125)];
        for (e, table) in [(10.0, printed), (std::f64::consts::E, euler)] {
            let schedule = Compressed { inertia: 0.5, mu: 8.0, e };
            for (k, expected) in table {
                let found = schedule.weights(k, 100).compression;
                assert!((found - expected).abs() < 6e-4, "e {e}, k {k}: {found}");
            }
        }
    }
}
