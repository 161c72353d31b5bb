//! What is possible: the published motions within the published limits, planned
//! by the exact method and certified.

use serde_json::{Value, json};

use super::experiment::{ReproduceError, plan};
use super::report::Section;
use crate::picture::page::Cell;
use crate::picture::{Beside, beside};
use crate::plan::TrajectoryResult;
use crate::trajectory::interpolation::{INTERPOLATIONS, Interpolation, Timing};

/// A published motion.
pub(super) struct Problem {
    pub(super) name: String,
    /// The paper's duration, s, where it has one that can be compared.
    pub(super) published: Option<f64>,
    /// The paper's curve.
    pub(super) family: &'static str,
    /// True if jerk is limited, which some curves cannot keep.
    pub(super) jerk_limited: bool,
    /// All joints at once, with the exact method.
    pub(super) request: Value,
}

impl Problem {
    fn plan(&self, family: &str) -> Result<TrajectoryResult, ReproduceError> {
        plan(&self.request_with(family))
    }

    fn request_with(&self, family: &str) -> Value {
        let mut request = self.request.clone();
        request["task"]["interpolation"] = json!(family);
        request
    }

    /// True if a robot can follow `family` through these waypoints, with no limit
    /// that it cannot keep.
    fn admits(&self, family: &Interpolation) -> bool {
        let waypoints = self.request["task"]["waypoints"].as_array().map_or(0, Vec::len);
        let segments = waypoints.saturating_sub(1);
        family.executable
            && matches!(family.timing, Timing::Search(_))
            && (family.bounded_jerk || !self.jerk_limited)
            && family.min_segments <= segments
            && family.max_segments.is_none_or(|most| segments <= most)
    }

    /// The shortest motion on any of the curves, and the curve's name.
    fn best(&self) -> Result<Option<(&'static str, TrajectoryResult)>, ReproduceError> {
        let mut best: Option<(&str, TrajectoryResult)> = None;
        for family in INTERPOLATIONS.iter().filter(|family| self.admits(family)) {
            let result = self.plan(family.name)?;
            if best.as_ref().is_none_or(|(_, best)| result.duration < best.duration) {
                best = Some((family.name, result));
            }
        }
        Ok(best)
    }
}

/// The section, and in a sentence what it comes to; none without problems.
pub(super) fn section(problems: &[Problem]) -> Result<(Section, Option<String>), ReproduceError> {
    let mut section = Section::new("What is possible");
    section.paragraph(
        "The same waypoints within the same limits, all joints planned at once by Takt's exact method, \
         which has no random numbers. First on the paper's own curves, then on quintics (smooth in \
         speed and acceleration, at rest at both ends), then on whichever of Takt's curves is fastest. \
         No motion whatever can be shorter than the lower bound. Every plan carries a certificate: its \
         exact peaks, over continuous time, as multiples of their limits.",
    );
    let heads = [
        "motion", "published s", "paper's curve s", "quintic s", "fastest curve s", "curve",
        "lower bound s", "worst peak / limit", "lawful",
    ];
    let (mut rows, mut picture, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for problem in problems {
        let Some((name, best)) = problem.best()? else { continue };
        let (same, quintic) = (problem.plan(problem.family)?, problem.plan("quintic")?);
        rows.push(row(problem, [&same, &quintic, &best], name));
        if let Some(published) = problem.published {
            let saved = 100.0 * (1.0 - best.duration / published);
            claims.push(format!("{}: {:.2} s instead of {published:.2} s ({saved:.1} % less)", problem.name, best.duration));
        }
        picture.push(Beside {
            name: problem.name.clone(),
            published: problem.published,
            ours: Some([best.duration; 3]),
            optimum: Some(same.duration),
        });
    }
    section.table(&heads, rows);
    section.paragraph(
        "Where no published time stands, waypoints or limits are substitutes. \"cubic\" and \"bspline\" \
         start with a step in acceleration, which a quintic does not.",
    );
    let title = "Duration of whole motions";
    let names = ["published", "fastest curve", "optimum on the paper's curve (upright line)"];
    let caption = "What the papers arrive at, and what the same limits allow.";
    section.figure(beside(title, "duration [s]", names, &picture), caption);
    for problem in problems {
        let title = format!("The request behind {} on quintics", problem.name);
        section.request(title, problem.request_with("quintic"));
    }
    Ok((section, (!claims.is_empty()).then(|| claims.join("; "))))
}

fn row(problem: &Problem, plans: [&TrajectoryResult; 3], name: &str) -> Vec<Cell> {
    let seconds = |value: f64| Cell::number(format!("{value:.4}"));
    let published = problem.published.map_or_else(|| Cell::number("-"), seconds);
    let [_, _, best] = plans;
    let bound = best.bound.as_ref().map_or_else(|| Cell::number("-"), |it| seconds(it.lower));
    let worst = plans.iter().map(|plan| plan.certificate.worst_ratio).fold(0.0, f64::max);
    // The paper's own curve may be one that no robot can follow.
    let lawful = plans.iter().all(|plan| plan.certificate.lawful);
    let lawful = if lawful { "all three" } else { "not on the paper's curve: speed jumps" };
    let durations = plans.map(|plan| seconds(plan.duration));
    [Cell::text(&problem.name), published]
        .into_iter()
        .chain(durations)
        .chain([Cell::text(name), bound, Cell::number(format!("{worst:.6}")), Cell::text(lawful)])
        .collect()
}
