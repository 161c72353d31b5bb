//! MoveIt's `joint_limits.yaml`.

use std::collections::HashMap;

use saphyr_parser::{Event, Parser};

use super::UrdfRobot;
use crate::fault::Faults;
use crate::robot::{Joint, Provenance};

/// Longest document, in bytes.
const MAX_BYTES: usize = 1 << 20;
/// `joint_limits`, the joint, the limit; a ROS 2 file may have a node's name and `ros__parameters` above.
const MAX_DEPTH: usize = 8;

/// By joint, by key: `max_velocity` and so on, as written.
pub(super) type Limits = HashMap<String, HashMap<String, String>>;

/// Reads the mapping below `joint_limits`, wherever in the document it stands.
pub(super) fn read(text: &str) -> Result<Limits, String> {
    if text.len() > MAX_BYTES {
        return Err(format!("{} bytes, but must be at most {MAX_BYTES}", text.len()));
    }
    let mut limits = Limits::new();
    let mut found = false;
    // The keys that lead here, and the key whose value comes next.
    let (mut path, mut key): (Vec<String>, Option<String>) = (Vec::new(), None);
    for event in Parser::new_from_str(text) {
        let (event, span) = event.map_err(|error| format!("not a YAML document: {error}"))?;
        let problem = |what: &str| Err(format!("line {}: {what}", span.start.line()));
        match event {
            Event::Alias(_) => return problem("aliases are not read"),
            Event::MappingStart(..) | Event::SequenceStart(..) => {
                if path.len() >= MAX_DEPTH {
                    return problem("nested too deeply");
                }
                path.push(key.take().unwrap_or_default());
                found |= path.last().is_some_and(|last| last == "joint_limits");
            }
            Event::MappingEnd | Event::SequenceEnd => {
                path.pop();
            }
            Event::Scalar(scalar, ..) => match key.take() {
                None => key = Some(scalar.into_owned()),
                Some(name) => {
                    if let [.., above, joint] = &path[..]
                        && above == "joint_limits"
                    {
                        limits.entry(joint.clone()).or_default().insert(name, scalar.into_owned());
                    }
                }
            },
            _ => {}
        }
    }
    if found { Ok(limits) } else { Err("there is no mapping `joint_limits`".to_owned()) }
}

/// Puts `limits` in place of the URDF's.
pub(super) fn apply(limits: &Limits, robot: &mut UrdfRobot, faults: &mut Faults) {
    for joint in &mut robot.joints {
        let Some(entries) = limits.get(&joint.name) else { continue };
        apply_to(joint, entries, faults);
    }
    let known = |name: &&String| !robot.joints.iter().any(|joint| joint.name == **name);
    let mut beside: Vec<&str> = limits.keys().filter(known).map(String::as_str).collect();
    if !beside.is_empty() {
        beside.sort_unstable();
        let names = beside.join(", ");
        robot.notes.push(format!(
            "Joint limits of joints that do not move the chain were left out: {names}."
        ));
    }
}

fn apply_to(joint: &mut Joint, entries: &HashMap<String, String>, faults: &mut Faults) {
    let name = &joint.name;
    let mut number = |key: &str, flag: &str| {
        // A limit that is switched off says nothing.
        if entries.get(flag).is_some_and(|flag| flag.trim() == "false") {
            return None;
        }
        let text = entries.get(key)?;
        let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let positional = flag == "has_position_limits";
        if value.is_none_or(|value| value <= 0.0 && !positional) {
            let must = if positional { "a finite number" } else { "a positive number" };
            faults.add("/joint_limits", format!("{key} {text:?} of joint {name:?} must be {must}"));
            return None;
        }
        value
    };
    let found = [
        number("min_position", "has_position_limits"),
        number("max_position", "has_position_limits"),
        number("max_velocity", "has_velocity_limits"),
        number("max_acceleration", "has_acceleration_limits"),
        number("max_jerk", "has_jerk_limits"),
        number("max_effort", "has_effort_limits"),
    ];
    let (limits, from) = (&mut joint.limits, &mut joint.provenance);
    let places = [
        (&mut limits.lower, &mut from.lower),
        (&mut limits.upper, &mut from.upper),
        (&mut limits.velocity, &mut from.velocity),
        (&mut limits.acceleration, &mut from.acceleration),
        (&mut limits.jerk, &mut from.jerk),
        (&mut limits.effort, &mut from.effort),
    ];
    for (value, (limit, provenance)) in found.into_iter().zip(places) {
        if value.is_some() {
            (*limit, *provenance) = (value, Some(Provenance::User));
        }
    }
    if let (Some(lower), Some(upper)) = (joint.limits.lower, joint.limits.upper)
        && lower >= upper
    {
        let detail = format!("min_position {lower} of joint {name:?} must be below {upper}");
        faults.add("/joint_limits", detail);
    }
}
