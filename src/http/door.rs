//! What every request passes on its way in and out: an id, a span in the log,
//! and problems written out.

use axum::extract::Request;
use axum::middleware::Next;
use axum::response::Response;
use http::{HeaderName, HeaderValue};
use tracing::Instrument;
use uuid::Uuid;

use super::problem::Problem;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Names the request, follows it in the log and writes out its problem, if any.
pub(super) async fn pass(request: Request, next: Next) -> Response {
    let id = request_id(&request);
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

/// The client's id if it is a sensible one, else a new one.
fn request_id(request: &Request) -> String {
    const LONGEST: usize = 128;
    let given = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let sensible = |id: &&str| {
        (1..=LONGEST).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_graphic())
    };
    given.filter(sensible).map_or_else(|| Uuid::now_v7().to_string(), str::to_owned)
}
