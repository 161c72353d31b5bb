//! The first generations of the stochastic optimizers, against an independent
//! script: `tests/data/golden_optimizers.py`.

use std::collections::BTreeMap;
use std::sync::Mutex;

use serde::Deserialize;
use serde_json::Value;
use takt::budget::Budget;
use takt::fault::Faults;
use takt::optimize::{Appraisal, Bounds, Candidate, Objective, Solution, minimize, optimizer};

const TOLERANCE: f64 = 1e-12;

#[derive(Deserialize)]
struct Case {
    optimizer: String,
    problem: String,
    seed: u64,
    settings: BTreeMap<String, Value>,
    generations: Vec<Generation>,
}

#[derive(Deserialize)]
struct Generation {
    /// Candidates in the order in which they are evaluated.
    evaluated: Vec<Vec<f64>>,
    best: Option<f64>,
    best_position: Option<Vec<f64>>,
}

/// The script's problems.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Bowl,
    /// Least sum of two durations whose product must be 1.2 at least.
    Fence {
        rejects: bool,
    },
}

struct Problem {
    kind: Kind,
    bounds: Bounds,
    evaluated: Mutex<Vec<Vec<f64>>>,
}

impl Problem {
    fn new(name: &str) -> Self {
        let (kind, lower, upper) = match name {
            "bowl" => (Kind::Bowl, [-1.0, -2.0], [1.0, 1.0]),
            "fence_penalty" => (Kind::Fence { rejects: false }, [0.2, 0.3], [2.0, 2.5]),
            "fence_reject" => (Kind::Fence { rejects: true }, [0.2, 0.3], [2.0, 2.5]),
            other => panic!("unknown problem {other}"),
        };
        let bounds = Bounds { lower: lower.to_vec(), upper: upper.to_vec() };
        Self { kind, bounds, evaluated: Mutex::default() }
    }
}

impl Objective for Problem {
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        Box::new(Recording(self))
    }

    fn evaluation_ns(&self) -> f64 {
        1.0
    }
}

/// Notes what is evaluated.
struct Recording<'a>(&'a Problem);

impl Candidate for Recording<'_> {
    fn fitness(&mut self, position: &[f64]) -> f64 {
        self.appraise(position).fitness
    }

    fn appraise(&mut self, position: &[f64]) -> Appraisal {
        self.0.evaluated.lock().unwrap().push(position.to_vec());
        let [x, y] = [position[0], position[1]];
        let Kind::Fence { rejects } = self.0.kind else {
            let fitness = 1.0 + (x - 0.3).powi(2) + 2.0 * (y + 0.2).powi(2);
            return Appraisal { fitness, cost: fitness, excess: 0.0 };
        };
        let (cost, excess) = (x + y, (1.2 / (x * y) - 1.0).max(0.0));
        let fitness = match (excess > 0.0, rejects) {
            (false, _) => cost,
            (true, true) => f64::INFINITY,
            (true, false) => cost + 10.0 + 10.0 * excess,
        };
        Appraisal { fitness, cost, excess: excess * excess }
    }

    fn repair(&mut self, position: &mut [f64]) {
        if self.0.kind != Kind::Bowl && position[0] * position[1] < 1.2 {
            position[0] = (1.2 / position[1] * (1.0 + 1e-9)).min(self.0.bounds.upper[0]);
        }
    }
}

/// A generation's candidates in the order in which they were evaluated.
type Evaluated = Vec<Vec<f64>>;

/// Runs `iterations` generations after the initial one.
fn run(case: &Case, iterations: usize) -> (Vec<Evaluated>, Solution) {
    let problem = Problem::new(&case.problem);
    let entry = optimizer(&case.optimizer).unwrap();
    let mut faults = Faults::default();
    let settings = entry.settings(&case.settings, "", &mut faults);
    assert!(faults.is_empty(), "{faults}");
    let mut optimizer = (entry.build)(&settings, &problem, case.seed);
    let mut generations = Vec::new();
    let mut progress = |_: &_| generations.push(problem.evaluated.lock().unwrap().split_off(0));
    let budget = Budget::default();
    let solution =
        minimize(&problem, optimizer.as_mut(), iterations as u64, &budget, &mut progress);
    (generations, solution)
}

fn near(found: &[f64], expected: &[f64]) -> bool {
    found.len() == expected.len()
        && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= TOLERANCE)
}

#[test]
fn the_first_generations_are_what_an_independent_script_finds() {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("../data/golden_optimizers.json")).unwrap();
    assert!(cases.len() >= 25);
    for case in &cases {
        // Cut after every generation: the best so far is then the search's result.
        for (last, expected) in case.generations.iter().enumerate() {
            let name = format!(
                "{} {:?} on {}, seed {}, generation {last}",
                case.optimizer, case.settings, case.problem, case.seed
            );
            let (generations, Solution { position, fitness, .. }) = run(case, last);
            assert_eq!(generations.len(), last + 1, "{name}");
            let found = &generations[last];
            let alike = found.iter().zip(&expected.evaluated).all(|(x, y)| near(x, y));
            assert_eq!(found.len(), expected.evaluated.len(), "{name}: {found:?}");
            assert!(alike, "{name}: {found:?} instead of {:?}", expected.evaluated);
            assert_eq!(position.is_some(), expected.best_position.is_some(), "{name}");
            if let (Some(position), Some(wanted)) = (&position, &expected.best_position) {
                assert!(near(position, wanted), "{name}: {position:?} instead of {wanted:?}");
                let best = expected.best.unwrap();
                assert!(near(&[fitness], &[best]), "{name}: {fitness} instead of {best}");
            }
        }
    }
}
