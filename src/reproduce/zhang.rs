//! Zhang et al. 2023: five planners on two maps of a plane, and four ways in a
//! box of 1 m. Maps, algorithms and constants are missing from the text that
//! could be had; substitutes stand in and are named.

use serde_json::{Value, json};

use super::experiment::{ReproduceError, Sample, number, paths, scenario};
use super::possible::Problem;
use super::report::{Findings, Section};
use super::verdict::Verdict;
use crate::picture;
use crate::picture::page::Cell;
use crate::plan::PathResult;

pub(super) const CITATION: &str = "Zhang, Li, Duan, Qin, Zhou: Multi-Objective Point Motion \
                                   Planning for Assembly Robotic Arm Based on IPQ-RRT* Connect \
                                   Algorithm, Actuators 12 (2023) 459, doi:10.3390/act12120459";

/// The paper's planners in its order, by registry name.
const PLANNERS: [&str; 5] =
    ["rrt_star", "informed_rrt_star", "bi_apf_rrt_star", "pq_rrt_star", "ipq_rrt_star_connect"];

/// A map: its scenario, and what the paper prints for IPQ-RRT*-connect on it, in
/// percent of another planner's figure.
struct Map {
    scenario: &'static str,
    name: &'static str,
    length: f64,
    time: f64,
    iterations: f64,
    /// Planners that found nothing in the paper's 200 s.
    failures: &'static [&'static str],
}

const MAPS: [Map; 2] = [
    Map {
        scenario: "zhang-plane-1",
        name: "map 1",
        length: -5.24,
        time: -96.97,
        iterations: -56.46,
        failures: &[],
    },
    Map {
        scenario: "zhang-plane-2",
        name: "map 2",
        length: -6.34,
        time: -85.67,
        iterations: -31.25,
        failures: &["informed_rrt_star", "bi_apf_rrt_star"],
    },
];

/// Iterations after which a run without a path counts as failed.
const MOST: u64 = 20_000;

/// The four ways of the box, mm: P0 over the end effector, P1 fixture table, P2
/// conveyor, P3 assembly table.
const WAYS: [(&str, [f64; 3], [f64; 3]); 4] = [
    ("P0 to P1", [500.0, 0.0, 600.0], [0.0, 789.2, 100.0]),
    ("P1 to P2", [0.0, 789.2, 100.0], [907.6, 612.5, 100.0]),
    ("P2 to P3", [907.6, 612.5, 100.0], [702.4, -200.6, 100.0]),
    ("P3 to P1", [702.4, -200.6, 100.0], [0.0, 789.2, 100.0]),
];

/// One planner's runs on one map.
struct Runs {
    planner: &'static str,
    found: Vec<Option<PathResult>>,
}

impl Runs {
    fn sample(&self, figure: impl Fn(&PathResult) -> f64) -> Sample {
        Sample::new(self.found.iter().map(|run| run.as_ref().map(&figure)))
    }

    fn failed(&self) -> usize {
        self.found.iter().filter(|run| run.is_none()).count()
    }
}

pub(super) fn problems() -> Vec<Problem> {
    Vec::new()
}

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    let mut sections = Vec::new();
    for map in &MAPS {
        sections.push(plane(map, runs)?);
    }
    sections.push(ways()?);
    Ok(sections)
}

/// A planner's first path on a map, with the step of 4 mm of the substitute's
/// trial, and otherwise with what its sources say.
fn request(map: &Map, planner: &str) -> Result<Value, ReproduceError> {
    let mut request = scenario(map.scenario)?;
    let mut settings =
        json!({ "name": planner, "range": 4, "iterations": MOST, "first_path": true });
    let own = match planner {
        "rrt_star" => json!({ "goal_reach": 4 }),
        "informed_rrt_star" => json!({ "goal_reach": 4, "cut_corners": false }),
        "pq_rrt_star" => json!({ "goal_reach": 4, "descent_stride": 0.5, "keep_off": 1 }),
        "ipq_rrt_star_connect" => {
            json!({ "descent_stride": 0.5, "keep_off": 1, "open_space": 6 })
        }
        _ => json!({}),
    };
    if let (Some(settings), Value::Object(own)) = (settings.as_object_mut(), own) {
        settings.extend(own);
    }
    request["task"]["planner"] = settings;
    request["task"]["smoothing"] = json!({ "name": "bezier", "shortcut": false });
    Ok(request)
}

fn plane(map: &Map, runs: u32) -> Result<Section, ReproduceError> {
    let mut section = Section::new(format!("Zhang et al., {}", map.name));
    section.paragraph(
        "Start, goal and the size of 100 mm are the paper's; where its obstacles stand is not in the \
         text, so a substitute map stands in, and figures cannot be compared one by one. Improved \
         Bi-APF-RRT* is only named by the paper and built here from public relatives; \
         IPQ-RRT*-connect is rebuilt from words. Steps of 4 mm; every run ends with its first path, \
         or without one after 20,000 iterations, where the paper's ended after 200 s. Times of \
         one machine say nothing about another and would make this report differ from run to run: \
         motions checked stand in for them. Mean and quartiles over the seeds.",
    );
    let mut all = Vec::new();
    for planner in PLANNERS {
        all.push(Runs { planner, found: paths(&request(map, planner)?, runs)? });
    }
    section.rows(
        &[
            "planner",
            "without a path",
            "iterations",
            "motions checked",
            "nodes",
            "length [mm]",
            "smoothed [mm]",
        ],
        all.iter().map(row).collect(),
    );
    section.findings(findings(map, &all));
    for runs in &all[3..] {
        if let Some(first) = runs.found.iter().flatten().next() {
            let caption = format!(
                "{}, {}: trees, the first path, and its corners as Bezier curves.",
                map.name, runs.planner
            );
            section.figure(picture::path(first), caption);
        }
    }
    section.learn(lesson(&all));
    let requests = PLANNERS.iter().map(|planner| request(map, planner));
    section.requests(
        "The requests behind the table, with seeds from 0 up",
        requests.collect::<Result<_, _>>()?,
    );
    Ok(section)
}

fn row(runs: &Runs) -> Vec<Cell> {
    let figures = [
        format!("{} of {}", runs.failed(), runs.found.len()),
        runs.sample(|it| it.iterations as f64).shown(1.0, 0),
        runs.sample(|it| it.evaluations as f64).shown(1.0, 0),
        runs.sample(|it| it.nodes as f64).shown(1.0, 0),
        runs.sample(|it| it.length).shown(1.0, 1),
        runs.sample(|it| it.best_length()).shown(1.0, 1),
    ];
    [Cell::text(runs.planner)].into_iter().chain(figures.map(Cell::number)).collect()
}

/// By how many percent the mean of `figure` for IPQ-RRT*-connect is above that of
/// the planner at `other`.
fn percent(all: &[Runs], other: usize, figure: impl Fn(&PathResult) -> f64) -> f64 {
    let [ours, theirs] = [4, other].map(|planner| all[planner].sample(&figure).mean());
    100.0 * (ours / theirs - 1.0)
}

fn findings(map: &Map, all: &[Runs]) -> Findings {
    let mut findings = Findings::new(&["IPQ-RRT*-connect", "paper [%]", "ours [%]"]);
    let cells = |what: &str, published: f64, ours: f64| {
        let name = format!("{}, {what}", map.name);
        vec![name, format!("{published:.2}"), number(ours, 2)]
    };
    let length = percent(all, 3, |it| it.length);
    findings.add(
        cells("length against PQ-RRT*, by how much", map.length, length),
        Verdict::CannotBeCompared,
        "The map is a substitute.",
    );
    findings.add(
        cells("length against PQ-RRT*, shorter at all", map.length, length),
        Verdict::shown(length < 0.0),
        "On the substitute. A first path of two trees that head for each other is no shorter than \
         one of a tree that was rewired all the way; paths get shorter by going on.",
    );
    let time = percent(all, 2, |it| it.evaluations as f64);
    let iterations = percent(all, 2, |it| it.iterations as f64);
    for (what, published, ours) in [
        ("time against Bi-APF-RRT*", map.time, time),
        ("iterations against Bi-APF-RRT*", map.iterations, iterations),
    ] {
        let reason = "The paper only names that planner; as built here it is a strong one, and it \
                      may be another. An iteration of IPQ-RRT*-connect extends two trees, one of \
                      the others extends one.";
        findings.add(cells(what, published, ours), Verdict::CannotBeCompared, reason);
    }
    for planner in map.failures {
        let Some(runs) = all.iter().find(|runs| runs.planner == *planner) else { continue };
        let share = 100.0 * runs.failed() as f64 / runs.found.len().max(1) as f64;
        let (verdict, reason) = match *planner {
            "bi_apf_rrt_star" => (
                Verdict::CannotBeCompared,
                "The paper only names that planner. Ours are runs without a path after 20,000 \
                 iterations on the substitute.",
            ),
            _ => (
                Verdict::shown(share > 50.0),
                "Ours are runs without a path after 20,000 iterations on the substitute. Until \
                 there is a path this planner is RRT*, which the paper has succeed.",
            ),
        };
        findings.add(cells(&format!("{planner} finds no path"), 100.0, share), verdict, reason);
    }
    findings
}

fn lesson(all: &[Runs]) -> String {
    format!(
        "On a substitute map IPQ-RRT*-connect takes {} % of the iterations of PQ-RRT* to a first path \
         that is {} % longer.",
        number(100.0 + percent(all, 3, |it| it.iterations as f64), 0),
        number(percent(all, 3, |it| it.length), 1)
    )
}

/// One of the ways, in the box of the scenario.
fn way(start: [f64; 3], goal: [f64; 3], planner: &str) -> Result<Value, ReproduceError> {
    let mut request = scenario("zhang-box")?;
    request["task"]["start"] = json!(start);
    request["task"]["goal"] = json!(goal);
    request["task"]["planner"] = json!({ "name": planner });
    if planner == "ipq_rrt_star_connect" {
        request["task"]["planner"] = json!({
            "name": planner, "range": 40, "descent_stride": 5, "keep_off": 10, "open_space": 60,
            "iterations": 1000,
        });
    }
    Ok(request)
}

fn ways() -> Result<Section, ReproduceError> {
    let mut section = Section::new("Zhang et al., the box of 1 m");
    section.paragraph(
        "Four ways between the paper's points, mm, among six balls that stand in for its own; P3 \
         lies outside of 0 to 1000, so the box reaches from -300 to 900 in y. The paper prints no \
         length. By IPQ-RRT*-connect and by what Takt takes of its own accord; shortcuts, then \
         cubic Bezier curves, every curve checked against every ball.",
    );
    let (mut rows, mut requests) = (Vec::new(), Vec::new());
    for (name, start, goal) in WAYS {
        let mut cells = vec![Cell::text(name)];
        for planner in ["ipq_rrt_star_connect", "auto"] {
            let request = way(start, goal, planner)?;
            let found = paths(&request, 1)?.into_iter().flatten().next();
            let result =
                found.ok_or_else(|| ReproduceError(format!("no way for {name} by {planner}")))?;
            if cells.len() == 1 {
                cells.push(Cell::number(format!("{:.1}", result.straight_length)));
            }
            cells.push(Cell::number(format!("{:.1}", result.length)));
            cells.push(Cell::number(format!("{:.1}", result.best_length())));
            if planner == "auto" && rows.is_empty() {
                let caption = format!("{name}, seen from above.");
                section.figure(picture::path(&result), caption);
            }
            requests.push(request);
        }
        rows.push(cells);
    }
    let heads = ["way", "straight", "IPQ-RRT*-connect", "smoothed", "auto", "smoothed"];
    section.rows(&heads, rows);
    section.learn(
        "All four ways are found around the substitute balls, and smoothed without touching.",
    );
    section.requests("The requests behind the table", requests);
    Ok(section)
}
