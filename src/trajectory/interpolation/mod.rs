//! Interpolations: how a curve runs through the waypoints. One file each.

mod bspline;
mod bspline_uniform;
mod cubic;
mod cubic_zero_acceleration;
mod hermite;
mod jerk_limited;
mod moments;
mod polynomial_353;
mod polynomial_434;
mod quintic;
mod quintic_han;
mod trapezoidal;

use serde::Serialize;
use utoipa::ToSchema;

use super::kernel::Kernel;

/// An interpolation the service offers.
pub struct Interpolation {
    /// Registry name.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it is and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Highest derivative that is continuous at inner waypoints.
    pub continuity: u32,
    /// Fewest segments it takes.
    pub min_segments: usize,
    /// Most segments it takes; none if any number.
    pub max_segments: Option<usize>,
    /// False if acceleration jumps somewhere, which no jerk limit allows.
    pub bounded_jerk: bool,
    /// False if velocity may jump at waypoints: limits are then kept inside the
    /// segments only, plans succeed, and their certificates report the jumps.
    pub executable: bool,
    /// How its durations are found.
    pub timing: Timing,
}

/// How an interpolation's durations are found.
pub enum Timing {
    /// An optimizer searches the segment durations.
    Search(&'static dyn Kernel),
    /// The best profile between two waypoints at rest is known.
    ClosedForm(fn(&[f64], &[ProfileLimits]) -> Profile),
    /// No family of curves: the fastest of all motions, see [`super::jerk_limited`].
    Free,
}

impl Timing {
    /// Where no optimizer searches the durations, in words why not.
    pub fn own(&self) -> Option<&'static str> {
        match self {
            Self::Search(_) => None,
            Self::ClosedForm(_) => Some("has closed-form durations"),
            Self::Free => Some("finds its durations itself"),
        }
    }
}

/// The limits a profile keeps; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileLimits {
    /// rad/s or m/s.
    pub velocity: f64,
    /// rad/s² or m/s².
    pub acceleration: f64,
}

/// A motion from 0 to 1 at rest at both ends, as polynomial pieces.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Duration, s, and coefficients in ascending powers of local time.
    pub pieces: Vec<(f64, Vec<f64>)>,
}

/// Every interpolation the service offers, in alphabetical order.
pub static INTERPOLATIONS: &[Interpolation] = &[
    polynomial_353::ENTRY,
    polynomial_434::ENTRY,
    bspline::ENTRY,
    bspline_uniform::ENTRY,
    cubic::ENTRY,
    cubic_zero_acceleration::ENTRY,
    jerk_limited::ENTRY,
    quintic::ENTRY,
    quintic_han::ENTRY,
    trapezoidal::ENTRY,
];

/// The interpolation called `name`.
pub fn interpolation(name: &str) -> Option<&'static Interpolation> {
    INTERPOLATIONS.iter().find(|entry| entry.name == name)
}

/// All names, for messages.
pub fn interpolation_names() -> String {
    INTERPOLATIONS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}

/// A registry entry as users see it.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct InterpolationInfo {
    /// Name to use in requests.
    pub name: &'static str,
    /// Name in words.
    pub title: &'static str,
    /// What it is and what to mind.
    pub description: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Highest derivative that is continuous at inner waypoints.
    pub continuity: u32,
    /// Fewest segments it takes.
    pub min_segments: usize,
    /// Most segments it takes; null if any number.
    pub max_segments: Option<usize>,
    /// False if acceleration jumps somewhere: then no jerk limit may be set.
    pub bounded_jerk: bool,
    /// False if no robot can follow the curve, because velocity may jump at
    /// waypoints. Plans keep the limits inside the segments and succeed; where
    /// velocity jumps against an acceleration limit, the certificate is not
    /// lawful and tells joint, time and size of the jump.
    pub executable: bool,
    /// True if an optimizer searches its durations.
    pub uses_optimizer: bool,
}

impl Interpolation {
    /// The entry as users see it.
    pub fn info(&self) -> InterpolationInfo {
        InterpolationInfo {
            name: self.name,
            title: self.title,
            description: self.description,
            source: self.source,
            continuity: self.continuity,
            min_segments: self.min_segments,
            max_segments: self.max_segments,
            bounded_jerk: self.bounded_jerk,
            executable: self.executable,
            uses_optimizer: self.timing.own().is_none(),
        }
    }
}
