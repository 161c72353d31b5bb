//! What is possible: the published motions within the published limits, planned
//! by the exact method and certified.

use serde_json::{Value, json};

use super::experiment::{ReproduceError, plan, scenario};
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
    /// The built-in scenario: waypoints and all limits, those of position too.
    pub(super) scenario: &'static str,
}

impl Problem {
    fn plan(&self, family: &str) -> Result<TrajectoryResult, ReproduceError> {
        plan(&self.request(family)?)
    }

    /// All joints at once on `family`, with the exact method.
    fn request(&self, family: &str) -> Result<Value, ReproduceError> {
        let mut request = scenario(self.scenario)?;
        request["task"]["interpolation"] = json!(family);
        request["task"]["optimizer"] = json!({ "name": "exact" });
        request["task"]["clock"] = json!("shared");
        Ok(request)
    }

    /// True if a robot can follow `family` through these waypoints, with no limit
    /// that it cannot keep.
    fn admits(&self, family: &Interpolation, segments: usize) -> bool {
        family.executable
            && matches!(family.timing, Timing::Search(_))
            && (family.bounded_jerk || !self.jerk_limited)
            && family.min_segments <= segments
            && family.max_segments.is_none_or(|most| segments <= most)
    }

    /// The shortest motion on any of the curves, and the curve's name.
    fn best(&self) -> Result<Option<(&'static str, TrajectoryResult)>, ReproduceError> {
        let waypoints = &scenario(self.scenario)?["task"]["waypoints"];
        let segments = waypoints.as_array().map_or(0, Vec::len).saturating_sub(1);
        let mut best: Option<(&str, TrajectoryResult)> = None;
        for family in INTERPOLATIONS.iter().filter(|family| self.admits(family, segments)) {
            let result = self.plan(family.name)?;
            if best.as_ref().is_none_or(|(_, best)| result.duration < best.duration) {
                best = Some((family.name, result));
            }
        }
        Ok(best)
    }

    /// In words how much faster than published it is; none if nothing is.
    fn claim(
        &self,
        curve: &str,
        best: &TrajectoryResult,
        same: &TrajectoryResult,
    ) -> Option<String> {
        let published = self.published.filter(|published| best.duration < *published)?;
        let saved = 100.0 * (1.0 - best.duration / published);
        Some(format!(
            "{} in {:.2} s instead of {published:.2} s ({saved:.0} % less) on the curve {curve}, \
             in {:.2} s on the paper's own",
            self.name, best.duration, same.duration
        ))
    }
}

const HEADS: [&str; 8] = [
    "motion",
    "published [s]",
    "paper's curve [s]",
    "quintic [s]",
    "fastest [s]",
    "on curve",
    "none below [s]",
    "lawful",
];

/// The section, and in a sentence what it comes to; none without problems.
pub(super) fn section(problems: &[Problem]) -> Result<(Section, Option<String>), ReproduceError> {
    let mut section = Section::new("What is possible");
    section.paragraph(
        "The same waypoints within the same limits, all joints planned at once by Takt's exact \
         method, which has no random numbers. First on the paper's own curves, then on quintics \
         (smooth in speed and acceleration, at rest at both ends), then on whichever of Takt's \
         curves is fastest. No motion whatever can be shorter than the last figure. Limits of \
         position hold too. Lawful is what a certificate says of each plan, from its exact peaks \
         over continuous time.",
    );
    let (mut rows, mut picture, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for problem in problems {
        let Some((name, best)) = problem.best()? else { continue };
        let (same, quintic) = (problem.plan(problem.family)?, problem.plan("quintic")?);
        rows.push(row(problem, [&same, &quintic, &best], name));
        claims.extend(problem.claim(name, &best, &same));
        picture.push(Beside {
            name: problem.name.clone(),
            published: problem.published,
            ours: Some([best.duration; 3]),
            optimum: Some(same.duration),
        });
    }
    section.rows(&HEADS, rows);
    section.paragraph(
        "Between the waypoints the curves differ, and so do the ways. Where a paper limits no \
         jerk, neither does the plan. Where no published time stands, waypoints or limits are \
         substitutes. \"cubic\" and \"bspline\" start with a step in acceleration, which a \
         quintic does not.",
    );
    let title = "Duration of whole motions";
    let names = ["published", "fastest curve", "optimum on the paper's curve (upright line)"];
    let caption = "What the papers arrive at, and what the same limits allow.";
    section.figure(beside(title, "duration [s]", names, &picture), caption);
    let requests = problems.iter().map(|problem| problem.request("quintic"));
    let title = "The requests behind the column \"quintic\": save one and run `takt plan FILE`";
    section.requests(title, requests.collect::<Result<_, _>>()?);
    let claim = format!(
        "Through the same waypoints, within the same limits, certified, Takt plans {}.",
        claims.join("; ")
    );
    Ok((section, (!claims.is_empty()).then_some(claim)))
}

fn row(problem: &Problem, plans: [&TrajectoryResult; 3], name: &str) -> Vec<Cell> {
    let seconds = |value: f64| Cell::number(format!("{value:.4}"));
    let published = problem.published.map_or_else(|| Cell::number("-"), seconds);
    let [_, _, best] = plans;
    let bound = best.bound.as_ref().map_or_else(|| Cell::number("-"), |it| seconds(it.lower));
    // The paper's own curve may be one that no robot can follow.
    let [same, others @ ..] = plans.map(|plan| plan.certificate.lawful);
    let lawful = match (same, others.iter().all(|lawful| *lawful)) {
        (true, true) => "yes",
        (false, true) => "not the paper's curve: its speed jumps",
        _ => "no",
    };
    let durations = plans.map(|plan| seconds(plan.duration));
    [Cell::text(&problem.name), published]
        .into_iter()
        .chain(durations)
        .chain([Cell::text(name), bound, Cell::text(lawful).prose()])
        .collect()
}
