//! Comparisons and benchmarks over both edges.

use futures::StreamExt;
use serde_json::{Value, json};
use takt::grpc::join;
use takt::grpc::proto::job_event::Kind;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::{GetResultRequest, WatchJobRequest};
use takt::plan::PlanResult;

use crate::support::*;

#[tokio::test]
async fn a_comparison_is_served_in_every_form() {
    let server = Server::start().await;
    let job = server.succeeded(&comparison_job()).await;
    let about = server.json(&job).await;
    assert_eq!((&about["task"], &about["method"]), (&json!("comparison"), &json!("3 methods")));
    assert_eq!(about["robot"], "pair");
    let result = server.json(&format!("{job}/result")).await;
    let methods = result["problems"][0]["methods"].as_array().unwrap();
    let labels: Vec<_> = methods.iter().map(|row| row["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["pso", "cfpso", "exact"]);

    let mut metrics = server.json(&format!("{job}/metrics")).await;
    for (row, full) in
        metrics["problems"][0]["methods"].as_array_mut().unwrap().iter_mut().zip(methods)
    {
        assert_eq!(row["curve"], json!([]));
        row["curve"] = full["curve"].clone();
    }
    assert_eq!(metrics, result);

    let curves = server.json(&format!("{job}/convergence")).await;
    assert_eq!(curves["problems"][0]["methods"][1]["curve"], methods[1]["curve"]);
    let csv = server.get(&format!("{job}/convergence?format=csv")).await.text().await.unwrap();
    let points: usize = methods.iter().map(|row| row["curve"].as_array().unwrap().len()).sum();
    assert_eq!(csv.lines().count(), points + 1);
    let svg = server.get(&format!("{job}/convergence?format=svg")).await;
    assert_eq!(header(&svg, "content-type"), "image/svg+xml");
    let page = server.get(&format!("{job}/page")).await;
    assert_eq!(header(&page, "content-type"), "text/html; charset=utf-8");
    assert!(header(&page, "content-security-policy").contains("default-src 'none'"));
    assert!(page.text().await.unwrap().contains("did best"));
}

#[tokio::test]
async fn what_a_result_has_not_is_a_problem() {
    let server = Server::start().await;
    let compared = server.succeeded(&benchmark_job()).await;
    assert_eq!(server.json(&compared).await["robot"], "-");
    for view in ["certificate", "trajectory", "plot.svg", "metrics?leg=f9", "convergence?leg=f9"] {
        problem(server.get(&format!("{compared}/{view}")).await, 404, "not_found").await;
    }
    let several = server.get(&format!("{compared}/convergence?format=svg")).await;
    problem(several, 422, "invalid").await;
    let one = server.get(&format!("{compared}/convergence?format=svg&leg=f7")).await;
    assert_eq!(one.status(), 200);
    let planned = server.succeeded(&quick_job()).await;
    problem(server.get(&format!("{planned}/page")).await, 404, "not_found").await;
}

#[tokio::test]
async fn a_running_comparison_can_be_cancelled() {
    let server = Server::start().await;
    let mut endless = benchmark_job();
    endless["task"]["iterations"] = json!(1_000_000);
    endless["task"]["runs"] = json!(50);
    let job = server.submit(&endless).await;
    server.runs(&job).await;
    server.post(&format!("{job}/cancel"), &Value::Null).await;
    assert_eq!(state(&server.ended(&job).await), "cancelled");
}

#[tokio::test]
async fn grpc_tells_the_method_and_the_whole_result() {
    let server = Server::start().await;
    let job = server.succeeded(&comparison_job()).await;
    let id = job.rsplit('/').next().unwrap().to_owned();
    let address = server.address().to_string();
    let mut client = PlanningServiceClient::connect(address).await.unwrap();
    let watch = WatchJobRequest { id: id.clone(), after_seq: 0 };
    let events = client.watch_job(watch).await.unwrap().into_inner();
    let events: Vec<_> = events.map(|event| event.unwrap().kind.unwrap()).collect().await;
    assert!(events.iter().any(|kind| match kind {
        Kind::Progress(progress) => progress.method.is_some() && progress.leg.is_some(),
        _ => false,
    }));
    let Some(Kind::Finished(finished)) = events.last() else { panic!("not finished") };
    let summary = finished.summary.as_ref().unwrap();
    assert_eq!((summary.duration, summary.legs), (None, 1));
    assert!(summary.verdict().contains("did best"));

    let chunks = client.get_result(GetResultRequest { id, partial: false }).await.unwrap();
    let chunks: Vec<_> = chunks.into_inner().map(Result::unwrap).collect().await;
    let result: PlanResult =
        serde_json::from_value(server.json(&format!("{job}/result")).await).unwrap();
    assert_eq!(join(chunks), Ok(result));
}
