//! Why a pose cannot be reached.

use super::numeric::{self, Scratch};
use super::redundant::spread;
use super::{InverseKinematics, PoseError, Range, Robot, Solver};
use crate::geometry::Transform;

/// Starts of the search for the nearest pose.
const STARTS: u64 = 24;
/// Positions of a held joint that are looked at.
const HELD: usize = 64;

/// A pose that no configuration within the limits reaches.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// The nearest pose found within the limits, m and rad weighed alike: how far it is off.
    pub error: PoseError,
    /// The configuration that leads there, rad or m per joint.
    pub configuration: Vec<f64>,
    /// The limit in the way, if without limits the pose could be reached.
    pub limit: Option<LimitMiss>,
}

impl Miss {
    /// What happened, in words; `names` are the joints'.
    pub fn describe(&self, names: &[String]) -> String {
        let PoseError { position, orientation } = self.error;
        let mut words = format!(
            "no configuration within the limits reaches the pose; the nearest found misses it by {position:.4} m \
             and {orientation:.4} rad"
        );
        if let Some(LimitMiss { joint, position, limit }) = self.limit {
            let name = &names[joint];
            words += &format!(
                "; joint {name:?} would have to be at {position:.4}, beyond its limit {limit:.4}"
            );
        }
        words
    }
}

/// A limit in the way of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitMiss {
    /// The joint that is furthest outside its limits, in the configuration that is outside least.
    pub joint: usize,
    /// Where it would have to be, rad or m.
    pub position: f64,
    /// The limit it would pass, rad or m.
    pub limit: f64,
}

/// Finds out why nothing reaches `target`.
pub(super) fn explain(
    inverse: &InverseKinematics,
    target: &Transform,
    seed: &[f64],
    tolerance: &PoseError,
) -> Miss {
    let mut scratch = Scratch::new(&inverse.kinematics);
    let mut least: Option<(f64, Vec<f64>)> = None;
    unlimited(inverse, target, seed, &mut scratch, |joints| {
        let outside =
            inverse.ranges.iter().zip(joints).map(|(range, joint)| range.excess(*joint).1);
        let outside = outside.fold(0.0, f64::max);
        let tool = inverse.kinematics.tool_transform(joints);
        if least.as_ref().is_none_or(|(excess, _)| outside < *excess)
            && PoseError::between(&tool, target).within(tolerance)
        {
            least = Some((outside, joints.to_vec()));
        }
    });
    let beyond = least.map(|(_, joints)| joints);
    let (error, configuration) = nearest(inverse, target, seed, beyond.as_deref(), &mut scratch);
    let limit = beyond.and_then(|joints| worst(&inverse.ranges, &joints));
    Miss { error, configuration, limit }
}

/// Shows `see` configurations that reach `target`, limits aside.
fn unlimited(
    inverse: &InverseKinematics,
    target: &Transform,
    seed: &[f64],
    scratch: &mut Scratch,
    mut see: impl FnMut(&[f64]),
) {
    let motion = *target * inverse.tool_from_world_at_zero;
    match &inverse.solver {
        Solver::Redundant(arm) => {
            let window = inverse.ranges[arm.held()].window(seed[arm.held()]);
            for position in spread(window).take(HELD) {
                arm.solve(&motion, position, seed, |joints| see(&joints));
            }
        }
        Solver::Numeric => {
            let free =
                |range: &Range| Range { lower: f64::NEG_INFINITY, upper: f64::INFINITY, ..*range };
            let ranges: Vec<Range> = inverse.ranges.iter().map(free).collect();
            let mut joints = vec![0.0; ranges.len()];
            for start in 0..STARTS {
                inverse.start(start, seed, &mut joints);
                numeric::descend(&inverse.kinematics, &ranges, target, &mut joints, scratch, None);
                see(&joints);
            }
        }
        _ => inverse.branches(&motion, seed, see),
    }
}

/// The configuration within the limits whose pose is nearest to `target`, of many descents.
fn nearest(
    inverse: &InverseKinematics,
    target: &Transform,
    seed: &[f64],
    beyond: Option<&[f64]>,
    scratch: &mut Scratch,
) -> (PoseError, Vec<f64>) {
    let InverseKinematics { kinematics, ranges, .. } = inverse;
    let mut best = (f64::INFINITY, vec![0.0; ranges.len()]);
    let mut joints = [0.0; Robot::MAX_DOF];
    let joints = &mut joints[..ranges.len()];
    for start in 0..=STARTS {
        match (start, beyond) {
            // From where the limits cut off what would have reached it.
            (0, Some(beyond)) => {
                for ((joint, range), beyond) in joints.iter_mut().zip(ranges).zip(beyond) {
                    *joint = range.excess(*beyond).0.max(range.lower).min(range.upper);
                }
            }
            (0, None) => continue,
            _ => inverse.start(start - 1, seed, joints),
        }
        let error = numeric::descend(kinematics, ranges, target, joints, scratch, None);
        if error < best.0 {
            best = (error, joints.to_vec());
        }
    }
    (PoseError::between(&kinematics.tool_transform(&best.1), target), best.1)
}

/// The joint that is furthest outside its limits; none if all are within.
fn worst(ranges: &[Range], joints: &[f64]) -> Option<LimitMiss> {
    let misses = ranges.iter().zip(joints).enumerate().map(|(joint, (range, position))| {
        let (position, excess) = range.excess(*position);
        let limit = if position < range.lower { range.lower } else { range.upper };
        (excess, LimitMiss { joint, position, limit })
    });
    let worst = misses.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (worst.0 > 0.0).then_some(worst.1)
}
