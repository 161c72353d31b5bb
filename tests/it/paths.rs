//! Paths of a point over both edges.

use futures::StreamExt;
use serde_json::{Value, json};
use takt::grpc::join;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::{self, GetResultRequest};
use takt::plan::PlanResult;

use crate::support::*;

fn path_job() -> Value {
    json!({
        "task": {
            "type": "path", "start": [10, 50], "goal": [90, 50], "trees": true,
            "space": {"lower": [0, 0], "upper": [100, 100], "obstacles": [
                {"type": "ball", "center": [50, 50], "radius": 20},
                {"type": "box", "lower": [70, 20], "upper": [80, 60]}]},
            "planner": {"name": "rrt_star", "iterations": 500},
            "smoothing": {"name": "bezier"},
        },
    })
}

#[tokio::test]
async fn a_path_is_served_in_every_form() {
    let server = Server::start().await;
    let job = server.succeeded(&path_job()).await;
    let about = server.json(&job).await;
    assert_eq!((&about["task"], &about["robot"]), (&json!("path"), &json!("-")));
    assert_eq!(about["method"], "rrt_star/bezier");
    let result = server.json(&format!("{job}/result")).await;
    let best = result["smoothed_path"].as_array().unwrap();
    assert_eq!((&best[0], &best[best.len() - 1]), (&json!([10.0, 50.0]), &json!([90.0, 50.0])));
    assert!(result["length"].as_f64().unwrap() < 110.0, "{}", result["length"]);
    let curve = server.json(&format!("{job}/convergence")).await;
    assert_eq!(curve["convergence"], result["convergence"]);
    let table = server.get(&format!("{job}/convergence?format=csv")).await.text().await.unwrap();
    assert_eq!(table.lines().count(), 1 + result["convergence"].as_array().unwrap().len());
    for view in ["plot.svg", "convergence?format=svg"] {
        let picture = server.get(&format!("{job}/{view}")).await;
        assert_eq!(header(&picture, "content-type"), "image/svg+xml", "{view}");
    }
    for view in ["trajectory", "certificate", "metrics", "timeline"] {
        let refused = problem(server.get(&format!("{job}/{view}")).await, 404, "not_found").await;
        assert!(refused["detail"].as_str().unwrap().contains("plot.svg"), "{refused}");
    }
    problem(server.get(&format!("{job}/plot.svg?leg=a")).await, 404, "not_found").await;
}

#[tokio::test]
async fn a_start_in_an_obstacle_fails_the_job_and_says_where() {
    let server = Server::start().await;
    let mut job = path_job();
    job["task"]["start"] = json!([50, 66]);
    let job = server.submit(&job).await;
    let ended = server.ended(&job).await;
    assert_eq!(state(&ended), "failed");
    assert_eq!(ended["error"]["code"], "start_in_collision");
    let details = &ended["error"]["details"];
    assert_eq!((&details["obstacle"], &details["depth"]), (&json!(0), &json!(4.0)));
    assert_eq!(details["pointer"], "/task/space/obstacles/0");
}

#[tokio::test]
async fn grpc_takes_a_path_and_returns_its_result_in_chunks() {
    let server = Server::start().await;
    let job = server.succeeded(&path_job()).await;
    let expected = server.json(&format!("{job}/result")).await;
    let mut client = PlanningServiceClient::connect(server.address().to_string()).await.unwrap();
    let id = job.rsplit('/').next().unwrap().to_owned();
    let request = GetResultRequest { id, partial: false };
    let chunks = client.get_result(request).await.unwrap().into_inner();
    let chunks: Vec<proto::ResultChunk> = chunks.map(|chunk| chunk.unwrap()).collect().await;
    assert!(chunks.len() > 3, "{} chunks", chunks.len());
    let joined = join(chunks).unwrap();
    let PlanResult::Path(path) = &joined else { panic!("a path") };
    assert!(!path.tree_edges.is_empty() && path.curve.is_some());
    assert_eq!(serde_json::to_value(&joined).unwrap(), expected);
}
