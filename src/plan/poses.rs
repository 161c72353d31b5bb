//! Waypoints that are poses of the tool: which configurations they are passed with.
//!
//! Every pose has several. Of all ways through the list, the one of the least joint travel is taken: the sum of
//! the distances between neighbouring configurations, starting from where the robot is before. A dynamic
//! programme over the configurations of each waypoint finds it exactly.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::prepare::Check;
use crate::fault::Faults;
use crate::geometry::check_pose;
use crate::geometry::{Pose, Transform};
use crate::robot::inverse::{InverseKinematics, PoseError, Solutions};

/// Most poses of one task: each is solved before the task is accepted.
const MAX_POSES: usize = 500;

/// Most configurations of one waypoint that are weighed: those nearest to where the robot is before.
const MOST: usize = 64;

/// Whole turns of one joint that are weighed: those nearest to where the robot is before.
const TURNS: usize = 3;

/// A waypoint: one position per joint (rad or m), or a pose of the tool.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum Waypoint {
    /// One position per joint, rad or m.
    Joints(Vec<f64>),
    /// Where the tool has to be.
    Pose(PoseWaypoint),
}

/// A waypoint that says where the tool has to be; needs a robot with kinematics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseWaypoint {
    /// The tool in the world.
    pub pose: Pose,
    /// One position per joint, rad or m: the configuration nearest to it is taken. Default: all of them are weighed, and
    /// those with the least joint travel through all waypoints are taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<Vec<f64>>,
}

impl<'de> Deserialize<'de> for Waypoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;

        impl<'de> Visitor<'de> for Either {
            type Value = Waypoint;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a list with a position per joint, or an object with a pose")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Waypoint, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(list)).map(Waypoint::Joints)
            }

            fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<Waypoint, A::Error> {
                let pose = PoseWaypoint::deserialize(MapAccessDeserializer::new(members));
                pose.map(Waypoint::Pose)
            }
        }

        deserializer.deserialize_any(Either)
    }
}

impl Check<'_> {
    /// The configurations of `waypoints`, which stand at `pointer`; `from` is where the robot is before, by default its
    /// home position. None if a fault keeps one from being known.
    pub(super) fn resolve(
        &self,
        waypoints: &[Waypoint],
        from: Option<&[f64]>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<Vec<Vec<f64>>> {
        let joints = |waypoint: &Waypoint| match waypoint {
            Waypoint::Joints(joints) => Some(joints.clone()),
            Waypoint::Pose(_) => None,
        };
        if let Some(all) = waypoints.iter().map(joints).collect() {
            return Some(all);
        }
        let Some(inverse) = self.robot.inverse() else {
            let detail = format!("poses need kinematics, which {} has not", self.robot.name());
            faults.add(pointer, detail);
            return None;
        };
        let poses = waypoints.iter().filter(|it| matches!(it, Waypoint::Pose(_))).count();
        if poses > MAX_POSES {
            faults.add(pointer, format!("{poses} poses; at most {MAX_POSES} are taken"));
            return None;
        }
        let home = inverse.home();
        let given =
            waypoints.iter().filter_map(joints).find(|joints| self.is_configuration(joints));
        let from = from.map(<[f64]>::to_vec).or(given).unwrap_or(home);
        let before = faults.0.len();
        let mut found = Solutions::new(inverse);
        let mut candidates = Vec::with_capacity(waypoints.len());
        for (index, waypoint) in waypoints.iter().enumerate() {
            let place = format!("{pointer}/{index}");
            candidates.push(match waypoint {
                Waypoint::Joints(joints) => {
                    if !self.is_configuration(joints) {
                        let detail =
                            "no configuration of this robot, so poses beside it are not looked at";
                        faults.add(place, detail);
                    }
                    vec![joints.clone()]
                }
                Waypoint::Pose(pose) => {
                    self.configurations_of(inverse, pose, &from, &place, &mut found, faults)
                }
            });
        }
        (faults.0.len() == before).then(|| least_travel(&from, candidates))
    }

    fn is_configuration(&self, joints: &[f64]) -> bool {
        joints.len() == self.robot.dof() && joints.iter().all(|position| position.is_finite())
    }

    /// The configurations for a pose within the limits, the nearest to `from` first.
    fn configurations_of(
        &self,
        inverse: &InverseKinematics,
        waypoint: &PoseWaypoint,
        from: &[f64],
        place: &str,
        found: &mut Solutions,
        faults: &mut Faults,
    ) -> Vec<Vec<f64>> {
        let before = faults.0.len();
        check_pose(&waypoint.pose, &format!("{place}/pose"), "the tool", faults);
        if let Some(seed) = waypoint.seed.as_ref().filter(|seed| !self.is_configuration(seed)) {
            let (count, dof) = (seed.len(), self.robot.dof());
            let detail =
                format!("{count} values; a seed has a finite number for each of {dof} joints");
            faults.add(format!("{place}/seed"), detail);
        }
        if faults.0.len() > before {
            return Vec::new();
        }
        let target = Transform::from(&waypoint.pose);
        let near = waypoint.seed.as_deref().unwrap_or(from);
        if waypoint.seed.is_none() {
            inverse.all(&target, near, &PoseError::TOLERANCE, found);
        }
        if (waypoint.seed.is_some() || found.is_empty())
            && let Err(miss) = inverse.nearest(&target, near, &PoseError::TOLERANCE, found)
        {
            let detail = format!("ik_no_solution: {}", miss.describe(self.robot.joint_names()));
            faults.add(format!("{place}/pose"), detail);
            return Vec::new();
        }
        let mut configurations: Vec<Vec<f64>> = if waypoint.seed.is_some() {
            found.iter().map(|(joints, _)| joints.to_vec()).collect()
        } else {
            found.iter().flat_map(|(joints, _)| with_turns(inverse, joints, near)).collect()
        };
        // A request may narrow the robot's limits.
        configurations.retain(|joints| {
            joints.iter().zip(self.limits).all(|(position, limit)| {
                limit.lower.as_ref().is_none_or(|lower| *position >= lower.value)
                    && limit.upper.as_ref().is_none_or(|upper| *position <= upper.value)
            })
        });
        if configurations.is_empty() {
            let detail =
                "ik_no_solution: every configuration is outside the limits of this request";
            faults.add(format!("{place}/pose"), detail);
        }
        configurations.sort_by(|a, b| distance(a, near).total_cmp(&distance(b, near)));
        configurations.truncate(MOST);
        configurations
    }
}

/// `joints` and the configurations that differ from it by whole turns, as near to `from` as can be.
fn with_turns(inverse: &InverseKinematics, joints: &[f64], from: &[f64]) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::with_capacity(joints.len())];
    for (joint, (position, from)) in joints.iter().zip(from).enumerate() {
        let mut same: Vec<f64> = inverse.same_positions(joint, *position).collect();
        same.sort_by(|a, b| (a - from).abs().total_cmp(&(b - from).abs()));
        same.truncate(TURNS);
        let longer = |start: &Vec<f64>| {
            let start = start.clone();
            same.iter().map(move |position| [&start[..], &[*position]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// The Euclidean distance of two configurations.
fn distance(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(left, right)| (left - right).powi(2)).sum::<f64>().sqrt()
}

/// One configuration per waypoint, so that the way from `from` through all of them is shortest; every waypoint has
/// at least one to choose from.
fn least_travel(from: &[f64], candidates: Vec<Vec<Vec<f64>>>) -> Vec<Vec<f64>> {
    // Per candidate of the waypoint looked at the shortest way there, and per waypoint the choice before it.
    let mut ways: Vec<f64> = Vec::new();
    let mut choices: Vec<Vec<usize>> = Vec::with_capacity(candidates.len());
    for (index, waypoint) in candidates.iter().enumerate() {
        let reach = |candidate: &Vec<f64>| {
            let Some(before) = index.checked_sub(1).map(|before| &candidates[before]) else {
                return (distance(from, candidate), 0);
            };
            let ways = before.iter().zip(&ways).enumerate();
            let ways =
                ways.map(|(choice, (start, way))| (way + distance(start, candidate), choice));
            ways.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
        };
        let (next, choice) = waypoint.iter().map(reach).unzip();
        ways = next;
        choices.push(choice);
    }
    let shortest = (0..ways.len()).min_by(|a, b| ways[*a].total_cmp(&ways[*b]));
    let mut choice = shortest.unwrap_or_default();
    let mut chosen: Vec<Vec<f64>> = Vec::with_capacity(candidates.len());
    for (mut waypoint, choices) in candidates.into_iter().zip(choices).rev() {
        chosen.push(waypoint.swap_remove(choice));
        choice = choices[choice];
    }
    chosen.reverse();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every way through every list is tried.
    #[test]
    fn no_way_through_the_candidates_is_shorter() {
        let mut random = crate::math::random::RandomStream::new(3, 0);
        for _ in 0..50 {
            let mut point = || vec![random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)];
            let from = point();
            let candidates: Vec<Vec<Vec<f64>>> =
                [3, 1, 4, 2].map(|count| (0..count).map(|_| point()).collect()).to_vec();
            let length = |way: &[Vec<f64>]| {
                let starts = [&from].into_iter().chain(way);
                starts.zip(way).map(|(start, end)| distance(start, end)).sum::<f64>()
            };
            let mut least = f64::INFINITY;
            for number in 0..24 {
                let picks = [number % 3, 0, number / 3 % 4, number / 12];
                let way: Vec<_> =
                    candidates.iter().zip(picks).map(|(it, pick)| it[pick].clone()).collect();
                least = least.min(length(&way));
            }
            let found = least_travel(&from, candidates);
            assert!((length(&found) - least).abs() < 1e-12);
        }
    }

    #[test]
    fn a_waypoint_is_a_list_or_has_a_pose() {
        let read = |text: &str| serde_json::from_str::<Waypoint>(text);
        assert_eq!(read("[1, 2]").unwrap(), Waypoint::Joints(vec![1.0, 2.0]));
        let Waypoint::Pose(pose) = read(r#"{"pose": {"position": [1, 0, 0]}}"#).unwrap() else {
            panic!("a pose")
        };
        assert_eq!((pose.pose.position, pose.seed), ([1.0, 0.0, 0.0], None));
        for (text, words) in [
            ("7", "a list with a position per joint, or an object with a pose"),
            (r#"{"position": [0, 0, 0]}"#, "unknown field `position`"),
            ("{}", "missing field `pose`"),
        ] {
            assert!(read(text).unwrap_err().to_string().contains(words), "{text}");
        }
    }
}
