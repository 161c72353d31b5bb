//! What stands first: how many figures came to which end in each paper, and what
//! came of each section in a sentence; and what stands last, the papers.

use super::Paper;
use super::report::{Report, Section};
use super::verdict::Verdict;
use crate::picture::page::Cell;

/// A paper and the verdicts on its figures.
type Given<'a> = (&'a Paper, Vec<Verdict>);

/// Puts the summary and what is possible, where motions were planned, before the
/// papers' sections.
pub(super) fn report(
    results: Vec<(&Paper, Vec<Section>)>,
    possible: Option<Section>,
    claim: Option<String>,
    runs: u32,
) -> Report {
    let given: Vec<Given<'_>> = results
        .iter()
        .map(|(paper, sections)| (*paper, sections.iter().flat_map(Section::verdicts).collect()))
        .collect();
    let mut summary = Section::new("Summary");
    count_table(&mut summary, &given);
    summary.paragraph(format!(
        "Runs of each method with random numbers: {runs}, with seeds that are fixed here, so that \
         the report repeats. Nothing was tuned to match: parameters are the papers' where printed \
         and Takt's defaults where not. Every figure comes from a request that anybody may send; \
         the sections show them."
    ));
    let lessons = results.iter().flat_map(|(_, sections)| sections).filter_map(Section::lesson);
    let row =
        |(heading, lesson): (&str, &str)| vec![Cell::text(heading), Cell::text(lesson).prose()];
    summary.rows(&["section", "what came of it"], lessons.map(row).collect());
    let headline = [counts(&given)].into_iter().chain(claim).collect();
    let sources = sources(&given);
    let papers = results.into_iter().flat_map(|(_, sections)| sections);
    let sections = [summary].into_iter().chain(possible).chain(papers).chain([sources]).collect();
    Report { title: "Published experiments, run again".to_owned(), headline, sections }
}

fn count(given: &[Verdict], verdict: Verdict) -> usize {
    given.iter().filter(|it| **it == verdict).count()
}

fn counts(given: &[Given<'_>]) -> String {
    let all: Vec<Verdict> = given.iter().flat_map(|(_, verdicts)| verdicts).copied().collect();
    let of = |verdict| count(&all, verdict);
    format!(
        "{} published figures checked: {} reproduce, {} more in order of magnitude, {} do not. {} \
         break the paper's own limits, {} contradict its own figures. {} could only be added up \
         and {} cannot be compared, because the papers leave out what is needed.",
        all.len(),
        of(Verdict::Reproduces),
        of(Verdict::OrderOfMagnitude),
        of(Verdict::DoesNotReproduce),
        of(Verdict::BreaksItsLimits),
        of(Verdict::PaperContradictsItself),
        of(Verdict::AddsUp),
        of(Verdict::CannotBeCompared)
    )
}

fn count_table(summary: &mut Section, given: &[Given<'_>]) {
    let titles = given.iter().map(|(paper, _)| paper.title);
    let heads: Vec<&str> =
        ["verdict", "all"].into_iter().chain(titles).chain(["what it means"]).collect();
    let row = |verdict: &Verdict| {
        let counts: Vec<usize> =
            given.iter().map(|(_, verdicts)| count(verdicts, *verdict)).collect();
        let all: usize = counts.iter().sum();
        let counts = [all].into_iter().chain(counts).map(|count| Cell::number(count.to_string()));
        let name = Cell::text(verdict.words());
        let name = verdict.heat().map_or(name.clone(), |heat| name.heat(heat));
        [name].into_iter().chain(counts).chain([Cell::text(verdict.meaning()).prose()]).collect()
    };
    summary.rows(&heads, Verdict::ALL.iter().map(row).collect());
}

fn sources(given: &[Given<'_>]) -> Section {
    let mut sources = Section::new("Papers");
    for (paper, _) in given {
        sources.paragraph(format!("{}: {}.", paper.title, paper.citation));
    }
    sources
}
