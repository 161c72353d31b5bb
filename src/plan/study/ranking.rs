//! Methods ranked over all problems of a comparison.

use super::result::{ComparisonResult, MethodResult, ProblemResult};
use super::row::{ROUNDING, SIGNIFICANT};
use crate::math::statistics::{mean, quantile};
use crate::optimize::optimizer;

/// How one method did over all problems.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Its place in every problem's `methods`.
    pub index: usize,
    /// Its label.
    pub label: String,
    /// True if it draws no random numbers: it ran once, and a further run would
    /// give the same.
    pub deterministic: bool,
    /// Mean over the problems of its rank by median, from 1; equal medians
    /// share the mean of their ranks.
    pub mean_rank: f64,
    /// Problems on which it is best: of the methods with seeds, as
    /// [`ProblemResult::best_method`] says; a deterministic one, if no median
    /// is below its value.
    pub best: usize,
    /// Problems on which another method is best, but not by more than rounding
    /// or chance (p < 0.05).
    pub level: usize,
    /// Median over the problems of its median gap; null if it found nothing
    /// on half of them.
    pub median_gap: Option<f64>,
    /// Mean over the problems of its success rate.
    pub success_rate: f64,
    /// Mean time of a run, s; differs between equal requests.
    pub seconds_per_run: f64,
}

impl MethodResult {
    /// True if the method draws no random numbers.
    pub fn is_deterministic(&self) -> bool {
        optimizer(&self.optimizer).is_some_and(|entry| entry.is_deterministic())
    }

    /// Mean time of a run, s.
    pub fn seconds_per_run(&self) -> f64 {
        self.seconds_per_evaluation * self.evaluations as f64 / f64::from(self.runs.max(1))
    }
}

impl ComparisonResult {
    /// All methods, the best first: by mean rank, then by gap, then as requested.
    pub fn ranking(&self) -> Vec<Standing> {
        let rows = self.problems.first().map_or(&[][..], |problem| &problem.methods);
        let mut ranking: Vec<Standing> =
            rows.iter().enumerate().map(|(index, row)| self.standing(index, row)).collect();
        ranking.sort_by(|a, b| {
            let gap = |standing: &Standing| standing.median_gap.unwrap_or(f64::INFINITY);
            a.mean_rank.total_cmp(&b.mean_rank).then(gap(a).total_cmp(&gap(b)))
        });
        ranking
    }

    fn standing(&self, index: usize, row: &MethodResult) -> Standing {
        let own: Vec<(&ProblemResult, &MethodResult)> =
            self.problems.iter().filter_map(|it| Some((it, it.methods.get(index)?))).collect();
        let over = |of: &dyn Fn(&ProblemResult, &MethodResult) -> f64| -> Vec<f64> {
            own.iter().map(|(problem, row)| of(problem, row)).collect()
        };
        let count = |of: fn(&ProblemResult, &MethodResult) -> bool| {
            own.iter().filter(|(problem, row)| of(problem, row)).count()
        };
        let average = |values: Vec<f64>| mean(&values).unwrap_or(0.0);
        let mut gaps = over(&|_, row| row.median_gap.unwrap_or(f64::INFINITY));
        gaps.sort_by(f64::total_cmp);
        Standing {
            index,
            label: row.label.clone(),
            deterministic: row.is_deterministic(),
            mean_rank: average(over(&ProblemResult::rank)),
            best: count(ProblemResult::is_best),
            level: count(ProblemResult::is_level),
            median_gap: quantile(&gaps, 0.5).filter(|gap| gap.is_finite()),
            success_rate: average(over(&|_, row| row.success_rate)),
            seconds_per_run: average(over(&|_, row| row.seconds_per_run())),
        }
    }
}

impl ProblemResult {
    /// Gaps below this are equal: durations are searched no more precisely, and
    /// a distance to zero is known to double precision.
    pub fn rounding(&self) -> f64 {
        if self.best_known == Some(0.0) { f64::EPSILON } else { ROUNDING }
    }

    /// True if `row` is best on this problem, as [`Standing::best`] counts it.
    pub fn is_best(&self, row: &MethodResult) -> bool {
        let gaps = || self.methods.iter().map(|row| self.ranked(row));
        let own = self.ranked(row);
        let first = own.is_finite() && gaps().all(|gap| own <= gap);
        self.best_method.as_deref() == Some(&row.label) || row.is_deterministic() && first
    }

    /// True if another method is best, but not by more than rounding or chance.
    fn is_level(&self, row: &MethodResult) -> bool {
        let winner = |it: &&MethodResult| self.best_method.as_deref() == Some(&it.label);
        let best = self.methods.iter().find(winner);
        let equal = best.is_some_and(|best| self.ranked(best) == self.ranked(row));
        let chance = row.p_value.is_some_and(|p| p >= SIGNIFICANT);
        row.median_gap.is_some() && !self.is_best(row) && (equal || chance)
    }

    /// The rank of `row` by median; equal ones share the mean of theirs.
    fn rank(&self, row: &MethodResult) -> f64 {
        let own = self.ranked(row);
        let gaps = || self.methods.iter().map(|row| self.ranked(row));
        let below = gaps().filter(|gap| *gap < own).count();
        let equal = gaps().filter(|gap| *gap == own).count();
        below as f64 + 0.5 * (equal as f64 + 1.0)
    }

    /// The median gap as ranked: rounding decides nothing.
    fn ranked(&self, row: &MethodResult) -> f64 {
        row.median_gap.map_or(f64::INFINITY, |gap| gap.max(self.rounding()))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// A row with this median gap and p-value.
    fn row(optimizer: &str, gap: Option<f64>, p: Option<f64>) -> serde_json::Value {
        let runs = if optimizer == "exact" { 1 } else { 4 };
        json!({ "label": optimizer, "optimizer": optimizer, "parameters": {}, "runs": runs,
            "feasible_runs": runs, "median_gap": gap, "success_rate": 0.5, "p_value": p,
            "evaluations": 100, "seconds_per_evaluation": 0.02, "curve": [] })
    }

    fn problem(best: &str, best_known: f64, rows: &[serde_json::Value]) -> serde_json::Value {
        json!({ "name": "p", "title": "", "unit": "s", "dimension": 2, "best_known": best_known,
            "best_method": best, "methods": rows })
    }

    fn ranking(problems: &[serde_json::Value]) -> Vec<Standing> {
        let result: ComparisonResult = serde_json::from_value(json!({ "task": "comparison",
            "runs": 4, "max_evaluations": 100, "success_tolerance": 1e-3, "test": "",
            "verdict": "", "problems": problems, "evaluations": 0, "planning_s": 0.0, "seed": 0,
            "version": "" }))
        .unwrap();
        result.ranking()
    }

    #[test]
    fn the_best_over_all_problems_comes_first() {
        let rows = |ga, pso, exact| {
            [row("ga", ga, Some(0.01)), row("pso", pso, None), row("exact", exact, None)]
        };
        let first = problem("pso", 5.0, &rows(Some(0.2), Some(1e-3), Some(0.0)));
        let second = problem("pso", 5.0, &rows(None, Some(0.1), Some(1e-9)));
        let ranking = ranking(&[first, second]);
        let labels: Vec<&str> = ranking.iter().map(|it| it.label.as_str()).collect();
        assert_eq!(labels, ["exact", "pso", "ga"]);
        let [exact, pso, ga] = &ranking[..] else { panic!("three methods") };
        assert!(exact.deterministic && !pso.deterministic);
        assert_eq!((exact.index, exact.mean_rank, exact.best, exact.level), (2, 1.0, 2, 0));
        assert_eq!((pso.index, pso.mean_rank, pso.best, pso.level), (1, 2.0, 2, 0));
        assert_eq!((ga.index, ga.mean_rank, ga.best, ga.level), (0, 3.0, 0, 0));
        assert_eq!((pso.median_gap, ga.median_gap), (Some(0.0505), None));
        assert_eq!((pso.seconds_per_run, exact.seconds_per_run), (0.5, 2.0));
        assert_eq!(ga.success_rate, 0.5);
    }

    /// Below the rounding nothing differs, and what chance explains is no defeat.
    #[test]
    fn rounding_and_chance_decide_nothing() {
        let rows = [
            row("pso", Some(1e-12), None),
            row("cfpso", Some(9e-7), Some(1e-6)),
            row("ga", Some(0.01), Some(0.06)),
            row("aga", Some(0.01), Some(0.04)),
            row("exact", Some(2e-7), None),
        ];
        let counts = |best_known| {
            let mut ranking = ranking(&[problem("pso", best_known, &rows)]);
            ranking.sort_by_key(|standing| standing.index);
            ranking.iter().map(|it| (it.mean_rank, it.best, it.level)).collect::<Vec<_>>()
        };
        let shared = [(2.0, 1, 0), (2.0, 0, 1), (4.5, 0, 1), (4.5, 0, 0), (2.0, 1, 0)];
        assert_eq!(counts(5.0), shared);
        // Distances to zero are known better.
        let apart = [(1.0, 1, 0), (3.0, 0, 0), (4.5, 0, 1), (4.5, 0, 0), (2.0, 0, 0)];
        assert_eq!(counts(0.0), apart);
    }

    #[test]
    fn nothing_found_is_nowhere_best() {
        let rows = [row("pso", None, None), row("exact", None, None)];
        let mut nothing = problem("", 5.0, &rows);
        nothing["best_method"] = json!(null);
        let ranking = ranking(&[nothing]);
        assert!(ranking.iter().all(|it| (it.best, it.level, it.median_gap) == (0, 0, None)));
        assert!(ranking.iter().all(|it| it.mean_rank == 1.5));
        assert!(super::tests::ranking(&[]).is_empty());
    }
}
