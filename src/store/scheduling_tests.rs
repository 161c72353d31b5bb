//! Jobs on a real store: order, slots, cancelling, expiry, watching. The tests
//! stand here because `job` may not know a store.

use futures::StreamExt;
use jiff::Timestamp;
use serde_json::json;

use super::testing::{Bench, LONG, Place, error_of, new_job, with_key};
use crate::job::{EventKind, JobCounts, JobFilter, JobId, JobState, JobsError, NewJob};

#[tokio::test(flavor = "multi_thread")]
async fn a_job_runs_and_leaves_its_result_and_story() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let submitted = bench.jobs.submit(new_job("plain")).await.unwrap();
    assert!(!submitted.existing);
    let id = submitted.job.id;
    bench.ended_as(id, JobState::Succeeded, None).await;
    let job = bench.jobs.get(id).await.unwrap();
    assert_eq!((job.attempt, job.seed, job.robot.as_str()), (1, u64::MAX, "sample"));
    assert_eq!(job.created_at, submitted.job.created_at);
    assert!(job.created_at <= job.started_at.unwrap());
    assert!(job.started_at <= job.finished_at);
    assert_eq!(bench.result(id).await["request"], "plain");
    assert_eq!(bench.jobs.request(id).await.unwrap(), "plain");
    assert_eq!(bench.story(id).await, "queued running succeeded");
    assert_eq!(bench.next_started().await, id);
    // Counted by the worker after the commit that watchers see.
    let ended = r#"takt_jobs_ended_total{method="exact",state="succeeded",task="waypoints"} 1"#;
    while !bench.metrics.text().unwrap().contains(ended) {
        tokio::task::yield_now().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn higher_priority_runs_first_and_equals_in_order() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    bench.run("gate").await;
    let mut last = None;
    for (request, priority) in [("low", 10), ("high", 90), ("middle", 50), ("middle too", 50)] {
        let id = bench.submit(NewJob { priority, ..new_job(request) }).await;
        last = last.or(Some(id));
    }
    assert_eq!(bench.jobs.counts(), JobCounts { queued: 4, running: 1, capacity: 10 });
    bench.open_gate();
    bench.ended(last.unwrap()).await;
    assert_eq!(bench.runs(), ["gate", "high", "middle", "middle too", "low"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_short_job_runs_while_long_ones_hold_all_workers() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    bench.run("gate").await;
    let waiting = bench.submit(NewJob { priority: 100, ..new_job("long") }).await;
    let short = bench.submit(NewJob { short: true, ..new_job("short") }).await;
    bench.ended_as(short, JobState::Succeeded, None).await;
    assert_eq!(bench.runs(), ["gate", "short"]);
    assert_eq!(bench.jobs.get(waiting).await.unwrap().state, JobState::Queued);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_queued_job_is_cancelled_at_once_and_never_runs() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let held = bench.run("gate").await;
    let id = bench.submit(new_job("never")).await;
    assert_eq!(error_of(bench.jobs.delete(id).await), conflict(id, JobState::Queued));
    assert_eq!(error_of(bench.jobs.result(id).await), conflict(id, JobState::Queued));
    assert_eq!(bench.jobs.cancel(id).await.unwrap().state, JobState::Cancelled);
    assert_eq!(error_of(bench.jobs.cancel(id).await), conflict(id, JobState::Cancelled));
    assert_eq!(bench.story(id).await, "queued cancelled");
    bench.open_gate();
    bench.ended(held).await;
    assert_eq!(bench.runs(), ["gate"]);
    bench.jobs.delete(id).await.unwrap();
    for error in [
        error_of(bench.jobs.get(id).await),
        error_of(bench.jobs.cancel(id).await),
        error_of(bench.jobs.delete(id).await),
        error_of(bench.jobs.watch(id, 0).await),
        error_of(bench.jobs.wait_ended(id, LONG).await),
    ] {
        assert_eq!(error, JobsError::NotFound(id));
    }
}

fn conflict(id: JobId, state: JobState) -> JobsError {
    JobsError::Conflict { id, state }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_running_job_is_cancelled_and_keeps_what_there_is() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let id = bench.run("gate").await;
    bench.jobs.cancel(id).await.unwrap();
    bench.ended_as(id, JobState::Cancelled, None).await;
    assert_eq!(bench.result(id).await, json!("partial"));
    assert_eq!(bench.story(id).await, "queued running cancelled");
    let next = bench.run("next").await;
    bench.ended_as(next, JobState::Succeeded, None).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_that_cannot_start_in_time_expire_while_workers_are_busy() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    bench.run("gate").await;
    let past = Some(Timestamp::now());
    let by_time = bench.submit(NewJob { start_by: past, ..new_job("late") }).await;
    let by_deadline = bench.submit(NewJob { deadline_s: Some(0.001), ..new_job("late") }).await;
    bench.ended_as(by_time, JobState::Expired, Some("start_by_passed")).await;
    bench.ended_as(by_deadline, JobState::Expired, Some("deadline_exceeded")).await;
    assert_eq!(bench.story(by_time).await, "queued expired");
    assert_eq!(bench.runs(), ["gate"]);
    assert_eq!(bench.jobs.counts().queued, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_runner_is_told_of_the_deadline() {
    let place = Place::new();
    let bench = Bench::start(&place, 10).await;
    let with = bench.submit(NewJob { deadline_s: Some(60.0), ..new_job("a") }).await;
    let without = bench.submit(NewJob { deadline_s: Some(1e300), ..new_job("b") }).await;
    bench.ended(with).await;
    bench.ended(without).await;
    assert_eq!(bench.result(with).await["deadline"], true);
    assert_eq!(bench.result(without).await["deadline"], json!(null));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_fails_its_job_and_not_the_worker() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let id = bench.run("panic").await;
    bench.ended_as(id, JobState::Failed, Some("internal")).await;
    assert!(bench.jobs.get(id).await.unwrap().error.unwrap().message.contains("panicked"));
    let id = bench.run("give_up").await;
    bench.ended_as(id, JobState::Failed, Some("internal")).await;
    let id = bench.run("next").await;
    bench.ended_as(id, JobState::Succeeded, None).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_queue_refuses_but_still_answers_repetitions() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 1).await;
    bench.run("gate").await;
    let first = bench.submit(with_key("waiting", "key", 1)).await;
    let full = error_of(bench.jobs.submit(new_job("one too many")).await);
    assert_eq!(full, JobsError::QueueFull { capacity: 1 });
    let again = bench.jobs.submit(with_key("waiting", "key", 1)).await.unwrap();
    assert_eq!((again.job.id, again.existing), (first, true));
    let other = error_of(bench.jobs.submit(with_key("other", "key", 2)).await);
    assert_eq!(other, JobsError::IdempotencyMismatch);
    // The cancelled job leaves its place to another.
    bench.jobs.cancel(first).await.unwrap();
    bench.submit(new_job("another")).await;
    assert_eq!(bench.jobs.counts().queued, 1);
}

// Without it, a late watcher could see another history than an early one.
#[tokio::test(flavor = "multi_thread")]
async fn two_hundred_watchers_see_the_same_events_whenever_they_come() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let id = bench.run("report").await;
    let mut watchers = Vec::new();
    for number in 0..100 {
        // Those that reconnect have seen up to two events.
        let events = bench.jobs.watch(id, number % 3).await.unwrap();
        watchers.push((number % 3, tokio::spawn(events.collect::<Vec<_>>())));
    }
    bench.open_gate();
    bench.ended(id).await;
    for number in 0..100 {
        let events = bench.jobs.watch(id, number % 4).await.unwrap();
        watchers.push((number % 4, tokio::spawn(events.collect::<Vec<_>>())));
    }
    let expected = bench.events(id, 0).await;
    // How many reports pass in between depends on the machine.
    let story = bench.story(id).await;
    assert!(story.starts_with("queued running progress progress "), "{story}");
    assert!(story.ends_with("progress succeeded"), "{story}");
    assert!((1..).zip(&expected).all(|(seq, event)| event.seq == seq), "{expected:?}");
    let iterations = expected.iter().filter_map(|event| match &event.kind {
        EventKind::Progress(progress) => Some((progress.iteration, progress.best)),
        _ => None,
    });
    let iterations: Vec<_> = iterations.collect();
    assert_eq!(
        (iterations.first(), iterations.last()),
        (Some(&(1, None)), Some(&(1000, Some(0.1))))
    );
    assert_eq!(watchers.len(), 200);
    for (after_seq, watcher) in watchers {
        let seen: Vec<_> = watcher.await.unwrap().into_iter().map(Result::unwrap).collect();
        let expected = &expected[usize::try_from(after_seq).unwrap()..];
        assert!(seen.iter().map(|event| &**event).eq(expected), "after {after_seq}: {seen:?}");
    }
    assert!(bench.events(id, expected.len() as u64).await.is_empty());
    let job = bench.jobs.get(id).await.unwrap();
    assert_eq!(job.progress.map(|progress| progress.iteration), Some(1000));
    assert!(
        bench.metrics.text().unwrap().contains("takt_evaluations_total{method=\"exact\"} 10000")
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn ended_jobs_are_forgotten_and_active_ones_kept() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 2000).await;
    let done = bench.run("plain").await;
    bench.ended(done).await;
    let held = bench.run("gate").await;
    // More than are deleted in one piece.
    for _ in 0..501 {
        let id = bench.submit(new_job("queued")).await;
        bench.jobs.cancel(id).await.unwrap();
    }
    let waiting = bench.submit(new_job("queued")).await;
    let end = bench.jobs.get(done).await.unwrap().finished_at.unwrap();
    assert_eq!(bench.jobs.delete_ended_before(end).await, Ok(0));
    assert_eq!(bench.jobs.delete_ended_before(Timestamp::MAX).await, Ok(502));
    let left = bench.jobs.list(JobFilter { page_size: 10, ..<_>::default() }).await.unwrap();
    let left: Vec<JobId> = left.jobs.iter().map(|job| job.id).collect();
    assert_eq!(left, [waiting, held]);
}

// A server whose disk fails has to say so at once, to everybody.
#[tokio::test(flavor = "multi_thread")]
async fn a_failed_store_is_reported_to_callers_and_watchers() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let id = bench.run("gate").await;
    let events = bench.jobs.watch(id, 0).await.unwrap();
    assert_eq!(bench.jobs.health().await, Ok(()));
    place.break_commits();
    let failed = |error: JobsError| assert!(matches!(error, JobsError::StoreFailed(_)), "{error}");
    failed(error_of(bench.jobs.submit(new_job("lost")).await));
    failed(error_of(bench.jobs.submit(new_job("lost")).await));
    failed(error_of(bench.jobs.get(id).await));
    failed(error_of(bench.jobs.health().await));
    failed(error_of(bench.jobs.wait_ended(id, LONG).await));
    let mut seen: Vec<_> = events.collect().await;
    failed(error_of(seen.pop().unwrap()));
    assert_eq!(seen.len(), 2);
    assert_eq!(bench.jobs.counts().queued, 0);
    bench.open_gate();
    bench.jobs.drain(LONG).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_that_cannot_be_stored_fails_its_job() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    place.meddle(
        "CREATE TRIGGER full BEFORE INSERT ON results BEGIN SELECT RAISE(ABORT, 'no'); END",
    );
    let id = bench.run("plain").await;
    bench.ended_as(id, JobState::Failed, Some("internal")).await;
    assert_eq!(bench.story(id).await, "queued running failed");
    assert_eq!(bench.jobs.result(id).await.unwrap().text, None);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_cannot_be_read_fails_instead_of_waiting_for_ever() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    bench.run("gate").await;
    let broken = bench.submit(new_job("broken")).await;
    place.meddle("DELETE FROM requests WHERE body = 'broken'");
    bench.open_gate();
    bench.ended_as(broken, JobState::Failed, Some("internal")).await;
    assert_eq!(bench.runs(), ["gate"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn cancelling_a_job_in_nobodys_hands_comes_to_an_end() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    bench.run("gate").await;
    let orphan = bench.submit(new_job("orphan")).await;
    place.meddle("UPDATE jobs SET state = 'running' WHERE state = 'queued'");
    let refused = error_of(bench.jobs.cancel(orphan).await);
    assert_eq!(refused, conflict(orphan, JobState::Running));
}
