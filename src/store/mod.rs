//! Where jobs and robots are kept. Only this module knows SQL.

mod migrations;
mod read;
mod readers;
mod sqlite;
mod write;
mod writer;

#[cfg(test)]
mod recovery_tests;
#[cfg(test)]
mod scheduling_tests;
#[cfg(test)]
mod suite;
#[cfg(test)]
mod testing;

use std::path::PathBuf;

pub use sqlite::SqliteStore;

/// Why a store could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// This SQLite may damage its files.
    #[error("SQLite {found} is too old: 3.51.3 or later is needed")]
    SqliteVersion {
        /// The version linked.
        found: &'static str,
    },
    /// Another process works on this data.
    #[error("{} is in use by another process", .path.display())]
    InUse {
        /// The database.
        path: PathBuf,
    },
    /// A newer program wrote this data.
    #[error("the database has schema {found}, this program knows up to {known}")]
    NewerSchema {
        /// The database's version.
        found: usize,
        /// The latest version known here.
        known: usize,
    },
    /// The file system does not allow a write-ahead log.
    #[error("the database cannot keep a write-ahead log, only `{mode}`")]
    NoWriteAheadLog {
        /// The journal mode that SQLite offers instead.
        mode: String,
    },
    /// The operating system refused.
    #[error("cannot use {}", .path.display())]
    Io {
        /// What was to be used.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// SQLite refused.
    #[error("cannot open the database")]
    Sqlite(#[from] rusqlite::Error),
}
