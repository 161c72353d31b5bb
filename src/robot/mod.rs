//! The robot: joints, their limits and where those come from, kinematics, and
//! a catalogue of known arms.
//!
//! A [`RobotDescription`] is what people write; [`Robot::new`] checks it once,
//! and what comes out never changes and needs no further checks.

pub mod catalogue;
mod description;
mod kinematics;
mod tool_motion;
mod validation;

pub use description::{
    DhConvention, DhRow, Joint, JointLimits, JointProvenance, JointType, KinematicsDescription,
    Provenance, RobotDescription,
};
pub use kinematics::{Jacobian, Kinematics, LinkFrames};
pub use tool_motion::JointRange;

use crate::fault::Faults;

/// A robot whose description was found valid; it never changes.
#[derive(Clone, Debug)]
pub struct Robot {
    description: RobotDescription,
    joint_names: Vec<String>,
    kinematics: Option<Kinematics>,
}

impl Robot {
    /// The most joints a robot may have.
    pub const MAX_DOF: usize = 32;

    /// Checks `description` and prepares its kinematics.
    ///
    /// # Errors
    ///
    /// All faults together, their pointers relative to the description.
    pub fn new(description: RobotDescription) -> Result<Self, Faults> {
        validation::check(&description)?;
        let joint_names = description.joints.iter().map(|joint| joint.name.clone()).collect();
        let kinematics = description
            .kinematics
            .as_ref()
            .map(|kinematics| Kinematics::new(kinematics, &description.joints));
        Ok(Self { description, joint_names, kinematics })
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// Number of joints, at least one.
    pub fn dof(&self) -> usize {
        self.description.joints.len()
    }

    /// The joints, from the base to the tool.
    pub fn joints(&self) -> &[Joint] {
        &self.description.joints
    }

    /// The joints' names, in the same order.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// The description the robot was built from.
    pub fn description(&self) -> &RobotDescription {
        &self.description
    }

    /// The kinematics, where the description has them.
    pub fn kinematics(&self) -> Option<&Kinematics> {
        self.kinematics.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::geometry::Pose;

    fn robot(value: serde_json::Value) -> Robot {
        Robot::new(serde_json::from_value(value).unwrap()).unwrap()
    }

    #[test]
    fn joints_alone_make_a_robot() {
        let robot = robot(json!({"joints": [
            {"name": "lift", "type": "prismatic"},
            {"name": "turn", "type": "continuous", "limits": {"velocity": 2}},
        ]}));
        assert_eq!(robot.name(), "unnamed");
        assert_eq!(robot.dof(), 2);
        assert_eq!(robot.joint_names(), ["lift", "turn"]);
        assert!(robot.kinematics().is_none());
        let units: Vec<_> = robot.joints().iter().map(|j| j.joint_type.position_unit()).collect();
        assert_eq!(units, ["m", "rad"]);
    }

    #[test]
    fn unknown_limits_are_written_as_null() {
        let robot = robot(json!({"name": "r", "joints": [{
            "name": "j", "type": "revolute", "limits": {"lower": -1, "velocity": null},
            "provenance": {"lower": "measured"},
        }]}));
        let written = serde_json::to_value(robot.description()).unwrap();
        assert_eq!(
            written,
            json!({"name": "r", "joints": [{
                "name": "j", "type": "revolute",
                "limits": {"lower": -1.0, "upper": null, "velocity": null,
                    "acceleration": null, "jerk": null, "effort": null},
                "provenance": {"lower": "measured"},
            }]})
        );
    }

    #[test]
    fn defaults_fill_what_kinematics_leave_out() {
        let robot = robot(json!({"joints": [{"name": "j", "type": "revolute"}],
            "kinematics": {"convention": "standard_dh", "rows": [{"d": 0.1}]}}));
        let kinematics = robot.description().kinematics.as_ref().unwrap();
        assert_eq!(kinematics.rows, [DhRow { d: 0.1, ..DhRow::default() }]);
        assert_eq!(kinematics.rows[0].sign, 1.0);
        assert_eq!((&kinematics.base, &kinematics.tool), (&Pose::default(), &Pose::default()));
    }

    /// The schema is what clients are generated from.
    #[test]
    fn the_schema_asks_for_joints_alone_and_knows_every_word() {
        let mut schemas = Vec::new();
        <RobotDescription as utoipa::ToSchema>::schemas(&mut schemas);
        let own = <RobotDescription as utoipa::PartialSchema>::schema();
        assert_eq!(serde_json::to_value(own).unwrap()["required"], json!(["joints"]));
        let named = |name: &str| {
            let (_, schema) = schemas.iter().find(|(found, _)| found == name).unwrap();
            serde_json::to_value(schema).unwrap()
        };
        assert_eq!(named("JointType")["enum"], json!(["revolute", "prismatic", "continuous"]));
        assert_eq!(named("Joint")["required"], json!(["name", "type"]));
        assert_eq!(named("Pose")["properties"]["orientation"]["maxItems"], 4);
    }

    #[test]
    fn unknown_fields_and_words_are_refused() {
        for (json, fault) in [
            (json!({"joints": [], "geometry": []}), "unknown field `geometry`"),
            (json!({"joints": [{"name": "j", "type": "screw"}]}), "unknown variant `screw`"),
            (
                json!({"joints": [{"name": "j", "type": "revolute", "limits": {"torque": 1}}]}),
                "unknown field `torque`",
            ),
            (
                json!({"joints": [{"name": "j", "type": "revolute",
                    "provenance": {"jerk": "rumour"}}]}),
                "unknown variant `rumour`",
            ),
            (
                json!({"joints": [], "kinematics": {"convention": "modified_dh",
                    "rows": [{"r": 1}]}}),
                "unknown field `r`",
            ),
        ] {
            let error = serde_json::from_value::<RobotDescription>(json).unwrap_err().to_string();
            assert!(error.contains(fault), "{error}");
        }
    }
}
