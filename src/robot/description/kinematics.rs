//! The kinematics of a robot as JSON: Denavit-Hartenberg rows, links, or a URDF.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::geometry::Pose;

/// Link lengths and frames, in one of three forms.
///
/// The world sees the tool at `base`, then the chain, then `tool`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "KinematicsFields", into = "KinematicsFields")]
pub struct KinematicsDescription {
    /// The chain.
    pub form: KinematicsForm,
    /// The base in the world.
    pub base: Pose,
    /// The tool in the frame of the last link.
    pub tool: Pose,
}

/// How a chain is written.
#[derive(Clone, Debug, PartialEq)]
pub enum KinematicsForm {
    /// Denavit-Hartenberg rows. Row i places the frame of joint i in the frame
    /// before it:
    /// - `modified_dh` (Craig): RotX(alpha) TransX(a) RotZ(theta) TransZ(d), so
    ///   joint i turns about the z axis of its own frame;
    /// - `standard_dh` (Denavit and Hartenberg): RotZ(theta) TransZ(d) TransX(a)
    ///   RotX(alpha), so joint i turns about the z axis of the frame before it.
    ///
    /// The joint's position times `sign` adds to theta, for a prismatic joint to d.
    Rows {
        /// How the rows are read.
        convention: DhConvention,
        /// One per joint.
        rows: Vec<DhRow>,
    },
    /// Links with poses and axes, as in a URDF.
    Links(Vec<LinkDescription>),
    /// A URDF, which becomes links when the robot is built.
    Urdf(UrdfSource),
}

/// The kinematics as they are written: `convention` and `rows`, or `links`, or `urdf` and `tip`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", default)]
pub struct KinematicsFields {
    /// How the rows are read; goes with `rows`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub convention: Option<DhConvention>,
    /// Denavit-Hartenberg rows, one per joint: the joint's position times `sign` adds to theta, for a
    /// prismatic joint to d.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<Vec<DhRow>>,
    /// Links with poses and axes, from the base to the tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub links: Option<Vec<LinkDescription>>,
    /// The text of a URDF. It is read when the robot is registered or first used; what is kept are its `links`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = "<robot name=\"arm\">...</robot>")]
    pub urdf: Option<String>,
    /// The URDF's link that the chain leads to.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = "tool0")]
    pub tip: Option<String>,
    /// The URDF's link that the chain starts from; default its root.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_link: Option<String>,
    /// The text of the URDF's SRDF: pairs of links that need no check against each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub srdf: Option<String>,
    /// The text of a MoveIt `joint_limits.yaml`; its limits replace the URDF's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_limits: Option<String>,
    /// The base in the world; default the identity.
    pub base: Pose,
    /// The tool in the frame of the last link; default the identity.
    pub tool: Pose,
}

/// A URDF and what comes with it, as texts.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfSource {
    /// The URDF.
    pub urdf: String,
    /// The link that the chain leads to.
    pub tip: String,
    /// The link that the chain starts from; by default the root.
    pub base_link: Option<String>,
    /// The SRDF.
    pub srdf: Option<String>,
    /// A MoveIt `joint_limits.yaml`.
    pub joint_limits: Option<String>,
}

/// A link and the joint that moves it.
///
/// With the joint's position `q`, the link's frame stands at `pose` in the frame of the link before, turned about
/// `axis` by `ratio * q + offset`, or for a prismatic joint moved along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct LinkDescription {
    /// Name; default that of the joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The joint that moves it, by name. Several links may follow the same joint.
    pub joint: String,
    /// In the frame of the link before with the joint at 0; default the identity.
    #[serde(default)]
    pub pose: Pose,
    /// Unit vector in the link's own frame; default z.
    #[serde(default = "along_z")]
    #[schema(min_items = 3, max_items = 3)]
    pub axis: [f64; 3],
    /// How far the link moves per unit of the joint's position; default 1.
    #[serde(default = "one")]
    pub ratio: f64,
    /// Where the link is with the joint at 0, rad or m; default 0.
    #[serde(default)]
    pub offset: f64,
}

impl LinkDescription {
    /// The axis if none is given.
    pub const ALONG_Z: [f64; 3] = [0.0, 0.0, 1.0];
}

fn along_z() -> [f64; 3] {
    LinkDescription::ALONG_Z
}

fn one() -> f64 {
    1.0
}

impl TryFrom<KinematicsFields> for KinematicsDescription {
    type Error = String;

    fn try_from(fields: KinematicsFields) -> Result<Self, String> {
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
        } = fields;
        let forms =
            [("rows", rows.is_some()), ("links", links.is_some()), ("urdf", urdf.is_some())];
        let given: Vec<_> = forms.iter().filter(|form| form.1).map(|form| form.0).collect();
        if let [first, second, ..] = given[..] {
            return Err(format!("`{first}` and `{second}` exclude each other"));
        }
        let misplaced = [
            ("convention", convention.is_some(), "rows"),
            ("tip", tip.is_some(), "urdf"),
            ("base_link", base_link.is_some(), "urdf"),
            ("srdf", srdf.is_some(), "urdf"),
            ("joint_limits", joint_limits.is_some(), "urdf"),
        ];
        if let Some((name, _, form)) =
            misplaced.iter().find(|(_, is_some, form)| *is_some && given != [*form])
        {
            return Err(if given.is_empty() {
                format!("missing field `{form}`")
            } else {
                format!("`{name}` goes with `{form}` only")
            });
        }
        let form = if let Some(rows) = rows {
            KinematicsForm::Rows {
                convention: convention.ok_or("missing field `convention`")?,
                rows,
            }
        } else if let Some(links) = links {
            KinematicsForm::Links(links)
        } else if let Some(urdf) = urdf {
            let tip = tip.ok_or("missing field `tip`")?;
            KinematicsForm::Urdf(UrdfSource { urdf, tip, base_link, srdf, joint_limits })
        } else {
            return Err("one of `rows`, `links` and `urdf` is needed".to_owned());
        };
        Ok(Self { form, base, tool })
    }
}

impl From<KinematicsDescription> for KinematicsFields {
    fn from(description: KinematicsDescription) -> Self {
        let KinematicsDescription { form, base, tool } = description;
        let fields = Self { base, tool, ..Self::default() };
        match form {
            KinematicsForm::Rows { convention, rows } => {
                Self { convention: Some(convention), rows: Some(rows), ..fields }
            }
            KinematicsForm::Links(links) => Self { links: Some(links), ..fields },
            KinematicsForm::Urdf(UrdfSource { urdf, tip, base_link, srdf, joint_limits }) => {
                Self { urdf: Some(urdf), tip: Some(tip), base_link, srdf, joint_limits, ..fields }
            }
        }
    }
}

/// How Denavit-Hartenberg rows are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum DhConvention {
    /// Craig's: RotX(alpha) TransX(a) RotZ(theta) TransZ(d).
    ModifiedDh,
    /// Denavit and Hartenberg's: RotZ(theta) TransZ(d) TransX(a) RotX(alpha).
    StandardDh,
}

/// One Denavit-Hartenberg row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case", default)]
pub struct DhRow {
    /// Distance along x, m; default 0.
    pub a: f64,
    /// Angle about x, rad; default 0.
    pub alpha: f64,
    /// Distance along z, m, for a prismatic joint at position 0; default 0.
    pub d: f64,
    /// Angle about z, rad, for a rotary joint at position 0; default 0.
    pub theta: f64,
    /// 1, or -1 if the joint counts the other way round; default 1.
    pub sign: f64,
}

impl Default for DhRow {
    fn default() -> Self {
        Self { a: 0.0, alpha: 0.0, d: 0.0, theta: 0.0, sign: 1.0 }
    }
}
