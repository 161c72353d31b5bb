//! Jobs across crashes and drains of the server.

use std::time::Duration;

use futures::StreamExt;

use super::testing::{Bench, LONG, Place, error_of, new_job, with_key};
use crate::job::{Drained, JobState, JobsError, NewJob};

// What was accepted is never lost.
#[tokio::test(flavor = "multi_thread")]
async fn a_crash_loses_neither_running_nor_queued_jobs() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let running = bench.run("gate").await;
    let later = bench.submit(NewJob { priority: 10, ..new_job("later") }).await;
    let keyed = bench.submit(with_key("keyed", "key", 1)).await;
    let image = place.crash();

    let mut bench = Bench::start(&image, 10).await;
    assert_eq!(bench.next_started().await, running);
    let again = bench.jobs.submit(with_key("keyed", "key", 1)).await.unwrap();
    assert_eq!((again.job.id, again.existing), (keyed, true));
    let other = error_of(bench.jobs.submit(with_key("other", "key", 2)).await);
    assert_eq!(other, JobsError::IdempotencyMismatch);
    // A watcher that reads events from before the crash and follows live.
    let story = bench.jobs.watch(running, 0).await.unwrap().count();
    bench.open_gate();
    for (id, attempt) in [(running, 2), (keyed, 1), (later, 1)] {
        let job = bench.ended(id).await;
        assert_eq!((job.state, job.attempt), (JobState::Succeeded, attempt));
    }
    assert_eq!(bench.runs(), ["gate", "keyed", "later"]);
    assert_eq!(bench.story(running).await, "queued running queued running succeeded");
    assert_eq!(story.await, 5);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_kills_its_process_three_times_fails() {
    let mut place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let deadly = bench.run("gate").await;
    for _ in 0..2 {
        let image = place.crash();
        bench = Bench::start(&image, 10).await;
        place = image;
        assert_eq!(bench.next_started().await, deadly);
    }
    let waiting = bench.submit(new_job("waiting")).await;
    let image = place.crash();
    let bench = Bench::start(&image, 10).await;
    bench.ended_as(deadly, JobState::Failed, Some("worker_crashed")).await;
    assert_eq!(bench.jobs.get(deadly).await.unwrap().attempt, 3);
    bench.ended_as(waiting, JobState::Succeeded, None).await;
    assert_eq!(bench.runs(), ["waiting"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn draining_queues_running_jobs_again_without_spending_an_attempt() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let running = bench.run("gate").await;
    let waiting = bench.submit(new_job("waiting")).await;
    let watcher = bench.jobs.watch(running, 2).await.unwrap();
    let drained = bench.jobs.drain(Duration::ZERO).await;
    assert_eq!(drained, Drained { interrupted: 1, abandoned: 0 });
    assert_eq!(error_of(bench.jobs.submit(new_job("too late")).await), JobsError::Draining);
    assert_eq!(error_of(bench.jobs.health().await), JobsError::Draining);
    let job = bench.jobs.get(running).await.unwrap();
    assert_eq!((job.state, job.attempt, job.started_at), (JobState::Queued, 0, None));
    assert_eq!(bench.runs(), ["gate"]);
    let mut seen: Vec<_> = watcher.collect().await;
    assert_eq!(seen.pop().unwrap().err(), Some(JobsError::Draining));
    assert_eq!(seen.len(), 1);
    drop(bench);

    let mut bench = Bench::start(&place, 10).await;
    assert_eq!(bench.next_started().await, running);
    bench.open_gate();
    bench.ended_as(running, JobState::Succeeded, None).await;
    bench.ended_as(waiting, JobState::Succeeded, None).await;
    assert_eq!(bench.jobs.get(running).await.unwrap().attempt, 1);
    assert_eq!(bench.story(running).await, "queued running queued running succeeded");
}

#[tokio::test(flavor = "multi_thread")]
async fn draining_lets_running_jobs_end_but_starts_none() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let running = bench.run("gate").await;
    let waiting = bench.submit(new_job("waiting")).await;
    let open = async {
        while bench.jobs.health().await != Err(JobsError::Draining) {
            tokio::task::yield_now().await;
        }
        bench.open_gate();
    };
    let (drained, ()) = tokio::join!(bench.jobs.drain(LONG), open);
    assert_eq!(drained, Drained { interrupted: 0, abandoned: 0 });
    bench.ended_as(running, JobState::Succeeded, None).await;
    assert_eq!(bench.jobs.get(waiting).await.unwrap().state, JobState::Queued);
    assert_eq!(bench.runs(), ["gate"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_is_not_queued_again_by_a_drain() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let running = bench.run("gate").await;
    bench.jobs.cancel(running).await.unwrap();
    bench.jobs.drain(Duration::ZERO).await;
    bench.ended_as(running, JobState::Cancelled, None).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_under_an_old_claim_is_discarded_and_counted() {
    let place = Place::new();
    let mut bench = Bench::start(&place, 10).await;
    let id = bench.run("gate").await;
    place.meddle("UPDATE jobs SET claim = claim + 1");
    bench.open_gate();
    bench.jobs.drain(LONG).await;
    assert_eq!(bench.metrics.discarded_results.get(), 1);
    assert_eq!(bench.jobs.get(id).await.unwrap().state, JobState::Running);
}
