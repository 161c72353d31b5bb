//! Puts the layers together and runs them: one port, one store, an orderly end.

mod logging;
mod robot_files;
mod serving;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

pub use logging::start_log;
pub use robot_files::RobotFileError;

use crate::config::Config;
use crate::grpc;
use crate::http::{self, HttpSettings};
use crate::job::{JobSettings, Jobs, JobsError, Metrics};
use crate::service::{PlanningRunner, Service, ServiceError};
use crate::store::{OpenError, SqliteStore};
use serving::Limits;

/// Why a server could not start or run on.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The store could not be opened.
    #[error(transparent)]
    Store(#[from] OpenError),
    /// The jobs could not be taken up.
    #[error("cannot start the jobs")]
    Jobs(#[from] JobsError),
    /// A robot file is none.
    #[error(transparent)]
    RobotFile(#[from] RobotFileError),
    /// The metrics could not be set up.
    #[error("cannot set up the metrics")]
    Metrics(#[from] prometheus::Error),
    /// The gRPC edge could not be set up.
    #[error("cannot set up gRPC")]
    Grpc(#[from] tonic_reflection::server::Error),
    /// The listener or a connection failed.
    #[error("cannot serve")]
    Serve(#[from] std::io::Error),
    /// Something failed that only a new start of the process can mend.
    #[error("cannot go on; start the server again")]
    Failed(#[source] ServiceError),
}

/// How long connections get to end once everything else has.
const CLOSING: Duration = Duration::from_secs(5);

/// How often it is looked whether the service can still do its work.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Serves on `listener` until `shutdown` is ready, then ends in order: not
/// ready, no new jobs, running ones get `drain_s`, then streams and connections
/// end.
///
/// Ends by itself, with an error, once only a new start can help; whoever
/// watches over the process can then give it one.
///
/// # Errors
///
/// See [`AppError`].
pub async fn run(
    config: &Config,
    listener: TcpListener,
    shutdown: impl Future<Output = ()>,
) -> Result<(), AppError> {
    let mut running = Running::start(config, listener).await?;
    tracing::info!(address = %running.address, version = env!("CARGO_PKG_VERSION"), "serving");
    let failure = tokio::select! {
        () = shutdown => return running.stop().await,
        failure = failure(&running.service) => failure,
    };
    tracing::error!(%failure, "ending, for only a new start can help");
    // Whatever the running jobs would still find could not be stored.
    running.drain = Duration::ZERO;
    running.stop().await?;
    Err(AppError::Failed(failure))
}

/// Waits until `service` can do its work no more.
async fn failure(service: &Service) -> ServiceError {
    loop {
        if let Err(failure) = service.liveness() {
            return failure;
        }
        tokio::time::sleep(LOOK_EVERY).await;
    }
}

/// A server that runs.
pub struct Running {
    address: SocketAddr,
    service: Service,
    drain: Duration,
    close: oneshot::Sender<()>,
    server: JoinHandle<()>,
    retention: JoinHandle<()>,
}

impl Running {
    /// Opens the store, takes up its jobs and serves on `listener`.
    ///
    /// # Errors
    ///
    /// See [`AppError`].
    pub async fn start(config: &Config, listener: TcpListener) -> Result<Self, AppError> {
        let service = open(config).await?;
        if let Some(directory) = &config.robots_dir {
            let robots = robot_files::register(&service, directory).await?;
            tracing::info!(robots, directory = %directory.display(), "registered robot files");
        }
        let settings = HttpSettings { max_body_bytes: config.max_body_bytes };
        let router = router(service.clone(), settings)?;
        let address = listener.local_addr()?;
        let (close, closing) = oneshot::channel::<()>();
        let closing = async move {
            // A dropped handle closes the server as well.
            let _ = closing.await;
        };
        let server = serving::serve(listener, router, Limits::default(), closing);
        let retention = keep_for(service.clone(), config.retention_days);
        Ok(Self {
            address,
            service,
            drain: Duration::from_secs_f64(config.drain_s),
            close,
            server: tokio::spawn(server),
            retention: tokio::spawn(retention),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What it serves.
    pub fn service(&self) -> &Service {
        &self.service
    }

    /// Ends in order; see [`run`].
    ///
    /// # Errors
    ///
    /// If serving had failed.
    pub async fn stop(self) -> Result<(), AppError> {
        tracing::info!("draining");
        self.retention.abort();
        let drained = self.service.drain(self.drain).await;
        tracing::info!(?drained, "drained");
        // Nobody listens any more if the server had failed; awaiting it tells.
        let _ = self.close.send(());
        let mut server = self.server;
        match tokio::time::timeout(CLOSING, &mut server).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(join)) => Err(std::io::Error::other(join).into()),
            Err(_) => {
                tracing::warn!("connections were cut");
                server.abort();
                Ok(())
            }
        }
    }
}

/// Opens the store below `data_dir` and starts the workers.
async fn open(config: &Config) -> Result<Service, AppError> {
    let metrics = Arc::new(Metrics::new()?);
    let path = config.data_dir.join("takt.db");
    let store = Arc::new(SqliteStore::open(&path, metrics.clone())?);
    let mut settings =
        JobSettings { queue_capacity: config.queue_capacity, ..JobSettings::default() };
    if config.workers > 0 {
        settings.workers = config.workers;
    }
    let jobs =
        Jobs::start(store.clone(), Arc::new(PlanningRunner), metrics.clone(), settings).await?;
    Ok(Service::new(jobs, store, metrics))
}

/// Both edges on one port.
fn router(service: Service, settings: HttpSettings) -> Result<Router, AppError> {
    let grpc = grpc::routes(service.clone(), settings.max_body_bytes)?;
    let unknown_methods = axum::middleware::from_fn(grpc::answer_unknown_methods);
    Ok(http::routes(service, settings).merge(grpc).layer(unknown_methods))
}

/// Deletes what ended more than `days` ago, every hour.
async fn keep_for(service: Service, days: u32) {
    const EVERY: Duration = Duration::from_secs(3600);
    if days == 0 {
        return;
    }
    let mut clock = tokio::time::interval(EVERY);
    loop {
        clock.tick().await;
        match service.delete_older_than(days).await {
            Ok(0) => {}
            Ok(jobs) => tracing::info!(jobs, days, "deleted what ended long ago"),
            Err(error) => tracing::warn!(%error, "old jobs could not be deleted"),
        }
    }
}

/// Is ready when the process is asked to end: SIGTERM, or Ctrl-C. Asked a
/// second time, the process ends at once; what was accepted is stored.
///
/// # Errors
///
/// If the operating system takes no handlers.
pub fn shutdown_signal() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{Signal, SignalKind, signal};
    async fn either(terminate: &mut Signal, interrupt: &mut Signal) -> &'static str {
        tokio::select! {
            _ = terminate.recv() => "SIGTERM",
            _ = interrupt.recv() => "SIGINT",
        }
    }
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    Ok(async move {
        let name = either(&mut terminate, &mut interrupt).await;
        tracing::info!(name, "asked to end");
        tokio::spawn(async move {
            let name = either(&mut terminate, &mut interrupt).await;
            tracing::warn!(name, "asked to end at once");
            std::process::exit(1);
        });
    })
}
