//! A certificate for anyone's trajectory.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::limits;
use super::prepare::resolve_robot;
use super::request::{LimitOverrides, LimitScale, RobotRef};
use crate::fault::{Faults, read};
use crate::robot::Robot;
use crate::trajectory::{Certificate, Trajectory};

/// Most samples of one request.
pub const MAX_SAMPLES: usize = 200_000;

/// A trajectory to certify: polynomial pieces or samples, one of the two.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct VerifyRequest {
    /// A catalogue or registered robot by name, or a robot object inline.
    pub robot: RobotRef,
    /// Limits that replace the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitOverrides>,
    /// Factors on the limits, after `limits` replaced them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_scale: Option<LimitScale>,
    /// Polynomial pieces, as results deliver them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<Trajectory>,
    /// Samples, and how the consumer interpolates between them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<Samples>,
    /// Configurations to be passed, and when.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waypoints: Option<Vec<DueWaypoint>>,
}

/// A configuration that is due.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DueWaypoint {
    /// When, s.
    pub time: f64,
    /// In joint order, rad or m.
    pub position: Vec<f64>,
}

/// Samples of a trajectory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Samples {
    /// How the consumer runs from sample to sample.
    pub interpolation: SampleInterpolation,
    /// Ascending, starting at 0, s.
    pub times: Vec<f64>,
    /// Per sample and joint, rad or m.
    pub positions: Vec<Vec<f64>>,
    /// Per sample and joint; for `cubic` and `quintic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocities: Option<Vec<Vec<f64>>>,
    /// Per sample and joint; for `quintic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accelerations: Option<Vec<Vec<f64>>>,
}

/// How a consumer runs from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SampleInterpolation {
    /// Straight lines: velocity jumps at samples.
    Linear,
    /// Cubics through positions and velocities (ROS controllers given both).
    Cubic,
    /// Quintics through positions, velocities and accelerations.
    Quintic,
}

impl VerifyRequest {
    /// Reads a request; the structure only.
    ///
    /// # Errors
    ///
    /// Every field that is missing, unknown or of the wrong type.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            robot: Value,
            #[serde(default)]
            limits: Option<LimitOverrides>,
            #[serde(default)]
            limit_scale: Option<LimitScale>,
            #[serde(default)]
            trajectory: Option<Trajectory>,
            #[serde(default)]
            samples: Option<Samples>,
            #[serde(default)]
            waypoints: Option<Vec<DueWaypoint>>,
        }
        let mut faults = Faults::default();
        let Some(raw) = read::<Raw>(value, "", &mut faults) else { return Err(faults) };
        let Some(robot) = RobotRef::parse(raw.robot, "/robot", &mut faults) else {
            return Err(faults);
        };
        let Raw { limits, limit_scale, trajectory, samples, waypoints, .. } = raw;
        Ok(Self { robot, limits, limit_scale, trajectory, samples, waypoints })
    }
}

/// Certifies a trajectory.
///
/// # Errors
///
/// Every fault of the request; an unlawful trajectory is not one.
pub fn verify(
    request: &VerifyRequest,
    find_robot: &dyn Fn(&str) -> Option<Arc<Robot>>,
) -> Result<Certificate, Faults> {
    let mut faults = Faults::default();
    let Some(robot) = resolve_robot(&request.robot, find_robot, &mut faults) else {
        return Err(faults);
    };
    let limits =
        limits::resolve(&robot, request.limits.as_ref(), request.limit_scale.as_ref(), &mut faults);
    let trajectory = match (&request.trajectory, &request.samples) {
        (Some(trajectory), None) => {
            let valid = trajectory.validate(robot.dof());
            valid
                .map(|()| trajectory.clone())
                .map_err(|error| faults.add("/trajectory", error.to_string()))
        }
        (None, Some(samples)) => samples.trajectory(robot.dof(), &mut faults).ok_or(()),
        (Some(_), Some(_)) | (None, None) => {
            faults.add("", "give either `trajectory` or `samples`");
            Err(())
        }
    };
    let none = Vec::new();
    let waypoints = request.waypoints.as_ref().unwrap_or(&none);
    for (index, waypoint) in waypoints.iter().enumerate() {
        let (found, dof) = (waypoint.position.len(), robot.dof());
        if found != dof {
            let detail = format!("{found} values for {dof} joints");
            faults.add(format!("/waypoints/{index}/position"), detail);
        }
    }
    let Ok(trajectory) = trajectory else { return Err(faults) };
    let due: Vec<(f64, &[f64])> =
        waypoints.iter().map(|waypoint| (waypoint.time, waypoint.position.as_slice())).collect();
    faults.into_result(()).map(|()| Certificate::new(&trajectory, &limits, &due))
}

impl Samples {
    /// The curve the consumer follows.
    fn trajectory(&self, dof: usize, faults: &mut Faults) -> Option<Trajectory> {
        self.check(dof, faults)?;
        let none = vec![vec![0.0; dof]; self.times.len()];
        let velocities = self.velocities.as_ref().unwrap_or(&none);
        let accelerations = self.accelerations.as_ref().unwrap_or(&none);
        let piece = |index: usize| -> Vec<Vec<f64>> {
            let h = self.times[index + 1] - self.times[index];
            let joint = |joint: usize| {
                let ends = |rows: &[Vec<f64>]| [rows[index][joint], rows[index + 1][joint]];
                let x = ends(&self.positions);
                match self.interpolation {
                    SampleInterpolation::Linear => vec![x[0], (x[1] - x[0]) / h],
                    SampleInterpolation::Cubic => cubic(x, ends(velocities), h),
                    SampleInterpolation::Quintic => {
                        quintic(x, ends(velocities), ends(accelerations), h)
                    }
                }
            };
            (0..dof).map(joint).collect()
        };
        let pieces = (0..self.times.len() - 1).map(piece).collect();
        let trajectory = Trajectory { breakpoints: self.times.clone(), pieces };
        match trajectory.validate(dof) {
            Ok(()) => Some(trajectory),
            Err(error) => {
                faults.add("/samples", error.to_string());
                None
            }
        }
    }

    fn check(&self, dof: usize, faults: &mut Faults) -> Option<()> {
        let before = faults.0.len();
        let count = self.times.len();
        if !(2..=MAX_SAMPLES).contains(&count) {
            faults.add("/samples/times", format!("{count} samples; 2 to {MAX_SAMPLES} are taken"));
        }
        let needed = match self.interpolation {
            SampleInterpolation::Linear => [false, false],
            SampleInterpolation::Cubic => [true, false],
            SampleInterpolation::Quintic => [true, true],
        };
        let rows = [
            ("positions", Some(&self.positions), true),
            ("velocities", self.velocities.as_ref(), needed[0]),
            ("accelerations", self.accelerations.as_ref(), needed[1]),
        ];
        for (name, rows, needed) in rows {
            let place = format!("/samples/{name}");
            match rows {
                None if needed => faults.add(place, "this interpolation needs them"),
                None => {}
                Some(_) if !needed => faults.add(place, "this interpolation does not use them"),
                Some(rows) => check_rows(rows, count, dof, &place, faults),
            }
        }
        (faults.0.len() == before).then_some(())
    }
}

fn check_rows(rows: &[Vec<f64>], count: usize, dof: usize, place: &str, faults: &mut Faults) {
    if rows.len() != count {
        faults.add(place, format!("{} rows for {count} times", rows.len()));
    }
    if let Some(index) = rows.iter().position(|row| row.len() != dof) {
        let found = rows[index].len();
        faults.add(format!("{place}/{index}"), format!("{found} values for {dof} joints"));
    }
}

/// The cubic between two positions and velocities.
fn cubic(x: [f64; 2], v: [f64; 2], h: f64) -> Vec<f64> {
    let way = x[1] - x[0];
    let (w0, w1) = (v[0] * h, v[1] * h);
    vec![x[0], v[0], (3.0 * way - 2.0 * w0 - w1) / (h * h), (w0 + w1 - 2.0 * way) / (h * h * h)]
}

/// The quintic between two positions, velocities and accelerations.
fn quintic(x: [f64; 2], v: [f64; 2], a: [f64; 2], h: f64) -> Vec<f64> {
    let way = x[1] - x[0];
    let (h2, h3) = (h * h, h * h * h);
    let (w0, w1, b0, b1) = (v[0] * h, v[1] * h, a[0] * h2, a[1] * h2);
    vec![
        x[0],
        v[0],
        0.5 * a[0],
        (10.0 * way - 6.0 * w0 - 4.0 * w1 - 1.5 * b0 + 0.5 * b1) / h3,
        (-15.0 * way + 8.0 * w0 + 7.0 * w1 + 1.5 * b0 - b1) / (h3 * h),
        (6.0 * way - 3.0 * (w0 + w1) - 0.5 * (b0 - b1)) / (h3 * h2),
    ]
}
