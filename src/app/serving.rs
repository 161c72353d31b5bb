//! Accepts connections and serves them until told to close.
//!
//! axum's own server sets no time limits. A port that other machines reach
//! needs some: a client that sends nothing, or a byte now and then, would keep
//! its connection for ever, and so would one whose machine was switched off.

use std::pin::pin;
use std::time::Duration;

use axum::Router;
use axum::serve::Listener;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::server::conn::auto::Builder;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

/// The time limits of a connection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// For a request's head; also how long a connection may stay idle between
    /// requests of HTTP/1.
    pub(super) head: Duration,
    /// How often an HTTP/2 client is asked whether it is still there, and how
    /// long it has to answer.
    pub(super) ping: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { head: Duration::from_secs(60), ping: Duration::from_secs(20) }
    }
}

/// What every HTTP/2 client sends first.
const HTTP2_PREFACE: &[u8; 24] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// Serves `router` on `listener` until `closing` is ready, then lets requests
/// under way end. Dropping it cuts all connections.
pub(super) async fn serve(
    mut listener: TcpListener,
    router: Router,
    limits: Limits,
    closing: impl Future<Output = ()>,
) {
    let mut connections = JoinSet::new();
    let closed = CancellationToken::new();
    let mut closing = pin!(closing);
    loop {
        tokio::select! {
            // Waits a while by itself if the process has no more files to open.
            (stream, _) = Listener::accept(&mut listener) => {
                connections.spawn(connection(stream, router.clone(), limits, closed.clone()));
            }
            Some(_) = connections.join_next() => {}
            () = &mut closing => break,
        }
    }
    drop(listener);
    closed.cancel();
    while connections.join_next().await.is_some() {}
}

async fn connection(stream: TcpStream, router: Router, limits: Limits, closed: CancellationToken) {
    // Small answers must not wait for the client's acknowledgements.
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!(%error, "a connection keeps its delay");
    }
    tokio::select! {
        begun = tokio::time::timeout(limits.head, beginning(&stream)) => {
            if begun.is_err() {
                tracing::debug!("a connection was closed on which nothing was sent");
                return;
            }
        }
        () = closed.cancelled() => return,
    }
    let mut builder = Builder::new(TokioExecutor::new());
    builder.http1().timer(TokioTimer::new()).header_read_timeout(limits.head);
    builder
        .http2()
        .timer(TokioTimer::new())
        .keep_alive_interval(limits.ping)
        .keep_alive_timeout(limits.ping);
    let service = TowerToHyperService::new(router);
    let mut served = pin!(builder.serve_connection(TokioIo::new(stream), service));
    let outcome = tokio::select! {
        outcome = served.as_mut() => outcome,
        () = closed.cancelled() => {
            served.as_mut().graceful_shutdown();
            served.await
        }
    };
    if let Err(error) = outcome {
        tracing::debug!(error, "a connection ended early");
    }
}

/// Waits until the protocol can be told, which the builder does without a
/// limit.
async fn beginning(stream: &TcpStream) {
    const AGAIN: Duration = Duration::from_millis(5);
    let mut bytes = [0; HTTP2_PREFACE.len()];
    loop {
        match stream.peek(&mut bytes).await {
            Ok(count) if count > 0 && count < bytes.len() => {
                if !HTTP2_PREFACE.starts_with(&bytes[..count]) {
                    return;
                }
                tokio::time::sleep(AGAIN).await;
            }
            _ => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::SocketAddr;

    use axum::routing::get;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::sync::oneshot;

    use super::*;

    async fn server(limits: Limits) -> (SocketAddr, oneshot::Sender<()>) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (close, closing) = oneshot::channel();
        let router = Router::new().route("/", get(|| async { "served" }));
        tokio::spawn(serve(listener, router, limits, async move { drop(closing.await) }));
        (address, close)
    }

    async fn answer(address: SocketAddr, sent: &[u8]) -> String {
        let mut client = TcpStream::connect(address).await.unwrap();
        client.write_all(sent).await.unwrap();
        let mut answer = Vec::new();
        // A reset is as good an end as any.
        let _ = client.read_to_end(&mut answer).await;
        String::from_utf8_lossy(&answer).into_owned()
    }

    #[tokio::test]
    async fn a_client_that_dribbles_is_let_go() {
        let limits = Limits { head: Duration::from_millis(50), ..Limits::default() };
        let (address, _close) = server(limits).await;
        let heads: [&[u8]; 4] = [b"", b"P", b"PRI * HT", b"GET / HTTP/1.1\r\nhost"];
        for head in heads {
            let found = answer(address, head).await;
            assert!(!found.contains("served"), "{found}");
        }
        let whole = b"GET / HTTP/1.1\r\nhost: a\r\n\r\n";
        assert!(answer(address, whole).await.ends_with("served"));
    }

    #[tokio::test]
    async fn closing_ends_idle_connections() {
        let (address, close) = server(Limits::default()).await;
        let mut silent = TcpStream::connect(address).await.unwrap();
        let mut idle = TcpStream::connect(address).await.unwrap();
        idle.write_all(b"GET / HTTP/1.1\r\nhost: a\r\n\r\n").await.unwrap();
        let mut begun = [0; 12];
        idle.read_exact(&mut begun).await.unwrap();
        assert_eq!(&begun, b"HTTP/1.1 200");
        close.send(()).unwrap();
        let mut rest = Vec::new();
        idle.read_to_end(&mut rest).await.unwrap();
        assert!(rest.ends_with(b"served"));
        assert_eq!(silent.read(&mut begun).await.unwrap_or(0), 0);
    }
}
