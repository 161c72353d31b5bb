//! Jobs and their events.

use serde_json::Value;

use super::{MessageForm, Place, Required};
use crate::fault::Faults;
use crate::grpc::proto;
use crate::job::{
    DEFAULT_PRIORITY, EventKind, Job, JobError, JobEvent, JobFilter, JobId, JobPage, JobState,
    Progress,
};
use crate::service::{JobRequest, ResultSummary};

message_form!(Job {
    id,
    state,
    priority,
    labels,
    task,
    method,
    robot,
    seed,
    created_at: Required,
    started_at,
    finished_at,
    deadline_s,
    start_by,
    attempt,
    progress,
    error,
});

message_form!(JobPage as ListJobsResponse { jobs, next_page_token });

message_form!(Progress {
    iteration,
    evaluations,
    elapsed_s,
    best,
    mean,
    lower_bound,
    leg,
    method,
    members,
});

message_form!(ResultSummary {
    duration,
    lawful,
    worst_ratio,
    lower_bound,
    legs,
    evaluations,
    planning_s,
    verdict,
});

message_enum!(
    JobState { Queued, Running, Succeeded, Failed, Cancelled, Expired },
    unspecified: None
);

impl MessageForm<String> for JobId {
    fn into_message(self) -> String {
        self.to_string()
    }

    fn from_message(message: String, place: Place<'_>, faults: &mut Faults) -> Self {
        message.parse().unwrap_or_else(|_| {
            place.fault(faults, format!("`{message}` is not the id of a job"));
            Self::new()
        })
    }
}

impl MessageForm<proto::JobRequest> for JobRequest {
    fn into_message(self) -> proto::JobRequest {
        let Self { plan, priority, deadline_s, start_by, labels } = self;
        proto::JobRequest {
            plan: Some(plan.into_message()),
            priority: Some(priority.into_message()),
            deadline_s,
            start_by: start_by.into_message(),
            labels,
        }
    }

    fn from_message(message: proto::JobRequest, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::JobRequest { plan, priority, deadline_s, start_by, labels } = message;
        // The JSON form has the plan's fields beside the job's.
        let Required(plan) = MessageForm::from_message(plan, place, faults);
        let priority = MessageForm::from_message(priority, place.field("priority"), faults);
        Self {
            plan,
            priority: Option::unwrap_or(priority, DEFAULT_PRIORITY),
            deadline_s: MessageForm::from_message(deadline_s, place.field("deadline_s"), faults),
            start_by: MessageForm::from_message(start_by, place.field("start_by"), faults),
            labels,
        }
    }
}

impl MessageForm<proto::ListJobsRequest> for JobFilter {
    fn into_message(self) -> proto::ListJobsRequest {
        let Self { state, labels, page_size, page_token } = self;
        proto::ListJobsRequest {
            state: state.into_message(),
            labels,
            page_size: u32::try_from(page_size).unwrap_or(u32::MAX),
            page_token: page_token.unwrap_or_default(),
        }
    }

    fn from_message(
        message: proto::ListJobsRequest,
        place: Place<'_>,
        faults: &mut Faults,
    ) -> Self {
        let proto::ListJobsRequest { state, labels, page_size, page_token } = message;
        Self {
            state: MessageForm::from_message(state, place.field("state"), faults),
            labels,
            page_size: usize::try_from(page_size).unwrap_or(usize::MAX),
            page_token: (!page_token.is_empty()).then_some(page_token),
        }
    }
}

impl MessageForm<proto::JobError> for JobError {
    fn into_message(self) -> proto::JobError {
        let Self { code, message, details } = self;
        let details = (!details.is_null()).then(|| details.into_message());
        proto::JobError { code, message, details }
    }

    fn from_message(message: proto::JobError, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::JobError { code, message, details } = message;
        let details: Option<Value> =
            MessageForm::from_message(details, place.field("details"), faults);
        Self { code, message, details: details.unwrap_or_default() }
    }
}

impl MessageForm<proto::JobEvent> for JobEvent {
    fn into_message(self) -> proto::JobEvent {
        let Self { seq, time, kind } = self;
        proto::JobEvent { seq, time: Some(time.into_message()), kind: Some(kind.into_message()) }
    }

    fn from_message(message: proto::JobEvent, place: Place<'_>, faults: &mut Faults) -> Self {
        let proto::JobEvent { seq, time, kind } = message;
        let Required(time) = MessageForm::from_message(time, place.field("time"), faults);
        let kind = kind.unwrap_or_else(|| {
            place.fault(faults, "expected state, progress or finished");
            proto::job_event::Kind::Progress(proto::Progress::default())
        });
        Self { seq, time, kind: MessageForm::from_message(kind, place, faults) }
    }
}

impl MessageForm<proto::job_event::Kind> for EventKind {
    fn into_message(self) -> proto::job_event::Kind {
        use proto::job_event::Kind;
        match self {
            Self::State { state, attempt } => {
                Kind::State(proto::StateChange { state: state.into_message(), attempt })
            }
            Self::Progress(progress) => Kind::Progress(progress.into_message()),
            Self::Finished { state, summary, error } => Kind::Finished(proto::Finished {
                state: state.into_message(),
                // Events kept by another version may hold other figures.
                summary: summary
                    .and_then(|summary| serde_json::from_value::<ResultSummary>(summary).ok())
                    .map(MessageForm::into_message),
                error: error.into_message(),
            }),
        }
    }

    fn from_message(
        message: proto::job_event::Kind,
        place: Place<'_>,
        faults: &mut Faults,
    ) -> Self {
        use proto::job_event::Kind;
        match message {
            Kind::State(proto::StateChange { state, attempt }) => Self::State {
                state: MessageForm::from_message(state, place.field("state"), faults),
                attempt,
            },
            Kind::Progress(progress) => {
                Self::Progress(MessageForm::from_message(progress, place, faults))
            }
            Kind::Finished(proto::Finished { state, summary, error }) => {
                let summary: Option<ResultSummary> =
                    MessageForm::from_message(summary, place.field("summary"), faults);
                Self::Finished {
                    state: MessageForm::from_message(state, place.field("state"), faults),
                    summary: summary.and_then(|summary| serde_json::to_value(summary).ok()),
                    error: MessageForm::from_message(error, place.field("error"), faults),
                }
            }
        }
    }
}
