//! Every optimizer the service offers.

use super::entry::OptimizerEntry;
use super::{aga, coa, dual_pso, exact, ga, improved_pso, pso, pso_linear};

/// Every optimizer the service offers, in alphabetical order.
pub static OPTIMIZERS: &[OptimizerEntry] = &[
    aga::ENTRY,
    coa::ENTRY,
    dual_pso::ENTRY,
    exact::ENTRY,
    ga::ENTRY,
    improved_pso::ENTRY,
    pso::ENTRY,
    pso_linear::ENTRY,
];

/// The optimizer called `name`.
pub fn optimizer(name: &str) -> Option<&'static OptimizerEntry> {
    OPTIMIZERS.iter().find(|entry| entry.name == name)
}

/// All names, for messages.
pub fn optimizer_names() -> String {
    OPTIMIZERS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}
