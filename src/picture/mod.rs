//! Pictures of results, as SVG: motion over time, what holds it back, paths among obstacles, families, the search's convergence and
//! fronts, methods compared, published figures beside ours; and pages that hold them.
//!
//! Pure: a result goes in, a text comes out. Drawing never fails and never
//! panics, whatever the numbers; what cannot be shown is left out.

mod bands;
mod beside;
mod canvas;
mod chart;
mod convergence;
mod family;
mod gaps;
mod motion;
pub mod page;
mod palette;
mod pareto;
mod path;
mod scale;
mod timeline;

pub use bands::bands;
pub use beside::{Beside, NAMES, beside};
pub use convergence::{Curve, Fitness, convergence};
pub use family::family;
pub use gaps::gaps;
pub use motion::{Section, plot};
pub use pareto::pareto;
pub use path::path;
pub use timeline::timeline;

#[cfg(test)]
mod family_tests;
#[cfg(test)]
mod tests;
