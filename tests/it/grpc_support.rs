//! A server of both edges whose planner does as the seed tells.

#![expect(clippy::unwrap_used, reason = "a test fails by a panic")]

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};
use takt::grpc;
use takt::grpc::proto::planning_service_client::PlanningServiceClient;
use takt::grpc::proto::{self, JobRequest, PlanRequest, RobotRef, robot_ref, task};
use takt::http::{self, HttpSettings};
use takt::job::{JobSettings, Jobs, Metrics, Progress, RunContext, RunOutcome, Runner};
use takt::plan::PlanResult;
use takt::service::{ResultSummary, Service};
use takt::store::SqliteStore;
use tempfile::TempDir;
use tonic::transport::Channel;

/// The job succeeds after [`PROGRESS_EVENTS`] with a small result.
pub const SUCCEEDS: u64 = 0;
/// The job runs until it is cancelled.
pub const ENDLESS: u64 = 1;
/// The job succeeds with a result of more than 4 MiB.
pub const LARGE: u64 = 2;
/// The job fails and leaves part of a plan.
pub const FAILS: u64 = 3;

/// What a plan needs for more than 4 MiB.
const MANY_PIECES: usize = 40_000;

pub struct Server {
    pub address: SocketAddr,
    pub service: Service,
    _directory: TempDir,
}

impl Server {
    pub async fn start() -> Self {
        const MAX_BYTES: usize = 1 << 20;
        let directory = tempfile::tempdir().unwrap();
        let metrics = Arc::new(Metrics::new().unwrap());
        let store = SqliteStore::open(&directory.path().join("takt.db"), metrics.clone()).unwrap();
        let settings = JobSettings { workers: 1, queue_capacity: 4 };
        let store = Arc::new(store);
        let jobs = Jobs::start(store.clone(), Arc::new(Scripted), metrics.clone(), settings);
        let service = Service::new(jobs.await.unwrap(), store, metrics);
        let grpc = grpc::routes(service.clone(), MAX_BYTES).unwrap();
        let router = http::routes(service.clone(), HttpSettings { max_body_bytes: MAX_BYTES })
            .merge(grpc)
            .layer(axum::middleware::from_fn(grpc::answer_unknown_methods));
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(axum::serve(listener, router).into_future());
        Self { address, service, _directory: directory }
    }

    pub async fn channel(&self) -> Channel {
        let address = format!("http://{}", self.address);
        Channel::from_shared(address).unwrap().connect().await.unwrap()
    }

    pub async fn planning(&self) -> PlanningServiceClient<Channel> {
        PlanningServiceClient::new(self.channel().await)
    }

    /// Creates a job that does what `script` says.
    pub async fn create(&self, script: u64) -> proto::Job {
        self.planning().await.create_job(job_request(script)).await.unwrap().into_inner()
    }

    /// Waits for the end of job `id`.
    pub async fn ended(&self, id: &str) -> proto::JobState {
        let end = self.service.wait_ended(id.parse().unwrap(), Duration::from_secs(60));
        end.await.unwrap();
        let request = proto::GetJobRequest { id: id.to_owned() };
        self.planning().await.get_job(request).await.unwrap().into_inner().state()
    }
}

/// Two waypoints for a robot of four joints, planned as the seed says.
pub fn job_request(seed: u64) -> JobRequest {
    let waypoints = [[0.0, 0.0, 0.0, 0.0], [0.1, 0.1, 0.05, 0.1]];
    let waypoints =
        waypoints.map(|it| proto::Waypoint { values: it.to_vec(), ..<_>::default() }).to_vec();
    let task = proto::WaypointsTask { waypoints, ..<_>::default() };
    let robot = robot_ref::Kind::Inline(robot("four"));
    let plan = PlanRequest {
        robot: Some(RobotRef { kind: Some(robot) }),
        task: Some(proto::Task { kind: Some(task::Kind::Waypoints(task)) }),
        seed,
        ..<_>::default()
    };
    JobRequest { plan: Some(plan), ..<_>::default() }
}

/// A robot of four turning joints with velocity and acceleration limits.
pub fn robot(name: &str) -> proto::Robot {
    let joint = |number: usize| proto::Joint {
        name: format!("j{number}"),
        r#type: proto::JointType::Revolute.into(),
        limits: Some(proto::JointLimits {
            velocity: Some(1.0),
            acceleration: Some(2.0),
            ..<_>::default()
        }),
        provenance: None,
    };
    proto::Robot { name: name.to_owned(), joints: (1..=4).map(joint).collect(), ..<_>::default() }
}

/// What the scripted planner answers.
pub fn result(script: u64) -> PlanResult {
    let pieces = if script == LARGE { MANY_PIECES } else { 2 };
    let polynomial = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5];
    let piece = vec![polynomial; 4];
    let certificate = json!({"lawful": true, "worst_ratio": 0.9, "continuity": 4,
        "starts_at_rest": true, "ends_at_rest": true, "joints": [], "violations": [],
        "waypoint_error": 0.0, "clearance": null, "sha256": "ab"});
    let metrics = json!({"initial_duration": 4.0, "saved": 0.5, "rms_jerk": [], "binding": [],
        "mean_utilisation": [null, 0.5], "path_length": []});
    let value = json!({
        "robot": "four", "joint_names": ["j1", "j2", "j3", "j4"], "joint_units": ["rad"],
        "duration": 2.0, "durations": vec![1.0; pieces], "waypoint_times": [0.0, 2.0],
        "waypoints": [[0.0], [1.0]],
        "trajectory": {"breakpoints": (0..=pieces).collect::<Vec<_>>(),
            "pieces": vec![piece; pieces]},
        "certificate": certificate, "bound": null, "metrics": metrics, "convergence": [],
        "interpolation": "quintic", "optimizer": "exact", "stop_reason": "converged",
        "iterations": 1, "evaluations": 2, "planning_s": 0.5, "seed": script, "version": "0",
    });
    serde_json::from_value(value).unwrap()
}

/// Progress events of a job that succeeds.
pub const PROGRESS_EVENTS: u64 = 1;

struct Scripted;

impl Runner for Scripted {
    fn run(&self, request: &str, context: &RunContext<'_>) -> RunOutcome {
        let request: Value = serde_json::from_str(request).unwrap();
        let script = request["seed"].as_u64().unwrap();
        (context.progress)(Progress { iteration: 1, best: Some(2.5), ..<_>::default() });
        if script == ENDLESS {
            while context.cancel.reason().is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
            return RunOutcome::Cancelled { partial: None };
        }
        let result = result(script);
        let summary = serde_json::to_value(ResultSummary::from(&result)).unwrap();
        let result = serde_json::to_string(&result).unwrap();
        if script == FAILS {
            let code = "limits_unreachable".to_owned();
            let details = json!({"joint": "j1"});
            let partial = Some(result);
            return RunOutcome::Failed { code, message: "no".to_owned(), details, partial };
        }
        RunOutcome::Succeeded { result, summary }
    }
}
