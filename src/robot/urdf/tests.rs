use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

use nalgebra::{Matrix4, Rotation3, Translation3, Unit, Vector3};
use serde_json::{Value, json};

use super::*;
use crate::geometry::Shape;
use crate::math::random::RandomStream;
use crate::robot::{JointType, LinkFrames, Robot, RobotDescription, catalogue};

/// A joint of a URDF: `xyz` and `rpy` of its origin, its axis.
type Origin = ([f64; 3], [f64; 3], [f64; 3]);

/// `xyz` and `rpy` of the tip in the last link.
type Tip = ([f64; 3], [f64; 3]);

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const NONE: [f64; 3] = [0.0; 3];
/// A right angle as UR's files have it, in rad.
const ROUNDED: f64 = 1_570_796_327e-9;
const ROLL: [f64; 3] = [FRAC_PI_2, 0.0, 0.0];
const ROLL_BACK: [f64; 3] = [-FRAC_PI_2, 0.0, 0.0];
const PITCH: [f64; 3] = [0.0, FRAC_PI_2, 0.0];

/// The joint origins and axes of four makers' descriptions, and the tip in the last link.
///
/// Sources: Universal_Robots_ROS2_Description, config/ur5e (from the frame `base`, digits as there);
/// franka_ros, panda_arm.xacro (to link8); kuka_experimental, kr6r900sixx_macro.xacro (to tool0); ros-industrial/abb,
/// irb120_3_58_macro.xacro (to tool0).
const ARMS: &[(&str, &[Origin], Tip)] = &[
    (
        "ur5e",
        &[
            ([0.0, 0.0, 0.1625], NONE, Z),
            (NONE, [ROUNDED, 0.0, 0.0], Z),
            ([-0.425, 0.0, 0.0], NONE, Z),
            ([-0.3922, 0.0, 0.1333], NONE, Z),
            ([0.0, -0.0997, -2.044881182297852e-11], [ROUNDED, 0.0, 0.0], Z),
            ([0.0, 0.0996, -2.042830148012698e-11], [ROUNDED - 4.10207e-10, PI, PI], Z),
        ],
        (NONE, NONE),
    ),
    (
        "franka_panda",
        &[
            ([0.0, 0.0, 0.333], NONE, Z),
            (NONE, ROLL_BACK, Z),
            ([0.0, -0.316, 0.0], ROLL, Z),
            ([0.0825, 0.0, 0.0], ROLL, Z),
            ([-0.0825, 0.384, 0.0], ROLL_BACK, Z),
            (NONE, ROLL, Z),
            ([0.088, 0.0, 0.0], ROLL, Z),
        ],
        ([0.0, 0.0, 0.107], NONE),
    ),
    (
        "kuka_kr6_r900_sixx",
        &[
            ([0.0, 0.0, 0.4], NONE, [0.0, 0.0, -1.0]),
            ([0.025, 0.0, 0.0], NONE, Y),
            ([0.455, 0.0, 0.0], NONE, Y),
            ([0.0, 0.0, 0.035], NONE, [-1.0, 0.0, 0.0]),
            ([0.42, 0.0, 0.0], NONE, Y),
            ([0.08, 0.0, 0.0], NONE, [-1.0, 0.0, 0.0]),
        ],
        (NONE, PITCH),
    ),
    (
        "abb_irb120",
        &[
            (NONE, NONE, Z),
            ([0.0, 0.0, 0.29], NONE, Y),
            ([0.0, 0.0, 0.27], NONE, Y),
            ([0.0, 0.0, 0.07], NONE, X),
            ([0.302, 0.0, 0.0], NONE, Y),
            ([0.072, 0.0, 0.0], NONE, X),
        ],
        (NONE, PITCH),
    ),
];

fn words([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

/// The URDF of an arm of revolute joints `j0`, `j1`, ... from `base` to `tip`.
fn urdf(joints: &[Origin], (xyz, rpy): Tip) -> String {
    let mut text =
        "<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n<link name=\"base\"/>\n".to_owned();
    let mut parent = "base".to_owned();
    for (index, (xyz, rpy, axis)) in joints.iter().enumerate() {
        let (xyz, rpy, axis) = (words(*xyz), words(*rpy), words(*axis));
        write!(
            text,
            "<link name=\"l{index}\"/>\n<joint name=\"j{index}\" type=\"revolute\"><parent link=\"{parent}\"/>\
             <child link=\"l{index}\"/><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"0\"/></joint>\n"
        )
        .unwrap();
        parent = format!("l{index}");
    }
    let (xyz, rpy) = (words(xyz), words(rpy));
    write!(
        text,
        "<link name=\"tip\"/>\n<joint name=\"end\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"tip\"/>\
         <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/></joint>\n</robot>\n"
    )
    .unwrap();
    text
}

/// The frames of an arm by plain matrix products, the tip last.
fn by_matrices(joints: &[Origin], tip: Tip, configuration: &[f64]) -> Vec<Matrix4<f64>> {
    let place = |xyz: [f64; 3], [r, p, y]: [f64; 3]| {
        Translation3::from(xyz).to_homogeneous()
            * Rotation3::from_euler_angles(r, p, y).to_homogeneous()
    };
    let mut frame = Matrix4::identity();
    let mut frames = Vec::new();
    for ((xyz, rpy, axis), &angle) in joints.iter().zip(configuration) {
        let axis = Unit::new_normalize(Vector3::from(*axis));
        frame =
            frame * place(*xyz, *rpy) * Rotation3::from_axis_angle(&axis, angle).to_homogeneous();
        frames.push(frame);
    }
    frames.push(frame * place(tip.0, tip.1));
    frames
}

fn matrix(transform: &Transform) -> Matrix4<f64> {
    let rotation = transform.rotation().to_homogeneous();
    Translation3::from(transform.origin).to_homogeneous() * rotation
}

fn robot(value: Value) -> Robot {
    Robot::new(serde_json::from_value(value).unwrap()).unwrap_or_else(|faults| panic!("{faults}"))
}

fn faults(value: Value) -> Faults {
    Robot::new(serde_json::from_value(value).unwrap()).unwrap_err()
}

#[test]
fn four_arms_stand_where_their_urdfs_put_them() {
    let mut random = RandomStream::new(11, 0);
    for (name, joints, tip) in ARMS {
        let robot = robot(json!({"kinematics": {"urdf": urdf(joints, *tip), "tip": "tip"}}));
        let kinematics = robot.kinematics().unwrap();
        let mut frames = LinkFrames::new(kinematics);
        let listed = catalogue::get(name).unwrap();
        for _ in 0..50 {
            let configuration: Vec<f64> =
                joints.iter().map(|_| random.uniform(-3.0, 3.0)).collect();
            kinematics.forward(&configuration, &mut frames);
            let expected = by_matrices(joints, *tip, &configuration);
            let found = frames.links().iter().chain([frames.tool()]);
            for (found, expected) in found.zip(&expected) {
                assert!((matrix(found) - expected).norm() < 1e-13, "{name}");
            }
            // The catalogue has rows, with right angles in full precision.
            let rows = listed.kinematics().unwrap().tool_transform(&configuration);
            assert!((matrix(&rows) - expected[joints.len()]).norm() < 1e-9, "{name} by its rows");
        }
    }
}

/// A lift with two fingers, one of which mimics the other, and a wheel beside the chain.
const LIFT: &str = r#"<?xml version="1.0"?>
<robot name="lift" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="grey"><color rgba="1 1 1 1"/></material>
  <link name="floor"><collision><geometry><box size="1 2 0.1"/></geometry></collision></link>
  <link name="base"><collision><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.1" length="1"/></geometry></collision></link>
  <joint name="anchor" type="fixed"><parent link="floor"/><child link="base"/><origin xyz="1 0 0.05"/></joint>
  <link name="carriage"><collision><geometry><mesh filename="package://lift/carriage.stl"/></geometry></collision></link>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="carriage"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.5" velocity="0.5" effort="0" acceleration="2" jerk="20"/>
  </joint>
  <link name="plate"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="mount" type="fixed"><parent link="carriage"/><child link="plate"/><origin xyz="0.3 0 0" rpy="0 0 1.5707963267948966"/></joint>
  <link name="arm"><collision><origin rpy="1.5707963267948966 0 0"/><geometry><capsule radius="0.02" length="0.3"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="plate"/><child link="arm"/><axis xyz="0 -1 0"/><limit velocity="3" effort="7"/></joint>
  <link name="head"/>
  <joint name="nod" type="revolute">
    <parent link="arm"/><child link="head"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <mimic joint="turn" multiplier="-0.5" offset="0.25"/><limit lower="-3" upper="3" velocity="1" effort="1"/>
  </joint>
  <link name="tool"/>
  <joint name="flange" type="fixed"><parent link="head"/><child link="tool"/><origin xyz="0 0 0.1"/></joint>
  <link name="wheel"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="spin" type="prismatic"><parent link="tool"/><child link="wheel"/><axis xyz="1 0 0"/><limit lower="0.02" upper="0.1"/></joint>
</robot>"#;

#[test]
fn joints_of_every_kind_become_a_chain() {
    let robot = robot(json!({"kinematics": {"urdf": LIFT, "tip": "tool"}}));
    assert_eq!(robot.joint_names(), ["lift", "turn"]);
    let [lift, turn] = robot.joints() else { panic!("two joints") };
    assert_eq!((lift.joint_type, turn.joint_type), (JointType::Prismatic, JointType::Continuous));
    let limits = &lift.limits;
    assert_eq!([limits.lower, limits.upper, limits.velocity], [Some(0.0), Some(1.5), Some(0.5)]);
    // Effort 0 is what is written where nobody knows.
    assert_eq!([limits.acceleration, limits.jerk, limits.effort], [Some(2.0), Some(20.0), None]);
    assert_eq!(lift.provenance.jerk, Some(Provenance::Urdf));
    assert_eq!(lift.provenance.effort, None);
    assert_eq!((turn.limits.lower, turn.limits.effort), (None, Some(7.0)));

    let (height, angle) = (0.7, 0.6);
    let tool = robot.kinematics().unwrap().tool_transform(&[height, angle]);
    let at = |x: f64, y: f64, z: f64| Translation3::new(x, y, z).to_homogeneous();
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle).to_homogeneous();
    let y = Vector3::y_axis();
    let expected = at(1.3, 0.0, 0.25 + height)
        * about(Vector3::z_axis(), FRAC_PI_2)
        * about(-y, angle)
        * at(0.4, 0.0, 0.0)
        * about(y, -0.5 * angle + 0.25)
        * at(0.0, 0.0, 0.1);
    assert!((matrix(&tool) - expected).norm() < 1e-14, "{tool:?}");
}

#[test]
fn the_jacobian_knows_joints_that_follow_others() {
    let robot = robot(json!({"kinematics": {"urdf": LIFT, "tip": "tool"}}));
    let kinematics = robot.kinematics().unwrap();
    let mut frames = LinkFrames::new(kinematics);
    let mut jacobian = crate::robot::Jacobian::new(2);
    kinematics.forward(&[0.3, 0.8], &mut frames);
    kinematics.jacobian(&frames, &mut jacobian);
    let step = 1e-6;
    let [before, after] =
        [0.8 - step, 0.8 + step].map(|turn| kinematics.tool_transform(&[0.3, turn]));
    let velocity = (after.origin - before.origin) / (2.0 * step);
    let turning = (after.x - before.x) / (2.0 * step);
    let column = jacobian.matrix().column(1);
    let (linear, angular) =
        (column.fixed_rows::<3>(0).into_owned(), column.fixed_rows::<3>(3).into_owned());
    assert!((linear - velocity).norm() < 1e-9);
    assert!((angular.cross(&frames.tool().x) - turning).norm() < 1e-9);
}

#[test]
fn the_chain_may_start_anywhere_and_end_in_a_tool_of_ones_own() {
    let whole = robot(json!({"kinematics": {"urdf": LIFT, "tip": "tool"}}));
    let part = robot(json!({"kinematics": {"urdf": LIFT, "tip": "head", "base_link": "base",
        "base": {"position": [1, 0, 0.05]}, "tool": {"position": [0, 0, 0.1]}}}));
    let [left, right] =
        [&whole, &part].map(|robot| robot.kinematics().unwrap().tool_transform(&[0.2, -0.4]));
    assert!((matrix(&left) - matrix(&right)).norm() < 1e-14);
}

#[test]
fn what_is_kept_needs_no_urdf_and_is_the_same_to_the_bit() {
    let (_, joints, tip) = ARMS[2];
    let robot =
        robot(json!({"name": "k", "kinematics": {"urdf": urdf(joints, tip), "tip": "tip"}}));
    let text = serde_json::to_string(robot.description()).unwrap();
    assert!(!text.contains("urdf\":\"<") && text.contains("\"links\""), "{text}");
    let back: RobotDescription = serde_json::from_str(&text).unwrap();
    assert_eq!(&back, robot.description());
    let again = Robot::new(back).unwrap();
    let configuration = [0.1, -0.7, 0.9, 1.1, -0.3, 2.0];
    let [left, right] =
        [&robot, &again].map(|robot| robot.kinematics().unwrap().tool_transform(&configuration));
    assert_eq!(left, right);
}

const YAML: &str = "
# MoveIt
default_velocity_scaling_factor: 0.1
joint_limits:
  lift:
    has_velocity_limits: true
    max_velocity: 0.4
    has_acceleration_limits: true
    max_acceleration: 1.25
    has_jerk_limits: false
    max_jerk: 99
  turn: {has_effort_limits: true, max_effort: 3.0, max_jerk: 50}
  finger: {max_velocity: 1}
";

#[test]
fn limits_come_from_the_urdf_then_moveit_then_the_description() {
    let robot = robot(json!({
        "joints": [{"name": "lift", "type": "prismatic", "limits": {"velocity": 0.3, "upper": 1.0},
            "provenance": {"velocity": "measured"}}],
        "kinematics": {"urdf": LIFT, "tip": "tool", "joint_limits": YAML},
    }));
    let [lift, turn] = robot.joints() else { panic!("two joints") };
    let limits = &lift.limits;
    assert_eq!([limits.lower, limits.upper, limits.velocity], [Some(0.0), Some(1.0), Some(0.3)]);
    assert_eq!([limits.acceleration, limits.jerk], [Some(1.25), Some(20.0)]);
    let from = &lift.provenance;
    assert_eq!([from.lower, from.upper], [Some(Provenance::Urdf), Some(Provenance::User)]);
    assert_eq!(
        [from.velocity, from.acceleration],
        [Some(Provenance::Measured), Some(Provenance::User)]
    );
    assert_eq!([turn.limits.effort, turn.limits.jerk], [Some(3.0), Some(50.0)]);
    assert!(robot.description().notes.iter().any(|note| note.contains("finger")));
}

#[test]
fn solids_move_with_the_links_they_are_fixed_to() {
    let source = UrdfSource {
        urdf: LIFT.to_owned(),
        tip: "tool".to_owned(),
        base_link: None,
        srdf: Some(
            r#"<robot name="lift"><group name="all"/>
            <disable_collisions link1="floor" link2="arm" reason="Never"/>
            <disable_collisions link1="arm" link2="plate" reason="Adjacent"/>
            <disable_collisions link1="wheel" link2="arm" reason="Never"/></robot>"#
                .to_owned(),
        ),
        joint_limits: None,
    };
    let robot = read(&source).unwrap();
    let found: Vec<_> =
        robot.geometry.iter().map(|(link, placed)| (*link, &placed.shape)).collect();
    let expected = [
        (0, &Shape::Box { size: [1.0, 2.0, 0.1] }),
        (0, &Shape::Cylinder { radius: 0.1, length: 1.0 }),
        (1, &Shape::Sphere { radius: 0.05 }),
        (2, &Shape::Capsule { radius: 0.02, length: 0.3 }),
        (3, &Shape::Sphere { radius: 0.01 }),
    ];
    assert_eq!(found, expected);
    let position = |index: usize| robot.geometry[index].1.pose.position;
    assert_eq!(position(1), [1.0, 0.0, 0.55]);
    assert_eq!(position(2), [0.3, 0.0, 0.0]);
    // The wheel's joint cannot stand at 0.
    assert_eq!(position(4), [0.02, 0.0, 0.1]);
    // The base has another solid beside the floor, which has to be checked against the arm.
    assert_eq!(robot.allowed_pairs, [[1, 2], [2, 3]]);
    let notes = robot.notes.join(" ");
    assert!(notes.contains("carriage (package://lift/carriage.stl)"), "{notes}");
    assert!(notes.contains("spin"), "{notes}");
}

#[test]
fn faults_tell_where_they_are() {
    let change = |from: &str, to: &str| {
        assert!(LIFT.contains(from), "{from}");
        json!({"urdf": LIFT.replacen(from, to, 1), "tip": "tool"})
    };
    let cases = [
        (change("</robot>", ""), "/urdf", "not a well-formed XML document"),
        (change("<robot name=\"lift\"", "<xacro:macro name=\"lift\""), "/urdf", "xacro"),
        (json!({"urdf": "", "tip": "tool"}), "/urdf", "XML"),
        (json!({"urdf": "<sdf/>", "tip": "tool"}), "/urdf", "<sdf>"),
        (json!({"urdf": "<robot/>", "tip": "tool"}), "/urdf", "no link"),
        (json!({"urdf": LIFT, "tip": "tool0"}), "/tip", "no link \"tool0\""),
        (json!({"urdf": LIFT, "tip": "floor"}), "/tip", "no joint moves"),
        (json!({"urdf": LIFT, "tip": "tool", "base_link": "wheel"}), "/tip", "does not hang"),
        (json!({"urdf": LIFT, "tip": "tool", "base_link": "x"}), "/base_link", "no link \"x\""),
        (change("<parent link=\"floor\"/>", "<parent link=\"tool\"/>"), "/urdf", "loop"),
        (
            change("<child link=\"plate\"/>", "<child link=\"base\"/>"),
            "/urdf",
            "both lead to link \"base\"",
        ),
        (
            change("<link name=\"floor\">", "<link name=\"lost\"/><link name=\"floor\">"),
            "/urdf",
            "\"lost\" and \"floor\"",
        ),
        (
            change("axis xyz=\"0 -1 0\"", "axis xyz=\"0 -2 0\""),
            "/urdf",
            "line 15: axis [0, -2, 0] of joint \"turn\" has length 2",
        ),
        (change("axis xyz=\"0 -1 0\"", "axis xyz=\"0 0 0\""), "/urdf", "length 0"),
        (change("axis xyz=\"0 -1 0\"", "axis xyz=\"0 nan 0\""), "/urdf", "three finite numbers"),
        (
            change("lower=\"0\" upper=\"1.5\"", "lower=\"2\" upper=\"1.5\""),
            "/urdf",
            "lower=2 of joint \"lift\"",
        ),
        (change("velocity=\"0.5\"", "velocity=\"-0.5\""), "/urdf", "velocity=-0.5"),
        (change("velocity=\"0.5\"", "velocity=\"fast\""), "/urdf", "line 10: velocity=\"fast\""),
        (change("type=\"continuous\"", "type=\"floating\""), "/urdf", "floating or planar"),
        (
            change("type=\"continuous\"", "type=\"spherical\""),
            "/urdf",
            "unknown type \"spherical\"",
        ),
        (change("mimic joint=\"turn\"", "mimic joint=\"nod\""), "/urdf", "mimics itself"),
        (
            change("mimic joint=\"turn\"", "mimic joint=\"twist\""),
            "/urdf",
            "\"twist\", which does not exist",
        ),
        (
            change("mimic joint=\"turn\"", "mimic joint=\"spin\""),
            "/urdf",
            "does not move the chain",
        ),
        (change("radius=\"0.05\"", "radius=\"0\""), "/urdf", "radius must be positive"),
        (change("<child link=\"arm\"/>", ""), "/urdf", "joint \"turn\" has no child"),
        (json!({"urdf": LIFT, "tip": "tool", "srdf": "<robot>"}), "/srdf", "XML"),
        (json!({"urdf": LIFT, "tip": "tool", "joint_limits": "a: [1"}), "/joint_limits", "YAML"),
        (
            json!({"urdf": LIFT, "tip": "tool", "joint_limits": "a: 1"}),
            "/joint_limits",
            "no mapping",
        ),
        (
            json!({"urdf": LIFT, "tip": "tool", "joint_limits": "joint_limits: {lift: {max_jerk: -1}}"}),
            "/joint_limits",
            "max_jerk \"-1\" of joint \"lift\"",
        ),
    ];
    for (kinematics, pointer, words) in cases {
        let faults = faults(json!({"kinematics": kinematics}));
        let place = format!("/kinematics{pointer}");
        let found = faults.0.iter().any(|f| f.pointer == place && f.detail.contains(words));
        assert!(found, "no {words:?} at {place} in {faults}");
    }
}

#[test]
fn joints_of_the_description_must_be_the_urdfs() {
    let faults = faults(json!({
        "joints": [{"name": "lift", "type": "revolute"}, {"name": "hop", "type": "prismatic"}],
        "kinematics": {"urdf": LIFT, "tip": "tool"},
    }));
    let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(pointers, ["/joints/0/type", "/joints/1/name"], "{faults}");
}

/// What would fill the memory of a careless reader ends in a fault.
#[test]
fn hostile_documents_are_refused() {
    let bomb = r#"<?xml version="1.0"?><!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]><robot name="&b;"/>"#;
    let deep = format!("<robot>{}{}</robot>", "<a>".repeat(50_000), "</a>".repeat(50_000));
    let wide = format!("<robot>{}</robot>", "<a/>".repeat(250_000));
    let long = format!("<robot>{}</robot>", " ".repeat(5 << 20));
    for (text, words) in [
        (bomb, "DTD"),
        (deep.as_str(), "no link"),
        (wide.as_str(), "nodes limit"),
        (long.as_str(), "bytes, but must be at most"),
    ] {
        let faults = faults(json!({"kinematics": {"urdf": text, "tip": "t"}}));
        assert!(faults.to_string().contains(words), "no {words:?} in {faults}");
    }
    let yaml = format!("a: &a [x]\nb: {}*a", "[".repeat(100));
    for text in [yaml.as_str(), "a: &a b\nc: *a"] {
        let faults =
            faults(json!({"kinematics": {"urdf": LIFT, "tip": "tool", "joint_limits": text}}));
        assert_eq!(faults.0[0].pointer, "/kinematics/joint_limits");
    }
}
