//! One link of a chain: what stands still, and what its joint moves.

use nalgebra::{Unit, Vector3};

use super::description::{DhConvention, DhRow, Joint, JointType, LinkDescription};
use crate::geometry::Transform;

/// A link as other kernels evaluate it.
///
/// With `q` the position of joint [`joint`](Self::joint), the link's frame is
///
/// ```text
/// world_from_link = world_from_link_before * before * RotZ(theta) TransZ(d) * after
/// ```
///
/// where `ratio * q` adds to `d` if the link [slides](Self::slides) and to `theta` if it turns.
#[derive(Clone, Debug)]
pub struct ChainLink {
    /// Constant, up to the joint: its z axis is the joint's.
    pub before: Transform,
    /// The joint that moves the link, by its index.
    pub joint: usize,
    /// True if it slides along z, m; false if it turns about z, rad.
    pub slides: bool,
    /// How far the link moves per unit of the joint's position; not zero.
    pub ratio: f64,
    /// Angle about z at position 0, rad.
    pub theta: f64,
    /// Distance along z at position 0, m.
    pub d: f64,
    /// Constant, from the joint to the link's own frame.
    pub after: Transform,
}

impl From<&Link> for ChainLink {
    fn from(link: &Link) -> Self {
        let Link { before, joint, slides, ratio, theta, d, after } = link;
        Self {
            before: before.transform(),
            joint: *joint,
            slides: *slides,
            ratio: *ratio,
            theta: *theta,
            d: *d,
            after: after.transform(),
        }
    }
}

/// [`ChainLink`] in the form that costs least to evaluate.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) before: Constant,
    pub(super) joint: usize,
    pub(super) slides: bool,
    pub(super) ratio: f64,
    theta: f64,
    pub(super) d: f64,
    pub(super) after: Constant,
}

/// A transform that no configuration changes.
///
/// A screw along x changes two axes and the origin, so it costs about a third of a general one; the
/// two Denavit-Hartenberg conventions need no more and differ in whether it comes before or after.
#[derive(Clone, Debug)]
pub(super) enum Constant {
    Identity,
    /// RotX(alpha) TransX(a); the two commute.
    ScrewX {
        a: f64,
        sin: f64,
        cos: f64,
    },
    Any(Transform),
}

impl Constant {
    /// How far it takes the origin, m.
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Identity => 0.0,
            Self::ScrewX { a, .. } => a.abs(),
            Self::Any(transform) => transform.origin.norm(),
        }
    }

    pub(super) fn transform(&self) -> Transform {
        let mut frame = Transform::IDENTITY;
        self.apply(&mut frame);
        frame
    }

    #[inline(always)]
    pub(super) fn apply(&self, frame: &mut Transform) {
        match self {
            Self::Identity => {}
            Self::ScrewX { a, sin, cos } => {
                let (y, z) = (frame.y, frame.z);
                frame.origin += frame.x * *a;
                frame.y = y * *cos + z * *sin;
                frame.z = z * *cos - y * *sin;
            }
            Self::Any(transform) => *frame = *frame * *transform,
        }
    }
}

impl From<Transform> for Constant {
    fn from(transform: Transform) -> Self {
        if transform == Transform::IDENTITY { Self::Identity } else { Self::Any(transform) }
    }
}

impl Link {
    /// The link of row `joint`.
    pub(super) fn from_row(
        convention: DhConvention,
        row: &DhRow,
        joint: usize,
        joint_type: JointType,
    ) -> Self {
        let (sin, cos) = libm::sincos(row.alpha);
        let screw = Constant::ScrewX { a: row.a, sin, cos };
        let (before, after) = match convention {
            DhConvention::ModifiedDh => (screw, Constant::Identity),
            DhConvention::StandardDh => (Constant::Identity, screw),
        };
        Self {
            before,
            joint,
            slides: joint_type == JointType::Prismatic,
            ratio: row.sign,
            theta: row.theta,
            d: row.d,
            after,
        }
    }

    /// The link that `link` describes; none if it names no joint of `joints`.
    pub(super) fn from_description(link: &LinkDescription, joints: &[Joint]) -> Option<Self> {
        let joint = joints.iter().position(|joint| joint.name == link.joint)?;
        let slides = joints[joint].joint_type == JointType::Prismatic;
        let (theta, d) = if slides { (0.0, link.offset) } else { (link.offset, 0.0) };
        let own = Transform::from(&link.pose);
        let still = |before: Constant, sense: f64, after: Constant| Self {
            before,
            joint,
            slides,
            ratio: sense * link.ratio,
            theta: sense * theta,
            d: sense * d,
            after,
        };
        let axis = Vector3::from(link.axis);
        Some(if axis.x == 0.0 && axis.y == 0.0 {
            still(own.into(), axis.z.signum(), Constant::Identity)
        } else {
            let turned = z_to(axis);
            still(Constant::Any(own * turned), 1.0, Constant::Any(turned.inverse()))
        })
    }

    /// The angle about z with the joints at `configuration`, rad.
    #[inline(always)]
    pub(super) fn angle(&self, configuration: &[f64]) -> f64 {
        if self.slides { self.theta } else { self.theta + self.ratio * configuration[self.joint] }
    }

    /// Takes `frame` from the link before to the joint.
    #[inline(always)]
    pub(super) fn enter(&self, frame: &mut Transform) {
        self.before.apply(frame);
    }

    /// Moves `frame` as the joint does; `(sin, cos)` are of [`angle`](Self::angle).
    #[inline(always)]
    pub(super) fn screw(
        &self,
        (sin, cos): (f64, f64),
        configuration: &[f64],
        frame: &mut Transform,
    ) {
        let travel = if self.slides { self.ratio * configuration[self.joint] } else { 0.0 };
        let (x, y) = (frame.x, frame.y);
        frame.origin += frame.z * (self.d + travel);
        frame.x = x * cos + y * sin;
        frame.y = y * cos - x * sin;
    }

    /// Takes `frame` from the joint to the link's own.
    #[inline(always)]
    pub(super) fn leave(&self, frame: &mut Transform) {
        self.after.apply(frame);
    }
}

/// A rotation that takes z to `axis`, which is not along z itself; of axes along x or y exact.
fn z_to(axis: Vector3<f64>) -> Transform {
    let z = Unit::new_normalize(axis).into_inner();
    // Of x, y and z the one that is furthest from the axis.
    let far = Vector3::ith(z.iamin(), 1.0);
    let x = Unit::new_normalize(far - z * z.dot(&far)).into_inner();
    Transform { x, y: z.cross(&x), z, origin: Vector3::zeros() }
}
