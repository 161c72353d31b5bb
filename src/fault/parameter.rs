//! Parameters that an entry of a registry declares, and how a user's values of
//! them are read: every fault with its pointer, defaults filled in.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::{Faults, escape};

/// A parameter of a method.
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

/// A whole number.
pub const fn integer(
    name: &'static str,
    description: &'static str,
    default: f64,
    min: f64,
    max: f64,
) -> Parameter {
    Parameter { name, description, kind: ParameterKind::Integer, default: Some(default), min, max }
}

/// A method's parameters, checked and complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings(BTreeMap<&'static str, f64>);

impl Settings {
    /// All parameters at their defaults.
    pub fn defaults(parameters: impl Iterator<Item = &'static Parameter>) -> Self {
        Self(parameters.filter_map(|p| Some((p.name, p.default?))).collect())
    }

    /// Reads the parameters of `method` that stand at `pointer`, filling in
    /// defaults.
    pub fn read(
        method: &str,
        parameters: impl Iterator<Item = &'static Parameter> + Clone,
        given: &BTreeMap<String, Value>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Self {
        for name in given.keys() {
            if !parameters.clone().any(|parameter| parameter.name == name) {
                let known: Vec<&str> = parameters.clone().map(|p| p.name).collect();
                let detail =
                    format!("{method} has no parameter `{name}`; known: {}", known.join(", "));
                faults.add(format!("{pointer}/{}", escape(name)), detail);
            }
        }
        let mut values = BTreeMap::new();
        for parameter in parameters {
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
        Self(values)
    }

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

    /// The parameter as users see it.
    pub fn info(&self) -> ParameterInfo {
        let Self { name, description, kind, default, min, max } = *self;
        let default = default.map(|value| match kind {
            ParameterKind::Boolean => Value::from(value != 0.0),
            ParameterKind::Integer => Value::from(value as u64),
            ParameterKind::Real => Value::from(value),
        });
        ParameterInfo { name, description, kind, default, min, max }
    }
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
