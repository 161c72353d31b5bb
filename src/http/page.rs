//! Results as pages.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::header;

use super::Edge;
use super::input::{JobPath, Parameters};
use super::problem::{Problem, Problems};
use super::results::from_result;
use crate::picture;

/// Show a family, comparison or benchmark as a page
///
/// One HTML page with everything inside, for screen and paper: of a family the
/// worst case, durations as a picture and a table; of a comparison which method to use, a
/// table of methods by problems, curves with quartile bands.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/page", tag = "results",
    params(("id" = String, Path, format = "uuid", description = "The job's id")),
    responses((status = 200, description = "The page", body = String, content_type = "text/html"), Problems),
)]
pub(super) async fn page(
    State(edge): State<Edge>,
    JobPath(id): JobPath,
    query: Parameters,
) -> Result<Response, Problem> {
    query.finish(())?;
    from_result(&edge, id, move |result| {
        let page = picture::page::of(result).ok_or_else(|| {
            let detail =
                "only a family, comparison or benchmark has a page; see /plot.svg for a motion";
            Problem::not_found(detail)
        })?;
        // Nothing on the page needs a script or anything from elsewhere.
        let policy = "default-src 'none'; style-src 'unsafe-inline'";
        let headers = [
            (header::CONTENT_TYPE, "text/html; charset=utf-8"),
            (header::CONTENT_SECURITY_POLICY, policy),
        ];
        Ok((headers, page).into_response())
    })
    .await
}
