//! For operators and first visitors: health, metrics, problem pages, links.

use axum::Json;
use axum::extract::State;
use axum::response::{Html, IntoResponse, Response};
use http::header;
use serde::Serialize;
use utoipa::ToSchema;

use super::Edge;
use super::input::NamePath;
use super::problem::{PROBLEM_TYPES, Problem, Problems};

/// That all is well.
#[derive(Serialize, ToSchema)]
pub(super) struct Health {
    /// `ok` or `ready`.
    status: &'static str,
    /// Takt's version.
    version: &'static str,
}

impl Health {
    fn new(status: &'static str) -> Json<Self> {
        Json(Self { status, version: env!("CARGO_PKG_VERSION") })
    }
}

/// Tell whether the process lives
///
/// A problem means that only a new start helps: the store has failed.
#[utoipa::path(
    get, path = "/healthz", tag = "operations",
    responses((status = 200, description = "It lives", body = Health), Problems),
)]
pub(super) async fn healthz(State(edge): State<Edge>) -> Result<Json<Health>, Problem> {
    edge.service.liveness()?;
    Ok(Health::new("ok"))
}

/// Tell whether jobs can be accepted and stored
#[utoipa::path(
    get, path = "/readyz", tag = "operations",
    responses((status = 200, description = "They can", body = Health), Problems),
)]
pub(super) async fn readyz(State(edge): State<Edge>) -> Result<Json<Health>, Problem> {
    edge.service.readiness().await?;
    Ok(Health::new("ready"))
}

/// Get all metrics in Prometheus' text format
#[utoipa::path(
    get, path = "/metrics", tag = "operations",
    responses((status = 200, description = "The metrics", body = String, content_type = "text/plain"), Problems),
)]
pub(super) async fn metrics(State(edge): State<Edge>) -> Result<Response, Problem> {
    let text = edge.service.metrics_text()?;
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response())
}

/// Explain a kind of problem
#[utoipa::path(
    get, path = "/problems/{code}", tag = "operations",
    params(("code" = String, Path, description = "The problem's code, with dashes")),
    responses((status = 200, description = "The page", body = String, content_type = "text/html"), Problems),
)]
pub(super) async fn problem(NamePath(code): NamePath) -> Result<Html<String>, Problem> {
    let kind = PROBLEM_TYPES.iter().find(|kind| kind.code.replace('_', "-") == code);
    let kind = kind.ok_or_else(|| Problem::not_found(format!("there is no problem `{code}`")))?;
    Ok(page(
        kind.title,
        &format!(
            "<p>Code <code>{}</code>, HTTP status {}.</p><p>{}</p>",
            kind.code, kind.status, kind.help
        ),
    ))
}

/// Links for whoever looks in with a browser.
pub(super) async fn index() -> Html<String> {
    const LINKS: [(&str, &str); 10] = [
        ("/docs", "try the interface in the browser"),
        ("/openapi.json", "its description for programs"),
        ("/v1/scenarios", "requests that are ready to be sent"),
        ("/v1/jobs", "jobs, newest first"),
        ("/v1/robots", "robots, built in and registered"),
        ("/v1/interpolations", "how curves run through waypoints"),
        ("/v1/optimizers", "how durations are searched"),
        ("/v1/planners", "how ways around obstacles are found"),
        ("/readyz", "whether jobs are accepted"),
        ("/metrics", "figures for Prometheus"),
    ];
    let links: String = LINKS
        .iter()
        .map(|(path, what)| format!("<li><a href=\"{path}\">{path}</a> {what}</li>"))
        .collect();
    let version = env!("CARGO_PKG_VERSION");
    let text = format!(
        "<p>Plans robot trajectories: as fast as the limits allow, certified over continuous time. \
         Version {version}.</p><ul>{links}</ul>"
    );
    page("Takt", &text)
}

fn page(title: &str, text: &str) -> Html<String> {
    Html(format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>{title}</title>\
         <style>body{{font:16px/1.5 sans-serif;max-width:40em;margin:3em auto;padding:0 1em}}</style>\
         <h1>{title}</h1>{text}</html>\n"
    ))
}
