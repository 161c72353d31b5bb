//! A cell that picks parts, turns them and places them on a tray.
//!
//! Part and posture decide on the legs, and the width across which a part is
//! held on a leg decides on the gripper. Source: Shu et al. and Han et al.
//! 2022, doi:10.3390/a15080269, whose tool carries four grippers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{CellLeg, Parameter, Settings, needed, setting};
use crate::fault::{Faults, escape};

/// The parameter that chooses the part.
const PART: &str = "part";

/// Grippers, parts, paths, and which leg is travelled when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Assembly {
    /// Grippers of the tool.
    pub grippers: Vec<Gripper>,
    /// Parts, named as the parameter `part` takes them.
    pub parts: Vec<Part>,
    /// Waypoints by the path's name; rad or m.
    pub paths: BTreeMap<String, Vec<Vec<f64>>>,
    /// What all legs' tasks share: members of a waypoints task.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub task: Map<String, Value>,
    /// Possible legs in order.
    pub legs: Vec<LegRule>,
}

/// A gripper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Gripper {
    /// Name or number.
    pub name: String,
    /// Distance between its jaws, closed and open, mm.
    pub stroke_mm: [f64; 2],
}

/// A part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Width between the jaws by the grasp's name, mm.
    pub grasps_mm: BTreeMap<String, f64>,
    /// Where the widths come from.
    #[serde(default)]
    pub source: String,
}

/// A leg and when it is travelled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LegRule {
    /// Name of the leg, unique among those selected together.
    pub name: String,
    /// Name of its path.
    pub path: String,
    /// Parameters and the values for which it is travelled; none: always.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub when: BTreeMap<String, Vec<String>>,
    /// How the part is held on it; none: the grippers are empty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grasp: Option<String>,
    /// What happens on it.
    #[serde(default)]
    pub note: String,
}

impl Assembly {
    /// Checks the data against itself and `parameters`.
    pub(super) fn check(&self, parameters: &[Parameter], faults: &mut Faults) {
        if let Some(part) = needed(parameters, PART, faults) {
            for name in part.all() {
                if self.part(&name).is_none() {
                    faults.add("/parts", format!("the part `{name}` is missing"));
                }
            }
        }
        for (index, Gripper { stroke_mm: [closed, open], .. }) in self.grippers.iter().enumerate() {
            if !(0.0 <= *closed && closed < open && open.is_finite()) {
                let detail = format!("{closed} to {open} mm is no stroke");
                faults.add(format!("/grippers/{index}/stroke_mm"), detail);
            }
        }
        for (index, leg) in self.legs.iter().enumerate() {
            self.check_leg(leg, &format!("/legs/{index}"), parameters, faults);
        }
    }

    fn check_leg(&self, leg: &LegRule, place: &str, parameters: &[Parameter], faults: &mut Faults) {
        if !self.paths.contains_key(&leg.path) {
            faults.add(format!("{place}/path"), format!("there is no path `{}`", leg.path));
        }
        for (name, values) in &leg.when {
            let place = format!("{place}/when/{}", escape(name));
            let Some(parameter) = parameters.iter().find(|it| it.name == *name) else {
                faults.add(place, format!("there is no parameter `{name}`"));
                continue;
            };
            let all = parameter.all();
            for value in values.iter().filter(|value| !all.contains(value)) {
                faults.add(place.clone(), format!("{name} has no value `{value}`"));
            }
        }
        let Some(grasp) = &leg.grasp else { return };
        for part in self.parts.iter().filter(|part| !part.grasps_mm.contains_key(grasp)) {
            let detail = format!("{} has no width for `{grasp}`", part.name);
            faults.add(format!("{place}/grasp"), detail);
        }
    }

    /// The legs for `settings`, each with its gripper.
    pub(super) fn legs(&self, settings: &Settings) -> Result<Vec<CellLeg>, Faults> {
        let mut faults = Faults::default();
        let part = self.part(setting(settings, PART));
        let holds = |(name, values): (&String, &Vec<String>)| {
            values.iter().any(|value| value == setting(settings, name))
        };
        let mut legs = Vec::new();
        for rule in self.legs.iter().filter(|rule| rule.when.iter().all(holds)) {
            let width = |grasp: &String| part.and_then(|part| part.grasps_mm.get(grasp)).copied();
            let held = rule.grasp.as_ref().and_then(width);
            let mut note = rule.note.clone();
            if let (Some(width), Some(part)) = (held, part) {
                match self.gripper(width) {
                    Some(gripper) => gripper.note(&part.name, width, &mut note),
                    None => faults.add(format!("/{PART}"), self.no_gripper(rule, part, width)),
                }
            }
            let waypoints = self.paths.get(&rule.path).cloned().unwrap_or_default();
            legs.push(CellLeg { name: rule.name.clone(), note, waypoints });
        }
        faults.into_result(legs)
    }

    fn part(&self, name: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.name == name)
    }

    /// The gripper with the most room to either end of its stroke, the first
    /// of equals; none if `width` is within no stroke.
    fn gripper(&self, width: f64) -> Option<&Gripper> {
        let room = |gripper: &Gripper| {
            let [closed, open] = gripper.stroke_mm;
            (width - closed).min(open - width)
        };
        let fitting = self.grippers.iter().filter(|gripper| room(gripper) >= 0.0);
        fitting.reduce(|best, gripper| if room(gripper) > room(best) { gripper } else { best })
    }

    fn no_gripper(&self, leg: &LegRule, part: &Part, width: f64) -> String {
        let stroke =
            |gripper: &Gripper| format!("{}-{}", gripper.stroke_mm[0], gripper.stroke_mm[1]);
        let strokes: Vec<String> = self.grippers.iter().map(stroke).collect();
        let widest = self.grippers.iter().map(|it| it.stroke_mm[1]).fold(0.0, f64::max);
        let verb = if width > widest { "opens to" } else { "fits" };
        format!(
            "no gripper {verb} {width} mm, across which {} is held on leg {}: gripper strokes are {} mm",
            part.name,
            leg.name,
            strokes.join(", ")
        )
    }
}

impl Gripper {
    /// Adds to `note` what the gripper holds.
    fn note(&self, part: &str, width: f64, note: &mut String) {
        let Self { name, stroke_mm: [closed, open] } = self;
        if !note.is_empty() {
            note.push_str("; ");
        }
        note.push_str(&format!(
            "gripper {name} ({closed}-{open} mm) holds {part} across {width} mm"
        ));
    }
}
