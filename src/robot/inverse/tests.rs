use std::f64::consts::{FRAC_PI_2, PI, TAU};

use serde_json::{Value, json};

use super::*;
use crate::robot::{KinematicsForm, catalogue};

fn robot(value: Value) -> Robot {
    Robot::new(serde_json::from_value(value).unwrap()).unwrap_or_else(|faults| panic!("{faults}"))
}

/// A robot of links: each joint's type, place in the link before and axis.
fn of_links(joints: &[(&str, [f64; 3], [f64; 3])]) -> Robot {
    let name = |index: usize| format!("j{index}");
    let described: Vec<_> = joints
        .iter()
        .enumerate()
        .map(|(index, (kind, ..))| json!({"name": name(index), "type": kind}))
        .collect();
    let links: Vec<_> = joints
        .iter()
        .enumerate()
        .map(|(index, (_, position, axis))| {
            json!({"joint": name(index), "pose": {"position": position}, "axis": axis})
        })
        .collect();
    robot(json!({"joints": described, "kinematics": {"links": links,
        "tool": {"position": [0.1, -0.05, 0.2], "orientation": [0.5, 0.5, -0.5, 0.5]}}}))
}

/// The same robot as far as its lines go, but without limits.
fn without_limits(robot: &Robot) -> Robot {
    let mut description = robot.description().clone();
    for joint in &mut description.joints {
        (joint.limits.lower, joint.limits.upper) = (None, None);
    }
    Robot::new(description).unwrap()
}

fn random_configuration(robot: &Robot, random: &mut RandomStream) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| &joint.limits);
    limits.map(|l| random.uniform(l.lower.unwrap_or(-3.0), l.upper.unwrap_or(3.0))).collect()
}

fn tool(robot: &Robot, joints: &[f64]) -> Transform {
    robot.kinematics().unwrap().tool_transform(joints)
}

/// All solutions nearest to the home position.
fn all(robot: &Robot, target: &Transform) -> Vec<Vec<f64>> {
    let inverse = robot.inverse().unwrap();
    let mut found = Solutions::new(inverse);
    inverse.all(target, &inverse.home(), &PoseError::TOLERANCE, &mut found);
    found.iter().map(|(joints, _)| joints.to_vec()).collect()
}

/// The nearest solution to `seed`.
fn nearest(robot: &Robot, target: &Transform, seed: &[f64]) -> Result<Vec<f64>, Box<Miss>> {
    let inverse = robot.inverse().unwrap();
    let mut found = Solutions::new(inverse);
    inverse.nearest(target, seed, &PoseError::TOLERANCE, &mut found)?;
    Ok(found.iter().next().unwrap().0.to_vec())
}

/// How far two configurations are apart, whole turns aside.
fn apart(robot: &Robot, left: &[f64], right: &[f64]) -> f64 {
    let ranges = &robot.inverse().unwrap().ranges;
    let differences = ranges.iter().zip(left.iter().zip(right)).map(|(range, (left, right))| {
        let difference = left - right;
        if range.turns { difference - TAU * (difference / TAU).round() } else { difference }
    });
    differences.fold(0.0, |most, difference| most.max(difference.abs()))
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const TURN: &str = "revolute";
const SLIDE: &str = "prismatic";

/// Robots beside the catalogue's, one for every way a closed form can go.
fn others() -> Vec<(&'static str, Robot)> {
    let oblique = [0.6, 0.0, 0.8];
    let wrist = [(TURN, [0.2, 0.0, 0.0], X), (TURN, [0.3, 0.0, 0.0], Y), (TURN, [0.0; 3], X)];
    // Every offset an elbow arm can have, and axes that count the other way.
    let offsets = [
        (TURN, [0.1, 0.05, 0.3], Z),
        (TURN, [0.06, 0.07, 0.2], Y),
        (TURN, [0.02, -0.04, 0.5], [0.0, -1.0, 0.0]),
    ];
    // Joints 1 and 2 meet, not at a right angle; joint 3 is oblique.
    let meeting =
        [(TURN, [0.0, 0.0, 0.4], Z), (TURN, [0.0; 3], oblique), (TURN, [0.4, 0.1, 0.2], Y)];
    let slides = [(SLIDE, [0.0; 3], X), (SLIDE, [0.0; 3], oblique), (SLIDE, [0.0; 3], Y)];
    let seven = [
        (TURN, [0.0, 0.0, 0.34], Z),
        (TURN, [0.0; 3], Y),
        (TURN, [0.0, 0.0, 0.4], Z),
        (TURN, [0.0; 3], [0.0, -1.0, 0.0]),
        (TURN, [0.0, 0.0, 0.4], Z),
        (TURN, [0.0; 3], Y),
        (TURN, [0.0, 0.0, 0.1], Z),
    ];
    let shoulder: Vec<_> =
        seven[..3].iter().copied().chain([seven[3], seven[4], seven[5]]).collect();
    let rail = [&[(SLIDE, [0.0; 3], Y)], &offsets[..], &wrist].concat();
    let planar = [
        (TURN, [0.1, 0.0, 0.0], X),
        (TURN, [0.0, 0.4, 0.0], [-1.0, 0.0, 0.0]),
        (SLIDE, [0.0; 3], [-1.0, 0.0, 0.0]),
        (TURN, [0.05, 0.3, 0.1], [-1.0, 0.0, 0.0]),
    ];
    let crooked = [
        (TURN, [0.0, 0.0, 0.3], Z),
        (TURN, [0.1, 0.0, 0.1], Y),
        (TURN, [0.0, 0.1, 0.4], X),
        (TURN, [0.1, 0.0, 0.2], Z),
        (TURN, [0.0, 0.05, 0.2], Y),
        (TURN, [0.1, 0.0, 0.1], X),
    ];
    vec![
        ("spherical_wrist", of_links(&[offsets, wrist].concat())),
        ("spherical_wrist", of_links(&[meeting, wrist].concat())),
        ("spherical_shoulder", of_links(&shoulder)),
        ("redundant", of_links(&seven)),
        ("redundant", of_links(&rail)),
        ("scara", of_links(&planar)),
        ("gantry", of_links(&[&slides[..], &wrist[..]].concat())),
        ("gantry", of_links(&[&slides[..2], &wrist[..1]].concat())),
        ("numeric", of_links(&crooked)),
        ("numeric", of_links(&crooked[..5])),
        ("numeric", of_links(&[&seven[..], &crooked[..2]].concat())),
    ]
}

#[test]
fn kinds_follow_from_the_lines() {
    for robot in catalogue::all() {
        let expected = match robot.name() {
            "aubo_i5" | "ur5e" | "ur10e" => "three_parallel_axes",
            "franka_panda" => "redundant",
            "adept_cobra_s600" | "epson_t3_401s" => "scara",
            "woodworking_pprr" => "gantry",
            _ => "spherical_wrist",
        };
        assert_eq!(robot.inverse().unwrap().kind(), expected, "{}", robot.name());
    }
    for (kind, robot) in others() {
        assert_eq!(robot.inverse().unwrap().kind(), kind);
    }
}

#[track_caller]
fn assert_reaches(robot: &Robot, poses: usize, accuracy: f64) {
    let inverse = robot.inverse().unwrap();
    let mut random = RandomStream::new(5, 0);
    let mut found = Solutions::new(inverse);
    let home = inverse.home();
    for _ in 0..poses {
        let joints = random_configuration(robot, &mut random);
        let target = tool(robot, &joints);
        let reached = inverse.nearest(&target, &home, &PoseError::TOLERANCE, &mut found);
        assert!(reached.is_ok(), "{} at {joints:?}: {reached:?}", robot.name());
        let (solution, error) = found.iter().next().unwrap();
        let by_itself = PoseError::between(&tool(robot, solution), &target);
        assert!(by_itself.largest() < accuracy, "{} at {joints:?}: {error:?}", robot.name());
        for (joint, position) in robot.joints().iter().zip(solution) {
            assert!(joint.limits.lower.is_none_or(|lower| *position >= lower));
            assert!(joint.limits.upper.is_none_or(|upper| *position <= upper));
        }
    }
}

#[test]
fn every_reachable_pose_is_reached_within_the_limits() {
    for robot in catalogue::all() {
        let accuracy = if robot.name() == "franka_panda" { 1e-10 } else { 1e-12 };
        assert_reaches(robot, 1000, accuracy);
    }
}

#[test]
fn every_reachable_pose_of_other_kinds_is_reached() {
    for (_, robot) in others() {
        assert_reaches(&robot, 50, 2e-10);
    }
}

/// A search from many starts finds nothing that the closed form does not list.
#[test]
fn no_branch_is_missing() {
    let listed = catalogue::all().iter().map(|robot| without_limits(robot));
    let robots = listed.chain(others().into_iter().map(|(_, robot)| robot));
    for robot in robots.filter(|robot| robot.inverse().unwrap().is_complete()) {
        let inverse = robot.inverse().unwrap();
        let mut random = RandomStream::new(6, 1);
        let mut scratch = Scratch::new(&inverse.kinematics);
        for _ in 0..20 {
            let joints = random_configuration(&robot, &mut random);
            let target = tool(&robot, &joints);
            let branches = all(&robot, &target);
            let listed =
                |joints: &[f64]| branches.iter().any(|branch| apart(&robot, branch, joints) < 1e-5);
            assert!(listed(&joints), "{}: {joints:?} not in {branches:?}", robot.name());
            assert!(branches.len() <= 8);
            for _ in 0..20 {
                let mut joints = random_configuration(&robot, &mut random);
                let InverseKinematics { kinematics, ranges, .. } = inverse;
                let error =
                    numeric::descend(kinematics, ranges, &target, &mut joints, &mut scratch, None);
                assert!(error > 1e-10 || listed(&joints), "{}: {joints:?}", robot.name());
            }
        }
    }
}

/// Makers measure where the lines of an arm really are: a little beside the drawing.
#[test]
fn measured_arms_are_solved_like_their_drawings() {
    let mut random = RandomStream::new(9, 0);
    for name in ["ur5e", "kuka_kr6_r900_sixx", "franka_panda"] {
        let drawn = catalogue::get(name).unwrap();
        let mut description = drawn.description().clone();
        let Some(kinematics) = &mut description.kinematics else { panic!("kinematics") };
        let KinematicsForm::Rows { rows, .. } = &mut kinematics.form else { panic!("rows") };
        for row in rows {
            row.a += random.uniform(-1e-3, 1e-3);
            row.alpha += random.uniform(-1e-3, 1e-3);
            row.d += random.uniform(-1e-3, 1e-3);
        }
        let measured = Robot::new(description).unwrap();
        let inverse = measured.inverse().unwrap();
        assert_eq!(inverse.kind(), drawn.inverse().unwrap().kind());
        assert!(!inverse.is_complete());
        assert_reaches(&measured, 300, 2e-10);
        let listed = (0..100).filter(|_| {
            let joints = random_configuration(&measured, &mut random);
            let branches = all(&measured, &tool(&measured, &joints));
            branches.iter().any(|branch| apart(&measured, branch, &joints) < 1e-6)
        });
        let count = listed.count();
        assert!(name == "franka_panda" || count >= 97, "{name}: {count} of 100 branches");
    }
}

#[test]
fn a_free_joint_takes_the_seeds_place() {
    // The wrist stretched: only the sum of joints 4 and 6 is determined.
    let rokae = catalogue::get("rokae_xb4").unwrap();
    let joints = [0.3, 0.4, -0.5, 0.7, 0.0, -0.2];
    let solution =
        nearest(&rokae, &tool(&rokae, &joints), &[0.0, 0.0, 0.0, 0.25, 0.0, 0.0]).unwrap();
    assert!((solution[3] - 0.25).abs() < 1e-9 && (solution[3] + solution[5] - 0.5).abs() < 1e-9);
    // Nothing jumps on the way through.
    let mut before = joints.to_vec();
    before[4] = -1e-3;
    for step in -10..=10 {
        let bend = f64::from(step) * 1e-4 + 3e-12;
        let target = tool(&rokae, &[0.3, 0.4, -0.5, 0.7, bend, -0.2]);
        let solution = nearest(&rokae, &target, &before).unwrap();
        assert!(apart(&rokae, &solution, &before) < 2e-3, "{solution:?} after {before:?}");
        before = solution;
    }
    // The wrist's centre above the base: joint 1 may be anywhere.
    let ur = catalogue::get("abb_irb120").unwrap();
    let above = [0.4, -0.1, f64::NAN, 0.2, 0.5, -0.6];
    let elbow = centred_elbow(&ur, above);
    let joints = [above[0], above[1], elbow, above[3], above[4], above[5]];
    let seed = [1.1, -0.1, elbow, 0.2, 0.5, -0.6];
    let solution = nearest(&ur, &tool(&ur, &joints), &seed).unwrap();
    assert!((solution[0] - 1.1).abs() < 1e-9, "{solution:?}");
}

/// A stretched wrist of a UR leaves joint 6 free, but not every position of it leaves the elbow within reach, and a
/// limit may exclude the seed's.
#[test]
fn a_free_joint_moves_where_the_seed_leads_nowhere() {
    let mut random = RandomStream::new(12, 0);
    for name in ["ur5e", "aubo_i5", "rokae_xb4"] {
        let robot = catalogue::get(name).unwrap();
        for _ in 0..300 {
            let mut joints = random_configuration(&robot, &mut random);
            joints[4] = 0.0;
            let target = tool(&robot, &joints);
            let solution = nearest(&robot, &target, &robot.inverse().unwrap().home());
            let solution = solution.unwrap_or_else(|miss| panic!("{name} at {joints:?}: {miss:?}"));
            let error = PoseError::between(&tool(&robot, &solution), &target);
            assert!(error.largest() < 1e-9, "{name} at {joints:?}: {error:?}");
        }
    }
}

/// The elbow that puts the wrist's centre on the axis of joint 1.
fn centred_elbow(robot: &Robot, mut joints: [f64; 6]) -> f64 {
    let mut frames = crate::robot::LinkFrames::new(robot.kinematics().unwrap());
    let mut radius = |elbow: f64| {
        joints[2] = elbow;
        robot.kinematics().unwrap().forward(&joints, &mut frames);
        let centre = frames.links()[4].origin;
        centre.x * joints[0].cos() + centre.y * joints[0].sin()
    };
    let (mut low, mut high) = (-1.9, 0.0);
    assert!(radius(low) * radius(high) < 0.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if radius(low) * radius(middle) <= 0.0 { high = middle } else { low = middle }
    }
    low
}

#[test]
fn whole_turns_bring_a_solution_near_the_seed() {
    let ur = catalogue::get("ur5e").unwrap();
    let joints = [0.3, -1.2, 1.4, -0.9, -1.5, 0.6];
    let turned = [0.3 - TAU, -1.2, 1.4, -0.9 + TAU, -1.5, 0.6 - TAU];
    let solution = nearest(&ur, &tool(&ur, &joints), &turned).unwrap();
    for (found, expected) in solution.iter().zip(turned) {
        assert!((found - expected).abs() < 1e-9, "{solution:?}");
    }
    let inverse = ur.inverse().unwrap();
    let same: Vec<f64> = inverse.same_positions(0, 0.3).collect();
    assert_eq!(same.len(), 2);
    assert!((same[0] - (0.3 - TAU)).abs() < 1e-15 && same[1] == 0.3);
    assert_eq!(inverse.same_positions(2, 0.3).collect::<Vec<_>>(), [0.3]);
}

#[test]
fn eight_branches_of_an_arm_in_the_open() {
    let ur = without_limits(&catalogue::get("ur5e").unwrap());
    assert_eq!(all(&ur, &tool(&ur, &[0.3, -1.2, 1.4, -0.9, -1.5, 0.6])).len(), 8);
    let scara = catalogue::get("epson_t3_401s").unwrap();
    assert_eq!(all(&scara, &tool(&scara, &[0.3, 1.2, -0.1, 0.5])).len(), 2);
}

#[test]
fn a_limit_in_the_way_is_named() {
    // The tool at the back, beyond the turn of joint 1, and the arm overhead not long enough.
    let kuka = without_limits(&catalogue::get("kuka_kr6_r900_sixx").unwrap());
    let mut description = kuka.description().clone();
    (description.joints[0].limits.lower, description.joints[0].limits.upper) =
        (Some(-1.0), Some(1.0));
    (description.joints[1].limits.lower, description.joints[1].limits.upper) =
        (Some(-1.0), Some(0.5));
    let narrow = Robot::new(description).unwrap();
    let target = tool(&kuka, &[1.2, -0.4, 0.8, 0.3, 0.7, 0.1]);
    let miss = nearest(&narrow, &target, &narrow.inverse().unwrap().home()).unwrap_err();
    let limit = miss.limit.unwrap();
    assert_eq!((limit.joint, limit.limit), (0, 1.0));
    assert!((limit.position - 1.2).abs() < 1e-9, "{limit:?}");
    assert!(miss.error.largest() > 0.01 && miss.error.largest() < 0.3, "{miss:?}");
    assert!(miss.configuration[0] <= 1.0);
}

#[test]
fn what_is_out_of_reach_tells_by_how_much() {
    let ur = catalogue::get("ur5e").unwrap();
    let mut target = tool(&ur, &[0.0, -0.5, 0.0, 0.2, -FRAC_PI_2, 0.0]);
    let outwards =
        Vector3::new(target.origin.x, target.origin.y, target.origin.z - 0.1625).normalize();
    target.origin += outwards * 0.4;
    let miss = nearest(&ur, &target, &[0.0, -0.5, 0.0, 0.2, -FRAC_PI_2, 0.0]).unwrap_err();
    assert_eq!(miss.limit, None);
    assert!((0.05..0.4).contains(&miss.error.position), "{miss:?}");
    // Not even nearer when asked again elsewhere: it is the nearest there is.
    let again = nearest(&ur, &target, &[0.1, -0.6, 0.1, 0.3, -1.4, 0.2]).unwrap_err();
    assert!((again.error.position - miss.error.position).abs() < 1e-6);
    // A SCARA cannot tilt its tool.
    let scara = catalogue::get("epson_t3_401s").unwrap();
    let upright = tool(&scara, &[0.3, 0.8, -0.1, 0.5]);
    let tilted = upright * Transform::about(&Vector3::x(), libm::sincos(0.2));
    let miss = nearest(&scara, &tilted, &[0.0; 4]).unwrap_err();
    assert!((miss.error.orientation - 0.2).abs() < 1e-6 && miss.error.position < 1e-6, "{miss:?}");
    // But what few digits tilt is within the tolerance.
    let rounded = upright * Transform::about(&Vector3::x(), libm::sincos(2e-4));
    assert!(nearest(&scara, &rounded, &[0.0; 4]).is_ok());
}

#[test]
fn errors_of_poses_are_offsets_and_angles() {
    for angle in [0.0, 1e-9, 0.3, 2.0, PI - 1e-7, PI] {
        for axis in [Vector3::x(), Vector3::new(0.6, 0.0, -0.8), Vector3::new(2.0, -1.0, 2.0) / 3.0]
        {
            let turned = Transform::about(&axis, libm::sincos(angle));
            let target = Transform { origin: Vector3::new(0.0, 0.3, -0.4), ..turned };
            let error = PoseError::between(&Transform::IDENTITY, &target);
            assert!((error.position - 0.5).abs() < 1e-15);
            assert!((error.orientation - angle).abs() < 1e-9, "{angle}: {error:?}");
        }
    }
}

#[test]
fn solutions_repeat_to_the_bit() {
    for name in ["franka_panda", "ur5e"] {
        let robot = catalogue::get(name).unwrap();
        let home = robot.inverse().unwrap().home();
        let mut random = RandomStream::new(8, 0);
        for _ in 0..10 {
            let target = tool(&robot, &random_configuration(&robot, &mut random));
            assert_eq!(nearest(&robot, &target, &home), nearest(&robot, &target, &home));
            assert_eq!(all(&robot, &target), all(&robot, &target));
        }
    }
}
