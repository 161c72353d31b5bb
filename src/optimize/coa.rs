//! Chaos optimisation with two carrier waves.
//!
//! Li and Jiang 1997 and Lu et al. 2006, doi:10.1631/jzus.2006.A0539. Each
//! variable follows an orbit of the logistic map `z <- 4 z (1 - z)` of its own.
//! The first wave carries the orbit over the whole box until the best has not
//! improved for `M1` points, the second over a neighbourhood of the best that
//! shrinks with every `M2` points that brought nothing.
//!
//! Readings: a generation is `population` points, Han et al.'s "optimisation
//! space" of 100 or 200, which their paper does not explain; the second wave
//! moves its centre between generations, so that all points of one can be
//! evaluated side by side. `M1`, `M2` and the neighbourhood are not printed.
//! In double precision an orbit can reach a point it never leaves; then it is
//! started anew.

use super::entry::{
    OptimizerEntry, Parameter, ParameterKind, Settings, iterations, population, real,
};
use super::swarm::mean;
use super::{Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "coa",
    title: "Chaos optimisation",
    description: "Chaotic orbits search the whole box, then a shrinking neighbourhood of the best. \
                  Ends by itself once the neighbourhood is small enough.",
    source: "Li and Jiang 1997; Lu et al. 2006, doi:10.1631/jzus.2006.A0539",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(Chaos::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    Parameter {
        description: "points of the orbit per generation; 100 as the \"optimisation space\" of \
                      Han et al. 2022",
        ..population(100.0)
    },
    iterations(200.0),
    Parameter {
        name: "first_wave_patience",
        description: "M1, points without improvement that end the first wave; not printed, 1000 \
                      is our choice",
        kind: ParameterKind::Integer,
        default: Some(1000.0),
        min: 1.0,
        max: 1e9,
    },
    Parameter {
        name: "second_wave_patience",
        description: "M2, points without improvement after which the neighbourhood shrinks; not \
                      printed, 100 is our choice",
        kind: ParameterKind::Integer,
        default: Some(100.0),
        min: 1.0,
        max: 1e9,
    },
    real(
        "alpha",
        "width of the first neighbourhood as a share of the search range; not printed, 0.1 is \
         our choice",
        0.1,
        1e-12,
        1.0,
    ),
    real(
        "alpha_min",
        "the search ends below this width, as a share of the search range; not printed, 1e-4 is \
         our choice",
        1e-4,
        1e-15,
        1.0,
    ),
    real(
        "alpha_shrink",
        "factor on the width; not printed, 0.95 is our choice",
        0.95,
        0.01,
        0.999_999,
    ),
];

/// Points this near the ends of (0, 1) count as having reached them.
const END: f64 = 1e-9;

struct Chaos {
    random: RandomStream,
    patience: [u64; 2],
    first_alpha: f64,
    least_alpha: f64,
    shrink: f64,
    /// Width of the second wave; none during the first.
    alpha: Option<f64>,
    /// Points since the best improved or the wave changed.
    since: u64,
    /// The chaotic variables.
    z: Vec<f64>,
    position: Vec<f64>,
    fitness: Vec<f64>,
}

impl Chaos {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        let dimension = objective.bounds().dimension();
        let mut random = RandomStream::new(seed, 0);
        Self {
            z: (0..dimension).map(|_| start(&mut random)).collect(),
            random,
            patience: ["first_wave_patience", "second_wave_patience"]
                .map(|name| settings.integer(name)),
            first_alpha: settings.get("alpha"),
            least_alpha: settings.get("alpha_min"),
            shrink: settings.get("alpha_shrink"),
            alpha: None,
            since: 0,
            position: vec![0.0; population * dimension],
            fitness: vec![f64::INFINITY; population],
        }
    }

    /// Carries the orbits' next points into the box.
    fn carry(&mut self, evaluator: &Evaluator<'_>) {
        let bounds = evaluator.bounds();
        let centre = evaluator.best_position();
        for point in self.position.chunks_exact_mut(bounds.dimension()) {
            for (d, x) in point.iter_mut().enumerate() {
                let (lower, upper) = (bounds.lower[d], bounds.upper[d]);
                let width = upper - lower;
                let z = self.z[d];
                *x = match self.alpha {
                    None => lower + z * width,
                    Some(alpha) => (centre[d] + alpha * (z - 0.5) * width).clamp(lower, upper),
                };
                self.z[d] = next(z, &mut self.random);
            }
        }
    }

    /// Counts points without improvement and acts when they are too many.
    fn judge(&mut self, mut best: f64) {
        for &fitness in &self.fitness {
            self.since += 1;
            if fitness < best {
                best = fitness;
                self.since = 0;
            }
        }
        let [first, second] = self.patience;
        match &mut self.alpha {
            // Without a feasible point there is no neighbourhood to search.
            None if self.since >= first && best < f64::INFINITY => {
                self.alpha = Some(self.first_alpha);
                self.since = 0;
            }
            None => {}
            Some(alpha) => {
                while self.since >= second {
                    *alpha *= self.shrink;
                    self.since -= second;
                }
            }
        }
    }
}

impl Optimizer for Chaos {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        let best = evaluator.best();
        self.carry(evaluator);
        evaluator.population(&self.position, &mut self.fitness);
        self.judge(best);
        let converged = self.alpha.is_some_and(|alpha| alpha < self.least_alpha);
        Step { mean: mean(&self.fitness), converged }
    }
}

/// A random start from which an orbit does not soon stand still.
fn start(random: &mut RandomStream) -> f64 {
    loop {
        let z = random.unit();
        if wanders(z) {
            return z;
        }
    }
}

/// The orbit's next point; a new start where it would stand still.
fn next(z: f64, random: &mut RandomStream) -> f64 {
    let next = 4.0 * z * (1.0 - z);
    if wanders(next) { next } else { start(random) }
}

/// False for 0, 1 and what leads there at once, and for the fixed point 3/4
/// and what leads there.
fn wanders(z: f64) -> bool {
    (END..=1.0 - END).contains(&z) && z != 0.25 && z != 0.5 && z != 0.75
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orbit_that_would_stand_still_starts_anew() {
        let mut random = RandomStream::new(1, 0);
        // 1/2 leads to 1 and then 0, 1/4 and 3/4 to 3/4 for ever; 0.146... leads to 1/2.
        let half = (2.0 - 2.0f64.sqrt()) / 4.0;
        for z in [0.0, 1.0, 1e-10, 1.0 - 1e-10, 0.25, 0.5, 0.75, half] {
            let mut orbit = z;
            let mut seen = std::collections::BTreeSet::new();
            for _ in 0..1000 {
                orbit = next(orbit, &mut random);
                assert!(wanders(orbit), "{z}: {orbit}");
                seen.insert(orbit.to_bits());
            }
            assert!(seen.len() > 990, "{z}: {} points", seen.len());
        }
    }

    #[test]
    fn the_map_is_the_logistic_one() {
        let mut random = RandomStream::new(1, 0);
        assert!((next(0.3, &mut random) - 0.84).abs() < 1e-15);
        assert!((next(0.84, &mut random) - 0.5376).abs() < 1e-15);
    }
}
