//! What the demonstration found, beside what was published.

use std::path::Path;

use crate::cli::table::Table;
use crate::plan::{LegResult, ProgramResult};

/// Times of Han et al. 2022 with their improved swarm, s: the segments of
/// each section. Section AB is that of their table 5, whose numbers their
/// table 6 mixes up.
const PUBLISHED: [(&str, [f64; 3]); 4] = [
    ("AB", [2.79, 3.31, 1.79]),
    ("BC", [4.1, 1.63, 5.8]),
    ("CD", [2.46, 4.89, 3.3]),
    ("DE", [2.82, 1.28, 1.05]),
];

/// The only section whose waypoints were published.
const COMPARABLE: &str = "AB";

/// The table with its footnotes, where the files are, and what to try next.
pub(super) fn report(results: &[ProgramResult; 3], out: &Path) -> String {
    format!("\n{}\n{}{}", table(results).text(), notes(results), next(&out.display().to_string()))
}

fn table(results: &[ProgramResult; 3]) -> Table {
    let [same_method, same_curves, best] = results;
    let mut table = Table::new([
        "section",
        "curves",
        ">published",
        ">same method",
        ">their optimum",
        ">quintic optimum",
        ">largest peak",
    ]);
    let legs = same_method.legs.iter().zip(&same_curves.legs).zip(&best.legs);
    for ((method, curves), best) in legs {
        let worst = [method, curves, best].map(|leg| leg.result.certificate.worst_ratio);
        table.row([
            method.name.clone(),
            method.result.interpolation.clone(),
            published(&method.name).map(published_text(&method.name)).unwrap_or_default(),
            seconds(method.result.duration),
            seconds(curves.result.duration),
            seconds(best.result.duration),
            percent(worst.into_iter().fold(0.0, f64::max)),
        ]);
    }
    let worst = results.iter().map(|result| result.worst_ratio).fold(0.0, f64::max);
    table.row([
        "together".to_owned(),
        String::new(),
        String::new(),
        seconds(same_method.duration),
        seconds(same_curves.duration),
        seconds(best.duration),
        percent(worst),
    ]);
    table
}

fn published(section: &str) -> Option<f64> {
    let (_, segments) = PUBLISHED.iter().find(|(name, _)| *name == section)?;
    Some(segments.iter().sum())
}

/// Marks what must not be compared.
fn published_text(section: &str) -> impl Fn(f64) -> String + '_ {
    move |time| format!("{time:.2} s{}", if section == COMPARABLE { "  " } else { " *" })
}

fn seconds(time: f64) -> String {
    format!("{time:.4} s")
}

fn percent(ratio: f64) -> String {
    format!("{:.2} %", 100.0 * ratio)
}

fn notes(results: &[ProgramResult; 3]) -> String {
    let mut text = String::from(
        "published        Han et al. 2022, doi 10.3390/a15080269, improved PSO; AB as in their table 5\n\
         same method      improved_pso on the same curves, each joint alone (clock per_joint)\n\
         their optimum    the shortest motion with the same curves, found by `exact`\n\
         quintic optimum  the shortest C4 quintic spline, found by `exact`\n\
         largest peak     of all three, against its limit, over continuous time\n\
         * only AB's waypoints were published. The other sections pass substitutes, some of them in\n  \
         more than the three segments that quintic_han takes: their times cannot be compared.\n",
    );
    if let Some(saved) = saved(results) {
        text.push_str(&saved);
    }
    text
}

/// What the comparable section gains.
fn saved(results: &[ProgramResult; 3]) -> Option<String> {
    let time = |result: &ProgramResult| -> Option<f64> {
        let is_comparable = |leg: &&LegResult| leg.name == COMPARABLE;
        Some(result.legs.iter().find(is_comparable)?.result.duration)
    };
    let published = published(COMPARABLE)?;
    let best = time(&results[2])?;
    let lawful = results.iter().all(|result| result.lawful);
    let certified =
        if lawful { "all trajectories are certified lawful" } else { "NOT all are lawful" };
    Some(format!(
        "\n{COMPARABLE}: {published:.2} s published, {best:.4} s possible within the same limits, \
         {:.1} % less;\n{certified}.\n",
        100.0 * (1.0 - best / published),
    ))
}

fn next(out: &str) -> String {
    let verify = format!("takt verify {out}/best/result.json");
    let change = "takt scenarios mcb-ab > my.json";
    let (methods, serve) = ("takt methods", "takt serve");
    let width = verify.chars().count().max(change.len());
    format!(
        "\nIn {out}/as-published, {out}/same-curves and {out}/best, as the server delivered them:\n  \
         plot.svg, convergence.svg, trajectory.csv (250 Hz), trajectory.json, certificate.json,\n  \
         metrics.json, result.json, request.json\n\
         \nTry next:\n  \
         {verify:<width$}  certify once more what was delivered\n  \
         {change:<width$}  a request to change, then takt plan my.json\n  \
         {methods:<width$}  interpolations and optimizers\n  \
         {serve:<width$}  then http://127.0.0.1:8080/docs\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_times_are_the_corrected_totals() {
        for (section, total) in [("AB", "7.89"), ("BC", "11.53"), ("CD", "10.65"), ("DE", "5.15")] {
            assert_eq!(format!("{:.2}", published(section).unwrap()), total);
        }
        assert_eq!(published("EF"), None);
        assert_eq!(published_text("AB")(7.89), "7.89 s  ");
        assert_eq!(published_text("BC")(11.53), "11.53 s *");
    }
}
