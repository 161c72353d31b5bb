//! What a user may set in a scenario.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::fault::{Faults, escape};

/// Every parameter's value.
pub type Settings = BTreeMap<String, String>;

/// Most values of a range.
const LONGEST_RANGE: u32 = 1000;

/// What a user may set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name to set it by.
    pub name: String,
    /// What it means.
    pub description: String,
    /// The value it has if nobody sets it.
    pub default: String,
    /// The values it takes.
    pub values: Values,
}

/// The values that a parameter takes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Values {
    /// One of these.
    Choices(Vec<Choice>),
    /// A whole number.
    Range {
        /// Smallest.
        min: u32,
        /// Largest.
        max: u32,
    },
}

/// One value of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// As it is set.
    pub value: String,
    /// What it means.
    #[serde(default)]
    pub description: String,
}

impl Parameter {
    /// All values, in order.
    pub fn all(&self) -> Vec<String> {
        match &self.values {
            Values::Choices(choices) => choices.iter().map(|choice| choice.value.clone()).collect(),
            Values::Range { min, max } => (*min..=*max).map(|value| value.to_string()).collect(),
        }
    }

    /// Checks the declaration; pointers count from it.
    pub fn check(&self, faults: &mut Faults) {
        if let Values::Range { min, max } = self.values
            && (min > max || max - min >= LONGEST_RANGE)
        {
            let detail = format!("{min} to {max} is no range of 1 to {LONGEST_RANGE} values");
            faults.add("/values/range", detail);
            return;
        }
        if let Err(detail) = self.read(&self.default) {
            faults.add("/default", detail);
        }
    }

    /// Reads a value as it was given; says what is known if it is none.
    fn read(&self, given: &str) -> Result<String, String> {
        match &self.values {
            Values::Choices(choices) => {
                let found = choices.iter().find(|choice| choice.value == given);
                found.map(|choice| choice.value.clone()).ok_or_else(|| {
                    format!("`{given}` is unknown; known: {}", self.all().join(", "))
                })
            }
            Values::Range { min, max } => {
                let number = given.parse().ok().filter(|number| (*min..=*max).contains(number));
                number
                    .map(|number| number.to_string())
                    .ok_or_else(|| format!("`{given}` is no whole number from {min} to {max}"))
            }
        }
    }
}

/// Every parameter's value: as given, else its default.
///
/// # Errors
///
/// All names and values that are unknown, as `/parameter`.
pub fn resolve(parameters: &[Parameter], given: &[(String, String)]) -> Result<Settings, Faults> {
    let mut faults = Faults::default();
    let default = |parameter: &Parameter| (parameter.name.clone(), parameter.default.clone());
    let mut settings: Settings = parameters.iter().map(default).collect();
    for (index, (name, value)) in given.iter().enumerate() {
        let place = format!("/{}", escape(name));
        let Some(parameter) = parameters.iter().find(|parameter| parameter.name == *name) else {
            faults.add(place, format!("no parameter is called `{name}`; {}", known(parameters)));
            continue;
        };
        if given[..index].iter().any(|(before, _)| before == name) {
            faults.add(place, "is set more than once");
            continue;
        }
        match parameter.read(value) {
            Ok(value) => drop(settings.insert(name.clone(), value)),
            Err(detail) => faults.add(place, detail),
        }
    }
    faults.into_result(settings)
}

fn known(parameters: &[Parameter]) -> String {
    if parameters.is_empty() {
        return "there are none here".to_owned();
    }
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    format!("known: {}", names.join(", "))
}
