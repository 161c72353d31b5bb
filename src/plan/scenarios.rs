//! Ready-made requests, one file each in `scenarios/`.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::cell::{Cell, Parameter, resolve};
use crate::fault::{Faults, read};

/// A ready-made request, or several to select from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name to use.
    #[serde(default)]
    pub name: String,
    /// Name in words.
    #[serde(default)]
    pub title: String,
    /// What it shows and what to mind.
    #[serde(default)]
    pub description: String,
    /// Where its figures come from, and which of them are substitutes.
    #[serde(default)]
    pub source: String,
    /// What may be set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Parameter>,
    /// What the settings select the legs of a program from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<Cell>,
    /// The plan request; with a cell, that for the default settings.
    pub request: Value,
}

impl Scenario {
    /// Reads a scenario and selects the default settings.
    ///
    /// # Errors
    ///
    /// Every fault of structure, then every reference to what is not there.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let scenario = read::<Self>(value, "", &mut faults);
        let Some(mut scenario) = scenario else { return Err(faults) };
        scenario.check(&mut faults);
        faults.into_result(())?;
        scenario.request = scenario.select(&[])?;
        Ok(scenario)
    }

    fn check(&self, faults: &mut Faults) {
        for (index, parameter) in self.parameters.iter().enumerate() {
            let (place, mut found) = (format!("/parameters/{index}"), Faults::default());
            parameter.check(&mut found);
            if self.parameters[..index].iter().any(|before| before.name == parameter.name) {
                found.add("/name", format!("another parameter is called `{}`", parameter.name));
            }
            faults.add_below(&place, found);
        }
        if !self.request.is_object() {
            faults.add("/request", "expected a plan request");
        }
        match &self.cell {
            Some(cell) if faults.is_empty() => {
                let mut found = Faults::default();
                cell.check(&self.parameters, &mut found);
                faults.add_below(&format!("/cell/{}", cell.kind()), found);
            }
            None if !self.parameters.is_empty() => {
                faults.add("/parameters", "select nothing without a cell");
            }
            _ => {}
        }
    }

    /// The request for what is `given`; the rest has its defaults.
    ///
    /// # Errors
    ///
    /// Settings that are unknown or do not go together, as `/parameter`.
    pub fn select(&self, given: &[(String, String)]) -> Result<Value, Faults> {
        let settings = resolve(&self.parameters, given)?;
        let mut request = self.request.clone();
        if let (Some(cell), Value::Object(members)) = (&self.cell, &mut request) {
            members.insert("task".to_owned(), cell.program(&settings)?);
        }
        Ok(request)
    }
}

const FILES: &[&str] = &[
    include_str!("../../scenarios/mcb-ab.json"),
    include_str!("../../scenarios/mcb-ab-fastest.json"),
    include_str!("../../scenarios/mcb-ab-what-if.json"),
    include_str!("../../scenarios/mcb-assembly.json"),
    include_str!("../../scenarios/optimizers.json"),
    include_str!("../../scenarios/pallet-places.json"),
    include_str!("../../scenarios/palletizing.json"),
    include_str!("../../scenarios/palletizing-points.json"),
    include_str!("../../scenarios/shu-ab.json"),
    include_str!("../../scenarios/shu-bc.json"),
    include_str!("../../scenarios/shu-cd.json"),
    include_str!("../../scenarios/shu-cycle.json"),
    include_str!("../../scenarios/shu-de.json"),
    include_str!("../../scenarios/wood.json"),
    include_str!("../../scenarios/wood-fastest.json"),
    include_str!("../../scenarios/zhang-box.json"),
    include_str!("../../scenarios/zhang-plane-1.json"),
    include_str!("../../scenarios/zhang-plane-2.json"),
];

static SCENARIOS: LazyLock<Vec<Scenario>> = LazyLock::new(|| {
    // A file that cannot be read is left out here and fails the tests.
    let load = |text: &&str| Scenario::parse(serde_json::from_str(text).ok()?).ok();
    FILES.iter().filter_map(load).collect()
});

/// All scenarios, by name.
pub fn all() -> &'static [Scenario] {
    &SCENARIOS
}

/// The scenario called `name`.
pub fn get(name: &str) -> Option<&'static Scenario> {
    all().iter().find(|scenario| scenario.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{PlanRequest, validate};
    use crate::robot::catalogue;

    #[test]
    fn every_scenario_is_a_valid_request() {
        assert_eq!(all().len(), FILES.len());
        for scenario in all() {
            let request = PlanRequest::parse(scenario.request.clone()).unwrap();
            let checked = validate(&request, &catalogue::get);
            assert!(checked.is_ok(), "{}: {}", scenario.name, checked.err().unwrap());
        }
    }
}
