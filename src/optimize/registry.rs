//! Every optimizer the service offers.

use super::entry::OptimizerEntry;
use super::{
    aga, cfpso, coa, dual_pso, exact, ga, gold_sa, golds_pso, improved_pso, pso, pso_linear, spso,
};

/// Every optimizer the service offers, in alphabetical order.
pub static OPTIMIZERS: &[OptimizerEntry] = &[
    aga::ENTRY,
    cfpso::ENTRY,
    coa::ENTRY,
    dual_pso::ENTRY,
    exact::ENTRY,
    ga::ENTRY,
    gold_sa::ENTRY,
    golds_pso::ENTRY,
    improved_pso::ENTRY,
    pso::ENTRY,
    pso_linear::ENTRY,
    spso::ENTRY,
];

/// The deterministic method that finds the optimum of a family.
pub static EXACT: &OptimizerEntry = &exact::ENTRY;

/// The optimizer called `name`.
pub fn optimizer(name: &str) -> Option<&'static OptimizerEntry> {
    OPTIMIZERS.iter().find(|entry| entry.name == name)
}

/// All names, for messages.
pub fn optimizer_names() -> String {
    OPTIMIZERS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}
