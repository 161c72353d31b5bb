//! The JSON form of a robot: what users send, store and read back.
//!
//! These types hold whatever parses; [`Robot::new`](super::Robot::new) checks
//! that it makes sense.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::{Pose, Shape};
mod kinematics;

pub use kinematics::{
    DhConvention, DhRow, KinematicsDescription, KinematicsFields, KinematicsForm, LinkDescription,
    UrdfSource,
};

/// A robot as JSON. Units are SI: m and rad, per joint type.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct RobotDescription {
    /// Name: 1 to 64 of `a-z 0-9 _ . -`, a letter first; default `unnamed`.
    #[serde(default = "unnamed")]
    #[schema(example = "my_arm")]
    pub name: String,
    /// What the robot is, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Where the figures come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// What a user should know before trusting the figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The joints, from the base to the tool; 1 to 32. With a URDF they come from there: those given here
    /// add to its limits and replace them, joint by joint, by name.
    #[serde(default)]
    #[schema(max_items = 32)]
    pub joints: Vec<Joint>,
    /// Link lengths and frames. Joint-space timing does without them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<KinematicsFields>)]
    pub kinematics: Option<KinematicsDescription>,
    /// What the robot consists of, for collision checks; needs kinematics.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub geometry: Vec<Body>,
    /// Pairs of links that may touch and are never checked, beside neighbours: a link and the next one that has a
    /// body.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed_pairs: Vec<[usize; 2]>,
    /// Where given, links that `geometry` has no body for get capsules of this radius along the lines that their
    /// Denavit-Hartenberg rows draw, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link_radius: Option<f64>,
}

/// A solid that moves with a link of the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Body {
    /// The link: 0 is the base, i the frame after joint i.
    #[schema(maximum = 32)]
    pub link: usize,
    /// What to call it in reports; default the link's name, `link_2`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The solid.
    pub shape: Shape,
    /// Of the solid's origin and axes in the link's frame; default the identity.
    #[serde(default)]
    pub pose: Pose,
    /// Where its measures come from; absent means not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
}

/// What reports and allowed pairs call link `link`: 0 is the base, i the frame after joint i.
pub fn link_name(link: usize) -> String {
    format!("link_{link}")
}

fn unnamed() -> String {
    "unnamed".to_owned()
}

/// One joint and what it can do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Joint {
    /// Name, unique within the robot.
    #[schema(min_length = 1)]
    pub name: String,
    /// How the joint moves.
    #[serde(rename = "type")]
    pub joint_type: JointType,
    /// What the joint can do; default nothing known.
    #[serde(default)]
    pub limits: JointLimits,
    /// Where each limit comes from.
    #[serde(default)]
    pub provenance: JointProvenance,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointType {
    /// Turns about its axis, position in rad.
    Revolute,
    /// Slides along its axis, position in m.
    Prismatic,
    /// Turns about its axis without end, position in rad.
    Continuous,
}

impl JointType {
    /// The unit of the joint's position, `rad` or `m`; its rates add `/s`,
    /// `/s²` and `/s³`.
    pub fn position_unit(self) -> &'static str {
        match self {
            Self::Revolute | Self::Continuous => "rad",
            Self::Prismatic => "m",
        }
    }
}

/// The limits of one joint. `null` means unknown: it is not enforced, and
/// certificates say so.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", default)]
pub struct JointLimits {
    /// Lowest position, rad or m.
    pub lower: Option<f64>,
    /// Highest position, rad or m.
    pub upper: Option<f64>,
    /// Highest speed in either direction, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Highest acceleration in either direction, rad/s² or m/s².
    pub acceleration: Option<f64>,
    /// Highest jerk in either direction, rad/s³ or m/s³.
    pub jerk: Option<f64>,
    /// Highest torque or force in either direction, N m or N.
    pub effort: Option<f64>,
}

/// Where each of a joint's limits comes from; absent means not told.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", default)]
pub struct JointProvenance {
    /// Of the lowest position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<Provenance>,
    /// Of the highest position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper: Option<Provenance>,
    /// Of the velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Provenance>,
    /// Of the acceleration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<Provenance>,
    /// Of the jerk.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk: Option<Provenance>,
    /// Of the effort.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Provenance>,
}

/// Where a limit comes from, and so how far to trust it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Provenance {
    /// The maker's data sheet or manual.
    Datasheet,
    /// A robot description (URDF) from the maker or ROS-Industrial.
    Urdf,
    /// A published paper.
    Paper,
    /// Measured on the machine.
    Measured,
    /// A collection kept by neither the maker nor the user.
    ThirdParty,
    /// Attributed to the maker, but not checked against a document.
    Unconfirmed,
    /// Chosen because nothing better is known.
    Assumed,
    /// Set by the user, for instance in a request.
    User,
}

impl Provenance {
    /// The name as JSON gives it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Datasheet => "datasheet",
            Self::Urdf => "urdf",
            Self::Paper => "paper",
            Self::Measured => "measured",
            Self::ThirdParty => "third_party",
            Self::Unconfirmed => "unconfirmed",
            Self::Assumed => "assumed",
            Self::User => "user",
        }
    }
}
