//! Six turning joints, the last three of which meet in one point.
//!
//! The first three bring that point where it has to be, the last three turn the tool (Pieper 1968).
//! Offsets of every kind are allowed as long as joints 2 and 3 are parallel or 1 and 2 meet.

use nalgebra::Vector3;

use super::screws::{NEARLY, Screw};
use super::turn::{Turn, between, three_turns, to_height, two_links};
use crate::geometry::Transform;

/// Such an arm.
#[derive(Clone, Debug)]
pub(super) struct SphericalWrist {
    screws: [Screw; 6],
    /// Where the last three lines meet.
    centre: Vector3<f64>,
    shoulder: Shoulder,
    /// Across line 6.
    across: Vector3<f64>,
}

#[derive(Clone, Debug)]
enum Shoulder {
    /// Lines 2 and 3 are parallel: links and senses in their plane.
    Parallel { links: [Vector3<f64>; 2], sense: f64 },
    /// Lines 1 and 2 meet here.
    Meeting(Vector3<f64>),
}

impl SphericalWrist {
    /// The arm with these lines, if it is one but for `tolerance`.
    pub(super) fn new(screws: [Screw; 6], tolerance: f64) -> Option<Self> {
        let [s1, s2, s3, s4, s5, s6] = &screws;
        if screws.iter().any(|screw| screw.slides) {
            return None;
        }
        let centre = s4.meeting(s5, tolerance)?;
        if !s6.contains(&centre, tolerance) || s5.is_parallel(s6, NEARLY) {
            return None;
        }
        let shoulder = if s2.is_parallel(s3, tolerance) && !s1.is_parallel(s2, NEARLY) {
            let links = [s2.across(&(s3.point - s2.point)), s2.across(&(centre - s3.point))];
            Shoulder::Parallel { links, sense: s2.sense(s3) }
        } else {
            let meeting = s1.meeting(s2, tolerance)?;
            if s3.contains(&meeting, NEARLY) || s3.contains(&centre, NEARLY) {
                return None;
            }
            Shoulder::Meeting(meeting)
        };
        let across = s6.any_across();
        Some(Self { screws, centre, shoulder, across })
    }

    /// Shows `see` every configuration whose motion is `motion`; `seed` stands in where a joint may be anywhere.
    #[inline]
    pub(super) fn solve(&self, motion: &Transform, seed: &[f64; 6], mut see: impl FnMut([f64; 6])) {
        let goal = motion.point(&self.centre);
        match &self.shoulder {
            Shoulder::Parallel { links, sense } => {
                self.parallel(links, *sense, &goal, seed, |arm| {
                    self.wrist(motion, arm, seed, &mut see);
                });
            }
            Shoulder::Meeting(point) => {
                self.meeting(point, &goal, seed, |arm| self.wrist(motion, arm, seed, &mut see));
            }
        }
    }

    /// The first three turns where lines 2 and 3 are parallel.
    #[inline]
    fn parallel(
        &self,
        [upper, fore]: &[Vector3<f64>; 2],
        sense: f64,
        goal: &Vector3<f64>,
        seed: &[f64; 6],
        mut see: impl FnMut([Turn; 3]),
    ) {
        let [s1, s2, ..] = &self.screws;
        // Joints 2 and 3 leave the centre's distance along their axis as it is.
        let height = s2.direction.dot(&(self.centre - s1.point));
        let bases = to_height(&s1.direction, &(goal - s1.point), &s2.direction, height);
        for base in bases.or(|| Turn::by(seed[0])) {
            let inner = s2.across(&(s1.turn(base.back(), goal) - s2.point));
            let held = || [Turn::by(seed[1]), Turn::by(sense * seed[2])];
            for [shoulder, elbow] in two_links(&s2.direction, [upper, fore, &inner], held) {
                see([base, shoulder, elbow.sensed(sense)]);
            }
        }
    }

    /// The first three turns where lines 1 and 2 meet in `point`.
    #[inline]
    fn meeting(
        &self,
        point: &Vector3<f64>,
        goal: &Vector3<f64>,
        seed: &[f64; 6],
        mut see: impl FnMut([Turn; 3]),
    ) {
        let [s1, s2, s3, ..] = &self.screws;
        // Joints 1 and 2 leave the centre's distance from the point as it is.
        let (from, arm, goal) = (point - s3.point, self.centre - s3.point, goal - point);
        let height = 0.5 * (from.norm_squared() + arm.norm_squared() - goal.norm_squared());
        let elbows = to_height(&s3.direction, &from, &arm, height);
        for elbow in elbows.or(|| Turn::by(seed[2])) {
            let reach = elbow.apply(&s3.direction, &arm) - from;
            let shoulders =
                to_height(&s2.direction, &s1.direction, &reach, s1.direction.dot(&goal));
            for shoulder in shoulders.or(|| Turn::by(seed[1])) {
                let raised = shoulder.apply(&s2.direction, &reach);
                let base = between(&s1.direction, &raised, &goal);
                see([base.unwrap_or_else(|| Turn::by(seed[0])), shoulder, elbow]);
            }
        }
    }

    /// The last three turns, once the first three are known.
    #[inline]
    fn wrist(
        &self,
        motion: &Transform,
        arm: [Turn; 3],
        seed: &[f64; 6],
        see: &mut impl FnMut([f64; 6]),
    ) {
        let [s1, s2, s3, s4, s5, s6] = &self.screws;
        let rotation = |vector: &Vector3<f64>| {
            let inner = arm[0].back().apply(&s1.direction, &motion.direction(vector));
            let inner = arm[1].back().apply(&s2.direction, &inner);
            arm[2].back().apply(&s3.direction, &inner)
        };
        let axes = [&s4.direction, &s5.direction, &s6.direction];
        let wrists = three_turns(axes, &self.across, rotation, || Turn::by(seed[3]));
        let [q1, q2, q3] = arm.map(Turn::angle);
        for wrist in wrists {
            let [q4, q5, q6] = wrist.map(Turn::angle);
            see([q1, q2, q3, q4, q5, q6]);
        }
    }
}
