//! Configurations for the ends of a motion.

use serde_json::json;

use super::checker::FreeMotions;
use super::prepare::PreparedMotion;
use super::request::MotionEnd;
use crate::geometry::{Pose, Transform};
use crate::plan::error::{PlanCode, PlanError};
use crate::planner::{PathEnd, ValidityChecker, distance};
use crate::robot::inverse::{InverseKinematics, Miss, PoseError, Solutions};

/// Free configurations for one end, the nearest to `seed` first.
///
/// # Errors
///
/// That the tool cannot be brought there, or only with something touching: what, and how deep.
pub fn configurations(
    task: &PreparedMotion,
    end: PathEnd,
    seed: &[f64],
    free: &mut FreeMotions,
) -> Result<Vec<Vec<f64>>, PlanError> {
    let wanted = match end {
        PathEnd::Start => &task.ends[0],
        PathEnd::Goal => &task.ends[1],
    };
    let mut all = match (wanted, task.robot.inverse()) {
        (MotionEnd::Joints(joints), _) => vec![joints.clone()],
        (MotionEnd::Pose(pose), Some(inverse)) => solutions(task, end, inverse, pose, seed)?,
        // Validation asks for kinematics where there are poses.
        (MotionEnd::Pose(_), None) => Vec::new(),
    };
    all.sort_by(|a, b| distance(a, seed).total_cmp(&distance(b, seed)));
    let open: Vec<_> = all.iter().filter(|state| free.is_state_valid(state)).cloned().collect();
    if open.is_empty() { Err(in_collision(task, end, &all, free)) } else { Ok(open) }
}

fn solutions(
    task: &PreparedMotion,
    end: PathEnd,
    inverse: &InverseKinematics,
    pose: &Pose,
    seed: &[f64],
) -> Result<Vec<Vec<f64>>, PlanError> {
    let target = Transform::from(pose);
    let mut found = Solutions::new(inverse);
    inverse.all(&target, seed, &PoseError::TOLERANCE, &mut found);
    if found.is_empty()
        && let Err(miss) = inverse.nearest(&target, seed, &PoseError::TOLERANCE, &mut found)
    {
        return Err(unreachable(task, end, &miss));
    }
    Ok(found.iter().map(|(joints, _)| joints.to_vec()).collect())
}

fn unreachable(task: &PreparedMotion, end: PathEnd, miss: &Miss) -> PlanError {
    let PoseError { position, orientation } = miss.error;
    let mut message = format!(
        "no configuration within the limits brings the tool to the {end}: the nearest one misses it by {:.3} mm \
         and {orientation:.4} rad",
        1e3 * position
    );
    let limit = miss.limit.map(|limit| {
        let name = &task.robot.joint_names()[limit.joint];
        message += &format!(
            "; {name} would have to be at {:.4}, beyond its limit of {}",
            limit.position, limit.limit
        );
        json!({ "joint": name, "position": limit.position, "limit": limit.limit })
    });
    let details = json!({
        "end": end.to_string(), "pointer": format!("/task/{end}"), "position_error_m": position,
        "orientation_error_rad": orientation, "nearest": miss.configuration, "limit": limit,
    });
    PlanError { code: PlanCode::IkNoSolution, message, details, partial: None }
}

/// All configurations touch something: what the least deep one touches.
fn in_collision(
    task: &PreparedMotion,
    end: PathEnd,
    all: &[Vec<f64>],
    free: &mut FreeMotions,
) -> PlanError {
    let code = match end {
        PathEnd::Start => PlanCode::StartInCollision,
        PathEnd::Goal => PlanCode::GoalInCollision,
    };
    let deepest = all.iter().filter_map(|state| {
        let contacts = task.checker.contacts(state, &mut free.scratch);
        Some((contacts.first()?.distance_m, state, contacts))
    });
    let Some((distance, state, contacts)) = deepest.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        let message = format!("the {end} is beyond the limits of a sliding joint");
        return PlanError {
            code,
            message,
            details: json!({ "end": end.to_string() }),
            partial: None,
        };
    };
    let [first, second] = &contacts[0].pair;
    let reason = if distance > 0.0 {
        format!(
            "is {:.3} mm from {second}, nearer than {} mm",
            1e3 * distance,
            1e3 * task.clearance_m
        )
    } else {
        format!("lies {:.3} mm deep in {second}", -1e3 * distance)
    };
    let among = if all.len() > 1 {
        format!(", and so it is with all {} configurations that reach it", all.len())
    } else {
        String::new()
    };
    let contacts: Vec<_> = contacts
        .iter()
        .map(|contact| json!({ "pair": contact.pair, "distance_m": contact.distance_m }))
        .collect();
    let details = json!({
        "end": end.to_string(), "pointer": format!("/task/{end}"), "configuration": state,
        "contacts": contacts, "configurations": all.len(), "clearance_m": task.clearance_m,
    });
    PlanError {
        code,
        message: format!("at the {end} {first} {reason}{among}"),
        details,
        partial: None,
    }
}
