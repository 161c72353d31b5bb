//! What stands first: how many figures came to which end, in each paper.

use super::Paper;
use super::report::{Report, Section};
use super::verdict::Verdict;
use crate::picture::page::Cell;

/// Puts the summary before the papers' sections and what is possible between.
pub(super) fn report(
    results: Vec<(&Paper, Vec<Section>)>,
    possible: Section,
    claim: Option<String>,
    runs: u32,
) -> Report {
    let given: Vec<(&Paper, Vec<Verdict>)> = results
        .iter()
        .map(|(paper, sections)| (*paper, sections.iter().flat_map(Section::verdicts).collect()))
        .collect();
    let summary = section(&given, runs);
    let headline = headline(&given, claim);
    let papers = results.into_iter().flat_map(|(_, sections)| sections);
    let sections = [summary, possible].into_iter().chain(papers).collect();
    Report { title: "Published experiments, run again".to_owned(), headline, sections }
}

fn count(given: &[Verdict], verdict: Verdict) -> usize {
    given.iter().filter(|it| **it == verdict).count()
}

fn headline(given: &[(&Paper, Vec<Verdict>)], claim: Option<String>) -> String {
    let all: Vec<Verdict> = given.iter().flat_map(|(_, verdicts)| verdicts).copied().collect();
    let of = |verdict| count(&all, verdict);
    let figures = format!(
        "{} published figures checked: {} reproduce, {} more in order of magnitude. {} do not; {} \
         contradict the paper's own figures, {} break the paper's own limits, {} cannot be compared \
         because the paper leaves out what is needed.",
        all.len(),
        of(Verdict::Reproduces),
        of(Verdict::OrderOfMagnitude),
        of(Verdict::DoesNotReproduce),
        of(Verdict::PaperContradictsItself),
        of(Verdict::BreaksItsLimits),
        of(Verdict::CannotBeCompared)
    );
    match claim {
        Some(claim) => {
            format!("{figures} Within the published limits Takt plans the published motions faster: {claim}.")
        }
        None => figures,
    }
}

fn section(given: &[(&Paper, Vec<Verdict>)], runs: u32) -> Section {
    let mut summary = Section::new("Summary");
    let titles = given.iter().map(|(paper, _)| paper.title);
    let heads: Vec<&str> =
        std::iter::once("verdict").chain(titles).chain(["all", "what it means"]).collect();
    let row = |verdict: &Verdict| {
        let counts: Vec<usize> =
            given.iter().map(|(_, verdicts)| count(verdicts, *verdict)).collect();
        let all: usize = counts.iter().sum();
        let counts = counts.into_iter().chain([all]).map(|count| Cell::number(count.to_string()));
        let name = Cell::text(verdict.words());
        let name = verdict.heat().map_or(name.clone(), |heat| name.heat(heat));
        [name].into_iter().chain(counts).chain([Cell::text(verdict.meaning()).prose()]).collect()
    };
    summary.table(&heads, Verdict::ALL.iter().map(row).collect());
    summary.paragraph(format!(
        "Methods with random numbers ran {runs} times, with seeds from 0 up. Nothing was tuned to match: \
         parameters are the papers' where printed and Takt's defaults where not. Every figure comes from \
         a request that anybody may send; the sections show them."
    ));
    for (paper, _) in given {
        summary.paragraph(format!("{}: {}.", paper.title, paper.citation));
    }
    summary
}
