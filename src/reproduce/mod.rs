//! The experiments of published papers, run again: their tables beside ours, a
//! verdict per figure and a reason. Nothing is tuned to match; methods run with
//! the papers' parameters where printed and their defaults otherwise, through
//! the same requests that anybody may send.

mod chen;
mod experiment;
mod han;
mod lin_yang;
mod possible;
mod report;
mod shu;
mod summary;
mod verdict;
mod zhang;

pub use experiment::ReproduceError;
pub use report::{Findings, Report, Section};
pub use verdict::Verdict;

use possible::Problem;

/// Runs of every method where the caller names no number, as Chen et al. took.
pub const DEFAULT_RUNS: u32 = 30;

/// A paper whose experiments can be run.
pub struct Paper {
    /// Name on the command line.
    pub name: &'static str,
    /// Name in the report.
    pub title: &'static str,
    /// What to cite.
    pub citation: &'static str,
    sections: fn(u32) -> Result<Vec<Section>, ReproduceError>,
    problems: fn() -> Vec<Problem>,
}

/// All papers.
pub static PAPERS: &[Paper] = &[
    Paper {
        name: "chen",
        title: "Chen et al. 2023",
        citation: chen::CITATION,
        sections: chen::sections,
        problems: chen::problems,
    },
    Paper {
        name: "han",
        title: "Han et al. 2022",
        citation: han::CITATION,
        sections: han::sections,
        problems: han::problems,
    },
    Paper {
        name: "shu",
        title: "Shu et al.",
        citation: shu::CITATION,
        sections: shu::sections,
        problems: shu::problems,
    },
    Paper {
        name: "lin_yang",
        title: "Lin and Yang",
        citation: lin_yang::CITATION,
        sections: lin_yang::sections,
        problems: lin_yang::problems,
    },
    Paper {
        name: "zhang",
        title: "Zhang et al. 2023",
        citation: zhang::CITATION,
        sections: zhang::sections,
        problems: zhang::problems,
    },
];

/// The paper called `name`.
pub fn paper(name: &str) -> Option<&'static Paper> {
    PAPERS.iter().find(|paper| paper.name == name)
}

/// Runs the experiments of `papers` and reports, a summary first. Methods with
/// random numbers run with `runs` seeds. `progress` is told what begins.
///
/// # Errors
///
/// An experiment that cannot be posed, or a plan without random numbers that
/// fails. A seed that finds nothing lawful is no error: the report counts it.
pub fn reproduce(
    papers: &[&Paper],
    runs: u32,
    progress: &dyn Fn(&str),
) -> Result<Report, ReproduceError> {
    let (mut results, mut problems) = (Vec::new(), Vec::new());
    for (at, paper) in papers.iter().enumerate() {
        progress(&format!(
            "{} of {}: {}, runs of each method: {runs}",
            at + 1,
            papers.len(),
            paper.title
        ));
        results.push((*paper, (paper.sections)(runs)?));
        problems.extend((paper.problems)());
    }
    if problems.is_empty() {
        return Ok(summary::report(results, None, None, runs));
    }
    progress("what is possible: exact plans of the same motions");
    let (possible, claim) = possible::section(&problems)?;
    Ok(summary::report(results, Some(possible), claim, runs))
}
