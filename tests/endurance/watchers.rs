//! Every watcher sees the same events, whenever it comes. If this fails,
//! screens in a plant disagree about one job.

use futures::StreamExt;
use serde_json::json;
use takt::app::Running;
use takt::config::Config;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::{JobEvent, WatchJobRequest};

use crate::support::short;

const WATCHERS: usize = 1_000;
/// Streams share connections, as they do behind a proxy.
const CONNECTIONS: usize = 10;

async fn watch(
    mut client: PlanningServiceClient<tonic::transport::Channel>,
    id: String,
) -> Vec<JobEvent> {
    let request = WatchJobRequest { id, after_seq: 0 };
    let events = client.watch_job(request).await.unwrap().into_inner();
    events.map(|event| event.unwrap()).collect().await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thousand_watchers_see_the_same() {
    let directory = tempfile::tempdir().unwrap();
    let mut config = Config::load(None, [], []).unwrap();
    config.data_dir = directory.path().to_owned();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let server = Running::start(&config, listener).await.unwrap();
    let base = format!("http://{}", server.address());

    // Long enough for progress to be thinned: the job ends by cancellation.
    let mut job = short(1);
    job["task"]["optimizer"]["iterations"] = json!(1_000_000_000u64);
    let http = reqwest::Client::new();
    let created = http.post(format!("{base}/v1/jobs")).json(&job).send().await.unwrap();
    let created: serde_json::Value = created.json().await.unwrap();
    let id = created["id"].as_str().unwrap().to_owned();

    let mut clients = Vec::new();
    for _ in 0..CONNECTIONS {
        clients.push(PlanningServiceClient::connect(base.clone()).await.unwrap());
    }
    let start =
        |number: usize| tokio::spawn(watch(clients[number % CONNECTIONS].clone(), id.clone()));
    let mut watchers: Vec<_> = (0..WATCHERS / 2).map(start).collect();
    // Some join while it runs, once there is a past to be told of.
    let mut first = clients[0].clone();
    let request = WatchJobRequest { id: id.clone(), after_seq: 0 };
    let mut events = first.watch_job(request).await.unwrap().into_inner();
    for _ in 0..12 {
        events.next().await.unwrap().unwrap();
    }
    watchers.extend((WATCHERS / 2..WATCHERS * 3 / 4).map(start));
    let cancelled = http.post(format!("{base}/v1/jobs/{id}/cancel")).send().await.unwrap();
    assert!(cancelled.status().is_success());
    // And some when it is over.
    while events.next().await.is_some() {}
    watchers.extend((WATCHERS * 3 / 4..WATCHERS).map(start));

    let mut sequences = Vec::new();
    for watcher in watchers {
        sequences.push(watcher.await.unwrap());
    }
    let first = &sequences[0];
    assert!(first.len() > 12, "{} events", first.len());
    let numbers: Vec<u64> = first.iter().map(|event| event.seq).collect();
    assert_eq!(numbers, (1..=first.len() as u64).collect::<Vec<_>>());
    for (number, sequence) in sequences.iter().enumerate() {
        assert_eq!(sequence, first, "watcher {number}");
    }
    println!("{} watchers, {} events each", sequences.len(), first.len());
    server.stop().await.unwrap();
}
