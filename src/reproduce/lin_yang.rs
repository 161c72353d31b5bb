//! Lin and Yang: Table 5, times of a palletizing arm. Joint values and a sixth
//! point are not printed; the built-in scenario's substitutes stand in.

use serde_json::{Value, json};

use super::experiment::{Repeated, ReproduceError, alone, peaks, plan, repeat, scenario};
use super::possible::Problem;
use super::report::{Findings, Section};
use super::verdict::Verdict;
use crate::picture::page::Cell;
use crate::plan::TrajectoryResult;

pub(super) const CITATION: &str = "Lin, Yang (Chongqing University of Posts and \
                                   Telecommunications): Research on trajectory planning of 6R \
                                   palletizing robot based on adaptive genetic algorithm (journal \
                                   and year not known to us)";

/// The curve as published, and its successor that a robot can follow.
const FAMILIES: [&str; 2] = ["bspline_uniform", "bspline"];

const SCENARIO: &str = "palletizing-points";

/// Table 5: the four printed times of each row, and the printed total, s.
const TABLE_5: [(&str, [f64; 4], f64); 7] = [
    ("initial", [2.0, 2.0, 2.0, 2.0], 10.0),
    ("joint 1", [1.032, 1.092, 0.934, 1.025], 4.919),
    ("joint 2", [1.154, 0.0, 0.451, 0.733], 2.973),
    ("joint 3", [0.326, 0.0, 0.058, 0.236], 0.658),
    ("joint 4", [0.0, 0.0, 0.0, 0.634], 1.359),
    ("joint 5", [0.0, 0.0, 0.0, 0.725], 1.807),
    ("joint 6", [0.0, 0.0, 0.965, 0.542], 2.131),
];

/// The published points on `family`: joint by joint with the adaptive genetic
/// algorithm, or exactly.
fn request(family: &str, exact: bool) -> Result<Value, ReproduceError> {
    let mut request = scenario(SCENARIO)?;
    let task = &mut request["task"];
    task["interpolation"] = json!(family);
    task["clock"] = json!("per_joint");
    task["optimizer"] = json!({ "name": "exact" });
    if !exact {
        task["optimizer"] = json!({ "name": "aga", "population": 100, "iterations": 100 });
        task["constraint_handling"] = json!("penalty");
        task["durations"] = json!({ "min": 0.05, "max": 3.0 });
    }
    Ok(request)
}

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    Ok(vec![totals(), per_joint(runs)?])
}

/// What the table says about itself.
fn totals() -> Section {
    let mut section = Section::new("Lin and Yang, Table 5: totals");
    section.paragraph(
        "Four times per row and their total are printed. In no row do they agree, and even the \
         row before any optimisation, four times 2 s, is printed as 10 s: a fifth interval must \
         have been left out, and with it a sixth point, of which Table 3 prints five.",
    );
    let mut findings =
        Findings::new(&["row", "paper, total [s]", "sum of its times [s]", "missing [s]"]);
    for (name, times, total) in TABLE_5 {
        let sum: f64 = times.iter().sum();
        let missing = total - sum;
        let figures = [total, sum, missing].map(|value| format!("{value:.3}"));
        let cells = [name.to_owned()].into_iter().chain(figures).collect();
        findings.add(cells, Verdict::adding_up(missing), "A fifth time is missing.");
    }
    section.findings(findings);
    section.learn(
        "No printed total is the sum of its printed times: a fifth interval was left out, and \
         without its point and the joint values nothing can be run again as published.",
    );
    section
}

fn per_joint(runs: u32) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Lin and Yang, Table 5: each joint alone, on substitutes");
    section.paragraph(
        "The five printed points on a stand-in arm (FANUC M-10iA), tool straight down, since \
         Table 4 with the joint values is not printed; limits of Table 2, printed in percent and \
         read as deg/s and deg/s^2. Adaptive genetic algorithm, 100 individuals, 100 generations, \
         penalty for what breaks a limit, 0.05 to 3 s per interval (not printed). On the \
         published uniform B-spline, whose speed jumps at every waypoint between unequal times, \
         so that no robot can follow it, and on Takt's \"bspline\", which a robot can. Ours is \
         the mean over the seeds, with quartiles.",
    );
    let [faithful, executable] = FAMILIES;
    let mut columns = Vec::new();
    for family in FAMILIES {
        columns.push((repeat(&request(family, false)?, runs)?, plan(&request(family, true)?)?));
    }
    section.findings(joints(&columns));
    let searched = columns.iter().map(|(runs, _)| runs.durations().shown(1.0, 3));
    let exact = columns.iter().map(|(_, exact)| format!("{:.3}", exact.duration));
    let rows = vec![
        composed("adaptive genetic algorithm, largest times per segment", searched),
        composed("exact, largest times per segment", exact),
    ];
    section.rows(&["all joints", "bspline_uniform [s]", "bspline [s]"], rows);
    section.paragraph(start()?);
    section.request(
        "The request behind \"bspline_uniform\", with seeds from 0 up",
        request(faithful, false)?,
    );
    section.request(
        "The request behind \"bspline\", with seeds from 0 up",
        request(executable, false)?,
    );
    Ok(section)
}

/// Each joint's times, per family the searched and the exact ones.
fn joints(columns: &[(Repeated, TrajectoryResult)]) -> Findings {
    let heads = [
        "row",
        "paper, sum [s]",
        "bspline_uniform [s]",
        "optimum [s]",
        "bspline [s]",
        "optimum [s]",
    ];
    let mut findings = Findings::new(&heads);
    for (index, (name, times, _)) in TABLE_5.iter().skip(1).enumerate() {
        let sum: f64 = times.iter().sum();
        let ours = columns.iter().flat_map(|(runs, exact)| match alone(exact, index) {
            Some(optimum) => [runs.joint(index).shown(1.0, 3), format!("{optimum:.3}")],
            None => ["does not move".to_owned(), "-".to_owned()],
        });
        let cells = [(*name).to_owned(), format!("{sum:.3}")].into_iter().chain(ours).collect();
        findings.add(cells, Verdict::CannotBeCompared, reason(times));
    }
    findings
}

fn composed(name: &str, durations: impl Iterator<Item = String>) -> Vec<Cell> {
    [Cell::text(name)].into_iter().chain(durations.map(Cell::number)).collect()
}

fn reason(times: &[f64; 4]) -> &'static str {
    match times.contains(&0.0) {
        true => {
            "Joint values are not printed. Its times of 0 s cannot be those of a joint that \
             moves; the joint probably rests there."
        }
        false => "Joint values are not printed.",
    }
}

/// Whether the printed start, 2 s per interval, is within the limits.
fn start() -> Result<String, ReproduceError> {
    let exact = plan(&request(FAMILIES[0], true)?)?;
    let limits = &exact.certificate.joints;
    let found = peaks(FAMILIES[0], &exact.waypoints, &TABLE_5[0].1)?;
    let ratios = found.iter().zip(limits).flat_map(|(peak, joint)| {
        let limits = [joint.velocity.limit, joint.acceleration.limit];
        limits.into_iter().zip(peak).filter_map(|(limit, peak)| Some(peak / limit?))
    });
    let worst = ratios.fold(0.0, f64::max);
    Ok(format!(
        "At the paper's start, 2 s per interval, the substitute motion reaches {worst:.2} of its \
         limits: {}",
        if worst > 1.0 {
            "more than allowed, so that on these joint values nothing within the limits is as \
             short as the paper's start on its own curve."
        } else {
            "allowed."
        }
    ))
}

/// The points, for what is possible.
pub(super) fn problems() -> Vec<Problem> {
    vec![Problem {
        name: "Lin and Yang (substitute)".to_owned(),
        published: None,
        family: FAMILIES[0],
        jerk_limited: false,
        scenario: SCENARIO,
    }]
}
