//! Forward kinematics and the geometric Jacobian.

use nalgebra::{Matrix6xX, Vector3, Vector6};

use super::Joint;
use super::description::{KinematicsDescription, KinematicsForm};
use super::link::{ChainLink, Constant, Link};
use crate::geometry::{Pose, Transform};
use crate::math::lanes::WIDTH;
use crate::math::trigonometry::sin_cos;

/// The geometry of a robot, ready for evaluation.
///
/// Working memory belongs to the caller, so threads share one `Kinematics`.
/// Frames are in world coordinates; [`KinematicsDescription`] defines them.
#[derive(Clone, Debug)]
pub struct Kinematics {
    dof: usize,
    pub(super) links: Vec<Link>,
    world_from_base: Transform,
    pub(super) flange_from_tool: Constant,
}

/// The frames of one configuration, in world coordinates.
#[derive(Clone, Debug)]
pub struct LinkFrames {
    /// The base, then every link.
    base_and_links: Vec<Transform>,
    /// The line each link moves along or about.
    axes: Vec<Axis>,
    tool: Transform,
}

/// A line in world coordinates.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Unit vector.
    direction: Vector3<f64>,
    /// Any point of the line, m.
    point: Vector3<f64>,
}

impl LinkFrames {
    /// Room for the frames of `kinematics`.
    pub fn new(kinematics: &Kinematics) -> Self {
        let links = kinematics.links.len();
        let axis = Axis { direction: Vector3::zeros(), point: Vector3::zeros() };
        Self {
            base_and_links: vec![Transform::IDENTITY; links + 1],
            axes: vec![axis; links],
            tool: Transform::IDENTITY,
        }
    }

    /// The base.
    pub fn base(&self) -> &Transform {
        &self.base_and_links[0]
    }

    /// The frame of each link, in the order of [`Kinematics::chain`].
    pub fn links(&self) -> &[Transform] {
        &self.base_and_links[1..]
    }

    /// The tool.
    pub fn tool(&self) -> &Transform {
        &self.tool
    }

    /// The line each link moves along or about: a unit vector and a point, m.
    pub(super) fn axes(&self) -> impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + '_ {
        self.axes.iter().map(|axis| (axis.direction, axis.point))
    }
}

/// The geometric Jacobian of the tool: how its velocity follows from the
/// joints' velocities.
///
/// One column per joint. Rows 0 to 2 are the velocity of the tool's origin (m/s
/// per rad/s or m/s), rows 3 to 5 the angular velocity (rad/s), all in world
/// coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Jacobian(Matrix6xX<f64>);

impl Jacobian {
    /// Room for a robot with `dof` joints.
    pub fn new(dof: usize) -> Self {
        Self(Matrix6xX::zeros(dof))
    }

    /// The matrix, 6 rows and one column per joint.
    pub fn matrix(&self) -> &Matrix6xX<f64> {
        &self.0
    }
}

impl Kinematics {
    /// Precomputes what no configuration changes; `description` is valid for
    /// `joints` and has no URDF left to read.
    pub(super) fn new(description: &KinematicsDescription, joints: &[Joint]) -> Self {
        let links = match &description.form {
            KinematicsForm::Rows { convention, rows } => {
                let rows = rows.iter().zip(joints).enumerate();
                rows.map(|(index, (row, joint))| {
                    Link::from_row(*convention, row, index, joint.joint_type)
                })
                .collect()
            }
            KinematicsForm::Links(links) => {
                links.iter().filter_map(|link| Link::from_description(link, joints)).collect()
            }
            // Robots are built from what the URDF was turned into.
            KinematicsForm::Urdf(_) => Vec::new(),
        };
        Self {
            dof: joints.len(),
            links,
            world_from_base: Transform::from(&description.base),
            flange_from_tool: Transform::from(&description.tool).into(),
        }
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// The links from the base to the tool, one per joint and one more for each place where a joint
    /// moves along with another.
    pub fn chain(&self) -> impl ExactSizeIterator<Item = ChainLink> + '_ {
        self.links.iter().map(ChainLink::from)
    }

    /// The base in the world: the chain starts here.
    pub fn base(&self) -> &Transform {
        &self.world_from_base
    }

    /// The tool in the frame of the last link.
    pub fn tool(&self) -> Transform {
        self.flange_from_tool.transform()
    }

    /// Computes every frame at `configuration` (rad or m per joint), which may
    /// lie outside the joint limits.
    ///
    /// # Panics
    ///
    /// If `configuration` has another number of joints, or `frames` is another robot's.
    pub fn forward(&self, configuration: &[f64], frames: &mut LinkFrames) {
        let LinkFrames { base_and_links, axes, tool } = frames;
        assert_eq!(axes.len(), self.links.len(), "one frame per link");
        base_and_links[0] = self.world_from_base;
        let mut out = base_and_links[1..].iter_mut().zip(axes);
        *tool = self.walk(configuration, |axis, frame| {
            if let Some((frame_out, axis_out)) = out.next() {
                (*frame_out, *axis_out) = (*frame, axis);
            }
        });
    }

    /// Where the tool is in the world at `configuration` (rad or m per joint).
    ///
    /// # Panics
    ///
    /// If `configuration` has another number of joints.
    pub fn tool_transform(&self, configuration: &[f64]) -> Transform {
        self.walk(configuration, |_, _| {})
    }

    /// [`tool_transform`](Self::tool_transform) as a pose.
    ///
    /// # Panics
    ///
    /// If `configuration` has another number of joints.
    pub fn tool_pose(&self, configuration: &[f64]) -> Pose {
        Pose::from(&self.tool_transform(configuration))
    }

    /// Goes from the base to the tool, whose frame it returns, and shows `see` the axis and the frame of
    /// each link.
    #[inline(always)]
    fn walk(&self, configuration: &[f64], mut see: impl FnMut(Axis, &Transform)) -> Transform {
        assert_eq!(configuration.len(), self.dof(), "one position per joint");
        let mut frame = self.world_from_base;
        for links in self.links.chunks(WIDTH) {
            let mut angles = [0.0; WIDTH];
            for (angle, link) in angles.iter_mut().zip(links) {
                *angle = link.angle(configuration);
            }
            let (sines, cosines) = sin_cos(&angles);
            for (link, turn) in links.iter().zip(sines.into_iter().zip(cosines)) {
                link.enter(&mut frame);
                link.screw(turn, configuration, &mut frame);
                let axis = Axis { direction: frame.z, point: frame.origin };
                link.leave(&mut frame);
                see(axis, &frame);
            }
        }
        self.flange_from_tool.apply(&mut frame);
        frame
    }

    /// Computes the Jacobian of the tool from the `frames` that
    /// [`forward`](Self::forward) left.
    ///
    /// # Panics
    ///
    /// If `frames` is another robot's or `jacobian` has another number of joints.
    pub fn jacobian(&self, frames: &LinkFrames, jacobian: &mut Jacobian) {
        assert_eq!(frames.axes.len(), self.links.len(), "one axis per link");
        assert_eq!(jacobian.0.ncols(), self.dof(), "one column per joint");
        let tool = frames.tool.origin;
        jacobian.0.fill(0.0);
        for (link, axis) in self.links.iter().zip(&frames.axes) {
            let direction = axis.direction * link.ratio;
            let (linear, angular) = if link.slides {
                (direction, Vector3::zeros())
            } else {
                (direction.cross(&(tool - axis.point)), direction)
            };
            let mut column = jacobian.0.column_mut(link.joint);
            column += Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use nalgebra::Matrix3;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use serde_json::json;

    use super::*;
    use crate::robot::{Robot, catalogue};

    fn robot(value: serde_json::Value) -> Robot {
        Robot::new(serde_json::from_value(value).unwrap()).unwrap()
    }

    /// An arm of revolute joints without limits.
    fn arm(dof: usize, kinematics: serde_json::Value) -> Robot {
        let joint = |index| json!({"name": format!("j{index}"), "type": "revolute"});
        let joints: Vec<_> = (0..dof).map(joint).collect();
        robot(json!({"joints": joints, "kinematics": kinematics}))
    }

    fn random_configuration(robot: &Robot, random: &mut Xoshiro256PlusPlus) -> Vec<f64> {
        let mut between = |lower: f64, upper: f64| {
            let unit = (random.next_u64() >> 11) as f64 * (-53_f64).exp2();
            lower + unit * (upper - lower)
        };
        let limits = robot.joints().iter().map(|joint| &joint.limits);
        limits.map(|l| between(l.lower.unwrap_or(-3.0), l.upper.unwrap_or(3.0))).collect()
    }

    fn frames(robot: &Robot, configuration: &[f64]) -> LinkFrames {
        let mut frames = LinkFrames::new(robot.kinematics().unwrap());
        robot.kinematics().unwrap().forward(configuration, &mut frames);
        frames
    }

    fn tool(robot: &Robot, configuration: &[f64]) -> Transform {
        *frames(robot, configuration).tool()
    }

    fn tool_position(robot: &Robot, configuration: &[f64]) -> [f64; 3] {
        robot.kinematics().unwrap().tool_pose(configuration).position
    }

    #[track_caller]
    fn assert_near(actual: [f64; 3], expected: [f64; 3]) {
        for (a, e) in actual.iter().zip(expected) {
            assert!((a - e).abs() < 1e-12, "{actual:?} is not {expected:?}");
        }
    }

    #[track_caller]
    fn assert_same(actual: &Transform, expected: &Transform) {
        let error = (actual.rotation() - expected.rotation()).norm()
            + (actual.origin - expected.origin).norm();
        assert!(error < 1e-12, "{actual:?} is not {expected:?}");
    }

    /// The Jacobian's column `joint` by central differences.
    fn difference_column(robot: &Robot, configuration: &[f64], joint: usize) -> Vector6<f64> {
        let step = 1e-5;
        let moved = |by: f64| {
            let mut configuration = configuration.to_vec();
            configuration[joint] += by;
            tool(robot, &configuration)
        };
        let (before, after) = (moved(-step), moved(step));
        let linear = (after.origin - before.origin) / (2.0 * step);
        // For a small turn R(+) R(-)^T is 1 plus the cross-product matrix of
        // the turn, up to third order in its skew part.
        let turn: Matrix3<f64> = after.rotation() * before.rotation().transpose();
        let angular = Vector3::new(
            turn[(2, 1)] - turn[(1, 2)],
            turn[(0, 2)] - turn[(2, 0)],
            turn[(1, 0)] - turn[(0, 1)],
        ) / (4.0 * step);
        Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    }

    fn assert_jacobian_is_the_derivative(robot: &Robot, random: &mut Xoshiro256PlusPlus) {
        let mut jacobian = Jacobian::new(robot.dof());
        for _ in 0..20 {
            let configuration = random_configuration(robot, random);
            let frames = frames(robot, &configuration);
            robot.kinematics().unwrap().jacobian(&frames, &mut jacobian);
            for joint in 0..robot.dof() {
                let expected = difference_column(robot, &configuration, joint);
                let error = (jacobian.matrix().column(joint) - expected).norm();
                assert!(error < 1e-6, "{} joint {joint}: off by {error}", robot.name());
            }
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative_for_every_robot() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        for robot in catalogue::all() {
            assert_jacobian_is_the_derivative(robot, &mut random);
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative_with_standard_rows_and_poses() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
        let joints: Vec<_> = ["revolute", "prismatic", "continuous", "prismatic"]
            .iter()
            .map(|kind| json!({"name": format!("{kind}{}", random.next_u64()), "type": kind}))
            .collect();
        for convention in ["standard_dh", "modified_dh"] {
            let robot = robot(json!({"joints": joints, "kinematics": {
                "convention": convention,
                "rows": [
                    {"a": 0.3, "alpha": 0.4, "d": 0.2, "theta": 0.1},
                    {"a": -0.1, "alpha": -1.1, "d": 0.5, "theta": 0.7, "sign": -1},
                    {"a": 0.2, "alpha": 1.3, "d": -0.2, "theta": -0.4, "sign": -1},
                    {"a": 0.1, "alpha": 0.2, "d": 0.1, "theta": 2.0},
                ],
                "base": {"position": [1, 2, 3], "orientation": [0.5, 0.5, 0.5, 0.5]},
                "tool": {"position": [0.1, 0.2, 0.3], "orientation": [0, 0.6, 0, 0.8]},
            }}));
            assert_jacobian_is_the_derivative(&robot, &mut random);
        }
    }

    #[test]
    fn frames_stay_orthonormal_and_the_tool_pose_agrees() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        for robot in catalogue::all() {
            let configuration = random_configuration(robot, &mut random);
            let frames = frames(robot, &configuration);
            assert_eq!(frames.links().len(), robot.dof());
            for frame in frames.links() {
                let rotation = frame.rotation();
                let defect = rotation * rotation.transpose() - Matrix3::identity();
                assert!(defect.norm() < 1e-14 && rotation.determinant() > 0.0);
            }
            let pose = robot.kinematics().unwrap().tool_pose(&configuration);
            assert_same(&Transform::from(&pose), frames.tool());
        }
    }

    /// Chen et al. 2023, equation 2 with y = z = 0.
    #[test]
    fn the_woodworking_machine_follows_the_papers_closed_form() {
        let machine = catalogue::get("woodworking_pprr").unwrap();
        let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
        for _ in 0..50 {
            let configuration = random_configuration(&machine, &mut random);
            let [d1, d2, t3, t4] = configuration[..] else { panic!("four joints") };
            let ((s3, c3), (s4, c4)) = (t3.sin_cos(), t4.sin_cos());
            let expected = Transform {
                x: Vector3::new(-s3 * c4, s4, -c3 * c4),
                y: Vector3::new(s3 * s4, c4, c3 * s4),
                z: Vector3::new(c3, 0.0, -s3),
                origin: Vector3::new(d2 + 0.2865 * c3, 0.672, d1 - 0.2865 * s3),
            };
            assert_same(&tool(&machine, &configuration), &expected);
        }
    }

    /// Sums of link lengths along the axes that the drawings show.
    #[test]
    fn the_arms_stand_where_their_drawings_put_them() {
        let at = |name: &str, configuration: &[f64]| {
            tool_position(&catalogue::get(name).unwrap(), configuration)
        };
        // Universal Robots: stretched along -x, the wrist turned down and to -y.
        let zero = [0.0; 6];
        assert_near(at("ur5e", &zero), [-0.425 - 0.3922, -0.1333 - 0.0996, 0.1625 - 0.0997]);
        assert_near(at("ur10e", &zero), [-1.18425, -0.2907, 0.06085]);
        let up = [0.0, -FRAC_PI_2, 0.0, -FRAC_PI_2, 0.0, 0.0];
        assert_near(at("ur5e", &up), [0.0, -0.2329, 0.1625 + 0.425 + 0.3922 + 0.0997]);
        // Panda: upright, the hand forward by 0.088 and hanging down by 0.107.
        assert_near(at("franka_panda", &[0.0; 7]), [0.088, 0.0, 0.333 + 0.316 + 0.384 - 0.107]);
        // Staubli: upright, with the shoulder's offset to the side.
        assert_near(at("staubli_tx2_60", &zero), [0.0, 0.02, 0.375 + 0.29 + 0.31 + 0.07]);
        // KUKA at zero: stretched forward, the elbow's offset upwards.
        assert_near(at("kuka_kr6_r900_sixx", &zero), [0.025 + 0.455 + 0.5, 0.0, 0.4 + 0.035]);
        // SCARA: forward, then left about the elbow, and 0.1 down.
        assert_near(at("epson_t3_401s", &[0.0, FRAC_PI_2, -0.1, 0.0]), [0.225, 0.175, -0.1]);
    }

    /// Han et al. 2022, Table 2, pick circuit breakers from above.
    #[test]
    fn the_tool_points_straight_down_at_hans_waypoints() {
        let waypoints_deg = [
            [0.0, -35.1, -29.8, 0.0, -25.1, 0.0],
            [-24.0, -37.7, -30.6, 0.0, -21.7, 23.96],
            [-43.7, -52.2, -4.14, 0.0, -33.6, 135.3],
            [-30.0, -58.3, -2.11, 0.0, -29.6, 125.0],
        ];
        let signs = [1.0, -1.0, -1.0, 1.0, -1.0, 1.0];
        let robot = catalogue::get("rokae_xb4").unwrap();
        for waypoint in waypoints_deg {
            let configuration: Vec<f64> = waypoint
                .iter()
                .zip(signs)
                .map(|(deg, sign)| sign * f64::to_radians(*deg))
                .collect();
            let z = tool(&robot, &configuration).z;
            assert!((z + Vector3::z()).norm() < 2e-3, "{z} at {waypoint:?}");
            let counted_hans_way: Vec<f64> = waypoint.map(f64::to_radians).to_vec();
            assert!(tool(&robot, &counted_hans_way).z.z > -0.9);
        }
    }

    #[test]
    fn both_conventions_describe_the_same_planar_arm() {
        // Craig's lengths stand one row later, so the last one is the tool.
        let standard =
            arm(2, json!({"convention": "standard_dh", "rows": [{"a": 0.4}, {"a": 0.3}]}));
        let modified = arm(
            2,
            json!({"convention": "modified_dh", "rows": [{}, {"a": 0.4}],
                "tool": {"position": [0.3, 0, 0]}}),
        );
        for [first, second] in [[0.0, 0.0], [0.3, -0.8], [-2.0, 1.5]] {
            let configuration = [first, second];
            let (left, right) = (tool(&standard, &configuration), tool(&modified, &configuration));
            assert_same(&left, &right);
            let both = first + second;
            let x = 0.4 * first.cos() + 0.3 * both.cos();
            let y = 0.4 * first.sin() + 0.3 * both.sin();
            assert_near(left.origin.into(), [x, y, 0.0]);
        }
    }

    /// The maker publishes the UR5e in standard rows, the catalogue has modified ones.
    #[test]
    fn both_conventions_describe_the_same_arm_in_space() {
        let modified = catalogue::get("ur5e").unwrap();
        let standard = arm(
            6,
            json!({"convention": "standard_dh", "rows": [
                {"d": 0.1625, "alpha": FRAC_PI_2}, {"a": -0.425}, {"a": -0.3922},
                {"d": 0.1333, "alpha": FRAC_PI_2}, {"d": 0.0997, "alpha": -FRAC_PI_2},
                {"d": 0.0996},
            ]}),
        );
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        let (mut left, mut right) = (Jacobian::new(6), Jacobian::new(6));
        for _ in 0..20 {
            let configuration = random_configuration(&modified, &mut random);
            let (first, second) =
                (frames(&modified, &configuration), frames(&standard, &configuration));
            assert_same(first.tool(), second.tool());
            modified.kinematics().unwrap().jacobian(&first, &mut left);
            standard.kinematics().unwrap().jacobian(&second, &mut right);
            assert!((left.matrix() - right.matrix()).norm() < 1e-12);
        }
    }

    #[test]
    fn base_and_tool_poses_compose() {
        let quarter = json!([0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]);
        let robot = arm(
            1,
            json!({"convention": "modified_dh", "rows": [{"a": 0.5, "d": 0.2}],
                "base": {"position": [1, 0, 0], "orientation": quarter},
                "tool": {"position": [0.1, 0, 0.05]}}),
        );
        let frames = frames(&robot, &[FRAC_PI_2]);
        assert_near(frames.base().origin.into(), [1.0, 0.0, 0.0]);
        // The base turns the link from x to y, the joint turns the tool on to -x.
        assert_near(frames.links()[0].origin.into(), [1.0, 0.5, 0.2]);
        assert_near(frames.tool().origin.into(), [0.9, 0.5, 0.25]);
        assert!((frames.tool().x + Vector3::x()).norm() < 1e-15);
    }

    #[test]
    fn a_nearly_normal_quaternion_is_normalised() {
        let robot = arm(
            1,
            json!({"convention": "modified_dh", "rows": [{}],
                "base": {"orientation": [0, 0, 0.70710713, 0.70710713]}}),
        );
        assert!((frames(&robot, &[0.0]).base().x.norm() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_negative_sign_turns_and_slides_the_other_way() {
        let robot = robot(json!({
            "joints": [{"name": "slide", "type": "prismatic"}, {"name": "turn", "type": "revolute"}],
            "kinematics": {"convention": "modified_dh",
                "rows": [{"d": 1, "sign": -1}, {"theta": FRAC_PI_2, "sign": -1}],
                "tool": {"position": [1, 0, 0]}},
        }));
        assert_near(tool_position(&robot, &[0.25, 0.0]), [0.0, 1.0, 0.75]);
        assert_near(tool_position(&robot, &[0.0, FRAC_PI_2]), [1.0, 0.0, 1.0]);
    }
}
