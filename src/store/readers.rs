//! A few threads that read. The write-ahead log keeps them out of the
//! writer's way and it out of theirs.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use rusqlite::Connection;

use super::writer::Health;
use crate::job::{Reply, StoreError};

type Query = Box<dyn FnOnce(&Connection) + Send>;

/// Sends queries to the reading threads, which end when this is dropped.
pub(super) struct Readers {
    queries: Sender<Query>,
    health: Arc<Health>,
}

impl Readers {
    /// Starts a thread for every connection.
    pub(super) fn start(
        connections: Vec<Connection>,
        health: Arc<Health>,
    ) -> Result<Self, std::io::Error> {
        let (queries, queue) = channel();
        let queue = Arc::new(Mutex::new(queue));
        for connection in connections {
            let queue = queue.clone();
            let run = move || while next(&queue).is_some_and(|query| answer(query, &connection)) {};
            thread::Builder::new().name("takt-store-reader".to_owned()).spawn(run)?;
        }
        Ok(Self { queries, health })
    }

    /// Has `query` answered by whichever thread is free.
    pub(super) fn read<T: Send + 'static>(
        &self,
        query: impl FnOnce(&Connection) -> rusqlite::Result<T> + Send + 'static,
    ) -> Reply<T> {
        if let Err(failure) = self.health.check() {
            return Reply::ready(Err(failure));
        }
        let (sender, reply) = Reply::channel();
        let answer = move |connection: &Connection| {
            let answer = query(connection);
            sender.send(answer.map_err(|error| StoreError::Statement(error.to_string())));
        };
        // If the threads are gone, the sender is dropped and the reply says so.
        let _ = self.queries.send(Box::new(answer));
        reply
    }
}

fn next(queue: &Mutex<Receiver<Query>>) -> Option<Query> {
    queue.lock().unwrap_or_else(PoisonError::into_inner).recv().ok()
}

fn answer(query: Query, connection: &Connection) -> bool {
    query(connection);
    true
}
