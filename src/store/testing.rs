//! What the tests of this module share.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use futures::StreamExt;
use rusqlite::Connection;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::sync::mpsc;

use super::SqliteStore;
use crate::budget::StopReason;
use crate::job::{
    Idempotency, Job, JobEvent, JobId, JobSettings, JobState, Jobs, JobsError, Metrics, NewJob,
    Progress, RunContext, RunOutcome, Runner,
};

/// Long enough never to matter unless a test fails.
pub(super) const LONG: Duration = Duration::from_secs(60);

/// A job of middle priority with this request.
pub(super) fn new_job(request: &str) -> NewJob {
    NewJob {
        request: request.to_owned(),
        task: "waypoints".to_owned(),
        method: "exact".to_owned(),
        robot: "sample".to_owned(),
        seed: u64::MAX,
        priority: 50,
        labels: BTreeMap::new(),
        deadline_s: None,
        start_by: None,
        short: false,
        idempotency: None,
    }
}

pub(super) fn with_key(request: &str, key: &str, body: u8) -> NewJob {
    let idempotency = Idempotency { key: key.to_owned(), body_sha256: [body; 32] };
    NewJob { idempotency: Some(idempotency), ..new_job(request) }
}

/// A database in a directory of its own.
pub(super) struct Place(TempDir);

impl Place {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(super) fn path(&self) -> PathBuf {
        self.0.path().join("takt.db")
    }

    pub(super) fn open(&self) -> (Arc<SqliteStore>, Arc<Metrics>) {
        let metrics = Arc::new(Metrics::new().unwrap());
        (Arc::new(SqliteStore::open(&self.path(), metrics.clone()).unwrap()), metrics)
    }

    /// What would be on disk if the process died now.
    pub(super) fn crash(&self) -> Self {
        let image = Self::new();
        for name in ["takt.db", "takt.db-wal"] {
            std::fs::copy(self.0.path().join(name), image.0.path().join(name)).unwrap();
        }
        image
    }

    /// Runs SQL behind the store's back.
    pub(super) fn meddle(&self, sql: &str) {
        Connection::open(self.path()).unwrap().execute_batch(sql).unwrap();
    }

    /// Makes every commit fail that writes an event.
    pub(super) fn break_commits(&self) {
        self.meddle(
            "CREATE TABLE poison (job INTEGER REFERENCES jobs DEFERRABLE INITIALLY DEFERRED);
             CREATE TRIGGER poisoning AFTER INSERT ON events
             BEGIN INSERT INTO poison VALUES (-1); END;",
        );
    }
}

/// A runner that does what the request's first word says.
///
/// `gate` waits until the gate opens or the run has to end, `report` does so
/// between its first and its further progress, `panic` panics, `give_up` claims
/// to have been interrupted, `deadline` tells whether it has one; anything else
/// succeeds at once.
pub(super) struct Script {
    runs: Mutex<Vec<String>>,
    started: mpsc::UnboundedSender<JobId>,
    open: Mutex<bool>,
    opened: Condvar,
}

impl Script {
    fn pass_gate(&self, context: &RunContext<'_>) -> Option<RunOutcome> {
        let mut open = self.open.lock().unwrap();
        while !*open {
            match context.cancel.reason() {
                Some(StopReason::Interrupted) => return Some(RunOutcome::Interrupted),
                Some(_) => {
                    return Some(RunOutcome::Cancelled { partial: Some("\"partial\"".to_owned()) });
                }
                None => open = self.opened.wait_timeout(open, Duration::from_millis(1)).unwrap().0,
            }
        }
        None
    }
}

impl Runner for Script {
    fn run(&self, request: &str, context: &RunContext<'_>) -> RunOutcome {
        self.runs.lock().unwrap().push(request.to_owned());
        let report = |iteration| {
            let best = Some(if iteration == 1 { f64::INFINITY } else { 0.1 });
            let evaluations = iteration * 10;
            (context.progress)(Progress { iteration, evaluations, best, ..<_>::default() });
        };
        let word = request.split(' ').next().unwrap();
        if word == "report" {
            report(1);
        }
        self.started.send(context.job).unwrap();
        match word {
            "panic" => panic!("as the request says"),
            "give_up" => return RunOutcome::Interrupted,
            "gate" | "report" => {
                if let Some(outcome) = self.pass_gate(context) {
                    return outcome;
                }
            }
            _ => {}
        }
        if word == "report" {
            (2..=1000).for_each(report);
        }
        let left = context.deadline.map(|at| at.saturating_duration_since(Instant::now()));
        let result = json!({ "request": request, "deadline": left.map(|left| left <= LONG) });
        RunOutcome::Succeeded { result: result.to_string(), summary: json!({ "duration": 1.5 }) }
    }
}

/// Jobs on a database with a scripted runner.
pub(super) struct Bench {
    pub(super) jobs: Jobs,
    pub(super) metrics: Arc<Metrics>,
    script: Arc<Script>,
    started: mpsc::UnboundedReceiver<JobId>,
}

impl Bench {
    /// One worker beside the short slot.
    pub(super) async fn start(place: &Place, queue_capacity: usize) -> Self {
        let (store, metrics) = place.open();
        let (sender, started) = mpsc::unbounded_channel();
        let script = Arc::new(Script {
            runs: Mutex::default(),
            started: sender,
            open: Mutex::new(false),
            opened: Condvar::new(),
        });
        let settings = JobSettings { workers: 1, queue_capacity };
        let jobs = Jobs::start(store, script.clone(), metrics.clone(), settings).await.unwrap();
        Self { jobs, metrics, script, started }
    }

    pub(super) async fn submit(&self, new: NewJob) -> JobId {
        self.jobs.submit(new).await.unwrap().job.id
    }

    /// Submits a job and waits until it runs.
    pub(super) async fn run(&mut self, request: &str) -> JobId {
        let id = self.submit(new_job(request)).await;
        assert_eq!(self.next_started().await, id);
        id
    }

    pub(super) async fn next_started(&mut self) -> JobId {
        self.started.recv().await.unwrap()
    }

    pub(super) fn open_gate(&self) {
        *self.script.open.lock().unwrap() = true;
        self.script.opened.notify_all();
    }

    /// The requests run so far, in order.
    pub(super) fn runs(&self) -> Vec<String> {
        self.script.runs.lock().unwrap().clone()
    }

    pub(super) async fn ended(&self, id: JobId) -> Job {
        let job = self.jobs.wait_ended(id, LONG).await.unwrap();
        assert!(job.state.is_ended(), "{job:?}");
        job
    }

    pub(super) async fn ended_as(&self, id: JobId, state: JobState, code: Option<&str>) {
        let job = self.ended(id).await;
        let found = job.error.as_ref().map(|error| error.code.as_str());
        assert_eq!((job.state, found), (state, code), "{job:?}");
    }

    pub(super) async fn events(&self, id: JobId, after_seq: u64) -> Vec<JobEvent> {
        let events = self.jobs.watch(id, after_seq).await.unwrap();
        events.map(|event| JobEvent::clone(&event.unwrap())).collect().await
    }

    /// The events' types, with the state where there is one.
    pub(super) async fn story(&self, id: JobId) -> String {
        let words = self.events(id, 0).await.into_iter().map(|event| {
            let value = serde_json::to_value(event).unwrap();
            let word = value.get("state").unwrap_or(&value["type"]);
            word.as_str().map(str::to_owned).unwrap()
        });
        words.collect::<Vec<_>>().join(" ")
    }

    pub(super) async fn result(&self, id: JobId) -> Value {
        let text = self.jobs.result(id).await.unwrap().text.unwrap();
        serde_json::from_str(&text).unwrap()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        // Lets a thread end that still stands at the gate.
        self.open_gate();
    }
}

/// The error in `result`; jobs and submissions have no plain `Debug` worth reading.
pub(super) fn error_of<T>(result: Result<T, JobsError>) -> JobsError {
    result.err().unwrap()
}
