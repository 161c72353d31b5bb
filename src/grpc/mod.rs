//! The gRPC edge: protobuf messages to use cases and back.
//!
//! `proto/takt/v1` is written by hand beside the domain types; `convert` has
//! both directions of every message, and a test compares the field names.

mod calls;
mod chunks;
pub mod convert;
mod health;
mod planning;
pub mod proto;
mod robots;
mod status;

use axum::Router;
use axum::middleware::from_fn;
use tonic::codec::CompressionEncoding::Gzip;
use tonic::service::Routes;
use tonic_health::pb::health_server::HealthServer;
use tonic_reflection::server::{Builder, Error as ReflectionError};
use tonic_web::GrpcWebLayer;
use tower_http::catch_panic::CatchPanicLayer;

use crate::service::Service;
use health::Readiness;
use planning::Planning;
use robots::Robots;

pub use calls::answer_unknown_methods;
pub use chunks::join;
pub use status::ERROR_DOMAIN;

type PlanningServer = proto::planning_service_server::PlanningServiceServer<Planning>;
type RobotsServer = proto::robot_service_server::RobotServiceServer<Robots>;

/// The gRPC services, to be merged with the other edge's routes: planning,
/// robots, health and reflection, for gRPC and gRPC-web.
///
/// A message may have up to `max_message_bytes`. The routes have no fallback of
/// their own; [`answer_unknown_methods`] belongs around the merged router.
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
    // tonic's own fallback would take every path that REST does not know, and
    // so must not be there when the routers are merged.
    let routes = routes.into_axum_router().reset_fallback();
    Ok(routes
        .route_layer(CatchPanicLayer::custom(calls::panicked))
        .route_layer(GrpcWebLayer::new())
        .route_layer(from_fn(calls::follow)))
}

fn reflection() -> Builder<'static> {
    Builder::configure()
        .register_encoded_file_descriptor_set(proto::FILE_DESCRIPTOR_SET)
        .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
        // The details of errors, which generic clients then can show.
        .register_encoded_file_descriptor_set(tonic_types::pb::FILE_DESCRIPTOR_SET)
}
