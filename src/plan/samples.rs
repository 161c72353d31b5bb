//! Samples of a trajectory, and the curve their consumer runs through them.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::fault::{Faults, read};
use crate::robot::Robot;
use crate::trajectory::{self, JointTrajectory, JointTrajectoryPoint, MAX_SAMPLES, Trajectory};

/// Samples, and how the consumer interpolates between them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Samples {
    /// How the consumer runs from sample to sample.
    pub interpolation: SampleInterpolation,
    /// The samples.
    #[serde(flatten)]
    pub form: SampleForm,
}

/// How a consumer runs from sample to sample. What it does not need, it ignores.
///
/// ROS' `joint_trajectory_controller` takes the highest its points allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SampleInterpolation {
    /// Straight lines through positions: velocity jumps at samples.
    Linear,
    /// Hermite's cubics through positions and velocities: acceleration jumps at samples.
    Cubic,
    /// Hermite's quintics through positions, velocities and accelerations.
    Quintic,
}

/// Samples as lists of one's own, or as Takt exports them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum SampleForm {
    /// One list per quantity.
    Lists(SampleLists),
    /// A trajectory as `GET /v1/jobs/{id}/trajectory?format=samples` delivers it.
    Export(trajectory::Samples),
    /// A trajectory in ROS' shape, as `format=joint_trajectory` delivers it.
    JointTrajectory(JointTrajectory),
}

/// One list per quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SampleLists {
    /// Joint order of every row; the robot's if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_names: Option<Vec<String>>,
    /// Ascending, starting at 0, s.
    pub times: Vec<f64>,
    /// Per sample and joint, rad or m.
    pub positions: Vec<Vec<f64>>,
    /// Per sample and joint, rad/s or m/s; for `cubic` and `quintic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocities: Option<Vec<Vec<f64>>>,
    /// Per sample and joint, rad/s² or m/s²; for `quintic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accelerations: Option<Vec<Vec<f64>>>,
}

impl Samples {
    /// Reads the samples that stand at `/samples`; the structure only. Members
    /// that only one form has tell the forms apart.
    pub(super) fn parse(mut value: Value, faults: &mut Faults) -> Option<Self> {
        let Value::Object(members) = &mut value else {
            faults.add("/samples", "expected an object: the samples and their `interpolation`");
            return None;
        };
        let interpolation = match members.shift_remove("interpolation") {
            Some(name) => read(name, "/samples/interpolation", faults),
            None => {
                let detail = "missing field `interpolation`: `linear`, `cubic` or `quintic`";
                faults.add("/samples/interpolation", detail);
                None
            }
        };
        let form = if members.contains_key("points") {
            read(value, "/samples", faults).map(SampleForm::JointTrajectory)
        } else if members.contains_key("rate_hz") {
            read(value, "/samples", faults).map(SampleForm::Export)
        } else {
            read(value, "/samples", faults).map(SampleForm::Lists)
        };
        Some(Self { interpolation: interpolation?, form: form? })
    }

    /// The curve the consumer follows, exact but for rounding.
    pub(super) fn trajectory(&self, robot: &Robot, faults: &mut Faults) -> Option<Trajectory> {
        let table = self.form.table();
        let columns = table.check(self.interpolation, robot, faults)?;
        let Table { times, rows, .. } = table;
        let rows = rows.map(Option::unwrap_or_default);
        let piece = |index: usize| -> Vec<Vec<f64>> {
            let h = times[index + 1] - times[index];
            let joint = |&column: &usize| {
                let ends = |order: usize| [0, 1].map(|end| rows[order][index + end][column]);
                match self.interpolation {
                    SampleInterpolation::Linear => linear(ends(0), h),
                    SampleInterpolation::Cubic => cubic(ends(0), ends(1), h),
                    SampleInterpolation::Quintic => quintic(ends(0), ends(1), ends(2), h),
                }
            };
            columns.iter().map(joint).collect()
        };
        let pieces = (0..times.len() - 1).map(piece).collect();
        let trajectory = Trajectory { breakpoints: times, pieces };
        match trajectory.validate(robot.dof()) {
            Ok(()) => Some(trajectory),
            Err(error) => {
                faults.add("/samples", format!("{error}; piece i starts at sample i"));
                None
            }
        }
    }
}

/// Samples whatever their form, and what their lists are called.
struct Table<'a> {
    /// Times, positions, velocities, accelerations.
    names: [&'static str; 4],
    /// True if each sample is an object of its own, false if each list is.
    by_sample: bool,
    joint_names: Option<&'a [String]>,
    times: Vec<f64>,
    /// Positions, velocities, accelerations by sample; none where not given.
    rows: [Option<Vec<&'a [f64]>>; 3],
}

impl SampleForm {
    fn table(&self) -> Table<'_> {
        match self {
            Self::Lists(lists) => Table {
                names: ["times", "positions", "velocities", "accelerations"],
                by_sample: false,
                joint_names: lists.joint_names.as_deref(),
                times: lists.times.clone(),
                rows: [
                    Some(&lists.positions),
                    lists.velocities.as_ref(),
                    lists.accelerations.as_ref(),
                ]
                .map(|list| list.map(|list| slices(list))),
            },
            Self::Export(export) => Table {
                names: ["time", "position", "velocity", "acceleration"],
                by_sample: false,
                joint_names: Some(&export.joint_names),
                times: export.time.clone(),
                rows: [&export.position, &export.velocity, &export.acceleration]
                    .map(|list| Some(slices(list))),
            },
            Self::JointTrajectory(message) => Table {
                names: ["time_from_start", "positions", "velocities", "accelerations"],
                by_sample: true,
                joint_names: Some(&message.joint_names),
                times: message.points.iter().map(|point| point.time_from_start.seconds()).collect(),
                rows: point_rows(&message.points),
            },
        }
    }
}

fn slices(list: &[Vec<f64>]) -> Vec<&[f64]> {
    list.iter().map(Vec::as_slice).collect()
}

/// In ROS' messages a list that is not given is empty at every point.
fn point_rows(points: &[JointTrajectoryPoint]) -> [Option<Vec<&[f64]>>; 3] {
    let list = |of: fn(&JointTrajectoryPoint) -> &Vec<f64>| {
        let rows: Vec<&[f64]> = points.iter().map(|point| of(point).as_slice()).collect();
        rows.iter().any(|row| !row.is_empty()).then_some(rows)
    };
    [
        list(|point| &point.positions),
        list(|point| &point.velocities),
        list(|point| &point.accelerations),
    ]
}

impl Table<'_> {
    /// Per joint of the robot its column, if the samples have no fault.
    fn check(
        &self,
        interpolation: SampleInterpolation,
        robot: &Robot,
        faults: &mut Faults,
    ) -> Option<Vec<usize>> {
        let before = faults.0.len();
        let count = self.times.len();
        if !(2..=MAX_SAMPLES).contains(&count) {
            let detail = format!("{count} samples; 2 to {MAX_SAMPLES} are taken");
            faults.add(self.list(0), detail);
            return None;
        }
        self.check_times(faults);
        for (order, rows) in self.rows.iter().enumerate() {
            match rows {
                Some(rows) => self.check_rows(order + 1, rows, robot.dof(), faults),
                None if order <= interpolation as usize => {
                    let name = self.names[order + 1];
                    let detail = format!("missing {name}: the interpolation named needs them");
                    faults.add(self.list(order + 1), detail);
                }
                None => {}
            }
        }
        let columns = columns(self.joint_names, robot, faults);
        (faults.0.len() == before).then_some(columns)
    }

    fn check_times(&self, faults: &mut Faults) {
        let first = self.times[0];
        if first != 0.0 {
            faults.add(self.entry(0, 0), format!("{first} s; the first sample's time is 0"));
        }
        for (index, pair) in self.times.windows(2).enumerate() {
            let [before, time] = [pair[0], pair[1]];
            if !time.is_finite() {
                faults.add(self.entry(0, index + 1), format!("{time} s is not a time"));
            } else if time <= before {
                let detail = format!("{time} s does not come after {before} s; times ascend");
                faults.add(self.entry(0, index + 1), detail);
            }
        }
    }

    fn check_rows(&self, list: usize, rows: &[&[f64]], dof: usize, faults: &mut Faults) {
        let (found, count) = (rows.len(), self.times.len());
        if found != count {
            faults.add(self.list(list), format!("{found} rows for {count} times"));
        }
        for (sample, row) in rows.iter().enumerate() {
            let place = || self.entry(list, sample);
            if row.len() != dof {
                faults.add(place(), format!("{} values for {dof} joints", row.len()));
            }
            for (column, value) in row.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
                faults.add(format!("{}/{column}", place()), format!("{value} is not finite"));
            }
        }
    }

    /// Where a list stands in the request.
    fn list(&self, list: usize) -> String {
        let name = if self.by_sample { "points" } else { self.names[list] };
        format!("/samples/{name}")
    }

    /// Where a list's entry for one sample stands in the request.
    fn entry(&self, list: usize, sample: usize) -> String {
        let name = self.names[list];
        if self.by_sample {
            format!("/samples/points/{sample}/{name}")
        } else {
            format!("/samples/{name}/{sample}")
        }
    }
}

/// Where each joint of the robot stands in a row: by name, as ROS reads it.
fn columns(names: Option<&[String]>, robot: &Robot, faults: &mut Faults) -> Vec<usize> {
    let Some(names) = names else { return (0..robot.dof()).collect() };
    let place = "/samples/joint_names";
    if names.len() != robot.dof() {
        let detail =
            format!("{} names for the {} joints of {}", names.len(), robot.dof(), robot.name());
        faults.add(place, detail);
    }
    let mut columns = Vec::with_capacity(robot.dof());
    for joint in robot.joint_names() {
        match names.iter().position(|name| name == joint) {
            Some(column) => columns.push(column),
            None => faults.add(place, format!("joint `{joint}` of {} is missing", robot.name())),
        }
    }
    columns
}

// Hermite's polynomials, ascending powers of local time, over a duration `h`.
// They are built from what remains at the end of the motion that the state at
// the start would lead to. The end's velocity and acceleration do not depend on
// the remainder of the position, so its rounding, which the powers of a short
// `h` magnify, cannot make them jump from piece to piece.

/// Between two positions.
fn linear([x0, x1]: [f64; 2], h: f64) -> Vec<f64> {
    vec![x0, (x1 - x0) / h]
}

/// Between two positions and velocities.
fn cubic([x0, x1]: [f64; 2], [v0, v1]: [f64; 2], h: f64) -> Vec<f64> {
    let position = (x1 - x0) - v0 * h;
    let velocity = (v1 - v0) * h;
    let h2 = h * h;
    vec![x0, v0, (3.0 * position - velocity) / h2, (velocity - 2.0 * position) / (h2 * h)]
}

/// Between two positions, velocities and accelerations.
fn quintic([x0, x1]: [f64; 2], [v0, v1]: [f64; 2], [a0, a1]: [f64; 2], h: f64) -> Vec<f64> {
    let h2 = h * h;
    let position = (x1 - x0) - v0 * h - 0.5 * a0 * h2;
    let velocity = (v1 - v0) * h - a0 * h2;
    let acceleration = (a1 - a0) * h2;
    vec![
        x0,
        v0,
        0.5 * a0,
        (10.0 * position - 4.0 * velocity + 0.5 * acceleration) / (h2 * h),
        (7.0 * velocity - 15.0 * position - acceleration) / (h2 * h2),
        (6.0 * position - 3.0 * velocity + 0.5 * acceleration) / (h2 * h2 * h),
    ]
}
