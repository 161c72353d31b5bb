//! Optimizers: `Objective`, `Optimizer`, one `minimize` loop, the registry.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The state of a search after one iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ConvergencePoint {
    /// Iterations done; 0 is the initial population.
    pub iteration: u64,
    /// Candidates evaluated so far.
    pub evaluations: u64,
    /// Seconds since the start.
    pub elapsed_s: f64,
    /// Best fitness so far; null while no candidate was feasible.
    pub best: Option<f64>,
    /// Mean fitness of the current population's feasible candidates; null if there is none.
    pub mean: Option<f64>,
}
