//! Motions around obstacles: certified, free over all their length, and told why where there is none.

use serde_json::{Value, json};
use takt::collision::{CollisionChecker, MotionCheck};
use takt::geometry::Pose;
use takt::plan::TrajectoryResult;
use takt::robot::catalogue;
use takt::scene::Scene;
use takt::trajectory::KinematicState;

use crate::support::{faults, merge, plan, timeless, try_plan};

const START: [f64; 6] = [-0.9, -1.2, 1.4, -1.8, -1.57, 0.0];
const GOAL: [f64; 6] = [0.9, -1.2, 1.4, -1.8, -1.57, 0.0];

fn pillar() -> Value {
    json!({"obstacles": [
        {"name": "pillar", "shape": {"type": "box", "size": [0.12, 0.12, 1.2]}, "pose": {"position": [-0.55, 0.0, 0.2]}},
        {"name": "table", "shape": {"type": "box", "size": [2.0, 2.0, 0.1]}, "pose": {"position": [0.0, 0.0, -0.25]}},
    ]})
}

/// A UR5e that has to get past a pillar, with `changes`.
fn request(changes: Value) -> Value {
    let mut request = json!({
        "robot": "ur5e", "scene": pillar(), "seed": 3,
        "limits": {"acceleration": 8.0, "jerk": 80.0},
        "task": {"type": "motion", "start": {"joints": START}, "goal": {"joints": GOAL}},
    });
    // Ends are of one kind or the other.
    for end in ["start", "goal"] {
        if !changes["task"][end].is_null() {
            request["task"][end] = json!({});
        }
    }
    merge(&mut request, changes);
    request
}

fn checker() -> CollisionChecker {
    let robot = catalogue::get("ur5e").unwrap();
    let scene = Scene::new(serde_json::from_value(pillar()).unwrap()).unwrap();
    CollisionChecker::new(&robot, &scene, 0.0, MotionCheck::Proven).unwrap()
}

/// The least clearance at many instants, m, by the distances of single configurations.
fn least_clearance(result: &TrajectoryResult) -> f64 {
    let checker = checker();
    let mut scratch = checker.scratch();
    let mut state = KinematicState::new(6);
    let samples = 2000;
    (0..=samples)
        .map(|sample| {
            result.trajectory.sample(result.duration * sample as f64 / samples as f64, &mut state);
            checker.clearance(&state.position, &mut scratch).unwrap().distance_m
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_motion_around_a_pillar_is_lawful_and_touches_nothing() {
    let checker = checker();
    assert!(!checker.is_motion_valid(&START, &GOAL, &mut checker.scratch()), "nothing in the way");
    for interpolation in ["jerk_limited", "quintic"] {
        let result = plan(request(json!({"task": {"interpolation": interpolation}})));
        let certificate = &result.certificate;
        assert!(certificate.lawful && certificate.starts_at_rest && certificate.ends_at_rest);
        let proven = certificate.clearance.as_ref().unwrap();
        let sampled = least_clearance(&result);
        assert!(proven.smallest_m > 0.0 && proven.smallest_m <= sampled, "{proven:?} {sampled}");
        assert!(sampled < proven.smallest_m + 2e-3, "{proven:?} {sampled}");
        assert_eq!(result.waypoints[0], START);
        assert_eq!(result.waypoints[result.waypoints.len() - 1], GOAL);
        let motion = result.motion.as_ref().unwrap();
        assert_eq!(result.waypoints.len(), motion.path.len() + motion.added_waypoints);
        assert!(motion.length >= motion.straight_length && motion.path.len() > 2);
    }
}

#[test]
fn clearance_asked_for_is_kept() {
    let result = plan(request(json!({"task": {"clearance_m": 0.01}})));
    assert!(result.certificate.clearance.as_ref().unwrap().smallest_m > 0.01);
    assert!(least_clearance(&result) > 0.01);
}

#[test]
fn equal_requests_give_equal_motions_and_other_seeds_other_ones() {
    let first = plan(request(json!({})));
    assert_eq!(timeless(&first), timeless(&plan(request(json!({})))));
    assert_ne!(first.motion, plan(request(json!({"seed": 4}))).motion);
}

#[test]
fn a_pose_is_reached_by_a_free_configuration() {
    let robot = catalogue::get("ur5e").unwrap();
    let pose: Pose = robot.kinematics().unwrap().tool_pose(&GOAL);
    let result = plan(request(json!({"task": {"goal": {"pose": pose}}})));
    let end = robot.kinematics().unwrap().tool_pose(&result.waypoints[result.waypoints.len() - 1]);
    for (found, wanted) in end.position.iter().zip(pose.position) {
        assert!((found - wanted).abs() < 1e-6, "{end:?} is not {pose:?}");
    }
    assert!(result.certificate.lawful && least_clearance(&result) > 0.0);
}

#[test]
fn without_obstacles_the_straight_way_is_taken() {
    let mut request = request(json!({}));
    request.as_object_mut().unwrap().remove("scene");
    let result = plan(request);
    let motion = result.motion.as_ref().unwrap();
    assert_eq!((motion.path.len(), motion.iterations), (2, 0));
    assert_eq!(motion.length, motion.straight_length);
}

#[test]
fn why_there_is_no_motion_is_told() {
    let failed = |changes: Value| try_plan(request(changes)).unwrap_err();
    // Straight through the pillar's place.
    let error = failed(json!({"task": {"goal": {"joints": [0.0, -1.2, 1.4, -1.8, -1.57, 0.0]}}}));
    assert_eq!(error.code.as_str(), "goal_in_collision");
    assert!(error.message.contains("deep in pillar"), "{}", error.message);
    assert_eq!(error.details["contacts"][0]["pair"][1], "pillar");
    assert!(error.details["contacts"][0]["distance_m"].as_f64().unwrap() < 0.0);
    let error = failed(json!({"task": {"start": {"pose": {"position": [3.0, 0.0, 0.3]}}}}));
    assert_eq!(error.code.as_str(), "ik_no_solution");
    let missed = error.details["position_error_m"].as_f64().unwrap();
    assert!((1.5..2.5).contains(&missed), "{missed}");
    let error = failed(json!({"task": {"planner": {"name": "rrt", "iterations": 1}}}));
    assert_eq!(error.code.as_str(), "no_path");
    assert_eq!(error.details["planner"], "rrt");
}

#[test]
fn faults_have_pointers() {
    let pointers = |changes: Value| -> Vec<String> {
        faults(request(changes)).0.into_iter().map(|fault| fault.pointer).collect()
    };
    assert_eq!(
        pointers(json!({
            "scene": {"obstacles": [{"name": "a", "shape": {"type": "sphere", "radius": -1.0}}]},
            "task": {"start": {"joints": [0.0]}},
        })),
        ["/scene/obstacles/0/shape/radius"]
    );
    assert_eq!(
        pointers(json!({"task": {
            "start": {"joints": [0.0]}, "goal": {"joints": [0.0, 99.0, 0.0, 0.0, 0.0, 0.0]},
            "clearance_m": -0.1, "planner": {"name": "guess"}, "smoothing": {"name": "bezier"},
            "interpolation": "3-5-3",
        }})),
        [
            "/task/start/joints",
            "/task/goal/joints/1",
            "/task/clearance_m",
            "/task/planner/name",
            "/task/smoothing/name",
            "/task/interpolation",
        ]
    );
    assert_eq!(pointers(json!({"robot": "woodworking_pprr"})).last().unwrap(), "/robot/geometry");
}
