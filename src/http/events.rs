//! A job's events as server-sent events.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::{StreamExt, future, stream};
use http::{HeaderMap, HeaderName, StatusCode};

use super::Edge;
use super::input::{JobPath, Parameters};
use super::problem::{Problem, ProblemFault, Problems};
use crate::job::{EventKind, JobEvent};

const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");

/// Follow a job
///
/// Server-sent events `state`, `progress` and `finished`, each with its number
/// as id, from the first on. The stream ends after `finished`. A client that
/// was cut off resumes with `Last-Event-ID`; one that has seen everything is
/// answered 204, which tells an `EventSource` to stop.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = "jobs",
    params(
        ("id" = String, Path, format = "uuid", description = "The job's id"),
        ("after_seq" = Option<u64>, Query, description = "Only events that follow this number"),
        ("Last-Event-ID" = Option<u64>, Header, description = "The same, as `EventSource` sends it; \
            wins over `after_seq`"),
    ),
    responses(
        (status = 200, description = "The events", body = JobEvent, content_type = "text/event-stream"),
        (status = 204, description = "The job has ended and no event follows"),
        Problems,
    ),
)]
pub(super) async fn watch(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    mut query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let after_seq = query.value("after_seq");
    let after_seq = query.finish(after_seq)?;
    let seen = last_event_id(&headers)?.or(after_seq).unwrap_or(0);
    let ended = edge.service.job(id).await?.state.is_ended();
    let mut events = edge.service.watch(id, seen).await?.boxed();
    let mut first = None;
    if ended {
        match events.next().await {
            Some(event) => first = Some(event),
            None => return Ok(StatusCode::NO_CONTENT.into_response()),
        }
    }
    // An error means that the server drains or its store failed: the stream
    // ends, and the client may resume it elsewhere.
    let events = stream::iter(first).chain(events);
    let events = events.take_while(|event| future::ready(event.is_ok()));
    let events = events.filter_map(|event| future::ready(event.ok()));
    let events = events.map(|event| server_sent(&event));
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    Ok(Sse::new(events).keep_alive(keep_alive).into_response())
}

fn last_event_id(headers: &HeaderMap) -> Result<Option<u64>, Problem> {
    let Some(value) = headers.get(LAST_EVENT_ID) else { return Ok(None) };
    let number = value.to_str().ok().and_then(|text| text.parse().ok());
    number.map(Some).ok_or_else(|| {
        let fault = ProblemFault::parameter("Last-Event-ID", "expected an event's number");
        Problem::parameters(vec![fault])
    })
}

fn server_sent(event: &Arc<JobEvent>) -> Result<Event, axum::Error> {
    let name = match event.kind {
        EventKind::State { .. } => "state",
        EventKind::Progress(_) => "progress",
        EventKind::Finished { .. } => "finished",
    };
    Event::default().id(event.seq.to_string()).event(name).json_data(event)
}
