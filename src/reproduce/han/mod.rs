//! Han et al. 2022: Table 5 (times per joint), Figure 12 (convergence), Tables 6
//! and 7 (sections and parts) of a circuit breaker assembly.

mod convergence;
mod data;
mod sections;
mod times;

use serde_json::{Value, json};

use super::experiment::ReproduceError;
use super::possible::Problem;
use super::report::Section;
use data::{TABLE_2, TABLE_4};

pub(super) const CITATION: &str = "Han, Shu, Wu, Chen, Zhang, Cai: Research of flexible assembly \
                                   of miniature circuit breakers based on robot trajectory \
                                   optimization. Algorithms 15 (2022) 269, doi:10.3390/a15080269";

/// The paper's curve.
const FAMILY: &str = "quintic_han";

pub(super) fn sections(runs: u32) -> Result<Vec<Section>, ReproduceError> {
    Ok(vec![
        times::table_5(runs)?,
        times::together(runs)?,
        convergence::figure_12(runs)?,
        sections::table_6()?,
        sections::table_7(),
    ])
}

/// The paper's motion, for what is possible.
pub(super) fn problems() -> Vec<Problem> {
    vec![Problem {
        name: "Han et al., AB".to_owned(),
        published: Some(data::COMPOSED[1].iter().sum()),
        family: FAMILY,
        jerk_limited: true,
        scenario: "mcb-ab",
    }]
}

fn waypoints() -> Vec<Vec<f64>> {
    TABLE_2.iter().map(|row| row.iter().map(|angle| angle.to_radians()).collect()).collect()
}

/// Section AB; the paper counts some joints the other way round than the
/// robot's position limits do, so that these do not hold.
fn request(optimizer: Value, clock: &str, limits: Value) -> Value {
    let mut task = json!({
        "type": "waypoints", "interpolation": FAMILY, "waypoints": waypoints(),
        "clock": clock, "optimizer": optimizer,
    });
    if optimizer["name"] != "exact" {
        task["durations"] = range();
        task["constraint_handling"] = json!(handling(&optimizer));
    }
    let mut request = json!({ "robot": "rokae_xb4", "limits": limits, "task": task });
    request["limits"]["lower"] = Value::Null;
    request["limits"]["upper"] = Value::Null;
    request
}

/// The paper searches from 0 s, where no curve exists.
fn range() -> Value {
    json!({ "min": 0.02, "max": 5.0 })
}

/// The improved swarm's "fitness switch" stretches segments over a limit; of the
/// other methods nothing is said, and what breaks a limit is rejected.
fn handling(optimizer: &Value) -> &'static str {
    if optimizer["name"] == "improved_pso" { "repair_segment" } else { "reject" }
}

fn speed_alone() -> Value {
    json!({ "velocity": data::SPEEDS, "acceleration": null, "jerk": null })
}

fn table_4() -> Value {
    json!({ "velocity": TABLE_4[0], "acceleration": TABLE_4[1], "jerk": TABLE_4[2] })
}
