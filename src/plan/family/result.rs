//! What a user gets when a problem is planned in many variants.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::request::SweepAxis;
use crate::plan::result::{Binding, PlanMetrics, Sensitivity, TrajectoryResult};

/// A family, member by member, and the whole plan of its worst case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FamilyResult {
    /// The robot's name.
    pub robot: String,
    /// In words: from which duration to which, and how many failed.
    pub verdict: String,
    /// What was swept; empty if the members were named one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sweep: Vec<SweepAxis>,
    /// A row per member, in the request's order; those of a run that was ended
    /// before its time only as far as they were planned.
    pub members: Vec<MemberResult>,
    /// The member with the shortest duration; of equal ones the first.
    pub fastest: String,
    /// The member with the longest duration, the worst case; of equal ones the first.
    pub slowest: String,
    /// Half of the planned members are faster, s.
    pub median_duration: f64,
    /// Members that could not be planned.
    pub failed: usize,
    /// True if the certificate of every planned member is lawful.
    pub lawful: bool,
    /// The worst ratio of a peak to its limit over all planned members.
    pub worst_ratio: f64,
    /// The plan of the slowest member.
    pub worst_case: Box<TrajectoryResult>,
    /// Candidates evaluated, for all members.
    pub evaluations: u64,
    /// Planning time, s. With that of the worst case and its
    /// `convergence[].elapsed_s` the only field that may differ between equal requests.
    pub planning_s: f64,
    /// The request's seed.
    pub seed: u64,
    /// Version of Takt that planned it.
    pub version: String,
}

/// One member. Figures of the plan are null if it could not be planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MemberResult {
    /// The member's name; that of a sweep names its values.
    pub name: String,
    /// In a sweep, its value on each axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Value>,
    /// Total duration, s.
    pub duration: Option<f64>,
    /// No lawful trajectory is shorter, s; null if not proven.
    pub lower_bound: Option<f64>,
    /// How far the duration is above the bound, as a share of the bound.
    pub gap: Option<f64>,
    /// True if its certificate is lawful.
    pub lawful: Option<bool>,
    /// The worst ratio of a peak to its limit.
    pub worst_ratio: Option<f64>,
    /// Which limit holds it back most; null if none is reached.
    pub most_binding: Option<MostBinding>,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Why it could not be planned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<MemberFailure>,
}

/// The limit that holds a motion back most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MostBinding {
    /// Joint name.
    pub joint: String,
    /// `velocity`, `acceleration` or `jerk`.
    pub limit: String,
    /// Number of segments in which it is reached.
    pub segments: usize,
    /// With `jerk_limited`, by how much the motion gets shorter if the limit is
    /// one percent higher, s: of all limits this one saves most. Null with other
    /// interpolations, where it is the limit reached in most segments.
    pub seconds_per_percent: Option<f64>,
}

/// Why a member could not be planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MemberFailure {
    /// Stable name of the fault, as a job's error has it.
    pub code: String,
    /// What happened, for people.
    pub message: String,
    /// Where it happened.
    pub details: Value,
}

impl MostBinding {
    /// That of a plan with these figures; none if it reaches no limit.
    pub(super) fn of(metrics: &PlanMetrics) -> Option<Self> {
        let reached = |joint: &str, limit: &str| {
            metrics.binding.iter().filter(|it| it.joint == joint && it.limit == limit).count()
        };
        if let Some(Sensitivity { joint, limit, seconds_per_percent }) =
            metrics.sensitivities.first().cloned()
        {
            let segments = reached(&joint, &limit);
            return Some(Self {
                joint,
                limit,
                segments,
                seconds_per_percent: Some(seconds_per_percent),
            });
        }
        let mut most: Option<Self> = None;
        for Binding { joint, limit, .. } in &metrics.binding {
            let segments = reached(joint, limit);
            if most.as_ref().is_none_or(|most| segments > most.segments) {
                let (joint, limit) = (joint.clone(), limit.clone());
                most = Some(Self { joint, limit, segments, seconds_per_percent: None });
            }
        }
        most
    }
}

impl fmt::Display for MostBinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, limit, segments, seconds_per_percent } = self;
        match seconds_per_percent {
            Some(seconds) => write!(f, "{limit} of {joint}, {:.2} ms per %", 1e3 * seconds),
            None if *segments == 1 => write!(f, "{limit} of {joint}, in 1 segment"),
            None => write!(f, "{limit} of {joint}, in {segments} segments"),
        }
    }
}

impl FamilyResult {
    /// True if `member` is the worst case.
    pub fn is_slowest(&self, member: &MemberResult) -> bool {
        member.name == self.slowest
    }
}
