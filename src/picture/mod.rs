//! Pictures of results, as SVG: motion over time, the search's convergence and
//! fronts.
//!
//! Pure: a result goes in, a text comes out. Drawing never fails and never
//! panics, whatever the numbers; what cannot be shown is left out.

mod canvas;
mod chart;
mod convergence;
mod motion;
mod palette;
mod pareto;
mod scale;

pub use convergence::{Curve, convergence};
pub use motion::{Section, plot};
pub use pareto::pareto;

#[cfg(test)]
mod tests;
