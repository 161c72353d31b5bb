//! What an optimizer of the registry is, and how its parameters are read.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::{Objective, Optimizer};
use crate::fault::{Faults, escape};

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

/// A parameter of an optimizer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name in requests.
    pub name: &'static str,
    /// What it does, its unit, where its default comes from.
    pub description: &'static str,
    /// Type of the value.
    pub kind: ParameterKind,
    /// Value when not given; none if it is then off.
    pub default: Option<f64>,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

/// Type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ParameterKind {
    /// A whole number.
    Integer,
    /// Any number.
    Real,
    /// `true` or `false`.
    Boolean,
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

/// A real parameter.
pub const fn real(
    name: &'static str,
    description: &'static str,
    default: f64,
    min: f64,
    max: f64,
) -> Parameter {
    Parameter { name, description, kind: ParameterKind::Real, default: Some(default), min, max }
}

/// A parameter that is on or off.
pub const fn flag(name: &'static str, description: &'static str, default: bool) -> Parameter {
    Parameter {
        name,
        description,
        kind: ParameterKind::Boolean,
        default: Some(if default { 1.0 } else { 0.0 }),
        min: 0.0,
        max: 1.0,
    }
}

/// `shift`, for methods that draw candidates to the origin.
pub const SHIFT: Parameter = flag(
    "shift",
    "measure positions from the centre of the search range instead of from the origin, which the \
     method favours; default false, as published",
    false,
);

/// An optimizer's parameters, checked and complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings(BTreeMap<&'static str, f64>);

impl Settings {
    /// The value of a parameter the entry declares.
    ///
    /// # Panics
    ///
    /// In debug builds, if the entry declares none of that name.
    pub fn get(&self, name: &str) -> f64 {
        let value = self.0.get(name).copied();
        debug_assert!(value.is_some(), "undeclared parameter {name}");
        value.unwrap_or(f64::NAN)
    }

    /// The value of a parameter that may be off.
    pub fn optional(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// Whether a parameter that is on or off is on.
    pub fn flag(&self, name: &str) -> bool {
        self.get(name) != 0.0
    }

    /// All values by name; `true` is 1.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.0.iter().map(|(&name, &value)| (name, value))
    }

    /// The same with another value of a parameter the entry declares.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: f64) -> Self {
        self.0.insert(name, value);
        self
    }

    /// The value of a whole number.
    pub fn integer(&self, name: &str) -> u64 {
        self.get(name) as u64
    }
}

impl OptimizerEntry {
    /// True if the seed changes nothing. Such a method follows the scaling law
    /// and can only be used where [`Objective::is_homogeneous`].
    pub fn is_deterministic(&self) -> bool {
        self.name == super::exact::ENTRY.name
    }

    /// All parameters: its own, then the common ones.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.parameters.iter().chain(COMMON)
    }

    /// All parameters at their defaults.
    pub fn defaults(&self) -> Settings {
        let defaults = self.all_parameters().filter_map(|p| Some((p.name, p.default?)));
        Settings(defaults.collect())
    }

    /// Reads parameters that stand at `pointer`, filling in defaults.
    pub fn settings(
        &self,
        given: &BTreeMap<String, Value>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Settings {
        for name in given.keys() {
            if !self.all_parameters().any(|parameter| parameter.name == name) {
                let known: Vec<&str> = self.all_parameters().map(|p| p.name).collect();
                let detail =
                    format!("{} has no parameter `{name}`; known: {}", self.name, known.join(", "));
                faults.add(format!("{pointer}/{}", escape(name)), detail);
            }
        }
        let mut values = BTreeMap::new();
        for parameter in self.all_parameters() {
            let value = match given.get(parameter.name) {
                None | Some(Value::Null) => parameter.default,
                Some(value) => match parameter.read(value) {
                    Ok(value) => Some(value),
                    Err(detail) => {
                        faults.add(format!("{pointer}/{}", parameter.name), detail);
                        parameter.default
                    }
                },
            };
            if let Some(value) = value {
                values.insert(parameter.name, value);
            }
        }
        Settings(values)
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

impl Parameter {
    fn read(&self, value: &Value) -> Result<f64, String> {
        let Self { name, min, max, .. } = self;
        let number = match (self.kind, value) {
            (ParameterKind::Boolean, Value::Bool(flag)) => f64::from(u8::from(*flag)),
            (ParameterKind::Boolean, _) => return Err(format!("{name} is true or false")),
            (_, value) => value.as_f64().ok_or(format!("{name} is a number, not {value}"))?,
        };
        if self.kind == ParameterKind::Integer && number.fract() != 0.0 {
            return Err(format!("{name} is a whole number, not {number}"));
        }
        if !(*min..=*max).contains(&number) {
            return Err(format!("{name} is {number}, outside {min} to {max}"));
        }
        Ok(number)
    }

    fn info(&self) -> ParameterInfo {
        let Self { name, description, kind, default, min, max } = *self;
        let default = default.map(|value| match kind {
            ParameterKind::Boolean => Value::from(value != 0.0),
            ParameterKind::Integer => Value::from(value as u64),
            ParameterKind::Real => Value::from(value),
        });
        ParameterInfo { name, description, kind, default, min, max }
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

/// A parameter as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ParameterInfo {
    /// Name to use in requests.
    pub name: &'static str,
    /// What it does, its unit, where its default comes from.
    pub description: &'static str,
    /// Type of the value.
    pub kind: ParameterKind,
    /// Value when not given; null if it is then off.
    #[schema(value_type = Option<f64>)]
    pub default: Option<Value>,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}
