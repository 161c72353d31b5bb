//! What every planner of the registry promises, on a plane and in a space with
//! two balls, and on a plane that is divided.

use std::collections::{BTreeMap, HashSet};
use std::time::Duration;

use serde_json::{Value, json};
use takt::budget::{Budget, CancelToken, StopReason};
use takt::fault::Faults;
use takt::fault::parameter::Settings;
use takt::math::random::RandomStream;
use takt::planner::{
    LengthPoint, PLANNERS, PathEnd, PathSolution, PlannerEntry, PlannerError, PlanningProblem,
    ValidityChecker, distance, length, shortcut, solve,
};

/// A point among balls, checked by the nearest point of the motion.
#[derive(Clone)]
struct Balls {
    balls: Vec<(Vec<f64>, f64)>,
    /// Nothing is free between two planes across the first axis.
    wall: Option<[f64; 2]>,
    knows_clearance: bool,
    checks: u64,
    /// At which check to cancel what.
    cancel: Option<(u64, CancelToken)>,
}

impl Balls {
    fn nearest(&self, from: &[f64], to: &[f64]) -> f64 {
        let along: f64 = from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum();
        let gap = |(centre, radius): &(Vec<f64>, f64)| {
            let ends = from.iter().zip(to).zip(centre);
            let share: f64 = ends.map(|((a, b), c)| (c - a) * (b - a)).sum::<f64>() / along;
            let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
            let at: Vec<f64> = from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect();
            distance(&at, centre) - radius
        };
        self.balls.iter().map(gap).fold(f64::INFINITY, f64::min)
    }
}

impl ValidityChecker for Balls {
    fn is_state_valid(&mut self, state: &[f64]) -> bool {
        self.nearest(state, state) > 0.0
            && self.wall.is_none_or(|[from, to]| state[0] < from || state[0] > to)
    }

    fn is_motion_valid(&mut self, from: &[f64], to: &[f64]) -> bool {
        self.checks += 1;
        if let Some((_, token)) = self.cancel.as_ref().filter(|(at, _)| *at == self.checks) {
            token.cancel();
        }
        let passes =
            |[left, right]: [f64; 2]| from[0].min(to[0]) <= right && from[0].max(to[0]) >= left;
        self.nearest(from, to) > 0.0 && !self.wall.is_some_and(passes)
    }

    fn clearance(&mut self, state: &[f64]) -> Option<f64> {
        let wall =
            self.wall.map_or(f64::INFINITY, |[from, to]| (from - state[0]).max(state[0] - to));
        self.knows_clearance.then(|| self.nearest(state, state).min(wall))
    }
}

/// From one side of a ball to the other; a second one stands aside.
fn two_balls(dimension: usize) -> (PlanningProblem, Balls) {
    let point = |x: f64, y: f64| {
        let mut point = vec![50.0; dimension];
        (point[0], point[1]) = (x, y);
        point
    };
    let problem = PlanningProblem {
        lower: vec![0.0; dimension],
        upper: vec![100.0; dimension],
        start: point(10.0, 50.0),
        goal: point(90.0, 50.0),
    };
    let balls = vec![(point(50.0, 50.0), 20.0), (point(50.0, 90.0), 10.0)];
    let balls = Balls { balls, wall: None, knows_clearance: true, checks: 0, cancel: None };
    (problem, balls)
}

/// Two tangents and an arc: the ends are two radii from the centre, so tangents
/// leave at 60 degrees and another 60 remain.
fn optimum() -> f64 {
    2.0 * 1200.0_f64.sqrt() + 20.0 * std::f64::consts::PI / 3.0
}

fn settings(entry: &PlannerEntry, given: Value) -> Settings {
    let given: BTreeMap<String, Value> = serde_json::from_value(given).unwrap();
    let mut faults = Faults::default();
    let settings = entry.settings(&given, "", &mut faults);
    assert!(faults.is_empty(), "{faults}");
    settings
}

fn watch(
    entry: &PlannerEntry,
    given: Value,
    (problem, checker): (&PlanningProblem, &mut Balls),
    seed: u64,
    budget: &Budget,
) -> (PathSolution, Vec<LengthPoint>) {
    let mut seen = Vec::new();
    let settings = settings(entry, given);
    let mut progress = |point: &LengthPoint| seen.push(*point);
    let solution = solve(entry, &settings, problem, checker, seed, budget, &mut progress);
    (solution.unwrap(), seen)
}

fn run(entry: &PlannerEntry, given: Value, dimension: usize, seed: u64) -> PathSolution {
    let (problem, mut checker) = two_balls(dimension);
    watch(entry, given, (&problem, &mut checker), seed, &Budget::default()).0
}

/// Everything a solution says but how long it took, to the bit.
fn bits(solution: &PathSolution) -> Vec<u64> {
    let path = solution.path.iter().flatten().flatten();
    let curve = solution.lengths.iter().flat_map(|point| {
        [point.length.unwrap_or(f64::NAN), point.iteration as f64, point.checks as f64]
    });
    let trees = solution.trees.iter().flat_map(|tree| tree.states.iter().copied());
    let numbers = path.copied().chain(curve).chain(trees).map(f64::to_bits);
    numbers.chain([solution.iterations, solution.checks, solution.nodes as u64]).collect()
}

/// Checked with steps of a hundredth, by distances alone.
fn assert_free(path: &[Vec<f64>], checker: &Balls, case: &str) {
    for pair in path.windows(2) {
        let steps = (distance(&pair[0], &pair[1]) / 0.01).ceil();
        for step in 0..=steps as u64 {
            let share = step as f64 / steps.max(1.0);
            let at: Vec<f64> =
                pair[0].iter().zip(&pair[1]).map(|(a, b)| a + share * (b - a)).collect();
            for (centre, radius) in &checker.balls {
                assert!(distance(&at, centre) > radius - 1e-9, "{case}: {at:?}");
            }
            assert!(at.iter().all(|x| (0.0..=100.0).contains(x)), "{case}: {at:?}");
        }
    }
}

#[test]
fn paths_are_free_and_end_where_they_should() {
    for entry in PLANNERS {
        for (dimension, seeds, iterations) in [(2, 8, 300), (3, 4, 300), (7, 2, 3000)] {
            for seed in 0..seeds {
                let case = format!("{}, {dimension}, {seed}", entry.name);
                let (problem, checker) = two_balls(dimension);
                let given = json!({ "iterations": iterations });
                let solution = run(entry, given, dimension, seed);
                let path = solution.path.as_ref().unwrap_or_else(|| panic!("{case}: no path"));
                assert_eq!(path[0], problem.start, "{case}");
                assert_eq!(path[path.len() - 1], problem.goal, "{case}");
                assert_free(path, &checker, &case);
                let off = (length(path) / solution.length - 1.0).abs();
                assert!(off < 1e-12, "{case}: {} {}", length(path), solution.length);
                assert!(solution.length > optimum() - 1e-6, "{case}: {}", solution.length);
            }
        }
    }
}

#[test]
fn anytime_planners_come_within_one_percent_of_the_optimum() {
    for entry in PLANNERS.iter().filter(|entry| entry.anytime) {
        for (dimension, iterations) in [(2, 4000), (3, 12_000)] {
            let solution = run(entry, json!({ "iterations": iterations }), dimension, 3);
            let excess = solution.length / optimum() - 1.0;
            assert!((0.0..0.01).contains(&excess), "{}, {dimension}: {excess}", entry.name);
        }
    }
}

#[test]
fn lengths_never_grow_and_end_with_the_result() {
    for entry in PLANNERS {
        let (problem, mut checker) = two_balls(2);
        let world = (&problem, &mut checker);
        let (solution, seen) =
            watch(entry, json!({ "iterations": 1500 }), world, 5, &Budget::default());
        let lengths: Vec<f64> =
            seen.iter().map(|point| point.length.unwrap_or(f64::INFINITY)).collect();
        assert!(lengths.windows(2).all(|pair| pair[1] <= pair[0]), "{}", entry.name);
        assert_eq!(lengths.last(), Some(&solution.length), "{}", entry.name);
        assert_eq!(solution.lengths, seen, "{}", entry.name);
        assert_eq!(seen.len() > 1, entry.anytime, "{}: {}", entry.name, seen.len());
    }
}

#[test]
fn a_seed_repeats_to_the_bit_and_others_differ() {
    for entry in PLANNERS {
        for dimension in [2, 5] {
            let again = |seed| bits(&run(entry, json!({ "iterations": 200 }), dimension, seed));
            assert_eq!(again(1), again(1), "{}", entry.name);
            assert_ne!(again(1), again(2), "{}", entry.name);
        }
    }
}

#[test]
fn iteration_limits_are_kept_to_the_number() {
    for entry in PLANNERS {
        for limit in [0, 1, 77] {
            let (problem, mut checker) = two_balls(2);
            checker.wall = Some([20.0, 30.0]);
            let world = (&problem, &mut checker);
            let given = json!({ "iterations": limit });
            let (solution, _) = watch(entry, given, world, 5, &Budget::default());
            assert_eq!(solution.stop_reason, StopReason::IterationLimit, "{}", entry.name);
            assert_eq!((solution.iterations, solution.path), (limit, None), "{}", entry.name);
            assert_eq!(solution.checks, checker.checks, "{}", entry.name);

            let budget = Budget::default().with_max_evaluations(Some(limit));
            let (solution, _) = watch(entry, json!({}), (&problem, &mut checker), 5, &budget);
            assert_eq!(solution.stop_reason, StopReason::EvaluationLimit, "{}", entry.name);
            assert_eq!(solution.iterations, limit, "{}", entry.name);
        }
    }
}

#[test]
fn a_way_that_is_barred_is_not_found() {
    for entry in PLANNERS {
        let (problem, mut checker) = two_balls(2);
        checker.wall = Some([20.0, 30.0]);
        let world = (&problem, &mut checker);
        let (solution, seen) =
            watch(entry, json!({ "iterations": 5000 }), world, 5, &Budget::default());
        assert_eq!((solution.path, solution.length), (None, f64::INFINITY), "{}", entry.name);
        assert!(solution.lengths.is_empty(), "{}", entry.name);
        assert!(!seen.is_empty() && seen.iter().all(|point| point.length.is_none()));
        let sides = solution.trees.iter().zip([0.0..20.0, 30.0..100.1]);
        for (tree, side) in sides {
            let firsts = tree.states.iter().step_by(2);
            assert!(firsts.into_iter().all(|x| side.contains(x)), "{}", entry.name);
        }
    }
}

#[test]
fn cancelled_searches_end_within_a_few_checks() {
    for entry in PLANNERS {
        // With short steps a tree is long on its way to the other.
        for (at, range) in [(2, 10.0), (400, 10.0), (400, 1e-3)] {
            let token = CancelToken::default();
            let (problem, mut checker) = two_balls(2);
            checker.wall = Some([20.0, 30.0]);
            checker.cancel = Some((at, token.clone()));
            let given = json!({ "iterations": 1_000_000, "range": range });
            let world = (&problem, &mut checker);
            let (solution, _) = watch(entry, given, world, 5, &Budget::new(token));
            assert_eq!(solution.stop_reason, StopReason::Cancelled, "{}", entry.name);
            let after = checker.checks - at;
            assert!(after < 400, "{}: {after} checks after it was cancelled", entry.name);
        }
    }
}

/// Fine steps make a path of thousands of states.
#[test]
fn shortcuts_of_a_long_path_end_and_can_be_cancelled() {
    let (problem, mut checker) = two_balls(2);
    let round = |share: f64| {
        let angle = std::f64::consts::PI * (1.0 - share);
        vec![50.0 + 40.0 * angle.cos(), 50.0 - 40.0 * angle.sin()]
    };
    let mut path: Vec<Vec<f64>> = (0..=5000).map(|step| round(f64::from(step) / 5000.0)).collect();
    path[0].clone_from(&problem.start);
    path[5000].clone_from(&problem.goal);
    let long = path.clone();
    shortcut(&mut path, &mut checker, 100, 1, &Budget::default());
    assert!(checker.checks < 100_000, "{} checks", checker.checks);
    assert!(length(&path) < 1.02 * optimum(), "{}", length(&path));
    assert_free(&path, &checker, "long");
    let token = CancelToken::default();
    token.cancel();
    let mut untouched = long.clone();
    shortcut(&mut untouched, &mut checker, 100, 1, &Budget::new(token));
    assert_eq!(untouched, long);
}

#[test]
fn a_time_limit_ends_the_search() {
    for entry in PLANNERS {
        let (problem, mut checker) = two_balls(2);
        let over = Budget::default().with_time_limit(Some(Duration::ZERO));
        let (solution, _) = watch(entry, json!({}), (&problem, &mut checker), 5, &over);
        assert_eq!(solution.stop_reason, StopReason::TimeLimit, "{}", entry.name);
        assert_eq!(solution.iterations, 0, "{}", entry.name);
        let given = json!({ "time_limit_s": 0.0 });
        let world = (&problem, &mut checker);
        let (solution, _) = watch(entry, given, world, 5, &Budget::default());
        assert_eq!(solution.stop_reason, StopReason::TimeLimit, "{}", entry.name);
    }
}

#[test]
fn wishes_end_the_search_when_they_are_met() {
    for entry in PLANNERS.iter().filter(|entry| entry.anytime) {
        let first = run(entry, json!({ "first_path": true }), 2, 4);
        assert_eq!(first.stop_reason, StopReason::Solved, "{}", entry.name);
        assert_eq!(first.lengths.len(), 1, "{}", entry.name);
        let near = run(entry, json!({ "gap": 0.2 }), 2, 4);
        assert_eq!(near.stop_reason, StopReason::Solved, "{}", entry.name);
        assert!(near.length <= 80.0 * 1.2, "{}: {}", entry.name, near.length);
    }
    for entry in PLANNERS.iter().filter(|entry| !entry.anytime) {
        assert_eq!(run(entry, json!({}), 2, 4).stop_reason, StopReason::Solved, "{}", entry.name);
    }
}

#[test]
fn a_free_straight_line_is_the_path() {
    for entry in PLANNERS {
        let (mut problem, mut checker) = two_balls(3);
        problem.goal = vec![10.0, 95.0, 20.0];
        for goal in [problem.goal.clone(), problem.start.clone()] {
            problem.goal = goal;
            let world = (&problem, &mut checker);
            let (solution, _) = watch(entry, json!({}), world, 1, &Budget::default());
            assert_eq!(solution.stop_reason, StopReason::Converged, "{}", entry.name);
            assert_eq!(solution.path, Some(vec![problem.start.clone(), problem.goal.clone()]));
            assert_eq!(solution.length, distance(&problem.start, &problem.goal));
            assert_eq!((solution.iterations, solution.checks), (0, 1), "{}", entry.name);
        }
    }
}

#[test]
fn ends_that_cannot_be_are_refused() {
    for entry in PLANNERS {
        let (problem, mut checker) = two_balls(2);
        let mut refusal = |problem: &PlanningProblem| {
            let settings = entry.defaults();
            solve(entry, &settings, problem, &mut checker, 0, &Budget::default(), &mut |_| {})
                .unwrap_err()
        };
        for (end, state) in [(PathEnd::Start, 0), (PathEnd::Goal, 1)] {
            let mut blocked = problem.clone();
            *[&mut blocked.start, &mut blocked.goal][state] = vec![50.0, 60.0];
            assert_eq!(refusal(&blocked), PlannerError::EndNotFree(end), "{}", entry.name);
            for value in [-0.1, 100.1, f64::NAN] {
                let mut outside = problem.clone();
                [&mut outside.start, &mut outside.goal][state][1] = value;
                let error = refusal(&outside);
                let expected = format!("coordinate 1 of the {end} is {value}, outside 0 to 100");
                assert_eq!(error.to_string(), expected, "{}", entry.name);
            }
        }
        checker.knows_clearance = false;
        let settings = settings(entry, json!({ "iterations": 100 }));
        let solved =
            solve(entry, &settings, &problem, &mut checker, 0, &Budget::default(), &mut |_| {});
        let refused = matches!(solved, Err(PlannerError::NeedsClearance(_)));
        assert_eq!(refused, entry.needs_clearance, "{}", entry.name);
    }
}

/// Trees hang together, every motion of them is free.
#[test]
fn trees_are_what_was_grown() {
    for entry in PLANNERS {
        let (problem, mut checker) = two_balls(2);
        let given = json!({ "iterations": 400 });
        let (solution, _) = watch(entry, given, (&problem, &mut checker), 2, &Budget::default());
        let count: usize = solution.trees.iter().map(|tree| tree.parents.len()).sum();
        assert_eq!(count, solution.nodes, "{}", entry.name);
        for (tree, root) in solution.trees.iter().zip([&problem.start, &problem.goal]) {
            let state = |node: usize| &tree.states[2 * node..2 * node + 2];
            assert_eq!((state(0), tree.parents[0]), (&root[..], 0));
            for (node, &parent) in tree.parents.iter().enumerate().skip(1) {
                assert!(checker.is_motion_valid(state(parent as usize), state(node)));
                let ancestors = |node: &usize| Some(tree.parents[*node] as usize);
                let mut line = std::iter::successors(Some(node), ancestors);
                assert!(line.by_ref().take(count).any(|node| node == 0), "{}", entry.name);
            }
        }
    }
}

#[test]
fn declared_parameters_are_what_is_taken() {
    for entry in PLANNERS {
        let info = serde_json::to_value(entry.info()).unwrap();
        for parameter in info["parameters"].as_array().unwrap() {
            let name = parameter["name"].as_str().unwrap();
            let read = |value: Value| {
                let mut faults = Faults::default();
                entry.settings(&BTreeMap::from([(name.to_owned(), value)]), "", &mut faults);
                faults.is_empty()
            };
            let default = &parameter["default"];
            assert!(default.is_null() || read(default.clone()), "{}: {name}", entry.name);
            let above = parameter["max"].as_f64().unwrap() * 2.0 + 1.0;
            assert!(!read(json!(above)), "{}: {name} takes {above}", entry.name);
            assert!(!read(json!("x")) && !read(json!([1])), "{}: {name}", entry.name);
        }
        let mut faults = Faults::default();
        entry.settings(&BTreeMap::from([("step".to_owned(), json!(1))]), "/planner", &mut faults);
        assert_eq!(faults.0[0].pointer, "/planner/step", "{}", entry.name);
    }
}

#[test]
fn the_registry_is_in_alphabetical_order() {
    let names: Vec<&str> = PLANNERS.iter().map(|entry| entry.name).collect();
    assert!(names.is_sorted() && names.len() == names.iter().collect::<HashSet<_>>().len());
}

/// Extreme settings keep what is promised.
#[test]
fn odd_settings_keep_the_promises() {
    let given = [
        json!({ "range": 1e9 }),
        json!({ "range": 0.5 }),
        json!({ "goal_bias": 1.0 }),
        json!({ "goal_reach": 1.0 }),
        json!({ "depth": 0 }),
        json!({ "depth": 50 }),
        json!({ "descent_steps": 200, "descent_stride": 1e9, "keep_off": 1e-9 }),
        json!({ "exploration": 0.0 }),
        json!({ "attraction": 0.0, "bias": 1.0, "influence": 1e9 }),
        json!({ "beacon_every": 1, "beacon_radius": 1e6 }),
        json!({ "connection_reach": 1e-3 }),
        json!({ "cut_corners": false }),
    ];
    for entry in PLANNERS {
        let takes = |given: &&Value| {
            let names: Vec<&str> = entry.all_parameters().map(|p| p.name).collect();
            given.as_object().unwrap().keys().all(|key| names.contains(&key.as_str()))
        };
        for given in given.iter().filter(takes) {
            let mut given = given.clone();
            given["iterations"] = json!(300);
            let case = format!("{} {given}", entry.name);
            let (problem, checker) = two_balls(2);
            let solution = run(entry, given, 2, 6);
            assert!(solution.iterations <= 300, "{case}");
            if let Some(path) = solution.path {
                assert_free(&path, &checker, &case);
                assert_eq!([&path[0], &path[path.len() - 1]], [&problem.start, &problem.goal]);
            }
        }
    }
}

#[test]
fn shortcuts_keep_a_path_free_and_make_it_shorter() {
    for seed in 0..20 {
        let (problem, mut checker) = two_balls(3);
        let entry = PLANNERS.iter().find(|entry| entry.name == "rrt").unwrap();
        let mut path = run(entry, json!({ "range": 5.0 }), 3, seed).path.unwrap();
        let before = length(&path);
        shortcut(&mut path, &mut checker, 50, seed, &Budget::default());
        assert_free(&path, &checker, &format!("{seed}"));
        assert_eq!([&path[0], &path[path.len() - 1]], [&problem.start, &problem.goal]);
        let after = length(&path);
        assert!(after < before && after < 1.05 * optimum(), "{seed}: {before} {after}");
        let mut straight = vec![vec![0.0; 3], vec![1.0; 3]];
        shortcut(&mut straight, &mut checker, 50, seed, &Budget::default());
        assert_eq!(straight, [[0.0; 3], [1.0; 3]]);
    }
}

/// The checker here is itself held against random points of motions.
#[test]
fn the_test_checker_misses_nothing() {
    let (_, mut checker) = two_balls(2);
    let mut random = RandomStream::new(1, 0);
    let mut draw = || [random.uniform(0.0, 100.0), random.uniform(0.0, 100.0)];
    for _ in 0..300 {
        let (from, to) = (draw(), draw());
        let points = (0..=1000).map(|step| f64::from(step) / 1000.0);
        let mut points =
            points.map(|s| [0, 1].map(|axis| from[axis] + s * (to[axis] - from[axis])));
        let is_free = points.all(|point| checker.is_state_valid(&point));
        assert!(is_free || !checker.is_motion_valid(&from, &to));
    }
}
