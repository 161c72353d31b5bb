//! What a client sends to have something planned: a plan request and how to
//! treat it as a job.

use std::collections::BTreeMap;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use crate::fault::{Faults, escape, read};
use crate::job::DEFAULT_PRIORITY;
use crate::plan::PlanRequest;

/// A planning job as it is submitted.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct JobRequest {
    /// What to plan.
    #[serde(flatten)]
    pub plan: PlanRequest,
    /// 0 to 100; higher starts earlier.
    #[serde(default)]
    #[schema(minimum = 0, maximum = 100, default = 50)]
    pub priority: u8,
    /// Seconds from acceptance within which the job has to end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0.0)]
    pub deadline_s: Option<f64>,
    /// Latest time at which it may begin, RFC 3339.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub start_by: Option<Timestamp>,
    /// The owner's own marks: at most 64, keys of 1 to 64 characters, values
    /// of at most 256.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
}

/// The members that make a plan request a job.
const MEMBERS: [&str; 4] = ["priority", "deadline_s", "start_by", "labels"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    #[serde(default)]
    priority: Option<i64>,
    #[serde(default)]
    deadline_s: Option<f64>,
    #[serde(default)]
    start_by: Option<Timestamp>,
    #[serde(default)]
    labels: BTreeMap<String, String>,
}

impl JobRequest {
    /// Most labels of a job.
    pub const MAX_LABELS: usize = 64;
    /// Most characters of a label's key.
    pub const MAX_LABEL_KEY: usize = 64;
    /// Most characters of a label's value.
    pub const MAX_LABEL_VALUE: usize = 256;

    /// A job with the default settings.
    pub fn new(plan: PlanRequest) -> Self {
        Self {
            plan,
            priority: DEFAULT_PRIORITY,
            deadline_s: None,
            start_by: None,
            labels: BTreeMap::new(),
        }
    }

    /// Reads a request; the structure only,
    /// [`create_job`](super::Service::create_job) checks its meaning.
    ///
    /// # Errors
    ///
    /// All faults of both together.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let Value::Object(mut plan) = value else {
            faults.add("", "expected an object");
            return Err(faults);
        };
        let mut settings = Map::new();
        for member in MEMBERS {
            settings.extend(plan.shift_remove(member).map(|value| (member.to_owned(), value)));
        }
        let settings = read::<Settings>(Value::Object(settings), "", &mut faults);
        let plan = PlanRequest::parse(Value::Object(plan))
            .map_err(|plan_faults| faults.add_below("", plan_faults));
        let (Some(settings), Ok(plan)) = (settings, plan) else { return Err(faults) };
        // Ranges are looked at together with the plan's meaning, so that all
        // faults come at once; here only what a `u8` cannot hold.
        let job = Self {
            priority: priority(settings.priority, &mut faults),
            deadline_s: settings.deadline_s,
            start_by: settings.start_by,
            labels: settings.labels,
            plan,
        };
        faults.into_result(job)
    }

    /// Adds what is wrong with the job's own settings; the plan is checked
    /// apart.
    pub fn check(&self, faults: &mut Faults) {
        if self.priority > 100 {
            faults.add("/priority", format!("{} is not within 0 to 100", self.priority));
        }
        if let Some(deadline) = self.deadline_s
            && !(deadline > 0.0 && deadline.is_finite())
        {
            faults.add("/deadline_s", format!("{deadline} is not a positive number of seconds"));
        }
        if self.labels.len() > Self::MAX_LABELS {
            let count = self.labels.len();
            faults.add("/labels", format!("{count} labels are more than {}", Self::MAX_LABELS));
        }
        for (key, value) in self.labels.iter().take(Self::MAX_LABELS) {
            let pointer = format!("/labels/{}", escape(key));
            if !(1..=Self::MAX_LABEL_KEY).contains(&key.chars().count()) {
                faults.add(&pointer, format!("keys have 1 to {} characters", Self::MAX_LABEL_KEY));
            }
            if value.chars().count() > Self::MAX_LABEL_VALUE {
                let most = Self::MAX_LABEL_VALUE;
                faults.add(pointer, format!("values have at most {most} characters"));
            }
        }
    }
}

fn priority(given: Option<i64>, faults: &mut Faults) -> u8 {
    match given.map(|value| (value, u8::try_from(value))) {
        None => DEFAULT_PRIORITY,
        Some((_, Ok(priority))) => priority,
        Some((value, Err(_))) => {
            faults.add("/priority", format!("{value} is not within 0 to 100"));
            DEFAULT_PRIORITY
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn pointers(value: Value) -> Vec<String> {
        let faults = JobRequest::parse(value).unwrap_err();
        faults.0.into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn settings_have_defaults_and_are_kept_apart_from_the_plan() {
        let plan = json!({"robot": "ur5e", "task": {"type": "waypoints", "waypoints": [[0], [1]]}});
        let job = JobRequest::parse(plan.clone()).unwrap();
        assert_eq!((job.priority, job.deadline_s, job.start_by), (50, None, None));
        let mut full = plan;
        full["priority"] = json!(90);
        full["start_by"] = json!("2030-01-02T03:04:05Z");
        full["labels"] = json!({"cell": "3"});
        let job = JobRequest::parse(full).unwrap();
        assert_eq!(job.priority, 90);
        assert_eq!(job.labels["cell"], "3");
        let again = JobRequest::parse(serde_json::to_value(&job).unwrap()).unwrap();
        assert_eq!(again, job);
    }

    #[test]
    fn faults_of_settings_and_plan_are_told_together() {
        let found = pointers(json!({"robot": 7, "task": {"type": "dance"}, "priority": "high",
            "deadline_s": [], "colour": "red"}));
        for expected in ["/robot", "/task/type", "/priority", "/deadline_s", "/colour"] {
            assert!(found.iter().any(|pointer| pointer == expected), "{expected}: {found:?}");
        }
    }

    #[test]
    fn everything_missing_is_told_together() {
        assert_eq!(pointers(json!({})), ["/robot", "/task"]);
        assert_eq!(pointers(json!({"task": {}, "colour": 1})), ["/robot", "/colour", "/task/type"]);
        assert_eq!(pointers(json!({"robot": null})), ["/task", "/robot"]);
        assert_eq!(pointers(json!([])), [""]);
    }

    #[test]
    fn settings_have_ranges() {
        let plan = json!({"robot": "r", "task": {"type": "waypoints", "waypoints": []}});
        let mut job = JobRequest::parse(plan.clone()).unwrap();
        let long = "x".repeat(65);
        (job.priority, job.deadline_s) = (101, Some(-1.0));
        job.labels = [String::new(), long.clone()].map(|key| (key, "v".to_owned())).into();
        let mut faults = Faults::default();
        job.check(&mut faults);
        let found: Vec<_> = faults.0.into_iter().map(|fault| fault.pointer).collect();
        assert_eq!(found, ["/priority", "/deadline_s", "/labels/", &format!("/labels/{long}")]);
        let mut beyond = plan;
        beyond["priority"] = json!(300);
        assert_eq!(pointers(beyond), ["/priority"]);
    }
}
