//! Smoother paths from planned ones, checked again exactly.

use serde::Serialize;
use utoipa::ToSchema;

use super::bezier::{self, BezierPiece};
use super::space::PointSpace;
use crate::budget::Budget;
use crate::fault::parameter::{Parameter, ParameterInfo, Settings, integer};
use crate::planner::{length, shortcut};

/// A way to smooth a path.
#[derive(Debug)]
pub struct SmoothingEntry {
    /// Registry name.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it does and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What can be set.
    pub parameters: &'static [Parameter],
    apply: Apply,
}

/// Smooths a path; the seed feeds its random stream.
type Apply = fn(&Settings, &mut PointSpace, &[Vec<f64>], u64, &Budget) -> Option<Smoothed>;

/// A smoothed path.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// Corners of a polyline that is free; with a curve, points of it.
    pub path: Vec<Vec<f64>>,
    /// The curve, piece by piece, if it is one.
    pub curve: Option<Vec<BezierPiece>>,
    /// Its length.
    pub length: f64,
}

/// `attempts`, of every smoothing that takes shortcuts.
pub(in crate::plan) const ATTEMPTS: Parameter = integer(
    "attempts",
    "random shortcuts that may fail in a row before it ends; default 100",
    100.0,
    0.0,
    1e6,
);

/// Every smoothing the service offers, in alphabetical order.
pub static SMOOTHINGS: &[SmoothingEntry] = &[
    SmoothingEntry {
        name: "bezier",
        title: "Segmented Bezier curve",
        description: "Every corner is replaced by a Bezier curve that touches both of its sides. \
                      Where that is not free, a shorter one is tried, and at last the corner stays.",
        source: "Zhang et al. 2023, doi:10.3390/act12120459",
        parameters: bezier::PARAMETERS,
        apply: bezier::smooth,
    },
    SmoothingEntry {
        name: "none",
        title: "None",
        description: "The path stays as it was planned.",
        source: "",
        parameters: &[],
        apply: |_, _, _, _, _| None,
    },
    SmoothingEntry {
        name: "shortcut",
        title: "Shortcuts",
        description: "Corners are left out or cut where the straight way is free. The path stays a \
                      polyline.",
        source: "Geraerts and Overmars 2007, doi:10.1177/0278364907079280",
        parameters: &[ATTEMPTS],
        apply: |settings, space, path, seed, budget| {
            let mut path = path.to_vec();
            shortcut(&mut path, space, settings.integer("attempts"), seed, budget);
            Some(Smoothed { length: length(&path), path, curve: None })
        },
    },
];

/// The smoothing called `name`.
pub fn smoothing(name: &str) -> Option<&'static SmoothingEntry> {
    SMOOTHINGS.iter().find(|entry| entry.name == name)
}

/// All names, for messages.
pub fn smoothing_names() -> String {
    SMOOTHINGS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}

impl SmoothingEntry {
    /// Smooths a free path; none if it stays as it is.
    pub fn apply(
        &self,
        settings: &Settings,
        space: &mut PointSpace,
        path: &[Vec<f64>],
        seed: u64,
        budget: &Budget,
    ) -> Option<Smoothed> {
        (self.apply)(settings, space, path, seed, budget)
    }

    /// The entry as users see it.
    pub fn info(&self) -> SmoothingInfo {
        SmoothingInfo {
            name: self.name,
            title: self.title,
            description: self.description,
            source: self.source,
            parameters: self.parameters.iter().map(Parameter::info).collect(),
        }
    }
}

/// A way to smooth a path, as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct SmoothingInfo {
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
