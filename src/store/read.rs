//! The queries.

use jiff::Timestamp;
use rusqlite::types::{Type, Value};
use rusqlite::{Connection, OptionalExtension, Row, params, params_from_iter};
use serde::de::DeserializeOwned;

use crate::job::{
    Idempotency, Job, JobEvent, JobFilter, JobId, JobPage, JobState, KeyUse, QueuedJob,
};

const JOB_COLUMNS: &str = "id, state, priority, labels, task, method, robot, seed, created_at, \
     started_at, finished_at, deadline_s, start_by, attempt, progress, error";

pub(super) fn job(connection: &Connection, id: JobId) -> rusqlite::Result<Option<Job>> {
    let sql = format!("SELECT {JOB_COLUMNS} FROM jobs WHERE id = ?1");
    connection.prepare_cached(&sql)?.query_row([id.to_string()], job_of).optional()
}

pub(super) fn key_use(
    connection: &Connection,
    key: &Idempotency,
) -> rusqlite::Result<Option<KeyUse>> {
    let sql = format!("SELECT {JOB_COLUMNS}, body_sha256 FROM jobs WHERE idempotency_key = ?1");
    let found = |row: &Row<'_>| {
        let same = row.get::<_, [u8; 32]>("body_sha256")? == key.body_sha256;
        Ok(if same { KeyUse::SameBody(Box::new(job_of(row)?)) } else { KeyUse::OtherBody })
    };
    connection.prepare_cached(&sql)?.query_row([&key.key], found).optional()
}

/// Jobs accepted before the one numbered `before`, newest first.
pub(super) fn list(
    connection: &Connection,
    filter: &JobFilter,
    before: Option<i64>,
) -> rusqlite::Result<JobPage> {
    let mut sql = format!("SELECT {JOB_COLUMNS}, number FROM jobs WHERE number < ?");
    let mut values = vec![Value::Integer(before.unwrap_or(i64::MAX))];
    if let Some(state) = filter.state {
        sql.push_str(" AND state = ?");
        values.push(Value::Text(state.to_string()));
    }
    for (key, value) in &filter.labels {
        sql.push_str(
            " AND EXISTS (SELECT 1 FROM labels WHERE key = ? AND value = ? AND job = number)",
        );
        values.extend([Value::Text(key.clone()), Value::Text(value.clone())]);
    }
    sql.push_str(" ORDER BY number DESC LIMIT ?");
    let page_size = filter.page_size.max(1);
    // One more than asked for tells whether there is another page.
    values.push(Value::Integer(i64::try_from(page_size).unwrap_or(i64::MAX).saturating_add(1)));
    let mut statement = connection.prepare_cached(&sql)?;
    let rows = statement
        .query_map(params_from_iter(values), |row| Ok((job_of(row)?, row.get("number")?)))?;
    let mut jobs: Vec<(Job, i64)> = rows.collect::<Result<_, _>>()?;
    let more = jobs.len() > page_size;
    jobs.truncate(page_size);
    let next_page_token = jobs.last().filter(|_| more).map(|(_, number)| number.to_string());
    Ok(JobPage { jobs: jobs.into_iter().map(|(job, _)| job).collect(), next_page_token })
}

pub(super) fn request(connection: &Connection, id: JobId) -> rusqlite::Result<Option<String>> {
    let sql = "SELECT body FROM requests WHERE job = (SELECT number FROM jobs WHERE id = ?1)";
    connection.prepare_cached(sql)?.query_row([id.to_string()], |row| row.get(0)).optional()
}

pub(super) fn result(connection: &Connection, id: JobId) -> rusqlite::Result<Option<String>> {
    let sql = "SELECT body FROM results WHERE job = (SELECT number FROM jobs WHERE id = ?1)";
    connection.prepare_cached(sql)?.query_row([id.to_string()], |row| row.get(0)).optional()
}

pub(super) fn events(
    connection: &Connection,
    id: JobId,
    after_seq: u64,
    limit: usize,
) -> rusqlite::Result<Vec<JobEvent>> {
    let mut statement = connection.prepare_cached(
        "SELECT seq, time, kind FROM events
         WHERE job = (SELECT number FROM jobs WHERE id = ?1) AND seq > ?2 ORDER BY seq LIMIT ?3",
    )?;
    let after_seq = i64::try_from(after_seq).unwrap_or(i64::MAX);
    let limit = i64::try_from(limit).unwrap_or(i64::MAX);
    let event = |row: &Row<'_>| {
        Ok(JobEvent { seq: count(row, "seq")?, time: time(row, "time")?, kind: json(row, "kind")? })
    };
    statement.query_map(params![id.to_string(), after_seq, limit], event)?.collect()
}

/// All queued jobs in order of acceptance.
pub(super) fn queued(connection: &Connection) -> rusqlite::Result<Vec<QueuedJob>> {
    let mut statement = connection.prepare(
        "SELECT id, number, priority, short, created_at, deadline_s, start_by, task, method,
             last_seq
         FROM jobs WHERE state = 'queued' ORDER BY number",
    )?;
    let job = |row: &Row<'_>| {
        Ok(QueuedJob {
            id: parsed(row, "id")?,
            number: count(row, "number")?,
            priority: row.get("priority")?,
            short: row.get("short")?,
            created_at: time(row, "created_at")?,
            deadline_s: row.get("deadline_s")?,
            start_by: optional_time(row, "start_by")?,
            task: row.get("task")?,
            method: row.get("method")?,
            last_seq: count(row, "last_seq")?,
        })
    };
    statement.query_map([], job)?.collect()
}

pub(super) fn state(connection: &Connection, id: JobId) -> rusqlite::Result<Option<JobState>> {
    let mut statement = connection.prepare_cached("SELECT state FROM jobs WHERE id = ?1")?;
    statement.query_row([id.to_string()], |row| parsed(row, "state")).optional()
}

pub(super) fn robot(connection: &Connection, name: &str) -> rusqlite::Result<Option<String>> {
    let mut statement = connection.prepare_cached("SELECT body FROM robots WHERE name = ?1")?;
    statement.query_row([name], |row| row.get(0)).optional()
}

pub(super) fn robots(connection: &Connection) -> rusqlite::Result<Vec<(String, String)>> {
    let mut statement = connection.prepare_cached("SELECT name, body FROM robots ORDER BY name")?;
    statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?.collect()
}

fn job_of(row: &Row<'_>) -> rusqlite::Result<Job> {
    Ok(Job {
        id: parsed(row, "id")?,
        state: parsed(row, "state")?,
        priority: row.get("priority")?,
        labels: json(row, "labels")?,
        task: row.get("task")?,
        method: row.get("method")?,
        robot: row.get("robot")?,
        seed: count(row, "seed")?,
        created_at: time(row, "created_at")?,
        started_at: optional_time(row, "started_at")?,
        finished_at: optional_time(row, "finished_at")?,
        deadline_s: row.get("deadline_s")?,
        start_by: optional_time(row, "start_by")?,
        attempt: row.get("attempt")?,
        progress: optional_json(row, "progress")?,
        error: optional_json(row, "error")?,
    })
}

/// An unsigned number; SQLite knows signed ones only.
pub(super) fn count(row: &Row<'_>, column: &str) -> rusqlite::Result<u64> {
    row.get(column).map(i64::cast_unsigned)
}

/// A column that holds a value's name.
pub(super) fn parsed<T>(row: &Row<'_>, column: &str) -> rusqlite::Result<T>
where
    T: std::str::FromStr<Err: std::error::Error + Send + Sync + 'static>,
{
    let text: String = row.get(column)?;
    text.parse().map_err(|error| unreadable(Type::Text, error))
}

fn time(row: &Row<'_>, column: &str) -> rusqlite::Result<Timestamp> {
    Timestamp::from_microsecond(row.get(column)?).map_err(|error| unreadable(Type::Integer, error))
}

fn optional_time(row: &Row<'_>, column: &str) -> rusqlite::Result<Option<Timestamp>> {
    let time = row.get::<_, Option<i64>>(column)?.map(Timestamp::from_microsecond);
    time.transpose().map_err(|error| unreadable(Type::Integer, error))
}

fn json<T: DeserializeOwned>(row: &Row<'_>, column: &str) -> rusqlite::Result<T> {
    let text: String = row.get(column)?;
    serde_json::from_str(&text).map_err(|error| unreadable(Type::Text, error))
}

fn optional_json<T: DeserializeOwned>(row: &Row<'_>, column: &str) -> rusqlite::Result<Option<T>> {
    let value = row.get::<_, Option<String>>(column)?.map(|text| serde_json::from_str(&text));
    value.transpose().map_err(|error| unreadable(Type::Text, error))
}

fn unreadable(
    found: Type,
    error: impl std::error::Error + Send + Sync + 'static,
) -> rusqlite::Error {
    rusqlite::Error::FromSqlConversionFailure(0, found, Box::new(error))
}
