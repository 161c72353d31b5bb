//! The gRPC edge: protobuf messages to use cases and back.
//!
//! `proto/takt/v1` is written by hand beside the domain types; `convert` has
//! both directions of every message, and a test compares the field names.

mod chunks;
pub mod convert;
mod health;
mod planning;
pub mod proto;
mod robots;
mod status;

use axum::Router;
use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use tonic::Status;
use tonic::codec::CompressionEncoding::Gzip;
use tonic::service::Routes;
use tonic_health::pb::health_server::HealthServer;
use tonic_reflection::server::{Builder, Error as ReflectionError};
use tonic_web::GrpcWebLayer;

use crate::service::Service;
use health::Readiness;
use planning::Planning;
use robots::Robots;

pub use chunks::join;
pub use status::ERROR_DOMAIN;

type PlanningServer = proto::planning_service_server::PlanningServiceServer<Planning>;
type RobotsServer = proto::robot_service_server::RobotServiceServer<Robots>;

/// The gRPC services, to be merged with the other edge's routes: planning,
/// robots, health and reflection, for gRPC and gRPC-web.
///
/// Messages sent to it may have up to `max_message_bytes`. The routes have no
/// fallback of their own; see [`answer_unknown_methods`].
///
/// # Errors
///
/// If the descriptors that reflection serves cannot be read.
pub fn routes(service: Service, max_message_bytes: usize) -> Result<Router, ReflectionError> {
    let planning = PlanningServer::new(Planning(service.clone()))
        .max_decoding_message_size(max_message_bytes)
        .accept_compressed(Gzip)
        .send_compressed(Gzip);
    let robots = RobotsServer::new(Robots(service.clone()))
        .max_decoding_message_size(max_message_bytes)
        .accept_compressed(Gzip)
        .send_compressed(Gzip);
    let routes = Routes::new(planning)
        .add_service(robots)
        .add_service(HealthServer::new(Readiness(service)))
        .add_service(reflection().build_v1()?)
        .add_service(reflection().build_v1alpha()?);
    // tonic's own fallback would take every path that REST does not know.
    Ok(routes.into_axum_router().reset_fallback().route_layer(GrpcWebLayer::new()))
}

fn reflection() -> Builder<'static> {
    Builder::configure()
        .register_encoded_file_descriptor_set(proto::FILE_DESCRIPTOR_SET)
        .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
        // The details of errors, which generic clients then can show.
        .register_encoded_file_descriptor_set(tonic_types::pb::FILE_DESCRIPTOR_SET)
}

/// Middleware for the merged router: a gRPC call that no route takes is
/// answered as gRPC asks (`UNIMPLEMENTED`) and not with HTTP's 404.
pub async fn answer_unknown_methods(request: Request, next: Next) -> Response {
    let unmatched = request.extensions().get::<MatchedPath>().is_none();
    let content_type = request.headers().get(CONTENT_TYPE).cloned();
    let Some(content_type) =
        content_type.filter(|it| it.as_bytes().starts_with(b"application/grpc"))
    else {
        return next.run(request).await;
    };
    if !unmatched {
        return next.run(request).await;
    }
    let status = Status::unimplemented(format!("there is no method {}", request.uri().path()));
    let mut response = status.into_http::<axum::body::Body>().into_response();
    // A status in the headers alone is lawful in gRPC-web too, under its own type.
    response.headers_mut().insert(CONTENT_TYPE, content_type);
    response
}
