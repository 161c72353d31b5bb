//! From many runs to a row of figures per method.

use super::prepare::{PreparedStudy, StudyMethod};
use super::result::{CurvePoint, EvaluationQuartiles, MethodResult, ProblemResult};
use super::trace::reached;
use crate::math::statistics::{holm, mann_whitney, mean, quantile, quartiles, standard_deviation};

/// The test behind the p-values.
pub const TEST: &str = "two-sided Mann-Whitney U test against the problem's best method, \
                        Holm-corrected over the methods";

/// What is kept of a run.
#[derive(Debug, Default)]
pub struct RunRecord {
    /// What it found; infinite if nothing feasible.
    pub value: f64,
    /// The best at every count of the grid.
    pub values: Vec<f64>,
    /// Its way near the optimum; see [`reached`].
    pub steps: Vec<(u64, f64)>,
    pub evaluations: u64,
    pub seconds: f64,
}

impl RunRecord {
    /// That of a run that found nothing within the limits.
    pub fn nothing(counts: usize, evaluations: u64, seconds: f64) -> Self {
        let values = vec![f64::INFINITY; counts];
        Self { value: f64::INFINITY, values, steps: Vec::new(), evaluations, seconds }
    }
}

/// What a run has to come down to in order to succeed.
pub fn threshold(best_known: f64, tolerance: f64) -> f64 {
    best_known + tolerance * if best_known == 0.0 { 1.0 } else { best_known.abs() }
}

/// A row per method from the records of all runs, method by method.
pub fn rows(
    study: &PreparedStudy,
    records: &[RunRecord],
    grid: &[u64],
    best_known: Option<f64>,
) -> Vec<MethodResult> {
    let mut rest = records;
    let mut samples = Vec::with_capacity(study.methods.len());
    let mut rows = Vec::with_capacity(study.methods.len());
    for method in &study.methods {
        let (own, others) = rest.split_at(method.runs(study.runs) as usize);
        rest = others;
        samples.push(own.iter().map(|record| record.value).collect::<Vec<f64>>());
        rows.push(row(method, own, grid, best_known, study.tolerance));
    }
    test(study, &samples, &mut rows);
    rows
}

fn row(
    method: &StudyMethod,
    records: &[RunRecord],
    grid: &[u64],
    best_known: Option<f64>,
    tolerance: f64,
) -> MethodResult {
    let values = ascending(records.iter().map(|record| record.value));
    let feasible = &values[..values.partition_point(|value| value.is_finite())];
    let of_feasible = quartiles(feasible);
    let evaluations: u64 = records.iter().map(|record| record.evaluations).sum();
    let seconds: f64 = records.iter().map(|record| record.seconds).sum();
    let threshold = best_known.map(|best| threshold(best, tolerance));
    let successes = records.iter().filter_map(|record| reached(&record.steps, threshold?));
    let successes = ascending(successes.map(|evaluations| evaluations as f64));
    let runs = records.len() as u32;
    MethodResult {
        label: method.label.clone(),
        optimizer: method.optimizer.name.to_owned(),
        parameters: method.settings.values().map(|(name, it)| (name.to_owned(), it)).collect(),
        runs,
        feasible_runs: feasible.len() as u32,
        best: feasible.first().copied(),
        mean: mean(feasible),
        worst: feasible.last().copied(),
        standard_deviation: standard_deviation(feasible),
        lower_quartile: of_feasible.map(|[lower, _, _]| lower),
        median: of_feasible.map(|[_, median, _]| median),
        upper_quartile: of_feasible.map(|[_, _, upper]| upper),
        median_gap: of_feasible.zip(best_known).map(|([_, median, _], best)| gap(median, best)),
        success_rate: successes.len() as f64 / f64::from(runs),
        evaluations_to_success: quartiles(&successes).map(
            |[lower_quartile, median, upper_quartile]| EvaluationQuartiles {
                lower_quartile,
                median,
                upper_quartile,
            },
        ),
        p_value: None,
        evaluations,
        seconds_per_evaluation: seconds / evaluations.max(1) as f64,
        curve: curve(records, grid),
    }
}

fn ascending(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// How far `value` is above `best`: a share of it, or the distance if it is zero.
fn gap(value: f64, best: f64) -> f64 {
    (value - best) / if best == 0.0 { 1.0 } else { best.abs() }
}

fn curve(records: &[RunRecord], grid: &[u64]) -> Vec<CurvePoint> {
    let point = |(index, &evaluations): (usize, &u64)| {
        let so_far = records.iter().filter_map(|record| record.values.get(index).copied());
        let sorted = ascending(so_far);
        let finite = |share| quantile(&sorted, share).filter(|value| value.is_finite());
        CurvePoint {
            evaluations,
            lower_quartile: finite(0.25),
            median: finite(0.5),
            upper_quartile: finite(0.75),
        }
    };
    grid.iter().enumerate().map(point).collect()
}

/// The index of the row with the least median among methods with seeds, or
/// among all if there is none; of equal ones that with the lower mean, then
/// the first.
pub fn best_method(study: &PreparedStudy, rows: &[MethodResult]) -> Option<usize> {
    let among = |seeded: bool| {
        let key = |at: &usize| (infinite(rows[*at].median), infinite(rows[*at].mean));
        let usable = |at: &usize| {
            let method = &study.methods[*at];
            rows[*at].median.is_some() && method.optimizer.is_deterministic() != seeded
        };
        (0..rows.len()).filter(usable).min_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    };
    among(true).or_else(|| among(false))
}

fn infinite(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::INFINITY)
}

/// Tests every method with seeds against the best of them.
fn test(study: &PreparedStudy, samples: &[Vec<f64>], rows: &mut [MethodResult]) {
    let Some(best) = best_method(study, rows) else { return };
    let others: Vec<usize> = (0..rows.len())
        .filter(|&at| at != best && !study.methods[at].optimizer.is_deterministic())
        .collect();
    if study.methods[best].optimizer.is_deterministic() {
        return;
    }
    let tested =
        others.iter().filter_map(|&at| Some((at, mann_whitney(&samples[at], &samples[best])?)));
    let (tested, mut p_values): (Vec<usize>, Vec<f64>) = tested.unzip();
    holm(&mut p_values);
    for (at, p) in tested.into_iter().zip(p_values) {
        rows[at].p_value = Some(p);
    }
}

/// A difference counts as proven below this.
pub(super) const SIGNIFICANT: f64 = 0.05;

/// Durations that differ by a smaller share are equal: no search ends more
/// precisely.
pub(super) const ROUNDING: f64 = 1e-6;

/// Which method did best, in words.
pub fn verdict(study: &PreparedStudy, problems: &[ProblemResult]) -> String {
    let count = problems.len();
    let wins = |label: &str| {
        problems.iter().filter(|problem| problem.best_method.as_deref() == Some(label)).count()
    };
    let ranked = study.methods.iter().map(|method| method.label.as_str());
    let ranked = ranked.map(|label| (wins(label), mean_gap(label, problems), label));
    let best = ranked.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    let Some((wins, gap, label)) = best.filter(|(wins, ..)| *wins > 0) else {
        return "No method found anything within the limits.".to_owned();
    };
    let clear = problems.iter().filter(|it| clearly_best(it, label)).count();
    let on = if count == 1 {
        "on the problem".to_owned()
    } else {
        format!("on {wins} of {count} problems")
    };
    let gap = match study.task {
        "benchmark" => format!("median values average {gap:.3e} above the optimum"),
        _ => format!("medians average {:.3} % above the best known duration", 100.0 * gap),
    };
    let proven = match (clear, count) {
        (0, _) => "nowhere significantly better than all others".to_owned(),
        (_, 1) => "significantly better than all others".to_owned(),
        (clear, _) => format!("on {clear} significantly better than all others"),
    };
    let exact = match study.task {
        "benchmark" => String::new(),
        _ => {
            let reached = problems.iter().filter(|it| optimum_is_best(it)).count();
            format!(
                "Use `exact`: deterministic, it is at the best known duration on {reached} of {count} \
                 problems. Of the methods with seeds "
            )
        }
    };
    format!("{exact}{label} did best {on}, {proven} (p < {SIGNIFICANT}); its {gap}.")
}

/// True if no run found anything better than the optimum, rounding aside.
fn optimum_is_best(problem: &ProblemResult) -> bool {
    let values = problem.optimum.as_ref().zip(problem.best_known);
    values.is_some_and(|(optimum, best)| optimum.value <= best * (1.0 + ROUNDING))
}

/// True if `label` is the best on `problem` and every other one is significantly worse, and there is another.
fn clearly_best(problem: &ProblemResult, label: &str) -> bool {
    let p_values: Vec<f64> = problem.methods.iter().filter_map(|row| row.p_value).collect();
    problem.best_method.as_deref() == Some(label)
        && !p_values.is_empty()
        && p_values.iter().all(|&p| p < SIGNIFICANT)
}

/// The mean over all problems of a method's median gap.
fn mean_gap(label: &str, problems: &[ProblemResult]) -> f64 {
    let rows = problems.iter().flat_map(|problem| &problem.methods);
    let gaps = rows.filter(|row| row.label == label).map(|row| infinite(row.median_gap));
    mean(&gaps.collect::<Vec<f64>>()).unwrap_or(f64::INFINITY)
}
