//! A point in a box among balls and boxes: which motions are free, exactly.
//!
//! Obstacles are closed: touching one at zero distance is a hit. So that
//! rounding hides no contact, they are a 1e-12th of the space's diagonal, and
//! balls a 4e-15th of their radius, larger than given.

use pulp::Arch;

use super::request::{Obstacle, Space};
use crate::math::lanes::{Lanes, WIDTH};
use crate::planner::{ValidityChecker, distance};

/// A point's box with its obstacles, eight of a kind side by side.
#[derive(Clone, Debug)]
pub struct PointSpace {
    dimension: usize,
    balls: Balls,
    boxes: Boxes,
    arch: Arch,
}

/// Groups of eight balls: a group's centres coordinate by coordinate.
#[derive(Clone, Debug, Default)]
struct Balls {
    centres: Vec<Lanes>,
    radii: Vec<Lanes>,
}

/// Groups of eight boxes: a group's lower ends, then its upper ones.
#[derive(Clone, Debug, Default)]
struct Boxes {
    ends: Vec<Lanes>,
}

/// By how much of the space's diagonal obstacles are larger than given.
const MARGIN: f64 = 1e-12;

impl PointSpace {
    /// The space that a valid request describes.
    pub fn new(space: &Space) -> Self {
        let dimension = space.lower.len();
        let margin = MARGIN * distance(&space.lower, &space.upper);
        let (mut balls, mut boxes) = (Vec::new(), Vec::new());
        for obstacle in &space.obstacles {
            match obstacle {
                Obstacle::Ball(ball) => {
                    balls.push((&ball.center, ball.radius * (1.0 + 4e-15) + margin));
                }
                Obstacle::Box(block) => boxes.push((&block.lower, &block.upper)),
            }
        }
        let mut found =
            Self { dimension, balls: Balls::default(), boxes: Boxes::default(), arch: Arch::new() };
        for group in balls.chunks(WIDTH) {
            // A missing ball is infinitely far away.
            let centre = |axis: usize| lanes(group, f64::INFINITY, |(centre, _)| centre[axis]);
            found.balls.centres.extend((0..dimension).map(centre));
            found.balls.radii.push(lanes(group, 0.0, |(_, radius)| *radius));
        }
        for group in boxes.chunks(WIDTH) {
            let lower =
                |axis: usize| lanes(group, f64::INFINITY, |(lower, _)| lower[axis] - margin);
            let upper =
                |axis: usize| lanes(group, f64::INFINITY, |(_, upper)| upper[axis] + margin);
            found.boxes.ends.extend((0..dimension).map(lower));
            found.boxes.ends.extend((0..dimension).map(upper));
        }
        found
    }

    /// Whether no obstacle is nearer than `margin` to the straight motion.
    ///
    /// Boxes are made larger on all sides, so near their corners a motion that is
    /// further away may be refused.
    pub fn is_motion_clear(&self, from: &[f64], to: &[f64], margin: f64) -> bool {
        self.arch.dispatch(
            #[inline(always)]
            || match self.dimension {
                2 => self.is_clear(2, from, to, margin),
                3 => self.is_clear(3, from, to, margin),
                dimension => self.is_clear(dimension, from, to, margin),
            },
        )
    }

    #[inline(always)]
    fn is_clear(&self, dimension: usize, from: &[f64], to: &[f64], margin: f64) -> bool {
        let (from, to) = (&from[..dimension], &to[..dimension]);
        !self.balls.are_hit(dimension, from, to, margin)
            && !self.boxes.are_hit(dimension, from, to, margin)
    }

    #[inline(always)]
    fn distance(&self, dimension: usize, state: &[f64]) -> f64 {
        let state = &state[..dimension];
        self.balls.distance(dimension, state).min(self.boxes.distance(dimension, state))
    }
}

fn lanes<T>(group: &[T], missing: f64, value: impl Fn(&T) -> f64) -> Lanes {
    Lanes(std::array::from_fn(|lane| group.get(lane).map_or(missing, &value)))
}

impl ValidityChecker for PointSpace {
    fn is_state_valid(&mut self, state: &[f64]) -> bool {
        self.is_motion_clear(state, state, 0.0)
    }

    fn is_motion_valid(&mut self, from: &[f64], to: &[f64]) -> bool {
        self.is_motion_clear(from, to, 0.0)
    }

    fn clearance(&mut self, state: &[f64]) -> Option<f64> {
        let distance = self.arch.dispatch(
            #[inline(always)]
            || match self.dimension {
                2 => self.distance(2, state),
                3 => self.distance(3, state),
                dimension => self.distance(dimension, state),
            },
        );
        Some(distance)
    }
}

impl Balls {
    /// Whether the segment comes within `margin` of a ball: the point of it
    /// nearest to the centre decides.
    #[inline(always)]
    fn are_hit(&self, dimension: usize, from: &[f64], to: &[f64], margin: f64) -> bool {
        let along: f64 = from.iter().zip(to).map(|(from, to)| (to - from) * (to - from)).sum();
        let inverse = if along > 0.0 { 1.0 / along } else { 0.0 };
        for (centres, radii) in self.centres.chunks_exact(dimension).zip(&self.radii) {
            let mut share = [0.0; WIDTH];
            for axis in 0..dimension {
                let way = (to[axis] - from[axis]) * inverse;
                for (share, centre) in share.iter_mut().zip(&centres[axis].0) {
                    *share += (centre - from[axis]) * way;
                }
            }
            for share in &mut share {
                // An infinitely far ball gives no number, which becomes zero here.
                *share = if *share > 0.0 { *share } else { 0.0 };
                *share = if *share < 1.0 { *share } else { 1.0 };
            }
            let mut squared = [0.0; WIDTH];
            for axis in 0..dimension {
                let way = to[axis] - from[axis];
                for lane in 0..WIDTH {
                    let off = (from[axis] - centres[axis].0[lane]) + share[lane] * way;
                    squared[lane] += off * off;
                }
            }
            let mut hit = false;
            for (squared, radius) in squared.iter().zip(&radii.0) {
                let reach = radius + margin;
                hit |= *squared <= reach * reach;
            }
            if hit {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn distance(&self, dimension: usize, state: &[f64]) -> f64 {
        let mut least = [f64::INFINITY; WIDTH];
        for (centres, radii) in self.centres.chunks_exact(dimension).zip(&self.radii) {
            let mut squared = [0.0; WIDTH];
            for axis in 0..dimension {
                for (squared, centre) in squared.iter_mut().zip(&centres[axis].0) {
                    let off = centre - state[axis];
                    *squared += off * off;
                }
            }
            for lane in 0..WIDTH {
                let distance = squared[lane].sqrt() - radii.0[lane];
                least[lane] = if distance < least[lane] { distance } else { least[lane] };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}

impl Boxes {
    /// Whether the segment comes within `margin` of a box in every axis at once:
    /// the parts of it between the planes of each axis are cut.
    #[inline(always)]
    fn are_hit(&self, dimension: usize, from: &[f64], to: &[f64], margin: f64) -> bool {
        for ends in self.ends.chunks_exact(2 * dimension) {
            let (mut enter, mut leave) = ([0.0; WIDTH], [1.0; WIDTH]);
            for axis in 0..dimension {
                let (lower, upper) = (&ends[axis].0, &ends[dimension + axis].0);
                let (start, way) = (from[axis], to[axis] - from[axis]);
                // Slower than any coordinate can tell.
                if way.abs() < 1e-200 {
                    for lane in 0..WIDTH {
                        let within = lower[lane] - margin <= start && start <= upper[lane] + margin;
                        leave[lane] = if within { leave[lane] } else { -1.0 };
                    }
                    continue;
                }
                let inverse = 1.0 / way;
                for lane in 0..WIDTH {
                    let at_lower = (lower[lane] - margin - start) * inverse;
                    let at_upper = (upper[lane] + margin - start) * inverse;
                    let ascending = at_lower < at_upper;
                    let first = if ascending { at_lower } else { at_upper };
                    let last = if ascending { at_upper } else { at_lower };
                    enter[lane] = if first > enter[lane] { first } else { enter[lane] };
                    leave[lane] = if last < leave[lane] { last } else { leave[lane] };
                }
            }
            let mut hit = false;
            for lane in 0..WIDTH {
                hit |= enter[lane] <= leave[lane];
            }
            if hit {
                return true;
            }
        }
        false
    }

    /// Inside a box the distance to the nearest face, negative.
    #[inline(always)]
    fn distance(&self, dimension: usize, state: &[f64]) -> f64 {
        let mut least = f64::INFINITY;
        for ends in self.ends.chunks_exact(2 * dimension) {
            let (mut squared, mut deepest) = ([0.0; WIDTH], [f64::NEG_INFINITY; WIDTH]);
            for axis in 0..dimension {
                let (lower, upper) = (&ends[axis].0, &ends[dimension + axis].0);
                for lane in 0..WIDTH {
                    let (below, above) = (lower[lane] - state[axis], state[axis] - upper[lane]);
                    let off = if below > above { below } else { above };
                    deepest[lane] = if off > deepest[lane] { off } else { deepest[lane] };
                    let outside = if off > 0.0 { off } else { 0.0 };
                    squared[lane] += outside * outside;
                }
            }
            for lane in 0..WIDTH {
                let inside = deepest[lane] <= 0.0;
                least = least.min(if inside { deepest[lane] } else { squared[lane].sqrt() });
            }
        }
        least
    }
}

/// How deep a state lies in an obstacle: the way to its surface; negative
/// outside, then the distance.
pub(super) fn depth(obstacle: &Obstacle, state: &[f64]) -> f64 {
    match obstacle {
        Obstacle::Ball(ball) => ball.radius - distance(&ball.center, state),
        Obstacle::Box(block) => {
            let ends = block.lower.iter().zip(&block.upper);
            let offs =
                state.iter().zip(ends).map(|(&x, (lower, upper))| (lower - x).max(x - upper));
            let deepest = offs.clone().fold(f64::NEG_INFINITY, f64::max);
            if deepest <= 0.0 {
                return -deepest;
            }
            -offs.map(|off| off.max(0.0) * off.max(0.0)).sum::<f64>().sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::{BallObstacle, BoxObstacle};
    use super::*;
    use crate::math::random::RandomStream;

    /// Balls and boxes of all sizes, more than one group of each.
    fn space(dimension: usize, seed: u64) -> (Space, RandomStream) {
        let mut random = RandomStream::new(seed, dimension as u64);
        let mut draw = |from: f64, to: f64| -> Vec<f64> {
            (0..dimension).map(|_| random.uniform(from, to)).collect()
        };
        let mut obstacles = Vec::new();
        for index in 0..20 {
            let center = draw(0.0, 10.0);
            obstacles.push(if index % 2 == 0 {
                Obstacle::Ball(BallObstacle { center, radius: draw(0.0, 2.0)[0] })
            } else {
                let size = draw(0.0, 3.0);
                let upper = center.iter().zip(&size).map(|(x, size)| x + size).collect();
                Obstacle::Box(BoxObstacle { lower: center, upper })
            });
        }
        let space = Space { lower: vec![0.0; dimension], upper: vec![10.0; dimension], obstacles };
        (space, random)
    }

    /// Against depths at the points of each motion, and the clearance against
    /// the nearest of all obstacles.
    #[test]
    fn motions_are_free_exactly_where_all_their_points_are() {
        let (mut hit, mut free) = (0, 0);
        for dimension in [2, 3, 5, 12] {
            for seed in 0..40 {
                let (given, mut random) = space(dimension, seed);
                let mut checker = PointSpace::new(&given);
                for _ in 0..20 {
                    let mut draw = || -> Vec<f64> {
                        (0..dimension).map(|_| random.uniform(0.0, 10.0)).collect()
                    };
                    let (from, mut to) = (draw(), draw());
                    // Along an axis in some of the rest.
                    to[1] = if from[0] < 3.0 { from[1] } else { to[1] };
                    let deepest = |at: &[f64]| {
                        let depths = given.obstacles.iter().map(|obstacle| depth(obstacle, at));
                        depths.fold(f64::NEG_INFINITY, f64::max)
                    };
                    let gap = (0..=2000).map(|step| {
                        let share = f64::from(step) / 2000.0;
                        let ends = from.iter().zip(&to);
                        deepest(&ends.map(|(a, b)| a + share * (b - a)).collect::<Vec<f64>>())
                    });
                    let gap = -gap.fold(f64::NEG_INFINITY, f64::max);
                    let spacing = distance(&from, &to) / 4000.0;
                    let is_free = checker.is_motion_valid(&from, &to);
                    assert!(!is_free || gap > 0.0, "{dimension}, {seed}: {gap}");
                    assert!(is_free || gap < spacing, "{dimension}, {seed}: {gap} {spacing}");
                    assert!(!is_free || checker.is_motion_clear(&from, &to, 0.0));
                    assert!(!checker.is_motion_clear(&from, &to, gap.max(0.0) + spacing));
                    assert_eq!(checker.is_motion_valid(&to, &from), is_free);
                    (hit, free) = if is_free { (hit, free + 1) } else { (hit + 1, free) };
                    let off = checker.clearance(&from).unwrap() + deepest(&from);
                    assert!(off.abs() < 1e-9, "{dimension}, {seed}: {off}");
                    assert_eq!(checker.is_state_valid(&from), deepest(&from) < 0.0);
                }
            }
        }
        assert!(hit > 500 && free > 500, "{hit} {free}");
    }

    #[test]
    fn touching_is_hitting() {
        let ball = Obstacle::Ball(BallObstacle { center: vec![0.3, 0.7], radius: 0.1 });
        let block = Obstacle::Box(BoxObstacle { lower: vec![0.1, 0.1], upper: vec![0.4, 0.3] });
        let space = |obstacles| Space { lower: vec![0.0; 2], upper: vec![1.0; 2], obstacles };
        let mut both = PointSpace::new(&space(vec![ball, block]));
        for [from, to] in [
            [[0.0, 0.6], [1.0, 0.6]],
            [[0.4, 0.0], [0.4, 1.0]],
            [[0.2, 0.0], [0.2, 1.0]],
            [[0.0, 0.3], [1.0, 0.3]],
            [[0.1, 0.0], [0.1, 1.0]],
            [[0.3, 0.4], [0.5, 0.2]],
        ] {
            assert!(!both.is_motion_valid(&from, &to), "{from:?} {to:?}");
            let aside = |[x, y]: [f64; 2]| [x + 1e-9, y + 1e-9];
            let moved = both.is_motion_valid(&aside(from), &aside(to));
            let is_parallel_above = from[1] == 0.3 || from == [0.4, 0.0] || from[1] == 0.4;
            assert_eq!(moved, is_parallel_above, "{from:?} {to:?}");
        }
        let mut empty = PointSpace::new(&space(Vec::new()));
        assert!(empty.is_motion_valid(&[0.0, 0.0], &[1.0, 1.0]));
        assert_eq!(empty.clearance(&[0.5, 0.5]), Some(f64::INFINITY));
    }
}
