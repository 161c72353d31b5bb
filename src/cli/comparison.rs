//! A comparison of methods as text.

use crate::plan::{ComparisonResult, MethodResult};

use super::table::Table;

/// A table of all problems and methods, and the verdict.
pub(super) fn summary(comparison: &ComparisonResult) -> String {
    let mut table = Table::new([
        "problem",
        "method",
        ">runs",
        ">best",
        ">median",
        ">worst",
        ">gap",
        ">success",
        ">evaluations",
        ">p",
    ]);
    for problem in &comparison.problems {
        for (index, row) in problem.methods.iter().enumerate() {
            let name = if index == 0 { problem.name.clone() } else { String::new() };
            let best = problem.best_method.as_deref() == Some(&row.label);
            let label = format!("{}{}", row.label, if best { " *" } else { "" });
            let [runs, lowest, median, worst, gap, success, evaluations, p] =
                figures(row, &problem.unit);
            table.row([name, label, runs, lowest, median, worst, gap, success, evaluations, p]);
        }
        if let Some(optimum) = &problem.optimum {
            let value = figure(Some(optimum.value), &problem.unit);
            let empty = String::new;
            table.row([
                empty(),
                "(optimum)".to_owned(),
                empty(),
                value,
                empty(),
                empty(),
                empty(),
                empty(),
                empty(),
                empty(),
            ]);
        }
    }
    let seconds = comparison.planning_s;
    format!(
        "{}{}\n{} evaluations in {seconds:.3} s\n",
        table.text(),
        comparison.verdict,
        comparison.evaluations
    )
}

fn figures(row: &MethodResult, unit: &str) -> [String; 8] {
    let MethodResult { runs, best, median, worst, median_gap, success_rate, p_value, .. } = row;
    let gap = median_gap.map(|gap| match unit {
        "" => format!("{gap:.2e}"),
        _ => format!("{:.3} %", 100.0 * gap),
    });
    let needed = row.evaluations_to_success.map(|it| format!("{:.0}", it.median));
    [
        runs.to_string(),
        figure(*best, unit),
        figure(*median, unit),
        figure(*worst, unit),
        gap.unwrap_or_default(),
        format!("{:.0} %", 100.0 * success_rate),
        needed.unwrap_or_else(|| "-".to_owned()),
        p_value.map(|p| format!("{p:.1e}")).unwrap_or_default(),
    ]
}

fn figure(value: Option<f64>, unit: &str) -> String {
    match (value, unit) {
        (None, _) => "-".to_owned(),
        (Some(value), "") => format!("{value:.3e}"),
        (Some(value), unit) => format!("{value:.4} {unit}"),
    }
}
