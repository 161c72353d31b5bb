//! The robot as a chain of screws: what all of collision checking knows about kinematics.

use nalgebra::Vector3;

use crate::geometry::Transform;
use crate::robot::{ChainLink, Robot};

/// A constant transform, then a screw along its z axis.
#[derive(Clone, Debug)]
pub(super) struct Screw {
    /// From the frame before to the joint's own at position zero.
    pub(super) constant: Transform,
    /// True if the joint turns, false if it slides.
    pub(super) turns: bool,
    /// Which position moves the joint.
    pub(super) joint: usize,
    /// What multiplies the position; its sign is the joint's.
    pub(super) ratio: f64,
    /// What is added to it, rad or m.
    pub(super) offset: f64,
    /// Largest magnitude of the position where the joint slides, m.
    pub(super) travel: f64,
}

impl Screw {
    /// How far the screw is turned or drawn out where its joint stands at `position`.
    pub(super) fn position(&self, position: f64) -> f64 {
        self.ratio * position + self.offset
    }
}

/// Where a link of the robot is: in the frame after `screws` screws.
#[derive(Clone, Debug)]
pub(super) struct LinkPlace {
    pub(super) screws: usize,
    pub(super) frame_from_link: Transform,
}

/// The screws of a robot and where its links are.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub(super) dof: usize,
    pub(super) world_from_base: Transform,
    pub(super) screws: Vec<Screw>,
    /// The base, the frame after each joint, and the tool.
    pub(super) links: Vec<LinkPlace>,
}

/// Sliding joints without limits are taken to stay within this, m.
const UNLIMITED_TRAVEL_M: f64 = 1000.0;

impl Chain {
    /// The chain of `robot`, if its kinematics are known.
    pub(super) fn new(robot: &Robot) -> Option<Self> {
        let kinematics = robot.kinematics()?;
        let mut links = vec![LinkPlace { screws: 0, frame_from_link: Transform::IDENTITY }];
        let mut screws = Vec::new();
        // What stands between the last screw and the frame after its joint.
        let mut rest = Transform::IDENTITY;
        for (index, link) in kinematics.chain().enumerate() {
            let limits = &robot.joints()[link.joint].limits;
            let most = [limits.lower, limits.upper]
                .map(|limit| limit.map_or(UNLIMITED_TRAVEL_M, f64::abs));
            screws.push(Screw {
                constant: exact(rest * link.before * along_z(&link)),
                turns: !link.slides,
                joint: link.joint,
                ratio: link.ratio,
                offset: if link.slides { 0.0 } else { link.theta },
                travel: link.ratio.abs() * most[0].max(most[1]),
            });
            rest = exact(link.after);
            links.push(LinkPlace { screws: index + 1, frame_from_link: rest });
        }
        let tool = rest * kinematics.tool();
        links.push(LinkPlace { screws: screws.len(), frame_from_link: tool });
        Some(Self { dof: robot.dof(), world_from_base: *kinematics.base(), screws, links })
    }

    /// The frame before the first and after each screw, in the world, at `configuration` (rad or m per joint).
    pub(super) fn forward(&self, configuration: &[f64], frames: &mut Vec<Transform>) {
        frames.clear();
        let mut frame = self.world_from_base;
        frames.push(frame);
        for screw in &self.screws {
            let position = screw.position(configuration[screw.joint]);
            frame = frame * screw.constant;
            if screw.turns {
                let (sin, cos) = (libm::sin(position), libm::cos(position));
                let (x, y) = (frame.x, frame.y);
                frame.x = x * cos + y * sin;
                frame.y = y * cos - x * sin;
            } else {
                frame.origin += frame.z * position;
            }
            frames.push(frame);
        }
    }

    /// How far the origin after `screws` screws is at most from the origin after each of them, m.
    pub(super) fn levers(&self, screws: usize) -> Vec<f64> {
        let mut levers = vec![0.0; screws];
        let mut distance = 0.0;
        for (lever, screw) in levers.iter_mut().zip(&self.screws).rev() {
            *lever = distance;
            distance += screw.constant.origin.norm();
            if !screw.turns {
                distance += screw.travel;
            }
        }
        levers
    }

    /// A ball in the world that a point within `radius` of the origin after `screws` screws never leaves.
    pub(super) fn room(&self, screws: usize, radius: f64) -> (Vector3<f64>, f64) {
        let mut center = self.world_from_base;
        let Some(first) = self.screws[..screws].first() else { return (center.origin, radius) };
        // The first joint's frame turns on the spot, so the ball is around that.
        center = center * first.constant;
        let lengths = self.screws[1..screws].iter().map(|screw| {
            screw.constant.origin.norm() + if screw.turns { 0.0 } else { screw.travel }
        });
        let travel = if first.turns { 0.0 } else { first.travel };
        (center.origin, radius + travel + lengths.sum::<f64>())
    }
}

/// What of a link's own screw stands still: the shift along z, and where it slides the turn about z.
fn along_z(link: &ChainLink) -> Transform {
    let theta = if link.slides { link.theta } else { 0.0 };
    let (sin, cos) = libm::sincos(theta);
    Transform {
        x: Vector3::new(cos, sin, 0.0),
        y: Vector3::new(-sin, cos, 0.0),
        z: Vector3::z(),
        origin: Vector3::new(0.0, 0.0, link.d),
    }
}

/// Right angles are meant exactly: the cosine of pi/2 as a number is 6e-17.
fn exact(transform: Transform) -> Transform {
    let right =
        |axis: Vector3<f64>| axis.map(|value| if value.abs() < 1e-15 { 0.0 } else { value });
    let Transform { x, y, z, origin } = transform;
    Transform { x: right(x), y: right(y), z: right(z), origin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::travel::{Arms, Rate};
    use crate::math::random::RandomStream;
    use crate::robot::{LinkFrames, catalogue};

    #[test]
    fn the_chain_stands_where_the_kinematics_do() {
        let standard = serde_json::json!({"joints": [
            {"name": "a", "type": "revolute"}, {"name": "b", "type": "prismatic"}, {"name": "c", "type": "revolute"}],
            "kinematics": {"convention": "standard_dh", "rows": [
                {"a": 0.3, "alpha": 0.4, "d": 0.2, "theta": 0.1},
                {"a": -0.1, "alpha": -1.1, "d": 0.5, "theta": 0.7, "sign": -1},
                {"a": 0.2, "alpha": 1.3, "d": -0.2, "theta": -0.4, "sign": -1}],
                "base": {"position": [1, 2, 3], "orientation": [0.5, 0.5, 0.5, 0.5]},
                "tool": {"position": [0.1, 0.2, 0.3], "orientation": [0, 0.6, 0, 0.8]}}});
        let standard = Robot::new(serde_json::from_value(standard).unwrap()).unwrap();
        let mut random = RandomStream::new(1, 0);
        for robot in crate::robot::catalogue::all().iter().map(AsRef::as_ref).chain([&standard]) {
            let chain = Chain::new(robot).unwrap();
            let mut expected = LinkFrames::new(robot.kinematics().unwrap());
            let mut frames = Vec::new();
            for _ in 0..5 {
                let configuration: Vec<_> =
                    (0..robot.dof()).map(|_| random.uniform(-3.0, 3.0)).collect();
                robot.kinematics().unwrap().forward(&configuration, &mut expected);
                chain.forward(&configuration, &mut frames);
                let all = [&[*expected.base()], expected.links(), &[*expected.tool()]].concat();
                assert_eq!(all.len(), chain.links.len());
                for (place, expected) in chain.links.iter().zip(all) {
                    let found = frames[place.screws] * place.frame_from_link;
                    let off = (found.rotation() - expected.rotation()).norm()
                        + (found.origin - expected.origin).norm();
                    assert!(off < 1e-12, "{}: {off}", robot.name());
                }
            }
        }
    }

    /// What continuous checks rest on.
    #[test]
    fn no_point_moves_further_than_its_rate() {
        let robot = catalogue::get("ur5e").unwrap();
        let chain = Chain::new(&robot).unwrap();
        let mut random = RandomStream::new(2, 0);
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for _ in 0..2000 {
            let screws = 1 + (random.unit() * 6.0) as usize;
            let point = Vector3::from_fn(|_, _| random.uniform(-0.2, 0.2));
            let from: Vec<_> = (0..6).map(|_| random.uniform(-3.0, 3.0)).collect();
            let to: Vec<_> = from.iter().map(|q| q + random.uniform(-0.3, 0.3)).collect();
            chain.forward(&from, &mut before);
            chain.forward(&to, &mut after);
            let moved = (before[screws].point(&point) - after[screws].point(&point)).norm();
            let delta: Vec<_> = from.iter().zip(&to).map(|(from, to)| to - from).collect();
            let arms = Arms { whole: point.norm(), about_axis: point.xy().norm() };
            let bound = Rate::new(&chain, 0..screws, &chain.levers(screws), &delta).of(&arms);
            assert!(moved <= bound, "{moved} {bound}");
            let (center, radius) = chain.room(screws, point.norm());
            assert!((before[screws].point(&point) - center).norm() <= radius + 1e-12);
        }
    }
}
