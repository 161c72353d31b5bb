//! What every request passes on its way in and out: an id, a span in the log,
//! and problems written out.

use axum::extract::Request;
use axum::middleware::Next;
use axum::response::Response;
use http::{HeaderName, HeaderValue};
use tracing::Instrument;

use super::problem::Problem;
use crate::service::request_id;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Names the request, follows it in the log and writes out its problem, if any.
pub(super) async fn pass(request: Request, next: Next) -> Response {
    let given = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let id = request_id(given);
    let (method, path) = (request.method().clone(), request.uri().path().to_owned());
    let span = tracing::info_span!("request", request_id = %id, %method, path);
    async {
        let mut response = next.run(request).await;
        let problem = response.extensions_mut().remove::<Problem>().or_else(|| {
            let status = response.status();
            let bare = status.is_client_error() || status.is_server_error();
            bare.then(|| Problem::of_status(status, &method, &path))
        });
        if let Some(problem) = problem {
            problem.log();
            problem.write(&mut response, &id);
        }
        tracing::debug!(status = response.status().as_u16(), "answered");
        if let Ok(value) = HeaderValue::from_str(&id) {
            response.headers_mut().insert(REQUEST_ID, value);
        }
        response
    }
    .instrument(span)
    .await
}
