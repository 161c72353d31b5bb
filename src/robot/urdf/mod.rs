//! Robots from URDF, with SRDF and MoveIt's joint limits beside it.
//!
//! The chain from the base to the tip becomes links and joints; fixed joints fold into constants, and
//! what hangs on the chain becomes part of the link it moves with.
//!
//! The XML reader expands no entities and refuses document types, so a small document stays small.

mod chain;
mod collision;
mod document;
mod joint_limits;
mod srdf;
#[cfg(test)]
mod tests;
mod xml;

use super::description::{
    Body, Joint, JointLimits, JointProvenance, KinematicsForm, LinkDescription, Provenance,
    RobotDescription, UrdfSource,
};
use crate::fault::Faults;
use crate::geometry::{Placed, Pose, Transform};

/// What a URDF and the documents beside it say about the chain from its base to its tip.
#[derive(Clone, Debug)]
pub struct UrdfRobot {
    /// The joints that move the chain by themselves, in order.
    pub joints: Vec<Joint>,
    /// The links of the chain, one per joint and mimicking joint.
    pub links: Vec<LinkDescription>,
    /// The tip in the frame of the last link.
    pub tip: Pose,
    /// Solids by the link they move with: 0 is the base, i is link i - 1 of `links`. Poses are in the
    /// frame of that link, those of link 0 in the frame of the base link.
    pub geometry: Vec<(usize, Placed)>,
    /// Pairs of such links all of whose solids need no check against each other, by the SRDF.
    pub allowed_pairs: Vec<[usize; 2]>,
    /// What a user should know: what was left out or assumed.
    pub notes: Vec<String>,
}

/// Reads a URDF and what comes with it.
///
/// # Errors
///
/// All faults that can be told apart, their pointers relative to the kinematics (`/urdf`, `/tip`, ...) and with the
/// document's lines in their words.
pub fn read(source: &UrdfSource) -> Result<UrdfRobot, Faults> {
    let document = document::read(&source.urdf)?;
    let mut robot = chain::build(&document, source.base_link.as_deref(), &source.tip)?;
    let mut faults = Faults::default();
    if let Some(text) = &source.joint_limits {
        match joint_limits::read(text) {
            Ok(limits) => joint_limits::apply(&limits, &mut robot.robot, &mut faults),
            Err(error) => faults.add("/joint_limits", error),
        }
    }
    let disabled = match source.srdf.as_deref().map(srdf::read) {
        None => Vec::new(),
        Some(Ok(pairs)) => pairs,
        Some(Err(error)) => {
            faults.add("/srdf", error);
            Vec::new()
        }
    };
    collision::attach(&document, &mut robot, &disabled);
    faults.into_result(robot.robot)
}

/// `description` with its URDF, if it has one, turned into joints and links.
///
/// # Errors
///
/// Those of [`read`], and joints of the description that the URDF does not have.
pub(super) fn expand(mut description: RobotDescription) -> Result<RobotDescription, Faults> {
    let Some(kinematics) = &mut description.kinematics else { return Ok(description) };
    let KinematicsForm::Urdf(source) = &kinematics.form else { return Ok(description) };
    let mut faults = Faults::default();
    let mut robot = read(source).map_err(|found| {
        let mut faults = Faults::default();
        faults.add_below("/kinematics", found);
        faults
    })?;
    for (index, given) in description.joints.iter().enumerate() {
        match robot.joints.iter_mut().find(|joint| joint.name == given.name) {
            Some(joint) => override_joint(joint, given, index, &mut faults),
            None => faults.add(
                format!("/joints/{index}/name"),
                format!("the URDF has no movable joint {:?} between base and tip", given.name),
            ),
        }
    }
    let tool = Transform::from(&robot.tip) * Transform::from(&kinematics.tool);
    kinematics.tool = Pose::from(&tool);
    kinematics.form = KinematicsForm::Links(robot.links);
    description.joints = robot.joints;
    if description.geometry.is_empty() {
        description.geometry = robot.geometry.into_iter().map(body).collect();
    }
    description.allowed_pairs.extend(robot.allowed_pairs);
    description.notes.extend(robot.notes);
    faults.into_result(description)
}

fn body((link, Placed { shape, pose }): (usize, Placed)) -> Body {
    Body { link, name: None, shape, pose, provenance: Some(Provenance::Urdf) }
}

/// Takes over what `given`, joint `index` of the description, says about `joint`.
fn override_joint(joint: &mut Joint, given: &Joint, index: usize, faults: &mut Faults) {
    if given.joint_type != joint.joint_type {
        let (name, found) = (&given.name, joint.joint_type);
        let detail = format!("joint {name:?} is {found:?} in the URDF").to_lowercase();
        faults.add(format!("/joints/{index}/type"), detail);
    }
    let (JointLimits { lower, upper, velocity, acceleration, jerk, effort }, from) =
        (&given.limits, &given.provenance);
    let (limits, provenance) = (&mut joint.limits, &mut joint.provenance);
    for (value, from, into, provenance) in [
        (lower, from.lower, &mut limits.lower, &mut provenance.lower),
        (upper, from.upper, &mut limits.upper, &mut provenance.upper),
        (velocity, from.velocity, &mut limits.velocity, &mut provenance.velocity),
        (acceleration, from.acceleration, &mut limits.acceleration, &mut provenance.acceleration),
        (jerk, from.jerk, &mut limits.jerk, &mut provenance.jerk),
        (effort, from.effort, &mut limits.effort, &mut provenance.effort),
    ] {
        if value.is_some() {
            *into = *value;
            *provenance = from.or(Some(Provenance::User));
        }
    }
}

/// The provenance of limits that are known.
fn provenance(limits: &JointLimits, from: Provenance) -> JointProvenance {
    let known = |limit: Option<f64>| limit.map(|_| from);
    JointProvenance {
        lower: known(limits.lower),
        upper: known(limits.upper),
        velocity: known(limits.velocity),
        acceleration: known(limits.acceleration),
        jerk: known(limits.jerk),
        effort: known(limits.effort),
    }
}
