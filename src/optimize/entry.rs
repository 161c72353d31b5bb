//! What an optimizer of the registry is, and how its parameters are read.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::{Objective, Optimizer};
use crate::fault::Faults;
pub use crate::fault::parameter::{Parameter, ParameterInfo, ParameterKind, Settings, flag, real};

/// An optimizer of the registry.
pub struct OptimizerEntry {
    /// Registry name.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it does and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Its own parameters, beside [`COMMON`].
    pub parameters: &'static [Parameter],
    /// Makes one for an objective; the seed feeds its random streams.
    pub build: fn(&Settings, &dyn Objective, u64) -> Box<dyn Optimizer>,
}

/// Limits that every optimizer takes.
pub static COMMON: &[Parameter] = &[
    Parameter {
        name: "max_evaluations",
        description: "end after this many candidates; default: no limit",
        kind: ParameterKind::Integer,
        default: None,
        min: 1.0,
        max: 1e12,
    },
    Parameter {
        name: "time_limit_s",
        description: "end after this long, s; the result may then differ from run to run; \
                      default: no limit",
        kind: ParameterKind::Real,
        default: None,
        min: 0.0,
        max: 86_400.0,
    },
];

/// `population` with a method's own default.
pub const fn population(default: f64) -> Parameter {
    Parameter {
        name: "population",
        description: "candidates per generation",
        kind: ParameterKind::Integer,
        default: Some(default),
        min: 2.0,
        max: 100_000.0,
    }
}

/// `iterations` with a method's own default.
pub const fn iterations(default: f64) -> Parameter {
    Parameter {
        name: "iterations",
        description: "generations after the initial one",
        kind: ParameterKind::Integer,
        default: Some(default),
        min: 0.0,
        max: 1e9,
    }
}

/// `shift`, for methods that draw candidates to the origin.
pub const SHIFT: Parameter = flag(
    "shift",
    "measure positions from the centre of the search range instead of from the origin, which the \
     method favours; default false, as published",
    false,
);

impl OptimizerEntry {
    /// True if the seed changes nothing. Such a method follows the scaling law
    /// and can only be used where [`Objective::is_homogeneous`].
    pub fn is_deterministic(&self) -> bool {
        self.name == super::exact::ENTRY.name
    }

    /// All parameters: its own, then the common ones.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static Parameter> + Clone + use<> {
        self.parameters.iter().chain(COMMON)
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
    pub fn info(&self) -> OptimizerInfo {
        OptimizerInfo {
            name: self.name,
            title: self.title,
            description: self.description,
            source: self.source,
            parameters: self.all_parameters().map(Parameter::info).collect(),
        }
    }
}

/// A registry entry as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct OptimizerInfo {
    /// Name to use in requests.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it does and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What can be set.
    pub parameters: Vec<ParameterInfo>,
}
