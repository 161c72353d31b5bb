//! A cell that stacks packs on a pallet.
//!
//! Pack type, layers and packs per layer decide on the sequence of places.
//! Source: Lin and Yang, palletizing: 25 pack types, at most 5 layers and at
//! most 5 packs per layer. The paper prints no pattern.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{CellLeg, Parameter, Settings, needed, setting};
use crate::fault::Faults;

/// The parameters that choose pack type, layers and packs per layer.
const PACK: &str = "pack";
const LAYERS: &str = "layers";
const PER_LAYER: &str = "per_layer";

/// Where packs are picked, and where those of each type may stand.
/// Configurations are in joint order, rad or m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Pallet {
    /// What all legs' tasks share: members of a waypoints task.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub task: Map<String, Value>,
    /// Height of the pallet's deck, mm.
    pub deck_mm: f64,
    /// Where the arm starts and ends.
    pub home: Vec<f64>,
    /// Passed on the way to and from the pick point.
    pub above_pick: Vec<f64>,
    /// Where packs are picked.
    pub pick: Vec<f64>,
    /// Pack types, named as the parameter `pack` takes them.
    pub packs: Vec<Pack>,
}

/// A type of packs and its pattern.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Pack {
    /// Its name.
    pub name: String,
    /// Length, width and height, mm.
    pub size_mm: [f64; 3],
    /// Places of a layer, in the order in which they are filled.
    pub places: Vec<Place>,
}

/// A place on the pallet, and those above it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Where the pack's middle stands, mm from the robot's origin.
    pub at_mm: [f64; 2],
    /// Passed on the way down and up, above the highest stack.
    pub above: Vec<f64>,
    /// Where a pack is let go, from the lowest layer up.
    pub layers: Vec<Vec<f64>>,
}

impl Pallet {
    /// Checks the data against itself and `parameters`.
    pub(super) fn check(&self, parameters: &[Parameter], faults: &mut Faults) {
        for name in [LAYERS, PER_LAYER] {
            needed(parameters, name, faults);
        }
        let pack = needed(parameters, PACK, faults);
        for name in pack.map(Parameter::all).unwrap_or_default() {
            if self.pack(&name).is_none() {
                faults.add("/packs", format!("the pack `{name}` is missing"));
            }
        }
        for (index, pack) in self.packs.iter().enumerate() {
            let layers = pack.layers();
            let even = pack.places.iter().all(|place| place.layers.len() == layers);
            if layers == 0 || !even {
                let detail = "every place needs the same number of layers, 1 or more";
                faults.add(format!("/packs/{index}/places"), detail);
            }
        }
    }

    /// To the pick point; then to every place, layer by layer, and back, after
    /// the last one home.
    pub(super) fn legs(&self, settings: &Settings) -> Result<Vec<CellLeg>, Faults> {
        let mut faults = Faults::default();
        let count = |name: &str| setting(settings, name).parse().unwrap_or(0usize);
        let (layers, per_layer) = (count(LAYERS), count(PER_LAYER));
        let Some(pack) = self.pack(setting(settings, PACK)) else { return Ok(Vec::new()) };
        pack.check(layers, per_layer, &mut faults);
        faults.into_result(())?;

        let way = [&self.home, &self.above_pick, &self.pick].map(Vec::clone);
        let note = format!("empty to the first pack of type {}", pack.name);
        let mut legs = vec![CellLeg { name: "start".to_owned(), note, waypoints: way.to_vec() }];
        for layer in 0..layers {
            for place in 0..per_layer {
                let last = layer + 1 == layers && place + 1 == per_layer;
                legs.extend(self.place(pack, layer, place, last).into_iter().flatten());
            }
        }
        Ok(legs)
    }

    /// The legs to a place and back, both counted from 0.
    fn place(&self, pack: &Pack, layer: usize, place: usize, last: bool) -> Option<[CellLeg; 2]> {
        let Place { at_mm: [x, y], above, layers } = pack.places.get(place)?;
        let down = layers.get(layer)?;
        let name = format!("{}.{}", layer + 1, place + 1);
        let z = self.deck_mm + (layer + 1) as f64 * pack.size_mm[2];
        let note = format!(
            "pack of type {} to layer {}, place {}: x {x}, y {y}, top {z} mm",
            pack.name,
            layer + 1,
            place + 1
        );
        let to = [&self.pick, &self.above_pick, above, down].map(Vec::clone).to_vec();
        let (back, back_note) = if last {
            (vec![down.clone(), above.clone(), self.home.clone()], "empty home")
        } else {
            (to.iter().rev().cloned().collect(), "empty to the next pack")
        };
        Some([
            CellLeg { name: format!("place {name}"), note, waypoints: to },
            CellLeg { name: format!("back {name}"), note: back_note.to_owned(), waypoints: back },
        ])
    }

    fn pack(&self, name: &str) -> Option<&Pack> {
        self.packs.iter().find(|pack| pack.name == name)
    }
}

impl Pack {
    /// Most layers.
    fn layers(&self) -> usize {
        self.places.first().map_or(0, |place| place.layers.len())
    }

    fn check(&self, layers: usize, per_layer: usize, faults: &mut Faults) {
        let Self { name, size_mm: [length, width, height], places } = self;
        let most = self.layers();
        if layers > most {
            let detail = format!(
                "packs of type {name} are {height} mm high: at most {most} stand on each other, not {layers}"
            );
            faults.add(format!("/{LAYERS}"), detail);
        }
        let most = places.len();
        if per_layer > most {
            let detail = format!(
                "packs of type {name} measure {length} x {width} mm: at most {most} make a layer, not {per_layer}"
            );
            faults.add(format!("/{PER_LAYER}"), detail);
        }
    }
}
