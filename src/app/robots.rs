//! Lets the service keep its robots in the store: neither knows the other.

use std::sync::Arc;

use crate::job::Reply;
use crate::service;
use crate::store::{RobotStore, SqliteStore};

/// The store's robots as the service asks for them.
pub(super) struct StoredRobots(pub(super) Arc<SqliteStore>);

impl service::RobotStore for StoredRobots {
    fn put_robot(&self, name: &str, json: &str) -> Reply<bool> {
        self.0.put_robot(name, json)
    }

    fn robot(&self, name: &str) -> Reply<Option<String>> {
        self.0.robot(name)
    }

    fn robots(&self) -> Reply<Vec<(String, String)>> {
        self.0.robots()
    }

    fn delete_robot(&self, name: &str) -> Reply<bool> {
        self.0.delete_robot(name)
    }
}
