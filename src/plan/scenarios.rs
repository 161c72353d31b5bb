//! Ready-made requests, one file each in `scenarios/`.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// A ready-made request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name to use.
    pub name: String,
    /// Name in words.
    pub title: String,
    /// What it shows and what to mind.
    pub description: String,
    /// Where its figures come from, and which of them are substitutes.
    pub source: String,
    /// The plan request.
    pub request: Value,
}

const FILES: &[&str] = &[
    include_str!("../../scenarios/mcb-ab.json"),
    include_str!("../../scenarios/mcb-assembly.json"),
    include_str!("../../scenarios/optimizers.json"),
    include_str!("../../scenarios/wood.json"),
];

static SCENARIOS: LazyLock<Vec<Scenario>> = LazyLock::new(|| {
    // A file that cannot be read is left out here and fails the tests.
    FILES.iter().filter_map(|text| serde_json::from_str(text).ok()).collect()
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
