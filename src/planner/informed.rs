//! Samples from where a shorter path can still go: the ellipsoid whose foci are
//! start and goal (Gammell et al. 2014, doi:10.1109/IROS.2014.6942976).

use super::rewiring::unit_ball;
use super::world::World;
use super::{PlanningProblem, ValidityChecker, distance};
use crate::math::random::RandomStream;

/// All states through which a path of at most a given length can lead.
///
/// Instead of the rotation that the source takes from a singular value
/// decomposition, a reflection turns the first axis into the direction from
/// start to goal: a ball is the same after either.
pub(super) struct Ellipsoid {
    centre: Vec<f64>,
    /// Normal of the mirror; zero where there is nothing to turn.
    mirror: Vec<f64>,
    /// Distance of the foci.
    least: f64,
    /// Half the length of the first axis, and of all others.
    radii: [f64; 2],
    /// Volume of the box, as a logarithm.
    box_volume: f64,
    ball: Vec<f64>,
}

impl Ellipsoid {
    pub fn new(problem: &PlanningProblem) -> Self {
        let PlanningProblem { lower, upper, start, goal } = problem;
        let least = distance(start, goal);
        let mut mirror: Vec<f64> = start
            .iter()
            .zip(goal)
            .map(|(start, goal)| (start - goal) / least.max(1e-300))
            .collect();
        mirror[0] += 1.0;
        let squared: f64 = mirror.iter().map(|x| x * x).sum();
        let scale = if squared > 1e-12 { (2.0 / squared).sqrt() } else { 0.0 };
        mirror.iter_mut().for_each(|x| *x *= scale);
        let sides = lower.iter().zip(upper).map(|(lower, upper)| libm::log(upper - lower));
        Self {
            centre: start.iter().zip(goal).map(|(start, goal)| 0.5 * (start + goal)).collect(),
            mirror,
            least,
            radii: [f64::INFINITY; 2],
            box_volume: sides.sum(),
            ball: vec![0.0; start.len()],
        }
    }

    /// Makes it that of paths of this length.
    pub fn shrink(&mut self, length: f64) {
        let across = (length - self.least) * (length + self.least);
        self.radii = [0.5 * length, 0.5 * across.max(0.0).sqrt()];
    }

    /// Its volume as a share of the box's; above one where it reaches far beyond.
    pub fn share(&self) -> f64 {
        let dimension = self.centre.len();
        let across = (dimension - 1) as f64 * libm::log(self.radii[1]);
        let volume = libm::log(unit_ball(dimension)) + libm::log(self.radii[0]) + across;
        libm::exp(volume - self.box_volume)
    }

    /// Draws a state of the box that lies in the ellipsoid; some state of the
    /// box if none is found soon.
    pub fn sample<C: ValidityChecker>(&mut self, world: &mut World<'_, C>, state: &mut [f64]) {
        const TRIES: usize = 64;
        let is_small = self.share() < 1.0;
        for _ in 0..TRIES {
            if is_small {
                self.draw(&mut world.random, state);
                if is_inside(world.problem, state) {
                    return;
                }
            } else {
                world.sample(state);
                if self.contains(world.problem, state) {
                    return;
                }
            }
        }
        world.sample(state);
    }

    /// Whether a path of the length can lead through a state.
    pub fn contains(&self, problem: &PlanningProblem, state: &[f64]) -> bool {
        let through = distance(&problem.start, state) + distance(state, &problem.goal);
        through < 2.0 * self.radii[0]
    }

    fn draw(&mut self, random: &mut RandomStream, state: &mut [f64]) {
        draw_from_ball(random, &mut self.ball);
        let [along, across] = self.radii;
        self.ball[0] *= along;
        self.ball[1..].iter_mut().for_each(|x| *x *= across);
        let depth: f64 = self.ball.iter().zip(&self.mirror).map(|(x, n)| x * n).sum();
        let centre = self.centre.iter().zip(&self.mirror);
        for ((x, ball), (centre, normal)) in state.iter_mut().zip(&self.ball).zip(centre) {
            *x = centre + ball - depth * normal;
        }
    }
}

fn is_inside(problem: &PlanningProblem, state: &[f64]) -> bool {
    let ends = problem.lower.iter().zip(&problem.upper);
    state.iter().zip(ends).all(|(x, (lower, upper))| (lower..=upper).contains(&x))
}

/// Draws from the unit ball: from the cube around it where that is not too rare,
/// else a direction of normal numbers at a random depth.
pub(super) fn draw_from_ball(random: &mut RandomStream, ball: &mut [f64]) {
    if ball.len() <= 4 {
        loop {
            ball.iter_mut().for_each(|x| *x = random.uniform(-1.0, 1.0));
            if ball.iter().map(|x| x * x).sum::<f64>() <= 1.0 {
                return;
            }
        }
    }
    for pair in ball.chunks_mut(2) {
        // Box and Muller; the logarithm never sees zero.
        let radius = (-2.0 * libm::log(1.0 - random.unit())).sqrt();
        let (sine, cosine) = libm::sincos(2.0 * std::f64::consts::PI * random.unit());
        for (x, share) in pair.iter_mut().zip([cosine, sine]) {
            *x = radius * share;
        }
    }
    let length = ball.iter().map(|x| x * x).sum::<f64>().sqrt();
    let depth = libm::pow(random.unit(), 1.0 / ball.len() as f64);
    let scale = if length > 0.0 { depth / length } else { 0.0 };
    ball.iter_mut().for_each(|x| *x *= scale);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// States lie in the ellipsoid, and evenly: as many on either side of the
    /// middle, and at the depths that volumes ask for.
    #[test]
    fn samples_fill_the_ellipsoid_evenly() {
        for dimension in [2, 3, 5, 12] {
            let mut problem = PlanningProblem {
                lower: vec![-10.0; dimension],
                upper: vec![10.0; dimension],
                start: vec![1.0; dimension],
                goal: vec![0.5; dimension],
            };
            problem.goal[1] = -2.0;
            let mut ellipsoid = Ellipsoid::new(&problem);
            let length = 1.2 * ellipsoid.least;
            ellipsoid.shrink(length);
            let mut random = RandomStream::new(3, 0);
            let mut state = vec![0.0; dimension];
            let (mut nearer_start, mut deep) = (0, 0);
            for _ in 0..20_000 {
                ellipsoid.draw(&mut random, &mut state);
                let (from, to) =
                    (distance(&problem.start, &state), distance(&state, &problem.goal));
                assert!(from + to <= length * (1.0 + 1e-12), "{dimension}: {from} + {to}");
                nearer_start += usize::from(from < to);
                // Half as large in all directions.
                let inner: Vec<f64> =
                    state.iter().zip(&ellipsoid.centre).map(|(x, c)| 2.0 * x - c).collect();
                let through = distance(&problem.start, &inner) + distance(&inner, &problem.goal);
                deep += usize::from(through <= length);
            }
            assert!((9_600..10_400).contains(&nearer_start), "{dimension}: {nearer_start}");
            let expected = 20_000.0 * 0.5f64.powi(dimension as i32);
            let off = (deep as f64 - expected).abs();
            assert!(off <= 4.0 * expected.sqrt(), "{dimension}: {deep} instead of {expected}");
        }
    }
}
