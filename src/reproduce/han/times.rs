//! Table 5 and Figure 13: section AB, joint by joint and all joints together.

use serde_json::{Value, json};

use super::data::{COMPOSED, FIGURE_13, REDUCTION, SPEEDS, TABLE_3, TABLE_4, TABLE_5};
use super::{FAMILY, request, speed_alone, table_4, waypoints};
use crate::picture::{Beside, NAMES, beside};
use crate::reproduce::experiment::{
    EXCESS, ReproduceError, Sample, alone, difference, in_picture, largest, peaks, peaks_alone,
    plan, repeat, rounded_up,
};
use crate::reproduce::report::{Findings, Section};
use crate::reproduce::verdict::Verdict;

/// Times are printed to two decimals: up to 2 % of the shortest, and so of peaks.
const ROUNDING: f64 = 1.02;

/// Methods of Table 5 as printed, and by registry name.
const METHODS: [(&str, &str); 2] = [("standard PSO", "pso"), ("improved PSO", "improved_pso")];

fn method(optimizer: &str, clock: &str) -> Value {
    let optimizer = json!({ "name": optimizer, "population": 50, "iterations": 100 });
    request(optimizer, clock, speed_alone())
}

fn exact(clock: &str, limits: Value) -> Value {
    request(json!({ "name": "exact" }), clock, limits)
}

pub(super) fn table_5(runs: u32) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., Table 5: each joint alone");
    section.paragraph(
        "How long each joint needs, moved alone through the four waypoints of section AB on \
         quintics that are smooth up to the jerk. 50 candidates, 100 iterations. The limits are \
         speed alone, 0.5 rad/s and 1.0 rad/s for joint 6: the peaks at the published times show \
         that these were used, not Table 4. The improved method stretches what breaks a limit, \
         its \"fitness switch\"; of the standard one the paper does not say, and candidates over \
         a limit are rejected. Ours is the mean over the seeds, with quartiles. A total \
         reproduces if ours is within 1 %.",
    );
    let (mut findings, picture) = joints(runs)?;
    let worst = add_limits(&mut findings)?;
    section.learn(format!(
        "The published times follow from speed limits that the paper does not print. Under its \
         own Table 4 they reach up to {worst:.0} times the jerk limit."
    ));
    section.findings(findings);
    let caption = "Joint 4 does not move in section AB.";
    section.figure(beside("Table 5: times per joint", "duration [s]", NAMES, &picture), caption);
    section.request(
        "The request behind \"ours\", with seeds from 0 up",
        method("improved_pso", "per_joint"),
    );
    section.request("The request behind the optimum", exact("per_joint", speed_alone()));
    Ok(section)
}

/// Table 5 joint by joint, as findings and for a picture.
fn joints(runs: u32) -> Result<(Findings, Vec<Beside>), ReproduceError> {
    let optima = plan(&exact("per_joint", speed_alone()))?;
    let heads = ["method, joint", "paper [s]", "ours [s]", "optimum [s]", "peak speed [rad/s]"];
    let (mut findings, mut picture) = (Findings::new(&heads), Vec::new());
    for (column, (title, name)) in METHODS.into_iter().enumerate() {
        let ours = repeat(&method(name, "per_joint"), runs)?;
        for (index, published) in TABLE_5 {
            let (times, total) = (published[column], published[column].iter().sum::<f64>());
            let (sample, optimum) = (ours.joint(index), alone(&optima, index).unwrap_or(f64::NAN));
            let speed = |times: &[f64; 3]| -> Result<f64, ReproduceError> {
                Ok(peaks_alone(FAMILY, &waypoints(), index, times)?[0])
            };
            let (peak, surely) = (speed(&times)?, speed(&rounded_up(&times, 5e-3))?);
            let ratios = [peak, surely].map(|speed| speed / SPEEDS[index]);
            let (verdict, reason) = judge(total, &sample, optimum, ratios);
            let figures = [format!("{total:.2}"), sample.shown(1.0, 4), format!("{optimum:.4}")];
            let cells = [format!("{title} {}", index + 1)].into_iter().chain(figures);
            findings.add(cells.chain([format!("{peak:.3}")]).collect(), verdict, reason);
            let name = format!("{title} joint {}", index + 1);
            picture.push(in_picture(name, total, &sample, optimum));
        }
    }
    Ok((findings, picture))
}

/// `worst` and `surely` are the peak as a multiple of its limit at the printed
/// times and at those rounded up.
fn judge(total: f64, ours: &Sample, optimum: f64, [worst, surely]: [f64; 2]) -> (Verdict, String) {
    if surely > EXCESS {
        let [over, still] = [worst, surely].map(|ratio| 100.0 * (ratio - 1.0));
        let reason = format!(
            "Peak speed is {over:.1} % over the limit, and {still:.1} % even with 0.005 s more \
             per segment for rounding; the true optimum is {optimum:.4} s."
        );
        return (Verdict::BreaksItsLimits, reason);
    }
    let verdict = Verdict::of(total, ours.mean(), 0.01);
    let above = 100.0 * (total / optimum - 1.0);
    let at = match (worst, verdict) {
        (_, Verdict::Reproduces) => String::new(),
        (worst, _) if worst < 0.99 => {
            format!(
                "; the published times stay {:.0} % below the speed limit",
                100.0 * (1.0 - worst)
            )
        }
        _ if above > 1.0 => format!("; the published search ended {above:.1} % above the optimum"),
        _ => "; the published times are at the optimum, which our runs miss in the mean".to_owned(),
    };
    (verdict, format!("In the mean {}{at}.", difference(total, ours.mean())))
}

/// Table 5 holds times that Table 4 does not allow. Returns the largest jerk as a
/// multiple of its limit.
fn add_limits(findings: &mut Findings) -> Result<f64, ReproduceError> {
    let mut worst = 0.0f64;
    for (index, published) in TABLE_5 {
        let [_, acceleration, jerk] = peaks_alone(FAMILY, &waypoints(), index, &published[1])?;
        let [limit, most] = [TABLE_4[1][index], TABLE_4[2][index]];
        worst = worst.max(jerk / most);
        if acceleration > limit * ROUNDING || jerk > most * ROUNDING {
            let name = format!("improved PSO {}, under Table 4", index + 1);
            let total: f64 = published[1].iter().sum();
            let cells =
                vec![name, format!("{total:.2}"), "-".to_owned(), "-".to_owned(), "-".to_owned()];
            let reason = format!(
                "Alone at its published times it reaches {acceleration:.2} rad/s^2 and {jerk:.1} \
                 rad/s^3, where Table 4 allows {limit} and {most}."
            );
            findings.add(cells, Verdict::BreaksItsLimits, reason);
        }
    }
    Ok(worst)
}

pub(super) fn together(runs: u32) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., all joints of section AB together");
    section.paragraph(
        "The paper takes for each segment the largest time of any joint. Ours is composed \
         likewise under the same speed limits, and stretched where that breaks one.",
    );
    let mut findings = Findings::new(&["figure", "paper", "ours"]);
    add_totals(&mut findings, runs)?;
    let [before, after] = [TABLE_3, COMPOSED[1]].map(|times| times.iter().sum::<f64>());
    let reduction = 100.0 * (1.0 - after / before);
    findings.add(
        vec!["Shorter than before, %".to_owned(), REDUCTION.to_string(), format!("{reduction:.2}")],
        Verdict::adding_up(REDUCTION - reduction),
        format!("From the printed {before} s and {after:.2} s."),
    );
    add_peaks(&mut findings)?;
    section.findings(findings);
    let exact_now = plan(&exact("shared", table_4()))?.duration;
    section.paragraph(format!(
        "All joints planned at once (exact) need {exact_now:.4} s on the same curves within Table \
         4, which limits acceleration and jerk too; published are {after:.2} s."
    ));
    section.request("The request that plans all joints at once", exact("shared", table_4()));
    Ok(section)
}

fn add_totals(findings: &mut Findings, runs: u32) -> Result<(), ReproduceError> {
    for (times, (title, name)) in COMPOSED.iter().zip(METHODS) {
        let published: f64 = times.iter().sum();
        let sample = repeat(&method(name, "per_joint"), runs)?.durations();
        let verdict = Verdict::of(published, sample.mean(), 0.01);
        let why = match verdict {
            Verdict::Reproduces => "",
            _ => "; joint 1's published times, which decide segment 1, are above its optimum",
        };
        findings.add(
            vec![format!("{title}, total, s"), format!("{published:.2}"), sample.shown(1.0, 4)],
            verdict,
            format!("In the mean {}{why}.", difference(published, sample.mean())),
        );
    }
    Ok(())
}

/// Figure 13.
fn add_peaks(findings: &mut Findings) -> Result<(), ReproduceError> {
    let found = peaks(FAMILY, &waypoints(), &COMPOSED[1])?;
    let names = ["Peak acceleration in Figure 13, rad/s^2", "Peak jerk in Figure 13, rad/s^3"];
    for ((name, published), order) in names.into_iter().zip(FIGURE_13).zip([1, 2]) {
        let ours = largest(&found, order);
        findings.add(
            vec![name.to_owned(), published.to_string(), format!("{ours:.3}")],
            Verdict::of(published, ours, 0.03),
            "Exact peak at the published times. Tolerance 3 %: the printed one has two or three \
             digits.",
        );
    }
    Ok(())
}
