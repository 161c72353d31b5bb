use super::*;
use crate::robot::catalogue;

#[test]
fn kinds_follow_from_the_lines() {
    let kinds: Vec<(String, &str)> = catalogue::all()
        .iter()
        .map(|robot| (robot.name().to_owned(), robot.inverse().unwrap().kind()))
        .collect();
    for (name, kind) in &kinds {
        let expected = match name.as_str() {
            "aubo_i5" | "ur5e" | "ur10e" => "three_parallel_axes",
            "franka_panda" => "redundant",
            "adept_cobra_s600" | "epson_t3_401s" => "scara",
            "woodworking_pprr" => "gantry",
            _ => "spherical_wrist",
        };
        assert_eq!(*kind, expected, "{name}");
    }
}

fn random_configuration(robot: &Robot, random: &mut RandomStream) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| &joint.limits);
    limits.map(|l| random.uniform(l.lower.unwrap_or(-3.0), l.upper.unwrap_or(3.0))).collect()
}

#[test]
fn every_reachable_pose_is_reached() {
    for robot in catalogue::all() {
        let (kinematics, inverse) = (robot.kinematics().unwrap(), robot.inverse().unwrap());
        let mut random = RandomStream::new(5, 0);
        let mut found = Solutions::new(inverse);
        let home = inverse.home();
        let mut worst = 0.0_f64;
        for _ in 0..1000 {
            let joints = random_configuration(robot, &mut random);
            let target = kinematics.tool_transform(&joints);
            let nearest = inverse.nearest(&target, &home, &PoseError::TOLERANCE, &mut found);
            assert!(nearest.is_ok(), "{} at {joints:?}: {nearest:?}", robot.name());
            let (solution, error) = found.iter().next().unwrap();
            worst = worst.max(error.largest());
            for (joint, position) in robot.joints().iter().zip(solution) {
                assert!(joint.limits.lower.is_none_or(|lower| *position >= lower));
                assert!(joint.limits.upper.is_none_or(|upper| *position <= upper));
            }
        }
        println!("{} {worst:e}", robot.name());
        assert!(worst < 1e-9, "{}: {worst:e}", robot.name());
    }
}
