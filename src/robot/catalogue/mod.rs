//! The built-in robots: one file each, one line each in the registry below.
//!
//! A figure that no source gives is `null`, never a guess, and every limit
//! tells where it comes from.

use std::sync::{Arc, LazyLock};

use super::{Robot, RobotDescription};
use crate::fault::Faults;

/// The registry: every built-in robot, in alphabetical order.
const FILES: &[&str] = &[
    include_str!("abb_irb120.json"),
    include_str!("adept_cobra_s600.json"),
    include_str!("aubo_i5.json"),
    include_str!("epson_c4_a601s.json"),
    include_str!("epson_t3_401s.json"),
    include_str!("fanuc_m10ia.json"),
    include_str!("fanuc_m6ib.json"),
    include_str!("franka_panda.json"),
    include_str!("kuka_kr6_r900_sixx.json"),
    include_str!("rokae_xb4.json"),
    include_str!("staubli_tx2_60.json"),
    include_str!("ur10e.json"),
    include_str!("ur5e.json"),
    include_str!("woodworking_pprr.json"),
    include_str!("yaskawa_gp7.json"),
];

// A file that does not load is left out rather than ending the process; the
// test `every_file_loads` keeps such a file out of the tree.
static ROBOTS: LazyLock<Vec<Arc<Robot>>> =
    LazyLock::new(|| FILES.iter().filter_map(|json| load(json).ok()).map(Arc::new).collect());

fn load(json: &str) -> Result<Robot, Faults> {
    let description: RobotDescription = serde_json::from_str(json).map_err(|error| {
        let mut faults = Faults::default();
        faults.add("", error.to_string());
        faults
    })?;
    Robot::new(description)
}

/// The built-in robots, in alphabetical order.
pub fn all() -> &'static [Arc<Robot>] {
    &ROBOTS
}

/// The names of the built-in robots, in alphabetical order.
pub fn names() -> impl Iterator<Item = &'static str> {
    all().iter().map(|robot| robot.name())
}

/// The built-in robot called `name`.
pub fn get(name: &str) -> Option<Arc<Robot>> {
    all().iter().find(|robot| robot.name() == name).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{JointType, Provenance};

    #[test]
    fn every_file_loads() {
        for json in FILES {
            let robot = load(json).unwrap_or_else(|faults| panic!("{faults} in {json}"));
            assert!(robot.kinematics().is_some(), "{} has kinematics", robot.name());
            assert!(robot.description().description.is_some());
            assert!(robot.description().source.is_some());
        }
        assert_eq!(all().len(), 15);
    }

    #[test]
    fn names_are_sorted_and_found() {
        let names: Vec<_> = names().collect();
        assert!(names.is_sorted());
        for name in names {
            assert_eq!(get(name).unwrap().name(), name);
        }
        assert!(get("no_such_robot").is_none());
    }

    #[test]
    fn every_robot_survives_the_way_through_json() {
        for robot in all() {
            let text = serde_json::to_string(robot.description()).unwrap();
            let back: RobotDescription = serde_json::from_str(&text).unwrap();
            assert_eq!(&back, robot.description());
        }
    }

    #[test]
    fn a_known_limit_tells_its_provenance_and_an_unknown_one_has_none() {
        for joint in all().iter().flat_map(|robot| robot.joints()) {
            let (limits, from) = (&joint.limits, &joint.provenance);
            for (limit, provenance) in [
                (limits.lower, from.lower),
                (limits.upper, from.upper),
                (limits.velocity, from.velocity),
                (limits.acceleration, from.acceleration),
                (limits.jerk, from.jerk),
                (limits.effort, from.effort),
            ] {
                assert_eq!(limit.is_some(), provenance.is_some(), "{}", joint.name);
            }
        }
    }

    #[test]
    fn unknown_speeds_stay_unknown() {
        for name in ["rokae_xb4", "fanuc_m6ib", "adept_cobra_s600"] {
            for joint in get(name).unwrap().joints() {
                assert_eq!(joint.limits.velocity, None, "{name}");
                assert_eq!(joint.limits.acceleration, None, "{name}");
                assert_eq!(joint.limits.jerk, None, "{name}");
            }
        }
        let scara = get("epson_t3_401s").unwrap();
        let speeds: Vec<_> = scara.joints().iter().map(|joint| joint.limits.velocity).collect();
        assert_eq!(speeds, [None, None, Some(1.0), Some(2600_f64.to_radians())]);
        assert_eq!(scara.joints()[2].provenance.velocity, Some(Provenance::Unconfirmed));
    }

    #[test]
    fn degrees_are_converted_in_full_precision() {
        let rokae = get("rokae_xb4").unwrap();
        assert_eq!(rokae.joints()[1].limits.upper, Some(130_f64.to_radians()));
        let staubli = get("staubli_tx2_60").unwrap();
        assert_eq!(staubli.joints()[5].limits.velocity, Some(1445_f64.to_radians()));
    }

    #[test]
    fn the_woodworking_machine_slides_first_and_turns_last() {
        let machine = get("woodworking_pprr").unwrap();
        let types: Vec<_> = machine.joints().iter().map(|joint| joint.joint_type).collect();
        use JointType::{Prismatic, Revolute};
        assert_eq!(types, [Prismatic, Prismatic, Revolute, Revolute]);
        assert_eq!(machine.joints()[1].limits.upper, Some(1.5));
        assert_eq!(machine.joints()[3].limits.acceleration, Some(2.4));
    }
}
