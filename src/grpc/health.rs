//! The standard health service: serving while the service is ready.

use std::pin::Pin;
use std::time::Duration;

use futures::{Stream, StreamExt, stream};
use tonic::server::NamedService;
use tonic::{Request, Response, Status};
use tonic_health::pb::health_check_response::ServingStatus;
use tonic_health::pb::health_server::Health;
use tonic_health::pb::{HealthCheckRequest, HealthCheckResponse};

use super::{PlanningServer, RobotsServer};
use crate::service::{ErrorCode, Service, ServiceError};

/// How often a watcher's status is looked at.
const WATCH_PERIOD: Duration = Duration::from_secs(1);

/// Answers from the service's readiness. The ready-made reporter would have to
/// be told of every change; this one asks.
pub(super) struct Readiness(pub(super) Service);

#[tonic::async_trait]
impl Health for Readiness {
    async fn check(
        &self,
        request: Request<HealthCheckRequest>,
    ) -> Result<Response<HealthCheckResponse>, Status> {
        let name = request.into_inner().service;
        if !is_served(&name) {
            return Err(ServiceError::new(
                ErrorCode::NotFound,
                format!("there is no service `{name}`"),
            )
            .into());
        }
        Ok(Response::new(response(status(&self.0).await.0)))
    }

    type WatchStream = Pin<Box<dyn Stream<Item = Result<HealthCheckResponse, Status>> + Send>>;

    async fn watch(
        &self,
        request: Request<HealthCheckRequest>,
    ) -> Result<Response<Self::WatchStream>, Status> {
        if !is_served(&request.into_inner().service) {
            let unknown = Ok(response(ServingStatus::ServiceUnknown));
            return Ok(Response::new(Box::pin(stream::iter([unknown]))));
        }
        Ok(Response::new(Box::pin(changes(self.0.clone()).map(|status| Ok(response(status))))))
    }
}

/// The status now and whenever it has changed; ends when the server drains.
fn changes(service: Service) -> impl Stream<Item = ServingStatus> + Send {
    stream::unfold(Some(ServingStatus::Unknown), move |told| {
        let service = service.clone();
        async move {
            let told = told?;
            loop {
                let (status, last) = status(&service).await;
                if status != told {
                    return Some((status, (!last).then_some(status)));
                }
                if last {
                    return None;
                }
                tokio::time::sleep(WATCH_PERIOD).await;
            }
        }
    })
}

/// The status, and whether it is the last one.
async fn status(service: &Service) -> (ServingStatus, bool) {
    match service.readiness().await {
        Ok(()) => (ServingStatus::Serving, false),
        Err(error) => (ServingStatus::NotServing, error.code == ErrorCode::Draining),
    }
}

fn is_served(name: &str) -> bool {
    // The empty name is the server as a whole.
    ["", PlanningServer::NAME, RobotsServer::NAME].contains(&name)
}

fn response(status: ServingStatus) -> HealthCheckResponse {
    HealthCheckResponse { status: status.into() }
}
