//! A busy server stays a good server. If this fails, one long job holds up a line.

use std::time::{Duration, Instant};

use reqwest::{Client, StatusCode};
use serde_json::{Value, json};

use crate::support::{Process, endless, short};

async fn job(http: &Client, url: &str) -> Value {
    http.get(url).send().await.unwrap().json().await.unwrap()
}

/// Waits for a state; fails if another final one comes.
async fn until(http: &Client, url: &str, state: &str) -> Value {
    loop {
        let found = job(http, url).await;
        if found["state"] == state {
            return found;
        }
        assert!(["queued", "running"].contains(&found["state"].as_str().unwrap()), "{found}");
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

async fn submit(http: &Client, base: &str, body: &Value) -> String {
    let response = http.post(format!("{base}/v1/jobs")).json(body).send().await.unwrap();
    assert_eq!(response.status(), StatusCode::ACCEPTED);
    let job: Value = response.json().await.unwrap();
    format!("{base}/v1/jobs/{}", job["id"].as_str().unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn long_jobs_hold_up_nobody() {
    let directory = tempfile::tempdir().unwrap();
    let server = Process::start(directory.path());
    let (base, http) = (server.base.clone(), Client::new());
    let workers = std::thread::available_parallelism().unwrap().get().max(2) - 1;
    let mut long = Vec::new();
    for _ in 0..workers {
        long.push(submit(&http, &base, &endless()).await);
    }
    for url in &long {
        until(&http, url, "running").await;
    }
    // One more long job waits behind them; short ones do not.
    let waiting = submit(&http, &base, &endless()).await;
    for seed in 0..20 {
        let url = submit(&http, &base, &short(seed)).await;
        until(&http, &url, "succeeded").await;
    }
    assert_eq!(job(&http, &waiting).await["state"], "queued");

    // Reading while all workers plan. Printed, because time is no assertion.
    let mut latencies = Vec::new();
    for _ in 0..300 {
        let started = Instant::now();
        assert_eq!(job(&http, &long[0]).await["state"], "running");
        latencies.push(started.elapsed());
    }
    latencies.sort();
    println!("GET while busy: median {:?}, 99 % {:?}", latencies[150], latencies[297]);

    // Cancelled: the waiting one at once, the running one within moments.
    let asked = Instant::now();
    for url in [&waiting, &long[0]] {
        let response = http.post(format!("{url}/cancel")).send().await.unwrap();
        assert!(response.status().is_success());
    }
    until(&http, &waiting, "cancelled").await;
    until(&http, &long[0], "cancelled").await;
    println!("cancelled after {:?}", asked.elapsed());
}

#[tokio::test(flavor = "multi_thread")]
async fn sigterm_drains_and_the_next_start_goes_on() {
    let directory = tempfile::tempdir().unwrap();
    let config = directory.path().join("takt.toml");
    std::fs::write(&config, "drain_s = 0.3\n").unwrap();
    // The process reads its settings from the environment.
    let server =
        Process::start_with(directory.path(), &[("TAKT_CONFIG", config.to_str().unwrap())]);
    let http = Client::new();
    let url = submit(&http, &server.base, &endless()).await;
    until(&http, &url, "running").await;
    let id = url.rsplit('/').next().unwrap().to_owned();
    assert!(server.terminate(), "an orderly end is exit status 0");

    let server = Process::start(directory.path());
    let url = format!("{}/v1/jobs/{id}", server.base);
    let again = until(&http, &url, "running").await;
    assert_eq!(again["attempt"], json!(1), "a drain spends no attempt");
    let response = http.post(format!("{url}/cancel")).send().await.unwrap();
    assert!(response.status().is_success());
    until(&http, &url, "cancelled").await;
}
