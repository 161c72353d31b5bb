//! Particle swarm with constant inertia.
//!
//! The basic method of Kennedy and Eberhart 1995, doi:10.1109/ICNN.1995.488968,
//! as Chen et al. 2023 (doi:10.3390/app131810482, eqs. 20-21) and Han et al.
//! 2022 (their "standard" one) use it. Chen's eq. 19 compares a fitness with a
//! position; the intended comparison of fitnesses is made here.

use super::entry::{OptimizerEntry, Parameter, iterations, population, real};
use super::swarm::{Schedule, Swarm, Weights};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "pso",
    title: "Particle swarm",
    description: "Particle swarm with constant inertia weight.",
    source: "Kennedy and Eberhart 1995, doi:10.1109/ICNN.1995.488968",
    parameters: PARAMETERS,
    build: |settings, _, seed| {
        let schedule = Constant { inertia: settings.get("inertia_weight") };
        Box::new(Swarm::new(schedule, settings, seed))
    },
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(100.0),
    real(
        "inertia_weight",
        "weight of the velocity before; 1 as in Chen et al. 2023",
        1.0,
        0.0,
        2.0,
    ),
    COGNITIVE,
    SOCIAL,
    MAX_VELOCITY,
];

/// Pull to a particle's own best.
pub const COGNITIVE: Parameter = real(
    "cognitive_coefficient",
    "pull to a particle's own best; 2 as in the papers",
    2.0,
    0.0,
    10.0,
);

/// Pull to the swarm's best.
pub const SOCIAL: Parameter =
    real("social_coefficient", "pull to the swarm's best; 2 as in the papers", 2.0, 0.0, 10.0);

/// Velocity bound.
pub const MAX_VELOCITY: Parameter = real(
    "max_velocity",
    "largest step per iteration as a share of the search range; 0.1 as in Han et al. 2022",
    0.1,
    1e-6,
    1.0,
);

struct Constant {
    inertia: f64,
}

impl Schedule for Constant {
    fn weights(&self, _: u64, _: u64) -> Weights {
        Weights { inertia: self.inertia, compression: 1.0 }
    }
}
