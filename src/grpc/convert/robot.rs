//! Robots.

use super::geometry::numbers;
use super::{Defaulted, MessageForm, Place};
use crate::fault::Faults;
use crate::geometry::Pose;
use crate::grpc::proto;
use crate::robot::{
    DhConvention, DhRow, Joint, JointLimits, JointProvenance, JointType, KinematicsDescription,
    KinematicsFields, KinematicsForm, LinkDescription, Provenance, RobotDescription,
};
use crate::service::{RobotOrigin, RobotPut, RobotSummary};

message_form!(RobotPut as PutRobotResponse { robot: Required, created });

message_form!(RobotSummary { name, origin, description, dof, joint_names, kinematics });

message_form!(JointLimits { lower, upper, velocity, acceleration, jerk, effort });

message_form!(JointProvenance { lower, upper, velocity, acceleration, jerk, effort });

message_enum!(RobotOrigin { Catalogue, Registered }, unspecified: None);

message_enum!(JointType { Revolute, Prismatic, Continuous }, unspecified: None);

message_enum!(DhConvention { ModifiedDh, StandardDh }, unspecified: None);

message_enum!(
    Provenance { Datasheet, Urdf, Paper, Measured, ThirdParty, Unconfirmed, Assumed, User },
    unspecified: None
);

/// Name of a robot that was given none, as in the JSON form.
const UNNAMED: &str = "unnamed";

impl MessageForm<proto::Robot> for RobotDescription {
    fn into_message(self) -> proto::Robot {
        let Self {
            name,
            description,
            source,
            notes,
            joints,
            kinematics,
            geometry,
            allowed_pairs,
            link_radius,
        } = self;
        proto::Robot {
            name,
            description,
            source,
            notes,
            joints: joints.into_message(),
            kinematics: kinematics.into_message(),
            geometry: geometry.into_message(),
            allowed_pairs: allowed_pairs.into_message(),
            link_radius,
        }
    }

    fn from_message(message: proto::Robot, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Robot {
            name,
            description,
            source,
            notes,
            joints,
            kinematics,
            geometry,
            allowed_pairs,
            link_radius,
        } = message;
        Self {
            name: if name.is_empty() { UNNAMED.to_owned() } else { name },
            description,
            source,
            notes,
            joints: MessageForm::from_message(joints, place.field("joints"), faults),
            kinematics: MessageForm::from_message(kinematics, place.field("kinematics"), faults),
            geometry: MessageForm::from_message(geometry, place.field("geometry"), faults),
            allowed_pairs: MessageForm::from_message(
                allowed_pairs,
                place.field("allowed_pairs"),
                faults,
            ),
            link_radius: MessageForm::from_message(link_radius, place.field("link_radius"), faults),
        }
    }
}

impl MessageForm<proto::Joint> for Joint {
    fn into_message(self) -> proto::Joint {
        let Self { name, joint_type, limits, provenance } = self;
        proto::Joint {
            name,
            r#type: joint_type.into_message(),
            limits: Some(limits.into_message()),
            provenance: Some(provenance.into_message()),
        }
    }

    fn from_message(message: proto::Joint, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Joint { name, r#type, limits, provenance } = message;
        let limits = limits.unwrap_or_default();
        let provenance = provenance.unwrap_or_default();
        Self {
            name,
            joint_type: MessageForm::from_message(r#type, place.field("type"), faults),
            limits: MessageForm::from_message(limits, place.field("limits"), faults),
            provenance: MessageForm::from_message(provenance, place.field("provenance"), faults),
        }
    }
}

impl MessageForm<proto::Kinematics> for KinematicsDescription {
    fn into_message(self) -> proto::Kinematics {
        let KinematicsFields {
            convention,
            rows,
            links,
            urdf,
            tip,
            base_link,
            srdf,
            joint_limits,
            base,
            tool,
        } = self.into();
        proto::Kinematics {
            convention: convention.map_or(0, DhConvention::into_message),
            rows: rows.unwrap_or_default().into_message(),
            base: Some(base.into_message()),
            tool: Some(tool.into_message()),
            links: links.unwrap_or_default().into_message(),
            urdf,
            tip,
            base_link,
            srdf,
            joint_limits,
        }
    }

    fn from_message(message: proto::Kinematics, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::Kinematics {
            convention,
            rows,
            base,
            tool,
            links,
            urdf,
            tip,
            base_link,
            srdf,
            joint_limits,
        } = message;
        let told = convention != i32::from(proto::DhConvention::Unspecified);
        let convention =
            told.then(|| DhConvention::from_message(convention, place.field("convention"), faults));
        let rows: Vec<DhRow> = MessageForm::from_message(rows, place.field("rows"), faults);
        let links: Vec<LinkDescription> =
            MessageForm::from_message(links, place.field("links"), faults);
        let Defaulted(base) = MessageForm::from_message(base, place.field("base"), faults);
        let Defaulted(tool) = MessageForm::from_message(tool, place.field("tool"), faults);
        let fields = KinematicsFields {
            // A list that is left out is empty.
            rows: (told || !rows.is_empty()).then_some(rows),
            links: (!links.is_empty()).then_some(links),
            convention,
            urdf,
            tip,
            base_link,
            srdf,
            joint_limits,
            base,
            tool,
        };
        Self::try_from(fields).unwrap_or_else(|problem| {
            place.fault(faults, problem);
            let form = KinematicsForm::Links(Vec::new());
            Self { form, base: Pose::default(), tool: Pose::default() }
        })
    }
}

impl MessageForm<proto::LinkDescription> for LinkDescription {
    fn into_message(self) -> proto::LinkDescription {
        let Self { name, joint, pose, axis, ratio, offset } = self;
        proto::LinkDescription {
            name,
            joint,
            pose: Some(pose.into_message()),
            axis: axis.to_vec(),
            ratio: Some(ratio),
            offset,
        }
    }

    fn from_message(
        message: proto::LinkDescription,
        place: Place<'_>,
        faults: &mut Faults,
    ) -> Self {
        let proto::LinkDescription { name, joint, pose, axis, ratio, offset } = message;
        let Defaulted(pose) = MessageForm::from_message(pose, place.field("pose"), faults);
        Self {
            name,
            joint,
            pose,
            axis: numbers(axis, Self::ALONG_Z, place.field("axis"), faults),
            ratio: f64::from_message(ratio.unwrap_or(1.0), place.field("ratio"), faults),
            offset: f64::from_message(offset, place.field("offset"), faults),
        }
    }
}

impl MessageForm<proto::DhRow> for DhRow {
    fn into_message(self) -> proto::DhRow {
        let Self { a, alpha, d, theta, sign } = self;
        proto::DhRow { a, alpha, d, theta, sign: Some(sign) }
    }

    fn from_message(message: proto::DhRow, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::DhRow { a, alpha, d, theta, sign } = message;
        let sign = sign.unwrap_or(Self::default().sign);
        let mut number = |value, name| f64::from_message(value, place.field(name), faults);
        Self {
            a: number(a, "a"),
            alpha: number(alpha, "alpha"),
            d: number(d, "d"),
            theta: number(theta, "theta"),
            sign: number(sign, "sign"),
        }
    }
}
