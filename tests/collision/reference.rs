//! The same robot and scene as parry3d's shapes, placed by the service's own forward kinematics.

use parry3d_f64::glamx::DQuat;
use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query::{self, details::closest_points_segment_segment_with_locations};
use parry3d_f64::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, Cylinder, Shape as ParryShape};
use takt::geometry::{Pose, Shape, Transform};
use takt::math::random::RandomStream;
use takt::robot::{LinkFrames, Robot};
use takt::scene::{Scene, SceneDescription};

pub struct Solid {
    shape: Box<dyn ParryShape>,
    local: ParryPose,
}

impl Solid {
    pub fn new(shape: &Shape, pose: &Pose) -> Self {
        let local = parry_pose(pose);
        // parry's cylinders stand along y.
        let upright = ParryPose::rotation(Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0));
        let (shape, local): (Box<dyn ParryShape>, _) = match shape {
            Shape::Sphere { radius } => (Box::new(Ball::new(*radius)), local),
            Shape::Capsule { radius, length } => {
                (Box::new(Capsule::new_z(0.5 * length, *radius)), local)
            }
            Shape::Cylinder { radius, length } => {
                (Box::new(Cylinder::new(0.5 * length, *radius)), local * upright)
            }
            Shape::Box { size: [x, y, z] } => {
                (Box::new(Cuboid::new(Vector::new(*x, *y, *z) * 0.5)), local)
            }
            Shape::ConvexHull { points } => {
                let points: Vec<_> = points.iter().map(|&[x, y, z]| Vector::new(x, y, z)).collect();
                (Box::new(ConvexPolyhedron::from_convex_hull(&points).unwrap()), local)
            }
        };
        Self { shape, local }
    }

    /// The point of the solid, in the world, that is nearest to `point`.
    pub fn nearest(&self, point: Vector) -> Vector {
        self.shape.project_point(&self.local, point, true).point
    }

    pub fn distance(&self, frame: &ParryPose, other: &Self, other_frame: &ParryPose) -> f64 {
        let (own, others) = (*frame * self.local, *other_frame * other.local);
        // The general search is off by up to 1e-5 for two capsules; their lines have a closed form.
        if let (Some(a), Some(b)) = (self.shape.as_capsule(), other.shape.as_capsule()) {
            let (from_a, from_b) = closest_points_segment_segment_with_locations(
                &own.inv_mul(&others),
                &a.segment,
                &b.segment,
            );
            let points = (own * a.segment.point_at(&from_a), others * b.segment.point_at(&from_b));
            return ((points.0 - points.1).length() - a.radius - b.radius).max(0.0);
        }
        query::distance(&own, &*self.shape, &others, &*other.shape).unwrap().distance
    }
}

pub fn parry_pose(pose: &Pose) -> ParryPose {
    let [x, y, z] = pose.position;
    let [i, j, k, w] = pose.orientation;
    ParryPose::from_parts(Vector::new(x, y, z), DQuat::from_xyzw(i, j, k, w).normalize())
}

/// A robot in a scene, every pair looked at.
pub struct World {
    robot: Robot,
    /// Link and solid of each body.
    bodies: Vec<(usize, Solid)>,
    obstacles: Vec<Solid>,
}

impl World {
    pub fn new(robot: &Robot, scene: &Scene) -> Self {
        let solid = |body: &takt::robot::Body| (body.link, Solid::new(&body.shape, &body.pose));
        Self {
            robot: robot.clone(),
            bodies: robot.bodies().iter().map(solid).collect(),
            obstacles: scene.obstacles().iter().map(|o| Solid::new(&o.shape, &o.pose)).collect(),
        }
    }

    /// The smallest distance of anything that must not touch, zero where something does.
    pub fn clearance(&self, state: &[f64]) -> f64 {
        let mut frames = LinkFrames::new(self.robot.kinematics().unwrap());
        self.robot.kinematics().unwrap().forward(state, &mut frames);
        let frame = |link: usize| match link {
            0 => parry_frame(frames.base()),
            _ => parry_frame(&frames.links()[link - 1]),
        };
        let placed: Vec<_> =
            self.bodies.iter().map(|(link, solid)| (*link, frame(*link), solid)).collect();
        let mut least = f64::INFINITY;
        for (index, (link, frame, solid)) in placed.iter().enumerate() {
            for obstacle in &self.obstacles {
                least = least.min(solid.distance(frame, obstacle, &ParryPose::identity()));
            }
            for (other_link, other_frame, other) in &placed[..index] {
                let pair = [*link.min(other_link), *link.max(other_link)];
                if self.robot.checked_pairs().contains(&pair) {
                    least = least.min(solid.distance(frame, other, other_frame));
                }
            }
        }
        least
    }
}

fn parry_frame(frame: &Transform) -> ParryPose {
    parry_pose(&Pose::from(frame))
}

pub const ROBOTS: [&str; 6] =
    ["ur5e", "franka_panda", "rokae_xb4", "kuka_kr6_r900_sixx", "abb_irb120", "aubo_i5"];

pub fn random_pose(random: &mut RandomStream, within: f64) -> Pose {
    let position = std::array::from_fn(|_| random.uniform(-within, within));
    let mut orientation: [f64; 4] = std::array::from_fn(|_| random.uniform(-1.0, 1.0));
    let norm = orientation.iter().map(|c| c * c).sum::<f64>().sqrt().max(1e-3);
    orientation.iter_mut().for_each(|component| *component /= norm);
    Pose { position, orientation }
}

pub fn random_shape(random: &mut RandomStream, kind: usize, size: f64) -> Shape {
    let mut extent = || random.uniform(0.1 * size, size);
    match kind % 5 {
        0 => Shape::Sphere { radius: 0.5 * extent() },
        1 => Shape::Capsule { radius: 0.3 * extent(), length: extent() },
        2 => Shape::Cylinder { radius: 0.5 * extent(), length: extent() },
        3 => Shape::Box { size: [extent(), extent(), extent()] },
        _ => Shape::ConvexHull {
            points: (0..12)
                .map(|_| std::array::from_fn(|_| random.uniform(-0.5 * size, 0.5 * size)))
                .collect(),
        },
    }
}

/// Ten obstacles of every kind, none of them in the robot's very middle.
pub fn random_scene(random: &mut RandomStream) -> Scene {
    let mut obstacles = Vec::new();
    while obstacles.len() < 10 {
        let kind = obstacles.len();
        let shape = random_shape(random, kind, 0.3);
        let pose = random_pose(random, 0.8);
        let [x, y, _] = pose.position;
        if x * x + y * y > 0.12 {
            let name = format!("obstacle {kind}");
            obstacles.push(serde_json::json!({"name": name, "shape": shape, "pose": pose}));
        }
    }
    let description: SceneDescription =
        serde_json::from_value(serde_json::json!({"name": "random", "obstacles": obstacles}))
            .unwrap();
    Scene::new(description).unwrap()
}

pub fn random_state(robot: &Robot, random: &mut RandomStream) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| &joint.limits);
    limits.map(|l| random.uniform(l.lower.unwrap_or(-3.1), l.upper.unwrap_or(3.1))).collect()
}
