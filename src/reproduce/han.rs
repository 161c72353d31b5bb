//! Han et al. 2022, doi:10.3390/a15080269: Table 5 (times per joint) and
//! Table 6 (section totals) of a circuit breaker assembly.

use serde_json::{Value, json};

use super::experiment::{ReproduceError, joint, mean, peaks, plan, repeat};
use super::report::Section;
use super::verdict::Verdict;

pub(super) const CITATION: &str = "Han, Shu, Wu, Chen, Zhang, Cai: Research of flexible assembly \
    of miniature circuit breakers based on robot trajectory optimization. Algorithms 15 (2022) \
    269, doi:10.3390/a15080269";

/// Table 2: a row per waypoint, deg.
const TABLE_2: [[f64; 6]; 4] = [
    [0.0, -35.1, -29.8, 0.0, -25.1, 0.0],
    [-24.0, -37.7, -30.6, 0.0, -21.7, 23.96],
    [-43.7, -52.2, -4.14, 0.0, -33.6, 135.3],
    [-30.0, -58.3, -2.11, 0.0, -29.6, 125.0],
];

/// Table 4: limits of velocity, acceleration and jerk; rad.
const TABLE_4: [[f64; 6]; 3] = [
    [0.9, 0.9, 0.9, 0.9, 0.95, 1.0],
    [0.9, 0.9, 0.9, 0.9, 0.9, 1.0],
    [2.0, 2.0, 2.0, 2.0, 2.0, 2.0],
];

/// The speed limits that the peaks at the times of Table 5 show, rad/s.
const SPEEDS: [f64; 6] = [0.5, 0.5, 0.5, 0.5, 0.5, 1.0];

/// Table 5: joint index and the times of standard and of improved PSO, s.
/// Joint 4 does not move.
const TABLE_5: [(usize, [[f64; 3]; 2]); 5] = [
    (0, [[3.0, 1.43, 1.9], [2.79, 1.29, 1.68]]),
    (1, [[0.38, 0.68, 0.7], [0.3, 0.54, 0.56]]),
    (2, [[0.63, 1.98, 0.58], [0.46, 1.67, 0.45]]),
    (4, [[0.81, 1.15, 0.85], [0.67, 0.88, 0.71]]),
    (5, [[1.95, 3.34, 1.85], [1.88, 3.31, 1.79]]),
];

/// Table 5, row "optimal": the times of all joints, s.
const COMPOSED: [[f64; 3]; 2] = [[3.0, 3.34, 1.9], [2.79, 3.31, 1.79]];

/// Table 6: standard and improved PSO per section AB, BC, CD, DE, s.
const TABLE_6: [[[f64; 3]; 2]; 4] = [
    [[3.0, 2.79, 3.34], [3.31, 1.9, 1.79]],
    [[4.03, 1.8, 7.31], [4.1, 1.63, 5.8]],
    [[3.0, 5.49, 4.11], [2.46, 4.89, 3.3]],
    [[3.54, 1.55, 1.27], [2.82, 1.28, 1.05]],
];

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    Ok(vec![table_5(runs)?, together()?, table_6()?])
}

fn waypoints() -> Vec<Vec<f64>> {
    TABLE_2.iter().map(|row| row.iter().map(|angle| angle.to_radians()).collect()).collect()
}

/// Section AB; the paper counts some joints the other way round than the
/// robot's position limits do, so that these do not hold.
fn request(optimizer: Value, clock: &str, limits: Value) -> Value {
    let mut task = json!({
        "type": "waypoints", "interpolation": "quintic_han", "waypoints": waypoints(),
        "clock": clock, "optimizer": optimizer,
    });
    if optimizer["name"] != "exact" {
        // The paper searches from 0 s, where no curve exists.
        task["durations"] = json!({ "min": 0.1, "max": 5.0 });
    }
    let mut request = json!({ "robot": "rokae_xb4", "limits": limits, "task": task });
    request["limits"]["lower"] = Value::Null;
    request["limits"]["upper"] = Value::Null;
    request
}

fn speed_alone() -> Value {
    json!({ "velocity": SPEEDS, "acceleration": null, "jerk": null })
}

fn table_4() -> Value {
    json!({ "velocity": TABLE_4[0], "acceleration": TABLE_4[1], "jerk": TABLE_4[2] })
}

fn totals(request: &Value, runs: u32) -> Result<Vec<f64>, ReproduceError> {
    let results = repeat(request, runs)?;
    let total = |index: usize| {
        let joints = results.iter().flat_map(|result| &result.per_joint);
        mean(
            &joints
                .filter_map(|joints| joints.get(index))
                .map(|it| it.duration)
                .collect::<Vec<_>>(),
        )
    };
    Ok((0..TABLE_5.len()).map(total).collect())
}

fn table_5(runs: u32) -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., Table 5: times per joint");
    section.paragraph(
        "C3 quintics, each joint alone, 50 particles, 100 iterations; means over the runs. The \
         limits are speed alone, 0.5 rad/s and 1.0 rad/s for joint 6: the peaks of the published \
         times show that these were used and not Table 4. Peaks are exact, at the published times.",
    );
    let optima = totals(&request(json!({ "name": "exact" }), "per_joint", speed_alone()), 1)?;
    let mut rows = Vec::new();
    for (column, name) in ["pso", "improved_pso"].into_iter().enumerate() {
        let optimizer = json!({ "name": name, "population": 50, "iterations": 100 });
        let ours = totals(&request(optimizer, "per_joint", speed_alone()), runs)?;
        for (((index, published), ours), optimum) in TABLE_5.iter().zip(ours).zip(&optima) {
            let times = &published[column];
            let total: f64 = times.iter().sum();
            let peak = peaks("quintic_han", &joint(&waypoints(), *index), times)?;
            let peak = peak.first().copied().unwrap_or_default();
            // Times are printed to two decimals, up to 2 % of the shortest.
            let broken = peak[0] > 1.02 * SPEEDS[*index];
            let judged = Verdict::of(total, ours, 0.01);
            let verdict = section.judge(if broken { Verdict::BreaksItsLimits } else { judged });
            let figures = [total, ours, *optimum, peak[0], peak[1], peak[2]];
            let figures = figures.map(|value| format!("{value:.3}"));
            let head = format!("{name} {}", index + 1);
            rows.push(std::iter::once(head).chain(figures).chain([verdict]).collect());
        }
    }
    let heads = ["method, joint", "paper s", "ours s", "optimum s", "speed", "acceleration"];
    section.table(&[&heads[..], &["jerk", "verdict"]].concat(), rows);
    let (index, published) = TABLE_5[1];
    let alone = peaks("quintic_han", &joint(&waypoints(), index), &published[1])?;
    let [_, acceleration, jerk] = alone.first().copied().unwrap_or_default();
    section.finding(
        "Table 5 under Table 4",
        Verdict::BreaksItsLimits,
        &format!(
            "Joint 2 alone at its published times reaches {acceleration:.2} rad/s^2 and {jerk:.1} \
             rad/s^3, where Table 4 allows 0.9 and 2.0."
        ),
    );
    Ok(section)
}

fn together() -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., all joints together");
    let found = peaks("quintic_han", &waypoints(), &COMPOSED[1])?;
    let largest = |order: usize| found.iter().map(|peak| peak[order]).fold(0.0, f64::max);
    let published = [("acceleration, rad/s^2", 1, 0.8), ("jerk, rad/s^3", 2, 1.51)];
    let mut rows = Vec::new();
    for (what, order, published) in published {
        let ours = largest(order);
        // The paper reads its peaks off a picture.
        let verdict = section.judge(Verdict::of(published, ours, 0.03));
        rows.push(vec![what.to_owned(), published.to_string(), format!("{ours:.3}"), verdict]);
    }
    section.table(&["peak at the published times (Figure 13)", "paper", "ours", "verdict"], rows);
    let exact = plan(request(json!({ "name": "exact" }), "shared", table_4()))?.duration;
    section.paragraph(format!(
        "The published times sum to {:.2} s. All joints planned at once (exact) need {exact:.4} s \
         on the same curves within Table 4.",
        COMPOSED[1].iter().sum::<f64>()
    ));
    Ok(section)
}

fn table_6() -> Result<Section, ReproduceError> {
    let mut section = Section::new("Han et al., Table 6: sections");
    let total = |rows: &[[[f64; 3]; 2]], column: usize| -> f64 {
        rows.iter().flat_map(|row| &row[column]).sum()
    };
    let corrected = [&[COMPOSED][..], &TABLE_6[1..]].concat();
    let row = |what: &str, rows: &[[[f64; 3]; 2]]| {
        let [standard, improved] = [0, 1].map(|column| total(rows, column));
        let saved = standard - improved;
        let figures = [standard, improved, saved, 100.0 * saved / standard];
        std::iter::once(what.to_owned()).chain(figures.map(|it| format!("{it:.2}"))).collect()
    };
    let rows = vec![row("as printed", &TABLE_6), row("row AB from Table 5", &corrected)];
    section.table(&["totals", "standard s", "improved s", "saved s", "saved %"], rows);
    let found = peaks("quintic_han", &waypoints(), &TABLE_6[0][1])?;
    let largest = |order: usize| found.iter().map(|peak| peak[order]).fold(0.0, f64::max);
    section.finding(
        "Row AB",
        Verdict::PaperContradictsItself,
        "Its six times are those of Table 5's row \"optimal\", dealt to the two methods in the \
         wrong order.",
    );
    section.finding(
        "Row AB as printed, improved PSO",
        Verdict::BreaksItsLimits,
        &format!(
            "Its peaks are {:.3} rad/s, {:.3} rad/s^2 and {:.2} rad/s^3.",
            largest(0),
            largest(1),
            largest(2)
        ),
    );
    section.finding(
        "Rows BC, CD and DE",
        Verdict::CannotBeCompared,
        "Their waypoints and limits are not printed.",
    );
    Ok(section)
}
