//! The door of the job layer.

use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use futures::Stream;
use jiff::Timestamp;

use super::backlog::Slot;
use super::hub::{Hub, Watcher};
use super::model::{now, to_microseconds};
use super::scheduler::{Scheduler, Withdrawn};
use super::worker::Worker;
use super::{
    Finish, Inserted, Job, JobCounts, JobEvent, JobFilter, JobId, JobPage, JobResult, JobState,
    JobStore, JobsError, KeyUse, Metrics, NewJob, QueuedJob, Runner, Submitted, lock,
};

/// How jobs are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobSettings {
    /// Threads that plan; at least one. One more takes short jobs only.
    /// Default: the machine's cores less one.
    pub workers: usize,
    /// Jobs that may wait at once. Default 10,000.
    pub queue_capacity: usize,
}

impl Default for JobSettings {
    fn default() -> Self {
        let cores = thread::available_parallelism().map_or(1, |cores| cores.get());
        Self { workers: cores.saturating_sub(1).max(1), queue_capacity: 10_000 }
    }
}

/// What a drain left behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drained {
    /// Jobs that did not end in the time given and were interrupted.
    pub interrupted: usize,
    /// Of those, jobs whose planner did not give way: the next start counts
    /// their attempt as a crash.
    pub abandoned: usize,
}

/// A job is failed as `worker_crashed` once this many attempts of it ended
/// with the process.
pub const MAX_ATTEMPTS: u32 = 3;

/// Accepts, runs, shows and forgets jobs.
///
/// Async calls need a tokio runtime with time enabled. When dropped without
/// [`drain`](Self::drain), running jobs end on their own time and nothing new
/// starts.
pub struct Jobs {
    core: Arc<Core>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

struct Core {
    store: Arc<dyn JobStore>,
    scheduler: Arc<Scheduler>,
    hub: Arc<Hub>,
    metrics: Arc<Metrics>,
}

impl Jobs {
    /// Queues what an earlier process left in `store` and starts the workers.
    ///
    /// # Errors
    ///
    /// If the store or the operating system refuses.
    pub async fn start(
        store: Arc<dyn JobStore>,
        runner: Arc<dyn Runner>,
        metrics: Arc<Metrics>,
        settings: JobSettings,
    ) -> Result<Self, JobsError> {
        let hub = Arc::new(Hub::default());
        store.subscribe(hub.clone());
        let scheduler = Arc::new(Scheduler::new(settings.queue_capacity, metrics.clone()));
        let queued = store.recover(MAX_ATTEMPTS, now()).await?;
        queued.iter().for_each(|job| hub.open(job.id, job.last_seq));
        scheduler.restore(queued);
        let worker = Arc::new(Worker {
            scheduler: scheduler.clone(),
            store: store.clone(),
            runner,
            metrics: metrics.clone(),
        });
        let jobs = Self {
            core: Arc::new(Core { store, scheduler, hub, metrics }),
            threads: Mutex::default(),
        };
        for number in 1..=settings.workers.max(1) {
            jobs.spawn(format!("takt-worker-{number}"), &worker, |it| it.work(Slot::Any))?;
        }
        jobs.spawn("takt-worker-short".to_owned(), &worker, |it| it.work(Slot::Short))?;
        jobs.spawn("takt-expiry".to_owned(), &worker, Worker::expire_late_jobs)?;
        Ok(jobs)
    }

    fn spawn(
        &self,
        name: String,
        worker: &Arc<Worker>,
        task: fn(&Worker),
    ) -> Result<(), JobsError> {
        let worker = worker.clone();
        let spawned = thread::Builder::new().name(name).spawn(move || task(&worker));
        let thread = spawned.map_err(|error| JobsError::Internal(error.to_string()))?;
        lock(&self.threads).push(thread);
        Ok(())
    }

    /// Accepts `new`. When this returns, the job is stored for good.
    ///
    /// # Errors
    ///
    /// [`JobsError::QueueFull`], [`JobsError::Draining`],
    /// [`JobsError::IdempotencyMismatch`] or [`JobsError::StoreFailed`]; the job
    /// is then not accepted.
    pub async fn submit(&self, new: NewJob) -> Result<Submitted, JobsError> {
        let core = self.core.clone();
        // A task of its own: a client that goes away must not leave a job
        // stored but not queued.
        in_background(async move { core.submit(new).await }).await
    }

    /// The job as it is now.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], or the store's.
    pub async fn get(&self, id: JobId) -> Result<Job, JobsError> {
        self.core.get(id).await
    }

    /// Jobs that match, newest first.
    ///
    /// # Errors
    ///
    /// [`JobsError::PageToken`], or the store's.
    pub async fn list(&self, filter: JobFilter) -> Result<JobPage, JobsError> {
        Ok(self.core.store.list(filter).await?)
    }

    /// The job's request, as it was accepted.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], or the store's.
    pub async fn request(&self, id: JobId) -> Result<String, JobsError> {
        self.core.store.request(id).await?.ok_or(JobsError::NotFound(id))
    }

    /// What an ended job produced.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], [`JobsError::Conflict`] while it has not ended,
    /// or the store's.
    pub async fn result(&self, id: JobId) -> Result<JobResult, JobsError> {
        let job = self.core.get(id).await?;
        if !job.state.is_ended() {
            return Err(JobsError::Conflict { id, state: job.state });
        }
        Ok(JobResult { text: self.core.store.result(id).await?, job })
    }

    /// Ends the job: at once if it waits, within moments if it runs. The
    /// answer may still show it running.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], [`JobsError::Conflict`] if it has ended, or the
    /// store's.
    pub async fn cancel(&self, id: JobId) -> Result<Job, JobsError> {
        let core = self.core.clone();
        in_background(async move { core.cancel(id).await }).await
    }

    /// Deletes an ended job with everything that belongs to it.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], [`JobsError::Conflict`] if it has not ended, or
    /// the store's.
    pub async fn delete(&self, id: JobId) -> Result<(), JobsError> {
        match self.core.store.delete(id).await? {
            None => Err(JobsError::NotFound(id)),
            Some(state) if state.is_ended() => Ok(()),
            Some(state) => Err(JobsError::Conflict { id, state }),
        }
    }

    /// Deletes jobs that ended before `time` and answers how many.
    ///
    /// # Errors
    ///
    /// The store's.
    pub async fn delete_ended_before(&self, time: Timestamp) -> Result<usize, JobsError> {
        // In pieces, so that other writes get their turn.
        const PIECE: usize = 500;
        let mut total = 0;
        loop {
            let deleted = self.core.store.delete_ended_before(time, PIECE).await?;
            total += deleted;
            if deleted < PIECE {
                return Ok(total);
            }
        }
    }

    /// The job's events that follow number `after_seq` (0 for all), as they
    /// happen; ends after the last one. Every watcher sees the same events.
    ///
    /// An item is an error if the server drains or its store fails; the stream
    /// then ends too, and the job goes on after the next start.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], or the store's.
    pub async fn watch(
        &self,
        id: JobId,
        after_seq: u64,
    ) -> Result<impl Stream<Item = Result<Arc<JobEvent>, JobsError>> + Send + use<>, JobsError>
    {
        let channel = self.core.hub.channel(id);
        if channel.is_none() {
            self.core.get(id).await?;
        }
        Ok(Watcher::new(id, after_seq, self.core.store.clone(), channel).into_stream())
    }

    /// The job as it is when it has ended or `timeout` has passed.
    ///
    /// # Errors
    ///
    /// [`JobsError::NotFound`], or the store's.
    pub async fn wait_ended(&self, id: JobId, timeout: Duration) -> Result<Job, JobsError> {
        if let Some(channel) = self.core.hub.channel(id) {
            // However the wait went, the job's state tells what there is to tell.
            let _ = tokio::time::timeout(timeout, channel.ended()).await;
        }
        self.core.get(id).await
    }

    /// How many jobs wait and run in this process.
    pub fn counts(&self) -> JobCounts {
        self.core.scheduler.counts()
    }

    /// Whether jobs can be accepted and stored.
    ///
    /// # Errors
    ///
    /// [`JobsError::Draining`], or the store's.
    pub async fn health(&self) -> Result<(), JobsError> {
        if self.core.scheduler.is_stopped() {
            return Err(JobsError::Draining);
        }
        Ok(self.core.store.health().await?)
    }

    /// Why only a new start of the process can help, if that is so.
    pub fn store_failure(&self) -> Option<JobsError> {
        self.core.hub.store_failure()
    }

    /// Stops: nothing is accepted or started any more, running jobs get `grace`
    /// to end, and those that do not are queued for the next start. Watchers'
    /// streams end.
    pub async fn drain(&self, grace: Duration) -> Drained {
        // Planners look at their token every millisecond; the rest is commits.
        const INTERRUPTION: Duration = Duration::from_secs(5);
        let scheduler = &self.core.scheduler;
        scheduler.stop();
        let mut drained = Drained { interrupted: 0, abandoned: 0 };
        if tokio::time::timeout(grace, scheduler.idle()).await.is_err() {
            drained.interrupted = scheduler.interrupt();
            if tokio::time::timeout(INTERRUPTION, scheduler.idle()).await.is_err() {
                drained.abandoned = scheduler.counts().running;
                tracing::error!(jobs = drained.abandoned, "planners did not give way");
            }
        }
        self.core.hub.close(&JobsError::Draining);
        if drained.abandoned == 0 {
            let threads = std::mem::take(&mut *lock(&self.threads));
            let joined =
                tokio::task::spawn_blocking(|| threads.into_iter().try_for_each(JoinHandle::join));
            if !matches!(joined.await, Ok(Ok(()))) {
                tracing::error!("a worker thread had panicked");
            }
        }
        drained
    }
}

impl Drop for Jobs {
    fn drop(&mut self) {
        self.core.scheduler.stop();
        self.core.hub.close(&JobsError::Draining);
    }
}

impl Core {
    async fn get(&self, id: JobId) -> Result<Job, JobsError> {
        self.store.get(id).await?.ok_or(JobsError::NotFound(id))
    }

    async fn submit(&self, mut new: NewJob) -> Result<Submitted, JobsError> {
        new.start_by = new.start_by.map(to_microseconds);
        // Looked up first: a repetition is answered even if the queue is full.
        if let Some(idempotency) = new.idempotency.clone()
            && let Some(used) = self.store.find_key(idempotency).await?
        {
            return earlier(used);
        }
        let place = self.scheduler.reserve()?;
        let (id, created_at) = (JobId::new(), now());
        let job = Job::accepted(id, &new, created_at);
        let short = new.short;
        self.hub.open(id, 0);
        match self.store.insert(id, new, created_at).await {
            Ok(Inserted::New { number }) => {
                place.fill(QueuedJob::new(&job, number, short));
                Ok(Submitted { job, existing: false })
            }
            Ok(Inserted::KeyUsed(used)) => {
                self.hub.forget(id);
                earlier(used)
            }
            Err(error) => {
                self.hub.forget(id);
                Err(error.into())
            }
        }
    }

    async fn cancel(&self, id: JobId) -> Result<Job, JobsError> {
        // A worker may take the job and a drain may queue it again in between;
        // more happens to no job.
        const LOOKS: usize = 4;
        // A worker still holds its job for a moment after the end is stored.
        let mut state = self.get(id).await?.state;
        if state.is_ended() {
            return Err(JobsError::Conflict { id, state });
        }
        for _ in 0..LOOKS {
            if matches!(self.scheduler.withdraw(id), Withdrawn::Running) {
                return self.get(id).await;
            }
            let finish = Finish::new(JobState::Cancelled, now());
            let cancelled = self.store.finish_queued(id, finish).await?;
            let job = self.get(id).await?;
            if cancelled {
                self.metrics.ended(JobState::Cancelled, &job.task, &job.method);
                return Ok(job);
            }
            if job.state.is_ended() {
                return Err(JobsError::Conflict { id, state: job.state });
            }
            state = job.state;
        }
        // Stored as running, and run by nobody: its end could not be stored.
        tracing::error!(job = %id, %state, "a job is in nobody's hands until the next start");
        Err(JobsError::Conflict { id, state })
    }
}

/// The answer to a repeated submission.
fn earlier(used: KeyUse) -> Result<Submitted, JobsError> {
    match used {
        KeyUse::SameBody(job) => Ok(Submitted { job: *job, existing: true }),
        KeyUse::OtherBody => Err(JobsError::IdempotencyMismatch),
    }
}

/// Runs `work` to its end even if the caller goes away.
async fn in_background<T: Send + 'static>(
    work: impl Future<Output = Result<T, JobsError>> + Send + 'static,
) -> Result<T, JobsError> {
    let joined = tokio::spawn(work).await;
    joined.unwrap_or_else(|error| Err(JobsError::Internal(error.to_string())))
}
