//! The embedded store: one SQLite file beside the server.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use rusqlite::{Connection, OpenFlags};

use super::migrations::migrate;
use super::readers::Readers;
use super::write::Change;
use super::writer::{Health, Writer};
use super::{OpenError, read};
use crate::job::{
    Claim, EventSink, Finish, Idempotency, Inserted, Job, JobEvent, JobFilter, JobId, JobPage,
    JobState, JobStore, KeyUse, Metrics, NewJob, Progress, QueuedJob, Reply, StoreError,
};
use crate::service::RobotStore;

/// SQLite with a write-ahead log, synced at every commit.
///
/// Opening takes a lock on the data, so that no two servers work on it.
/// Dropping commits what was sent.
pub struct SqliteStore {
    writer: Option<Writer>,
    readers: Readers,
    health: Arc<Health>,
    /// Held to keep other processes out.
    _lock: File,
}

impl SqliteStore {
    /// Earlier versions can damage a database when its write-ahead log starts anew.
    const OLDEST_SQLITE: i32 = 3_051_003;
    const READERS: usize = 2;

    /// Opens the database at `path`, with its directory and schema made if
    /// need be.
    ///
    /// # Errors
    ///
    /// See [`OpenError`].
    pub fn open(path: &Path, metrics: Arc<Metrics>) -> Result<Self, OpenError> {
        if rusqlite::version_number() < Self::OLDEST_SQLITE {
            return Err(OpenError::SqliteVersion { found: rusqlite::version() });
        }
        let lock = lock(path)?;
        let mut connection = Connection::open(path)?;
        let mode: String =
            connection.pragma_update_and_check(None, "journal_mode", "WAL", |row| row.get(0))?;
        if mode != "wal" {
            return Err(OpenError::NoWriteAheadLog { mode });
        }
        connection.pragma_update(None, "synchronous", "FULL")?;
        connection.pragma_update(None, "foreign_keys", true)?;
        prepare(&connection)?;
        migrate(&mut connection)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let mut connections = Vec::with_capacity(Self::READERS);
        for _ in 0..Self::READERS {
            let reader = Connection::open_with_flags(path, flags)?;
            prepare(&reader)?;
            connections.push(reader);
        }
        let health = Arc::new(Health::default());
        let io = |source| OpenError::Io { path: path.to_owned(), source };
        let readers = Readers::start(connections, health.clone()).map_err(io)?;
        let writer = Writer::start(connection, health.clone(), metrics).map_err(io)?;
        Ok(Self { writer: Some(writer), readers, health, _lock: lock })
    }

    fn write<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Change<'_>) -> rusqlite::Result<T> + Send + 'static,
    ) -> Reply<T> {
        let Some(writer) = &self.writer else {
            return Reply::ready(Err(StoreError::Failed("it is closing".into())));
        };
        writer.write(|connection, events| work(&mut Change { connection, events }))
    }

    fn read<T: Send + 'static>(
        &self,
        query: impl FnOnce(&Connection) -> rusqlite::Result<T> + Send + 'static,
    ) -> Reply<T> {
        self.readers.read(query)
    }
}

impl Drop for SqliteStore {
    fn drop(&mut self) {
        if let Some(writer) = self.writer.take() {
            writer.stop();
        }
    }
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.set_prepared_statement_cache_capacity(64);
    connection.busy_timeout(Duration::from_secs(5))
}

/// Locks a file beside the database and makes its directory if need be.
fn lock(path: &Path) -> Result<File, OpenError> {
    let io = |path: PathBuf| |source| OpenError::Io { path, source };
    if let Some(directory) = path.parent() {
        std::fs::create_dir_all(directory).map_err(io(directory.to_owned()))?;
    }
    let mut lock_path = path.as_os_str().to_owned();
    lock_path.push(".lock");
    let lock_path = PathBuf::from(lock_path);
    let file = File::options().create(true).truncate(false).write(true).open(&lock_path);
    let file = file.map_err(io(lock_path.clone()))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(OpenError::InUse { path: path.to_owned() }),
        Err(TryLockError::Error(source)) => Err(OpenError::Io { path: lock_path, source }),
    }
}

impl JobStore for SqliteStore {
    fn subscribe(&self, sink: Arc<dyn EventSink>) {
        self.health.subscribe(sink);
    }

    fn insert(&self, id: JobId, new: NewJob, at: Timestamp) -> Reply<Inserted> {
        self.write(move |change| change.insert(id, &new, at))
    }

    fn find_key(&self, key: Idempotency) -> Reply<Option<KeyUse>> {
        self.read(move |connection| read::key_use(connection, &key))
    }

    fn get(&self, id: JobId) -> Reply<Option<Job>> {
        self.read(move |connection| read::job(connection, id))
    }

    fn list(&self, filter: JobFilter) -> Reply<JobPage> {
        let before = match filter.page_token.as_deref().map(|token| (token, token.parse())) {
            None => None,
            Some((_, Ok(number))) => Some(number),
            Some((token, Err(_))) => {
                return Reply::ready(Err(StoreError::PageToken(token.to_owned())));
            }
        };
        self.read(move |connection| read::list(connection, &filter, before))
    }

    fn request(&self, id: JobId) -> Reply<Option<String>> {
        self.read(move |connection| read::request(connection, id))
    }

    fn result(&self, id: JobId) -> Reply<Option<String>> {
        self.read(move |connection| read::result(connection, id))
    }

    fn events(&self, id: JobId, after_seq: u64, limit: usize) -> Reply<Vec<JobEvent>> {
        self.read(move |connection| read::events(connection, id, after_seq, limit))
    }

    fn recover(&self, max_attempts: u32, at: Timestamp) -> Reply<Vec<QueuedJob>> {
        self.write(move |change| change.recover(max_attempts, at))
    }

    fn start(&self, id: JobId, at: Timestamp) -> Reply<Option<Claim>> {
        self.write(move |change| change.start(id, at))
    }

    fn requeue(&self, id: JobId, claim: u64, at: Timestamp) -> Reply<bool> {
        self.write(move |change| change.requeue(id, claim, at))
    }

    fn progress(&self, id: JobId, claim: u64, at: Timestamp, progress: Progress) -> Reply<bool> {
        self.write(move |change| change.progress(id, claim, at, progress))
    }

    fn finish(&self, id: JobId, claim: u64, finish: Finish) -> Reply<bool> {
        self.write(move |change| change.finish(id, claim, finish))
    }

    fn finish_queued(&self, id: JobId, finish: Finish) -> Reply<bool> {
        self.write(move |change| change.finish_queued(id, finish))
    }

    fn delete(&self, id: JobId) -> Reply<Option<JobState>> {
        self.write(move |change| change.delete(id))
    }

    fn delete_ended_before(&self, time: Timestamp, limit: usize) -> Reply<usize> {
        self.write(move |change| change.delete_ended_before(time, limit))
    }

    fn health(&self) -> Reply<()> {
        self.read(|connection| connection.query_row("SELECT 1", [], |_| Ok(())))
    }
}

impl RobotStore for SqliteStore {
    fn put_robot(&self, name: &str, json: &str) -> Reply<bool> {
        let (name, json) = (name.to_owned(), json.to_owned());
        self.write(move |change| change.put_robot(&name, &json))
    }

    fn robot(&self, name: &str) -> Reply<Option<String>> {
        let name = name.to_owned();
        self.read(move |connection| read::robot(connection, &name))
    }

    fn robots(&self) -> Reply<Vec<(String, String)>> {
        self.read(read::robots)
    }

    fn delete_robot(&self, name: &str) -> Reply<bool> {
        let name = name.to_owned();
        self.write(move |change| change.delete_robot(&name))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::mpsc::{self, Receiver, Sender};

    use super::super::testing::{Place, new_job};
    use super::*;
    use crate::store::suite;

    #[test]
    fn does_what_every_job_store_does() {
        let place = Place::new();
        let next = std::cell::Cell::new(0);
        suite::run(|| {
            next.set(next.get() + 1);
            let path = place.path().with_file_name(format!("{}/takt.db", next.get()));
            SqliteStore::open(&path, Arc::new(Metrics::new().unwrap())).unwrap()
        });
    }

    /// Tells when the writer publishes, and makes it wait there.
    struct GatedSink {
        reached: Sender<JobId>,
        gate: Mutex<Receiver<()>>,
    }

    impl EventSink for GatedSink {
        fn publish(&self, job: JobId, _: Arc<JobEvent>) {
            self.reached.send(job).unwrap();
            // An error means that the gate is open for good.
            let _ = self.gate.lock().unwrap().recv();
        }

        fn store_failed(&self, _: &StoreError) {}
    }

    #[test]
    fn writes_that_come_during_a_commit_share_the_next_and_fail_alone() {
        let place = Place::new();
        let (store, metrics) = place.open();
        let (reached, published) = mpsc::channel();
        let (open, gate) = mpsc::channel();
        store.subscribe(Arc::new(GatedSink { reached, gate: Mutex::new(gate) }));
        let at = Timestamp::UNIX_EPOCH;
        let first = JobId::new();
        let reply = store.insert(first, new_job("first"), at);
        assert_eq!(published.recv(), Ok(first));
        let ids: Vec<JobId> = (0..100).map(|_| JobId::new()).collect();
        let replies: Vec<_> = ids.iter().map(|id| store.insert(*id, new_job("a"), at)).collect();
        let twice = store.insert(ids[0], new_job("twice"), at);
        let last = store.insert(JobId::new(), new_job("last"), at);
        drop(open);
        let number = |reply: Reply<Inserted>| match reply.wait() {
            Ok(Inserted::New { number }) => number,
            other => panic!("{other:?}"),
        };
        assert_eq!(number(reply), 1);
        assert!(replies.into_iter().map(number).eq(2..=101));
        assert!(matches!(twice.wait(), Err(StoreError::Statement(_))));
        number(last);
        assert_eq!(metrics.store_batch_size.get_sample_count(), 2);
        assert_eq!(metrics.store_batch_size.get_sample_sum(), 103.0);
        // The refused insert left neither a row nor an event.
        assert_eq!(published.iter().take(101).collect::<Vec<_>>()[..100], ids);
        assert_eq!(store.events(ids[0], 0, 10).wait().unwrap().len(), 1);
        assert_eq!(store.request(ids[0]).wait().unwrap().as_deref(), Some("a"));
    }

    #[test]
    fn a_failed_commit_ends_the_store_and_loses_what_it_held() {
        let place = Place::new();
        let (store, _) = place.open();
        let kept = JobId::new();
        store.insert(kept, new_job("kept"), Timestamp::UNIX_EPOCH).wait().unwrap();
        place.break_commits();
        let lost = JobId::new();
        let failed = |error: Option<StoreError>| {
            assert!(matches!(error, Some(StoreError::Failed(_))), "{error:?}");
        };
        failed(store.insert(lost, new_job("lost"), Timestamp::UNIX_EPOCH).wait().err());
        // This would succeed, but nothing is trusted any more.
        failed(store.put_robot("a", "{}").wait().err());
        failed(store.get(kept).wait().err());
        failed(store.health().wait().err());
        drop(store);
        let (store, _) = place.open();
        assert!(store.get(kept).wait().unwrap().is_some());
        assert_eq!(store.get(lost).wait(), Ok(None));
        assert_eq!(store.robots().wait(), Ok(Vec::new()));
    }

    #[test]
    fn two_processes_cannot_share_the_data() {
        let place = Place::new();
        let (store, metrics) = place.open();
        let error = SqliteStore::open(&place.path(), metrics.clone()).err().unwrap();
        assert!(matches!(error, OpenError::InUse { .. }), "{error}");
        drop(store);
        SqliteStore::open(&place.path(), metrics).unwrap();
    }

    #[test]
    fn robots_are_kept_by_name() {
        let place = Place::new();
        let (store, _) = place.open();
        assert_eq!(store.put_robot("b", "1").wait(), Ok(true));
        assert_eq!(store.put_robot("a", "2").wait(), Ok(true));
        assert_eq!(store.put_robot("b", "3").wait(), Ok(false));
        drop(store);
        let (store, _) = place.open();
        assert_eq!(store.robot("b").wait().unwrap().as_deref(), Some("3"));
        assert_eq!(store.robot("c").wait(), Ok(None));
        let pair = |name: &str, body: &str| (name.to_owned(), body.to_owned());
        assert_eq!(store.robots().wait().unwrap(), [pair("a", "2"), pair("b", "3")]);
        assert_eq!(store.delete_robot("b").wait(), Ok(true));
        assert_eq!(store.delete_robot("b").wait(), Ok(false));
        assert_eq!(store.robot("b").wait(), Ok(None));
    }
}
