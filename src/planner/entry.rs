//! What a planner of the registry is, and how its parameters are read.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::PlanningProblem;
use crate::fault::Faults;
use crate::fault::parameter::{Parameter, ParameterInfo, ParameterKind, Settings};

/// A planner of the registry.
#[derive(Debug)]
pub struct PlannerEntry {
    /// Registry name.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it does and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// True if it goes on making its path shorter until a limit ends it.
    pub anytime: bool,
    /// True if it needs the distance to obstacles.
    pub needs_clearance: bool,
    /// Its own parameters, beside the common ones.
    pub parameters: &'static [Parameter],
}

/// What every planner takes.
static COMMON: &[Parameter] = &[Parameter {
    name: "time_limit_s",
    description: "end after this long, s; the result may then differ from run to run; default: no \
                  limit",
    kind: ParameterKind::Real,
    default: None,
    min: 0.0,
    max: 86_400.0,
}];

/// What every planner takes that goes on after its first path.
static ANYTIME: &[Parameter] = &[
    Parameter {
        name: "first_path",
        description: "end with the first path; default false",
        kind: ParameterKind::Boolean,
        default: Some(0.0),
        min: 0.0,
        max: 1.0,
    },
    Parameter {
        name: "gap",
        description: "end with a path at most this share longer than the straight line, which \
                      none can undercut; default 0",
        kind: ParameterKind::Real,
        default: Some(0.0),
        min: 0.0,
        max: 1e6,
    },
];

/// `iterations` with a method's own default.
pub(super) const fn iterations(default: f64) -> Parameter {
    Parameter {
        name: "iterations",
        description: "end after this many samples",
        kind: ParameterKind::Integer,
        default: Some(default),
        min: 0.0,
        max: 1e8,
    }
}

/// `range`, whose default is a share of the box's diagonal.
pub(super) const RANGE: Parameter = optional(
    "range",
    "longest extension of a tree, in the units of the space; default: a tenth of the box's diagonal",
);

/// The range that is set, or a tenth of the box's diagonal: measured on three
/// maps of a plane, where 0.07 and 0.14 take up to half as long again.
pub(super) fn range(settings: &Settings, problem: &PlanningProblem) -> f64 {
    settings.optional("range").unwrap_or(0.1 * problem.diagonal())
}

/// A positive real parameter whose default depends on the problem.
pub(super) const fn optional(name: &'static str, description: &'static str) -> Parameter {
    Parameter {
        name,
        description,
        kind: ParameterKind::Real,
        default: None,
        min: f64::MIN_POSITIVE,
        max: 1e12,
    }
}

impl PlannerEntry {
    /// All parameters: its own, then the common ones.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static Parameter> + Clone + use<> {
        let anytime = if self.anytime { ANYTIME } else { &[] };
        self.parameters.iter().chain(anytime).chain(COMMON)
    }

    /// All parameters at their defaults.
    pub fn defaults(&self) -> Settings {
        Settings::defaults(self.all_parameters())
    }

    /// Reads parameters that stand at `pointer`, filling in defaults.
    pub fn settings(
        &self,
        given: &BTreeMap<String, Value>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Settings {
        Settings::read(self.name, self.all_parameters(), given, pointer, faults)
    }

    /// The entry as users see it.
    pub fn info(&self) -> PlannerInfo {
        PlannerInfo {
            name: self.name,
            title: self.title,
            description: self.description,
            source: self.source,
            anytime: self.anytime,
            parameters: self.all_parameters().map(Parameter::info).collect(),
        }
    }
}

/// A registry entry as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct PlannerInfo {
    /// Name to use in requests.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it does and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// True if it goes on making its path shorter until a limit ends it.
    pub anytime: bool,
    /// What can be set.
    pub parameters: Vec<ParameterInfo>,
}
