//! Shows every watcher of a job the same events.
//!
//! While a job is active its events stay in memory, once, and a watcher is
//! nothing but a position in that list. Older events, and those of ended jobs,
//! come from the store. Events arrive here only after their commit, so what
//! is seen live and what is read later cannot differ.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, RwLock};

use futures::{Stream, stream};
use tokio::sync::watch;

use super::{EventSink, JobEvent, JobId, JobStore, JobsError, StoreError, lock};

/// The channels of all active jobs.
#[derive(Default)]
pub(super) struct Hub {
    channels: Mutex<Channels>,
}

#[derive(Default)]
struct Channels {
    of: HashMap<JobId, Arc<Channel>>,
    /// Why there is nothing more to see, once that is so.
    closed: Option<JobsError>,
}

impl Hub {
    /// Opens the channel of a job whose latest event is `last_seq`. Has to
    /// happen before the job can be seen, or a watcher would take it for ended.
    pub(super) fn open(&self, job: JobId, last_seq: u64) {
        let channel = Arc::new(Channel::new(last_seq));
        let mut channels = lock(&self.channels);
        // A job accepted while the server closed: nobody must wait for it here.
        if let Some(reason) = &channels.closed {
            channel.close(reason.clone());
        }
        channels.of.insert(job, channel);
    }

    /// Forgets a job that did not come to be.
    pub(super) fn forget(&self, job: JobId) {
        lock(&self.channels).of.remove(&job);
    }

    /// The channel of `job` if it is active.
    pub(super) fn channel(&self, job: JobId) -> Option<Arc<Channel>> {
        lock(&self.channels).of.get(&job).cloned()
    }

    /// Ends all watching with `reason`, now and in future. The first reason
    /// stays, unless the store fails after it.
    pub(super) fn close(&self, reason: &JobsError) {
        let mut channels = lock(&self.channels);
        if channels.closed.is_none() || matches!(reason, JobsError::StoreFailed(_)) {
            channels.closed = Some(reason.clone());
        }
        for channel in channels.of.values() {
            channel.close(reason.clone());
        }
    }

    /// Why the store failed, if it did.
    pub(super) fn store_failure(&self) -> Option<JobsError> {
        let closed = lock(&self.channels).closed.clone();
        closed.filter(|reason| matches!(reason, JobsError::StoreFailed(_)))
    }
}

impl EventSink for Hub {
    fn publish(&self, job: JobId, event: Arc<JobEvent>) {
        let mut channels = lock(&self.channels);
        let last = event.kind.is_last();
        let channel = if last { channels.of.remove(&job) } else { channels.of.get(&job).cloned() };
        drop(channels);
        if let Some(channel) = channel {
            channel.push(event);
        }
    }

    fn store_failed(&self, error: &StoreError) {
        self.close(&error.clone().into());
    }
}

/// The events of one active job.
pub(super) struct Channel {
    log: RwLock<Log>,
    changed: watch::Sender<()>,
}

struct Log {
    /// Sequence number of the event before the first one in `events`.
    base: u64,
    events: VecDeque<Arc<JobEvent>>,
    closed: Option<JobsError>,
}

/// What a channel holds for a watcher at some position.
enum Read {
    Events(VecDeque<Arc<JobEvent>>),
    /// The events asked for are in the store only.
    InStore,
    /// Nothing yet.
    Nothing,
    /// Nothing, ever.
    End,
    Closed(JobsError),
}

impl Channel {
    /// Hours of progress; a longer history is read from the store.
    const KEPT: usize = 16_384;
    const BATCH: usize = 64;

    fn new(base: u64) -> Self {
        let log = Log { base, events: VecDeque::new(), closed: None };
        Self { log: RwLock::new(log), changed: watch::Sender::new(()) }
    }

    fn push(&self, event: Arc<JobEvent>) {
        self.change(|log| {
            log.events.push_back(event);
            if log.events.len() > Self::KEPT {
                log.events.pop_front();
                log.base += 1;
            }
        });
    }

    fn close(&self, reason: JobsError) {
        self.change(|log| log.closed = Some(reason));
    }

    fn change(&self, change: impl FnOnce(&mut Log)) {
        change(&mut self.log.write().unwrap_or_else(|poisoned| poisoned.into_inner()));
        self.changed.send_replace(());
    }

    fn read(&self, after_seq: u64) -> Read {
        let log = self.log.read().unwrap_or_else(|poisoned| poisoned.into_inner());
        let Some(position) = after_seq.checked_sub(log.base) else { return Read::InStore };
        let position = usize::try_from(position).unwrap_or(usize::MAX).min(log.events.len());
        let events: VecDeque<_> = log.events.range(position..).take(Self::BATCH).cloned().collect();
        if !events.is_empty() {
            return Read::Events(events);
        }
        if log.events.back().is_some_and(|event| event.kind.is_last()) {
            return Read::End;
        }
        log.closed.clone().map_or(Read::Nothing, Read::Closed)
    }

    /// Waits until the job has ended.
    ///
    /// # Errors
    ///
    /// Why watching ended before the job did.
    pub(super) async fn ended(&self) -> Result<(), JobsError> {
        let mut changed = self.changed.subscribe();
        loop {
            changed.borrow_and_update();
            match self.read(u64::MAX) {
                Read::End => return Ok(()),
                Read::Closed(reason) => return Err(reason),
                // The sender lives in `self`, so this waits and cannot fail.
                _ => drop(changed.changed().await),
            }
        }
    }
}

/// One reader of a job's events.
pub(super) struct Watcher {
    job: JobId,
    after_seq: u64,
    store: Arc<dyn JobStore>,
    live: Option<(Arc<Channel>, watch::Receiver<()>)>,
    ready: VecDeque<Arc<JobEvent>>,
    done: bool,
}

impl Watcher {
    const PAGE: usize = 512;

    /// Reads the events of `job` that follow `after_seq`; `channel` is there if
    /// the job is active.
    pub(super) fn new(
        job: JobId,
        after_seq: u64,
        store: Arc<dyn JobStore>,
        channel: Option<Arc<Channel>>,
    ) -> Self {
        let live = channel.map(|channel| {
            let changed = channel.changed.subscribe();
            (channel, changed)
        });
        Self { job, after_seq, store, live, ready: VecDeque::new(), done: false }
    }

    /// The events as a stream that ends with the job.
    pub(super) fn into_stream(self) -> impl Stream<Item = Result<Arc<JobEvent>, JobsError>> {
        stream::unfold(self, |mut watcher| async move {
            watcher.next().await.map(|event| (event, watcher))
        })
    }

    async fn next(&mut self) -> Option<Result<Arc<JobEvent>, JobsError>> {
        loop {
            if let Some(event) = self.ready.pop_front() {
                self.after_seq = event.seq;
                self.done |= event.kind.is_last();
                return Some(Ok(event));
            }
            if self.done {
                return None;
            }
            if let Err(error) = self.fill().await {
                self.done = true;
                return Some(Err(error));
            }
        }
    }

    /// Gets events ready, waits for a change, or finds that there is no more.
    async fn fill(&mut self) -> Result<(), JobsError> {
        let read = match &mut self.live {
            Some((channel, changed)) => {
                // Marked as seen before reading: a change in between wakes us again.
                changed.borrow_and_update();
                channel.read(self.after_seq)
            }
            None => Read::InStore,
        };
        match read {
            Read::Events(events) => self.ready = events,
            Read::InStore => {
                let events = self.store.events(self.job, self.after_seq, Self::PAGE).await?;
                self.done = events.is_empty();
                self.ready = events.into_iter().map(Arc::new).collect();
            }
            Read::End => self.done = true,
            Read::Closed(reason) => return Err(reason),
            Read::Nothing => {
                if let Some((_, changed)) = &mut self.live {
                    self.done = changed.changed().await.is_err();
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;

    use super::*;
    use crate::job::{EventKind, JobState, Progress};

    fn event(seq: u64) -> Arc<JobEvent> {
        let kind = EventKind::Progress(Progress { iteration: seq, ..<_>::default() });
        Arc::new(JobEvent { seq, time: Timestamp::UNIX_EPOCH, kind })
    }

    fn sequence(read: Read) -> Vec<u64> {
        match read {
            Read::Events(events) => events.iter().map(|event| event.seq).collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn a_position_finds_exactly_the_events_after_it() {
        let channel = Channel::new(2);
        (3..=5).for_each(|seq| channel.push(event(seq)));
        assert!(matches!(channel.read(1), Read::InStore));
        assert_eq!(sequence(channel.read(2)), [3, 4, 5]);
        assert_eq!(sequence(channel.read(4)), [5]);
        assert!(matches!(channel.read(5), Read::Nothing));
        assert!(matches!(channel.read(900), Read::Nothing));
    }

    #[test]
    fn a_long_history_is_left_to_the_store() {
        let channel = Channel::new(0);
        let count = Channel::KEPT as u64 + 10;
        (1..=count).for_each(|seq| channel.push(event(seq)));
        assert!(matches!(channel.read(9), Read::InStore));
        assert_eq!(sequence(channel.read(10))[0], 11);
        assert_eq!(sequence(channel.read(count - 1)), [count]);
    }

    #[test]
    fn the_last_event_takes_the_channel_out_of_the_hub() {
        let hub = Hub::default();
        let job = JobId::new();
        hub.open(job, 0);
        let channel = hub.channel(job).unwrap();
        hub.publish(job, event(1));
        assert!(hub.channel(job).is_some());
        let kind = EventKind::Finished { state: JobState::Succeeded, summary: None, error: None };
        hub.publish(job, Arc::new(JobEvent { seq: 2, time: Timestamp::UNIX_EPOCH, kind }));
        assert!(hub.channel(job).is_none());
        assert_eq!(sequence(channel.read(0)), [1, 2]);
        assert!(matches!(channel.read(2), Read::End));
    }

    #[test]
    fn closing_comes_after_the_events_before_it() {
        let hub = Hub::default();
        let job = JobId::new();
        hub.open(job, 0);
        hub.publish(job, event(1));
        hub.close(&JobsError::Draining);
        let channel = hub.channel(job).unwrap();
        assert_eq!(sequence(channel.read(0)), [1]);
        assert!(matches!(channel.read(1), Read::Closed(JobsError::Draining)));
        // As for a job whose acceptance was under way.
        let late = JobId::new();
        hub.open(late, 0);
        let channel = hub.channel(late).unwrap();
        assert!(matches!(channel.read(0), Read::Closed(JobsError::Draining)));
    }

    #[test]
    fn a_failed_store_is_remembered_beside_a_drain() {
        let hub = Hub::default();
        assert_eq!(hub.store_failure(), None);
        hub.close(&JobsError::Draining);
        assert_eq!(hub.store_failure(), None);
        let failure = StoreError::Failed("the disk is full".into());
        hub.store_failed(&failure);
        hub.close(&JobsError::Draining);
        assert_eq!(hub.store_failure(), Some(failure.into()));
    }
}
