//! What makes a robot description valid.

use super::description::{
    DhRow, Joint, JointType, KinematicsDescription, KinematicsForm, LinkDescription,
};
use super::{Robot, RobotDescription};
use crate::fault::Faults;
use crate::geometry::Pose;

/// Longest name of a robot or a joint, in characters.
const MAX_NAME: usize = 64;
/// Beyond this a length is surely not in metres.
const MAX_LENGTH_M: f64 = 1000.0;
/// Offsets are angles of a drawing: beyond a few turns they are surely degrees.
const MAX_OFFSET_RAD: f64 = 8.0 * std::f64::consts::PI;
/// How far from 1 the norm of a quaternion may be.
const NORM_TOLERANCE: f64 = 1e-6;
/// The most links: every joint may be followed by one more.
const MAX_LINKS: usize = 2 * Robot::MAX_DOF;
/// Ratios of gears between joints are within these.
const MIN_RATIO: f64 = 1e-6;
const MAX_RATIO: f64 = 1e6;
/// Limits beyond this cannot be meant, and their powers would overflow.
const MAX_LIMIT: f64 = 1e12;
/// Limits below this would lead to durations beyond any use.
const MIN_LIMIT: f64 = 1e-9;

/// Finds every fault of `description`.
pub(super) fn check(description: &RobotDescription) -> Result<(), Faults> {
    let mut faults = Faults::default();
    check_name(&description.name, &mut faults);
    check_joints(&description.joints, &mut faults);
    if let Some(kinematics) = &description.kinematics {
        check_kinematics(kinematics, &description.joints, &mut faults);
    }
    faults.into_result(())
}

fn check_name(name: &str, faults: &mut Faults) {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_.-".contains(c);
    let well_formed = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(allowed)
        && name.len() <= MAX_NAME;
    if !well_formed {
        faults.add(
            "/name",
            format!(
                "name {name:?} must start with a letter a-z and go on with at most {} of a-z 0-9 _ . -",
                MAX_NAME - 1
            ),
        );
    }
}

fn check_joints(joints: &[Joint], faults: &mut Faults) {
    if joints.is_empty() || joints.len() > Robot::MAX_DOF {
        let count = joints.len();
        faults.add("/joints", format!("{count} joints, but must be 1 to {}", Robot::MAX_DOF));
        return;
    }
    for (index, joint) in joints.iter().enumerate() {
        let pointer = format!("/joints/{index}/name");
        let first = joints[..index].iter().position(|other| other.name == joint.name);
        if let Some(first) = first {
            let name = &joint.name;
            faults.add(pointer, format!("joint name {name:?} is taken by joint {first}"));
        } else {
            check_joint_name(&joint.name, pointer, faults);
        }
        check_limits(joint, &format!("/joints/{index}/limits"), faults);
    }
}

fn check_joint_name(name: &str, pointer: String, faults: &mut Faults) {
    if name.trim().is_empty() {
        faults.add(pointer, format!("joint name {name:?} must not be empty"));
    } else if name.chars().count() > MAX_NAME || name.chars().any(char::is_control) {
        let detail = format!(
            "joint name {name:?} must have at most {MAX_NAME} characters, none a control character"
        );
        faults.add(pointer, detail);
    }
}

fn check_limits(joint: &Joint, pointer: &str, faults: &mut Faults) {
    let limits = &joint.limits;
    let unit = joint.joint_type.position_unit();
    let effort_unit = if joint.joint_type == JointType::Prismatic { "N" } else { "N m" };
    for (name, value, unit) in [
        ("velocity", limits.velocity, format!("{unit}/s")),
        ("acceleration", limits.acceleration, format!("{unit}/s²")),
        ("jerk", limits.jerk, format!("{unit}/s³")),
        ("effort", limits.effort, effort_unit.to_owned()),
    ] {
        if let Some(problem) = value.and_then(rate_problem) {
            let joint = &joint.name;
            let value = value.unwrap_or_default();
            faults.add(
                format!("{pointer}/{name}"),
                format!("{name} limit {value} {unit} of joint {joint:?} {problem}"),
            );
        }
    }
    check_range(joint, pointer, faults);
}

/// What is wrong with the limit of a rate or of an effort.
fn rate_problem(value: f64) -> Option<String> {
    if !value.is_finite() {
        Some("must be a finite number; leave it out if there is none".to_owned())
    } else if value <= 0.0 {
        Some("must be positive; leave it out if it is unknown".to_owned())
    } else if !(MIN_LIMIT..=MAX_LIMIT).contains(&value) {
        Some(format!("must be from {MIN_LIMIT:e} to {MAX_LIMIT:e}"))
    } else {
        None
    }
}

fn check_range(joint: &Joint, pointer: &str, faults: &mut Faults) {
    let (name, unit) = (&joint.name, joint.joint_type.position_unit());
    let mut usable = true;
    for (side, value) in [("lower", joint.limits.lower), ("upper", joint.limits.upper)] {
        let Some(value) = value else { continue };
        let problem = if joint.joint_type == JointType::Continuous {
            "must be left out, for a continuous joint has no ends".to_owned()
        } else if !value.is_finite() {
            "must be a finite number; leave it out if there is none".to_owned()
        } else if value.abs() > MAX_LIMIT {
            format!("must be within ±{MAX_LIMIT:e}")
        } else {
            continue;
        };
        usable = false;
        let detail = format!("{side} limit {value} {unit} of joint {name:?} {problem}");
        faults.add(format!("{pointer}/{side}"), detail);
    }
    if let (true, Some(lower), Some(upper)) = (usable, joint.limits.lower, joint.limits.upper)
        && lower >= upper
    {
        faults.add(
            format!("{pointer}/lower"),
            format!(
                "lower limit {lower} {unit} of joint {name:?} must be below its upper limit {upper} {unit}"
            ),
        );
    }
}

fn check_kinematics(kinematics: &KinematicsDescription, joints: &[Joint], faults: &mut Faults) {
    match &kinematics.form {
        KinematicsForm::Rows { rows, .. } => check_rows(rows, joints, faults),
        KinematicsForm::Links(links) => check_links(links, joints, faults),
        // Read, and thereby checked, before.
        KinematicsForm::Urdf(_) => {}
    }
    check_pose(&kinematics.base, "/kinematics/base", "the base", faults);
    check_pose(&kinematics.tool, "/kinematics/tool", "the tool", faults);
}

fn check_rows(rows: &[DhRow], joints: &[Joint], faults: &mut Faults) {
    let (count, dof) = (rows.len(), joints.len());
    // Without joints the fault is there, not in the rows.
    if count != dof && dof > 0 {
        let detail = format!("{count} rows for {dof} joints, but must be one row per joint");
        faults.add("/kinematics/rows", detail);
    }
    for (index, (row, joint)) in rows.iter().zip(joints).enumerate() {
        check_row(row, &joint.name, &format!("/kinematics/rows/{index}"), faults);
    }
}

fn check_links(links: &[LinkDescription], joints: &[Joint], faults: &mut Faults) {
    if links.len() > MAX_LINKS {
        let detail = format!("{} links, but must be at most {MAX_LINKS}", links.len());
        return faults.add("/kinematics/links", detail);
    }
    for joint in joints {
        if !links.iter().any(|link| link.joint == joint.name) {
            let detail = format!("no link follows joint {:?}", joint.name);
            faults.add("/kinematics/links", detail);
        }
    }
    for (index, link) in links.iter().enumerate() {
        check_link(link, joints, &format!("/kinematics/links/{index}"), faults);
    }
}

fn check_link(link: &LinkDescription, joints: &[Joint], pointer: &str, faults: &mut Faults) {
    let name = &link.joint;
    if !joints.iter().any(|joint| joint.name == *name) {
        faults.add(format!("{pointer}/joint"), format!("there is no joint {name:?}"));
    }
    check_pose(
        &link.pose,
        &format!("{pointer}/pose"),
        &format!("the link of joint {name:?}"),
        faults,
    );
    let norm = link.axis.iter().map(|component| component * component).sum::<f64>().sqrt();
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        let detail = format!(
            "axis {:?} of joint {name:?} has norm {norm}, but must have norm 1 within {NORM_TOLERANCE:e}",
            link.axis
        );
        faults.add(format!("{pointer}/axis"), detail);
    }
    if !(MIN_RATIO..=MAX_RATIO).contains(&link.ratio.abs()) {
        let detail = format!(
            "ratio {} of joint {name:?} must be from {MIN_RATIO:e} to {MAX_RATIO:e} in magnitude",
            link.ratio
        );
        faults.add(format!("{pointer}/ratio"), detail);
    }
    if let Some(problem) = length_problem(link.offset) {
        let detail = format!("offset {} of joint {name:?} {problem}", link.offset);
        faults.add(format!("{pointer}/offset"), detail);
    }
}

fn check_row(row: &DhRow, joint: &str, pointer: &str, faults: &mut Faults) {
    for (name, value) in [("a", row.a), ("d", row.d)] {
        if let Some(problem) = length_problem(value) {
            let detail = format!("{name} {value} m of joint {joint:?} {problem}");
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
    for (name, value) in [("alpha", row.alpha), ("theta", row.theta)] {
        if !value.is_finite() || value.abs() > MAX_OFFSET_RAD {
            let detail = format!(
                "{name} {value} rad of joint {joint:?} must be a number within ±8π; are these degrees?"
            );
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
    if row.sign != 1.0 && row.sign != -1.0 {
        let detail = format!("sign {} of joint {joint:?} must be 1 or -1", row.sign);
        faults.add(format!("{pointer}/sign"), detail);
    }
}

/// What is wrong with a length in m.
fn length_problem(value: f64) -> Option<String> {
    if !value.is_finite() {
        Some("must be a finite number".to_owned())
    } else if value.abs() > MAX_LENGTH_M {
        Some(format!("must be within ±{MAX_LENGTH_M} m; are these millimetres?"))
    } else {
        None
    }
}

/// Adds what is wrong with a pose `of` something, which stands at `pointer`.
pub fn check_pose(pose: &Pose, pointer: &str, of: &str, faults: &mut Faults) {
    for (index, &value) in pose.position.iter().enumerate() {
        if let Some(problem) = length_problem(value) {
            faults.add(
                format!("{pointer}/position/{index}"),
                format!("position {value} m of {of} {problem}"),
            );
        }
    }
    let norm = pose.orientation.iter().map(|component| component * component).sum::<f64>().sqrt();
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        faults.add(
            format!("{pointer}/orientation"),
            format!(
                "quaternion {:?} of {of} has norm {norm}, but must have norm 1 within {NORM_TOLERANCE:e}",
                pose.orientation
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{DhConvention, JointLimits};

    fn valid() -> RobotDescription {
        let joint = |name: &str, joint_type| Joint {
            name: name.to_owned(),
            joint_type,
            limits: JointLimits { velocity: Some(1.0), ..JointLimits::default() },
            provenance: Default::default(),
        };
        RobotDescription {
            name: "arm-1".to_owned(),
            description: None,
            source: None,
            notes: Vec::new(),
            joints: vec![
                joint("turn", JointType::Revolute),
                joint("slide", JointType::Prismatic),
                joint("spin", JointType::Continuous),
            ],
            kinematics: Some(KinematicsDescription {
                form: KinematicsForm::Rows {
                    convention: DhConvention::StandardDh,
                    rows: vec![DhRow::default(); 3],
                },
                base: Pose::default(),
                tool: Pose::default(),
            }),
        }
    }

    fn faults_after(change: impl Fn(&mut RobotDescription)) -> Faults {
        let mut description = valid();
        change(&mut description);
        Robot::new(description).unwrap_err()
    }

    /// A change that breaks a description, the pointer and the words of its fault.
    type Case = (fn(&mut RobotDescription), &'static str, &'static [&'static str]);

    fn kinematics(description: &mut RobotDescription) -> &mut KinematicsDescription {
        description.kinematics.as_mut().unwrap()
    }

    fn rows(description: &mut RobotDescription) -> &mut Vec<DhRow> {
        let KinematicsForm::Rows { rows, .. } = &mut kinematics(description).form else {
            panic!("no rows")
        };
        rows
    }

    const BAD_JOINTS: &[Case] = &[
        (|d| d.name = String::new(), "/name", &["\"\"", "a-z"]),
        (|d| d.name = "Arm".into(), "/name", &["\"Arm\""]),
        (|d| d.name = "9arm".into(), "/name", &["\"9arm\"", "start with a letter"]),
        (|d| d.name = "an arm".into(), "/name", &["\"an arm\""]),
        (|d| d.name = "ärm".into(), "/name", &["\"ärm\""]),
        (|d| d.name = "a".repeat(65), "/name", &["at most 63"]),
        (|d| d.joints.clear(), "/joints", &["0 joints", "1 to 32"]),
        (|d| d.joints[1].name = " ".into(), "/joints/1/name", &["must not be empty"]),
        (|d| d.joints[1].name = "a\nb".into(), "/joints/1/name", &["control character"]),
        (|d| d.joints[1].name = "j".repeat(65), "/joints/1/name", &["at most 64"]),
        (|d| d.joints[2].name = "turn".into(), "/joints/2/name", &["\"turn\"", "joint 0"]),
        (
            |d| d.joints[2].limits.velocity = Some(0.0),
            "/joints/2/limits/velocity",
            &["velocity limit 0 rad/s", "\"spin\"", "positive"],
        ),
        (
            |d| d.joints[1].limits.velocity = Some(-2.5),
            "/joints/1/limits/velocity",
            &["-2.5 m/s ", "\"slide\"", "positive"],
        ),
        (
            |d| d.joints[0].limits.acceleration = Some(f64::NAN),
            "/joints/0/limits/acceleration",
            &["NaN rad/s²", "finite"],
        ),
        (
            |d| d.joints[0].limits.jerk = Some(f64::INFINITY),
            "/joints/0/limits/jerk",
            &["inf rad/s³", "finite"],
        ),
        (|d| d.joints[0].limits.jerk = Some(1e300), "/joints/0/limits/jerk", &["1e-9 to 1e12"]),
        (
            |d| d.joints[0].limits.velocity = Some(1e-300),
            "/joints/0/limits/velocity",
            &["1e-9 to 1e12"],
        ),
        (|d| d.joints[1].limits.effort = Some(-1.0), "/joints/1/limits/effort", &["-1 N "]),
        (
            |d| (d.joints[0].limits.lower, d.joints[0].limits.upper) = (Some(2.0), Some(1.5)),
            "/joints/0/limits/lower",
            &["2 rad", "\"turn\"", "1.5 rad"],
        ),
        (
            |d| (d.joints[1].limits.lower, d.joints[1].limits.upper) = (Some(1.0), Some(1.0)),
            "/joints/1/limits/lower",
            &["1 m of", "\"slide\"", "below"],
        ),
        (
            |d| d.joints[0].limits.upper = Some(f64::INFINITY),
            "/joints/0/limits/upper",
            &["upper limit inf rad", "finite"],
        ),
        (|d| d.joints[0].limits.lower = Some(-1e13), "/joints/0/limits/lower", &["±1e12"]),
        (
            |d| d.joints[2].limits.upper = Some(3.0),
            "/joints/2/limits/upper",
            &["3 rad", "\"spin\"", "continuous"],
        ),
    ];

    const BAD_KINEMATICS: &[Case] = &[
        (|d| rows(d).truncate(2), "/kinematics/rows", &["2 rows for 3 joints"]),
        (|d| rows(d)[1].sign = 0.5, "/kinematics/rows/1/sign", &["0.5", "\"slide\""]),
        (|d| rows(d)[1].sign = f64::NAN, "/kinematics/rows/1/sign", &["1 or -1"]),
        (|d| rows(d)[0].a = 1200.0, "/kinematics/rows/0/a", &["1200 m", "\"turn\"", "millimetres"]),
        (|d| rows(d)[0].d = f64::NAN, "/kinematics/rows/0/d", &["NaN", "finite"]),
        (|d| rows(d)[2].alpha = 90.0, "/kinematics/rows/2/alpha", &["90", "degrees"]),
        (|d| rows(d)[2].theta = f64::NAN, "/kinematics/rows/2/theta", &["NaN"]),
        (
            |d| kinematics(d).base.position[2] = 2e3,
            "/kinematics/base/position/2",
            &["2000 m", "base"],
        ),
        (
            |d| kinematics(d).tool.orientation = [0.0; 4],
            "/kinematics/tool/orientation",
            &["norm 0", "tool"],
        ),
        (
            |d| kinematics(d).tool.orientation[3] = 1.00001,
            "/kinematics/tool/orientation",
            &["norm 1.00001"],
        ),
        (
            |d| kinematics(d).base.orientation[0] = f64::NAN,
            "/kinematics/base/orientation",
            &["NaN"],
        ),
    ];

    #[test]
    fn the_unchanged_description_is_valid() {
        assert!(Robot::new(valid()).is_ok());
    }

    #[test]
    fn each_fault_is_found_where_it_is_and_named() {
        let cases = BAD_JOINTS.iter().chain(BAD_KINEMATICS);
        for (number, (change, pointer, words)) in cases.enumerate() {
            let faults = faults_after(change);
            assert_eq!(faults.0.len(), 1, "case {number}: {faults}");
            assert_eq!(faults.0[0].pointer, *pointer, "case {number}: {faults}");
            for word in *words {
                assert!(
                    faults.0[0].detail.contains(word),
                    "case {number}: no {word:?} in {faults}"
                );
            }
        }
    }

    #[test]
    fn more_joints_than_allowed_are_refused() {
        let mut description = valid();
        description.kinematics = None;
        let joint = description.joints[0].clone();
        let named = |index: usize| Joint { name: format!("j{index}"), ..joint.clone() };
        description.joints = (0..Robot::MAX_DOF).map(named).collect();
        assert!(Robot::new(description.clone()).is_ok());
        description.joints.push(named(Robot::MAX_DOF));
        let faults = Robot::new(description).unwrap_err();
        assert_eq!(faults.0[0].pointer, "/joints");
        assert!(faults.0[0].detail.contains("33 joints"), "{faults}");
    }

    #[test]
    fn all_faults_come_together() {
        let faults = faults_after(|d| {
            d.name = "?".into();
            d.joints[0].limits.velocity = Some(-1.0);
            d.joints[0].limits.jerk = Some(0.0);
            d.joints[2].limits.lower = Some(0.0);
            rows(d)[1].sign = 2.0;
            kinematics(d).tool.orientation[3] = 2.0;
        });
        let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(
            pointers,
            [
                "/name",
                "/joints/0/limits/velocity",
                "/joints/0/limits/jerk",
                "/joints/2/limits/lower",
                "/kinematics/rows/1/sign",
                "/kinematics/tool/orientation"
            ]
        );
    }
}
