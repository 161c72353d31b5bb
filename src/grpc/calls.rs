//! What every call passes on its way in and out.

use std::any::Any;

use axum::body::Body;
use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use http::{HeaderName, HeaderValue};
use tonic::Status;
use tracing::Instrument;

use crate::service::{ServiceError, request_id};

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Names the call and follows it in the log. The id is the client's if it sent
/// a sensible one, and comes back as metadata.
pub(super) async fn follow(request: Request, next: Next) -> Response {
    let given = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let id = request_id(given);
    let span = tracing::info_span!("call", request_id = %id, path = request.uri().path());
    async {
        let mut response = next.run(request).await;
        // Absent unless the call failed at once.
        let refused = response.headers().get(Status::GRPC_STATUS);
        tracing::debug!(?refused, "answered");
        if let Ok(value) = HeaderValue::from_str(&id) {
            response.headers_mut().insert(REQUEST_ID, value);
        }
        response
    }
    .instrument(span)
    .await
}

/// A panic ends its call and nothing else.
pub(super) fn panicked(panic: Box<dyn Any + Send>) -> Response {
    into_response(ServiceError::panic(panic.as_ref()).into())
}

/// Middleware for the merged router: a gRPC call that no route takes is
/// answered as gRPC asks (`UNIMPLEMENTED`) and not with HTTP's 404.
pub async fn answer_unknown_methods(request: Request, next: Next) -> Response {
    if request.extensions().get::<MatchedPath>().is_some() {
        return next.run(request).await;
    }
    let content_type = request.headers().get(CONTENT_TYPE).cloned();
    let grpc = |value: &HeaderValue| value.as_bytes().starts_with(b"application/grpc");
    let Some(content_type) = content_type.filter(grpc) else {
        return next.run(request).await;
    };
    let path = request.uri().path();
    let mut response = into_response(Status::unimplemented(format!("there is no method {path}")));
    // A status in the headers alone is lawful in gRPC-web too, under its own type.
    response.headers_mut().insert(CONTENT_TYPE, content_type);
    response
}

fn into_response(status: Status) -> Response {
    status.into_http::<Body>().into_response()
}
