//! What a comparison or benchmark produced, in other forms.

use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;

use super::problem::{Problem, ProblemFault};
use super::results::json;
use crate::picture;
use crate::plan::{ComparisonResult, CurvePoint, MethodResult, ProblemResult};

/// How the methods of every problem converged.
#[derive(Serialize, ToSchema)]
pub(super) struct ComparedConvergence {
    /// A problem each.
    problems: Vec<ProblemCurves>,
}

/// How the methods converged on a problem.
#[derive(Serialize, ToSchema)]
struct ProblemCurves {
    /// The problem's name.
    name: String,
    /// A method each.
    methods: Vec<MethodCurve>,
}

/// How one method converged.
#[derive(Serialize, ToSchema)]
struct MethodCurve {
    /// The method's label.
    label: String,
    /// Quartiles of the best value so far over evaluations.
    curve: Vec<CurvePoint>,
}

/// The problem `name`; all without a name.
fn problems<'a>(
    result: &'a ComparisonResult,
    name: Option<&str>,
) -> Result<Vec<&'a ProblemResult>, Problem> {
    let named = |problem: &&ProblemResult| name.is_none_or(|name| problem.name == name);
    let found: Vec<_> = result.problems.iter().filter(named).collect();
    match name {
        Some(name) if found.is_empty() => Err(Problem::not_found(format!(
            "there is no problem `{name}`; there are: {}",
            names(result)
        ))),
        _ => Ok(found),
    }
}

fn names(result: &ComparisonResult) -> String {
    let names = result.problems.iter().map(|problem| problem.name.as_str());
    names.collect::<Vec<_>>().join(", ")
}

/// All figures, without the curves.
pub(super) fn metrics(result: &ComparisonResult, leg: Option<&str>) -> Result<Response, Problem> {
    let without = |row: &MethodResult| MethodResult { curve: Vec::new(), ..row.clone() };
    let problem = |problem: &ProblemResult| ProblemResult {
        methods: problem.methods.iter().map(without).collect(),
        ..problem.clone()
    };
    let problems = problems(result, leg)?.into_iter().map(problem).collect();
    json(&ComparisonResult { problems, ..result.clone() })
}

/// The curves as JSON.
pub(super) fn convergence(
    result: &ComparisonResult,
    leg: Option<&str>,
) -> Result<Response, Problem> {
    let curve =
        |row: &MethodResult| MethodCurve { label: row.label.clone(), curve: row.curve.clone() };
    let problem = |problem: &ProblemResult| ProblemCurves {
        name: problem.name.clone(),
        methods: problem.methods.iter().map(curve).collect(),
    };
    let problems = problems(result, leg)?.into_iter().map(problem).collect();
    json(&ComparedConvergence { problems })
}

/// The curves as comma separated values.
pub(super) fn convergence_csv(
    result: &ComparisonResult,
    leg: Option<&str>,
) -> Result<String, Problem> {
    // RFC 4180: a quote within quotes is doubled.
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let mut text =
        String::from("problem,method,evaluations,lower_quartile,median,upper_quartile\r\n");
    for problem in problems(result, leg)? {
        for row in &problem.methods {
            for point in &row.curve {
                text.push_str(&format!(
                    "{},{},{},{},{},{}\r\n",
                    quoted(&problem.name),
                    quoted(&row.label),
                    point.evaluations,
                    number(point.lower_quartile),
                    number(point.median),
                    number(point.upper_quartile)
                ));
            }
        }
    }
    Ok(text)
}

/// The curves of one problem as a picture.
pub(super) fn convergence_svg(
    result: &ComparisonResult,
    leg: Option<&str>,
) -> Result<String, Problem> {
    match problems(result, leg)?[..] {
        [only] => Ok(picture::bands(only)),
        _ => {
            let detail = format!("name one problem to draw; there are: {}", names(result));
            Err(Problem::parameters(vec![ProblemFault::parameter("leg", detail)]))
        }
    }
}
