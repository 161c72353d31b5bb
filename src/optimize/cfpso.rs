//! Particle swarm with constriction factor (CFPSO).
//!
//! Clerc and Kennedy 2002, doi:10.1109/4235.985692:
//! `v <- chi (v + c1 r1 (p - x) + c2 r2 (g - x))` with
//! `chi = 2 / |2 - phi - sqrt(phi^2 - 4 phi)|` and `phi = c1 + c2 > 4`. The factor makes the
//! swarm converge without a bound on the velocity; the bound is the whole search range here.

use super::entry::{OptimizerEntry, Parameter, iterations, population, real};
use super::pso::MAX_VELOCITY;
use super::swarm::{Schedule, Swarm, Weights};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "cfpso",
    title: "Particle swarm with constriction factor",
    description: "Particle swarm whose whole velocity is multiplied by a factor that makes it \
                  converge.",
    source: "Clerc and Kennedy 2002, doi:10.1109/4235.985692",
    parameters: PARAMETERS,
    build: |settings, _, seed| {
        let phi = settings.get("cognitive_coefficient") + settings.get("social_coefficient");
        Box::new(Swarm::new(Constricted { chi: constriction(phi) }, settings, seed))
    },
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(100.0),
    real(
        "cognitive_coefficient",
        "pull to a particle's own best; 2.05 as in Clerc and Kennedy",
        2.05,
        2.0,
        10.0,
    ),
    real(
        "social_coefficient",
        "pull to the swarm's best; 2.05 as in Clerc and Kennedy",
        2.05,
        2.0,
        10.0,
    ),
    Parameter {
        description: "largest step per iteration as a share of the search range; 1: the factor does the work",
        default: Some(1.0),
        ..MAX_VELOCITY
    },
];

/// The constriction factor for `phi = c1 + c2`; 1 at its lower end, 4.
fn constriction(phi: f64) -> f64 {
    2.0 / (2.0 - phi - (phi * phi - 4.0 * phi).max(0.0).sqrt()).abs()
}

struct Constricted {
    chi: f64,
}

impl Schedule for Constricted {
    fn weights(&self, _: u64, _: u64) -> Weights {
        Weights { inertia: 1.0, compression: self.chi }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value everybody quotes for 2.05 + 2.05.
    #[test]
    fn the_factor_for_4_1_is_0_7298() {
        assert!((constriction(4.1) - 0.729_843_788).abs() < 1e-9);
        assert_eq!(constriction(4.0), 1.0);
    }
}
