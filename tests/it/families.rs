//! Families over both edges, and the timeline of what holds a motion back.

use futures::StreamExt;
use serde_json::{Value, json};
use takt::grpc::join;
use takt::grpc::proto::job_event::Kind;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::{self, GetResultRequest, WatchJobRequest};
use takt::plan::PlanResult;

use crate::support::*;

fn family_job() -> Value {
    let task = quick_job()["task"].take();
    json!({
        "robot": robot("pair"),
        "task": {"type": "family", "problem": {"task": task}, "sweep": [
            {"path": "/limit_scale/acceleration", "values": [1, 0.25]},
            {"path": "/task/duration", "values": [null, {"at_most": 1.5}]}]},
    })
}

#[tokio::test]
async fn a_family_is_served_in_every_form() {
    let server = Server::start().await;
    let job = server.succeeded(&family_job()).await;
    let about = server.json(&job).await;
    assert_eq!((&about["task"], &about["robot"]), (&json!("family"), &json!("pair")));
    let result = server.json(&format!("{job}/result")).await;
    let rows = result["members"].as_array().unwrap();
    let codes: Vec<_> = rows.iter().map(|row| &row["failure"]["code"]).collect();
    let unreachable = json!("limits_unreachable");
    assert_eq!(codes, [&Value::Null, &unreachable, &Value::Null, &unreachable]);
    assert_eq!(result["slowest"], rows[2]["name"]);
    assert_eq!(result["failed"], 2);

    // Every view of a motion speaks of the worst case.
    for view in ["certificate", "metrics"] {
        assert_eq!(server.json(&format!("{job}/{view}")).await, result["worst_case"][view]);
    }
    let curve = server.json(&format!("{job}/convergence")).await;
    assert_eq!(curve["convergence"], result["worst_case"]["convergence"]);
    let trajectory = server.json(&format!("{job}/trajectory")).await;
    assert_eq!(trajectory["pieces"], result["worst_case"]["trajectory"]["pieces"]);
    for view in ["plot.svg", "timeline?format=svg", "convergence?format=svg"] {
        let picture = server.get(&format!("{job}/{view}")).await;
        assert_eq!(header(&picture, "content-type"), "image/svg+xml", "{view}");
    }
    let named = format!("{job}/certificate?leg=acceleration=1,%20duration=null");
    let refused = problem(server.get(&named).await, 404, "not_found").await;
    assert!(refused["detail"].as_str().unwrap().contains("slowest"), "{refused}");
    let page = server.get(&format!("{job}/page")).await;
    assert_eq!(header(&page, "content-type"), "text/html; charset=utf-8");
    let page = page.text().await.unwrap();
    assert!(page.contains("2 of 4 members planned") && page.contains("(slowest)"));

    let stored = server.json(&format!("{job}/request")).await;
    assert_eq!(stored["task"]["sweep"], family_job()["task"]["sweep"]);
}

#[tokio::test]
async fn faults_of_members_are_told_together() {
    let server = Server::start().await;
    let mut job = family_job();
    job["task"]["sweep"] = json!([]);
    job["task"]["members"] = json!([
        {"name": "a", "set": {"task": {"waypoints": [[0, 0], [9, 0]]}}},
        {"name": "b", "set": {"limit_scale": {"jerk": 2}}}]);
    let refused = problem(server.post("/v1/jobs", &job).await, 422, "invalid").await;
    let places: Vec<_> =
        refused["errors"].as_array().unwrap().iter().map(|it| it["pointer"].clone()).collect();
    assert_eq!(
        places,
        ["/task/members/0/set/task/waypoints/1/0", "/task/members/1/set/limit_scale/jerk"]
    );
}

/// Robots are written into accepted jobs; the problem's own as well.
#[tokio::test]
async fn a_family_of_a_registered_robot_is_planned() {
    let server = Server::start().await;
    let mut job = family_job();
    job.as_object_mut().unwrap().remove("robot");
    job["task"]["problem"]["robot"] = json!("ur5e");
    job["task"]["problem"]["task"]["waypoints"] =
        json!([[0, -1.6, 1.2, 0, 0, 0], [0.4, -1.3, 1.4, 0, 0, 0]]);
    job["task"]["problem"]["limits"] = json!({"acceleration": 5, "jerk": 50});
    job["task"]["sweep"] = json!([{"path": "/limit_scale/velocity", "values": [0.5, 1]}]);
    let job = server.succeeded(&job).await;
    assert_eq!(server.json(&job).await["robot"], "ur5e");
}

#[tokio::test]
async fn a_running_family_can_be_cancelled() {
    let server = Server::start().await;
    let mut endless = family_job();
    endless["task"]["problem"]["task"] = endless_job()["task"].take();
    let job = server.submit(&endless).await;
    server.runs(&job).await;
    server.post(&format!("{job}/cancel"), &Value::Null).await;
    assert_eq!(state(&server.ended(&job).await), "cancelled");
}

#[tokio::test]
async fn grpc_takes_a_family_and_tells_its_members_and_result() {
    let server = Server::start().await;
    let plan = takt::plan::PlanRequest::parse(family_job()).unwrap();
    let number = |value: f64| prost_types::Value {
        kind: Some(prost_types::value::Kind::NumberValue(value)),
    };
    let waypoints = |task: takt::plan::Task| match task {
        takt::plan::Task::Family(family) => family.problem.task,
        _ => panic!("a family"),
    };
    let rows = waypoints(plan.task).waypoints.into_iter();
    let rows = rows.map(|waypoint| match waypoint {
        takt::plan::Waypoint::Joints(values) => proto::Waypoint { values, ..<_>::default() },
        takt::plan::Waypoint::Pose(_) => panic!("joints"),
    });
    let rows = rows.collect();
    let task = proto::WaypointsTask { waypoints: rows, ..<_>::default() };
    let family = proto::FamilyTask {
        problem: Some(proto::FamilyProblem { task: Some(task), ..<_>::default() }),
        members: Vec::new(),
        sweep: vec![proto::SweepAxis {
            path: "/limit_scale/acceleration".to_owned(),
            values: vec![number(1.0), number(0.25)],
        }],
    };
    server
        .request(reqwest::Method::PUT, "/v1/robots/pair")
        .json(&robot("pair"))
        .send()
        .await
        .unwrap();
    let request = proto::JobRequest {
        plan: Some(proto::PlanRequest {
            robot: Some(proto::RobotRef {
                kind: Some(proto::robot_ref::Kind::Name("pair".into())),
            }),
            task: Some(proto::Task { kind: Some(proto::task::Kind::Family(family)) }),
            ..<_>::default()
        }),
        ..<_>::default()
    };
    let address = server.address().to_string();
    let mut client = PlanningServiceClient::connect(address).await.unwrap();
    let id = client.create_job(request).await.unwrap().into_inner().id;
    let watch = WatchJobRequest { id: id.clone(), after_seq: 0 };
    let events = client.watch_job(watch).await.unwrap().into_inner();
    let events: Vec<_> = events.map(|event| event.unwrap().kind.unwrap()).collect().await;
    let members: Vec<_> = events
        .iter()
        .filter_map(|kind| match kind {
            Kind::Progress(progress) => progress.members,
            _ => None,
        })
        .collect();
    assert!(members.iter().all(|members| members.of == 2) && !members.is_empty());
    let Some(Kind::Finished(finished)) = events.last() else { panic!("not finished") };
    let summary = finished.summary.as_ref().unwrap();
    assert_eq!(summary.legs, 2);
    assert!(summary.verdict().contains("2 of 2 members"));

    let chunks =
        client.get_result(GetResultRequest { id: id.clone(), partial: false }).await.unwrap();
    let chunks: Vec<_> = chunks.into_inner().map(Result::unwrap).collect().await;
    let result = server.json(&format!("/v1/jobs/{id}/result")).await;
    let result: PlanResult = serde_json::from_value(result).unwrap();
    assert_eq!(join(chunks), Ok(result.clone()));
    let PlanResult::Family(result) = result else { panic!("a family") };
    assert_eq!(summary.duration, Some(result.worst_case.duration));
}

#[tokio::test]
async fn timelines_come_per_leg_of_a_program() {
    let server = Server::start().await;
    let single = server.succeeded(&quick_job()).await;
    let timeline = server.json(&format!("{single}/timeline")).await;
    let result = server.json(&format!("{single}/result")).await;
    assert_eq!(timeline["duration"], result["duration"]);
    let joints = timeline["joints"].as_array().unwrap();
    assert_eq!(joints.len(), 2);
    // A quintic as fast as can be is at some limit for a moment at least.
    assert!(timeline["held"].as_f64().unwrap() > 0.0);

    let program = server.succeeded(&program_job()).await;
    let all = server.json(&format!("{program}/timeline")).await;
    assert_eq!(all["legs"].as_array().unwrap().len(), 2);
    let leg = server.json(&format!("{program}/timeline?leg=BC")).await;
    assert_eq!(leg["held"], all["legs"][1]["held"]);
    let svg = server.get(&format!("{program}/timeline?format=svg")).await.text().await.unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("what holds it back"));
    let compared = server.succeeded(&benchmark_job()).await;
    problem(server.get(&format!("{compared}/timeline")).await, 404, "not_found").await;
}
