//! The changes. Each is one call inside the writer's transaction, and writes
//! the events that tell of it.

use std::sync::Arc;

use jiff::Timestamp;
use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;

use super::read;
use super::writer::Events;
use crate::job::{
    Claim, EventKind, Finish, Inserted, JobError, JobEvent, JobId, JobState, NewJob, Progress,
    QueuedJob,
};

/// A change under way.
pub(super) struct Change<'a> {
    pub(super) connection: &'a Connection,
    pub(super) events: &'a mut Events,
}

impl Change<'_> {
    pub(super) fn insert(
        &mut self,
        id: JobId,
        new: &NewJob,
        at: Timestamp,
    ) -> rusqlite::Result<Inserted> {
        if let Some(key) = &new.idempotency
            && let Some(used) = read::key_use(self.connection, key)?
        {
            return Ok(Inserted::KeyUsed(used));
        }
        let key = new.idempotency.as_ref();
        let mut statement = self.connection.prepare_cached(
            "INSERT INTO jobs (id, state, priority, short, task, method, robot, seed, labels,
                 created_at, deadline_s, start_by, idempotency_key, body_sha256)
             VALUES (?1, 'queued', ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)",
        )?;
        let number = statement.insert(params![
            id.to_string(),
            new.priority,
            new.short,
            new.task,
            new.method,
            new.robot,
            new.seed.cast_signed(),
            json(&new.labels)?,
            at.as_microsecond(),
            new.deadline_s,
            new.start_by.map(Timestamp::as_microsecond),
            key.map(|key| &key.key),
            key.map(|key| key.body_sha256),
        ])?;
        for (key, value) in &new.labels {
            self.run("INSERT INTO labels VALUES (?1, ?2, ?3)", params![key, value, number])?;
        }
        self.run("INSERT INTO requests VALUES (?1, ?2)", params![number, new.request])?;
        self.emit(number, id, at, EventKind::State { state: JobState::Queued, attempt: 0 })?;
        Ok(Inserted::New { number: number.cast_unsigned() })
    }

    pub(super) fn recover(
        &mut self,
        max_attempts: u32,
        at: Timestamp,
    ) -> rusqlite::Result<Vec<QueuedJob>> {
        for (id, claim, attempt) in self.running()? {
            if attempt >= max_attempts {
                let failed = Finish::new(JobState::Failed, at);
                self.finish(id, claim, Finish { error: Some(crashed(attempt)), ..failed })?;
                continue;
            }
            if let Some((number, attempt)) = self.back_to_queue(id, claim, 0)? {
                self.emit(number, id, at, EventKind::State { state: JobState::Queued, attempt })?;
            }
        }
        read::queued(self.connection)
    }

    fn running(&self) -> rusqlite::Result<Vec<(JobId, u64, u32)>> {
        let mut statement = self.connection.prepare(
            "SELECT id, claim, attempt FROM jobs WHERE state = 'running' ORDER BY number",
        )?;
        let jobs = statement.query_map([], |row| {
            Ok((read::parsed(row, "id")?, read::count(row, "claim")?, row.get("attempt")?))
        })?;
        jobs.collect()
    }

    pub(super) fn start(&mut self, id: JobId, at: Timestamp) -> rusqlite::Result<Option<Claim>> {
        let mut statement = self.connection.prepare_cached(
            "UPDATE jobs SET state = 'running', attempt = attempt + 1, claim = claim + 1,
                 started_at = ?2
             WHERE id = ?1 AND state = 'queued' RETURNING number, claim, attempt",
        )?;
        let started = statement.query_row(params![id.to_string(), at.as_microsecond()], |row| {
            Ok((row.get("number")?, read::count(row, "claim")?, row.get("attempt")?))
        });
        let Some((job, number, attempt)) = started.optional()? else { return Ok(None) };
        self.emit(job, id, at, EventKind::State { state: JobState::Running, attempt })?;
        let request = read::request(self.connection, id)?;
        let request = request.ok_or(rusqlite::Error::QueryReturnedNoRows)?;
        Ok(Some(Claim { number, attempt, request }))
    }

    pub(super) fn requeue(
        &mut self,
        id: JobId,
        claim: u64,
        at: Timestamp,
    ) -> rusqlite::Result<bool> {
        let Some((job, attempt)) = self.back_to_queue(id, claim, 1)? else { return Ok(false) };
        self.emit(job, id, at, EventKind::State { state: JobState::Queued, attempt })?;
        Ok(true)
    }

    /// Number and attempts of the job if it ran under `claim`.
    fn back_to_queue(
        &self,
        id: JobId,
        claim: u64,
        refunded: u32,
    ) -> rusqlite::Result<Option<(i64, u32)>> {
        let mut statement = self.connection.prepare_cached(
            "UPDATE jobs SET state = 'queued', attempt = attempt - ?3, started_at = NULL
             WHERE id = ?1 AND state = 'running' AND claim = ?2 RETURNING number, attempt",
        )?;
        let values = params![id.to_string(), claim.cast_signed(), refunded];
        statement.query_row(values, |row| Ok((row.get(0)?, row.get(1)?))).optional()
    }

    pub(super) fn progress(
        &mut self,
        id: JobId,
        claim: u64,
        at: Timestamp,
        progress: Progress,
    ) -> rusqlite::Result<bool> {
        let mut statement = self.connection.prepare_cached(
            "UPDATE jobs SET progress = ?3
             WHERE id = ?1 AND state = 'running' AND claim = ?2 RETURNING number",
        )?;
        let number = statement
            .query_row(params![id.to_string(), claim.cast_signed(), json(&progress)?], |row| {
                row.get(0)
            })
            .optional()?;
        let Some(number) = number else { return Ok(false) };
        self.emit(number, id, at, EventKind::Progress(progress))?;
        Ok(true)
    }

    pub(super) fn finish(
        &mut self,
        id: JobId,
        claim: u64,
        finish: Finish,
    ) -> rusqlite::Result<bool> {
        self.end(id, "running", Some(claim), finish)
    }

    pub(super) fn finish_queued(&mut self, id: JobId, finish: Finish) -> rusqlite::Result<bool> {
        self.end(id, "queued", None, finish)
    }

    /// Ends the job if it is in state `from`, under `claim` if one is given.
    fn end(
        &mut self,
        id: JobId,
        from: &str,
        claim: Option<u64>,
        finish: Finish,
    ) -> rusqlite::Result<bool> {
        let Finish { state, at, result, summary, error } = finish;
        let mut statement = self.connection.prepare_cached(
            "UPDATE jobs SET state = ?4, finished_at = ?5, error = ?6
             WHERE id = ?1 AND state = ?2 AND claim = coalesce(?3, claim) RETURNING number",
        )?;
        let error_json = error.as_ref().map(json).transpose()?;
        let claim = claim.map(u64::cast_signed);
        let values =
            params![id.to_string(), from, claim, state.as_str(), at.as_microsecond(), error_json];
        let number: Option<i64> = statement.query_row(values, |row| row.get(0)).optional()?;
        let Some(number) = number else { return Ok(false) };
        if let Some(result) = result {
            self.run("INSERT INTO results VALUES (?1, ?2)", params![number, result])?;
        }
        self.emit(number, id, at, EventKind::Finished { state, summary, error })?;
        Ok(true)
    }

    pub(super) fn delete(&mut self, id: JobId) -> rusqlite::Result<Option<JobState>> {
        let state = read::state(self.connection, id)?;
        if state.is_some_and(JobState::is_ended) {
            self.run("DELETE FROM jobs WHERE id = ?1", params![id.to_string()])?;
        }
        Ok(state)
    }

    pub(super) fn delete_ended_before(
        &mut self,
        time: Timestamp,
        limit: usize,
    ) -> rusqlite::Result<usize> {
        let limit = i64::try_from(limit).unwrap_or(i64::MAX);
        self.run(
            "DELETE FROM jobs WHERE number IN
                 (SELECT number FROM jobs WHERE finished_at < ?1 ORDER BY finished_at LIMIT ?2)",
            params![time.as_microsecond(), limit],
        )
    }

    pub(super) fn put_robot(&mut self, name: &str, body: &str) -> rusqlite::Result<bool> {
        let new = read::robot(self.connection, name)?.is_none();
        self.run("INSERT OR REPLACE INTO robots VALUES (?1, ?2)", params![name, body])?;
        Ok(new)
    }

    pub(super) fn delete_robot(&mut self, name: &str) -> rusqlite::Result<bool> {
        Ok(self.run("DELETE FROM robots WHERE name = ?1", params![name])? > 0)
    }

    /// Writes the job's next event.
    fn emit(
        &mut self,
        number: i64,
        id: JobId,
        time: Timestamp,
        kind: EventKind,
    ) -> rusqlite::Result<()> {
        let mut statement = self.connection.prepare_cached(
            "UPDATE jobs SET last_seq = last_seq + 1 WHERE number = ?1 RETURNING last_seq",
        )?;
        let seq = statement.query_row([number], |row| read::count(row, "last_seq"))?;
        self.run(
            "INSERT INTO events VALUES (?1, ?2, ?3, ?4)",
            params![number, seq.cast_signed(), time.as_microsecond(), json(&kind)?],
        )?;
        self.events.push((id, Arc::new(JobEvent { seq, time, kind })));
        Ok(())
    }

    fn run(&self, sql: &str, values: impl rusqlite::Params) -> rusqlite::Result<usize> {
        self.connection.prepare_cached(sql)?.execute(values)
    }
}

fn crashed(attempts: u32) -> JobError {
    JobError {
        code: "worker_crashed".to_owned(),
        message: format!("the server died in each of {attempts} attempts to run the job"),
        details: serde_json::Value::Null,
    }
}

fn json(value: &impl Serialize) -> rusqlite::Result<String> {
    let text = serde_json::to_string(value);
    text.map_err(|error| rusqlite::Error::ToSqlConversionFailure(Box::new(error)))
}
