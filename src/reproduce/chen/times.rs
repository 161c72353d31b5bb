//! Table 5: the times of a woodworking arm, joint by joint and all together.

use serde_json::{Value, json};

use super::data::{
    BEFORE, COMPOSED, CONCLUSION, LIMITS, PublishedTimes, REDUCTIONS, TABLE_4, TABLE_5,
};
use crate::picture::{Beside, NAMES, beside};
use crate::reproduce::experiment::{
    EXCESS, Repeated, ReproduceError, alone, difference, in_picture, number, peaks, peaks_alone,
    plan, repeat, rounded_up,
};
use crate::reproduce::report::{Findings, Section};
use crate::reproduce::verdict::Verdict;

const FAMILY: &str = "3-5-3";

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    let ours = TABLE_5
        .iter()
        .map(|row| repeat(&request(Some(row.optimizer), "per_joint"), runs))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(vec![table_5(&ours)?, composition(&ours)?])
}

/// The paper's motion; without an optimizer the exact one, which needs no range.
pub(super) fn request(optimizer: Option<&str>, clock: &str) -> Value {
    let limit = |kind: usize| LIMITS.iter().map(|limits| limits[kind]).collect::<Vec<_>>();
    let mut task = json!({
        "type": "waypoints", "interpolation": FAMILY, "waypoints": TABLE_4, "clock": clock,
        "optimizer": { "name": "exact" },
    });
    if let Some(name) = optimizer {
        task["optimizer"] = json!({ "name": name, "population": 50, "iterations": 300 });
        task["durations"] = json!({ "min": 1.0, "max": 5.0 });
        task["constraint_handling"] = json!("reject");
    }
    // The paper minds no position limits; joint 4 passes its own under the times
    // that some seeds compose.
    let limits = json!({
        "velocity": limit(0), "acceleration": limit(1), "lower": null, "upper": null,
    });
    json!({ "robot": "woodworking_pprr", "limits": limits, "task": task })
}

fn waypoints() -> Vec<Vec<f64>> {
    TABLE_4.iter().map(|row| row.to_vec()).collect()
}

fn table_5(ours: &[Repeated]) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Chen et al., Table 5: each joint alone");
    section.paragraph(
        "How long each of four joints needs, moved alone through four waypoints on a 3-5-3 curve \
         (cubic, quintic, cubic polynomial), within its limits of speed and acceleration. 50 \
         candidates, 300 iterations, 1 to 5 s per segment. How the paper treats candidates over a \
         limit is not printed; here they are rejected. Ours is the mean over the seeds, with \
         quartiles. The optimum is the true one of the same curves within the same limits. A \
         total reproduces if ours is within 1 %.",
    );
    let Joints { findings, picture, over } = joints(ours)?;
    section.findings(findings);
    let least = over.iter().copied().fold(f64::INFINITY, f64::min);
    let most = over.iter().copied().fold(0.0, f64::max);
    section.learn(format!(
        "{} of the {} published motions exceed the paper's own limits, by {least:.1} to {most:.1} \
         %: all of joint 1, whose published times lie below the true optimum.",
        over.len(),
        TABLE_5.len() * LIMITS.len()
    ));
    section.paragraph(
        "Speed and acceleration are the exact peaks at the published times, as multiples of their \
         limits: above 1 a motion is not allowed.",
    );
    let caption = "A published time left of the upright line lies below what the limits allow.";
    section.figure(beside("Table 5: times per joint", "duration [s]", NAMES, &picture), caption);
    let title = "The request behind \"ours\", with `optimizer.name` pso, gold_sa or golds_pso and \
                 a seed from 0 up";
    section.request(title, request(Some("golds_pso"), "per_joint"));
    section.request("The request behind the optimum", request(None, "per_joint"));
    Ok(section)
}

/// Table 5 joint by joint.
struct Joints {
    findings: Findings,
    picture: Vec<Beside>,
    /// By how many percent limits are exceeded, where they are.
    over: Vec<f64>,
}

fn joints(ours: &[Repeated]) -> Result<Joints, ReproduceError> {
    let exact = plan(&request(None, "per_joint"))?;
    let heads = ["method, joint", "paper [s]", "ours [s]", "optimum [s]", "speed", "acceleration"];
    let (mut findings, mut picture, mut over) = (Findings::new(&heads), Vec::new(), Vec::new());
    for (row, ours) in TABLE_5.iter().zip(ours) {
        for (index, published) in row.joints.iter().enumerate() {
            let (sample, optimum) = (ours.joint(index), alone(&exact, index).unwrap_or(f64::NAN));
            let [total, times @ ..] = published;
            let [speed, acceleration] = ratios(index, times)?;
            let surely = ratios(index, &rounded_up(times, 5e-5))?;
            let broken = surely[0].max(surely[1]) > EXCESS;
            let excess = broken.then_some(100.0 * (speed.max(acceleration) - 1.0));
            over.extend(excess);
            let (verdict, reason) = judge(published, excess, sample.mean(), optimum);
            let figures = [format!("{total:.4}"), sample.shown(1.0, 4), format!("{optimum:.4}")];
            let checks = [speed, acceleration].map(|ratio| format!("{ratio:.3}"));
            let name = [format!("{} {}", row.method, index + 1)];
            findings.add(name.into_iter().chain(figures).chain(checks).collect(), verdict, reason);
            let name = format!("{} joint {}", row.method, index + 1);
            picture.push(in_picture(name, *total, &sample, optimum));
        }
    }
    Ok(Joints { findings, picture, over })
}

/// Peaks of a joint at these times as multiples of their limits.
fn ratios(index: usize, times: &[f64; 3]) -> Result<[f64; 2], ReproduceError> {
    let peak = peaks_alone(FAMILY, &waypoints(), index, times)?;
    Ok([0, 1].map(|order| peak[order] / LIMITS[index][order]))
}

fn judge(published: &[f64; 4], excess: Option<f64>, ours: f64, optimum: f64) -> (Verdict, String) {
    let [total, times @ ..] = published;
    let sum: f64 = times.iter().sum();
    if let Some(over) = excess {
        let below = if *total < optimum {
            format!("; it lies below the true optimum, {optimum:.4} s, so no lawful motion has it")
        } else {
            String::new()
        };
        let reason = format!("At the published times the limit is exceeded by {over:.1} %{below}.");
        return (Verdict::BreaksItsLimits, reason);
    }
    if (sum - total).abs() > 1e-3 {
        let reason = format!("The three printed times sum to {sum:.4} s, not to {total} s.");
        return (Verdict::PaperContradictsItself, reason);
    }
    let verdict = Verdict::of(*total, ours, 0.01);
    let why = match verdict {
        Verdict::Reproduces => String::new(),
        _ => format!(
            ": the published total is {:.1} % above the optimum, ours {:.1} %. Parameters and the \
             treatment of candidates over a limit are not printed",
            100.0 * (total / optimum - 1.0),
            100.0 * (ours / optimum - 1.0)
        ),
    };
    (verdict, format!("In the mean {}{why}.", difference(*total, ours)))
}

fn composition(ours: &[Repeated]) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Chen et al., all joints together");
    let found = peaks(FAMILY, &waypoints(), &COMPOSED)?;
    let ratios =
        found.iter().zip(LIMITS).flat_map(|(peak, limit)| [0, 1].map(|i| peak[i] / limit[i]));
    let worst = ratios.fold(0.0, f64::max);
    section.paragraph(format!(
        "The paper takes for each segment the largest time of any joint. At the times it arrives \
         at, {COMPOSED:?} s, all joints together reach {worst:.3} of their limits: allowed. Ours \
         is composed likewise, and stretched where that breaks a limit."
    ));
    let mut findings = Findings::new(&["figure", "paper", "ours"]);
    for (row, ours) in TABLE_5.iter().zip(ours) {
        add_total(&mut findings, row, ours);
    }
    let sum: f64 = COMPOSED.iter().sum();
    findings.add(
        vec!["Total of the conclusion, s".to_owned(), CONCLUSION.to_string(), format!("{sum:.4}")],
        Verdict::PaperContradictsItself,
        format!(
            "The results print {sum:.4} s, to which the times sum; the conclusion {CONCLUSION} s."
        ),
    );
    section.learn(add_reductions(&mut findings, ours));
    section.findings(findings);
    let at_once = plan(&request(None, "shared"))?.duration;
    let composed = plan(&request(None, "per_joint"))?.duration;
    section.paragraph(format!(
        "Joint by joint is not the way: even exact times per joint, composed, need {composed:.4} \
         s. All joints planned at once need {at_once:.4} s on the same curves within the same \
         limits, {:.1} % less than published.",
        100.0 * (1.0 - at_once / sum)
    ));
    section.request("The request that plans all joints at once", request(None, "shared"));
    Ok(section)
}

fn add_total(findings: &mut Findings, row: &PublishedTimes, ours: &Repeated) {
    let sample = ours.durations();
    let verdict = Verdict::of(row.composed, sample.mean(), 0.01);
    let cells = vec![
        format!("{}, all joints, s", row.method),
        format!("{:.4}", row.composed),
        sample.shown(1.0, 4),
    ];
    let why = match verdict {
        Verdict::Reproduces => "",
        _ => {
            "; it hangs on the largest time of any joint, and so on single runs; joint 1's \
             published times also break its limit"
        }
    };
    findings.add(
        cells,
        verdict,
        format!("In the mean {}{why}.", difference(row.composed, sample.mean())),
    );
}

/// By how many percent GoldS-PSO is shorter, as text and abstract state it; and
/// in a sentence.
fn add_reductions(findings: &mut Findings, ours: &[Repeated]) -> String {
    let ours: Vec<f64> = ours.iter().map(|runs| runs.durations().mean()).collect();
    let [pso, gold_sa, best] = [0, 1, 2].map(|at| ours.get(at).copied().unwrap_or(f64::NAN));
    for ((than, text, summary), reference) in REDUCTIONS.into_iter().zip([BEFORE, pso, gold_sa]) {
        let saved = 100.0 * (1.0 - best / reference);
        let name = |place: &str| format!("GoldS-PSO shorter than {than}, {place}, %");
        // A difference of two totals that may each be 1 % off.
        let verdict = match (saved - text).abs() <= 1.5 {
            true => Verdict::Reproduces,
            false if saved > 0.1 * text => Verdict::OrderOfMagnitude,
            false => Verdict::DoesNotReproduce,
        };
        let reason = match verdict {
            Verdict::Reproduces => "Within 1.5 percentage points.",
            Verdict::OrderOfMagnitude => "Shorter, but by another share.",
            _ => {
                "In our runs GoldS-PSO is not, or hardly, the shorter one: the published figure \
                 compares one run with one other."
            }
        };
        findings.add(vec![name("text"), text.to_string(), number(saved, 2)], verdict, reason);
        findings.add(
            vec![name("abstract"), summary.to_string(), number(saved, 2)],
            Verdict::PaperContradictsItself,
            format!(
                "The text has {text} %, which follows from the printed totals; this follows from \
                 none."
            ),
        );
    }
    let [_, (_, than_pso, _), (_, than_gold_sa, _)] = REDUCTIONS;
    format!(
        "GoldS-PSO is said to be {than_pso} % shorter than PSO and {than_gold_sa} % than Gold-SA; \
         over our runs it is {} and {}.",
        compared(best, pso),
        compared(best, gold_sa)
    )
}

fn compared(ours: f64, other: f64) -> String {
    let percent = 100.0 * (1.0 - ours / other);
    let than = if percent < 0.0 { "longer" } else { "shorter" };
    format!("{} % {than}", number(percent.abs(), 1))
}
