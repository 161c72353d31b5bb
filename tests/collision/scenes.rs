//! What scenes say: margins, attached objects, pairs that may touch, and faults in them.

use serde_json::{Value, json};
use takt::collision::{CollisionChecker, MotionCheck};
use takt::robot::{Robot, catalogue};
use takt::scene::Scene;

fn scene(value: Value) -> Scene {
    Scene::new(serde_json::from_value(value).unwrap()).unwrap()
}

fn checker(robot: &Robot, scene: &Scene, margin: f64) -> CollisionChecker {
    CollisionChecker::new(robot, scene, margin, MotionCheck::Proven).unwrap()
}

/// A planar arm of two links, 0.4 and 0.3 m long and 0.1 m thick.
fn arm() -> Robot {
    let joint = |name: &str| json!({"name": name, "type": "revolute"});
    let robot = json!({
        "joints": [joint("a"), joint("b"), joint("c")],
        "kinematics": {"convention": "modified_dh", "rows": [{}, {"a": 0.4}, {"a": 0.3}],
            "tool": {"position": [0.1, 0, 0]}},
        "link_radius": 0.05,
    });
    Robot::new(serde_json::from_value(robot).unwrap()).unwrap()
}

/// A wall whose face stands 0.8 m from the base: the stretched arm ends at 0.75 m.
fn wall() -> Value {
    json!({"name": "wall", "shape": {"type": "box", "size": [0.2, 2, 2]}, "pose": {"position": [0.9, 0, 0]}})
}

#[test]
fn the_margin_is_kept_and_no_more() {
    let (robot, scene) = (arm(), scene(json!({"obstacles": [wall()]})));
    for (margin, free) in [(0.0, true), (0.049, true), (0.0499999, true), (0.0500001, false)] {
        let checker = checker(&robot, &scene, margin);
        let mut scratch = checker.scratch();
        assert_eq!(checker.is_valid(&[0.0; 3], &mut scratch), free, "{margin}");
        let clearance = checker.clearance(&[0.0; 3], &mut scratch).unwrap();
        assert!((clearance.distance_m - 0.05).abs() < 1e-12);
        assert_eq!(clearance.pair, ["link_2", "wall"]);
        let contacts = checker.contacts(&[0.0; 3], &mut scratch);
        assert_eq!(contacts.is_empty(), free);
    }
}

#[test]
fn attached_objects_hang_on_the_tool_or_on_their_link() {
    let robot = arm();
    for (attached, free, name) in [
        (
            json!({"name": "rod", "shape": {"type": "capsule", "radius": 0.01, "length": 0.2}}),
            true,
            "x",
        ),
        // The tool stands at 0.8 m, so its ball reaches into the wall.
        (json!({"name": "ball", "shape": {"type": "sphere", "radius": 0.03}}), false, "ball"),
        (
            json!({"name": "ball", "link": 3, "shape": {"type": "sphere", "radius": 0.03}}),
            true,
            "x",
        ),
        (
            json!({"name": "far", "link": 3, "shape": {"type": "box", "size": [0.3, 0.1, 0.1]}}),
            false,
            "far",
        ),
    ] {
        let mut wall = wall();
        wall["pose"]["position"][0] = json!(0.915);
        let scene = scene(json!({"obstacles": [wall], "attached": [attached]}));
        let checker = checker(&robot, &scene, 0.0);
        let mut scratch = checker.scratch();
        let contacts = checker.contacts(&[0.0; 3], &mut scratch);
        assert_eq!(checker.is_valid(&[0.0; 3], &mut scratch), free, "{contacts:?}");
        assert_eq!(contacts.is_empty(), free);
        if let Some(contact) = contacts.first() {
            assert_eq!(contact.pair, [name, "wall"]);
        }
    }
}

#[test]
fn attached_objects_keep_away_from_the_robot_itself() {
    let robot = arm();
    let scene = scene(json!({"attached": [
        {"name": "part", "shape": {"type": "box", "size": [0.1, 0.1, 0.1]}}]}));
    let checker = checker(&robot, &scene, 0.0);
    let mut scratch = checker.scratch();
    assert!(checker.is_valid(&[0.0; 3], &mut scratch));
    // Folded back at the elbow, the part lies on the first link.
    let folded = [0.0, std::f64::consts::PI, 0.0];
    let contacts = checker.contacts(&folded, &mut scratch);
    assert!(!checker.is_valid(&folded, &mut scratch));
    assert!(
        contacts.iter().any(|contact| contact.pair.contains(&"part".to_owned())),
        "{contacts:?}"
    );
}

#[test]
fn allowed_pairs_are_not_checked() {
    let robot = catalogue::get("ur5e").unwrap();
    let table = json!({"name": "table", "shape": {"type": "box", "size": [1, 1, 0.16]},
        "pose": {"position": [0, 0, 0]}});
    let up = [0.0, -1.5, 0.0, 0.0, 0.0, 0.0];
    for (allowed, free) in [
        (json!([]), false),
        (json!([["table", "link_1"]]), true),
        (json!([["shoulder", "table"]]), true),
    ] {
        let scene = scene(json!({"obstacles": [table], "allowed_pairs": allowed}));
        let checker = checker(&robot, &scene, 0.0);
        assert_eq!(checker.is_valid(&up, &mut checker.scratch()), free, "{allowed}");
    }
}

#[test]
fn what_the_robot_does_not_have_is_a_fault() {
    let robot = arm();
    let sphere = json!({"type": "sphere", "radius": 0.1});
    let scene = scene(json!({
        "obstacles": [{"name": "link_1", "shape": sphere}],
        "attached": [{"name": "tool", "link": 4, "shape": sphere}],
        "allowed_pairs": [["link_0", "cup"]],
    }));
    let faults = CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap_err();
    let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(pointers, ["/attached/0/link", "/obstacles/0/name", "/allowed_pairs/0/1"]);
    for (robot, pointer) in [
        (json!({"joints": [{"name": "a", "type": "revolute"}]}), "/kinematics"),
        (
            json!({"joints": [{"name": "a", "type": "revolute"}],
                "kinematics": {"convention": "modified_dh", "rows": [{}]}}),
            "/geometry",
        ),
    ] {
        let robot = Robot::new(serde_json::from_value(robot).unwrap()).unwrap();
        let faults = CollisionChecker::new(&robot, &Scene::default(), 0.0, MotionCheck::Proven);
        assert_eq!(faults.unwrap_err().0[0].pointer, pointer);
    }
}

/// The capsules are assumed, so they must at least not stop robots from what they do all day.
#[test]
fn catalogue_robots_are_free_where_they_usually_stand() {
    for (name, state) in [
        ("ur5e", vec![0.0, -1.57, 1.57, -1.57, -1.57, 0.0]),
        ("franka_panda", vec![0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
        ("rokae_xb4", vec![0.0, 0.5, -0.5, 0.0, 0.4, 0.0]),
        ("kuka_kr6_r900_sixx", vec![0.0, -1.57, 1.57, 0.0, 0.5, 0.0]),
        ("abb_irb120", vec![0.0; 6]),
        ("aubo_i5", vec![0.0; 6]),
    ] {
        let robot = catalogue::get(name).unwrap();
        let floor = json!({"name": "floor", "shape": {"type": "box", "size": [4, 4, 0.1]},
            "pose": {"position": [0, 0, -0.05]}});
        let scene = scene(json!({"obstacles": [floor]}));
        let checker = checker(&robot, &scene, 0.0);
        let contacts = checker.contacts(&state, &mut checker.scratch());
        assert!(contacts.is_empty(), "{name}: {contacts:?}");
    }
}
