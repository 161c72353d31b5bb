//! Cells as data: what a user sets decides on the legs of a program.
//!
//! A scenario declares parameters and holds a cell; [`Cell::program`] turns
//! settings into the task `program`. Nothing else is known of the cell than
//! its data: another one is another file.

mod assembly;
mod pallet;
mod parameter;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use utoipa::ToSchema;

pub use assembly::{Assembly, Gripper, LegRule, Part};
pub use pallet::{Pack, Pallet, Place};
pub use parameter::{Choice, Parameter, Settings, Values, resolve};

use crate::fault::Faults;

/// What selects the legs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cell {
    /// Part and posture decide on paths and grippers (Han et al., Shu et al.).
    Assembly(Assembly),
    /// Pack type, layers and packs per layer decide on places (Lin and Yang).
    Pallet(Pallet),
}

impl Cell {
    /// The kind, as a scenario names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Assembly(_) => "assembly",
            Self::Pallet(_) => "pallet",
        }
    }

    /// Checks the data against itself and `parameters`; pointers count from
    /// the cell.
    pub fn check(&self, parameters: &[Parameter], faults: &mut Faults) {
        match self {
            Self::Assembly(cell) => cell.check(parameters, faults),
            Self::Pallet(cell) => cell.check(parameters, faults),
        }
    }

    /// The task `program` for `settings`.
    ///
    /// # Errors
    ///
    /// Settings that do not go together, as `/parameter`.
    pub fn program(&self, settings: &Settings) -> Result<Value, Faults> {
        let (legs, shared) = match self {
            Self::Assembly(cell) => (cell.legs(settings)?, &cell.task),
            Self::Pallet(cell) => (cell.legs(settings)?, &cell.task),
        };
        let legs: Vec<Value> = legs.into_iter().map(|leg| leg.into_json(shared)).collect();
        Ok(json!({ "type": "program", "legs": legs }))
    }
}

/// A selected leg.
struct CellLeg {
    name: String,
    note: String,
    waypoints: Vec<Vec<f64>>,
}

impl CellLeg {
    /// The leg of a request; `shared` are the members that all tasks have.
    fn into_json(self, shared: &Map<String, Value>) -> Value {
        let mut task = Map::from_iter([("type".to_owned(), json!("waypoints"))]);
        task.extend(shared.clone());
        task.insert("waypoints".to_owned(), json!(self.waypoints));
        let mut leg = Map::from_iter([("name".to_owned(), json!(self.name))]);
        if !self.note.is_empty() {
            leg.insert("note".to_owned(), json!(self.note));
        }
        leg.insert("task".to_owned(), Value::Object(task));
        Value::Object(leg)
    }
}

/// The parameter `name`, without which the cell cannot select anything.
fn needed<'a>(
    parameters: &'a [Parameter],
    name: &str,
    faults: &mut Faults,
) -> Option<&'a Parameter> {
    let found = parameters.iter().find(|parameter| parameter.name == name);
    if found.is_none() {
        faults.add("", format!("needs a parameter `{name}`"));
    }
    found
}

/// What is set for `name`; empty if the cell was never checked.
fn setting<'a>(settings: &'a Settings, name: &str) -> &'a str {
    settings.get(name).map_or("", String::as_str)
}
