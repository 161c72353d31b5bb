//! Shu et al.: what a second search over segment times saves, in four stages.
//! No node, limit or time of the paper survives in the text at hand, so that the
//! built-in scenarios' substitutes stand in.

use serde_json::{Value, json};

use super::experiment::{Repeated, ReproduceError, Sample, number, plan, repeat, scenario};
use super::possible::Problem;
use super::report::{Findings, Section};
use super::verdict::Verdict;
use crate::picture::{Beside, NAMES, beside};

pub(super) const CITATION: &str = "Shu, Ge, Wu, Chen, Zhang (Wenzhou University): Robot \
                                   trajectory planning with dual optimisation for flexible \
                                   breaker assembly (in Chinese; journal and year not known to \
                                   us)";

/// A stage: its name, its scenario, and by how many percent standard and dual
/// PSO are said to be shorter than random times, and dual PSO than standard.
const STAGES: [(&str, &str, [f64; 3]); 4] = [
    ("AB", "shu-ab", [11.9, 37.9, 26.0]),
    ("BC", "shu-bc", [22.0, 25.6, 3.6]),
    ("CD", "shu-cd", [22.6, 39.5, 16.9]),
    ("DE", "shu-de", [9.9, 17.3, 7.4]),
];

/// Methods as printed and by registry name.
const METHODS: [(&str, &str); 2] = [("standard PSO", "pso_linear"), ("dual PSO", "dual_pso")];

/// One stage planned from random times, by both methods, and exactly.
struct Stage {
    random: Repeated,
    single: Repeated,
    searched: [Repeated; 2],
    exact: f64,
}

/// A stage's scenario the paper's way: joint by joint, 0.1 to 5 s per segment.
fn request(stage: &str, optimizer: Value, handling: &str) -> Result<Value, ReproduceError> {
    let mut request = scenario(stage)?;
    request["task"]["clock"] = json!("per_joint");
    request["task"]["durations"] = json!({ "min": 0.1, "max": 5.0 });
    request["task"]["constraint_handling"] = json!(handling);
    request["task"]["optimizer"] = optimizer;
    Ok(request)
}

fn searching(stage: &str, method: &str, iterations: u32) -> Result<Value, ReproduceError> {
    let mut optimizer = json!({
        "name": method, "population": 50, "iterations": iterations,
        "cognitive_coefficient": 1.96, "social_coefficient": 1.96,
    });
    if method == "dual_pso" {
        // As printed: a second row over a limit is dropped.
        optimizer["h2_repair"] = json!(false);
    }
    request(stage, optimizer, "reject")
}

/// One set of random times per joint, stretched where it breaks a limit.
fn single(stage: &str) -> Result<Value, ReproduceError> {
    let one = json!({
        "name": "pso_linear", "population": 2, "iterations": 0, "max_evaluations": 1,
    });
    request(stage, one, "repair_segment")
}

impl Stage {
    fn run(scenario: &str, runs: u32) -> Result<Self, ReproduceError> {
        let search = |method: &str, iterations: u32| -> Result<Repeated, ReproduceError> {
            repeat(&searching(scenario, method, iterations)?, runs)
        };
        Ok(Self {
            random: search("pso_linear", 0)?,
            single: repeat(&single(scenario)?, runs)?,
            searched: [search("pso_linear", 15)?, search("dual_pso", 15)?],
            exact: plan(&super::experiment::scenario(scenario)?)?.duration,
        })
    }
}

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    let run = |(_, scenario, _): &(&str, &str, _)| Stage::run(scenario, runs);
    let stages = STAGES.iter().map(run).collect::<Result<Vec<_>, _>>()?;
    let mut section = Section::new("Shu et al.: savings in four stages, on substitutes");
    section.paragraph(
        "The paper states by how many percent plain and \"dual\" particle swarms shorten a \
         robot's four assembly stages, measured from random times. Its waypoints, limits, times \
         and its number of candidates are lost, and what \"random\" means is not said. Ours are \
         substitutes: AB from Han et al. (same laboratory, same cell), the rest computed with the \
         arm's kinematics; limits from Han et al.; clamped cubic splines, 50 candidates, 15 \
         iterations, factors 1.96, candidates over a limit rejected. The percentages therefore \
         show what the methods do, and cannot agree but by chance.",
    );
    section.paragraph(
        "Random is here the best of the 50 random candidates that the search of the same seed \
         starts from. Ours is the mean over the seeds, with quartiles.",
    );
    section.learn(lesson(&stages));
    section.findings(findings(&stages));
    section.rows(&HEADS, STAGES.iter().zip(&stages).map(times).collect());
    section.paragraph(format!(
        "The last column but one is a single random set of times per joint, each segment \
         stretched until it is lawful; runs that would need more than 5 s per segment have none. \
         Measured from there, dual PSO saves in the median {}. What a percentage of a random \
         start says about a method depends on what is called random.",
        STAGES.iter().zip(&stages).map(from_single).collect::<Vec<_>>().join(", ")
    ));
    section.figure(picture(&stages), "Savings in percent: published, and ours on substitutes.");
    for (_, method) in METHODS {
        let title = format!("The request behind {method}, stage AB, with seeds from 0 up");
        section.request(title, searching("shu-ab", method, 15)?);
    }
    section.request(
        "The request behind the random start, stage AB",
        searching("shu-ab", "pso_linear", 0)?,
    );
    Ok(vec![section])
}

fn from_single(((name, ..), stage): (&(&str, &str, [f64; 3]), &Stage)) -> String {
    let [_, dual] = &stage.searched;
    let saved = dual.savings(&stage.single).quartiles().map_or(f64::NAN, |[_, median, _]| median);
    format!("{} % ({name})", number(100.0 * saved, 0))
}

fn lesson(stages: &[Stage]) -> String {
    let gain = |stage: &Stage| Some(stage.gain()).filter(|gain| !gain.is_nan());
    let gains = Sample::new(stages.iter().map(gain));
    let printed = Sample::new(STAGES.iter().map(|(_, _, [.., points])| Some(*points)));
    format!(
        "Waypoints and limits are lost. On substitutes the dual search saves {} percentage points \
         more than the plain one, where the paper prints {}.",
        gains.range(1),
        printed.range(1)
    )
}

fn findings(stages: &[Stage]) -> Findings {
    let heads = ["shorter than random times, by", "paper [%]", "ours [%]"];
    let mut findings = Findings::new(&heads);
    for ((name, _, published), stage) in STAGES.iter().zip(stages) {
        for (at, (method, _)) in METHODS.into_iter().enumerate() {
            let ours = stage.searched[at].savings(&stage.random);
            findings.add(
                vec![format!("{name}, {method}"), published[at].to_string(), ours.shown(100.0, 1)],
                Verdict::CannotBeCompared,
                "Waypoints, limits and the random times are not printed.",
            );
        }
    }
    for ((name, _, [standard, dual, difference]), stage) in STAGES.iter().zip(stages) {
        let gain = stage.gain();
        findings.add(
            vec![
                format!("{name}, dual PSO more than standard PSO, points"),
                difference.to_string(),
                number(gain, 1),
            ],
            Verdict::CannotBeCompared,
            format!("{dual} - {standard}, as printed; waypoints, limits and random times are not."),
        );
    }
    findings
}

impl Stage {
    /// By how many percentage points the dual search saves more.
    fn gain(&self) -> f64 {
        let [standard, dual] = &self.searched;
        100.0 * (dual.savings(&self.random).mean() - standard.savings(&self.random).mean())
    }
}

const HEADS: [&str; 6] = [
    "stage",
    "random [s]",
    "standard PSO [s]",
    "dual PSO [s]",
    "single random set [s]",
    "all joints at once, exact [s]",
];

fn times(
    ((name, ..), stage): (&(&str, &str, [f64; 3]), &Stage),
) -> Vec<crate::picture::page::Cell> {
    use crate::picture::page::Cell;
    let [standard, dual] = &stage.searched;
    let samples = [&stage.random, standard, dual, &stage.single];
    let samples = samples.map(|runs| Cell::number(runs.durations().shown(1.0, 2)));
    let exact = Cell::number(format!("{:.4}", stage.exact));
    [Cell::text(*name)].into_iter().chain(samples).chain([exact]).collect()
}

fn picture(stages: &[Stage]) -> String {
    let mut rows = Vec::new();
    for ((name, _, published), stage) in STAGES.iter().zip(stages) {
        for (at, (method, _)) in METHODS.into_iter().enumerate() {
            let ours = stage.searched[at].savings(&stage.random).quartiles();
            rows.push(Beside {
                name: format!("{name} {method}"),
                published: Some(published[at]),
                ours: ours.map(|quartiles| quartiles.map(|share| 100.0 * share)),
                optimum: None,
            });
        }
    }
    beside("Savings from random times", "saved [%]", NAMES, &rows)
}

/// The stages, for what is possible.
pub(super) fn problems() -> Vec<Problem> {
    let problem = |(name, scenario, _): &(&str, &'static str, _)| Problem {
        name: format!("Shu et al., {name} (substitute)"),
        published: None,
        family: "cubic",
        jerk_limited: false,
        scenario,
    };
    STAGES.iter().map(problem).collect()
}
