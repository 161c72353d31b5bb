//! Pictures that are not XML, or leave out a joint, a unit or a limit, would
//! pass unnoticed without these tests.

use serde_json::json;

use crate::optimize::ConvergencePoint;
use crate::plan::{ComparisonResult, PathResult, PlanResult, TrajectoryResult};
use crate::trajectory::Quantity;

use super::{Curve, Fitness, Section, bands, convergence, gaps, page, pareto, path, plot};

/// A motion of `dof` joints in two quintic-like pieces, every second one
/// prismatic, with values around `size` and pieces of `length` seconds.
pub(super) fn result(
    dof: usize,
    size: f64,
    length: f64,
    limit: impl Fn(usize) -> Option<f64>,
) -> TrajectoryResult {
    let names: Vec<String> = (0..dof).map(|j| format!("joint_{j}")).collect();
    let units: Vec<&str> = (0..dof).map(|j| if j % 2 == 0 { "rad" } else { "m" }).collect();
    let power = |k: i32| size / length.powi(k);
    let pieces: Vec<Vec<Vec<f64>>> = [1.0, -1.0]
        .iter()
        .map(|sign| {
            (0..dof)
                .map(|j| {
                    let share = sign * (j as f64 + 1.0) / dof as f64;
                    vec![
                        0.1 * size,
                        0.0,
                        0.0,
                        10.0 * power(3) * share,
                        -15.0 * power(4) * share,
                        6.0 * power(5) * share,
                    ]
                })
                .collect()
        })
        .collect();
    let joints: Vec<_> = (0..dof)
        .map(|j| {
            let peak = json!({"peak": size, "at": 0.0, "limit": limit(j), "ratio": null, "provenance": null});
            json!({"name": names[j], "velocity": peak, "acceleration": peak, "jerk": peak,
                "position": {"min": 0.0, "min_at": 0.0, "max": 1.0, "max_at": 0.0,
                    "lower": limit(j).map(|l| -l), "upper": limit(j), "provenance": null}})
        })
        .collect();
    let mut result: TrajectoryResult = serde_json::from_value(json!({
        "robot": "test & robot", "joint_names": names, "joint_units": units, "duration": 2.0 * length,
        "durations": [length, length], "waypoint_times": [0.0, length, 2.0 * length], "waypoints": [],
        "trajectory": {"breakpoints": [0.0, length, 2.0 * length], "pieces": []},
        "certificate": {"lawful": true, "worst_ratio": 0.5, "continuity": 2, "starts_at_rest": true,
            "ends_at_rest": true, "joints": joints, "violations": [], "waypoint_error": null,
            "clearance": null, "sha256": ""},
        "bound": null,
        "metrics": {"initial_duration": 1.0, "saved": 0.0, "rms_jerk": [], "mean_utilisation": [],
            "path_length": [], "binding": []},
        "convergence": [], "interpolation": "quintic", "optimizer": "exact",
        "stop_reason": "converged", "iterations": 1, "evaluations": 1, "planning_s": 0.0, "seed": 0,
        "version": "0",
    }))
    .unwrap();
    // Not by way of JSON, which has no infinity.
    result.trajectory.pieces = pieces;
    result
}

fn plot_all(result: &TrajectoryResult) -> String {
    plot(&[Section { name: None, start: 0.0, result }], &Quantity::ALL)
}

/// Checks tags, attributes and entities, and that all numbers are numbers.
pub(super) fn assert_well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for part in svg.split('<').skip(1) {
        let (tag, text) = part.split_once('>').expect("every tag is closed");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        for value in tag.split('"').chain([text]) {
            for entity in value.split('&').skip(1) {
                let known = ["amp;", "lt;", "gt;", "quot;", "apos;"];
                assert!(known.iter().any(|known| entity.starts_with(known)), "{entity}");
            }
            assert!(!value.contains("NaN") && value.trim() != "inf", "{value}");
        }
    }
    assert!(open.is_empty() && svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    assert!(!svg.chars().any(|c| c.is_control() && c != '\n'), "control character");
}

/// The number of dashed lines of limits: the legend has one more.
fn dashed_lines(svg: &str) -> usize {
    svg.matches("<polygon").count() - 1
}

#[test]
fn shows_every_joint_unit_and_limit() {
    let svg = plot_all(&result(3, 1.0, 1.0, |j| Some(1.0 + j as f64 / 10.0)));
    assert_well_formed(&svg);
    for text in [
        "joint_0",
        "joint_1",
        "joint_2",
        "position [rad]",
        "position [m]",
        "velocity [rad/s]",
        "velocity [m/s]",
        "acceleration [rad/s²]",
        "jerk [m/s³]",
        "time [s]",
        "test &amp; robot: 2 s",
        "lawful, largest peak 50.00 % of its limit",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // Two radian joints and one in metres, each with a lower and an upper
    // limit of its own in each of four quantities.
    assert_eq!(dashed_lines(&svg), 3 * 2 * 4);
}

#[test]
fn draws_a_shared_limit_once_and_tells_of_distant_ones() {
    let shared = plot_all(&result(5, 1.0, 1.0, |_| Some(1.5)));
    assert_eq!(dashed_lines(&shared), 2 * 2 * 4);
    let distant = plot_all(&result(2, 1.0, 1.0, |_| Some(1e5)));
    assert!(distant.contains("limits beyond the axis: joint_0 \u{2212}1.00e5, joint_0 1.00e5"));
    assert!(!distant.contains("<polygon"), "neither limits nor a legend for them");
}

#[test]
fn draws_jumps_as_vertical_lines() {
    let mut result = result(1, 1.0, 1.0, |_| None);
    // Acceleration 2, then -2.
    result.trajectory.pieces = vec![vec![vec![0.0, 0.0, 1.0]], vec![vec![1.0, 2.0, -1.0]]];
    let section = Section { name: None, start: 0.0, result: &result };
    let svg = plot(&[section], &[Quantity::Acceleration]);
    let curve = svg.lines().find(|line| line.contains("#0072B2\" stroke-width=\"16\"")).unwrap();
    let points = curve.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
    let points: Vec<Vec<f64>> = points
        .split_whitespace()
        .map(|point| point.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(points.len(), 4, "two straight pieces");
    assert_eq!(points[1][0], points[2][0]);
    assert!(points[2][1] > points[1][1] + 500.0, "falls");
    assert_eq!((points[0][1], points[2][1]), (points[1][1], points[3][1]), "constant pieces");
}

#[test]
fn survives_any_number_of_joints_and_any_size() {
    for dof in [1, 2, 32] {
        for size in [0.0, 1e-300, 1e-12, 1.0, 1e12, 1e300] {
            for length in [1e-9, 1.0, 1e9] {
                for limit in [None, Some(1e-9), Some(1.0), Some(1e300), Some(f64::INFINITY)] {
                    let mut result = result(dof, size, length, |_| Some(1.0));
                    for joint in &mut result.certificate.joints {
                        joint.velocity.limit = limit;
                        joint.position.upper = limit;
                    }
                    let svg = plot_all(&result);
                    assert_well_formed(&svg);
                    assert_eq!(svg.matches(">\njoint_").count(), dof, "legend");
                }
            }
        }
    }
    assert_well_formed(&plot(&[], &Quantity::ALL));
    assert_well_formed(&plot_all(&result(0, 1.0, 1.0, |_| None)));
    assert_well_formed(&plot(&[], &[]));
}

#[test]
fn marks_where_limits_are_exceeded() {
    let mut result = result(1, 1.0, 1.0, |_| Some(1.5));
    result.certificate.violations = serde_json::from_value(json!([{"joint": "joint_0",
        "limit": "velocity", "at": 1.5, "value": 1.875, "limit_value": 1.5,
        "detail": "joint_0 exceeds its velocity limit"}]))
    .unwrap();
    let svg = plot_all(&result);
    assert!(svg.contains("NOT LAWFUL: joint_0 exceeds its velocity limit"));
    let dots: Vec<&str> = svg.lines().filter(|line| line.starts_with("<circle")).collect();
    assert_eq!(dots.len(), 1);
    // At three quarters of the time axis.
    assert!(dots[0].contains("cx=\"7215\""), "{}", dots[0]);
}

#[test]
fn names_are_escaped() {
    let mut result = result(1, 1.0, 1.0, |_| None);
    result.joint_names = vec!["a<b>&\"\u{1}\u{7}".into()];
    let svg = plot_all(&result);
    assert_well_formed(&svg);
    assert!(svg.contains("a&lt;b&gt;&amp;&quot;  "));
}

#[test]
fn sections_follow_each_other_by_name() {
    let leg = result(2, 1.0, 1.0, |_| Some(2.0));
    let program: PlanResult = serde_json::from_value(json!({
        "robot": leg.robot, "joint_names": leg.joint_names, "duration": 4.0, "lawful": true, "worst_ratio": 0.5,
        "legs": [{"name": "AB", "start": 0.0, "result": leg}, {"name": "BC", "start": 2.0, "result": leg}],
        "evaluations": 2, "planning_s": 0.0, "seed": 0, "version": "0",
    }))
    .unwrap();
    let svg = plot(&Section::all(&program), &Quantity::ALL);
    assert_well_formed(&svg);
    assert!(svg.contains(">\nAB\n") && svg.contains(">\nBC\n"));
    assert!(svg.contains("2 sections, 4 s"));
    assert!(convergence(&Curve::all(&program)).contains("BC (exact, quintic)"));
    let section = Section::leg(&program, "BC").unwrap();
    assert!(plot(&[section], &[Quantity::Position]).contains("test &amp; robot, BC: 2 s"));
    assert!(Section::leg(&program, "XY").is_none());
}

#[test]
fn convergence_shows_best_mean_and_reference() {
    let point = |k: u64, best: f64, mean: f64| ConvergencePoint {
        iteration: k,
        evaluations: 50 * k,
        elapsed_s: 0.0,
        best: Some(best),
        mean: Some(mean),
    };
    let points = [point(1, 9.0, 15.0), point(2, 8.0, 11.0), point(3, 7.5, 8.5)];
    let curve = |name: &str| Curve {
        name: name.into(),
        points: &points,
        reference: Some(("optimum", 7.0255)),
        fitness: Fitness::Duration,
    };
    let svg = convergence(&[curve("AB")]);
    assert_well_formed(&svg);
    for text in [
        "AB",
        "mean of the candidates",
        "optimum 7.026 s",
        "duration [s]",
        "evaluations",
        "best 7.5 s after 150 evaluations",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg.matches("<polygon").count(), 2, "the optimum and its legend");
    let weighted = convergence(&[Curve { fitness: Fitness::Objective, ..curve("AB") }]);
    assert!(!weighted.contains("duration [s]") && weighted.contains("best 7.5 after 150"));
    let two = convergence(&[curve("AB"), curve("BC")]);
    assert!(two.contains("best together 15 s after 300 evaluations"));
    assert_eq!(two.matches("<circle").count(), 2);
}

/// One curve through several searches would show a best that gets worse.
#[test]
fn searches_of_single_joints_are_drawn_apart() {
    let point = |iteration: u64, evaluations: u64, best: f64| ConvergencePoint {
        iteration,
        evaluations,
        elapsed_s: 0.0,
        best: Some(best),
        mean: None,
    };
    let points = [point(0, 10, 3.0), point(1, 20, 2.0), point(0, 30, 5.0), point(1, 40, 4.0)];
    let mut result = result(2, 1.0, 1.0, |_| None);
    result.convergence = points.to_vec();
    result.per_joint = Some(Vec::new());
    result.bound =
        Some(serde_json::from_value(json!({"lower": 4.5, "gap": 0.1, "method": ""})).unwrap());
    let section = Section { name: None, start: 0.0, result: &result };
    let svg = convergence(&[Curve::of(&section)]);
    assert_eq!(svg.matches("<circle").count(), 2);
    assert!(svg.contains("each joint alone, one after the other: 40 evaluations"));
    assert!(!svg.contains("lower bound"));
}

#[test]
fn convergence_survives_any_values() {
    let values = [
        None,
        Some(0.0),
        Some(-1.0),
        Some(1e-300),
        Some(1e300),
        Some(f64::NAN),
        Some(f64::INFINITY),
    ];
    for best in values {
        for mean in values {
            for count in [0, 1, 3] {
                let point =
                    ConvergencePoint { iteration: 0, evaluations: 0, elapsed_s: 0.0, best, mean };
                let points = vec![point; count];
                let curve = Curve {
                    name: "x".into(),
                    points: &points,
                    reference: best.map(|b| ("optimum", b)),
                    fitness: Fitness::Duration,
                };
                assert_well_formed(&convergence(&[curve.clone(), curve]));
            }
        }
    }
    assert_well_formed(&convergence(&[]));
}

/// A front with a third objective, and a plan that is none of its motions.
fn with_front(objectives: &[&str], points: &[&[f64]]) -> TrajectoryResult {
    let mut result = result(2, 1.0, 1.0, |_| None);
    let axes: Vec<_> =
        objectives.iter().map(|name| json!({"name": name, "unit": "rad & m"})).collect();
    let points: Vec<_> = points
        .iter()
        .map(|values| json!({"values": values, "durations": [1.0], "worst_ratio": 1.0}))
        .collect();
    result.pareto = Some(
        serde_json::from_value(json!({"objectives": axes, "method": "nsga2", "points": points}))
            .unwrap(),
    );
    result.metrics.objective =
        serde_json::from_value(json!({"time": 2.5, "rms_jerk": 6.0, "energy": 3.0})).unwrap();
    result
}

#[test]
fn fronts_show_every_motion_the_plan_and_the_stretched_one() {
    let two: [&[f64]; 3] = [&[2.0, 8.0], &[3.0, 2.0], &[4.0, 0.5]];
    let result = with_front(&["time", "rms_jerk"], &two);
    let section = Section { name: Some("AB"), start: 0.0, result: &result };
    let svg = pareto(&[section]);
    assert_well_formed(&svg);
    // Stretched to 4 s the fastest would have a jerk of 1, to 3 s of 2.37.
    for text in [
        "test &amp; robot, AB: 3 motions, rms jerk up to 50 % less than by stretching",
        "time [s]",
        "rms jerk [rad &amp; m]",
        "motions of the front",
        "the fastest one, only stretched",
        "the plan 2.5 s, 6 rad &amp; m",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg.matches("<circle").count(), 2 + 3 + 1, "legend, motions, plan");
    let three: [&[f64]; 2] = [&[1.0, 5.0, 9.0], &[2.0, 4.0, 1.0]];
    let both = with_front(&["energy", "time", "rms_jerk"], &three);
    let svg = pareto(&[section, Section { name: None, start: 0.0, result: &both }]);
    assert_well_formed(&svg);
    assert!(svg.contains("mean squared acceleration [rad &amp; m]"));
    assert_eq!(svg.matches("<circle").count(), 2 + (3 + 1) + 2 * (2 + 1));
}

#[test]
fn fronts_survive_any_values() {
    let values = [0.0, 1e-300, 1.0, 1e300, f64::NAN, f64::INFINITY];
    for a in values {
        for b in values {
            let mut result = with_front(&["time", "energy"], &[&[1.0, 1.0]]);
            result.metrics.objective.energy = b;
            let front = result.pareto.as_mut().unwrap();
            front.points[0].values = vec![a, b];
            assert_well_formed(&pareto(&[Section { name: None, start: 0.0, result: &result }]));
            result.pareto.as_mut().unwrap().points.clear();
            assert_well_formed(&pareto(&[Section { name: None, start: 0.0, result: &result }]));
        }
    }
    assert_well_formed(&pareto(&[]));
}

/// Three methods on a problem: one with quartiles around `median`, one that
/// found nothing and a deterministic one at the best known value.
fn compared(best_known: Option<f64>, median: f64, problems: usize) -> ComparisonResult {
    let row = |optimizer: &str, values: [Option<f64>; 3], gap: Option<f64>| {
        let [lower, median, upper] = values;
        let point = |evaluations: u64, by: f64| {
            json!({ "evaluations": evaluations, "lower_quartile": lower.map(|it| it * by),
                "median": median.map(|it| it * by), "upper_quartile": upper.map(|it| it * by) })
        };
        json!({ "label": optimizer, "optimizer": optimizer, "parameters": {}, "runs": 1,
            "feasible_runs": 1, "lower_quartile": lower, "median": median,
            "upper_quartile": upper, "median_gap": gap, "success_rate": 1.0, "evaluations": 200,
            "seconds_per_evaluation": 0.001,
            "curve": [point(50, 2.0), point(100, 1.5), point(200, 1.0)] })
    };
    let found = [Some(0.9 * median), Some(median), Some(1.1 * median)];
    let gap = |value: f64| Some(value / best_known? - 1.0).filter(|gap| gap.is_finite());
    let problem = |at: usize| {
        json!({ "name": format!("p{at} & q"), "title": "two `points`", "unit": "s",
            "dimension": 2, "best_known": best_known, "best_method": "pso",
            "optimum": best_known.map(|value| json!({ "value": value, "position": [], "source": "" })),
            "methods": [row("ga", [None; 3], None), row("pso", found, gap(median)),
                row("exact", [best_known; 3], best_known.and_then(gap))] })
    };
    serde_json::from_value(json!({ "task": "comparison", "runs": 1, "max_evaluations": 200,
        "success_tolerance": 1e-3, "test": "", "verdict": "Use `exact` & <b>.",
        "problems": (0..problems).map(problem).collect::<Vec<_>>(), "evaluations": 0,
        "planning_s": 0.0, "seed": 0, "version": "" }))
    .unwrap()
}

#[test]
fn gaps_show_every_method_on_every_problem_in_ranking_order() {
    let result = compared(Some(5.0), 5.05, 4);
    let svg = gaps(&result, &result.ranking());
    assert_well_formed(&svg);
    // The legend's two, and on each problem the two that found something.
    assert_eq!(svg.matches("<circle").count(), 2 + 4 * 2);
    assert_eq!(svg.matches("none found").count(), 4);
    assert_eq!(svg.matches(">\np3 &amp; q\n").count(), 1);
    // Four problems are two rows of panels; the names stand before each.
    let at = |name: &str| svg.find(&format!(">\n{name}\n")).unwrap();
    assert!(at("exact") < at("pso") && at("pso") < at("ga"));
    assert_eq!(svg.matches(">\nexact\n").count(), 2);
    assert!(svg.contains("0.01 %") && !svg.contains("1e"));
}

#[test]
fn gaps_and_bands_survive_any_values() {
    let values = [0.0, 1e-300, 1e-9, 5.0, 1e300, f64::NAN, f64::INFINITY];
    for best in values.map(Some).into_iter().chain([None]) {
        for median in values {
            // Texts of JSON hold neither infinite nor undefined values.
            let mut result = compared(Some(5.0), 5.05, 1);
            let problem = &mut result.problems[0];
            problem.best_known = best;
            problem.methods[1].median = Some(median);
            problem.methods[1].median_gap = Some(median);
            problem.methods[1].curve[1].median = Some(median);
            assert_well_formed(&gaps(&result, &result.ranking()));
            assert_well_formed(&bands(&result.problems[0]));
        }
    }
    let empty = compared(None, 1.0, 0);
    assert_well_formed(&gaps(&empty, &empty.ranking()));
    assert!(page::comparison(&empty).contains("0 problems"));
}

/// One run's best holds until the next; a slope would be values never found.
#[test]
fn a_deterministic_curve_is_drawn_as_stairs() {
    let svg = bands(&compared(Some(5.0), 5.05, 1).problems[0]);
    let curves: Vec<Vec<&str>> = svg
        .lines()
        .filter(|line| line.starts_with("<polyline") && line.contains("stroke-width=\"18\""))
        .map(|line| line.split("points=\"").nth(1).unwrap().split('"').next().unwrap())
        .map(|points| points.split_whitespace().collect())
        .collect();
    let [pso, exact] = &curves[..] else { panic!("two curves: {curves:?}") };
    assert_eq!(pso.len(), 3, "a median glides");
    assert_eq!(exact.len(), 6);
    for step in exact.windows(2) {
        let (from, to) = (step[0].split_once(',').unwrap(), step[1].split_once(',').unwrap());
        assert!(from.0 == to.0 || from.1 == to.1, "{step:?}");
    }
}

#[test]
fn a_page_tells_the_optimum_and_the_deterministic_apart_and_sets_code() {
    let html = page::comparison(&compared(Some(5.0), 5.05, 2));
    for text in [
        "Use <code>exact</code> &amp; &lt;b&gt;.",
        "two <code>points</code>;",
        "1.\u{a0}exact (deterministic) \u{2605}",
        "optimum \u{2605}",
        "1.000 % \u{2605}",
        "none found",
        "200.00 ms",
        "A deterministic method draws no random numbers, so it ran once.",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert!(!html.contains("0.000 %") && !html.contains('`'));
    assert_eq!(html.matches("optimum \u{2605}").count(), 2);
    // Half a pair is no code.
    let lone = page::page("", page::paragraph("a ` b"));
    assert!(lone.contains("<p>a ` b</p>"));
    // What a run found below the method's optimum makes its value no optimum.
    let mut beaten = compared(Some(5.0), 5.05, 1);
    beaten.problems[0].optimum.as_mut().unwrap().value = 5.2;
    assert!(page::comparison(&beaten).contains("&lt; 0.001 % \u{2605}"));
}

fn path_result(dimension: usize, size: f64) -> PathResult {
    let point = |share: f64| vec![share * size; dimension];
    let value = json!({
        "path": [point(0.1), point(0.4), point(0.9)], "smoothed_path": [point(0.1), point(0.9)],
        "length": size, "smoothed_length": 0.9 * size, "straight_length": 0.8 * size,
        "clearance": 0.1, "nodes": 4, "iterations": 5, "evaluations": 6,
        "convergence": [
            {"iteration": 1, "evaluations": 2, "elapsed_s": 0.0, "best": size, "mean": null}],
        "planner": "rrt_star", "smoothing": "shortcut", "stop_reason": "solved",
        "space": {"lower": point(0.0), "upper": point(1.0), "obstacles": [
            {"type": "ball", "center": point(0.5), "radius": 0.2 * size},
            {"type": "box", "lower": point(-0.7), "upper": point(0.2)}]},
        "tree_edges": [{"from": point(0.1), "to": point(0.4)}],
        "planning_s": 0.0, "seed": 0, "version": "",
    });
    serde_json::from_value(value).unwrap()
}

#[test]
fn a_path_shows_map_tree_and_both_forms() {
    let svg = path(&path_result(3, 100.0));
    for text in ["trees", "path as planned", "smoothed", "goal", "rrt_star: length 100", "2 of 3"] {
        assert!(svg.contains(text), "{text}");
    }
    // A ball, a box, an edge and two paths beside grid and legend.
    assert!(svg.matches("<polygon").count() >= 2);
    let mut plain = path_result(2, 100.0);
    (plain.smoothed_path, plain.smoothed_length) = (None, None);
    plain.tree_edges.clear();
    let svg = path(&plain);
    assert!(!svg.contains("smoothed") && !svg.contains("trees") && !svg.contains("coordinates"));
    let curve = convergence(&[Curve::of_path(&plain)]);
    assert!(curve.contains("straight line") && curve.contains("motions checked"));
}

#[test]
fn odd_paths_are_drawn_without_panic() {
    for size in [0.0, 1e-300, 1e300, f64::MAX] {
        let mut odd = path_result(2, size);
        assert!(path(&odd).ends_with("</svg>\n") || path(&odd).contains("</svg>"));
        odd.path.clear();
        odd.space.upper.clear();
        assert!(path(&odd).contains("</svg>"));
    }
}
