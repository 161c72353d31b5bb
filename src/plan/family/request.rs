//! What a user asks for when planning a problem in many variants.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use crate::fault::{Faults, read};
use crate::plan::request::{LegTask, LimitOverrides, LimitScale, RobotRef, Task, WaypointsTask};

/// Most members of a family.
pub const MAX_MEMBERS: usize = 1000;

/// Plan one problem in many variants: members that are named one by one, or a
/// sweep over values; 1 to 1000 of them, with at most 200,000 waypoints in all.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FamilyTask {
    /// What all members start from; it is not planned itself.
    pub problem: FamilyProblem,
    /// The members; instead of `sweep`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(max_items = 1000)]
    pub members: Vec<FamilyMember>,
    /// Every combination of these values is a member, the last axis changing
    /// fastest; 1 to 8 axes, instead of `members`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(max_items = 8)]
    pub sweep: Vec<SweepAxis>,
}

/// The problem of a family: a plan request with a `waypoints` task.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct FamilyProblem {
    /// The robot, instead of the request's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotRef>,
    /// Limits that replace the robot's, instead of the request's, which hold
    /// for the request's robot only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitOverrides>,
    /// Factors on the limits, instead of the request's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_scale: Option<LimitScale>,
    /// What is planned.
    #[serde(serialize_with = "LegTask::serialize_waypoints")]
    #[schema(value_type = LegTask)]
    pub task: WaypointsTask,
}

/// One member of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FamilyMember {
    /// Name, unique within the family; 1 to 64 characters.
    #[schema(min_length = 1, max_length = 64)]
    pub name: String,
    /// How it differs from the problem: a JSON merge patch (RFC 7386), so a
    /// list replaces a whole list, and null takes a member out. Everything but
    /// the robot and the task's type may differ.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub set: Map<String, Value>,
}

/// One axis of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepAxis {
    /// JSON pointer (RFC 6901) into the problem, such as
    /// `/limit_scale/acceleration`. Objects on the way are made where there
    /// are none.
    pub path: String,
    /// The values that stand there in turn; null stands there as well.
    #[schema(min_items = 1)]
    pub values: Vec<Value>,
}

impl FamilyTask {
    /// Reads the task that stands at `pointer`.
    pub(in crate::plan) fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            problem: Value,
            #[serde(default)]
            members: Vec<FamilyMember>,
            #[serde(default)]
            sweep: Vec<SweepAxis>,
        }
        let Raw { problem, members, sweep } = read(value, pointer, faults)?;
        let problem = FamilyProblem::parse(problem, &format!("{pointer}/problem"), faults)?;
        Some(Self { problem, members, sweep })
    }
}

impl FamilyProblem {
    fn parse(value: Value, pointer: &str, faults: &mut Faults) -> Option<Self> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Raw {
            #[serde(default)]
            robot: Option<Value>,
            #[serde(default)]
            limits: Option<LimitOverrides>,
            #[serde(default)]
            limit_scale: Option<LimitScale>,
            task: Value,
        }
        let Raw { robot, limits, limit_scale, task } = read(value, pointer, faults)?;
        let robot = robot.map(|it| RobotRef::parse(it, &format!("{pointer}/robot"), faults));
        let place = format!("{pointer}/task");
        match Task::parse(task, &place, faults)? {
            Task::Waypoints(task) => {
                Some(Self { robot: robot.flatten(), limits, limit_scale, task })
            }
            other => {
                let detail = format!("a family varies a `waypoints` task, not a {}", other.name());
                faults.add(place, detail);
                None
            }
        }
    }
}
