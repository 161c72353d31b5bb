//! A robot's joints as lines in the world, with every joint at 0.
//!
//! With `E_i(q_i)` the motion about (or along) line i, and `M` the tool's place at 0, the tool stands at
//! `E_1(q_1) ... E_n(q_n) M`. Closed forms work with `E = T M⁻¹`, `T` the wanted place.

use nalgebra::Vector3;

use super::turn::Turn;
use crate::geometry::Transform;
use crate::robot::{Kinematics, LinkFrames};

/// How far parallels may diverge (rad) and meeting lines miss each other (m): rounding of drawings, and no more.
pub(super) const EXACTLY: f64 = 1e-9;
/// The same of real arms, whose makers measured where the lines are.
pub(super) const NEARLY: f64 = 1e-2;

/// A joint's line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Screw {
    /// Unit vector; a positive position turns about it by the right hand, or slides along it.
    pub(super) direction: Vector3<f64>,
    /// Of the line, m.
    pub(super) point: Vector3<f64>,
    /// True if the joint slides.
    pub(super) slides: bool,
}

impl Screw {
    /// A point moved by `turn`.
    #[inline]
    pub(super) fn turn(&self, turn: Turn, point: &Vector3<f64>) -> Vector3<f64> {
        self.point + turn.apply(&self.direction, &(point - self.point))
    }

    /// The joint's motion to `position`, rad or m.
    pub(super) fn to(&self, position: f64) -> Transform {
        if self.slides {
            return Transform { origin: self.direction * position, ..Transform::IDENTITY };
        }
        let turned = Transform::about(&self.direction, libm::sincos(position));
        Transform { origin: self.point - turned.direction(&self.point), ..turned }
    }

    pub(super) fn is_parallel(&self, other: &Self, tolerance: f64) -> bool {
        self.direction.cross(&other.direction).norm() < tolerance
    }

    /// 1 if both point the same way, -1 if not.
    pub(super) fn sense(&self, other: &Self) -> f64 {
        1.0_f64.copysign(self.direction.dot(&other.direction))
    }

    /// Where the lines meet, if they do in one point but for `tolerance`.
    pub(super) fn meeting(&self, other: &Self, tolerance: f64) -> Option<Vector3<f64>> {
        let across = self.direction.cross(&other.direction);
        let squared = across.norm_squared();
        // Lines that are nearly parallel meet nowhere that could be told.
        if squared < 1e-3 {
            return None;
        }
        let between = other.point - self.point;
        let along = between.cross(&other.direction).dot(&across) / squared;
        let point = self.point + self.direction * along;
        (between.dot(&across).abs() < tolerance * squared.sqrt()).then_some(point)
    }

    /// True if the line goes through `point`.
    pub(super) fn contains(&self, point: &Vector3<f64>, tolerance: f64) -> bool {
        self.direction.cross(&(point - self.point)).norm() < tolerance
    }

    /// `vector` without what of it lies along the line.
    #[inline]
    pub(super) fn across(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        vector - self.direction * self.direction.dot(vector)
    }

    /// A unit vector across the line.
    pub(super) fn any_across(&self) -> Vector3<f64> {
        self.across(&Vector3::ith(self.direction.iamin(), 1.0)).normalize()
    }

    /// The joint seen from the other end of the arm: it turns the other way.
    pub(super) fn reversed(&self) -> Self {
        Self { direction: -self.direction, ..*self }
    }
}

/// The lines of `kinematics`, where every joint moves one link by as much as itself.
pub(super) fn of(kinematics: &Kinematics) -> Option<Vec<Screw>> {
    let links = &kinematics.links;
    let plain = |(index, link): (usize, &crate::robot::link::Link)| {
        link.joint == index && link.ratio.abs() == 1.0
    };
    if links.len() != kinematics.dof() || !links.iter().enumerate().all(plain) {
        return None;
    }
    let mut frames = LinkFrames::new(kinematics);
    kinematics.forward(&vec![0.0; kinematics.dof()], &mut frames);
    let screws = links.iter().zip(frames.axes()).map(|(link, (direction, point))| Screw {
        direction: (direction * link.ratio).normalize(),
        point,
        slides: link.slides,
    });
    Some(screws.collect())
}
