//! Solids and where they are.

use super::{MessageForm, Place};
use crate::fault::Faults;
use crate::geometry::{Pose, Shape};
use crate::grpc::proto;
use crate::robot::Body;

message_form!(Body { link, name, shape: Required, pose: Defaulted, provenance });

impl MessageForm<proto::LinkPair> for [usize; 2] {
    fn into_message(self) -> proto::LinkPair {
        let [first, second] = self.map(MessageForm::into_message);
        proto::LinkPair { first, second }
    }

    fn from_message(message: proto::LinkPair, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::LinkPair { first, second } = message;
        [
            MessageForm::from_message(first, place.element(0), faults),
            MessageForm::from_message(second, place.element(1), faults),
        ]
    }
}

impl MessageForm<proto::Shape> for Shape {
    fn into_message(self) -> proto::Shape {
        use proto::shape::Kind;
        let kind = match self {
            Self::Sphere { radius } => Kind::Sphere(proto::SphereShape { radius }),
            Self::Capsule { radius, length } => {
                Kind::Capsule(proto::CapsuleShape { radius, length })
            }
            Self::Cylinder { radius, length } => {
                Kind::Cylinder(proto::CylinderShape { radius, length })
            }
            Self::Box { size } => Kind::Box(proto::BoxShape { size: size.to_vec() }),
            Self::ConvexHull { points } => {
                let point = |[x, y, z]: [f64; 3]| proto::Point { x, y, z };
                let points = points.into_iter().map(point).collect();
                Kind::ConvexHull(proto::ConvexHullShape { points })
            }
        };
        proto::Shape { kind: Some(kind) }
    }

    fn from_message(message: proto::Shape, place: Place<'_>, faults: &mut Faults) -> Self {
        use proto::shape::Kind;
        let mut number = |value, name| f64::from_message(value, place.field(name), faults);
        match message.kind {
            Some(Kind::Sphere(sphere)) => Self::Sphere { radius: number(sphere.radius, "radius") },
            Some(Kind::Capsule(capsule)) => Self::Capsule {
                radius: number(capsule.radius, "radius"),
                length: number(capsule.length, "length"),
            },
            Some(Kind::Cylinder(cylinder)) => Self::Cylinder {
                radius: number(cylinder.radius, "radius"),
                length: number(cylinder.length, "length"),
            },
            // Left out, a size is zero, which validation refuses.
            Some(Kind::Box(proto::BoxShape { size })) => {
                Self::Box { size: numbers(size, [0.0; 3], place.field("size"), faults) }
            }
            Some(Kind::ConvexHull(proto::ConvexHullShape { points })) => {
                let place = place.field("points");
                let points =
                    points.into_iter().enumerate().map(|(index, proto::Point { x, y, z })| {
                        numbers(vec![x, y, z], [0.0; 3], place.element(index), faults)
                    });
                Self::ConvexHull { points: points.collect() }
            }
            None => {
                place.fault(faults, "expected a sphere, capsule, cylinder, box or convex hull");
                Self::Sphere { radius: 1.0 }
            }
        }
    }
}

impl MessageForm<proto::Pose> for Pose {
    fn into_message(self) -> proto::Pose {
        let Self { position, orientation } = self;
        proto::Pose { position: position.to_vec(), orientation: orientation.to_vec() }
    }

    fn from_message(message: proto::Pose, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Pose { position, orientation } = message;
        let default = Self::default();
        Self {
            position: numbers(position, default.position, place.field("position"), faults),
            orientation: numbers(
                orientation,
                default.orientation,
                place.field("orientation"),
                faults,
            ),
        }
    }
}

/// `N` numbers, or none at all for the default.
fn numbers<const N: usize>(
    message: Vec<f64>,
    default: [f64; N],
    place: Place<'_>,
    faults: &mut Faults,
) -> [f64; N] {
    if message.is_empty() {
        return default;
    }
    let numbers = Vec::from_message(message, place, faults);
    numbers.try_into().unwrap_or_else(|numbers: Vec<f64>| {
        place.fault(faults, format!("{} numbers instead of {N}", numbers.len()));
        default
    })
}
