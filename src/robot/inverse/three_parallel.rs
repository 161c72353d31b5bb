//! Six turning joints, the middle three before the last two parallel: 2, 3 and 4.
//!
//! The parallel joints move everything in planes, so the first and the fifth joint follow from distances and
//! directions across them. Joints 5 and 6 have to meet.

use nalgebra::Vector3;

use super::screws::{NEARLY, Screw};
use super::turn::{Turn, between, to_height, two_links};
use crate::geometry::Transform;

/// Such an arm.
#[derive(Clone, Debug)]
pub(super) struct ThreeParallel {
    screws: [Screw; 6],
    /// Where lines 5 and 6 meet.
    centre: Vector3<f64>,
    /// From line 2 to 3 and from 3 to 4, across them.
    links: [Vector3<f64>; 2],
    /// Of lines 3 and 4 against line 2.
    senses: [f64; 2],
    /// Across line 2.
    across: Vector3<f64>,
}

impl ThreeParallel {
    /// The arm with these lines, if it is one but for `tolerance`.
    pub(super) fn new(screws: [Screw; 6], tolerance: f64) -> Option<Self> {
        let [s1, s2, s3, s4, s5, s6] = &screws;
        let parallel = s2.is_parallel(s3, tolerance) && s2.is_parallel(s4, tolerance);
        let slides = screws.iter().any(|screw| screw.slides);
        if slides || !parallel || s1.is_parallel(s2, NEARLY) || s4.is_parallel(s5, NEARLY) {
            return None;
        }
        let centre = s5.meeting(s6, tolerance)?;
        let links = [s2.across(&(s3.point - s2.point)), s2.across(&(s4.point - s3.point))];
        let senses = [s2.sense(s3), s2.sense(s4)];
        let across = s2.any_across();
        Some(Self { screws, centre, links, senses, across })
    }

    /// Shows `see` every configuration whose motion is `motion`; `seed` stands in where a joint may be anywhere.
    #[inline]
    pub(super) fn solve(&self, motion: &Transform, seed: &[f64; 6], mut see: impl FnMut([f64; 6])) {
        let [s1, s2, _, _, s5, s6] = &self.screws;
        let goal = motion.point(&self.centre) - s1.point;
        let height = s2.direction.dot(&(self.centre - s1.point));
        let bases = to_height(&s1.direction, &goal, &s2.direction, height);
        let pointing = motion.direction(&s6.direction);
        for base in bases.or(|| Turn::by(seed[0])) {
            let plane = base.apply(&s1.direction, &s2.direction);
            // The plane's normal as the last link sees it.
            let normal =
                Vector3::new(motion.x.dot(&plane), motion.y.dot(&plane), motion.z.dot(&plane));
            let wrists =
                to_height(&s5.direction, &s2.direction, &s6.direction, plane.dot(&pointing));
            for wrist in wrists.or(|| Turn::by(seed[4])) {
                let before = wrist.back().apply(&s5.direction, &s2.direction);
                let last = between(&s6.direction, &normal, &before);
                let last = last.unwrap_or_else(|| Turn::by(seed[5]));
                self.middle(motion, [base, wrist, last], seed, &mut see);
            }
        }
    }

    /// The parallel joints, once the first and the last two are known.
    #[inline]
    fn middle(
        &self,
        motion: &Transform,
        [base, wrist, last]: [Turn; 3],
        seed: &[f64; 6],
        see: &mut impl FnMut([f64; 6]),
    ) {
        let [s1, s2, _, s4, s5, s6] = &self.screws;
        // What the three of them do to a point or a direction.
        let point = s6.turn(last.back(), &s5.turn(wrist.back(), &s4.point));
        let goal = s2.across(&(s1.turn(base.back(), &motion.point(&point)) - s2.point));
        let turned =
            last.back().apply(&s6.direction, &wrist.back().apply(&s5.direction, &self.across));
        let turned = base.back().apply(&s1.direction, &motion.direction(&turned));
        let total = between(&s2.direction, &self.across, &turned);
        let total = total.unwrap_or(Turn { sin: 0.0, cos: 1.0 }).angle();
        let [upper, fore] = &self.links;
        let [third, fourth] = self.senses;
        let held = || [Turn::by(seed[1]), Turn::by(third * seed[2])];
        let [q1, q5, q6] = [base, wrist, last].map(Turn::angle);
        for [shoulder, elbow] in two_links(&s2.direction, [upper, fore, &goal], held) {
            let (q2, bend) = (shoulder.angle(), elbow.angle());
            see([q1, q2, third * bend, fourth * (total - q2 - bend), q5, q6]);
        }
    }
}
