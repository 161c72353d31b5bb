//! What every job store has to do, whatever it is built on.

use std::collections::BTreeMap;

use jiff::Timestamp;
use serde_json::{Value, json};

use super::testing::{new_job, with_key};
use crate::job::{
    EventKind, Finish, Idempotency, Inserted, Job, JobError, JobFilter, JobId, JobState, JobStore,
    KeyUse, NewJob, Progress, StoreError,
};

/// Runs the suite, each part on a store of its own.
pub(super) fn run<S: JobStore>(fresh: impl Fn() -> S) {
    keeps_what_was_inserted(&fresh());
    moves_jobs_only_along_their_states(&fresh());
    fences_results_by_claim(&fresh());
    takes_an_attempt_back_when_queued_again(&fresh());
    numbers_events_without_gaps(&fresh());
    pages_and_filters_newest_first(&fresh());
    knows_idempotency_keys(&fresh());
    deletes_only_ended_jobs(&fresh());
    recovers_in_order_of_acceptance(&fresh());
}

fn second(second: i64) -> Timestamp {
    Timestamp::from_second(second).unwrap()
}

fn insert(store: &dyn JobStore, new: NewJob) -> JobId {
    let id = JobId::new();
    let inserted = store.insert(id, new, second(10)).wait().unwrap();
    assert!(matches!(inserted, Inserted::New { .. }), "{inserted:?}");
    id
}

fn start(store: &dyn JobStore, id: JobId) -> u64 {
    store.start(id, second(20)).wait().unwrap().unwrap().number
}

fn succeeded() -> Finish {
    let result = Some(r#"{"duration":1.5}"#.to_owned());
    Finish {
        result,
        summary: Some(json!({"d": 1.5})),
        ..Finish::new(JobState::Succeeded, second(30))
    }
}

fn state(store: &dyn JobStore, id: JobId) -> JobState {
    store.get(id).wait().unwrap().unwrap().state
}

fn keeps_what_was_inserted(store: &dyn JobStore) {
    let labels = BTreeMap::from([("cell".to_owned(), "3 'é\"".to_owned())]);
    let new = NewJob {
        labels,
        priority: 100,
        deadline_s: Some(0.1 + 0.2),
        start_by: Some(second(99)),
        ..new_job(r#"{"task": 1}"#)
    };
    let id = insert(store, new.clone());
    let expected = Job::accepted(id, &new, second(10));
    assert_eq!(store.get(id).wait().unwrap(), Some(expected));
    assert_eq!(store.request(id).wait().unwrap().as_deref(), Some(r#"{"task": 1}"#));
    assert_eq!(store.result(id).wait().unwrap(), None);
    let unknown = JobId::new();
    assert_eq!(store.get(unknown).wait().unwrap(), None);
    assert_eq!(store.request(unknown).wait().unwrap(), None);
    assert_eq!(store.delete(unknown).wait().unwrap(), None);
    assert_eq!(store.health().wait(), Ok(()));
}

fn moves_jobs_only_along_their_states(store: &dyn JobStore) {
    let id = insert(store, new_job("a"));
    assert!(!store.finish(id, 0, succeeded()).wait().unwrap(), "a queued job has no result");
    assert!(!store.requeue(id, 0, second(20)).wait().unwrap());
    let claim = store.start(id, second(20)).wait().unwrap().unwrap();
    assert_eq!((claim.number, claim.attempt, claim.request.as_str()), (1, 1, "a"));
    assert_eq!(store.start(id, second(20)).wait().unwrap(), None, "it runs already");
    let cancelled = || Finish::new(JobState::Cancelled, second(25));
    assert!(!store.finish_queued(id, cancelled()).wait().unwrap(), "it is not queued");
    assert!(store.finish(id, 1, succeeded()).wait().unwrap());
    for refused in [
        store.finish(id, 1, cancelled()).wait(),
        store.finish_queued(id, cancelled()).wait(),
        store.requeue(id, 1, second(40)).wait(),
        store.progress(id, 1, second(40), Progress::default()).wait(),
        store.start(id, second(40)).wait().map(|claim| claim.is_some()),
    ] {
        assert_eq!(refused, Ok(false), "an ended job stays as it is");
    }
    let job = store.get(id).wait().unwrap().unwrap();
    assert_eq!(job.state, JobState::Succeeded);
    assert_eq!((job.started_at, job.finished_at), (Some(second(20)), Some(second(30))));
    assert_eq!(store.result(id).wait().unwrap().as_deref(), Some(r#"{"duration":1.5}"#));

    let id = insert(store, new_job("b"));
    let error = JobError { code: "late".into(), message: "too late".into(), details: json!([1]) };
    let expired =
        Finish { error: Some(error.clone()), ..Finish::new(JobState::Expired, second(9)) };
    assert!(store.finish_queued(id, expired).wait().unwrap());
    let job = store.get(id).wait().unwrap().unwrap();
    assert_eq!((job.state, job.error, job.attempt), (JobState::Expired, Some(error), 0));
}

fn fences_results_by_claim(store: &dyn JobStore) {
    let id = insert(store, new_job("a"));
    let old = start(store, id);
    assert!(store.requeue(id, old, second(21)).wait().unwrap());
    let new = start(store, id);
    assert_ne!(old, new);
    assert!(!store.finish(id, old, succeeded()).wait().unwrap());
    assert!(!store.progress(id, old, second(22), Progress::default()).wait().unwrap());
    assert!(!store.requeue(id, old, second(22)).wait().unwrap());
    assert_eq!(store.result(id).wait().unwrap(), None);
    assert_eq!(state(store, id), JobState::Running);
    assert!(store.finish(id, new, succeeded()).wait().unwrap());
}

fn takes_an_attempt_back_when_queued_again(store: &dyn JobStore) {
    let id = insert(store, new_job("a"));
    let claim = start(store, id);
    store.requeue(id, claim, second(21)).wait().unwrap();
    let job = store.get(id).wait().unwrap().unwrap();
    assert_eq!((job.state, job.attempt, job.started_at), (JobState::Queued, 0, None));
    let claim = store.start(id, second(22)).wait().unwrap().unwrap();
    assert_eq!((claim.number, claim.attempt), (2, 1));
}

fn numbers_events_without_gaps(store: &dyn JobStore) {
    let (id, other) = (insert(store, new_job("a")), insert(store, new_job("b")));
    let claim = start(store, id);
    start(store, other);
    for iteration in 1..=3 {
        let progress = Progress { iteration, best: Some(0.1), ..<_>::default() };
        assert!(store.progress(id, claim, second(21), progress).wait().unwrap());
    }
    store.finish(id, claim, succeeded()).wait().unwrap();
    let events = store.events(id, 0, 100).wait().unwrap();
    assert!(events.iter().map(|event| event.seq).eq(1..=6));
    assert_eq!(events[0].kind, EventKind::State { state: JobState::Queued, attempt: 0 });
    assert_eq!(events[1].kind, EventKind::State { state: JobState::Running, attempt: 1 });
    let summary = Some(json!({"d": 1.5}));
    let last = EventKind::Finished { state: JobState::Succeeded, summary, error: None };
    assert_eq!((&events[5].kind, events[5].time), (&last, second(30)));
    assert_eq!(store.events(id, 2, 2).wait().unwrap(), events[2..4]);
    assert_eq!(store.events(id, u64::MAX, 2).wait().unwrap(), []);
    let latest = store.get(id).wait().unwrap().unwrap().progress.unwrap();
    assert_eq!((latest.iteration, latest.best), (3, Some(0.1)));
}

fn pages_and_filters_newest_first(store: &dyn JobStore) {
    let labelled = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
    };
    let mut ids: Vec<JobId> = (0..7)
        .map(|index| {
            let parity = if index % 2 == 0 { "even" } else { "odd" };
            let labels = labelled(&[("parity", parity), ("cell", "3")]);
            insert(store, NewJob { labels, ..new_job("a") })
        })
        .collect();
    start(store, ids[0]);
    ids.reverse();
    let page = |filter: JobFilter| -> (Vec<JobId>, Option<String>) {
        let page = store.list(filter).wait().unwrap();
        (page.jobs.iter().map(|job| job.id).collect(), page.next_page_token)
    };
    let mut seen = Vec::new();
    let mut filter = JobFilter { page_size: 3, ..<_>::default() };
    let mut sizes = Vec::new();
    loop {
        let (found, next) = page(filter.clone());
        sizes.push(found.len());
        seen.extend(found);
        // A job that comes in between shifts nothing.
        insert(store, new_job("later"));
        let Some(next) = next else { break };
        filter.page_token = Some(next);
    }
    assert_eq!((seen, sizes), (ids.clone(), vec![3, 3, 1]));
    let labels = labelled(&[("parity", "odd"), ("cell", "3")]);
    let odd = page(JobFilter { page_size: 3, labels, ..<_>::default() });
    assert_eq!(odd, (vec![ids[1], ids[3], ids[5]], None));
    let labels = labelled(&[("parity", "odd"), ("cell", "4")]);
    assert_eq!(page(JobFilter { page_size: 3, labels, ..<_>::default() }).0, []);
    let running = JobFilter { state: Some(JobState::Running), page_size: 3, ..<_>::default() };
    assert_eq!(page(running).0, [ids[6]]);
    let bad = JobFilter { page_token: Some("x".to_owned()), ..<_>::default() };
    assert_eq!(store.list(bad).wait(), Err(StoreError::PageToken("x".to_owned())));
}

fn knows_idempotency_keys(store: &dyn JobStore) {
    let id = insert(store, with_key("a", "key", 1));
    let again = |body| store.insert(JobId::new(), with_key("a", "key", body), second(11)).wait();
    let job = Box::new(store.get(id).wait().unwrap().unwrap());
    assert_eq!(again(1), Ok(Inserted::KeyUsed(KeyUse::SameBody(job.clone()))));
    assert_eq!(again(2), Ok(Inserted::KeyUsed(KeyUse::OtherBody)));
    let find = |key: &str, body| {
        let key = Idempotency { key: key.to_owned(), body_sha256: [body; 32] };
        store.find_key(key).wait().unwrap()
    };
    assert_eq!(find("key", 1), Some(KeyUse::SameBody(job)));
    assert_eq!(find("key", 2), Some(KeyUse::OtherBody));
    assert_eq!(find("other key", 1), None);
    let all = store.list(JobFilter { page_size: 9, ..<_>::default() }).wait().unwrap();
    assert_eq!(all.jobs.len(), 1);
}

fn deletes_only_ended_jobs(store: &dyn JobStore) {
    let labels = BTreeMap::from([("a".to_owned(), "b".to_owned())]);
    let (ended, queued, running) = (
        insert(store, NewJob { labels: labels.clone(), ..with_key("a", "key", 1) }),
        insert(store, new_job("b")),
        insert(store, new_job("c")),
    );
    start(store, running);
    let claim = start(store, ended);
    store.finish(ended, claim, succeeded()).wait().unwrap();
    assert_eq!(store.delete_ended_before(second(30), 10).wait(), Ok(0));
    assert_eq!(store.delete_ended_before(second(31), 0).wait(), Ok(0));
    assert_eq!(store.delete_ended_before(second(31), 10).wait(), Ok(1));
    assert_eq!(store.delete(queued).wait(), Ok(Some(JobState::Queued)));
    assert_eq!(store.delete(running).wait(), Ok(Some(JobState::Running)));
    assert_eq!(state(store, queued), JobState::Queued);
    assert_eq!(state(store, running), JobState::Running);
    assert_eq!(store.get(ended).wait(), Ok(None));
    assert_eq!(store.request(ended).wait(), Ok(None));
    assert_eq!(store.result(ended).wait(), Ok(None));
    assert_eq!(store.events(ended, 0, 9).wait(), Ok(Vec::new()));
    // The key is free again, and the same labels find the new job only.
    let id = insert(store, NewJob { labels: labels.clone(), ..with_key("a", "key", 2) });
    let found = store.list(JobFilter { labels, page_size: 9, ..<_>::default() }).wait().unwrap();
    assert_eq!(found.jobs.iter().map(|job| job.id).collect::<Vec<_>>(), [id]);
    store.finish_queued(id, Finish::new(JobState::Cancelled, second(1))).wait().unwrap();
    assert_eq!(store.delete(id).wait(), Ok(Some(JobState::Cancelled)));
    assert_eq!(store.get(id).wait(), Ok(None));
}

fn recovers_in_order_of_acceptance(store: &dyn JobStore) {
    let new = |request: &str, short| NewJob { short, priority: 7, ..new_job(request) };
    let (first, second_job) = (insert(store, new("a", false)), insert(store, new("b", true)));
    let (crashing, ended) = (insert(store, new("c", false)), insert(store, new("d", false)));
    let claim = start(store, ended);
    store.finish(ended, claim, succeeded()).wait().unwrap();
    for attempt in 1..=3 {
        start(store, crashing);
        if attempt < 3 {
            let queued = store.recover(3, second(40)).wait().unwrap();
            assert_eq!(queued.len(), 3, "one more attempt is left");
        }
    }
    let claim = start(store, first);
    let queued = store.recover(3, second(50)).wait().unwrap();
    assert!(!store.finish(first, claim, succeeded()).wait().unwrap());
    let found: Vec<_> = queued.iter().map(|job| (job.id, job.short, job.last_seq)).collect();
    assert_eq!(found, [(first, false, 3), (second_job, true, 1)]);
    assert!(queued[0].number < queued[1].number);
    assert_eq!((queued[0].priority, queued[0].created_at), (7, second(10)));
    let job = store.get(crashing).wait().unwrap().unwrap();
    let error = job.error.unwrap();
    assert_eq!((job.state, job.attempt), (JobState::Failed, 3));
    assert_eq!((error.code.as_str(), error.details), ("worker_crashed", Value::Null));
    assert_eq!(store.get(first).wait().unwrap().unwrap().attempt, 1);
    assert_eq!(state(store, ended), JobState::Succeeded);
}
