//! Figure 12: how many iterations each method needs.

use serde_json::{Value, json};

use super::data::{ACCURACY, FIGURE_12};
use super::{FAMILY, range, speed_alone, waypoints};
use crate::picture::bands;
use crate::plan::{ComparisonResult, MethodResult, ProblemResult};
use crate::reproduce::experiment::{ReproduceError, compare, number};
use crate::reproduce::report::{Findings, Section};
use crate::reproduce::verdict::Verdict;

/// Index of the joint that needs longest.
const JOINT: usize = 5;

const ITERATIONS: u32 = 100;

/// Label, optimizer and candidates per iteration of the figure's methods.
const METHODS: [(&str, &str, u32); 5] = [
    ("improved PSO", "improved_pso", 50),
    ("standard PSO", "pso", 50),
    ("GA", "ga", 50),
    ("COA 100", "coa", 100),
    ("COA 200", "coa", 200),
];

/// Joint 6 of section AB, all methods with one way to treat what breaks a limit.
fn request(handling: &str, runs: u32) -> Value {
    let still = |row: Vec<f64>| -> Vec<f64> {
        let keep = |(joint, angle)| if joint == JOINT { angle } else { 0.0 };
        row.into_iter().enumerate().map(keep).collect()
    };
    let waypoints: Vec<Vec<f64>> = waypoints().into_iter().map(still).collect();
    let method = |(label, name, population): &(&str, &str, u32)| {
        json!({
            "label": label, "name": name, "population": population, "iterations": ITERATIONS,
        })
    };
    let most = METHODS.iter().map(|(.., population)| population).max().copied().unwrap_or(1);
    let mut limits = speed_alone();
    limits["lower"] = Value::Null;
    limits["upper"] = Value::Null;
    json!({ "robot": "rokae_xb4", "limits": limits, "task": {
        "type": "comparison", "runs": runs, "max_evaluations": most * (ITERATIONS + 1),
        "success_tolerance": 0.001,
        "methods": METHODS.iter().map(method).collect::<Vec<_>>(),
        "problems": [{ "name": "joint 6 of section AB", "task": {
            "type": "waypoints", "interpolation": FAMILY, "waypoints": waypoints,
            "constraint_handling": handling, "durations": range(),
        } }],
    } })
}

fn only(result: &ComparisonResult) -> Result<&ProblemResult, ReproduceError> {
    result.problems.first().ok_or_else(|| ReproduceError("nothing was compared".to_owned()))
}

/// Iterations after the first generation that half of the successful runs needed.
fn iterations(row: &MethodResult, population: u32) -> Option<f64> {
    let needed = row.evaluations_to_success?.median / f64::from(population);
    Some((needed - 1.0).max(0.0))
}

fn shown(row: &MethodResult, population: u32) -> String {
    let share = 100.0 * row.success_rate;
    match iterations(row, population) {
        Some(needed) => format!("{needed:.0} ({share:.0} %)"),
        None => "no run".to_owned(),
    }
}

pub(super) fn figure_12(runs: u32) -> Result<Section, ReproduceError> {
    let (rejecting, repairing) = (request("reject", runs), request("repair_segment", runs));
    let [rejected, repaired] = [compare(&rejecting)?, compare(&repairing)?];
    let [rejected, repaired] = [only(&rejected)?, only(&repaired)?];
    let mut section = Section::new("Han et al., Figure 12: iterations to the optimum");
    section.paragraph(
        "Which joint the figure shows is not said; ours is joint 6, which needs longest. \"To the \
         optimum\" is to within 0.1 % of the true one, the median over the runs that come there; \
         in brackets the share of runs that do within 100 iterations. Where fewer than half do, \
         the figure does not reproduce. Iterations count from 0, the random start. GA and COA \
         have no printed parameters; theirs are our defaults, with 50 candidates and with 100 and \
         200 points per iteration. The switch is the improved method's own: what breaks a limit \
         is stretched instead of rejected. Each method ran both ways; judged is the improved one \
         with it and the others without.",
    );
    let heads = ["iterations of", "paper", "ours, with the switch", "ours, without"];
    let mut findings = Findings::new(&heads);
    for (at, (label, name, population)) in METHODS.into_iter().enumerate() {
        let (Some(without), Some(with)) = (rejected.methods.get(at), repaired.methods.get(at))
        else {
            continue;
        };
        let row = if name == "improved_pso" { with } else { without };
        let (verdict, reason) = judge(at, row, population);
        let cells = [label.to_owned(), FIGURE_12[at].to_string()];
        let ours = [with, without].map(|row| shown(row, population));
        findings.add(cells.into_iter().chain(ours).collect(), verdict, reason);
    }
    section.findings(findings);
    section.findings(accuracy(rejected, repaired));
    section.learn(conclusion(rejected, repaired));
    section.figure(bands(rejected), "All methods without the switch.");
    section.figure(bands(repaired), "All methods with the switch, everything else equal.");
    section.request("The request behind \"without\"", rejecting);
    section.request("The request behind \"with the switch\"", repairing);
    Ok(section)
}

fn judge(method: usize, row: &MethodResult, population: u32) -> (Verdict, &'static str) {
    if row.success_rate < 0.5 {
        // Where most runs never come there, those that do say little.
        let reason = "Fewer than half of our runs come there within 100 iterations. Parameters, \
                      and how candidates over a limit are treated, are not printed.";
        return (Verdict::DoesNotReproduce, reason);
    }
    let ours = iterations(row, population).unwrap_or(f64::NAN);
    // Medians of whole iterations: a third is their own spread.
    let verdict = Verdict::of(FIGURE_12[method], ours, 0.33);
    let reason = match (verdict, method) {
        (Verdict::Reproduces, _) => "Within a third of the published number.",
        (_, 0) => "How far segments are stretched, and which joint is shown, is not printed.",
        (_, 1) => "Treatment of candidates over a limit is not printed, and it decides.",
        _ => "No parameter of this method is printed.",
    };
    (verdict, reason)
}

/// How much better improved PSO ends than the others.
fn accuracy(rejected: &ProblemResult, repaired: &ProblemResult) -> Findings {
    let heads = ["improved PSO better than", "paper [%]", "ours [%]"];
    let mut findings = Findings::new(&heads);
    let best = repaired.methods.first().and_then(|row| row.mean).unwrap_or(f64::NAN);
    let others = rejected.methods.iter().zip(METHODS).skip(1);
    for ((row, (label, ..)), published) in others.zip(ACCURACY) {
        let ours = 100.0 * (1.0 - best / row.mean.unwrap_or(f64::NAN));
        let verdict = Verdict::of(published, ours.max(0.0), 0.33);
        let reason = match verdict {
            Verdict::Reproduces => "Within a third of the published number.",
            Verdict::OrderOfMagnitude => "Better, by another share; parameters are not printed.",
            _ => {
                "Ours ends near the optimum by itself: so large a gain means that the published \
                 run stopped far from it."
            }
        };
        let cells = vec![label.to_owned(), published.to_string(), number(ours, 2)];
        findings.add(cells, verdict, reason);
    }
    findings
}

fn conclusion(rejected: &ProblemResult, repaired: &ProblemResult) -> String {
    let pair = |problem: &ProblemResult| {
        let needed = problem.methods.iter().zip(METHODS).take(2);
        let mut needed = needed.map(|(row, (.., population))| shown(row, population));
        let (improved, standard) = (needed.next(), needed.next());
        [improved, standard].map(Option::unwrap_or_default).join(" and ")
    };
    format!(
        "With the improved method's switch given to both, improved and standard PSO need {} \
         iterations; without it for both, {}: the switch decides, not only the compression \
         factor.",
        pair(repaired),
        pair(rejected)
    )
}
