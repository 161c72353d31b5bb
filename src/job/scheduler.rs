//! Hands waiting jobs to workers and knows which ones run.

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::watch;

use super::backlog::{Backlog, Slot};
use super::model::now;
use super::{JobCounts, JobId, JobsError, Metrics, QueuedJob, lock};
use crate::budget::CancelToken;

/// The queue and the list of running jobs, under one lock.
pub(super) struct Scheduler {
    state: Mutex<State>,
    /// Workers wait here for jobs.
    work: Condvar,
    /// The expiry thread waits here for the next expiry to change.
    expiry: Condvar,
    running: watch::Sender<usize>,
    capacity: usize,
    metrics: Arc<Metrics>,
}

#[derive(Default)]
struct State {
    backlog: Backlog,
    /// Places promised to jobs that are being stored.
    reserved: usize,
    running: HashMap<JobId, CancelToken>,
    stopped: bool,
}

/// What a withdrawal found.
pub(super) enum Withdrawn {
    /// The job runs and was told to end.
    Running,
    /// The job does not run, and it does not wait any more.
    Idle,
}

impl Scheduler {
    pub(super) fn new(capacity: usize, metrics: Arc<Metrics>) -> Self {
        Self {
            state: Mutex::default(),
            work: Condvar::new(),
            expiry: Condvar::new(),
            running: watch::Sender::new(0),
            capacity,
            metrics,
        }
    }

    /// Keeps a place in the queue for a job about to be stored.
    ///
    /// # Errors
    ///
    /// [`JobsError::QueueFull`] or [`JobsError::Draining`].
    pub(super) fn reserve(self: &Arc<Self>) -> Result<Reservation, JobsError> {
        let mut state = lock(&self.state);
        if state.stopped {
            return Err(JobsError::Draining);
        }
        if state.backlog.len() + state.reserved >= self.capacity {
            return Err(JobsError::QueueFull { capacity: self.capacity });
        }
        state.reserved += 1;
        Ok(Reservation(self.clone()))
    }

    /// Queues jobs that were accepted earlier, whatever the capacity.
    pub(super) fn restore(&self, jobs: Vec<QueuedJob>) {
        let mut state = lock(&self.state);
        jobs.into_iter().for_each(|job| state.backlog.push(job));
        self.changed(&state);
    }

    /// Waits for a job that fits `slot`; none once the scheduler has stopped.
    pub(super) fn next(self: &Arc<Self>, slot: Slot) -> Option<Claimed> {
        let mut state = lock(&self.state);
        loop {
            if state.stopped {
                return None;
            }
            if let Some(job) = state.backlog.pop(slot) {
                let cancel = CancelToken::default();
                state.running.insert(job.id, cancel.clone());
                self.changed(&state);
                return Some(Claimed { job, cancel, scheduler: self.clone() });
            }
            state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits for a job to expire in the queue; none once the scheduler has
    /// stopped.
    pub(super) fn next_expired(&self) -> Option<QueuedJob> {
        // The wall clock may be set while we wait, so it is looked at again.
        const LONGEST_WAIT: Duration = Duration::from_secs(10);
        let mut state = lock(&self.state);
        loop {
            if state.stopped {
                return None;
            }
            let now = now();
            if let Some(job) = state.backlog.pop_expired(now) {
                self.changed(&state);
                return Some(job);
            }
            state = match state.backlog.next_expiry() {
                None => self.expiry.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(time) => {
                    let left = Duration::try_from(time.duration_since(now)).unwrap_or_default();
                    let wait = self.expiry.wait_timeout(state, left.min(LONGEST_WAIT));
                    wait.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    /// Takes a waiting job out of the queue or tells a running one to end.
    pub(super) fn withdraw(&self, id: JobId) -> Withdrawn {
        let mut state = lock(&self.state);
        if let Some(cancel) = state.running.get(&id) {
            cancel.cancel();
            return Withdrawn::Running;
        }
        state.backlog.remove(id);
        self.changed(&state);
        Withdrawn::Idle
    }

    /// No job starts any more, and threads that wait for one end.
    pub(super) fn stop(&self) {
        lock(&self.state).stopped = true;
        self.work.notify_all();
        self.expiry.notify_all();
    }

    /// Asks every running job to end so that it can be queued again; answers
    /// how many there are.
    pub(super) fn interrupt(&self) -> usize {
        let state = lock(&self.state);
        state.running.values().for_each(CancelToken::interrupt);
        state.running.len()
    }

    /// Waits until no job runs.
    pub(super) async fn idle(&self) {
        // Fails only if the sender is gone, and it lives in `self`.
        let _ = self.running.subscribe().wait_for(|running| *running == 0).await;
    }

    pub(super) fn is_stopped(&self) -> bool {
        lock(&self.state).stopped
    }

    pub(super) fn counts(&self) -> JobCounts {
        let state = lock(&self.state);
        let queued = state.backlog.len();
        JobCounts { queued, running: state.running.len(), capacity: self.capacity }
    }

    /// Tells everyone concerned that the lists changed.
    fn changed(&self, state: &MutexGuard<'_, State>) {
        let gauge = |count: usize| i64::try_from(count).unwrap_or(i64::MAX);
        self.metrics.queue_depth.set(gauge(state.backlog.len()));
        self.metrics.running.set(gauge(state.running.len()));
        self.running.send_replace(state.running.len());
        // All of them: a single one might be the slot that leaves long jobs alone.
        self.work.notify_all();
        self.expiry.notify_all();
    }
}

/// A place in the queue, given back when dropped.
pub(super) struct Reservation(Arc<Scheduler>);

impl Reservation {
    /// Puts a stored job into the place.
    pub(super) fn fill(self, job: QueuedJob) {
        let mut state = lock(&self.0.state);
        state.backlog.push(job);
        self.0.changed(&state);
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        lock(&self.0.state).reserved -= 1;
    }
}

/// A job in a worker's hands; counts as running until dropped.
pub(super) struct Claimed {
    pub(super) job: QueuedJob,
    pub(super) cancel: CancelToken,
    scheduler: Arc<Scheduler>,
}

impl Drop for Claimed {
    fn drop(&mut self) {
        let mut state = lock(&self.scheduler.state);
        state.running.remove(&self.job.id);
        self.scheduler.changed(&state);
    }
}
