//! A server on a free port with a directory of its own, and requests to send.

use std::path::Path;
use std::time::Duration;

use reqwest::{Client, Method, RequestBuilder, Response, StatusCode};
use serde_json::{Value, json};
use takt::app::Running;
use takt::config::Config;
use tempfile::TempDir;

/// A server that stops when dropped.
pub struct Server {
    pub client: Client,
    running: Option<Running>,
    base: String,
    directory: TempDir,
}

impl Server {
    pub async fn start() -> Self {
        Self::start_with(|_| {}).await
    }

    /// Starts a server whose settings are changed by `change`.
    pub async fn start_with(change: impl FnOnce(&mut Config)) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let mut config = Config::load(None, [], []).unwrap();
        config.data_dir = directory.path().to_owned();
        config.drain_s = 0.2;
        change(&mut config);
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let running = Running::start(&config, listener).await.unwrap();
        let base = format!("http://{}", running.address());
        Self { client: Client::new(), running: Some(running), base, directory }
    }

    /// Makes every commit fail from now on, as a full disk would.
    pub fn break_store(&self) {
        break_store(self.directory.path());
    }

    /// What it serves, from the inside.
    pub fn service(&self) -> &takt::service::Service {
        self.running.as_ref().unwrap().service()
    }

    /// Takes the server out, to stop it.
    pub fn take(&mut self) -> Running {
        self.running.take().unwrap()
    }

    /// Where both edges answer.
    pub fn address(&self) -> &str {
        &self.base
    }

    pub fn request(&self, method: Method, path: &str) -> RequestBuilder {
        self.client.request(method, format!("{}{path}", self.base))
    }

    pub async fn get(&self, path: &str) -> Response {
        self.request(Method::GET, path).send().await.unwrap()
    }

    pub async fn post(&self, path: &str, body: &Value) -> Response {
        self.request(Method::POST, path).json(body).send().await.unwrap()
    }

    pub async fn delete(&self, path: &str) -> Response {
        self.request(Method::DELETE, path).send().await.unwrap()
    }

    /// The JSON at `path`, which has to be there.
    pub async fn json(&self, path: &str) -> Value {
        let response = self.get(path).await;
        assert_eq!(response.status(), 200, "{path}");
        response.json().await.unwrap()
    }

    /// Submits a job and answers its address.
    pub async fn submit(&self, job: &Value) -> String {
        let response = self.post("/v1/jobs", job).await;
        let location = header(&response, "location");
        let (status, body) = (response.status(), response.text().await.unwrap());
        assert_eq!(status, StatusCode::ACCEPTED, "{body}");
        location
    }

    /// Waits until the job at `address` has ended.
    pub async fn ended(&self, address: &str) -> Value {
        self.until(address, |job| !["queued", "running"].contains(&state(job))).await
    }

    /// Waits until the job at `address` runs.
    pub async fn runs(&self, address: &str) -> Value {
        self.until(address, |job| state(job) == "running").await
    }

    async fn until(&self, address: &str, done: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..6000 {
            let job = self.json(address).await;
            if done(&job) {
                return job;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        panic!("{address} does not come to its end");
    }

    /// Submits a job, waits for its success and answers its address.
    pub async fn succeeded(&self, job: &Value) -> String {
        let address = self.submit(job).await;
        let job = self.ended(&address).await;
        assert_eq!(state(&job), "succeeded", "{job}");
        address
    }
}

/// Makes every commit fail from now on to the database in `directory`.
pub fn break_store(directory: &Path) {
    let database = rusqlite::Connection::open(directory.join("takt.db")).unwrap();
    let poison = "CREATE TABLE poison (job INTEGER REFERENCES jobs DEFERRABLE INITIALLY DEFERRED);
        CREATE TRIGGER poisoning AFTER INSERT ON events
        BEGIN INSERT INTO poison VALUES (-1); END;";
    database.execute_batch(poison).unwrap();
}

pub fn state(job: &Value) -> &str {
    job["state"].as_str().unwrap()
}

pub fn header(response: &Response, name: &str) -> String {
    let value = response.headers().get(name).unwrap_or_else(|| panic!("no header {name}"));
    value.to_str().unwrap().to_owned()
}

/// Checks that `response` is a well-formed problem and answers it.
pub async fn problem(response: Response, status: u16, code: &str) -> Value {
    assert_eq!(header(&response, "content-type"), "application/problem+json");
    let id = header(&response, "x-request-id");
    let found = response.status();
    let problem: Value = response.json().await.unwrap();
    assert_eq!(found, status, "{problem}");
    assert_eq!(problem["status"], status);
    assert_eq!(problem["code"], code, "{problem}");
    assert_eq!(problem["type"], format!("/problems/{}", code.replace('_', "-")));
    assert_eq!(problem["request_id"], id);
    assert!(!problem["detail"].as_str().unwrap().is_empty());
    assert!(!problem["title"].as_str().unwrap().is_empty());
    problem
}

/// A robot with a turning and a sliding joint, all limits known.
pub fn robot(name: &str) -> Value {
    let limits = json!({"lower": -3, "upper": 3, "velocity": 1, "acceleration": 2, "jerk": 10});
    json!({
        "name": name,
        "joints": [
            {"name": "turn", "type": "revolute", "limits": limits},
            {"name": "slide", "type": "prismatic", "limits": limits},
        ],
        "kinematics": {"convention": "standard_dh", "rows": [{"a": 2}, {"d": 0.5}]},
    })
}

/// A job that is done at once.
pub fn quick_job() -> Value {
    json!({
        "robot": robot("pair"),
        "task": {"type": "waypoints", "waypoints": [[0, 0], [0.5, 0.2], [1, 0.1]]},
    })
}

/// A job that runs until it is told to end.
pub fn endless_job() -> Value {
    let mut job = quick_job();
    job["task"]["optimizer"] = json!({"name": "pso", "iterations": 1_000_000_000});
    job
}

/// Two legs, AB and BC.
pub fn program_job() -> Value {
    let leg = |name: &str, waypoints: Value| json!({"name": name, "task": {"type": "waypoints", "waypoints": waypoints}});
    json!({
        "robot": robot("pair"),
        "task": {"type": "program", "legs": [
            leg("AB", json!([[0, 0], [0.5, 0.2], [1, 0.1]])),
            leg("BC", json!([[1, 0.1], [0, 1]])),
        ]},
    })
}

/// Two methods compared on a motion.
pub fn comparison_job() -> Value {
    let task = quick_job()["task"].take();
    json!({
        "robot": robot("pair"),
        "task": {"type": "comparison", "task": task, "runs": 4, "max_evaluations": 300,
            "methods": ["pso", {"name": "cfpso", "population": 30}, "exact"]},
    })
}

/// Two methods compared on two functions.
pub fn benchmark_job() -> Value {
    json!({
        "task": {"type": "benchmark", "functions": ["f1", "f7"], "dimension": 3, "iterations": 20,
            "runs": 3, "optimizers": ["pso", "coa"]},
    })
}
