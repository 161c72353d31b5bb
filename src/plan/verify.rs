//! A certificate for anyone's trajectory.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::limits;
use super::prepare::resolve_robot;
use super::request::{LimitOverrides, LimitScale, RobotRef, ViaTolerance};
use super::samples::Samples;
use crate::fault::{Faults, read};
use crate::robot::Robot;
use crate::trajectory::{Certificate, TcpLimit, Trajectory};

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
    /// By how much each joint may miss `waypoints`, rad or m; default: any miss is only told. Those due where the trajectory
    /// starts or ends are met exactly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub via_tolerance: Option<ViaTolerance>,
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
            samples: Option<Value>,
            #[serde(default)]
            waypoints: Option<Vec<DueWaypoint>>,
            #[serde(default)]
            via_tolerance: Option<ViaTolerance>,
        }
        let mut faults = Faults::default();
        let Some(raw) = read::<Raw>(value, "", &mut faults) else { return Err(faults) };
        let Raw { robot, limits, limit_scale, trajectory, samples, waypoints, via_tolerance } = raw;
        let robot = RobotRef::parse(robot, "/robot", &mut faults);
        let samples = samples.and_then(|samples| Samples::parse(samples, &mut faults));
        let Some(robot) = robot else { return Err(faults) };
        faults.into_result(Self {
            robot,
            limits,
            limit_scale,
            trajectory,
            samples,
            waypoints,
            via_tolerance,
        })
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
    let tcp_speed = limits::tcp_speed(&robot, request.limits.as_ref(), &mut faults);
    let trajectory = match (&request.trajectory, &request.samples) {
        (Some(trajectory), None) => {
            let valid = trajectory.validate(robot.dof());
            valid
                .map(|()| trajectory.clone())
                .map_err(|error| faults.add("/trajectory", error.to_string()))
        }
        (None, Some(samples)) => samples.trajectory(&robot, &mut faults).ok_or(()),
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
    let tolerance = request.via_tolerance.as_ref();
    let tolerance = tolerance.and_then(|it| it.resolve(&limits, "/via_tolerance", &mut faults));
    if request.via_tolerance.is_some() && waypoints.is_empty() {
        faults.add("/via_tolerance", "there are no `waypoints` that it could hold for: give them");
    }
    let Ok(trajectory) = trajectory else { return Err(faults) };
    let due: Vec<(f64, &[f64])> =
        waypoints.iter().map(|waypoint| (waypoint.time, waypoint.position.as_slice())).collect();
    faults.into_result(())?;
    let tcp_limit =
        robot.kinematics().zip(tcp_speed).map(|(kinematics, speed)| TcpLimit { kinematics, speed });
    let certificate = Certificate::new(&trajectory, &limits, &due);
    Ok(certificate.with_tcp_limit(&trajectory, tcp_limit.as_ref()).with_via_tolerance(
        &trajectory,
        &limits,
        &due,
        tolerance.as_deref(),
    ))
}
