//! The planning service.

use std::pin::Pin;

use futures::{Stream, StreamExt, stream};
use prost::Message;
use tonic::metadata::MetadataMap;
use tonic::{Request, Response, Status};

use super::chunks;
use super::convert::{MessageForm, read};
use super::proto;
use crate::fault::Faults;
use crate::job::{JobFilter, JobId, Submitted};
use crate::plan::PlanResult;
use crate::service::{Service, ServiceError, blocking};

/// Request metadata that makes a repeated submission harmless.
const IDEMPOTENCY_KEY: &str = "idempotency-key";

/// Jobs on a page if the client does not say.
const DEFAULT_PAGE_SIZE: usize = 50;
/// Most jobs on a page.
const MAX_PAGE_SIZE: usize = 200;
/// Most bytes of a page: clients refuse messages beyond 4 MiB.
const MAX_PAGE_BYTES: usize = 3 << 20;

/// Serves [`Service`] as `takt.v1.PlanningService`.
pub(super) struct Planning(pub(super) Service);

impl Planning {
    async fn submit(&self, request: Request<proto::JobRequest>) -> Result<Submitted, ServiceError> {
        let key = idempotency_key(request.metadata())?;
        self.0.create_job(read(request.into_inner())?, key).await
    }
}

type Answers<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

#[tonic::async_trait]
impl proto::planning_service_server::PlanningService for Planning {
    async fn create_job(
        &self,
        request: Request<proto::JobRequest>,
    ) -> Result<Response<proto::Job>, Status> {
        let submitted = self.submit(request).await;
        let submitted =
            submitted.inspect_err(|error| self.0.count_rejection(error.code.as_str()))?;
        Ok(Response::new(submitted.job.into_message()))
    }

    async fn get_job(
        &self,
        request: Request<proto::GetJobRequest>,
    ) -> Result<Response<proto::Job>, Status> {
        let job = self.0.job(job_id(request.into_inner().id)?).await?;
        Ok(Response::new(job.into_message()))
    }

    async fn list_jobs(
        &self,
        request: Request<proto::ListJobsRequest>,
    ) -> Result<Response<proto::ListJobsResponse>, Status> {
        let mut filter: JobFilter = read(request.into_inner()).map_err(ServiceError::from)?;
        if filter.page_size == 0 {
            filter.page_size = DEFAULT_PAGE_SIZE;
        }
        filter.page_size = filter.page_size.min(MAX_PAGE_SIZE);
        loop {
            let page = self.0.list_jobs(filter.clone()).await?;
            let jobs = page.jobs.len();
            let page = page.into_message();
            if page.encoded_len() <= MAX_PAGE_BYTES || jobs < 2 {
                return Ok(Response::new(page));
            }
            // Many long labels. Pages may be shorter than asked for.
            filter.page_size = jobs / 2;
        }
    }

    async fn cancel_job(
        &self,
        request: Request<proto::CancelJobRequest>,
    ) -> Result<Response<proto::Job>, Status> {
        let job = self.0.cancel_job(job_id(request.into_inner().id)?).await?;
        Ok(Response::new(job.into_message()))
    }

    type WatchJobStream = Answers<proto::JobEvent>;

    async fn watch_job(
        &self,
        request: Request<proto::WatchJobRequest>,
    ) -> Result<Response<Self::WatchJobStream>, Status> {
        let proto::WatchJobRequest { id, after_seq } = request.into_inner();
        let events = self.0.watch(job_id(id)?, after_seq).await?;
        let events = events.map(|event| match event {
            Ok(event) => Ok((*event).clone().into_message()),
            Err(error) => Err(error.into()),
        });
        Ok(Response::new(Box::pin(events)))
    }

    type GetResultStream = Answers<proto::ResultChunk>;

    async fn get_result(
        &self,
        request: Request<proto::GetResultRequest>,
    ) -> Result<Response<Self::GetResultStream>, Status> {
        let proto::GetResultRequest { id, partial } = request.into_inner();
        let id = job_id(id)?;
        let text = match partial {
            true => self.0.partial_result_text(id).await?,
            false => self.0.result_text(id).await?,
        };
        // A large result takes its time, which the async threads do not have.
        let chunks = blocking(move || {
            let result: PlanResult = serde_json::from_str(&text).map_err(ServiceError::internal)?;
            Ok::<_, ServiceError>(chunks::split(result.into_message()))
        });
        let chunks = chunks.await?;
        Ok(Response::new(Box::pin(stream::iter(chunks.into_iter().map(Ok)))))
    }
}

fn job_id(text: String) -> Result<JobId, ServiceError> {
    text.parse().map_err(|_| {
        let mut faults = Faults::default();
        faults.add("/id", format!("`{text}` is not the id of a job"));
        faults.into()
    })
}

fn idempotency_key(metadata: &MetadataMap) -> Result<Option<String>, ServiceError> {
    let Some(value) = metadata.get(IDEMPOTENCY_KEY) else { return Ok(None) };
    let key = value.to_str().map_err(|_| {
        let mut faults = Faults::default();
        faults.add("", format!("metadata {IDEMPOTENCY_KEY} has other than ASCII characters"));
        faults
    })?;
    Ok(Some(key.to_owned()))
}
