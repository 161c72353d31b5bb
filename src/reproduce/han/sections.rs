//! Tables 6 and 7: what the other sections and the parts are said to save.

use super::data::{COMPOSED, SAVED, TABLE_4, TABLE_6, TABLE_7};
use super::{FAMILY, waypoints};
use crate::picture::page::Cell;
use crate::reproduce::experiment::{ReproduceError, largest, peaks};
use crate::reproduce::report::{Findings, Section};
use crate::reproduce::verdict::Verdict;

/// Column of a method in Table 6.
const STANDARD: usize = 1;
const IMPROVED: usize = 4;

/// Seconds of standard and improved PSO, saved, and saved in percent.
fn totals(sections: &[[[f64; 3]; 2]]) -> [f64; 4] {
    let total = |column: usize| sections.iter().flat_map(|row| row[column]).sum::<f64>();
    let [standard, improved] = [0, 1].map(total);
    let saved = standard - improved;
    [standard, improved, saved, 100.0 * saved / standard]
}

pub(super) fn table_6() -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., Table 6: all sections");
    section.paragraph(
        "Section AB stands in Table 5 too, so that both can be compared. Of the other sections \
         the paper prints times, but neither waypoints nor limits.",
    );
    let printed = TABLE_6.map(|(_, methods)| [methods[STANDARD], methods[IMPROVED]]);
    let corrected = [&[COMPOSED][..], &printed[1..]].concat();
    let row = |what: &str, rows: &[[[f64; 3]; 2]]| {
        let figures = totals(rows).map(|value| Cell::number(format!("{value:.2}")));
        [Cell::text(what)].into_iter().chain(figures).collect()
    };
    let rows = vec![row("as printed", &printed), row("row AB from Table 5", &corrected)];
    section.matrix(&["totals", "standard [s]", "improved [s]", "saved [s]", "saved [%]"], rows);
    let ([_, _, seconds, share], (_, _, published)) = (totals(&corrected), SAVED);
    section.learn(format!(
        "Row AB holds the times of Table 5 dealt out in the wrong order. Put right, the improved \
         method saves {seconds:.2} s or {share:.1} %, not {published} %."
    ));
    let mut findings = Findings::new(&["figure", "paper", "ours"]);
    add_row_ab(&mut findings, &printed[0])?;
    add_savings(&mut findings, &printed, totals(&corrected));
    for (name, methods) in &TABLE_6[1..] {
        let total: f64 = methods[IMPROVED].iter().sum();
        findings.add(
            vec![format!("{name}, improved PSO, total, s"), format!("{total:.2}"), "-".to_owned()],
            Verdict::CannotBeCompared,
            "Waypoints and limits of this section are not printed.",
        );
    }
    section.findings(findings);
    Ok(section)
}

fn add_row_ab(findings: &mut Findings, printed: &[[f64; 3]; 2]) -> Result<(), ReproduceError> {
    let names = ["AB, standard PSO, total, s", "AB, improved PSO, total, s"];
    for ((name, printed), table_5) in names.into_iter().zip(printed).zip(COMPOSED) {
        let [printed, table_5] = [*printed, table_5].map(|times| times.iter().sum::<f64>());
        findings.add(
            vec![name.to_owned(), format!("{printed:.2}"), format!("{table_5:.2}")],
            Verdict::PaperContradictsItself,
            "Ours is Table 5's row \"optimal\". The same six times were dealt to the two methods \
             row by row instead of column by column.",
        );
    }
    let found = peaks(FAMILY, &waypoints(), &printed[1])?;
    let [speed, acceleration, jerk] = [0, 1, 2].map(|order| largest(&found, order));
    let [most, hardest, sharpest] = TABLE_4.map(|limits| limits[5]);
    findings.add(
        vec![
            "AB, improved PSO, peak speed, rad/s".to_owned(),
            most.to_string(),
            format!("{speed:.3}"),
        ],
        Verdict::BreaksItsLimits,
        format!(
            "At the times as printed joint 6 reaches {speed:.3} rad/s, {acceleration:.3} rad/s^2 \
             and {jerk:.2} rad/s^3; Table 4 allows {most}, {hardest} and {sharpest}."
        ),
    );
    Ok(())
}

/// The savings per section and together.
fn add_savings(findings: &mut Findings, printed: &[[[f64; 3]; 2]], corrected: [f64; 4]) {
    let (sections, total, percent) = SAVED;
    for (((name, _), rows), published) in TABLE_6.iter().zip(printed).zip(sections).skip(1) {
        let [_, _, saved, _] = totals(&[*rows]);
        findings.add(
            vec![format!("{name}, saved, s"), published.to_string(), format!("{saved:.2}")],
            Verdict::adding_up(saved - published),
            "Follows from the printed times; they themselves cannot be checked.",
        );
    }
    let [_, _, seconds, share] = corrected;
    let [_, _, ab, _] = totals(&[COMPOSED]);
    let claims = [
        ("AB, saved, s", sections[0], ab),
        ("All sections, saved, s", total, seconds),
        ("All sections, saved, %", percent, share),
    ];
    for (name, published, ours) in claims {
        findings.add(
            vec![name.to_owned(), published.to_string(), format!("{ours:.2}")],
            Verdict::PaperContradictsItself,
            "Ours has row AB as Table 5 has it.",
        );
    }
}

pub(super) fn table_7() -> Section {
    let mut section = Section::new("Han et al., Table 7: parts");
    section.paragraph(
        "Measured times per part and section. The text names five parts, the table four. More \
         than their sums cannot be checked, since the paths are not printed.",
    );
    let methods = ["no optimisation", "standard PSO", "improved PSO"];
    let mut findings = Findings::new(&["total of", "paper [s]", "sum of its column [s]"]);
    for (part, rows) in &TABLE_7 {
        let [parts @ .., total] = rows;
        for (at, method) in methods.into_iter().enumerate() {
            let sum: f64 = parts.iter().map(|row| row[at]).sum();
            let (verdict, off) = (Verdict::adding_up(sum - total[at]), (sum - total[at]).abs());
            let reason = match verdict {
                Verdict::AddsUp => "The total is the sum.".to_owned(),
                _ => format!("Off by {off:.2} s."),
            };
            let cells =
                vec![format!("{part}, {method}"), total[at].to_string(), format!("{sum:.2}")];
            findings.add(cells, verdict, reason);
        }
    }
    section.findings(findings);
    section
}
