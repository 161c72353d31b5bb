//! The solids that a robot consists of, and which of them may touch.

use super::RobotDescription;
use nalgebra::{UnitQuaternion, Vector3};

use super::description::{
    Body, DhConvention, DhRow, Joint, JointType, KinematicsDescription, KinematicsForm, Provenance,
};
use crate::geometry::{Pose, Shape};

/// The bodies of a valid description: those given, then capsules along links without any, where
/// [`link_radius`](RobotDescription::link_radius) asks for them.
pub(super) fn bodies(description: &RobotDescription) -> Vec<Body> {
    let mut bodies = description.geometry.clone();
    if let (Some(radius), Some(kinematics)) = (description.link_radius, &description.kinematics) {
        let bare = |body: &Body| description.geometry.iter().all(|given| given.link != body.link);
        let capsules = capsules_along_links(kinematics, &description.joints, radius);
        bodies.extend(capsules.into_iter().filter(bare));
    }
    bodies
}

/// Capsules of `radius` (m) along the lines that the links draw, marked as assumed.
///
/// Of Denavit-Hartenberg rows a line along x (`a`) belongs to the link on whose side of the joint it is; one along z
/// (`d`) lies on the joint's axis, so that turning does not move it, and is given to the link beyond. `d` at a
/// prismatic joint, whose length changes, is left out. Of links with poses the line runs from one origin to the next.
/// Lines shorter than a tenth of the radius are hidden in their neighbours and left out.
pub fn capsules_along_links(
    kinematics: &KinematicsDescription,
    joints: &[Joint],
    radius: f64,
) -> Vec<Body> {
    let lines = match &kinematics.form {
        KinematicsForm::Rows { convention, rows } => lines_of_rows(*convention, rows, joints),
        KinematicsForm::Links(links) => links
            .iter()
            .enumerate()
            .map(|(index, link)| Line { link: index, from: [0.0; 3], to: link.pose.position })
            .collect(),
        // Robots are built from what the URDF was turned into.
        KinematicsForm::Urdf(_) => Vec::new(),
    };
    lines.iter().filter_map(|line| line.capsule(radius)).collect()
}

/// A line in the frame of a link, m.
struct Line {
    link: usize,
    from: [f64; 3],
    to: [f64; 3],
}

impl Line {
    /// A capsule of `radius` around it, unless it is too short to stick out of its neighbours.
    fn capsule(&self, radius: f64) -> Option<Body> {
        let (from, to) = (Vector3::from(self.from), Vector3::from(self.to));
        let length = (to - from).norm();
        if length < 0.1 * radius {
            return None;
        }
        // Half a turn about x where the line runs against z.
        let turn =
            UnitQuaternion::rotation_between(&Vector3::z(), &(to - from)).unwrap_or_else(|| {
                UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(0.0, 1.0, 0.0, 0.0))
            });
        Some(Body {
            link: self.link,
            name: None,
            shape: Shape::Capsule { radius, length },
            pose: Pose {
                position: (0.5 * (from + to)).into(),
                orientation: [turn.i, turn.j, turn.k, turn.w],
            },
            provenance: Some(Provenance::Assumed),
        })
    }
}

fn lines_of_rows(convention: DhConvention, rows: &[DhRow], joints: &[Joint]) -> Vec<Line> {
    let mut lines = Vec::with_capacity(2 * rows.len());
    let mut add = |link, from, to| lines.push(Line { link, from, to });
    for (index, (row, joint)) in rows.iter().zip(joints).enumerate() {
        let d = if joint.joint_type == JointType::Prismatic { 0.0 } else { row.d };
        match convention {
            DhConvention::ModifiedDh => {
                add(index, [0.0; 3], [row.a, 0.0, 0.0]);
                add(index + 1, [0.0; 3], [0.0, 0.0, -d]);
            }
            DhConvention::StandardDh => {
                // In the frame beyond, the joint's axis stands at -a, turned by -alpha about x.
                let (sin, cos) = libm::sincos(row.alpha);
                let corner = [-row.a, 0.0, 0.0];
                add(index + 1, corner, [-row.a, -d * sin, -d * cos]);
                add(index + 1, corner, [0.0; 3]);
            }
        }
    }
    lines
}

/// Every pair of links with bodies that has to be checked, the lower link first.
///
/// Left out are the pairs that the description allows to touch, and neighbours: a link and the next one that has a
/// body, for they meet in a joint.
pub(super) fn checked_pairs(description: &RobotDescription, bodies: &[Body]) -> Vec<[usize; 2]> {
    let mut links: Vec<usize> = bodies.iter().map(|body| body.link).collect();
    links.sort_unstable();
    links.dedup();
    let allowed = |a: usize, b: usize| {
        description.allowed_pairs.iter().any(|pair| *pair == [a, b] || *pair == [b, a])
    };
    let mut pairs = Vec::new();
    for (place, &first) in links.iter().enumerate() {
        for &second in links.iter().skip(place + 2) {
            if !allowed(first, second) {
                pairs.push([first, second]);
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use serde_json::json;

    use super::*;
    use crate::geometry::Transform;
    use crate::robot::{LinkFrames, Robot, catalogue};

    fn robot(value: serde_json::Value) -> Robot {
        Robot::new(serde_json::from_value(value).unwrap()).unwrap()
    }

    /// The ends of a capsule in the world.
    fn ends(robot: &Robot, body: &Body, configuration: &[f64]) -> [Vector3<f64>; 2] {
        let mut frames = LinkFrames::new(robot.kinematics().unwrap());
        robot.kinematics().unwrap().forward(configuration, &mut frames);
        let link = if body.link == 0 { *frames.base() } else { frames.links()[body.link - 1] };
        let Shape::Capsule { length, .. } = body.shape else { panic!("not a capsule") };
        let frame = link * Transform::from(&body.pose);
        [frame.origin - frame.z * (0.5 * length), frame.origin + frame.z * (0.5 * length)]
    }

    /// Each capsule has to begin where another ends, or pieces of the arm are missing.
    #[test]
    fn capsules_run_from_the_base_to_the_flange_in_both_conventions() {
        let modified = catalogue::get("ur5e").unwrap();
        let modified = modified.description();
        let quarter = std::f64::consts::FRAC_PI_2;
        let standard = json!({"convention": "standard_dh", "rows": [
            {"d": 0.1625, "alpha": quarter}, {"a": -0.425}, {"a": -0.3922},
            {"d": 0.1333, "alpha": quarter}, {"d": 0.0997, "alpha": -quarter}, {"d": 0.0996},
        ]});
        for kinematics in [serde_json::to_value(&modified.kinematics).unwrap(), standard] {
            let robot = robot(json!({
                "joints": modified.joints, "kinematics": kinematics, "link_radius": 0.05,
            }));
            assert_eq!(robot.bodies().len(), 6);
            for configuration in [[0.0; 6], [0.3, -1.0, 0.7, -0.4, 1.1, 2.0]] {
                let mut frames = LinkFrames::new(robot.kinematics().unwrap());
                robot.kinematics().unwrap().forward(&configuration, &mut frames);
                let capsules: Vec<_> =
                    robot.bodies().iter().map(|body| ends(&robot, body, &configuration)).collect();
                let touched = |point: &Vector3<f64>| {
                    capsules.iter().flatten().filter(|end| (*end - point).norm() < 1e-12).count()
                };
                assert_eq!(touched(&Vector3::zeros()), 1);
                assert_eq!(touched(&frames.tool().origin), 1);
                for end in capsules.iter().flatten() {
                    let outermost =
                        end.norm() < 1e-12 || (end - frames.tool().origin).norm() < 1e-12;
                    assert!(outermost || touched(end) == 2, "{end} is loose");
                }
            }
        }
    }

    #[test]
    fn links_with_bodies_of_their_own_get_no_capsules() {
        let robot = robot(json!({
            "joints": [{"name": "a", "type": "revolute"}, {"name": "b", "type": "revolute"}],
            "kinematics": {"convention": "modified_dh", "rows": [{}, {"a": 0.4}],
                "tool": {"position": [0.3, 0, 0]}},
            "geometry": [{"link": 2, "shape": {"type": "sphere", "radius": 0.1}}],
            "link_radius": 0.02,
        }));
        let links: Vec<_> = robot.bodies().iter().map(|body| body.link).collect();
        assert_eq!(links, [2, 1]);
    }

    #[test]
    fn neighbours_and_allowed_pairs_are_not_checked() {
        // Link 5 has no body, so 4 and 6 meet in the wrist.
        let rokae = catalogue::get("rokae_xb4").unwrap();
        assert_eq!(rokae.checked_pairs(), [[1, 3], [1, 4], [1, 6], [2, 6], [3, 6]]);
    }
}
