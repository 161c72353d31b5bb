//! Errors as `application/problem+json` (RFC 9457).
//!
//! Handlers return a [`Problem`]; it travels in the response's extensions and
//! is written out once, at the door, where the request id is known. What the
//! router itself refuses is turned into a problem there too.

use axum::body::Body;
use axum::response::{IntoResponse, Response};
use http::{HeaderValue, StatusCode, header};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::fault::{Fault, Faults};
use crate::service::{ErrorCode, ServiceError};

/// A kind of problem, with a page of its own under `/problems/`.
#[derive(Debug)]
pub struct ProblemType {
    /// Stable name.
    pub code: &'static str,
    /// HTTP status.
    pub status: StatusCode,
    /// The same in a few words.
    pub title: &'static str,
    /// What a client can do about it.
    pub help: &'static str,
}

impl ProblemType {
    /// Where its page is: `/problems/` and the code with dashes.
    pub fn path(&self) -> String {
        format!("/problems/{}", self.code.replace('_', "-"))
    }
}

macro_rules! problem_types {
    ($($name:ident: $code:literal, $status:ident, $title:literal, $help:literal;)*) => {
        $(static $name: ProblemType = ProblemType {
            code: $code, status: StatusCode::$status, title: $title, help: $help,
        };)*
        /// Every kind of problem that answers can name.
        pub static PROBLEM_TYPES: &[&ProblemType] = &[$(&$name),*];
    };
}

problem_types! {
    UNREADABLE: "unreadable", BAD_REQUEST, "The request cannot be read",
        "The body has to be one JSON document; `detail` names line and column. JSON knows no NaN \
         and no Infinity, and numbers have to fit a 64-bit float.";
    INVALID: "invalid", UNPROCESSABLE_ENTITY, "The request is not valid",
        "`errors` lists everything that is wrong, each with a JSON pointer into the body or the \
         name of the query parameter. The schemas are in /openapi.json and /docs.";
    NOT_FOUND: "not_found", NOT_FOUND, "There is no such thing",
        "The address, job, robot or leg does not exist. /docs lists all addresses, GET /v1/jobs all \
         jobs, GET /v1/robots all robots.";
    CONFLICT: "conflict", CONFLICT, "The present state forbids it",
        "A job that has ended cannot be cancelled, one that has not cannot be deleted, and the \
         catalogue's robots stay as they are.";
    NOT_ENDED: "not_ended", CONFLICT, "The job has not ended",
        "Follow the job under /v1/jobs/{id}/events, or ask again later.";
    NO_RESULT: "no_result", CONFLICT, "The job ended without this result",
        "`detail` has the job's error. With ?partial=true, /v1/jobs/{id}/result serves what there \
         is of the plan, if anything.";
    IDEMPOTENCY_MISMATCH: "idempotency_mismatch", UNPROCESSABLE_ENTITY,
        "The idempotency key stands for another request",
        "Use a new Idempotency-Key for every request that is to make a new job.";
    TOO_LARGE: "too_large", PAYLOAD_TOO_LARGE, "The body is too large",
        "The server's `max_body_bytes` limits a body after decompression.";
    QUEUE_FULL: "queue_full", TOO_MANY_REQUESTS, "The queue is full",
        "Nothing was accepted. Try again after the seconds in Retry-After.";
    DRAINING: "draining", SERVICE_UNAVAILABLE, "The server is about to stop",
        "Nothing was accepted. Try again after the seconds in Retry-After.";
    UNAVAILABLE: "unavailable", SERVICE_UNAVAILABLE, "The server cannot store anything",
        "The server has to be started again; its log has the cause.";
    INTERNAL: "internal", INTERNAL_SERVER_ERROR, "The server made a mistake",
        "Please report it with the `request_id`, under which the server's log has the cause.";
    METHOD_NOT_ALLOWED: "method_not_allowed", METHOD_NOT_ALLOWED, "The method is not allowed here",
        "The Allow header names the methods that are.";
    UNSUPPORTED_MEDIA_TYPE: "unsupported_media_type", UNSUPPORTED_MEDIA_TYPE,
        "The body's type is not supported",
        "Send `Content-Type: application/json`, plain or with `Content-Encoding: gzip`.";
}

fn type_of(code: ErrorCode) -> &'static ProblemType {
    match code {
        ErrorCode::Unreadable => &UNREADABLE,
        ErrorCode::Invalid => &INVALID,
        ErrorCode::NotFound => &NOT_FOUND,
        ErrorCode::Conflict => &CONFLICT,
        ErrorCode::NotEnded => &NOT_ENDED,
        ErrorCode::NoResult => &NO_RESULT,
        ErrorCode::IdempotencyMismatch => &IDEMPOTENCY_MISMATCH,
        ErrorCode::TooLarge => &TOO_LARGE,
        ErrorCode::QueueFull => &QUEUE_FULL,
        ErrorCode::Draining => &DRAINING,
        ErrorCode::Unavailable => &UNAVAILABLE,
        ErrorCode::Internal => &INTERNAL,
    }
}

/// The body of an error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ProblemBody {
    /// The problem's page: `/problems/` and the code with dashes.
    #[serde(rename = "type")]
    #[schema(example = "/problems/not-found")]
    pub problem_type: String,
    /// The kind of problem in a few words.
    pub title: String,
    /// The HTTP status again.
    pub status: u16,
    /// What happened this time.
    pub detail: String,
    /// The kind of problem as a stable name.
    #[schema(example = "not_found")]
    pub code: String,
    /// Everything that is wrong with the request.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<ProblemFault>,
    /// Under this id the server's log tells of the request.
    pub request_id: String,
}

/// One thing that is wrong with a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct ProblemFault {
    /// Where in the body, as a JSON pointer (RFC 6901).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// Which query parameter or header.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter: Option<String>,
    /// What is wrong, naming value and limit.
    pub detail: String,
}

impl ProblemFault {
    /// A fault of a query parameter or header.
    pub(super) fn parameter(name: &str, detail: impl Into<String>) -> Self {
        Self { pointer: None, parameter: Some(name.to_owned()), detail: detail.into() }
    }
}

impl From<Fault> for ProblemFault {
    fn from(Fault { pointer, detail }: Fault) -> Self {
        Self { pointer: Some(pointer), parameter: None, detail }
    }
}

/// An error on its way to the client.
#[derive(Clone, Debug)]
pub struct Problem {
    kind: &'static ProblemType,
    detail: String,
    errors: Vec<ProblemFault>,
}

impl Problem {
    fn new(kind: &'static ProblemType, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), errors: Vec::new() }
    }

    /// The kind of problem as a stable name.
    pub(super) fn code(&self) -> &'static str {
        self.kind.code
    }

    /// 422 for query parameters or headers.
    pub(super) fn parameters(errors: Vec<ProblemFault>) -> Self {
        Self { kind: &INVALID, detail: summary(&errors), errors }
    }

    /// 404.
    pub(super) fn not_found(detail: impl Into<String>) -> Self {
        Self::new(&NOT_FOUND, detail)
    }

    /// 400.
    pub(super) fn unreadable(detail: impl Into<String>) -> Self {
        Self::new(&UNREADABLE, detail)
    }

    /// 413.
    pub(super) fn too_large(limit: usize) -> Self {
        Self::new(&TOO_LARGE, format!("the body has more than {limit} bytes"))
    }

    /// 415.
    pub(super) fn unsupported_media_type(detail: impl Into<String>) -> Self {
        Self::new(&UNSUPPORTED_MEDIA_TYPE, detail)
    }

    /// What a bare error status of the router stands for.
    pub(super) fn of_status(status: StatusCode, method: &http::Method, path: &str) -> Self {
        match status {
            StatusCode::NOT_FOUND => Self::not_found(format!("there is nothing at {path}")),
            StatusCode::METHOD_NOT_ALLOWED => {
                Self::new(&METHOD_NOT_ALLOWED, format!("{path} does not take {method}"))
            }
            StatusCode::UNSUPPORTED_MEDIA_TYPE => Self::unsupported_media_type(
                "the content encoding is not supported; send the body plain or as gzip",
            ),
            StatusCode::PAYLOAD_TOO_LARGE => Self::new(&TOO_LARGE, "the body is too large"),
            status if status.is_client_error() => {
                Self::unreadable(status.canonical_reason().unwrap_or("the request cannot be read"))
            }
            status => ServiceError::internal(format!("answered with {status}")).into(),
        }
    }

    pub(super) fn log(&self) {
        let Self { kind, detail, errors } = self;
        let (code, status) = (kind.code, kind.status.as_u16());
        tracing::info!(status, code, detail, faults = errors.len(), "refused");
    }

    /// Writes the problem into `response`, keeping its headers.
    pub(super) fn write(self, response: &mut Response, request_id: &str) {
        let Self { kind, detail, errors } = self;
        let body = ProblemBody {
            problem_type: kind.path(),
            title: kind.title.to_owned(),
            status: kind.status.as_u16(),
            detail,
            code: kind.code.to_owned(),
            errors,
            request_id: request_id.to_owned(),
        };
        *response.status_mut() = kind.status;
        let headers = response.headers_mut();
        headers.remove(header::CONTENT_LENGTH);
        let content_type = HeaderValue::from_static("application/problem+json");
        headers.insert(header::CONTENT_TYPE, content_type);
        if let Some(seconds) = retry_after(kind) {
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static(seconds));
        }
        *response.body_mut() = Body::from(serde_json::to_vec(&body).unwrap_or_default());
    }
}

/// A queue moves within a second; a server needs a few to be replaced.
fn retry_after(kind: &ProblemType) -> Option<&'static str> {
    match kind.status {
        StatusCode::TOO_MANY_REQUESTS => Some("1"),
        StatusCode::SERVICE_UNAVAILABLE => Some("5"),
        _ => None,
    }
}

/// The first fault, and how many more there are.
fn summary(errors: &[ProblemFault]) -> String {
    let Some(first) = errors.first() else { return String::new() };
    let place = first.pointer.as_deref().or(first.parameter.as_deref()).unwrap_or_default();
    let first = match place {
        "" => first.detail.clone(),
        place => format!("{place}: {}", first.detail),
    };
    match errors.len() {
        1 => first,
        count => format!("{first}; and {} more, see `errors`", count - 1),
    }
}

impl From<ServiceError> for Problem {
    fn from(error: ServiceError) -> Self {
        let errors: Vec<_> = error.faults.into_iter().map(ProblemFault::from).collect();
        let detail = if errors.is_empty() { error.message } else { summary(&errors) };
        Self { kind: type_of(error.code), detail, errors }
    }
}

impl From<Faults> for Problem {
    fn from(faults: Faults) -> Self {
        ServiceError::from(faults).into()
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = self.kind.status.into_response();
        response.extensions_mut().insert(self);
        response
    }
}

/// The problem answers of every operation, for the API description.
pub(super) struct Problems;

impl utoipa::IntoResponses for Problems {
    fn responses() -> std::collections::BTreeMap<
        String,
        utoipa::openapi::RefOr<utoipa::openapi::response::Response>,
    > {
        let content = utoipa::openapi::ContentBuilder::new()
            .schema(Some(utoipa::openapi::Ref::from_schema_name("ProblemBody")))
            .build();
        let response = utoipa::openapi::ResponseBuilder::new()
            .description("What is wrong; each `type` has a page.")
            .content("application/problem+json", content)
            .build();
        [("default".to_owned(), response.into())].into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_code_has_a_problem_type_of_its_name() {
        for code in ErrorCode::ALL {
            assert_eq!(type_of(code).code, code.as_str());
            assert!(PROBLEM_TYPES.iter().any(|kind| kind.code == code.as_str()));
        }
    }

    #[test]
    fn the_detail_names_the_first_fault_and_counts_the_rest() {
        let mut faults = Faults::default();
        faults.add("/seed", "too small");
        assert_eq!(Problem::from(faults.clone()).detail, "/seed: too small");
        faults.add("", "too big");
        assert_eq!(Problem::from(faults).detail, "/seed: too small; and 1 more, see `errors`");
    }
}
