//! The jobs that wait, in the order in which they start.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use jiff::Timestamp;

use super::{JobId, QueuedJob};

/// Which jobs a worker takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// Every job.
    Any,
    /// Only short ones, so that they never wait behind long ones alone.
    Short,
}

/// Higher priority first, then order of acceptance.
type Rank = (Reverse<u8>, u64);

/// Waiting jobs by rank, long and short apart.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    long: BTreeMap<Rank, QueuedJob>,
    short: BTreeMap<Rank, QueuedJob>,
    ranks: HashMap<JobId, (bool, Rank)>,
    expiries: BTreeSet<(Timestamp, JobId)>,
}

impl Backlog {
    pub(super) fn len(&self) -> usize {
        self.ranks.len()
    }

    /// Adds a job.
    pub(super) fn push(&mut self, job: QueuedJob) {
        let rank = (Reverse(job.priority), job.number);
        self.ranks.insert(job.id, (job.short, rank));
        self.expiries.extend(job.latest_start().map(|time| (time, job.id)));
        let queue = if job.short { &mut self.short } else { &mut self.long };
        queue.insert(rank, job);
    }

    /// Takes the first job that fits `slot`.
    pub(super) fn pop(&mut self, slot: Slot) -> Option<QueuedJob> {
        let short = self.short.first_key_value();
        let long = self.long.first_key_value().filter(|_| slot == Slot::Any);
        let first = [short, long].into_iter().flatten().min_by_key(|(rank, _)| **rank)?;
        let id = first.1.id;
        self.remove(id)
    }

    /// Takes out `id` if it waits.
    pub(super) fn remove(&mut self, id: JobId) -> Option<QueuedJob> {
        let (short, rank) = self.ranks.remove(&id)?;
        let queue = if short { &mut self.short } else { &mut self.long };
        let job = queue.remove(&rank)?;
        if let Some(time) = job.latest_start() {
            self.expiries.remove(&(time, id));
        }
        Some(job)
    }

    /// When the next job expires.
    pub(super) fn next_expiry(&self) -> Option<Timestamp> {
        self.expiries.first().map(|(time, _)| *time)
    }

    /// Takes a job that can no longer start in time.
    pub(super) fn pop_expired(&mut self, now: Timestamp) -> Option<QueuedJob> {
        let (_, id) = *self.expiries.first().filter(|(time, _)| *time <= now)?;
        self.remove(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(number: u64, priority: u8, short: bool) -> QueuedJob {
        QueuedJob {
            id: JobId::new(),
            number,
            priority,
            short,
            created_at: Timestamp::UNIX_EPOCH,
            deadline_s: None,
            start_by: None,
            task: "waypoints".into(),
            method: "exact".into(),
            last_seq: 1,
        }
    }

    fn numbers(backlog: &mut Backlog, slot: Slot) -> Vec<u64> {
        std::iter::from_fn(|| backlog.pop(slot)).map(|job| job.number).collect()
    }

    #[test]
    fn higher_priority_starts_first_then_the_older_job() {
        let mut backlog = Backlog::default();
        let jobs = [(1, 50, false), (2, 90, true), (3, 50, true), (4, 90, false), (5, 0, false)];
        jobs.into_iter().rev().for_each(|(n, p, short)| backlog.push(job(n, p, short)));
        assert_eq!(numbers(&mut backlog, Slot::Any), [2, 4, 1, 3, 5]);
        assert_eq!(backlog.len(), 0);
    }

    #[test]
    fn the_short_slot_leaves_long_jobs_alone() {
        let mut backlog = Backlog::default();
        [(1, 90, false), (2, 10, true), (3, 20, true)]
            .into_iter()
            .for_each(|(n, p, short)| backlog.push(job(n, p, short)));
        assert_eq!(numbers(&mut backlog, Slot::Short), [3, 2]);
        assert_eq!(numbers(&mut backlog, Slot::Any), [1]);
    }

    #[test]
    fn the_earlier_of_deadline_and_start_by_expires_a_job() {
        let second = |s| Timestamp::from_second(s).unwrap();
        let mut backlog = Backlog::default();
        backlog.push(QueuedJob { deadline_s: Some(9.0), ..job(1, 50, false) });
        backlog.push(QueuedJob {
            deadline_s: Some(8.0),
            start_by: Some(second(5)),
            ..job(2, 50, true)
        });
        backlog.push(job(3, 50, false));
        let removed = job(4, 50, false);
        backlog.push(QueuedJob { start_by: Some(second(1)), ..removed.clone() });
        backlog.remove(removed.id);
        assert_eq!(backlog.next_expiry(), Some(second(5)));
        assert!(backlog.pop_expired(second(4)).is_none());
        assert_eq!(backlog.pop_expired(second(5)).map(|job| job.number), Some(2));
        assert!(backlog.pop_expired(second(5)).is_none());
        assert_eq!(backlog.pop_expired(second(100)).map(|job| job.number), Some(1));
        assert_eq!(backlog.next_expiry(), None);
        assert_eq!(backlog.len(), 1);
    }
}
