//! Table 3: five methods on eight functions, and what is left of it once the
//! optimum is moved.

use serde_json::{Value, json};

use super::data::{METHODS, RUNS, TABLE_3};
use crate::optimize::functions::{self, Function};
use crate::picture::bands;
use crate::picture::page::Cell;
use crate::plan::{ComparisonResult, MethodResult, ProblemResult};
use crate::reproduce::experiment::{ReproduceError, compare};
use crate::reproduce::report::{Findings, Section};
use crate::reproduce::verdict::Verdict;

/// Variables of each function.
const DIMENSION: u32 = 30;

/// What double precision leaves of zero in sums of some thirty terms.
const ROUNDING: f64 = 1e-14;

/// Means between the first, shown best, and the last, shown worst.
const HEAT: [f64; 2] = [1e-8, 1e2];

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    let (printed, moved) = (request(runs, false), request(runs, true));
    let [as_printed, shifted] = [compare(&printed)?, compare(&moved)?];
    Ok(vec![table_3(&as_printed, printed), impossible(), origin_bias(&as_printed, &shifted, moved)])
}

fn request(runs: u32, shifted: bool) -> Value {
    let optimizers: Vec<&str> = METHODS.iter().map(|(_, name)| *name).collect();
    json!({ "task": {
        "type": "benchmark", "dimension": DIMENSION, "population": 30, "iterations": 1000,
        "runs": runs, "optimizers": optimizers, "shifted": shifted,
    } })
}

fn mean(row: &MethodResult) -> f64 {
    row.mean.unwrap_or(f64::NAN)
}

/// Three digits; powers of ten where there would be many zeros.
fn number(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        value if !(1e-2..1e4).contains(&value) => format!("{value:.2e}"),
        value if value < 1.0 => format!("{value:.4}"),
        value if value < 100.0 => format!("{value:.2}"),
        value => format!("{value:.0}"),
    }
}

/// Every entry of Table 3 beside ours, with its function's index.
fn entries(
    result: &ComparisonResult,
) -> impl Iterator<Item = (usize, &ProblemResult, &MethodResult, &'static str, f64)> {
    result.problems.iter().zip(TABLE_3).enumerate().flat_map(|(index, (problem, published))| {
        let rows = problem.methods.iter().zip(METHODS).zip(published);
        rows.map(move |((row, (method, _)), [mean, ..])| (index, problem, row, method, mean))
    })
}

fn table_3(result: &ComparisonResult, request: Value) -> Section {
    let mut section = Section::new("Chen et al., Table 3: eight test functions");
    section.paragraph(
        "Mathematical functions of 30 variables whose least value, 0, is known; a method is the \
         better the nearer it comes. 30 candidates, 1000 iterations. A published mean reproduces \
         if ours is within a factor of two: means of searches that fall over many orders of \
         magnitude are no sharper. Each cell holds the paper's mean, then ours, in the colour of \
         the verdict on it.",
    );
    section.matrix(&heads(), result.problems.iter().enumerate().map(matrix_row).collect());
    let heads = ["function, method", "paper, mean", "ours, mean", "ours, quartiles"];
    let mut findings =
        Findings::new(&heads).folded("All 40 figures of Table 3 one by one, with reasons");
    for (index, problem, row, method, published) in entries(result) {
        let (verdict, reason) = judge(index, method, published, row);
        let quartiles = row.lower_quartile.zip(row.upper_quartile);
        let spread =
            quartiles.map(|(lower, upper)| format!("{} to {}", number(lower), number(upper)));
        let figures = [number(published), number(mean(row)), spread.unwrap_or_default()];
        let name = format!("{} {method}", problem.name.to_uppercase());
        findings.add([name].into_iter().chain(figures).collect(), verdict, reason);
    }
    let count = |wanted: Verdict| findings.verdicts().filter(|it| *it == wanted).count();
    section.learn(format!(
        "Of 40 means {} come out again within a factor of two and {} more within a factor of ten.",
        count(Verdict::Reproduces),
        count(Verdict::OrderOfMagnitude)
    ));
    section.findings(findings);
    if let Some(problem) = result.problems.first() {
        let caption = "F1, the sum of squares, with its optimum at the origin: how the best value \
                       of each method fell. Lines are medians over the runs, areas reach from \
                       quartile to quartile.";
        section.figure(bands(problem), caption);
    }
    section.request("The request behind this table: save it and run `takt plan FILE`", request);
    section
}

fn heads() -> Vec<&'static str> {
    std::iter::once("function").chain(METHODS.iter().map(|(method, _)| *method)).collect()
}

fn matrix_row((index, problem): (usize, &ProblemResult)) -> Vec<Cell> {
    let cells = problem.methods.iter().zip(METHODS).enumerate().map(|(at, (row, (method, _)))| {
        let published = TABLE_3[index][at][0];
        let (verdict, _) = judge(index, method, published, row);
        let cell = Cell::number(format!("{} / {}", number(published), number(mean(row))));
        verdict.heat().map_or(cell.clone(), |heat| cell.heat(heat))
    });
    [Cell::text(problem.name.to_uppercase())].into_iter().chain(cells).collect()
}

/// The largest value of F5, `sum i x^4` and less than 1 of noise, within its range.
fn largest_of_f5(function: &Function) -> f64 {
    let n = f64::from(DIMENSION);
    0.5 * n * (n + 1.0) * function.range.powi(4) + 1.0
}

fn judge(index: usize, method: &str, published: f64, row: &MethodResult) -> (Verdict, String) {
    let bound = functions::FUNCTIONS.get(index).filter(|it| it.name == "f5").map(largest_of_f5);
    if let Some(bound) = bound.filter(|bound| published > *bound) {
        let reason = format!(
            "Nowhere within the printed range is the function above {bound:.1}: so particles left \
             it, or the range was another."
        );
        return (Verdict::PaperContradictsItself, reason);
    }
    let ours = mean(row);
    let verdict = Verdict::of(published, ours, 1.0);
    let median = row.median.unwrap_or(f64::NAN);
    let reason = match verdict {
        Verdict::Reproduces if published == 0.0 => "Exactly zero in both.",
        Verdict::Reproduces => "Within a factor of two.",
        _ if published.max(ours) < 1e-30 => {
            "Both are zero for every purpose; the printed digits tell when a search was stopped."
        }
        _ if published.max(ours) < ROUNDING => "Both are zero but for rounding in the last digits.",
        _ if Verdict::of(published, median, 1.0) == Verdict::Reproduces => {
            "In the median ours agrees within a factor of two; runs that end far from there make \
             our mean."
        }
        _ => unprinted(method),
    };
    (verdict, reason.to_owned())
}

/// What the paper leaves out about a method, and what stands in for it.
fn unprinted(method: &str) -> &'static str {
    match method {
        "PSO" => {
            "Inertia, step limit and treatment of the range are not printed; ours are w = 1, c = \
             2 and steps of at most 10 % of the range."
        }
        "CFPSO" => "Its factors are not printed; ours are Clerc and Kennedy's, 0.7298 and 2.05.",
        "SPSO" => "The course of its inertia is not printed; ours falls from 0.9 to 0.4.",
        "Gold-SA" => {
            "Not printed is whether random numbers are coupled; ours follows the method's \
             published code."
        }
        _ => {
            "lambda, c1, c2 and the range of w are not printed; ours are 0.5, 2, 2 and 0.9 to \
             0.4."
        }
    }
}

/// Standard deviations that no thirty runs with the printed mean and best can have.
fn impossible() -> Section {
    let mut section = Section::new("Chen et al., Table 3: figures that cannot be");
    section.paragraph(
        "Of n values with mean m, none below b, the sample standard deviation is at most (m - b) \
         times the root of n: all values but one are then at b. Table 3 states mean, best and \
         deviation of 30 runs, so that every entry can be checked.",
    );
    let mut findings = Findings::new(&["entry", "printed", "largest possible"]);
    for (index, row) in TABLE_3.iter().enumerate() {
        for ((method, _), [mean, best, deviation]) in METHODS.iter().zip(row) {
            let largest = (mean - best) * f64::from(RUNS).sqrt();
            if *deviation > largest {
                let name = format!("F{} {method}, standard deviation", index + 1);
                let reason = "Probably a slipped decimal point.";
                let cells = vec![name, deviation.to_string(), format!("{largest:.4}")];
                findings.add(cells, Verdict::PaperContradictsItself, reason);
            }
        }
    }
    let [.., [_, best, _]] = TABLE_3[7];
    let cells = vec!["F8 GoldS-PSO, best".to_owned(), number(best), "-".to_owned()];
    let reason = "The text calls it slightly worse than Gold-SA's 1.06e-7: a digit too many in \
                  the exponent.";
    findings.add(cells, Verdict::PaperContradictsItself, reason);
    section.findings(findings);
    section
}

/// The functions on which the last method's mean is not the least, as `F1, F2`.
fn lost(means: impl Iterator<Item = Vec<f64>>) -> Vec<String> {
    let wins =
        |row: &Vec<f64>| row.last().is_some_and(|last| row.iter().all(|other| last <= other));
    let lost = means.enumerate().filter(|(_, row)| !wins(row));
    lost.map(|(index, _)| format!("F{}", index + 1)).collect()
}

fn means(result: &ComparisonResult) -> impl Iterator<Item = Vec<f64>> + '_ {
    result.problems.iter().map(|problem| problem.methods.iter().map(mean).collect())
}

fn origin_bias(printed: &ComparisonResult, shifted: &ComparisonResult, request: Value) -> Section {
    let mut section = Section::new("Chen et al., the same functions with the optimum moved");
    section.paragraph(
        "All eight functions have their optimum at or near the origin, the middle of every range. \
         SPSO, Gold-SA and GoldS-PSO multiply the position itself by numbers below 1, so they are \
         drawn to the origin whatever they minimise: they find such an optimum without searching. \
         Below, the optimum is moved by 20 to 40 % of the range and everything else is equal. \
         Means of the best values, first as printed, then moved.",
    );
    let row = |(at, moved): (&ProblemResult, &ProblemResult)| {
        let cells = at.methods.iter().zip(&moved.methods).map(|(at, moved)| {
            let value = mean(moved);
            let heat = (value.max(HEAT[0]) / HEAT[0]).log10() / (HEAT[1] / HEAT[0]).log10();
            Cell::number(format!("{} / {}", number(mean(at)), number(value))).heat(heat)
        });
        [Cell::text(at.name.to_uppercase())].into_iter().chain(cells).collect()
    };
    section.matrix(&heads(), printed.problems.iter().zip(&shifted.problems).map(row).collect());
    let (findings, lesson) = ranking(printed, shifted);
    section.learn(lesson);
    section.findings(findings);
    if let Some(problem) = shifted.problems.first() {
        let caption = "F1 again, its optimum moved off the origin: the methods that reached zero \
                       above stay far from it.";
        section.figure(bands(problem), caption);
    }
    section.request("The request behind this table: save it and run `takt plan FILE`", request);
    section
}

/// On how many functions GoldS-PSO is the best of the five methods, and what
/// that comes to.
fn ranking(printed: &ComparisonResult, shifted: &ComparisonResult) -> (Findings, String) {
    let published = lost(TABLE_3.iter().map(|row| row.iter().map(|entry| entry[0]).collect()));
    let [at_origin, moved] = [lost(means(printed)), lost(means(shifted))];
    let of = |lost: &[String]| format!("{} of {}", TABLE_3.len() - lost.len(), TABLE_3.len());
    let mut findings = Findings::new(&["GoldS-PSO has the least mean on", "paper", "ours"]);
    findings.add(
        vec!["the functions as printed".to_owned(), of(&published), of(&at_origin)],
        Verdict::shown(at_origin.len() <= published.len()),
        format!(
            "Ties count. Not on {} here; not on {} in the paper.",
            names(&at_origin),
            names(&published)
        ),
    );
    findings.add(
        vec!["the functions with the optimum moved".to_owned(), of(&published), of(&moved)],
        Verdict::shown(moved.len() <= published.len()),
        "The printed zeros measure where the optimum was put, not how well the method searches.",
    );
    let lesson = format!(
        "GoldS-PSO is the best of the five methods on {} functions as the paper has them, and on \
         {} once the optimum is moved off the origin.",
        of(&at_origin),
        of(&moved)
    );
    (findings, lesson)
}

fn names(lost: &[String]) -> String {
    if lost.is_empty() { "none".to_owned() } else { lost.join(", ") }
}
