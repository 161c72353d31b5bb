//! Chen, Zhang and Yi 2023: Table 3 (functions) and Table 5 (a woodworking arm).

mod data;
mod functions;
mod times;

use super::experiment::ReproduceError;
use super::possible::Problem;
use super::report::Section;

pub(super) const CITATION: &str = "Chen, Zhang, Yi: Time-optimal trajectory planning for \
                                   woodworking manipulators using an improved PSO algorithm. \
                                   Applied Sciences 13 (2023) 10482, doi:10.3390/app131810482";

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    let mut sections = functions::sections(runs)?;
    sections.extend(times::sections(runs)?);
    Ok(sections)
}

/// The paper's motion, for what is possible.
pub(super) fn problems() -> Vec<Problem> {
    vec![Problem {
        name: "Chen et al.".to_owned(),
        published: Some(data::COMPOSED.iter().sum()),
        family: "3-5-3",
        jerk_limited: false,
        scenario: "wood",
    }]
}
