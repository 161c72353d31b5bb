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
