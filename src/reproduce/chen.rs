//! Chen, Zhang and Yi 2023, doi:10.3390/app131810482: Table 3 (functions) and
//! Table 5 (a woodworking arm).

use serde_json::{Value, json};

use super::experiment::{self, ReproduceError, joint, mean, peaks, plan, repeat};
use super::report::Section;
use super::verdict::Verdict;
use crate::picture::bands;
use crate::plan::ComparisonResult;

pub(super) const CITATION: &str = "Chen, Zhang, Yi: Time-optimal trajectory planning for \
    woodworking manipulators using an improved PSO algorithm. Applied Sciences 13 (2023) 10482, \
    doi:10.3390/app131810482";

/// Methods of Table 3 as printed, and by registry name.
const METHODS: [(&str, &str); 5] = [
    ("PSO", "pso"),
    ("CFPSO", "cfpso"),
    ("SPSO", "spso"),
    ("Gold-SA", "gold_sa"),
    ("GoldS-PSO", "golds_pso"),
];

/// Table 3, means: a row per function F1 to F8, a column per method.
const TABLE_3: [[f64; 5]; 8] = [
    [37.3248, 1.2322, 6.4918e-190, 0.0, 0.0],
    [25.9152, 3.1992, 7.6576e-96, 1.3191e-259, 0.0],
    [2.3978, 0.9964, 1.3423e-95, 2.4626e-214, 0.0],
    [35.8749, 1.2009, 5.3438, 6.3772e-05, 3.0695e-05],
    [1586.7973, 7.5091, 0.13191, 4.141e-05, 2.9164e-05],
    [3.8518, 1.6354, 7.8752e-15, 8.8818e-16, 8.8818e-16],
    [0.86704, 0.050136, 0.11211, 0.0, 0.0],
    [5.6774, 0.32971, 3.1016, 9.1171e-05, 9.823e-05],
];

/// Table 4: a row per waypoint; m and rad.
#[expect(clippy::approx_constant, reason = "the paper prints 3.141")]
const TABLE_4: [[f64; 4]; 4] = [
    [0.8, 1.2, 3.141, 0.0],
    [0.578, 0.868, 1.897, 1.047],
    [0.688, 0.567, 1.468, 1.771],
    [0.459, 0.964, 2.355, 0.754],
];

/// Section 3.2: limits of velocity and acceleration per joint; m or rad.
const LIMITS: [[f64; 2]; 4] = [[0.6, 0.8], [0.6, 0.8], [1.8, 2.4], [1.8, 2.4]];

/// A method of Table 5: name as printed, name in the registry, and per joint
/// the printed total and the three times, s.
type PublishedTimes = (&'static str, &'static str, [[f64; 4]; 4]);

const TABLE_5: [PublishedTimes; 3] = [
    (
        "PSO",
        "pso",
        [
            [7.221, 1.7301, 3.5905, 1.9008],
            [7.4472, 2.0576, 2.2782, 3.0889],
            [7.0339, 2.6648, 2.3479, 2.0272],
            [6.9658, 2.0908, 2.5381, 2.3368],
        ],
    ),
    (
        "Gold-SA",
        "gold_sa",
        [
            [7.121, 1.9488, 3.1077, 2.0645],
            [7.5203, 2.2059, 2.2647, 3.0497],
            [6.9526, 2.4483, 2.4637, 2.0406],
            [7.1518, 2.3862, 2.4097, 2.356],
        ],
    ),
    (
        "GoldS-PSO",
        "golds_pso",
        [
            [7.0672, 2.1107, 2.954, 2.0025],
            [7.2177, 2.0009, 2.6121, 2.6047],
            [6.897, 2.3189, 2.5846, 1.9935],
            [6.8713, 2.0205, 2.5096, 2.3412],
        ],
    ),
];

/// The composed times and their total as the results and the conclusion print it, s.
const COMPOSED: ([f64; 3], f64, f64) = ([2.3189, 2.954, 2.6047], 7.8776, 7.8876);

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    Ok(vec![table_3(runs)?, shifted(runs)?, table_5(runs)?, composition()?])
}

fn functions(runs: u32, shifted: bool) -> Result<ComparisonResult, ReproduceError> {
    let optimizers: Vec<&str> = METHODS.iter().map(|(_, name)| *name).collect();
    experiment::benchmark(json!({
        "type": "benchmark", "dimension": 30, "population": 30, "iterations": 1000,
        "runs": runs, "optimizers": optimizers, "shifted": shifted,
    }))
}

fn table_3(runs: u32) -> Result<Section, ReproduceError> {
    let result = functions(runs, false)?;
    let mut section = Section::new("Chen et al., Table 3: benchmark functions");
    section.paragraph("30 particles, 30 variables, 1000 iterations; means over the runs.");
    let mut rows = Vec::new();
    for (problem, published) in result.problems.iter().zip(TABLE_3) {
        for ((row, (method, _)), published) in problem.methods.iter().zip(METHODS).zip(published) {
            let ours = row.mean.unwrap_or(f64::NAN);
            let verdict = section.judge(Verdict::of(published, ours, 1.0));
            let (paper, ours) = (format!("{published:.3e}"), format!("{ours:.3e}"));
            rows.push(vec![format!("{} {method}", problem.name), paper, ours, verdict]);
        }
    }
    section.table(&["function, method", "paper", "ours", "verdict"], rows);
    section.paragraph(
        "Reason where they differ: the paper leaves out the parameters of GoldS-PSO and how \
         particles are kept within the range; the defaults here follow the sources it cites.",
    );
    if let Some(problem) = result.problems.first() {
        section.figure(bands(problem), "F1: the methods' runs");
    }
    Ok(section)
}

fn shifted(runs: u32) -> Result<Section, ReproduceError> {
    let result = functions(runs, true)?;
    let mut section = Section::new("Chen et al., the functions of Table 3 shifted");
    section.paragraph(
        "The optimum of almost every function in Table 3 is at the origin. A method whose moves \
         shrink positions towards zero finds it without searching. With the optimum moved off the \
         origin and everything else equal, these means remain.",
    );
    let row = |problem: &crate::plan::ProblemResult| {
        let means =
            problem.methods.iter().map(|row| format!("{:.3e}", row.mean.unwrap_or(f64::NAN)));
        std::iter::once(problem.name.clone()).chain(means).collect()
    };
    let heads: Vec<&str> =
        std::iter::once("function").chain(METHODS.iter().map(|(method, _)| *method)).collect();
    section.table(&heads, result.problems.iter().map(row).collect());
    Ok(section)
}

fn waypoints() -> Vec<Vec<f64>> {
    TABLE_4.iter().map(|row| row.to_vec()).collect()
}

fn request(optimizer: Value, clock: &str) -> Value {
    let limit = |kind: usize| LIMITS.iter().map(|limits| limits[kind]).collect::<Vec<_>>();
    let mut task = json!({
        "type": "waypoints", "interpolation": "3-5-3", "waypoints": TABLE_4,
        "clock": clock, "optimizer": optimizer,
    });
    if optimizer["name"] != "exact" {
        task["durations"] = json!({ "min": 1.0, "max": 5.0 });
    }
    // The paper minds no position limits; joint 4 passes its own under the times
    // that some seeds compose.
    let limits = json!({
        "velocity": limit(0), "acceleration": limit(1), "lower": null, "upper": null,
    });
    json!({ "robot": "woodworking_pprr", "limits": limits, "task": task })
}

fn exact(clock: &str) -> Value {
    request(json!({ "name": "exact" }), clock)
}

fn table_5(runs: u32) -> Result<Section, ReproduceError> {
    let optima: Vec<f64> = plan(exact("per_joint"))?
        .per_joint
        .unwrap_or_default()
        .iter()
        .map(|joint| joint.duration)
        .collect();
    let mut section = Section::new("Chen et al., Table 5: times per joint");
    section.paragraph(
        "3-5-3 polynomials, each joint alone, 50 particles, 300 iterations, 1 to 5 s per segment; \
         means over the runs. The peaks are exact, at the published times, over their limits. The \
         optimum is the true one of the same curves within the same limits.",
    );
    let mut rows = Vec::new();
    for (method, name, published) in TABLE_5 {
        let optimizer = json!({ "name": name, "population": 50, "iterations": 300 });
        let results = repeat(&request(optimizer, "per_joint"), runs)?;
        for (index, (published, optimum)) in published.iter().zip(&optima).enumerate() {
            let alone = results.iter().flat_map(|result| &result.per_joint);
            let totals = alone.filter_map(|joints| joints.get(index)).map(|joint| joint.duration);
            let ours = mean(&totals.collect::<Vec<f64>>());
            rows.push(row_of_table_5(&mut section, method, index, published, ours, *optimum)?);
        }
    }
    let heads = ["method, joint", "paper s", "ours s", "optimum s", "speed", "acceleration"];
    section.table(&[&heads[..], &["verdict"]].concat(), rows);
    section.paragraph(
        "The times published for joint 1 break the acceleration limit in every row and lie below \
         the true optimum; no lawful plan can reproduce them. Where the paper contradicts itself, \
         the printed total is not the sum of the printed times.",
    );
    Ok(section)
}

fn row_of_table_5(
    section: &mut Section,
    method: &str,
    index: usize,
    published: &[f64; 4],
    ours: f64,
    optimum: f64,
) -> Result<Vec<String>, ReproduceError> {
    let [total, times @ ..] = published;
    let found = peaks("3-5-3", &joint(&waypoints(), index), times)?;
    let ratio = |order: usize| found.iter().map(move |peak| peak[order] / LIMITS[index][order]);
    let [speed, acceleration] = [0, 1].map(|order| ratio(order).fold(0.0, f64::max));
    // Times printed to four decimals move a peak by less than 0.1 %.
    let verdict = if speed.max(acceleration) > 1.01 {
        Verdict::BreaksItsLimits
    } else if (times.iter().sum::<f64>() - total).abs() > 1e-3 {
        Verdict::PaperContradictsItself
    } else {
        Verdict::of(*total, ours, 0.01)
    };
    let figures = [*total, ours, optimum].map(|value| format!("{value:.4}"));
    let ratios = [speed, acceleration].map(|ratio| format!("{ratio:.3}"));
    let head = format!("{method} {}", index + 1);
    let cells = std::iter::once(head).chain(figures).chain(ratios);
    Ok(cells.chain([section.judge(verdict)]).collect())
}

fn composition() -> Result<Section, ReproduceError> {
    let (times, results, conclusion) = COMPOSED;
    let found = peaks("3-5-3", &waypoints(), &times)?;
    let ratios = found
        .iter()
        .zip(LIMITS)
        .map(|(peak, limit)| (0..2).map(|order| peak[order] / limit[order]).fold(0.0, f64::max));
    let worst = ratios.fold(0.0, f64::max);
    let sum: f64 = times.iter().sum();
    let mut section = Section::new("Chen et al., all joints together");
    section.finding(
        "Total of the conclusion",
        Verdict::PaperContradictsItself,
        &format!(
            "The results print {results} s, the conclusion {conclusion} s; the times sum to \
             {sum:.4} s. The percentages of the abstract follow from neither."
        ),
    );
    let at_once = plan(exact("shared"))?.duration;
    let composed = plan(exact("per_joint"))?.duration;
    section.paragraph(format!(
        "All joints at the published times reach {worst:.3} of their limits. Exact times per joint, \
         composed by the largest per segment, need {composed:.4} s; all joints planned at once need \
         {at_once:.4} s on the same curves (exact), the published {results} s."
    ));
    Ok(section)
}
