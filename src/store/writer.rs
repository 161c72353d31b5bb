//! The one thread that writes, and its group commit.
//!
//! A sync costs milliseconds however much it covers. So the thread takes all
//! writes that came in during the last sync and commits them as one
//! transaction; each has a savepoint of its own and fails alone. A failed
//! commit ends the store: what is on disk is then unknown, and trying again
//! could report success without it.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use rusqlite::{Connection, ErrorCode, TransactionBehavior};

use crate::job::{EventSink, JobEvent, JobId, Metrics, Reply, ReplySender, StoreError};

/// More writes than this wait for the next commit.
const MAX_BATCH: usize = 512;

/// Events that become true with a commit.
pub(super) type Events = Vec<(JobId, Arc<JobEvent>)>;

/// What the writer and its users share.
#[derive(Default)]
pub(super) struct Health {
    failure: OnceLock<StoreError>,
    sink: Mutex<Option<Arc<dyn EventSink>>>,
}

impl Health {
    /// An error once the store has failed.
    pub(super) fn check(&self) -> Result<(), StoreError> {
        self.failure.get().map_or(Ok(()), |failure| Err(failure.clone()))
    }

    pub(super) fn subscribe(&self, sink: Arc<dyn EventSink>) {
        *self.sink.lock().unwrap_or_else(PoisonError::into_inner) = Some(sink);
    }

    fn sink(&self) -> Option<Arc<dyn EventSink>> {
        self.sink.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn fail(&self, error: &rusqlite::Error) -> StoreError {
        tracing::error!(%error, "a commit failed; the store takes no more work");
        let failure = StoreError::Failed(error.to_string().into());
        let _ = self.failure.set(failure.clone());
        if let Some(sink) = self.sink() {
            sink.store_failed(&failure);
        }
        failure
    }
}

/// Sends writes to their thread.
pub(super) struct Writer {
    commands: Sender<Box<dyn Command>>,
    thread: JoinHandle<()>,
}

impl Writer {
    pub(super) fn start(
        connection: Connection,
        health: Arc<Health>,
        metrics: Arc<Metrics>,
    ) -> Result<Self, std::io::Error> {
        let (commands, queue) = channel();
        let run = move || Loop { connection, health, metrics }.run(&queue);
        let thread = thread::Builder::new().name("takt-store-writer".to_owned()).spawn(run)?;
        Ok(Self { commands, thread })
    }

    /// Has `work` done in the next transaction.
    pub(super) fn write<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Connection, &mut Events) -> rusqlite::Result<T> + Send + 'static,
    ) -> Reply<T> {
        let (sender, reply) = Reply::channel();
        // If the thread is gone, the sender is dropped and the reply says so.
        let _ = self.commands.send(Box::new(Write { work: Some(work), done: None, sender }));
        reply
    }

    /// Commits what was sent and ends the thread.
    pub(super) fn stop(self) {
        drop(self.commands);
        if self.thread.join().is_err() {
            tracing::error!("the store's writer had panicked");
        }
    }
}

/// A write, its type forgotten.
trait Command: Send {
    /// Does the work and keeps its outcome.
    fn apply(&mut self, connection: &Connection, events: &mut Events) -> rusqlite::Result<()>;

    /// Tells the caller.
    fn reply(self: Box<Self>, committed: Result<(), StoreError>);
}

struct Write<T, F> {
    work: Option<F>,
    done: Option<Result<T, StoreError>>,
    sender: ReplySender<T>,
}

impl<T, F> Command for Write<T, F>
where
    T: Send,
    F: FnOnce(&Connection, &mut Events) -> rusqlite::Result<T> + Send,
{
    fn apply(&mut self, connection: &Connection, events: &mut Events) -> rusqlite::Result<()> {
        let Some(work) = self.work.take() else { return Ok(()) };
        let (done, outcome) = match work(connection, events) {
            Ok(value) => (Ok(value), Ok(())),
            Err(error) => (Err(StoreError::Statement(error.to_string())), Err(error)),
        };
        self.done = Some(done);
        outcome
    }

    fn reply(self: Box<Self>, committed: Result<(), StoreError>) {
        let Self { done, sender, .. } = *self;
        let undone = || Err(StoreError::Failed("the write was not done".into()));
        sender.send(committed.and_then(|()| done.unwrap_or_else(undone)));
    }
}

struct Loop {
    connection: Connection,
    health: Arc<Health>,
    metrics: Arc<Metrics>,
}

impl Loop {
    fn run(mut self, queue: &Receiver<Box<dyn Command>>) {
        while let Ok(first) = queue.recv() {
            let mut batch = vec![first];
            batch.extend(queue.try_iter().take(MAX_BATCH - 1));
            let committed = self.health.check().and_then(|()| self.commit(&mut batch));
            batch.into_iter().for_each(|command| command.reply(committed.clone()));
        }
    }

    /// Commits the batch and publishes its events, in this order.
    fn commit(&mut self, batch: &mut [Box<dyn Command>]) -> Result<(), StoreError> {
        let events = self.transact(batch).map_err(|error| self.health.fail(&error))?;
        if let Some(sink) = self.health.sink() {
            events.into_iter().for_each(|(job, event)| sink.publish(job, event));
        }
        Ok(())
    }

    fn transact(&mut self, batch: &mut [Box<dyn Command>]) -> rusqlite::Result<Events> {
        let mut events = Events::new();
        let mut transaction =
            self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        for command in batch.iter_mut() {
            let before = events.len();
            let savepoint = transaction.savepoint()?;
            match command.apply(&savepoint, &mut events) {
                Ok(()) => savepoint.commit()?,
                Err(error) if is_fatal(&error) => return Err(error),
                Err(_) => {
                    savepoint.finish()?;
                    events.truncate(before);
                }
            }
        }
        let begun = Instant::now();
        transaction.commit()?;
        self.metrics.store_commit_seconds.observe(begun.elapsed().as_secs_f64());
        self.metrics.store_batch_size.observe(batch.len() as f64);
        Ok(events)
    }
}

/// True if the error concerns the database, not the statement.
fn is_fatal(error: &rusqlite::Error) -> bool {
    use ErrorCode::{
        CannotOpen, DatabaseBusy, DatabaseCorrupt, DatabaseLocked, DiskFull,
        FileLockingProtocolFailed, NotADatabase, OutOfMemory, ReadOnly, SystemIoFailure,
    };
    matches!(
        error.sqlite_error_code(),
        Some(
            CannotOpen
                | DatabaseBusy
                | DatabaseCorrupt
                | DatabaseLocked
                | DiskFull
                | FileLockingProtocolFailed
                | NotADatabase
                | OutOfMemory
                | ReadOnly
                | SystemIoFailure
        )
    )
}
