//! Where a robot's tool is, and how to bring it somewhere.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::{ErrorCode, Service, ServiceError, blocking};
use crate::fault::{Faults, read};
use crate::geometry::{Pose, Transform, check_pose};
use crate::robot::inverse::{InverseKinematics, Miss, PoseError, Solutions};
use crate::robot::{Jacobian, LinkFrames, Robot};

/// A configuration whose frames are wanted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ForwardKinematicsRequest {
    /// One position per joint, rad or m; may lie outside the limits.
    pub joints: Vec<f64>,
}

impl ForwardKinematicsRequest {
    /// Reads a request.
    ///
    /// # Errors
    ///
    /// Every field that is missing, unknown or of the wrong type.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        read(value, "", &mut faults).ok_or(faults)
    }
}

/// Where the robot's frames are, in world coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForwardKinematics {
    /// The joints' names in order.
    pub joint_names: Vec<String>,
    /// The tool.
    pub tool: Pose,
    /// The frame after each joint.
    pub links: Vec<Pose>,
    /// Geometric Jacobian of the tool, 6 rows with a column per joint: linear
    /// velocity (m/s), then angular velocity (rad/s), per rad/s or m/s.
    pub jacobian: Vec<Vec<f64>>,
}

/// A pose of the tool for which configurations are wanted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct InverseKinematicsRequest {
    /// Where the tool has to be, in the world.
    pub pose: Pose,
    /// One position per joint, rad or m: solutions are ordered by their distance from it, joints that can make whole
    /// turns stay near it, and where a singular place leaves a joint free it takes this position. Default: every
    /// joint at 0 or, where its limits exclude that, in their middle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<Vec<f64>>,
    /// Which solutions are wanted.
    #[serde(default)]
    pub solutions: SolutionChoice,
    /// How far a solution's pose may be from the wanted one. Only what cannot be reached exactly makes use of it.
    #[serde(default)]
    pub tolerance: PoseTolerance,
}

/// Which solutions are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SolutionChoice {
    /// All branches, the nearest to the seed first.
    #[default]
    All,
    /// The nearest to the seed alone.
    Nearest,
}

/// How far a pose may be from the wanted one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PoseTolerance {
    /// m; default 1e-4.
    pub position: f64,
    /// rad; default 1e-3.
    pub orientation: f64,
}

impl Default for PoseTolerance {
    fn default() -> Self {
        let PoseError { position, orientation } = PoseError::TOLERANCE;
        Self { position, orientation }
    }
}

impl InverseKinematicsRequest {
    /// Reads a request.
    ///
    /// # Errors
    ///
    /// Every field that is missing, unknown or of the wrong type.
    pub fn parse(value: Value) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        read(value, "", &mut faults).ok_or(faults)
    }

    fn check(&self, robot: &Robot) -> Result<(), Faults> {
        let mut faults = Faults::default();
        check_pose(&self.pose, "/pose", "the tool", &mut faults);
        if let Some(seed) = &self.seed {
            check_configuration(robot, seed, "/seed", &mut faults);
        }
        let PoseTolerance { position, orientation } = self.tolerance;
        for (name, value, unit) in
            [("position", position, "m"), ("orientation", orientation, "rad")]
        {
            if !(0.0..=1.0).contains(&value) {
                let detail = format!("{value} {unit} must be from 0 to 1 {unit}");
                faults.add(format!("/tolerance/{name}"), detail);
            }
        }
        faults.into_result(())
    }
}

/// The configurations that bring the tool to a pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InverseKinematicsAnswer {
    /// The joints' names in order.
    pub joint_names: Vec<String>,
    /// How they were found: in closed form (`spherical_wrist`, `spherical_shoulder`, `three_parallel_axes`, `scara`,
    /// `gantry`), in closed form along one joint (`redundant`), or by descents (`numeric`).
    pub method: String,
    /// True if these are all branches; false where only the nearest was asked for, where there are infinitely many, or
    /// where descents found them.
    pub complete: bool,
    /// The solutions within the limits, the nearest to the seed first.
    pub solutions: Vec<InverseSolution>,
    /// Why there is none.
    pub failure: Option<InverseFailure>,
}

/// One configuration for a pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InverseSolution {
    /// One position per joint, rad or m.
    pub joints: Vec<f64>,
    /// Per joint every position within its limits that leads to the same pose by whole turns, that of the
    /// solution included, in ascending order.
    pub equivalent: Vec<Vec<f64>>,
    /// How far the tool is from the wanted position, m.
    pub position_error: f64,
    /// The angle between the tool's orientation and the wanted one, rad.
    pub orientation_error: f64,
}

impl InverseSolution {
    fn new(inverse: &InverseKinematics, joints: &[f64], error: PoseError) -> Self {
        let same = |(joint, position): (usize, &f64)| inverse.same_positions(joint, *position);
        Self {
            joints: joints.to_vec(),
            equivalent: joints.iter().enumerate().map(same).map(Iterator::collect).collect(),
            position_error: error.position,
            orientation_error: error.orientation,
        }
    }
}

/// Why no configuration brings the tool to a pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InverseFailure {
    /// `ik_no_solution`.
    pub code: String,
    /// In words.
    pub detail: String,
    /// The configuration within the limits whose pose is nearest, as far as a search found; m and rad weigh alike.
    pub joints: Vec<f64>,
    /// How far that pose is from the wanted position, m.
    pub position_error: f64,
    /// The angle between that pose's orientation and the wanted one, rad.
    pub orientation_error: f64,
    /// The limit in the way, if the pose could be reached without limits.
    pub limit: Option<ExcludingLimit>,
}

/// A limit that keeps a pose from being reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ExcludingLimit {
    /// The joint.
    pub joint: String,
    /// Where it would have to be, rad or m.
    pub position: f64,
    /// The limit it would pass, rad or m.
    pub limit: f64,
}

impl InverseFailure {
    fn new(robot: &Robot, miss: Miss) -> Self {
        let detail = miss.describe(robot.joint_names());
        let Miss { error: PoseError { position, orientation }, configuration, limit } = miss;
        let limit = limit.map(|limit| ExcludingLimit {
            joint: robot.joint_names()[limit.joint].clone(),
            position: limit.position,
            limit: limit.limit,
        });
        Self {
            code: "ik_no_solution".to_owned(),
            detail,
            joints: configuration,
            position_error: position,
            orientation_error: orientation,
            limit,
        }
    }
}

impl Service {
    /// The frames of robot `name` at a configuration.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::Invalid`] for a configuration that
    /// does not fit, [`ErrorCode::Conflict`] if the kinematics are unknown, or
    /// the store's.
    pub async fn forward_kinematics(
        &self,
        name: &str,
        request: &ForwardKinematicsRequest,
    ) -> Result<ForwardKinematics, ServiceError> {
        let robot = self.robot(name).await?;
        let kinematics = robot.kinematics().ok_or_else(|| unknown_kinematics(name))?;
        let mut faults = Faults::default();
        check_configuration(&robot, &request.joints, "/joints", &mut faults);
        faults.into_result(())?;
        let mut frames = LinkFrames::new(kinematics);
        kinematics.forward(&request.joints, &mut frames);
        let mut jacobian = Jacobian::new(robot.dof());
        kinematics.jacobian(&frames, &mut jacobian);
        let rows = jacobian.matrix().row_iter();
        Ok(ForwardKinematics {
            joint_names: robot.joint_names().to_vec(),
            tool: Pose::from(frames.tool()),
            links: frames.links().iter().map(Pose::from).collect(),
            jacobian: rows.map(|row| row.iter().copied().collect()).collect(),
        })
    }

    /// The configurations that bring the tool of robot `name` to a pose.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::Invalid`] for a request that does not fit, [`ErrorCode::Conflict`] if the
    /// kinematics are unknown, or the store's. That nothing reaches the pose is no error but an answer.
    pub async fn inverse_kinematics(
        &self,
        name: &str,
        request: InverseKinematicsRequest,
    ) -> Result<InverseKinematicsAnswer, ServiceError> {
        let robot = self.robot(name).await?;
        if robot.inverse().is_none() {
            return Err(unknown_kinematics(name));
        }
        request.check(&robot)?;
        // A search from hundreds of starts, or for a reason, takes milliseconds.
        blocking(move || match robot.inverse() {
            Some(inverse) => Ok(answer(&robot, inverse, &request)),
            None => Err(unknown_kinematics(robot.name())),
        })
        .await
    }
}

/// Solves a request that is valid for `robot`.
fn answer(
    robot: &Robot,
    inverse: &InverseKinematics,
    request: &InverseKinematicsRequest,
) -> InverseKinematicsAnswer {
    let target = Transform::from(&request.pose);
    let seed = request.seed.clone().unwrap_or_else(|| inverse.home());
    let PoseTolerance { position, orientation } = request.tolerance;
    let tolerance = PoseError { position, orientation };
    let mut found = Solutions::new(inverse);
    let all = request.solutions == SolutionChoice::All;
    if all {
        inverse.all(&target, &seed, &tolerance, &mut found);
    }
    // Also where all were asked for: it knows why there is none.
    let failure = if all && !found.is_empty() {
        None
    } else {
        inverse.nearest(&target, &seed, &tolerance, &mut found).err()
    };
    let distance = |joints: &[f64]| -> f64 {
        joints.iter().zip(&seed).map(|(joint, seed)| (joint - seed).powi(2)).sum()
    };
    let mut solutions: Vec<InverseSolution> =
        found.iter().map(|(joints, error)| InverseSolution::new(inverse, joints, error)).collect();
    solutions.sort_by(|a, b| distance(&a.joints).total_cmp(&distance(&b.joints)));
    InverseKinematicsAnswer {
        joint_names: robot.joint_names().to_vec(),
        method: inverse.kind().to_owned(),
        complete: all && inverse.is_complete(),
        solutions,
        failure: failure.map(|miss| InverseFailure::new(robot, *miss)),
    }
}

fn unknown_kinematics(name: &str) -> ServiceError {
    let message = format!("the kinematics of robot `{name}` are unknown");
    ServiceError::new(ErrorCode::Conflict, message)
}

fn check_configuration(robot: &Robot, joints: &[f64], pointer: &str, faults: &mut Faults) {
    if joints.len() != robot.dof() {
        let (found, dof) = (joints.len(), robot.dof());
        faults.add(pointer, format!("{found} values for a robot with {dof} joints"));
    }
    for (index, value) in joints.iter().enumerate().filter(|(_, value)| !value.is_finite()) {
        faults.add(format!("{pointer}/{index}"), format!("{value} is not finite"));
    }
}
