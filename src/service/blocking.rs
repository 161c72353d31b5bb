//! A bound on the work that is done beside the async threads.

use std::sync::LazyLock;
use std::thread::available_parallelism;

use tokio::sync::Semaphore;

use super::ServiceError;

/// Places for work that blocks or computes: twice as many as there are cores,
/// since some of it waits for the disk.
///
/// The runtime would start hundreds of threads at once, and a body takes many
/// times its bytes while it is parsed.
static PLACES: LazyLock<Semaphore> =
    LazyLock::new(|| Semaphore::new(2 * available_parallelism().map_or(1, usize::from)));

/// Runs `work`, which may block or compute for long, off the async threads, as
/// soon as there is a place for it. Must not be awaited by other such work.
///
/// # Errors
///
/// The work's own, or [`Internal`](super::ErrorCode::Internal) if it panicked.
pub async fn blocking<T, E>(work: impl FnOnce() -> Result<T, E> + Send + 'static) -> Result<T, E>
where
    T: Send + 'static,
    E: From<ServiceError> + Send + 'static,
{
    in_place(&PLACES, work).await
}

async fn in_place<T, E>(
    places: &'static Semaphore,
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, E>
where
    T: Send + 'static,
    E: From<ServiceError> + Send + 'static,
{
    let place = places.acquire().await.map_err(ServiceError::internal)?;
    let span = tracing::Span::current();
    let joined = tokio::task::spawn_blocking(move || {
        // The work goes on if its caller goes away, and so it keeps its place.
        let _place = place;
        span.in_scope(work)
    });
    joined.await.unwrap_or_else(|error| Err(ServiceError::internal(error).into()))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use futures::future::join_all;

    use super::super::ErrorCode;
    use super::*;

    #[tokio::test]
    async fn no_more_work_runs_at_once_than_there_are_places() {
        static PLACES: Semaphore = Semaphore::const_new(3);
        static RUNNING: AtomicUsize = AtomicUsize::new(0);
        let works = (0..30).map(|_| {
            in_place(&PLACES, || {
                let running = RUNNING.fetch_add(1, Ordering::SeqCst) + 1;
                std::thread::sleep(Duration::from_millis(1));
                RUNNING.fetch_sub(1, Ordering::SeqCst);
                Ok::<_, ServiceError>(running)
            })
        });
        for running in join_all(works).await {
            assert!((1..=3).contains(&running.unwrap()));
        }
    }

    #[tokio::test]
    async fn a_panic_is_an_error_and_gives_its_place_back() {
        static PLACES: Semaphore = Semaphore::const_new(1);
        let panicked = in_place(&PLACES, || -> Result<(), ServiceError> { panic!("as it should") });
        assert_eq!(panicked.await.unwrap_err().code, ErrorCode::Internal);
        assert_eq!(in_place(&PLACES, || Ok::<_, ServiceError>(7)).await, Ok(7));
    }
}
