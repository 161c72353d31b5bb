//! The page of a comparison: which method to use, at a glance.

use super::{Cell, Html, Table, figure, page, paragraph, section, verdict};
use crate::picture::scale::figure as significant;
use crate::picture::{bands, gaps};
use crate::plan::{ComparisonResult, MethodResult, ProblemResult, Standing};

/// A gap of this size and below is shown in the best colour, and of the second
/// and above in the worst; shares of the best known value.
const HEAT: [f64; 2] = [1e-5, 1e-1];

/// The same for values of functions.
const FUNCTION_HEAT: [f64; 2] = [1e-8, 1e2];

/// A median this near, a share of the best known value, is told to be there:
/// three decimals of a percent show no difference.
const REACHED: f64 = 5e-6;

/// A page that shows a comparison or benchmark.
pub fn comparison(result: &ComparisonResult) -> String {
    let title = match result.task.as_str() {
        "benchmark" => "Optimizers on benchmark functions",
        _ => "Optimizers compared",
    };
    let ranking = result.ranking();
    let problems = result.problems.iter().map(problem);
    let content = [
        verdict(&result.verdict),
        paragraph(&setting(result, &ranking)),
        section("Ranking over all problems", standings(result, &ranking)),
        section("Gap to the best known value", overview(result, &ranking)),
    ];
    page(title, Html::join(content.into_iter().chain(problems).chain([method(result)])))
}

fn setting(result: &ComparisonResult, ranking: &[Standing]) -> String {
    let once = match ranking.iter().any(|standing| standing.deterministic) {
        true => " A deterministic method draws no random numbers, so it ran once.",
        false => "",
    };
    format!(
        "{}, {} of each method on each, {} evaluations per run, seed {}. Every method had the \
         same seeds and the same evaluations.{once}",
        counted(result.problems.len(), "problem"),
        counted(result.runs as usize, "run"),
        result.max_evaluations,
        result.seed
    )
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// All methods in the order in which to try them.
fn standings(result: &ComparisonResult, ranking: &[Standing]) -> Html {
    let function = result.task == "benchmark";
    let heads = ["mean rank", "median gap", "success", "best on", "level on", "time per run"];
    let heads = heads.map(Cell::number);
    let mut table = Table::new([Cell::text("method")].into_iter().chain(heads));
    for (place, standing) in ranking.iter().enumerate() {
        let of_all = |count: usize| Cell::number(format!("{count} of {}", result.problems.len()));
        let name = format!("{}.\u{a0}{}", place + 1, name(&standing.label, standing.deterministic));
        table.row([
            Cell::text(name).marked(place == 0),
            Cell::number(format!("{:.1}", standing.mean_rank)),
            gap(standing.median_gap, function),
            Cell::number(format!("{:.0} %", 100.0 * standing.success_rate)),
            of_all(standing.best),
            of_all(standing.level),
            Cell::number(format!("{:.2} ms", 1e3 * standing.seconds_per_run)),
        ]);
    }
    let note = "Rank 1 is the least median on a problem; gap, success and time are the median and \
                the means over the problems. Best on: problems with the least median of all \
                methods with random numbers; for a deterministic method, problems on which no \
                median is below its only value. Level on: problems on which another method is \
                best, but not by more than rounding or chance (p < 0.05).";
    Html::join([table.html(), paragraph(note)])
}

fn name(label: &str, deterministic: bool) -> String {
    format!("{label}{}", if deterministic { " (deterministic)" } else { "" })
}

/// Methods by problems: drawn, and as a table coloured by how good they are.
fn overview(result: &ComparisonResult, ranking: &[Standing]) -> Html {
    let caption = "Where the runs of each method ended, problem by problem: farther left is \
                   better. The axis is logarithmic and the same for all.";
    let heads = result.problems.iter().map(|problem| Cell::number(&problem.name));
    let mut table = Table::new([Cell::text("median gap")].into_iter().chain(heads));
    for Standing { index, label, deterministic, .. } in ranking {
        let cells = result.problems.iter().map(|problem| match problem.methods.get(*index) {
            Some(row) => median_gap(problem, row),
            None => Cell::default(),
        });
        table.row([Cell::text(name(label, *deterministic))].into_iter().chain(cells));
    }
    let note = "A star marks the best method of a problem: the one with random numbers that has \
                the least median, and beside it a deterministic one whose only value no median \
                is below.";
    Html::join([figure(&gaps(result, ranking), caption), table.html(), paragraph(note)])
}

fn median_gap(problem: &ProblemResult, row: &MethodResult) -> Cell {
    let function = problem.unit.is_empty();
    let optimum = problem.optimum.as_ref().zip(problem.best_known);
    let known = optimum.is_some_and(|(it, best)| it.value <= best * (1.0 + REACHED));
    let cell = match row.median_gap {
        Some(gap) if known && reached(gap, function) => Cell::number("optimum").heat(0.0),
        other => gap(other, function),
    };
    cell.marked(problem.is_best(row))
}

/// True if the gap is too small for the digits shown.
fn reached(gap: f64, function: bool) -> bool {
    if function { gap == 0.0 } else { gap < REACHED }
}

/// A gap to the best known value, coloured by how good it is.
fn gap(gap: Option<f64>, function: bool) -> Cell {
    let Some(gap) = gap else { return Cell::number("none found").heat(1.0) };
    let [good, bad] = if function { FUNCTION_HEAT } else { HEAT };
    let heat = (gap.max(good) / good).log10() / (bad / good).log10();
    let text = match function {
        true => significant(gap),
        false if reached(gap, function) => "< 0.001 %".to_owned(),
        false => format!("{:.3} %", 100.0 * gap),
    };
    Cell::number(text).heat(heat)
}

fn problem(problem: &ProblemResult) -> Html {
    let caption = "Gap to the best known value over evaluations, logarithmic: medians over the \
                   runs and the span between the quartiles.";
    let content = [paragraph(&facts(problem)), figure(&bands(problem), caption), rows(problem)];
    section(&problem.name, Html::join(content))
}

fn facts(problem: &ProblemResult) -> String {
    let value = |value: f64| number(value, &problem.unit);
    let mut facts = vec![format!("{}; {} variables", problem.title, problem.dimension)];
    facts.extend(problem.robot.as_ref().map(|robot| format!("Robot: {robot}")));
    let optimum = problem.optimum.as_ref();
    facts.extend(optimum.map(|it| format!("Optimum: {} ({})", value(it.value), it.source)));
    facts.extend(
        problem.lower_bound.map(|it| format!("No lawful trajectory is below {}", value(it))),
    );
    facts.extend(problem.best_run.as_ref().map(|best| {
        format!("Best run: {} by {}, run {}", value(best.value), best.method, best.run)
    }));
    facts.join(". ") + "."
}

/// The figures of every method on a problem.
fn rows(problem: &ProblemResult) -> Html {
    let heads = ["best", "median", "mean", "worst", "std. dev.", "success", "evaluations", "p"];
    let heads = heads.map(Cell::number);
    let mut table = Table::new([Cell::text("method")].into_iter().chain(heads));
    for row in &problem.methods {
        let value = |value: Option<f64>| {
            Cell::number(value.map_or("\u{2013}".to_owned(), |value| number(value, &problem.unit)))
        };
        let needed = row.evaluations_to_success.map(|it| format!("{:.0}", it.median));
        let p_value = row.p_value.map(significant);
        table.row([
            Cell::text(name(&row.label, row.is_deterministic())).marked(problem.is_best(row)),
            value(row.best),
            value(row.median),
            value(row.mean),
            value(row.worst),
            value(row.standard_deviation),
            Cell::number(format!("{:.0} %", 100.0 * row.success_rate)),
            Cell::number(needed.unwrap_or_else(|| "\u{2013}".to_owned())),
            Cell::number(p_value.unwrap_or_else(|| "\u{2013}".to_owned())),
        ]);
    }
    table.html()
}

fn number(value: f64, unit: &str) -> String {
    if unit.is_empty() { significant(value) } else { format!("{value:.4} {unit}") }
}

/// How to read the figures.
fn method(result: &ComparisonResult) -> Html {
    let success = format!(
        "A run succeeds once it is within {} of the best known value; for a value of zero that is \
         the distance itself. Evaluations are the median over the runs that succeeded.",
        result.success_tolerance
    );
    let made = format!(
        "{} evaluations in {:.3} s, by Takt {}.",
        result.evaluations, result.planning_s, result.version
    );
    let time = "Times per run were taken while other runs went on; of all figures of the methods \
                only they differ between equal requests.";
    let test = format!("p is of the {}.", result.test);
    section("How to read this", Html::join([&success, time, &test, &made].map(paragraph)))
}
