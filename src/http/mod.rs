//! The REST edge: addresses, headers and status codes. Nothing else knows them.

mod comparisons;
mod door;
mod events;
mod examples;
mod input;
mod jobs;
mod operations;
mod page;
mod problem;
mod registry;
mod results;
mod robots;
mod schemas;

use std::any::Any;

use axum::Router;
use axum::extract::Request;
use axum::response::IntoResponse;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::decompression::RequestDecompressionLayer;
use utoipa::{OpenApi, openapi};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::SwaggerUi;

pub use problem::{PROBLEM_TYPES, Problem, ProblemBody, ProblemFault, ProblemType};

use crate::service::{Service, ServiceError};

/// How the edge treats requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HttpSettings {
    /// Largest body after decompression, bytes.
    pub max_body_bytes: usize,
}

/// What handlers share.
#[derive(Clone)]
struct Edge {
    service: Service,
    settings: HttpSettings,
}

#[derive(OpenApi)]
#[openapi(
    info(
        title = "Takt",
        description = "Plans robot trajectories: as fast as the limits allow, certified over \
            continuous time, repeatable from a seed. SI units and radians throughout; vectors follow \
            the robot's joint order. Unknown fields and query parameters are refused.",
    ),
    components(schemas(ProblemBody)),
    tags(
        (name = "jobs", description = "Submit, follow and manage planning jobs"),
        (name = "results", description = "What an ended job produced; certificates"),
        (name = "robots", description = "The catalogue and your own"),
        (name = "methods", description = "What is on offer"),
        (name = "operations", description = "Health and metrics"),
    ),
)]
struct ApiDescription;

/// All addresses of the REST edge; unknown ones are answered with a problem.
pub fn routes(service: Service, settings: HttpSettings) -> Router {
    let (router, api) = api_routes().split_for_parts();
    let router = router
        .route("/", get(operations::index))
        .with_state(Edge { service, settings })
        .merge(SwaggerUi::new("/docs").url("/openapi.json", api))
        .fallback(unknown_address);
    guarded(router)
}

/// What every request passes, from the inside out.
fn guarded(router: Router) -> Router {
    router
        .layer(RequestDecompressionLayer::new())
        .layer(CatchPanicLayer::custom(|panic: Box<dyn Any + Send>| {
            Problem::from(ServiceError::panic(panic.as_ref())).into_response()
        }))
        .layer(axum::middleware::from_fn(door::pass))
        .layer(CompressionLayer::new())
}

/// The description of the REST edge as OpenAPI 3.1.
pub fn api_description() -> openapi::OpenApi {
    api_routes().into_openapi()
}

fn api_routes() -> OpenApiRouter<Edge> {
    let mut router = described_routes();
    schemas::open_composed(router.get_openapi_mut());
    router
}

fn described_routes() -> OpenApiRouter<Edge> {
    OpenApiRouter::with_openapi(ApiDescription::openapi())
        .routes(routes!(jobs::create, jobs::list))
        .routes(routes!(jobs::get, jobs::delete))
        .routes(routes!(jobs::request))
        .routes(routes!(jobs::cancel))
        .routes(routes!(events::watch))
        .routes(routes!(results::result))
        .routes(routes!(results::metrics))
        .routes(routes!(results::certificate))
        .routes(routes!(results::trajectory))
        .routes(routes!(results::convergence))
        .routes(routes!(results::plot))
        .routes(routes!(results::timeline))
        .routes(routes!(page::page))
        .routes(routes!(results::pareto))
        .routes(routes!(registry::verify))
        .routes(routes!(robots::list))
        .routes(routes!(robots::get, robots::put, robots::delete))
        .routes(routes!(robots::forward_kinematics))
        .routes(routes!(robots::inverse_kinematics))
        .routes(routes!(registry::optimizers))
        .routes(routes!(registry::planners))
        .routes(routes!(registry::interpolations))
        .routes(routes!(registry::scenarios))
        .routes(routes!(registry::scenario))
        .routes(routes!(registry::scenario_request))
        .routes(routes!(operations::healthz))
        .routes(routes!(operations::readyz))
        .routes(routes!(operations::metrics))
        .routes(routes!(operations::problem))
}

async fn unknown_address(request: Request) -> Problem {
    Problem::not_found(format!("there is nothing at {}", request.uri().path()))
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use tower::ServiceExt;

    use super::*;

    #[tokio::test]
    async fn a_panic_is_answered_with_a_problem_that_hides_its_message() {
        async fn panics() {
            panic!("the secret cause");
        }
        let router = guarded(Router::new().route("/", get(panics)));
        let request = Request::builder().uri("/").header("x-request-id", "7").body(Body::empty());
        let response = router.oneshot(request.unwrap()).await.unwrap();
        assert_eq!(response.status(), 500);
        let body = axum::body::to_bytes(response.into_body(), usize::MAX).await.unwrap();
        let problem: ProblemBody = serde_json::from_slice(&body).unwrap();
        assert_eq!((problem.code.as_str(), problem.request_id.as_str()), ("internal", "7"));
        assert!(!problem.detail.contains("secret"));
    }
}
