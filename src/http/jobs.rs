//! Jobs: submit, look up, list, cancel, delete.

use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};

use super::Edge;
use super::examples;
use super::input::{JobPath, JsonBody, NoParameters, Parameters};
use super::problem::{Problem, ProblemFault, Problems};
use crate::job::{Job, JobFilter, JobPage, JobState, Submitted};
use crate::plan::PlanResult;
use crate::service::{JobRequest, Service};

const PREFER: HeaderName = HeaderName::from_static("prefer");
const PREFERENCE_APPLIED: HeaderName = HeaderName::from_static("preference-applied");
const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");
const IDEMPOTENT_REPLAYED: HeaderName = HeaderName::from_static("idempotent-replayed");

/// Longest wait that a client may prefer, s.
const LONGEST_WAIT_S: u64 = 60;

/// Submit a job
///
/// Answers once the job is stored for good. With `Prefer: wait=N` the answer
/// waits up to N seconds (at most 60): 200 with the result if the job succeeds
/// in time, else 202 with the job as it is then.
#[utoipa::path(
    post, path = "/v1/jobs", tag = "jobs",
    request_body(content = JobRequest, examples(
        ("minimal" = (summary = "The least that makes a job", value = json!(examples::job()))),
        ("published" = (
            summary = "A published method, own limits, labels",
            value = json!(examples::published_job())
        )),
        ("program" = (summary = "Several motions in order", value = json!(examples::program_job()))),
        ("family" = (summary = "One motion with less and less acceleration", value = json!(examples::family_job()))),
        ("comparison" = (summary = "Methods compared on a motion", value = json!(examples::comparison_job()))),
        ("path" = (summary = "A way around obstacles", value = json!(examples::path_job()))),
        ("motion" = (summary = "A robot around obstacles", value = json!(examples::motion_job()))),
        ("benchmark" = (summary = "Methods compared on functions", value = json!(examples::benchmark_job()))),
    )),
    params(
        ("Prefer" = Option<String>, Header, description = "`wait=5` waits up to 5 s for the result"),
        ("Idempotency-Key" = Option<String>, Header,
            description = "Repeating a request under its key answers with the first job"),
    ),
    responses(
        (status = 202, description = "Accepted", body = Job,
            headers(("Location" = String, description = "The job's address"))),
        (status = 200, description = "Succeeded while waiting", body = PlanResult),
        Problems,
    ),
)]
pub(super) async fn create(
    State(edge): State<Edge>,
    query: Result<NoParameters, Problem>,
    headers: HeaderMap,
    body: Result<JsonBody, Problem>,
) -> Result<Response, Problem> {
    let submitted = submit(&edge.service, query, &headers, body).await;
    let submitted =
        submitted.inspect_err(|problem| edge.service.count_rejection(problem.code()))?;
    let id = submitted.job.id;
    tracing::info!(job = %id, existing = submitted.existing, "accepted");
    let wait = preferred_wait(&headers);
    let job = match wait {
        Some(wait) => edge.service.wait_ended(id, wait).await?,
        None => submitted.job,
    };
    let mut response = if wait.is_some() && job.state == JobState::Succeeded {
        json_text(edge.service.result_text(id).await?)
    } else {
        (StatusCode::ACCEPTED, Json(job)).into_response()
    };
    let answer = response.headers_mut();
    if let Ok(location) = HeaderValue::from_str(&format!("/v1/jobs/{id}")) {
        answer.insert(header::LOCATION, location);
    }
    if let Some(wait) = wait {
        let applied = HeaderValue::from_str(&format!("wait={}", wait.as_secs()));
        answer.extend(applied.ok().map(|value| (PREFERENCE_APPLIED, value)));
    }
    if submitted.existing {
        answer.insert(IDEMPOTENT_REPLAYED, HeaderValue::from_static("true"));
    }
    Ok(response)
}

/// The part of [`create`] that may reject the job.
async fn submit(
    service: &Service,
    query: Result<NoParameters, Problem>,
    headers: &HeaderMap,
    body: Result<JsonBody, Problem>,
) -> Result<Submitted, Problem> {
    query?;
    let key = idempotency_key(headers)?;
    let request = body?.parse(JobRequest::parse).await?;
    Ok(service.create_job(request, key).await?)
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get(IDEMPOTENCY_KEY) else { return Ok(None) };
    match value.to_str() {
        Ok(key) if !key.is_empty() => Ok(Some(key.to_owned())),
        _ => {
            let fault =
                ProblemFault::parameter("Idempotency-Key", "expected 1 to 255 ASCII characters");
            Err(Problem::parameters(vec![fault]))
        }
    }
}

/// The wait asked for in a `Prefer` header (RFC 7240); what is not understood
/// is ignored, as the RFC asks.
fn preferred_wait(headers: &HeaderMap) -> Option<Duration> {
    let lines = headers.get_all(PREFER).iter().filter_map(|value| value.to_str().ok());
    let mut preferences = lines.flat_map(|line| line.split([',', ';']));
    let seconds = preferences.find_map(|preference| {
        let (name, value) = preference.split_once('=')?;
        if !name.trim().eq_ignore_ascii_case("wait") {
            return None;
        }
        value.trim().trim_matches('"').parse::<u64>().ok()
    })?;
    Some(Duration::from_secs(seconds.min(LONGEST_WAIT_S)))
}

/// JSON text as it was stored.
pub(super) fn json_text(text: String) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

/// List jobs, newest first
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs",
    params(
        ("state" = Option<JobState>, Query, description = "Only jobs in this state"),
        ("label.KEY" = Option<String>, Query, description = "Only jobs whose label KEY has this value"),
        ("page_size" = Option<usize>, Query, minimum = 1, maximum = 500,
            description = "1 to 500, default 50"),
        ("page_token" = Option<String>, Query, description = "`next_page_token` of the page before"),
    ),
    responses((status = 200, description = "A page of jobs", body = JobPage), Problems),
)]
pub(super) async fn list(
    State(edge): State<Edge>,
    mut query: Parameters,
) -> Result<Json<JobPage>, Problem> {
    const LARGEST_PAGE: usize = 500;
    let page_size = query.value("page_size").unwrap_or(50);
    if !(1..=LARGEST_PAGE).contains(&page_size) {
        query.fault("page_size", format!("{page_size} is not within 1 to {LARGEST_PAGE}"));
    }
    let filter = JobFilter {
        state: query.value("state"),
        labels: query.prefixed("label."),
        page_size,
        page_token: query.text("page_token"),
    };
    let filter = query.finish(filter)?;
    Ok(Json(edge.service.list_jobs(filter).await?))
}

/// Look a job up
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = "jobs",
    params(("id" = String, Path, format = "uuid", description = "The job's id")),
    responses((status = 200, description = "The job", body = Job), Problems),
)]
pub(super) async fn get(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    _: NoParameters,
) -> Result<Json<Job>, Problem> {
    Ok(Json(edge.service.job(id).await?))
}

/// Get a job's plan request as it was accepted
///
/// The robot is in it in full, so it plans the same again whatever became of
/// the robot's name.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/request", tag = "jobs",
    params(("id" = String, Path, format = "uuid", description = "The job's id")),
    responses((status = 200, description = "The request", body = crate::plan::PlanRequest), Problems),
)]
pub(super) async fn request(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    _: NoParameters,
) -> Result<Response, Problem> {
    Ok(json_text(edge.service.request_text(id).await?))
}

/// Cancel a job
///
/// A waiting job ends at once, a running one within moments; the answer may
/// still show it running.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = "jobs",
    params(("id" = String, Path, format = "uuid", description = "The job's id")),
    responses((status = 200, description = "The job", body = Job), Problems),
)]
pub(super) async fn cancel(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    _: NoParameters,
) -> Result<Json<Job>, Problem> {
    Ok(Json(edge.service.cancel_job(id).await?))
}

/// Delete an ended job with its result and events
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = "jobs",
    params(("id" = String, Path, format = "uuid", description = "The job's id")),
    responses((status = 204, description = "Deleted"), Problems),
)]
pub(super) async fn delete(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    _: NoParameters,
) -> Result<StatusCode, Problem> {
    edge.service.delete_job(id).await?;
    Ok(StatusCode::NO_CONTENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(prefer: &'static str) -> Option<u64> {
        let headers = HeaderMap::from_iter([(PREFER, HeaderValue::from_static(prefer))]);
        preferred_wait(&headers).map(|wait| wait.as_secs())
    }

    #[test]
    fn preferences_are_read_leniently() {
        assert_eq!(wait("wait=5"), Some(5));
        assert_eq!(wait("respond-async, Wait = 7"), Some(7));
        assert_eq!(wait("wait=1000"), Some(60));
        assert_eq!(wait("wait=soon"), None);
        assert_eq!(wait("return=minimal"), None);
    }
}
