//! The experiments of published papers, run again: their tables beside ours, a
//! verdict per figure and a reason. Nothing is tuned to match; methods run with
//! the papers' parameters where printed and their defaults otherwise.

mod chen;
mod experiment;
mod han;
mod report;
mod verdict;

pub use experiment::ReproduceError;
pub use report::{Report, Section};
pub use verdict::Verdict;

/// Runs of every method where the caller names no number, as Chen et al. took.
pub const DEFAULT_RUNS: u32 = 30;

/// A paper whose experiments can be run.
pub struct Paper {
    /// Name on the command line.
    pub name: &'static str,
    /// What to cite.
    pub citation: &'static str,
    sections: fn(u32) -> Result<Vec<Section>, ReproduceError>,
}

/// All papers.
pub static PAPERS: &[Paper] = &[
    Paper { name: "chen", citation: chen::CITATION, sections: chen::sections },
    Paper { name: "han", citation: han::CITATION, sections: han::sections },
];

/// The paper called `name`.
pub fn paper(name: &str) -> Option<&'static Paper> {
    PAPERS.iter().find(|paper| paper.name == name)
}

/// Runs the experiments of `papers` and reports, a summary first.
pub fn reproduce(
    papers: &[&Paper],
    runs: u32,
    progress: &dyn Fn(&str),
) -> Result<Report, ReproduceError> {
    let mut sections = Vec::new();
    for paper in papers {
        progress(&format!("{}: {}", paper.name, paper.citation));
        sections.extend((paper.sections)(runs)?);
    }
    sections.insert(0, summary(papers, runs, &sections));
    Ok(Report { title: "Published experiments, run again".to_owned(), sections })
}

fn summary(papers: &[&Paper], runs: u32, sections: &[Section]) -> Section {
    let mut summary = Section::new("Summary");
    for paper in papers {
        summary.paragraph(format!("{}: {}", paper.name, paper.citation));
    }
    summary.paragraph(format!(
        "{runs} runs of every seeded method, seeds 0 and up. A figure reproduces if ours is within \
         1 % of it (means of benchmark functions: a factor of two); otherwise it is judged by order \
         of magnitude."
    ));
    let given: Vec<Verdict> = sections.iter().flat_map(Section::verdicts).copied().collect();
    let count = |verdict: &Verdict| given.iter().filter(|it| *it == verdict).count();
    let row = |verdict: &Verdict| vec![verdict.words().to_owned(), count(verdict).to_string()];
    summary.table(&["verdict", "figures"], Verdict::ALL.iter().map(row).collect());
    summary
}
