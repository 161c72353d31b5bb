//! GoldS-PSO of Chen et al. 2023, doi:10.3390/app131810482, eqs. 23-30.
//!
//! A swarm without velocity that starts from a circle chaotic map, whose inertia falls along
//! an S-curve, and whose pull to the swarm's best is a golden sine step (see `gold_sa`):
//! `x <- lambda (w x + c1 |sin R1| (p - x) - c2 R2 sin R1 |x1 g - x2 x|)`, clamped to the box.
//!
//! Not printed are `lambda`, `c1`, `c2`, the range of `w`, whether the golden section is
//! updated, and whether draws are per particle or per component. The defaults are those that
//! came nearest to the paper's Table 3 in a calibration: `lambda` 0.5, `c1 = c2 = 2`, `w` from
//! 0.9 to 0.4, updated, per particle. The paper's citation beside `lambda` suggests Clerc and
//! Kennedy's 0.7298, with which the printed zeros of F2 are seldom reached. How infeasible
//! candidates are treated is not printed either; that is the problem's `constraint_handling`.
//!
//! Mind: `lambda w x` draws every particle to the origin, whatever is minimised. That is why
//! the benchmark's optima, which lie there, are reached so well.

use std::f64::consts::PI;

use pulp::Arch;

use super::entry::{
    OptimizerEntry, Parameter, SHIFT, Settings, flag, iterations, population, real,
};
use super::gold_sa::{GoldenSection, origin};
use super::particles::Particles;
use super::pso_linear::{INERTIA_FIRST, INERTIA_LAST};
use super::{Bounds, Evaluator, Objective, Optimizer, Step};
use crate::math::random::RandomStream;

/// Its registry entry.
pub const ENTRY: OptimizerEntry = OptimizerEntry {
    name: "golds_pso",
    title: "Golden sine particle swarm of Chen et al.",
    description: "Particle swarm with chaotic start, S-curve inertia and golden sine steps. Draws \
                  particles to the origin, whatever is minimised: see shift.",
    source: "Chen et al. 2023, doi:10.3390/app131810482, eqs. 23-30",
    parameters: PARAMETERS,
    build: |settings, objective, seed| Box::new(GoldenSwarm::new(settings, objective, seed)),
};

const PARAMETERS: &[Parameter] = &[
    population(50.0),
    iterations(300.0),
    real(
        "lambda",
        "factor on the whole new position; not printed, 0.5 by calibration",
        0.5,
        0.0,
        2.0,
    ),
    Parameter { description: "largest inertia weight; not printed, 0.9", ..INERTIA_FIRST },
    Parameter { description: "smallest inertia weight; not printed, 0.4", ..INERTIA_LAST },
    real(
        "cognitive_coefficient",
        "c1, pull to a particle's own best; not printed, 2 by calibration",
        2.0,
        0.0,
        10.0,
    ),
    real(
        "golden_coefficient",
        "c2, width of the golden sine step; not printed, 2 by calibration",
        2.0,
        0.0,
        10.0,
    ),
    flag("golden_update", "narrow the golden section with every particle; default true", true),
    flag(
        "draw_per_component",
        "draw R1 and R2 for every component instead of once per particle; default false",
        false,
    ),
    SHIFT,
];

struct GoldenSwarm {
    random: RandomStream,
    iterations: u64,
    iteration: u64,
    lambda: f64,
    inertia: [f64; 2],
    cognitive: f64,
    golden: f64,
    updates: bool,
    per_component: bool,
    section: GoldenSection,
    /// What positions are measured from.
    origin: Vec<f64>,
    particles: Particles,
}

impl GoldenSwarm {
    fn new(settings: &Settings, objective: &dyn Objective, seed: u64) -> Self {
        let population = settings.integer("population") as usize;
        Self {
            random: RandomStream::new(seed, 0),
            iterations: settings.integer("iterations"),
            iteration: 0,
            lambda: settings.get("lambda"),
            inertia: [settings.get("inertia_first"), settings.get("inertia_last")],
            cognitive: settings.get("cognitive_coefficient"),
            golden: settings.get("golden_coefficient"),
            updates: settings.flag("golden_update"),
            per_component: settings.flag("draw_per_component"),
            section: GoldenSection::default(),
            origin: origin(settings, objective),
            particles: Particles::new(population, objective.bounds().dimension()),
        }
    }

    fn start(&mut self, bounds: &Bounds) {
        circle_chaos(&mut self.particles.position, bounds, &mut self.random);
        self.particles.own_best.copy_from_slice(&self.particles.position);
    }

    fn fly(&mut self, evaluator: &Evaluator<'_>) {
        let best = evaluator.best_position();
        let dimension = best.len();
        let w = s_curve(self.inertia, self.iteration, self.iterations);
        // Components that move by the same draw lie side by side.
        let alike = if self.per_component { 1 } else { dimension };
        let particles = self.particles.position.chunks_exact_mut(alike);
        let beside = best.chunks_exact(alike).zip(self.origin.chunks_exact(alike)).cycle();
        let owns = self.particles.own_best.chunks_exact(alike);
        for ((x, own), (best, origin)) in particles.zip(owns).zip(beside) {
            let turn = Turn::draw(&mut self.random);
            let (lambda, c1, c2) = (self.lambda, self.cognitive, self.golden);
            let GoldenSection { x1, x2, .. } = self.section;
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for (((x, p), g), o) in x.iter_mut().zip(own).zip(best).zip(origin) {
                        let (from, own, to) = (*x - o, p - o, g - o);
                        let pull = c1 * turn.sine.abs() * (own - from);
                        let step = c2 * turn.reach * (x1 * to - x2 * from).abs();
                        *x = o + lambda * (w * from + pull - step); // Eq. (29)
                    }
                },
            );
        }
        evaluator.bounds().clamp(&mut self.particles.position);
    }
}

impl Optimizer for GoldenSwarm {
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step {
        let (first, best) = (self.iteration == 0, evaluator.best());
        if first || evaluator.best_position().is_empty() {
            self.start(evaluator.bounds());
        } else {
            self.fly(evaluator);
        }
        let step = self.particles.evaluate(evaluator);
        if self.updates && !first {
            self.section.follow(best, &self.particles.fitness, &mut self.random);
        }
        self.iteration += 1;
        step
    }
}

/// The random part of a golden sine step.
struct Turn {
    /// `sin R1`.
    sine: f64,
    /// `R2 sin R1`.
    reach: f64,
}

impl Turn {
    /// `R1` uniform in (0, 2 pi), `R2` in (0, pi), independent.
    fn draw(random: &mut RandomStream) -> Self {
        let sine = libm::sin(2.0 * PI * random.unit());
        Self { sine, reach: PI * random.unit() * sine }
    }
}

/// Inertia in iteration `k` of `1..=iterations`, eq. (25).
fn s_curve([first, last]: [f64; 2], k: u64, iterations: u64) -> f64 {
    let done = k as f64 / iterations.max(1) as f64;
    last + 0.5 * (first - last) * (1.0 + libm::tanh(2.0 - 4.0 * done))
}

/// The circle map, eq. (23), one sequence per component with a random start.
fn circle_chaos(positions: &mut [f64], bounds: &Bounds, random: &mut RandomStream) {
    let dimension = bounds.dimension();
    for d in 0..dimension {
        let (lower, width) = (bounds.lower[d], bounds.upper[d] - bounds.lower[d]);
        let mut k = random.unit();
        for x in positions[d..].iter_mut().step_by(dimension) {
            k = circle(k);
            *x = lower + k * width;
        }
    }
}

fn circle(k: f64) -> f64 {
    let next = k + 0.2 - 0.5 / (2.0 * PI) * libm::sin(2.0 * PI * k);
    next - next.floor()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertia_falls_along_an_s() {
        let inertia = |k| s_curve([0.9, 0.4], k, 100);
        // 0.4 + 0.25 (1 + tanh 2) and its mirror image.
        assert!((inertia(0) - 0.891_006_895).abs() < 1e-9);
        assert!((inertia(50) - 0.65).abs() < 1e-12);
        assert!((inertia(100) - 0.408_993_105).abs() < 1e-9);
    }

    /// Worked out by hand: `sin(pi/2) = 1` at a quarter, 0 at a half.
    #[test]
    fn the_circle_map_turns() {
        assert!((circle(0.25) - (0.45 - 0.25 / PI)).abs() < 1e-15);
        assert!((circle(0.5) - 0.7).abs() < 1e-15);
        let end = circle(0.9);
        assert!((end - (0.1 + 0.25 / PI * libm::sin(0.2 * PI))).abs() < 1e-15, "{end}");
    }
}
