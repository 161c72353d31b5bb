//! Three turning joints and perhaps a sliding one, all of them parallel.

use nalgebra::Vector3;

use super::screws::Screw;
use super::turn::{Turn, between, two_links};
use crate::geometry::Transform;

/// Such an arm.
#[derive(Clone, Debug)]
pub(super) struct Scara {
    /// The turning joints and their indices.
    turns: [(usize, Screw); 3],
    slide: Option<(usize, Screw)>,
    /// From the first line to the second and from there to the third, across them.
    links: [Vector3<f64>; 2],
    /// Of the second and third line against the first.
    senses: [f64; 2],
    /// Across the lines.
    across: Vector3<f64>,
}

impl Scara {
    /// Most joints of such an arm.
    pub(super) const MOST: usize = 4;

    /// The arm with these lines, if it is one but for `tolerance`.
    pub(super) fn new(screws: &[Screw], tolerance: f64) -> Option<Self> {
        if !screws.iter().all(|screw| screw.is_parallel(&screws[0], tolerance)) {
            return None;
        }
        let of = |slides: bool| {
            screws.iter().copied().enumerate().filter(move |(_, screw)| screw.slides == slides)
        };
        let turns: [(usize, Screw); 3] = of(false).collect::<Vec<_>>().try_into().ok()?;
        let mut slides = of(true);
        let (slide, None) = (slides.next(), slides.next()) else { return None };
        let [(_, s1), (_, s2), (_, s3)] = &turns;
        let links = [s1.across(&(s2.point - s1.point)), s1.across(&(s3.point - s2.point))];
        let (senses, across) = ([s1.sense(s2), s1.sense(s3)], s1.any_across());
        Some(Self { turns, slide, links, senses, across })
    }

    /// Shows `see` every configuration whose motion comes nearest to `motion`: the arm cannot tilt its tool.
    #[inline]
    pub(super) fn solve(
        &self,
        motion: &Transform,
        seed: &[f64],
        mut see: impl FnMut([f64; Self::MOST]),
    ) {
        let [(first, s1), (second, _), (third, s3)] = &self.turns;
        let axis = &s1.direction;
        let goal = motion.point(&s3.point);
        // None where the tool stands on its head, which no turn of it is near.
        let Some(total) = between(axis, &self.across, &motion.direction(&self.across)) else {
            return;
        };
        let mut joints = [0.0; Self::MOST];
        if let Some((index, slide)) = &self.slide {
            joints[*index] = slide.direction.dot(&(goal - s3.point));
        }
        let [upper, fore] = &self.links;
        let [sense2, sense3] = self.senses;
        let held = || [Turn::by(seed[*first]), Turn::by(sense2 * seed[*second])];
        let goal = s1.across(&(goal - s1.point));
        for [shoulder, elbow] in two_links(axis, [upper, fore, &goal], held) {
            let (turn, bend) = (shoulder.angle(), elbow.angle());
            joints[*first] = turn;
            joints[*second] = sense2 * bend;
            joints[*third] = sense3 * (total.angle() - turn - bend);
            see(joints);
        }
    }
}
