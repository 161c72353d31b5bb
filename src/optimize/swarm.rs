//! The particle swarm that `pso` and its relatives share.

use pulp::{Arch, Simd, WithSimd};

use super::entry::Settings;
use super::particles::Particles;
use super::{Bounds, Evaluator, Optimizer, Step};
use crate::math::lanes::{Lanes, Vector, WIDTH, registers};
use crate::math::random::{RandomLanes, RandomStream};

/// How the swarm's momentum changes from iteration to iteration.
pub trait Schedule {
    /// Inertia weight `w` and the factor `phi` on the whole velocity, in
    /// iteration `k` of 1 to `iterations`.
    fn weights(&self, k: u64, iterations: u64) -> Weights;

    /// True if initial particles are first moved to feasible places.
    fn repairs_initial(&self) -> bool {
        false
    }

    /// What inertia keeps.
    fn momentum(&self) -> Momentum {
        Momentum::Velocity
    }
}

/// Factors of the velocity update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// On the momentum.
    pub inertia: f64,
    /// On the sum of all three terms.
    pub compression: f64,
}

/// What inertia keeps of a particle's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Momentum {
    /// The velocity before.
    Velocity,
    /// Nothing but the position itself, measured from the origin.
    Position,
    /// The position, measured from the centre of the box.
    ShiftedPosition,
}

/// A particle swarm (Kennedy and Eberhart 1995, doi:10.1109/ICNN.1995.488968).
///
/// `v <- phi (w v + c1 r1 (p - x) + c2 r2 (g - x))`, clamped to a share of the
/// box, then `x <- x + v`, clamped to the box; a component that leaves the box
/// loses its velocity there. Fresh `r1`, `r2` per particle and component, as
/// multiples of 2^-32.
pub struct Swarm<S> {
    schedule: S,
    random: RandomStream,
    lanes: RandomLanes,
    population: usize,
    iterations: u64,
    cognitive: f64,
    social: f64,
    /// Largest step as a share of the box.
    velocity_share: f64,
    iteration: u64,
    /// Of eight components that lie side by side each.
    velocity: Vec<Lanes>,
    tiles: Vec<Tile>,
    pub(super) particles: Particles,
}

/// What belongs to eight components that lie side by side. Eight particles fill
/// whole tiles, so after as many as there are components they repeat.
struct Tile {
    best: Lanes,
    lower: Lanes,
    upper: Lanes,
    fastest: Lanes,
    centre: Lanes,
}

fn tiles(bounds: &Bounds, velocity_share: f64, momentum: Momentum) -> Vec<Tile> {
    let widths = bounds.lower.iter().zip(&bounds.upper).map(|(lower, upper)| upper - lower);
    let fastest: Vec<f64> = widths.map(|width| velocity_share * width).collect();
    let centre = match momentum {
        Momentum::ShiftedPosition => bounds.centre(),
        Momentum::Velocity | Momentum::Position => vec![0.0; bounds.dimension()],
    };
    let tile = |index: usize| {
        let cut =
            |of: &[f64]| Lanes(std::array::from_fn(|lane| of[(index * WIDTH + lane) % of.len()]));
        Tile {
            best: Lanes::ZERO,
            lower: cut(&bounds.lower),
            upper: cut(&bounds.upper),
            fastest: cut(&fastest),
            centre: cut(&centre),
        }
    };
    (0..bounds.dimension()).map(tile).collect()
}

impl<S: Schedule> Swarm<S> {
    /// A swarm with the parameters every relative shares.
    pub fn new(schedule: S, settings: &Settings, seed: u64) -> Self {
        Self {
            // Without momentum there is no velocity to bound.
            velocity_share: match schedule.momentum() {
                Momentum::Velocity => settings.get("max_velocity"),
                Momentum::Position | Momentum::ShiftedPosition => f64::INFINITY,
            },
            schedule,
            random: RandomStream::new(seed, 0),
            lanes: RandomLanes::new(seed, 1),
            population: settings.integer("population") as usize,
            iterations: settings.integer("iterations"),
            cognitive: settings.get("cognitive_coefficient"),
            social: settings.get("social_coefficient"),
            iteration: 0,
            velocity: Vec::new(),
            tiles: Vec::new(),
            particles: Particles::default(),
        }
    }

    fn initialize(&mut self, evaluator: &mut Evaluator<'_>) {
        let bounds = evaluator.bounds();
        let dimension = bounds.dimension();
        self.particles = Particles::new(self.population, dimension);
        let registers = (self.population * dimension).div_ceil(WIDTH);
        self.velocity = vec![Lanes::ZERO; registers];
        self.tiles = tiles(bounds, self.velocity_share, self.schedule.momentum());
        self.particles.scatter(evaluator, &mut self.random);
        if self.schedule.repairs_initial() {
            for particle in self.particles.position.chunks_exact_mut(dimension) {
                if evaluator.stop_reason().is_some() {
                    break;
                }
                evaluator.repair(particle);
            }
            self.particles.own_best.copy_from_slice(&self.particles.position);
        }
    }

    fn fly(&mut self, best: &[f64]) {
        let Weights { inertia, compression } =
            self.schedule.weights(self.iteration, self.iterations);
        let mut repeated = best.iter().cycle();
        for lane in self.tiles.iter_mut().flat_map(|tile| &mut tile.best.0) {
            *lane = *repeated.next().unwrap_or(&0.0);
        }
        let remembers = self.schedule.momentum() == Momentum::Velocity;
        // `x <- w x + ...` moves a particle by `(w - 1) x + ...`.
        let inertia = if remembers { inertia } else { inertia - 1.0 };
        Arch::new().dispatch(Flight {
            factors: Factors {
                remembers,
                inertia,
                compression,
                cognitive: self.cognitive,
                social: self.social,
            },
            lanes: &mut self.lanes,
            velocity: &mut self.velocity,
            particles: &mut self.particles,
            tiles: &self.tiles,
        });
    }
}

impl<S: Schedule> Optimizer for Swarm<S> {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        if self.particles.is_empty() {
            self.initialize(evaluator);
        } else {
            self.iteration += 1;
            if evaluator.best_position().is_empty() {
                self.particles.scatter(evaluator, &mut self.random);
            } else {
                self.fly(evaluator.best_position());
            }
        }
        self.particles.evaluate(evaluator)
    }
}

/// One iteration's move of all particles, in the machine's widest registers.
struct Flight<'a> {
    factors: Factors,
    lanes: &'a mut RandomLanes,
    velocity: &'a mut [Lanes],
    particles: &'a mut Particles,
    tiles: &'a [Tile],
}

#[derive(Clone, Copy)]
struct Factors {
    /// False if positions take the place of velocities.
    remembers: bool,
    inertia: f64,
    compression: f64,
    cognitive: f64,
    social: f64,
}

type Eight = [f64; WIDTH];

impl WithSimd for Flight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factors, lanes, velocity, particles, tiles } = self;
        let (x, x_rest) = particles.position.as_chunks_mut();
        let (p, p_rest) = particles.own_best.as_chunks();
        let mut beside = velocity.iter_mut().zip(tiles.iter().cycle());
        // In this order of zipping, the last velocity is left to the rest.
        for ((x, p), (v, tile)) in x.iter_mut().zip(p).zip(&mut beside) {
            step(simd, factors, lanes.pair(), x, v, p, tile);
        }
        if let Some((v, tile)) = beside.next() {
            // Components that fill no register take the same way in a copy.
            let copy = |rest: &[f64]| Lanes::from_slice(rest, 0.0).0;
            let mut x = copy(x_rest);
            step(simd, factors, lanes.pair(), &mut x, v, &copy(p_rest), tile);
            x_rest.copy_from_slice(&x[..x_rest.len()]);
        }
    }
}

/// Moves eight components.
#[inline(always)]
fn step<S: Simd>(
    simd: S,
    factors: Factors,
    [r1, r2]: &[Lanes; 2],
    x: &mut Eight,
    v: &mut Lanes,
    p: &Eight,
    tile: &Tile,
) {
    let splat = |value| Vector::splat(simd, value);
    for part in 0..registers::<S>(WIDTH) {
        let load = |lanes| Vector::load(simd, lanes, part);
        let from = Vector::read(simd, x, part);
        let own = load(r1) * factors.cognitive * (Vector::read(simd, p, part) - from);
        let swarm = load(r2) * factors.social * (load(&tile.best) - from);
        let momentum = if factors.remembers { load(v) } else { from - load(&tile.centre) };
        let wish = (momentum * factors.inertia + (own + swarm)) * factors.compression;
        let fastest = load(&tile.fastest);
        let velocity = wish.max(-fastest).min(fastest);
        let moved = from + velocity;
        let inside = moved.max(load(&tile.lower)).min(load(&tile.upper));
        inside.write(x, part);
        inside.equals(moved).select(velocity, splat(0.0)).store(v, part);
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::*;

    #[test]
    fn flights_do_not_depend_on_the_width_of_registers() {
        let bounds = Bounds { lower: vec![-1.0, 0.0, 2.0], upper: vec![1.0, 3.0, 2.5] };
        for momentum in [Momentum::Velocity, Momentum::Position, Momentum::ShiftedPosition] {
            let fly = |wide: bool| {
                // Five particles of three components leave one register unfilled.
                let mut particles = Particles::new(5, 3);
                bounds.scatter(&mut particles.own_best, &mut RandomStream::new(1, 0));
                bounds.scatter(&mut particles.position, &mut RandomStream::new(2, 0));
                let mut velocity = [Lanes::ZERO; 2];
                let mut lanes = RandomLanes::new(3, 0);
                for _ in 0..20 {
                    let flight = Flight {
                        factors: Factors {
                            remembers: momentum == Momentum::Velocity,
                            inertia: 0.7,
                            compression: 0.9,
                            cognitive: 1.8,
                            social: 2.1,
                        },
                        lanes: &mut lanes,
                        velocity: &mut velocity,
                        particles: &mut particles,
                        tiles: &tiles(&bounds, 0.3, momentum),
                    };
                    if wide {
                        Arch::new().dispatch(flight)
                    } else {
                        flight.with_simd(Scalar::new())
                    }
                }
                particles.position
            };
            assert_eq!(fly(true), fly(false), "{momentum:?}");
        }
    }
}
