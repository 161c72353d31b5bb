//! What a job's watchers see.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::{JobError, JobState};
use crate::plan::Progress;

/// One event of a job. All watchers of a job see the same events.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobEvent {
    /// Counts a job's events from 1 without gaps.
    pub seq: u64,
    /// When it happened.
    #[schema(value_type = String, format = DateTime)]
    pub time: Timestamp,
    /// What happened.
    #[serde(flatten)]
    pub kind: EventKind,
}

/// What happened to a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum EventKind {
    /// The job waits or runs, perhaps again.
    State {
        /// `queued` or `running`.
        state: JobState,
        /// Attempts so far, the running one included.
        attempt: u32,
    },
    /// The planning went on.
    Progress(Progress),
    /// The job ended; no event follows.
    Finished {
        /// How it ended.
        state: JobState,
        /// The result in a few figures, if the job succeeded.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schema(value_type = Option<Object>)]
        summary: Option<Value>,
        /// Why it did not succeed.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        error: Option<JobError>,
    },
}

impl EventKind {
    /// True if no event can follow.
    pub fn is_last(&self) -> bool {
        matches!(self, Self::Finished { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_shows_number_time_and_the_three_types() {
        let schema = serde_json::to_string(&<JobEvent as utoipa::PartialSchema>::schema()).unwrap();
        assert!(schema.contains(r#""seq""#) && schema.contains("date-time"), "{schema}");
        let mut parts = Vec::new();
        <JobEvent as ToSchema>::schemas(&mut parts);
        let parts = serde_json::to_string(&parts).unwrap();
        for tag in ["state", "progress", "finished"] {
            assert!(parts.contains(&format!(r#""enum":["{tag}"]"#)), "{tag} not in {parts}");
        }
    }

    #[test]
    fn events_are_flat_tagged_objects_that_read_back_equal() {
        let progress =
            Progress { best: Some(f64::INFINITY), mean: Some(0.1 + 0.2), ..<_>::default() };
        let kinds = [
            EventKind::State { state: JobState::Running, attempt: 1 },
            EventKind::Progress(progress.finite()),
            EventKind::Finished { state: JobState::Succeeded, summary: None, error: None },
        ];
        for (kind, tag) in kinds.into_iter().zip(["state", "progress", "finished"]) {
            let last = kind.is_last();
            let event = JobEvent { seq: 3, time: Timestamp::UNIX_EPOCH, kind };
            let json = serde_json::to_string(&event).unwrap();
            assert!(
                json.starts_with(r#"{"seq":3,"time":"1970-01-01T00:00:00Z","type":""#),
                "{json}"
            );
            assert!(json.contains(&format!(r#""type":"{tag}""#)), "{json}");
            assert_eq!(last, tag == "finished");
            assert_eq!(serde_json::from_str::<JobEvent>(&json).unwrap(), event);
        }
    }
}
