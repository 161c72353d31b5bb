//! Accepted means kept: if this fails, jobs are lost or planned twice.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use reqwest::Client;
use serde_json::Value;
use takt::math::random::RandomStream;
use tokio::sync::{RwLock, watch};

use crate::support::{Process, short, timeless};

const JOBS: usize = 2_000;
const CLIENTS: usize = 16;
/// Different requests among the jobs; equal ones must get equal results.
const SEEDS: u64 = 40;

/// Submits jobs until all are accepted. A request that broke off is sent again
/// under the same key, so that it counts once.
async fn client(
    number: usize,
    base: watch::Receiver<String>,
    accepted: Arc<RwLock<HashMap<String, u64>>>,
    count: Arc<AtomicUsize>,
) {
    let http = Client::builder().timeout(Duration::from_secs(10)).build().unwrap();
    for job in (number..JOBS).step_by(CLIENTS) {
        let seed = job as u64 % SEEDS;
        loop {
            let url = format!("{}/v1/jobs", base.borrow().clone());
            let request = http.post(&url).header("idempotency-key", format!("job-{job}"));
            if let Ok(response) = request.json(&short(seed)).send().await
                && response.status().is_success()
                && let Ok(body) = response.json::<Value>().await
            {
                let id = body["id"].as_str().unwrap().to_owned();
                accepted.write().await.insert(id, seed);
                count.fetch_add(1, Ordering::SeqCst);
                break;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn every_accepted_job_survives_three_kills() {
    let directory = tempfile::tempdir().unwrap();
    let mut server = Process::start(directory.path());
    let (announce, base) = watch::channel(server.base.clone());
    let accepted = Arc::new(RwLock::new(HashMap::new()));
    let count = Arc::new(AtomicUsize::new(0));
    let clients: Vec<_> = (0..CLIENTS)
        .map(|number| tokio::spawn(client(number, base.clone(), accepted.clone(), count.clone())))
        .collect();

    // Three random moments, told by how far the clients are.
    let mut random = RandomStream::new(0x7a4b, 0);
    for kill in 0..3usize {
        let moment = (JOBS * kill / 3) + (random.unit() * JOBS as f64 / 3.5) as usize;
        while count.load(Ordering::SeqCst) < moment {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        server.kill();
        server = Process::start(directory.path());
        announce.send(server.base.clone()).unwrap();
    }
    for client in clients {
        client.await.unwrap();
    }

    let http = Client::new();
    let accepted = accepted.read().await;
    assert_eq!(accepted.len(), JOBS, "keys were answered with the job they named first");
    let mut by_seed: HashMap<u64, String> = HashMap::new();
    let mut restarted = 0;
    for (id, seed) in accepted.iter() {
        let url = format!("{}/v1/jobs/{id}", server.base);
        let job = loop {
            let job: Value = http.get(&url).send().await.unwrap().json().await.unwrap();
            match job["state"].as_str().unwrap() {
                "queued" | "running" => tokio::time::sleep(Duration::from_millis(5)).await,
                _ => break job,
            }
        };
        assert_eq!(job["state"], "succeeded", "{job}");
        restarted += usize::from(job["attempt"].as_u64().unwrap() > 1);
        let result = http.get(format!("{url}/result")).send().await.unwrap();
        let result = timeless(result.json().await.unwrap());
        let first = by_seed.entry(*seed).or_insert_with(|| result.clone());
        assert_eq!(*first, result, "job {id} of seed {seed}");
        // It ended once: one terminal event, and it is the last.
        let events = http.get(format!("{url}/events")).send().await.unwrap().text().await.unwrap();
        assert_eq!(events.matches("event: finished").count(), 1, "{events}");
    }
    println!("{JOBS} jobs, 3 kills, {restarted} jobs ran again");

    // The same without kills: planned in this process.
    for (seed, result) in by_seed {
        assert_eq!(result, undisturbed(seed), "seed {seed}");
    }
}

fn undisturbed(seed: u64) -> String {
    use takt::budget::Budget;
    use takt::plan::{PlanRequest, validate};
    let request = PlanRequest::parse(short(seed)).unwrap();
    let plan = validate(&request, &|_| None).unwrap_or_else(|faults| panic!("{faults}"));
    let result = plan.run(&Budget::default(), &|_| {}).unwrap();
    // Numbers are compared as the service writes them.
    let text = serde_json::to_string(&result).unwrap();
    timeless(serde_json::from_str(&text).unwrap())
}
