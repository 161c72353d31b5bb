//! What the jobs ask of a store.
//!
//! Every call is sent off when it is made and answered later, so the same
//! trait serves async code (`.await`) and worker threads (`.wait()`).

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use jiff::{SignedDuration, Timestamp};
use serde_json::Value;
use tokio::sync::oneshot;

use super::{
    Idempotency, Job, JobError, JobEvent, JobFilter, JobId, JobPage, JobState, NewJob, Progress,
};

/// Why a store could not do what it was asked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// A commit failed or the store was closed. Nothing works until the
    /// process starts again: after a failed sync nobody knows what is on disk.
    #[error("the store has failed: {0}")]
    Failed(Arc<str>),
    /// This one call failed and changed nothing.
    #[error("the store refused a statement: {0}")]
    Statement(String),
    /// The page token is not one of ours.
    #[error("unknown page token `{0}`")]
    PageToken(String),
}

/// A store's answer under way.
///
/// For a write it arrives after the commit. Dropping it does not undo the
/// call.
#[must_use = "the call may have failed"]
pub struct Reply<T>(oneshot::Receiver<Result<T, StoreError>>);

/// Where a store puts its answer.
pub struct ReplySender<T>(oneshot::Sender<Result<T, StoreError>>);

impl<T> Reply<T> {
    /// A reply and the end that answers it.
    pub fn channel() -> (ReplySender<T>, Self) {
        let (sender, receiver) = oneshot::channel();
        (ReplySender(sender), Self(receiver))
    }

    /// A reply that is already there.
    pub fn ready(answer: Result<T, StoreError>) -> Self {
        let (sender, reply) = Self::channel();
        sender.send(answer);
        reply
    }

    /// Blocks this thread until the answer is there.
    ///
    /// # Errors
    ///
    /// What the store says.
    ///
    /// # Panics
    ///
    /// On a thread that drives async tasks; await the reply there.
    pub fn wait(self) -> Result<T, StoreError> {
        self.0.blocking_recv().unwrap_or_else(|_| Err(closed()))
    }
}

impl<T> ReplySender<T> {
    /// Answers. It does not matter if nobody waits any more.
    pub fn send(self, answer: Result<T, StoreError>) {
        let _ = self.0.send(answer);
    }
}

impl<T> Future for Reply<T> {
    type Output = Result<T, StoreError>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let answer = Pin::new(&mut self.0).poll(context);
        answer.map(|received| received.unwrap_or_else(|_| Err(closed())))
    }
}

fn closed() -> StoreError {
    StoreError::Failed("it was closed".into())
}

/// What became of an insert.
#[derive(Clone, Debug, PartialEq)]
pub enum Inserted {
    /// The job is stored, the `number`-th ever.
    New {
        /// Counts accepted jobs; the order in which equals are started.
        number: u64,
    },
    /// Its key was used before; nothing was stored.
    KeyUsed(KeyUse),
}

/// What an idempotency key stands for already.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyUse {
    /// The same body: this is its job.
    SameBody(Box<Job>),
    /// Another body.
    OtherBody,
}

/// What the queue needs to know of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct QueuedJob {
    /// The job.
    pub id: JobId,
    /// Counts accepted jobs.
    pub number: u64,
    /// 0 to 100; higher starts earlier.
    pub priority: u8,
    /// True if the work is estimated to be short.
    pub short: bool,
    /// When it was accepted.
    pub created_at: Timestamp,
    /// Seconds from acceptance within which it has to end.
    pub deadline_s: Option<f64>,
    /// Latest time at which it may begin.
    pub start_by: Option<Timestamp>,
    /// The task's type.
    pub task: String,
    /// The method that plans it.
    pub method: String,
    /// Number of its latest event.
    pub last_seq: u64,
}

impl QueuedJob {
    /// A job just accepted, its first event written.
    pub(super) fn new(job: &Job, number: u64, short: bool) -> Self {
        Self {
            id: job.id,
            number,
            priority: job.priority,
            short,
            created_at: job.created_at,
            deadline_s: job.deadline_s,
            start_by: job.start_by,
            task: job.task.clone(),
            method: job.method.clone(),
            last_seq: 1,
        }
    }

    /// When the job has to end; none if never, or beyond the calendar.
    pub(super) fn deadline(&self) -> Option<Timestamp> {
        let deadline = SignedDuration::try_from_secs_f64(self.deadline_s?).ok()?;
        self.created_at.checked_add(deadline).ok()
    }

    /// From when on the job need not start any more.
    pub(super) fn latest_start(&self) -> Option<Timestamp> {
        self.deadline().into_iter().chain(self.start_by).min()
    }
}

/// The right to run a job and to write its result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claim {
    /// Differs for every start of the job and fences its writes: those under
    /// an older number have no effect.
    pub number: u64,
    /// Attempts so far, this one included.
    pub attempt: u32,
    /// The plan request.
    pub request: String,
}

/// How a job ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// One of the ended states.
    pub state: JobState,
    /// When it ended.
    pub at: Timestamp,
    /// The result, or what there is of it, as JSON text.
    pub result: Option<String>,
    /// The result in a few figures.
    pub summary: Option<Value>,
    /// Why it did not succeed.
    pub error: Option<JobError>,
}

impl Finish {
    /// An end without result or error.
    pub fn new(state: JobState, at: Timestamp) -> Self {
        Self { state, at, result: None, summary: None, error: None }
    }
}

/// Learns of events once they are committed.
pub trait EventSink: Send + Sync {
    /// `event` of `job` was committed. A job's events come in order, and each
    /// before the reply to the call that caused it.
    fn publish(&self, job: JobId, event: Arc<JobEvent>);

    /// The store has failed; no event will follow.
    fn store_failed(&self, error: &StoreError);
}

/// Keeps jobs, their requests, results and events.
///
/// All writes are durable when answered. The store numbers a job's events
/// and writes them with the change they tell of, in one transaction.
pub trait JobStore: Send + Sync {
    /// Tells `sink` of every event committed from now on. Only the latest
    /// sink is told.
    fn subscribe(&self, sink: Arc<dyn EventSink>);

    /// Stores a new job as queued, unless its key was used before.
    fn insert(&self, id: JobId, new: NewJob, at: Timestamp) -> Reply<Inserted>;

    /// What the key stands for already, if it was used.
    fn find_key(&self, key: Idempotency) -> Reply<Option<KeyUse>>;

    /// The job, if there is one.
    fn get(&self, id: JobId) -> Reply<Option<Job>>;

    /// Jobs that match, newest first.
    fn list(&self, filter: JobFilter) -> Reply<JobPage>;

    /// The job's request.
    fn request(&self, id: JobId) -> Reply<Option<String>>;

    /// The job's result text, if it has one.
    fn result(&self, id: JobId) -> Reply<Option<String>>;

    /// At most `limit` events of the job that follow `after_seq`, in order.
    fn events(&self, id: JobId, after_seq: u64, limit: usize) -> Reply<Vec<JobEvent>>;

    /// Takes up what an earlier process left: running jobs are queued again,
    /// or fail as `worker_crashed` if they had `max_attempts`. Answers all
    /// queued jobs in order of acceptance.
    fn recover(&self, max_attempts: u32, at: Timestamp) -> Reply<Vec<QueuedJob>>;

    /// Makes a queued job run. Nothing if it is not queued.
    fn start(&self, id: JobId, at: Timestamp) -> Reply<Option<Claim>>;

    /// Queues a running job again and takes its attempt back. False if the
    /// claim is not the latest.
    fn requeue(&self, id: JobId, claim: u64, at: Timestamp) -> Reply<bool>;

    /// Adds a progress event to a running job. False if the claim is not the
    /// latest.
    fn progress(&self, id: JobId, claim: u64, at: Timestamp, progress: Progress) -> Reply<bool>;

    /// Ends a running job. False if the claim is not the latest or the job
    /// does not run: the result is then discarded.
    fn finish(&self, id: JobId, claim: u64, finish: Finish) -> Reply<bool>;

    /// Ends a job that is still queued. False if it is not.
    fn finish_queued(&self, id: JobId, finish: Finish) -> Reply<bool>;

    /// Deletes an ended job with all that belongs to it. Answers the state it
    /// was found in, if there was one; unless ended, it stays.
    fn delete(&self, id: JobId) -> Reply<Option<JobState>>;

    /// Deletes at most `limit` jobs that ended before `time`, oldest first, and
    /// answers how many.
    fn delete_ended_before(&self, time: Timestamp, limit: usize) -> Reply<usize>;

    /// Whether the store can be read and has not failed.
    fn health(&self) -> Reply<()>;
}
