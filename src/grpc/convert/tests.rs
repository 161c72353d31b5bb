//! Without these tests a field could be forgotten, or be called one thing in
//! JSON and another in protobuf.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;

use prost::Message;
use prost_types::{DescriptorProto, FileDescriptorSet};
use serde_json::{Value, json};

use super::{MessageForm, read};
use crate::grpc::{chunks, proto};
use crate::job::{EventKind, Job, JobEvent, JobFilter, JobId, JobPage, JobState};
use crate::plan::{Clock, PlanRequest, PlanResult, Task, Waypoint, WaypointsTask};
use crate::robot::{KinematicsDescription, RobotDescription};
use crate::service::{JobRequest, RobotOrigin, RobotPut, RobotSummary};

/// A robot with every field given.
pub(crate) fn robot() -> Value {
    let words = ["datasheet", "urdf", "paper", "measured", "third_party", "unconfirmed"];
    let kinds = ["lower", "upper", "velocity", "acceleration", "jerk", "effort"];
    let provenance: BTreeMap<_, _> = kinds.into_iter().zip(words).collect();
    json!({
        "name": "arm", "description": "an arm", "source": "a book", "notes": ["mind the gap"],
        "joints": [
            {"name": "j1", "type": "revolute", "limits": {"lower": -1.0, "upper": 2.0,
                "velocity": 3.0, "acceleration": 4.0, "jerk": 5.0, "effort": 6.0},
                "provenance": provenance},
            {"name": "j2", "type": "prismatic", "limits": {},
                "provenance": {"jerk": "assumed", "velocity": "user"}},
            {"name": "j3", "type": "continuous"},
        ],
        "kinematics": {"convention": "modified_dh",
            "rows": [{"a": 0.1, "alpha": 0.2, "d": 0.3, "theta": 0.4, "sign": -1.0}, {}, {}],
            "base": {"position": [1.0, 2.0, 3.0], "orientation": [1.0, 0.0, 0.0, 0.0]},
            "tool": {"position": [4.0, 5.0, 6.0]}},
        "geometry": [
            {"link": 0, "name": "foot", "shape": {"type": "box", "size": [0.1, 0.2, 0.3]},
                "pose": {"position": [0.0, 0.0, 0.1]}, "provenance": "measured"},
            {"link": 1, "shape": {"type": "sphere", "radius": 0.1}},
            {"link": 1, "shape": {"type": "capsule", "radius": 0.1, "length": 0.2}},
            {"link": 2, "shape": {"type": "cylinder", "radius": 0.1, "length": 0.2}},
            {"link": 3, "shape": {"type": "convex_hull",
                "points": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]}},
        ],
        "allowed_pairs": [[0, 2]], "link_radius": 0.05,
    })
}

fn waypoints_task() -> Value {
    json!({
        "type": "waypoints", "waypoints": [[0.0, 0.1, 0.2], [1.0, 1.1, 1.2]],
        "interpolation": "cubic", "clock": "per_joint",
        "optimizer": {"name": "improved_pso", "population": 50, "w": 0.7, "own": {"deep": [true]}},
        "constraint_handling": "penalty", "constraints": "velocity_only",
        "durations": {"min": 0.02, "max": 10.0}, "duration": {"at_most": 3.2},
        "objective": {"time": 1.0, "rms_jerk": 0.5, "energy": 0.25},
        "pareto": {"objectives": ["time", "rms_jerk", "energy"], "points": 9, "method": "nsga2",
            "max_stretch": 3.0, "population": 40, "generations": 50},
        "fixed_durations": [0.5],
        "start": {"velocity": [0.1, 0.2, 0.3], "acceleration": [0.4, 0.5, 0.6]},
        "goal": {"velocity": [0.7, 0.8, 0.9], "acceleration": [1.0, 1.1, 1.2]},
        "via_tolerance": [0.05, 0.0, 0.01],
    })
}

/// A job request with every field given.
fn job_request() -> Value {
    let mut leg = waypoints_task();
    leg.as_object_mut().unwrap().insert("duration".into(), json!({"exactly": 4.0}));
    json!({
        "robot": robot(),
        "task": {"type": "program", "legs": [
            {"name": "AB", "note": "gripper 3", "task": waypoints_task()}, {"name": "BC", "task": leg}]},
        "seed": 7, "scene": motion_request()["scene"],
        "limits": {"lower": [null, -1.0, -1.0], "upper": 2.0, "velocity": 3.0,
            "acceleration": [1.0, 2.0, 3.0], "jerk": null, "tcp_speed": 0.25},
        "limit_scale": {"velocity": 0.5, "acceleration": 0.6, "jerk": 0.7},
        "priority": 90, "deadline_s": 60.0, "start_by": "2030-01-02T03:04:05.5Z",
        "labels": {"cell": "3"},
    })
}

/// A trajectory's result with every field given, of three pieces.
pub(crate) fn trajectory_result() -> Value {
    let peak = json!({"peak": 1.5, "at": 0.5, "limit": 2.0, "ratio": 0.75, "provenance": "paper"});
    let open = json!({"peak": null, "at": 0.5, "limit": null, "ratio": null, "provenance": null});
    let range = json!({"min": -1.0, "min_at": 0.0, "max": 1.0, "max_at": 2.0, "lower": -2.0,
        "upper": null, "provenance": "measured"});
    json!({
        "robot": "arm", "joint_names": ["j1", "j2"], "joint_units": ["rad", "m"],
        "duration": 3.0, "durations": [1.0, 1.0, 1.0], "waypoint_times": [0.0, 1.0, 2.0, 3.0],
        "waypoints": [[0.0, 0.5], [1.0, 1.5], [2.0, 2.5], [3.0, 3.5]],
        "trajectory": {"breakpoints": [0.0, 1.0, 2.0, 3.0],
            "pieces": [[[0.0, 0.1], [0.5]], [[1.0], [1.5, 0.2]], [[2.0], [2.5, 0.3, 0.4]]]},
        "certificate": {"lawful": true, "worst_ratio": 0.75, "continuity": 4,
            "starts_at_rest": true, "ends_at_rest": true,
            "joints": [{"name": "j1", "position": range, "velocity": peak, "acceleration": peak,
                "jerk": open}],
            "tcp_speed": peak,
            "violations": [{"joint": "j1", "limit": "jerk", "at": 0.1, "value": 9.0,
                "limit_value": 8.0, "detail": "too much"}],
            "waypoint_error": 1e-12, "via_tolerance": [0.05, 0.0],
            "clearance": {"smallest_m": 0.1, "at": 1.0, "pair": ["arm", "table"]},
            "sha256": "ab"},
        "bound": {"lower": 2.9, "gap": 0.03, "method": "speed"},
        "motion": {"planned": [[0.0, 0.5], [3.0, 3.5]], "path": [[0.0, 0.5], [3.0, 3.5]],
            "length": 4.5, "straight_length": 4.25, "nodes": 10, "iterations": 11, "checks": 12,
            "planner": "rrt_connect", "smoothing": "shortcut", "added_waypoints": 2},
        "metrics": {"initial_duration": 12.0, "saved": 0.75, "rms_jerk": [1.0, 2.0],
            "mean_utilisation": [0.5, null], "path_length": [3.0, 3.0],
            "binding": [{"segment": 1, "joint": "j1", "limit": "velocity"}],
            "without_tcp_limit": 2.8,
            "sensitivities": [{"joint": "j1", "limit": "velocity", "seconds_per_percent": 0.02}],
            "objective": {"time": 3.0, "rms_jerk": 9.0, "energy": 2.0},
            "reference": {"time": 2.5, "rms_jerk": 12.0, "energy": 4.0}},
        "pareto": {"objectives": [{"name": "time", "unit": "s"}, {"name": "energy", "unit": "rad²/s⁴"}],
            "method": "epsilon_constraint", "points": [
                {"values": [2.5, 4.0], "durations": [0.8, 0.8, 0.9], "worst_ratio": 1.0},
                {"values": [3.0, 2.0], "durations": [1.0, 1.0, 1.0], "worst_ratio": 0.9}]},
        "per_joint": [{"joint": "j1", "durations": [1.0, 1.0, 0.5], "duration": 2.5,
            "evaluations": 10}],
        "convergence": [
            {"iteration": 0, "evaluations": 50, "elapsed_s": 0.001, "best": null, "mean": null},
            {"iteration": 1, "evaluations": 100, "elapsed_s": 0.002, "best": 3.0, "mean": 4.0}],
        "interpolation": "quintic", "optimizer": "improved_pso", "stop_reason": "iteration_limit",
        "iterations": 1, "evaluations": 100, "planning_s": 0.003, "seed": 7, "version": "0.1.0",
    })
}

fn program_result() -> Value {
    json!({
        "robot": "arm", "joint_names": ["j1", "j2"], "duration": 6.0, "lawful": true, "worst_ratio": 0.75,
        "legs": [{"name": "AB", "note": "gripper 3", "start": 0.0, "result": trajectory_result()},
            {"name": "BC", "start": 3.0, "result": trajectory_result()}],
        "evaluations": 200, "planning_s": 0.006, "seed": 7, "version": "0.1.0",
    })
}

fn comparison_task() -> Value {
    json!({
        "type": "comparison",
        "problems": [{"name": "p", "robot": "ur5e", "limits": {"velocity": [1.0, null]},
            "limit_scale": {"jerk": 0.5}, "task": waypoints_task()}],
        "methods": ["pso", {"name": "ga", "label": "small", "population": 40}],
        "runs": 12, "max_evaluations": 700, "success_tolerance": 0.01,
    })
}

fn family_task() -> Value {
    json!({
        "type": "family",
        "problem": {"robot": robot(), "limits": {"velocity": [1.0, null]},
            "limit_scale": {"jerk": 0.5}, "task": waypoints_task()},
        "members": [
            {"name": "a", "set": {"task": {"waypoints": [[0.5, 1], [2, 3.25]], "clock": null}}},
            {"name": "b", "set": {}}],
    })
}

fn sweep_task() -> Value {
    json!({
        "type": "family", "problem": {"task": waypoints_task()},
        "sweep": [{"path": "/limit_scale/jerk", "values": [0.5, 1, null, "x", [1.5]]}],
    })
}

fn family_result() -> Value {
    let failed = json!({
        "name": "jerk=1", "values": [1], "duration": null, "lower_bound": null, "gap": null,
        "lawful": null, "worst_ratio": null, "most_binding": null, "evaluations": 0,
        "failure": {"code": "limits_unreachable", "message": "no", "details": {"joint": "j1"}},
    });
    json!({
        "robot": "arm", "verdict": "1 of 2", "sweep": sweep_task()["sweep"],
        "members": [
            {"name": "jerk=0.5", "values": [0.5], "duration": 3.0, "lower_bound": 2.5, "gap": 0.2,
                "lawful": true, "worst_ratio": 0.75, "evaluations": 100, "most_binding":
                    {"joint": "j1", "limit": "jerk", "segments": 2, "seconds_per_percent": 0.01}},
            failed],
        "fastest": "jerk=0.5", "slowest": "jerk=0.5", "median_duration": 3.0, "failed": 1,
        "lawful": true, "worst_ratio": 0.75, "worst_case": trajectory_result(),
        "evaluations": 100, "planning_s": 0.03, "seed": 7, "version": "0.1.0",
    })
}

fn path_task() -> Value {
    json!({
        "type": "path", "space": {"lower": [0.0, 0.0], "upper": [9.0, 8.0], "obstacles": [
            {"type": "ball", "center": [3.0, 3.5], "radius": 1.5},
            {"type": "box", "lower": [5.0, 1.0], "upper": [6.0, 2.0]}]},
        "start": [1.0, 2.0], "goal": [8.0, 7.0],
        "planner": {"name": "rrt_star", "range": 0.5, "first_path": true},
        "smoothing": {"name": "bezier", "degree": 5}, "trees": true,
    })
}

/// With every field given.
fn motion_request() -> Value {
    json!({
        "robot": "arm", "seed": 7,
        "scene": {"name": "cell", "description": "a cell",
            "obstacles": [{"name": "table", "shape": {"type": "box", "size": [1.0, 2.0, 0.1]},
                "pose": {"position": [1.0, 0.0, 0.0], "orientation": [0.0, 0.0, 0.0, 1.0]}}],
            "attached": [{"name": "gripper", "link": 6, "shape": {"type": "sphere", "radius": 0.1},
                "pose": {"position": [0.0, 0.0, 0.1], "orientation": [0.0, 0.0, 0.0, 1.0]}}],
            "allowed_pairs": [["gripper", "table"]]},
        "task": {"type": "motion", "start": {"joints": [0.0, 1.0]},
            "goal": {"pose": {"position": [0.5, 0.0, 0.5], "orientation": [0.0, 1.0, 0.0, 0.0]}},
            "clearance_m": 0.01, "planner": {"name": "rrt_connect", "range": 0.5},
            "smoothing": {"name": "shortcut", "attempts": 50}, "interpolation": "quintic",
            "clock": "per_joint", "optimizer": {"name": "pso", "population": 20},
            "constraint_handling": "penalty", "constraints": "velocity_only",
            "durations": {"min": 0.1, "max": 2.0}, "duration": {"at_most": 3.0},
            "objective": {"time": 1.0, "rms_jerk": 0.5, "energy": 0.25}},
    })
}

#[test]
fn motions_survive_both_ways() {
    let request = PlanRequest::parse(motion_request()).unwrap();
    assert_returns::<proto::PlanRequest, _>(request.clone());
    let named = json!({"scene": "cell-3", "robot": "ur5e", "task": motion_request()["task"]});
    assert_returns::<proto::PlanRequest, _>(PlanRequest::parse(named).unwrap());
}

/// With every field given.
fn path_result() -> Value {
    json!({
        "path": [[1.0, 2.0], [4.0, 1.0], [8.0, 7.0]], "smoothed_path": [[1.0, 2.0], [8.0, 7.0]],
        "curve": [{"control_points": [[1.0, 2.0], [4.0, 1.0], [8.0, 7.0]]}],
        "length": 10.5, "smoothed_length": 9.5, "straight_length": 8.5, "clearance": 0.25,
        "nodes": 40, "iterations": 50, "evaluations": 60,
        "convergence": [
            {"iteration": 3, "evaluations": 5, "elapsed_s": 0.001, "best": 10.5, "mean": null}],
        "planner": "rrt_star", "smoothing": "bezier", "stop_reason": "solved",
        "space": path_task()["space"], "tree_edges": [{"from": [1.0, 2.0], "to": [4.0, 1.0]}],
        "planning_s": 0.002, "seed": 7, "version": "0.1.0",
    })
}

fn benchmark_task() -> Value {
    json!({"type": "benchmark", "functions": ["f1", "f6"], "dimension": 5, "population": 20,
        "iterations": 70, "runs": 4, "optimizers": [{"name": "ga", "elite": 1}], "shifted": true})
}

fn method_result() -> Value {
    json!({
        "label": "pso", "optimizer": "pso", "parameters": {"population": 50.0},
        "runs": 12, "feasible_runs": 11, "best": 2.75, "mean": 3.25, "worst": 4.0,
        "standard_deviation": 0.125, "lower_quartile": 3.0, "median": 3.125,
        "upper_quartile": 3.5, "median_gap": 0.5, "success_rate": 0.75,
        "evaluations_to_success":
            {"lower_quartile": 100.0, "median": 150.0, "upper_quartile": 200.0},
        "p_value": 0.0625, "evaluations": 8400, "seconds_per_evaluation": 1e-6,
        "curve": [
            {"evaluations": 1, "lower_quartile": null, "median": null, "upper_quartile": null},
            {"evaluations": 700, "lower_quartile": 3.0, "median": 3.125, "upper_quartile": 3.5}],
    })
}

fn comparison_result() -> Value {
    let problem = json!({
        "name": "p", "title": "4 waypoints", "robot": "arm", "unit": "s", "dimension": 2,
        "optimum": {"value": 3.0, "position": [1.0, 2.0], "source": "exact"},
        "lower_bound": 2.5, "best_known": 2.75, "best_method": "pso",
        "best_run": {"method": "pso", "run": 3, "value": 2.75, "position": [1.0, 1.75]},
        "methods": [method_result()],
    });
    json!({
        "task": "comparison", "runs": 12, "max_evaluations": 700, "success_tolerance": 0.01,
        "test": "U", "verdict": "pso did best", "problems": [problem],
        "evaluations": 8600, "planning_s": 0.03, "seed": 7, "version": "0.1.0",
    })
}

fn progress() -> Value {
    json!({"iteration": 3, "evaluations": 150, "elapsed_s": 0.1, "best": 5.5, "mean": 6.5,
        "lower_bound": 5.0, "leg": "AB", "method": "pso",
        "members": {"done": 2, "of": 9, "failed": 1, "slowest": 7.5}})
}

fn error() -> Value {
    json!({"code": "limits_unreachable", "message": "no", "details": {"joint": "j1", "waypoint": 2}})
}

fn job() -> Value {
    let time = "2026-11-05T12:00:00.123456Z";
    json!({
        "id": JobId::new(), "state": "failed", "priority": 90, "labels": {"cell": "3"},
        "task": "waypoints", "method": "improved_pso", "robot": "arm", "seed": 7,
        "created_at": time, "started_at": time, "finished_at": time, "deadline_s": 60.0,
        "start_by": time, "attempt": 2, "progress": progress(), "error": error(),
    })
}

fn events() -> [Value; 3] {
    let event = |seq: u64, kind: &str, more: Value| {
        let mut event = json!({"seq": seq, "time": "2026-11-05T12:00:00Z", "type": kind});
        event.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        event
    };
    let summary = json!({"duration": 3.0, "lawful": true, "worst_ratio": 0.75, "lower_bound": 2.9,
        "legs": 1, "evaluations": 100, "planning_s": 0.003, "verdict": "pso did best"});
    [
        event(1, "state", json!({"state": "running", "attempt": 1})),
        event(2, "progress", progress()),
        event(3, "finished", json!({"state": "failed", "summary": summary, "error": error()})),
    ]
}

/// Sends `value` there and back over the wire.
fn assert_returns<M: Message + Default, T>(value: T)
where
    T: MessageForm<M> + Clone + PartialEq + Debug,
{
    let bytes = value.clone().into_message().encode_to_vec();
    let message = M::decode(bytes.as_slice()).unwrap();
    assert_eq!(read::<T, M>(message), Ok(value));
}

fn parsed<T: serde::de::DeserializeOwned>(value: Value) -> T {
    serde_json::from_value(value).unwrap()
}

#[test]
fn requests_return_as_they_went() {
    let request = JobRequest::parse(job_request()).unwrap();
    assert_returns::<proto::JobRequest, _>(request.clone());
    assert_returns::<proto::PlanRequest, _>(request.plan);
    let named = json!({"robot": "ur5e", "task": waypoints_task()});
    assert_returns::<proto::PlanRequest, _>(PlanRequest::parse(named).unwrap());
    for task in [comparison_task(), benchmark_task(), family_task(), sweep_task(), path_task()] {
        let request = PlanRequest::parse(json!({ "task": task })).unwrap();
        assert_returns::<proto::PlanRequest, _>(request);
    }
    let single = json!({"type": "comparison", "task": waypoints_task(), "methods": ["pso"]});
    let single = PlanRequest::parse(json!({"robot": "ur5e", "task": single})).unwrap();
    assert_returns::<proto::PlanRequest, _>(single);
    assert_returns::<proto::Robot, RobotDescription>(parsed(robot()));
    let state = Some(JobState::Running);
    let labels = BTreeMap::from([("cell".to_owned(), "3".to_owned())]);
    let page_token = Some("next".to_owned());
    assert_returns::<proto::ListJobsRequest, _>(JobFilter {
        state,
        labels,
        page_size: 9,
        page_token,
    });
    assert_returns::<proto::ListJobsRequest, _>(JobFilter::default());
}

#[test]
fn results_jobs_and_events_return_as_they_went() {
    for result in
        [trajectory_result(), program_result(), comparison_result(), family_result(), path_result()]
    {
        let result: PlanResult = parsed(result);
        assert_returns::<proto::PlanResult, _>(result.clone());
        assert_eq!(chunks::join(chunks::split(result.clone().into_message())), Ok(result));
    }
    let job: Job = parsed(job());
    assert_returns::<proto::Job, _>(job.clone());
    let next_page_token = Some("next".to_owned());
    assert_returns::<proto::ListJobsResponse, _>(JobPage { jobs: vec![job], next_page_token });
    for event in events() {
        assert_returns::<proto::JobEvent, JobEvent>(parsed(event));
    }
    let finished = EventKind::Finished { state: JobState::Succeeded, summary: None, error: None };
    let bare = JobEvent { seq: 1, time: jiff::Timestamp::UNIX_EPOCH, kind: finished };
    assert_returns::<proto::JobEvent, _>(bare);
}

#[test]
fn robots_of_the_service_return_as_they_went() {
    assert_returns::<proto::PutRobotResponse, _>(RobotPut {
        robot: parsed(robot()),
        created: true,
    });
    assert_returns::<proto::RobotSummary, _>(robot_summary());
}

fn robot_summary() -> RobotSummary {
    RobotSummary {
        name: "arm".to_owned(),
        origin: RobotOrigin::Registered,
        description: Some("an arm".to_owned()),
        dof: 3,
        joint_names: vec!["j1".to_owned()],
        kinematics: true,
    }
}

/// Kinematics as links.
fn links() -> Value {
    json!({"links": [{"name": "arm", "joint": "j", "pose": {"position": [0, 0, 1]}, "axis": [0, 1, 0],
        "ratio": -1, "offset": 0.5}]})
}

/// Kinematics as a URDF.
fn urdf() -> Value {
    json!({"urdf": "<robot/>", "tip": "tool0", "base_link": "base", "srdf": "<robot/>", "joint_limits": "a: b"})
}

#[test]
fn kinematics_of_every_form_survive_the_way_through_a_message() {
    for form in [links(), urdf(), json!({"convention": "standard_dh", "rows": [{"a": 1}]})] {
        let kinematics: KinematicsDescription = parsed(form);
        let message: proto::Kinematics = kinematics.clone().into_message();
        assert_eq!(read::<KinematicsDescription, _>(message), Ok(kinematics));
    }
    let message = proto::Kinematics { tip: Some("t".to_owned()), ..<_>::default() };
    assert!(read::<KinematicsDescription, _>(message).is_err());
}

#[test]
fn waypoints_of_every_form_survive_the_way_through_a_message() {
    for form in [
        json!([1.0, 2.0]),
        json!({"pose": {"position": [1, 2, 3]}}),
        json!({"pose": {}, "seed": [0.5]}),
    ] {
        let waypoint: Waypoint = parsed(form);
        let message: proto::Waypoint = waypoint.clone().into_message();
        assert_eq!(read::<Waypoint, _>(message), Ok(waypoint));
    }
    let both = proto::Waypoint { values: vec![0.0], pose: Some(<_>::default()), seed: Vec::new() };
    assert!(read::<Waypoint, _>(both).is_err());
}

/// What both forms leave out has to mean the same in both.
#[test]
fn defaults_are_those_of_the_json_form() {
    let message = proto::WaypointsTask {
        waypoints: vec![proto::Waypoint { values: vec![0.0], ..<_>::default() }],
        ..<_>::default()
    };
    let task: WaypointsTask = parsed(json!({"waypoints": [[0.0]]}));
    assert_eq!(read::<WaypointsTask, _>(message), Ok(task));

    let joint = proto::Joint {
        name: "j".to_owned(),
        r#type: proto::JointType::Revolute.into(),
        limits: None,
        provenance: None,
    };
    let kinematics = proto::Kinematics {
        convention: proto::DhConvention::StandardDh.into(),
        rows: vec![proto::DhRow::default()],
        base: None,
        tool: Some(proto::Pose::default()),
        ..<_>::default()
    };
    let message =
        proto::Robot { joints: vec![joint], kinematics: Some(kinematics), ..<_>::default() };
    let json = json!({"joints": [{"name": "j", "type": "revolute"}],
        "kinematics": {"convention": "standard_dh", "rows": [{}], "tool": {}}});
    assert_eq!(read::<RobotDescription, _>(message), Ok(parsed(json)));

    let plan = json!({"robot": "r", "task": {"type": "waypoints", "waypoints": []}});
    let message: proto::PlanRequest = PlanRequest::parse(plan.clone()).unwrap().into_message();
    let message = proto::JobRequest { plan: Some(message), ..<_>::default() };
    assert_eq!(read::<JobRequest, _>(message), JobRequest::parse(plan));
}

/// The pointers are those of the JSON form, so one page of documentation
/// explains the faults of both edges.
#[test]
fn every_fault_is_told_with_its_pointer() {
    let mut message: proto::JobRequest = JobRequest::parse(job_request()).unwrap().into_message();
    message.priority = Some(300);
    message.deadline_s = Some(f64::NAN);
    let plan = message.plan.as_mut().unwrap();
    let limits = plan.limits.as_mut().unwrap();
    limits.upper = Some(proto::LimitOverride { kind: None });
    let Some(proto::robot_ref::Kind::Inline(robot)) = &mut plan.robot.as_mut().unwrap().kind else {
        panic!("an inline robot");
    };
    robot.joints[1].r#type = 0;
    robot.joints[2].provenance.as_mut().unwrap().jerk = 99;
    robot.kinematics.as_mut().unwrap().base.as_mut().unwrap().position.pop();
    let Some(proto::task::Kind::Program(program)) = &mut plan.task.as_mut().unwrap().kind else {
        panic!("a program");
    };
    program.legs[0].task = None;
    let task = program.legs[1].task.as_mut().unwrap();
    task.waypoints[1].values[2] = f64::INFINITY;
    task.clock = 17;
    task.duration = Some(proto::DurationGoal { kind: None });

    let faults = read::<JobRequest, _>(message).unwrap_err();
    let found: BTreeSet<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
    let expected = BTreeSet::from([
        "/robot/joints/1/type",
        "/robot/joints/2/provenance/jerk",
        "/robot/kinematics/base/position",
        "/task/legs/0/task",
        "/task/legs/1/task/waypoints/1/2",
        "/task/legs/1/task/clock",
        "/task/legs/1/task/duration",
        "/limits/upper",
        "/priority",
        "/deadline_s",
    ]);
    assert_eq!(found, expected);
    assert_eq!(faults.0.len(), expected.len());

    let empty = read::<JobRequest, _>(proto::JobRequest::default()).unwrap_err();
    assert_eq!(empty.0.len(), 1);
}

#[test]
fn words_are_equal_in_both_forms() {
    let word = |message: &str, prefix: &str| message.strip_prefix(prefix).unwrap().to_lowercase();
    for state in JobState::ALL {
        let message = proto::JobState::try_from(state.into_message()).unwrap();
        assert_eq!(word(message.as_str_name(), "JOB_STATE_"), state.as_str());
    }
    let clock: proto::Clock = Clock::PerJoint.into_message().try_into().unwrap();
    assert_eq!(json!(Clock::PerJoint), word(clock.as_str_name(), "CLOCK_"));
}

/// Messages that have no JSON object of the same fields, and why.
const WITHOUT_JSON: &[(&str, &str)] = &[
    ("PutRobotRequest", "REST has name and robot in address and body"),
    ("GetRobotRequest", "an address in REST"),
    ("DeleteRobotRequest", "an address in REST"),
    ("ListRobotsRequest", "an address in REST"),
    ("ListRobotsResponse", "a list in REST"),
    ("GetJobRequest", "an address in REST"),
    ("ListJobsRequest", "query parameters in REST"),
    ("CancelJobRequest", "an address in REST"),
    ("WatchJobRequest", "an address in REST"),
    ("GetResultRequest", "an address in REST"),
    ("ResultChunk", "REST sends the result whole"),
    ("Shape", "JSON has the solid's fields beside a `type`"),
    ("LinkPair", "a list in JSON"),
    ("Point", "a list in JSON"),
    ("RobotRef", "JSON has the name or the robot itself"),
    ("Task", "JSON has the task's fields beside a `type`"),
    ("PlanResult", "JSON has the fields of the one or the other"),
    ("JobRequest", "JSON has the plan's fields beside the job's"),
    ("JobEvent", "JSON has the event's fields beside a `type`"),
    ("Configuration", "a list in JSON"),
    ("Waypoint", "a list in JSON, or an object with a pose"),
    ("Piece", "a list in JSON"),
    ("Polynomial", "a list in JSON"),
    ("OptionalNumbers", "a list in JSON"),
    ("OptionalNumber", "a number or null in JSON"),
    ("LimitOverride", "null, a number or a list in JSON"),
    ("ViaTolerance", "a number or a list in JSON"),
    ("DurationGoal", "JSON has one of its fields at a time"),
    ("OptimizerChoice", "JSON has the parameters beside the name"),
    ("MethodChoice", "JSON has the parameters beside the name"),
    ("PlannerChoice", "JSON has the parameters beside the name"),
    ("SmoothingChoice", "JSON has the parameters beside the name"),
    ("Obstacle", "JSON has the obstacle's fields beside a `type`"),
    ("SceneRef", "JSON has the name or the scene itself"),
    ("NamePair", "a list in JSON"),
    ("MotionEnd", "JSON has one of its fields at a time"),
];

/// An object of the JSON form for every other message.
fn objects() -> BTreeMap<&'static str, Value> {
    let request = serde_json::to_value(JobRequest::parse(job_request()).unwrap()).unwrap();
    let mut plan = request.clone();
    for member in ["priority", "deadline_s", "start_by", "labels"] {
        plan.as_object_mut().unwrap().shift_remove(member).unwrap();
    }
    // What is written, not what is read: there every field is named.
    let robot = serde_json::to_value(parsed::<RobotDescription>(robot())).unwrap();
    let Task::Waypoints(task) =
        PlanRequest::parse(json!({"robot": "r", "task": waypoints_task()})).unwrap().task
    else {
        panic!("a waypoints task");
    };
    let task = serde_json::to_value(task).unwrap();
    let result: PlanResult = parsed(trajectory_result());
    let result = serde_json::to_value(result).unwrap();
    let program = serde_json::to_value(parsed::<PlanResult>(program_result())).unwrap();
    let comparison = serde_json::to_value(parsed::<PlanResult>(comparison_result())).unwrap();
    let task_of = |task: Value| {
        let request = PlanRequest::parse(json!({ "task": task })).unwrap();
        serde_json::to_value(request.task).unwrap()
    };
    let job = serde_json::to_value(parsed::<Job>(job())).unwrap();
    let [state, progress, finished] = events();
    let without = |mut event: Value, members: &[&str]| {
        members.iter().for_each(|it| drop(event.as_object_mut().unwrap().shift_remove(*it)));
        event
    };
    let certificate = &result["certificate"];
    let links = serde_json::to_value(parsed::<KinematicsDescription>(links())).unwrap();
    let urdf = serde_json::to_value(parsed::<KinematicsDescription>(urdf())).unwrap();
    // The fields of all three forms.
    let mut kinematics = robot["kinematics"].clone();
    for form in [&links, &urdf] {
        kinematics.as_object_mut().unwrap().extend(form.as_object().unwrap().clone());
    }
    let mut objects = BTreeMap::from([
        ("Robot", robot.clone()),
        ("Joint", robot["joints"][0].clone()),
        ("JointLimits", robot["joints"][0]["limits"].clone()),
        ("JointProvenance", robot["joints"][0]["provenance"].clone()),
        ("Kinematics", kinematics),
        ("LinkDescription", links["links"][0].clone()),
        ("DhRow", robot["kinematics"]["rows"][0].clone()),
        ("Pose", robot["kinematics"]["base"].clone()),
        ("Body", robot["geometry"][0].clone()),
        ("BoxShape", without(robot["geometry"][0]["shape"].clone(), &["type"])),
        ("SphereShape", without(robot["geometry"][1]["shape"].clone(), &["type"])),
        ("CapsuleShape", without(robot["geometry"][2]["shape"].clone(), &["type"])),
        ("CylinderShape", without(robot["geometry"][3]["shape"].clone(), &["type"])),
        ("ConvexHullShape", without(robot["geometry"][4]["shape"].clone(), &["type"])),
        ("PutRobotResponse", json!({"robot": 0, "created": 0})),
        ("RobotSummary", serde_json::to_value(robot_summary()).unwrap()),
        ("PlanRequest", plan),
        ("WaypointsTask", task.clone()),
        ("DurationRange", task["durations"].clone()),
        ("EndMotion", task["start"].clone()),
        ("ObjectiveWeights", task["objective"].clone()),
        ("ParetoRequest", task["pareto"].clone()),
        ("ProgramTask", without(request["task"].clone(), &["type"])),
        ("Leg", request["task"]["legs"][0].clone()),
        ("LimitOverrides", request["limits"].clone()),
        ("LimitScale", request["limit_scale"].clone()),
        ("Job", job.clone()),
        ("JobError", job["error"].clone()),
        ("ListJobsResponse", json!({"jobs": 0, "next_page_token": 0})),
        ("StateChange", without(state, &["seq", "time", "type"])),
        ("Progress", without(progress, &["seq", "time", "type"])),
        ("ResultSummary", finished["summary"].clone()),
        ("Finished", without(finished, &["seq", "time", "type"])),
    ]);
    let problem = &comparison["problems"][0];
    let mut comparison_task = task_of(comparison_task());
    comparison_task["task"] = json!(0);
    objects.extend([
        ("ComparisonTask", without(comparison_task.clone(), &["type"])),
        ("ComparedProblem", comparison_task["problems"][0].clone()),
        ("BenchmarkTask", without(task_of(benchmark_task()), &["type"])),
        ("ComparisonResult", comparison.clone()),
        ("ProblemResult", problem.clone()),
        ("KnownOptimum", problem["optimum"].clone()),
        ("BestRun", problem["best_run"].clone()),
        ("MethodResult", problem["methods"][0].clone()),
        ("EvaluationQuartiles", problem["methods"][0]["evaluations_to_success"].clone()),
        ("CurvePoint", problem["methods"][0]["curve"][1].clone()),
    ]);
    let family = serde_json::to_value(parsed::<PlanResult>(family_result())).unwrap();
    let mut family_task = task_of(family_task());
    family_task["sweep"] = task_of(sweep_task())["sweep"].clone();
    objects.extend([
        ("FamilyTask", without(family_task.clone(), &["type"])),
        ("FamilyProblem", family_task["problem"].clone()),
        ("FamilyMember", family_task["members"][0].clone()),
        ("SweepAxis", family_task["sweep"][0].clone()),
        ("FamilyResult", family.clone()),
        ("MemberResult", {
            let mut member = family["members"][0].clone();
            member["failure"] = family["members"][1]["failure"].clone();
            member
        }),
        ("MostBinding", family["members"][0]["most_binding"].clone()),
        ("MemberFailure", family["members"][1]["failure"].clone()),
        ("MembersDone", json!({"done": 0, "of": 0, "failed": 0, "slowest": 0})),
    ]);
    let path = serde_json::to_value(parsed::<PlanResult>(path_result())).unwrap();
    let path_task = task_of(path_task());
    let obstacle =
        |index: usize| without(path_task["space"]["obstacles"][index].clone(), &["type"]);
    objects.extend([
        ("PathTask", without(path_task.clone(), &["type"])),
        ("Space", path_task["space"].clone()),
        ("BallObstacle", obstacle(0)),
        ("BoxObstacle", obstacle(1)),
        ("PathResult", path.clone()),
        ("BezierPiece", path["curve"][0].clone()),
        ("TreeEdge", path["tree_edges"][0].clone()),
    ]);
    let motion = serde_json::to_value(PlanRequest::parse(motion_request()).unwrap()).unwrap();
    objects.extend([
        ("MotionTask", without(motion["task"].clone(), &["type"])),
        ("MotionPath", result["motion"].clone()),
        ("Scene", motion["scene"].clone()),
        ("SceneObstacle", motion["scene"]["obstacles"][0].clone()),
        ("AttachedObject", motion["scene"]["attached"][0].clone()),
    ]);
    objects.extend([
        ("ProgramResult", program.clone()),
        ("LegResult", program["legs"][0].clone()),
        ("TrajectoryResult", result.clone()),
        ("Trajectory", result["trajectory"].clone()),
        ("Certificate", certificate.clone()),
        ("JointCertificate", certificate["joints"][0].clone()),
        ("Peak", certificate["joints"][0]["velocity"].clone()),
        ("PositionRange", certificate["joints"][0]["position"].clone()),
        ("Violation", certificate["violations"][0].clone()),
        ("Clearance", certificate["clearance"].clone()),
        ("LowerBound", result["bound"].clone()),
        ("PlanMetrics", result["metrics"].clone()),
        ("Measures", result["metrics"]["objective"].clone()),
        ("ParetoFront", result["pareto"].clone()),
        ("ParetoAxis", result["pareto"]["objectives"][0].clone()),
        ("ParetoPoint", result["pareto"]["points"][0].clone()),
        ("Binding", result["metrics"]["binding"][0].clone()),
        ("Sensitivity", result["metrics"]["sensitivities"][0].clone()),
        ("JointOptimum", result["per_joint"][0].clone()),
        ("ConvergencePoint", result["convergence"][0].clone()),
    ]);
    objects
}

#[test]
fn fields_have_one_name_in_both_forms() {
    let set = FileDescriptorSet::decode(proto::FILE_DESCRIPTOR_SET).unwrap();
    let ours = set.file.iter().filter(|file| file.package() == "takt.v1");
    let messages: Vec<&DescriptorProto> = ours.flat_map(|file| &file.message_type).collect();
    let objects = objects();
    for message in &messages {
        let name = message.name();
        if WITHOUT_JSON.iter().any(|(without, _)| *without == name) {
            continue;
        }
        let object = objects.get(name).unwrap_or_else(|| panic!("no JSON form of {name}"));
        let keys: BTreeSet<_> = object.as_object().unwrap().keys().map(String::as_str).collect();
        let fields: BTreeSet<_> = message.field.iter().map(|field| field.name()).collect();
        assert_eq!(fields, keys, "{name}");
    }
    let without = WITHOUT_JSON.iter().map(|(name, _)| *name);
    let known: BTreeSet<_> = objects.keys().copied().chain(without).collect();
    assert_eq!(known, messages.iter().map(|message| message.name()).collect());
}

mod chunked {
    use super::*;

    fn long_result(pieces: usize) -> PlanResult {
        let mut result = trajectory_result();
        let count = |template: &Value| vec![template.clone(); pieces];
        result["durations"] = json!(vec![1.0; pieces]);
        result["trajectory"]["pieces"] = json!(count(&result["trajectory"]["pieces"][0]));
        result["convergence"] = json!(count(&result["convergence"][1]));
        result["metrics"]["binding"] = json!(count(&result["metrics"]["binding"][0]));
        result["certificate"]["violations"] = json!(count(&result["certificate"]["violations"][0]));
        parsed(result)
    }

    #[test]
    fn a_small_result_is_one_chunk() {
        let chunks = chunks::split(parsed::<PlanResult>(trajectory_result()).into_message());
        assert_eq!(chunks.len(), 1);
        let chunks = chunks::split(parsed::<PlanResult>(program_result()).into_message());
        assert_eq!(chunks.len(), 3);
        let result = parsed::<PlanResult>(comparison_result());
        let chunks = chunks::split(result.clone().into_message());
        assert_eq!(chunks.len(), 2);
        assert_eq!(chunks::join(chunks), Ok(result));
        // The head, two members, the worst case.
        let chunks = chunks::split(parsed::<PlanResult>(family_result()).into_message());
        assert_eq!(chunks.len(), 4);
    }

    #[test]
    fn a_large_result_is_split_below_the_limit_and_joined_again() {
        let long = long_result(30_000);
        let PlanResult::Trajectory(trajectory) = long.clone() else { panic!("a trajectory") };
        let PlanResult::Program(mut program) = parsed(program_result()) else {
            panic!("a program");
        };
        program.legs[1].result = *trajectory;
        for result in [long, PlanResult::Program(program)] {
            let message: proto::PlanResult = result.clone().into_message();
            assert!(message.encoded_len() > 4 << 20);
            let chunks = chunks::split(message);
            assert!(chunks.len() > 4);
            assert!(chunks.iter().all(|chunk| chunk.encoded_len() < 2 << 20));
            assert_eq!(chunks::join(chunks), Ok(result));
        }
    }

    #[test]
    fn chunks_out_of_order_are_refused() {
        let program = || chunks::split(parsed::<PlanResult>(program_result()).into_message());
        let mut headless = program();
        headless.remove(0);
        let mut twice = program();
        twice.extend(program());
        let mut compared = chunks::split(parsed::<PlanResult>(comparison_result()).into_message());
        compared.remove(0);
        let mut member = chunks::split(parsed::<PlanResult>(family_result()).into_message());
        member.remove(0);
        for wrong in
            [headless, twice, compared, member, Vec::new(), vec![proto::ResultChunk { part: None }]]
        {
            assert!(chunks::join(wrong).is_err());
        }
    }
}
