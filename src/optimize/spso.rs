//! Simplified particle swarm (SPSO): without velocity.
//!
//! Hu and Li 2007, doi:10.1360/jos180861, as Chen et al. 2023 (doi:10.3390/app131810482,
//! eq. 22) use it: `x <- w x + c1 r1 (p - x) + c2 r2 (g - x)`, clamped to the box, with fresh
//! `r1`, `r2` per particle and component and `w` falling linearly (Chen prints no range).
//!
//! Deviation, of rounding alone: the swarm's common step moves a particle by
//! `(w - 1) x + c1 r1 (p - x) + c2 r2 (g - x)`, which is added to `x`.
//!
//! Mind: `w x` draws every particle to the origin, whatever is minimised. That flatters the
//! method where the optimum lies there and harms it elsewhere.

use super::entry::{OptimizerEntry, Parameter, SHIFT, iterations, population};
use super::pso::{COGNITIVE, SOCIAL};
use super::pso_linear::{INERTIA_FIRST, INERTIA_LAST, Linear};
use super::swarm::{Momentum, Schedule, Swarm, Weights};

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "spso",
    title: "Simplified particle swarm",
    description: "Particle swarm without velocity. Draws particles to the origin, whatever is \
                  minimised: see shift.",
    source: "Hu and Li 2007, doi:10.1360/jos180861; Chen et al. 2023, doi:10.3390/app131810482, \
             eq. 22",
    parameters: PARAMETERS,
    build: |settings, _, seed| {
        let shift = settings.flag("shift");
        let schedule = WithoutVelocity { inertia: Linear::new(settings), shift };
        Box::new(Swarm::new(schedule, settings, seed))
    },
};

const PARAMETERS: &[Parameter] =
    &[population(50.0), iterations(100.0), INERTIA_FIRST, INERTIA_LAST, COGNITIVE, SOCIAL, SHIFT];

struct WithoutVelocity {
    inertia: Linear,
    shift: bool,
}

impl Schedule for WithoutVelocity {
    fn weights(&self, k: u64, iterations: u64) -> Weights {
        self.inertia.weights(k, iterations)
    }

    fn momentum(&self) -> Momentum {
        if self.shift { Momentum::ShiftedPosition } else { Momentum::Position }
    }
}
