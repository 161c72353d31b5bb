//! Checks what a family means: every member like a request of its own.

use std::collections::HashSet;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::patch::{merge, put};
use super::request::{FamilyProblem, FamilyTask, MAX_MEMBERS, SweepAxis};
use crate::fault::{Fault, Faults};
use crate::plan::prepare::{Common, check_name, resolve_robot, validate};
use crate::plan::prepared::PreparedPlan;
use crate::plan::request::{PlanRequest, Task};
use crate::robot::Robot;

/// Most waypoints of all members together: more would only fill the memory.
const MAX_ALL_WAYPOINTS: usize = 200_000;

/// Most axes of a sweep: more have no names to be told apart by.
const MAX_AXES: usize = 8;

/// Longest value that a member's name spells out, characters.
const LONGEST_LABEL: usize = 24;

/// A valid family, ready to run.
pub(in crate::plan) struct PreparedFamily {
    pub members: Vec<PreparedMember>,
    pub sweep: Vec<SweepAxis>,
}

/// A valid member.
pub(in crate::plan) struct PreparedMember {
    pub name: String,
    /// In a sweep, its value on each axis.
    pub values: Vec<Value>,
    /// As it would be planned alone.
    pub plan: PreparedPlan,
}

/// A member before it is checked.
struct Variant {
    name: String,
    origin: Origin,
    values: Vec<Value>,
}

/// Where a member comes from.
enum Origin {
    /// From the list of members.
    Listed(usize),
    /// From a sweep: which value on each axis.
    Swept(Vec<usize>),
}

/// Checks a `family`, a task of `request`.
pub(in crate::plan) fn prepare(
    task: &FamilyTask,
    request: &PlanRequest,
    common: &Common<'_>,
    faults: &mut Faults,
) -> Option<PreparedFamily> {
    let variants = match (&task.members[..], &task.sweep[..]) {
        ([], []) => {
            faults.add("/task", "either `members` or `sweep` is needed");
            return None;
        }
        ([_, ..], [_, ..]) => {
            faults.add("/task/sweep", "`members` and `sweep` exclude each other");
            return None;
        }
        (_, []) => listed(task, faults),
        ([], _) => swept(&task.sweep, faults),
    };
    let robot = robot(&task.problem, common, faults)?;
    let document = document(&task.problem, &robot, request);
    let members = Base { task, robot, document }.members(variants?, faults)?;
    Some(PreparedFamily { members, sweep: task.sweep.clone() })
}

fn robot(problem: &FamilyProblem, common: &Common<'_>, faults: &mut Faults) -> Option<Arc<Robot>> {
    let Some(own) = &problem.robot else {
        if common.robot.is_none() {
            faults.add("/robot", "missing: the problem names no robot of its own");
        }
        return common.robot.cloned();
    };
    let mut found = Faults::default();
    let robot = resolve_robot(own, common.find_robot, &mut found);
    faults.add_below("/task/problem", found);
    robot
}

fn listed(task: &FamilyTask, faults: &mut Faults) -> Option<Vec<Variant>> {
    let count = task.members.len();
    if count > MAX_MEMBERS {
        faults.add("/task/members", format!("{count} members; 1 to {MAX_MEMBERS} are taken"));
        return None;
    }
    let mut names = HashSet::new();
    let members = task.members.iter().enumerate().map(|(index, member)| {
        let place = format!("/task/members/{index}/name");
        check_name(&member.name, &place, &mut names, faults);
        let (name, origin) = (member.name.clone(), Origin::Listed(index));
        Variant { name, origin, values: Vec::new() }
    });
    Some(members.collect())
}

/// The combinations of all values, the last axis changing fastest.
fn swept(sweep: &[SweepAxis], faults: &mut Faults) -> Option<Vec<Variant>> {
    let before = faults.0.len();
    if sweep.len() > MAX_AXES {
        faults.add("/task/sweep", format!("{} axes; 1 to {MAX_AXES} are taken", sweep.len()));
        return None;
    }
    for (index, axis) in sweep.iter().enumerate() {
        check_axis(axis, index, &sweep[..index], faults);
    }
    let count = sweep.iter().try_fold(1usize, |all, axis| all.checked_mul(axis.values.len()));
    if count.is_none_or(|count| count > MAX_MEMBERS) {
        let counts: Vec<_> = sweep.iter().map(|axis| axis.values.len().to_string()).collect();
        let detail = format!("{} members; 1 to {MAX_MEMBERS} are taken", counts.join(" x "));
        faults.add("/task/sweep", detail);
    }
    if faults.0.len() > before {
        return None;
    }
    let titles = titles(sweep);
    Some((0..count?).map(|number| combination(number, sweep, &titles)).collect())
}

/// Combination `number` of all values.
fn combination(number: usize, sweep: &[SweepAxis], titles: &[&str]) -> Variant {
    let mut rest = number;
    let mut chosen = vec![0; sweep.len()];
    for (at, axis) in chosen.iter_mut().zip(sweep).rev() {
        (*at, rest) = (rest % axis.values.len(), rest / axis.values.len());
    }
    let axes = || chosen.iter().zip(sweep);
    let names = axes().zip(titles);
    let names = names.map(|((&at, axis), title)| format!("{title}={}", label(axis, at)));
    Variant {
        name: names.collect::<Vec<_>>().join(", "),
        values: axes().map(|(&at, axis)| axis.values[at].clone()).collect(),
        origin: Origin::Swept(chosen),
    }
}

fn check_axis(axis: &SweepAxis, index: usize, before: &[SweepAxis], faults: &mut Faults) {
    let place = format!("/task/sweep/{index}");
    if !axis.path.starts_with('/') {
        let detail = format!("`{}` is no JSON pointer below the problem", axis.path);
        faults.add(format!("{place}/path"), detail);
    }
    if let Some(other) = before.iter().find(|other| overlap(&other.path, &axis.path)) {
        let detail =
            format!("`{}` and `{}` are not independent of each other", other.path, axis.path);
        faults.add(format!("{place}/path"), detail);
    }
    if axis.values.is_empty() {
        faults.add(format!("{place}/values"), "no values; at least one is needed");
    }
    let mut labels = HashSet::new();
    for at in 0..axis.values.len().min(MAX_MEMBERS) {
        let label = label(axis, at);
        if labels.contains(&label) {
            let detail = format!("another value reads {label} as well");
            faults.add(format!("{place}/values/{at}"), detail);
        }
        labels.insert(label);
    }
}

/// True if one pointer leads to the other's place or on from it.
fn overlap(one: &str, other: &str) -> bool {
    let below = |below: &str, above: &str| {
        below.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    below(one, other) || below(other, one)
}

/// What names call each axis: the end of its path, all of it if ends are equal
/// or numbers of elements.
fn titles(sweep: &[SweepAxis]) -> Vec<&str> {
    let end = |axis: &SweepAxis| axis.path.rfind('/').map_or(0, |slash| slash + 1);
    let ends: Vec<&str> = sweep.iter().map(|axis| &axis.path[end(axis)..]).collect();
    let unique = |at: usize| ends.iter().filter(|end| **end == ends[at]).count() == 1;
    let telling = |at: usize| unique(at) && ends[at].parse::<usize>().is_err();
    let title = |at: usize| if telling(at) { ends[at] } else { &sweep[at].path[1..] };
    (0..sweep.len()).map(title).collect()
}

/// A value as names spell it: long ones by their number.
fn label(axis: &SweepAxis, at: usize) -> String {
    let text = match &axis.values[at] {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    };
    if text.chars().count() > LONGEST_LABEL { format!("#{}", at + 1) } else { text }
}

/// The problem as a plan request, with what it takes over from `request`.
fn document(problem: &FamilyProblem, robot: &Robot, request: &PlanRequest) -> Value {
    let FamilyProblem { robot: own, limits, limit_scale, task } = problem;
    // Limits belong to a robot: another one has its own.
    let shared = own.is_none();
    let limits = limits.as_ref().or(request.limits.as_ref().filter(|_| shared));
    let scale = limit_scale.as_ref().or(request.limit_scale.as_ref().filter(|_| shared));
    let mut document = Map::new();
    document.insert("robot".to_owned(), json!(robot.name()));
    document.insert("task".to_owned(), json!(Task::Waypoints(task.clone())));
    document.insert("seed".to_owned(), json!(request.seed));
    for (name, value) in [("limits", json!(limits)), ("limit_scale", json!(scale))] {
        if !value.is_null() {
            document.insert(name.to_owned(), value);
        }
    }
    Value::Object(document)
}

/// The faults told so far. Each is told once: that of a value in many
/// combinations, and those that the problem has without any change.
struct Told {
    told: HashSet<(String, String)>,
    /// The problem's own, once they are needed.
    own: Option<Vec<Fault>>,
}

impl Told {
    fn new(faults: &Faults) -> Self {
        let told = faults.0.iter().map(|fault| (fault.pointer.clone(), fault.detail.clone()));
        Self { told: told.collect(), own: None }
    }

    fn tell(&mut self, base: &Base<'_>, variant: &Variant, found: Faults, faults: &mut Faults) {
        let own = || base.check(base.document.clone()).err().unwrap_or_default().0;
        let own = self.own.get_or_insert_with(own);
        for fault in found.0 {
            let (pointer, detail) = match own.contains(&fault) {
                true => (base.below_problem(&fault.pointer), fault.detail.clone()),
                false => base.locate(variant, &fault),
            };
            if self.told.insert((pointer.clone(), fault.detail)) {
                faults.add(pointer, detail);
            }
        }
    }
}

/// What all members start from.
struct Base<'a> {
    task: &'a FamilyTask,
    robot: Arc<Robot>,
    /// The problem as a plan request of its own.
    document: Value,
}

impl Base<'_> {
    /// All members, checked.
    fn members(&self, variants: Vec<Variant>, faults: &mut Faults) -> Option<Vec<PreparedMember>> {
        let mut told = Told::new(faults);
        let (mut members, mut waypoints) = (Vec::with_capacity(variants.len()), 0);
        let count = variants.len();
        for variant in variants {
            match self.member(&variant) {
                Ok(plan) => {
                    waypoints += plan.tasks().map(|task| task.waypoints.len()).sum::<usize>();
                    let Variant { name, values, .. } = variant;
                    members.push(PreparedMember { name, values, plan });
                }
                Err(found) => told.tell(self, &variant, found, faults),
            }
            if waypoints > MAX_ALL_WAYPOINTS {
                let detail =
                    format!("all members together have more than {MAX_ALL_WAYPOINTS} waypoints");
                faults.add("/task", detail);
                return None;
            }
            // More faults than are shown help nobody, and cost time.
            if faults.0.len() > Faults::SHOWN {
                return None;
            }
        }
        (members.len() == count).then_some(members)
    }

    /// Applies a variant's changes and checks what comes out.
    fn member(&self, variant: &Variant) -> Result<PreparedPlan, Faults> {
        let mut document = self.document.clone();
        match &variant.origin {
            Origin::Listed(index) => merge(&mut document, &self.task.members[*index].set),
            Origin::Swept(_) => {
                let mut faults = Faults::default();
                for (axis, value) in self.task.sweep.iter().zip(&variant.values) {
                    if let Err(detail) = put(&mut document, &axis.path, value.clone()) {
                        faults.add(&axis.path, detail);
                    }
                }
                faults.into_result(())?;
            }
        }
        self.check(document)
    }

    /// Checks a plan request as if it had come alone.
    fn check(&self, document: Value) -> Result<PreparedPlan, Faults> {
        let mut faults = Faults::default();
        if document["robot"] != self.document["robot"] {
            faults.add("/robot", "all members of a family have the problem's robot");
            return Err(faults);
        }
        if document.pointer("/task/type") != self.document.pointer("/task/type") {
            faults.add("/task/type", "all members of a family are `waypoints` tasks");
            return Err(faults);
        }
        let request = PlanRequest::parse(document)?;
        let plan = validate(&request, &|_| Some(Arc::clone(&self.robot)))?;
        Ok(PreparedPlan { side_by_side: true, ..plan })
    }

    /// Where a fault of the problem itself stands in the request.
    fn below_problem(&self, pointer: &str) -> String {
        let FamilyProblem { limits, limit_scale, .. } = &self.task.problem;
        let inherited = pointer.starts_with("/seed")
            || pointer.starts_with("/limits") && limits.is_none()
            || pointer.starts_with("/limit_scale") && limit_scale.is_none();
        if inherited { pointer.to_owned() } else { format!("/task/problem{pointer}") }
    }

    /// Where a fault of a member stands in the request, and how it is told.
    fn locate(&self, variant: &Variant, fault: &Fault) -> (String, String) {
        let Fault { pointer, detail } = fault;
        let chosen = match &variant.origin {
            Origin::Listed(index) => {
                return (format!("/task/members/{index}/set{pointer}"), detail.clone());
            }
            Origin::Swept(chosen) => chosen,
        };
        let sweep = &self.task.sweep;
        let only = (sweep.len() == 1).then_some(0);
        let axis = sweep.iter().position(|axis| overlap(&axis.path, pointer)).or(only);
        let place = match axis {
            Some(axis) => format!("/task/sweep/{axis}/values/{}", chosen[axis]),
            None => "/task/sweep".to_owned(),
        };
        (place, format!("{}: {detail}", variant.name))
    }
}
