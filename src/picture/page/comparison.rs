//! The page of a comparison: which method to use, at a glance.

use super::{Cell, Html, Table, figure, page, paragraph, section, verdict};
use crate::picture::bands;
use crate::plan::{ComparisonResult, MethodResult, ProblemResult};

/// A gap of this size and below is shown in the best colour, and of the second
/// and above in the worst; shares of the best known value.
const HEAT: [f64; 2] = [1e-5, 1e-1];

/// The same for values of functions.
const FUNCTION_HEAT: [f64; 2] = [1e-8, 1e2];

/// A page that shows a comparison or benchmark.
pub fn comparison(result: &ComparisonResult) -> String {
    let title = match result.task.as_str() {
        "benchmark" => "Optimizers on benchmark functions",
        _ => "Optimizers compared",
    };
    let problems = result.problems.iter().map(problem);
    let content = [
        verdict(&result.verdict),
        paragraph(&setting(result)),
        section("Median gap to the best known value", overview(result)),
    ];
    page(title, Html::join(content.into_iter().chain(problems).chain([method(result)])))
}

fn setting(result: &ComparisonResult) -> String {
    format!(
        "{} problems, {} runs of each method on each, {} evaluations per run, seed {}. Every \
         method had the same seeds and the same evaluations. A star marks the least median among \
         methods with random numbers; deterministic methods ran once.",
        result.problems.len(),
        result.runs,
        result.max_evaluations,
        result.seed
    )
}

/// Methods by problems, coloured by how good they are.
fn overview(result: &ComparisonResult) -> Html {
    let heads = result.problems.iter().map(|problem| Cell::number(&problem.name));
    let mut table = Table::new([Cell::text("method")].into_iter().chain(heads));
    let labels = result.problems.first().map_or(&[][..], |problem| &problem.methods);
    for (index, row) in labels.iter().enumerate() {
        let cells = result.problems.iter().map(|problem| {
            problem.methods.get(index).map_or_else(Cell::default, |row| gap(problem, row))
        });
        table.row([Cell::text(&row.label)].into_iter().chain(cells));
    }
    table.html()
}

fn is_best(problem: &ProblemResult, row: &MethodResult) -> bool {
    problem.best_method.as_deref() == Some(&row.label)
}

fn gap(problem: &ProblemResult, row: &MethodResult) -> Cell {
    let Some(gap) = row.median_gap else { return Cell::number("none found").heat(1.0) };
    let function = problem.unit.is_empty();
    let [good, bad] = if function { FUNCTION_HEAT } else { HEAT };
    let heat = (gap.max(good) / good).log10() / (bad / good).log10();
    let text = if function { format!("{gap:.2e}") } else { format!("{:.3} %", 100.0 * gap) };
    Cell::number(text).heat(heat).marked(is_best(problem, row))
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
        let p_value = row.p_value.map(|p| format!("{p:.1e}"));
        table.row([
            Cell::text(&row.label).marked(is_best(problem, row)),
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
    if unit.is_empty() { format!("{value:.3e}") } else { format!("{value:.4} {unit}") }
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
    let test = format!("p is of the {}.", result.test);
    section("How to read this", Html::join([success, test, made].map(|text| paragraph(&text))))
}
