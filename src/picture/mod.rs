//! Pictures of results, as SVG: motion over time and the search's convergence.
//!
//! Pure: a result goes in, a text comes out. Drawing never fails and never
//! panics, whatever the numbers; what cannot be shown is left out.

mod canvas;
mod chart;
mod convergence;
mod motion;
mod palette;
mod scale;

pub use convergence::{Curve, convergence};
pub use motion::{Section, plot};

#[cfg(test)]
mod tests;
