//! What whoever runs the service meets: failures, repetitions, figures.

use std::future::pending;

use futures::future::join_all;
use reqwest::Method;
use serde_json::{Value, json};
use takt::app::{self, AppError};
use takt::config::Config;

use crate::support::*;

#[tokio::test]
async fn a_failed_store_refuses_everything_and_asks_for_a_new_start() {
    let mut server = Server::start().await;
    let address = server.succeeded(&quick_job()).await;
    assert_eq!(server.get("/healthz").await.status(), 200);
    server.break_store();
    problem(server.post("/v1/jobs", &quick_job()).await, 503, "unavailable").await;
    for path in ["/healthz", "/readyz", &address, &format!("{address}/events")] {
        problem(server.get(path).await, 503, "unavailable").await;
    }
    problem(server.post("/v1/jobs", &quick_job()).await, 503, "unavailable").await;
    // What needs no store is still there, and the server ends in order.
    assert_eq!(server.get("/metrics").await.status(), 200);
    server.take().stop().await.unwrap();
}

// A process that stayed up would refuse all jobs until somebody noticed.
#[tokio::test]
async fn a_failed_store_ends_the_process_with_an_error() {
    let directory = tempfile::tempdir().unwrap();
    let mut config = Config::load(None, [], []).unwrap();
    config.data_dir = directory.path().to_owned();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let served = tokio::spawn(async move { app::run(&config, listener, pending()).await });
    let jobs = format!("http://{address}/v1/jobs");
    let client = reqwest::Client::new();
    let submit = || client.post(&jobs).json(&endless_job()).send();
    assert_eq!(submit().await.unwrap().status(), 202);
    break_store(directory.path());
    // It may have failed already with the first job's next event, and be gone.
    if let Ok(refused) = submit().await {
        assert_eq!(refused.status(), 503);
    }
    let error = served.await.unwrap().unwrap_err();
    assert!(matches!(error, AppError::Failed(_)), "{error}");
}

#[tokio::test]
async fn a_draining_server_lives_and_is_not_ready() {
    let server = Server::start().await;
    let address = server.submit(&endless_job()).await;
    server.runs(&address).await;
    let events = server.get(&format!("{address}/events")).await;
    let drained = server.service().drain(std::time::Duration::ZERO).await;
    assert_eq!((drained.interrupted, drained.abandoned), (1, 0));
    let events = events.text().await.unwrap();
    assert!(events.trim_end().ends_with(r#""state":"queued","attempt":0}"#), "{events}");
    assert_eq!(server.get("/healthz").await.status(), 200);
    problem(server.get("/readyz").await, 503, "draining").await;
    problem(server.post("/v1/jobs", &quick_job()).await, 503, "draining").await;
    let job = server.json(&address).await;
    assert_eq!((state(&job), &job["attempt"]), ("queued", &json!(0)));
}

#[tokio::test]
async fn sixteen_clients_with_one_key_make_one_job() {
    let server = Server::start().await;
    let submissions = (0..16).map(|_| {
        let request = server.request(Method::POST, "/v1/jobs").json(&quick_job());
        request.header("Idempotency-Key", "one").send()
    });
    let mut new = 0;
    let mut ids = Vec::new();
    for response in join_all(submissions).await {
        let response = response.unwrap();
        assert_eq!(response.status(), 202);
        new += usize::from(!response.headers().contains_key("idempotent-replayed"));
        ids.push(response.json::<Value>().await.unwrap()["id"].clone());
    }
    ids.dedup();
    assert_eq!((new, ids.len()), (1, 1), "{ids:?}");
    assert_eq!(server.json("/v1/jobs").await["jobs"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn the_figures_agree_with_the_results() {
    let server = Server::start().await;
    let mut swarm = quick_job();
    swarm["task"]["optimizer"] = json!({"name": "pso", "iterations": 5, "population": 10});
    let mut expected = Vec::new();
    for (job, method) in [(quick_job(), "exact/quintic"), (swarm, "pso/quintic")] {
        let address = server.succeeded(&job).await;
        let result = server.json(&format!("{address}/result")).await;
        let evaluations = &result["evaluations"];
        expected.push(format!("takt_evaluations_total{{method=\"{method}\"}} {evaluations}"));
        let labels = format!("method=\"{method}\",task=\"waypoints\"");
        for name in ["takt_job_wait_seconds_count", "takt_job_run_seconds_count"] {
            expected.push(format!("{name}{{{labels}}} 1"));
        }
        let labels = format!("method=\"{method}\",state=\"succeeded\",task=\"waypoints\"");
        expected.push(format!("takt_jobs_ended_total{{{labels}}} 1"));
    }
    for _ in 0..2 {
        problem(server.post("/v1/jobs", &json!({})).await, 422, "invalid").await;
    }
    problem(server.post("/v1/jobs?wait=1", &quick_job()).await, 422, "invalid").await;
    let scrap = server.request(Method::POST, "/v1/jobs").header("Content-Type", "application/json");
    problem(scrap.body("{").send().await.unwrap(), 400, "unreadable").await;
    let untyped = server.request(Method::POST, "/v1/jobs").body("{}");
    problem(untyped.send().await.unwrap(), 415, "unsupported_media_type").await;
    for (code, count) in
        [("invalid", 3), ("unreadable", 1), ("unsupported_media_type", 1), ("unavailable", 0)]
    {
        expected.push(format!("takt_rejections_total{{code=\"{code}\"}} {count}"));
    }
    expected.extend(["takt_queue_depth 0".to_owned(), "takt_jobs_running 0".to_owned()]);
    // A job counts as running for a moment after its end was stored.
    let mut text = String::new();
    for _ in 0..1000 {
        text = server.get("/metrics").await.text().await.unwrap();
        if expected.iter().all(|line| text.lines().any(|found| found == line)) {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    expected.retain(|line| !text.lines().any(|found| found == line));
    panic!("{expected:#?} not in\n{text}");
}

#[tokio::test]
async fn a_list_is_filtered_by_as_many_labels_as_a_job_has() {
    let server = Server::start().await;
    let query = |count: usize| {
        let labels: Vec<_> = (0..count).map(|index| format!("label.k{index}=v")).collect();
        format!("/v1/jobs?{}", labels.join("&"))
    };
    assert_eq!(server.json(&query(64)).await["jobs"], json!([]));
    // SQLite would refuse an expression of this depth.
    problem(server.get(&query(1100)).await, 422, "invalid").await;
}
