//! Every planner the service offers.

use super::entry::PlannerEntry;
use super::solve::{PathSolution, Search};
use super::{
    ValidityChecker, bi_apf_rrt_star, informed_rrt_star, ipq_rrt_star_connect, p_rrt_star,
    pq_rrt_star, quick_rrt_star, rrt, rrt_connect, rrt_star, rrt_star_smart,
};
use crate::fault::parameter::Settings;

/// Lists entries, and lets the one that was chosen search: planners are generic
/// over the checker, so no table can hold them.
macro_rules! planners {
    ($($module:ident)*) => {
        /// Every planner the service offers, in alphabetical order.
        pub static PLANNERS: &[PlannerEntry] = &[$($module::ENTRY),*];

        /// Runs the search with the planner of `entry`.
        pub(super) fn run<C: ValidityChecker>(
            entry: &PlannerEntry,
            settings: &Settings,
            search: Search<'_, C>,
        ) -> PathSolution {
            let problem = search.world.problem;
            match entry.name {
                $(name if name == $module::ENTRY.name => {
                    search.run($module::build(settings, problem))
                })*
                name => unreachable!("{name} is no planner of the registry"),
            }
        }
    };
}

planners! {
    bi_apf_rrt_star
    informed_rrt_star
    ipq_rrt_star_connect
    p_rrt_star
    pq_rrt_star
    quick_rrt_star
    rrt
    rrt_connect
    rrt_star
    rrt_star_smart
}

/// The planner called `name`.
pub fn planner(name: &str) -> Option<&'static PlannerEntry> {
    PLANNERS.iter().find(|entry| entry.name == name)
}

/// The planner that `auto` stands for: what measures best (`docs/PLANNING.md`).
pub fn auto(dimension: usize) -> &'static PlannerEntry {
    if dimension <= AUTO_INFORMED { &informed_rrt_star::ENTRY } else { &rrt_connect::ENTRY }
}

/// Most coordinates with which a short path is searched instead of a first one.
const AUTO_INFORMED: usize = 4;

/// All names, for messages.
pub fn planner_names() -> String {
    PLANNERS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}
