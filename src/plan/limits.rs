//! The limits of a request: the robot's, replaced and scaled.

use super::request::{LimitOverride, LimitOverrides, LimitScale, LimitValues};
use crate::fault::Faults;
use crate::robot::{Provenance, Robot};
use crate::trajectory::{DERIVATIVES, JointBounds, Limit};

/// Smallest derivative limit: any below would lead to durations beyond any use.
const SMALLEST: f64 = 1e-9;

/// Largest derivative limit: the powers of any above would overflow.
const LARGEST: f64 = 1e12;

/// Where a limit of the request itself comes from.
const REQUEST: &str = "request";

/// The limits that hold for a request, one set per joint.
pub fn resolve(
    robot: &Robot,
    overrides: Option<&LimitOverrides>,
    scale: Option<&LimitScale>,
    faults: &mut Faults,
) -> Vec<JointBounds> {
    let none = LimitOverrides::default();
    let overrides = overrides.unwrap_or(&none);
    check_overrides(robot, overrides, faults);
    let factors = scale.map_or([None; 3], |s| [s.velocity, s.acceleration, s.jerk]);
    for (name, factor) in DERIVATIVES.iter().zip(factors) {
        if factor.is_some_and(|factor| !(factor > 0.0 && factor <= 1.0)) {
            let factor = factor.unwrap_or_default();
            faults.add(format!("/limit_scale/{name}"), format!("{factor} is outside (0, 1]"));
        }
    }
    let kinds = [&overrides.velocity, &overrides.acceleration, &overrides.jerk];
    let joints = robot.joints().iter().enumerate().map(|(index, joint)| {
        let (own, from) = (&joint.limits, &joint.provenance);
        let derivatives = [
            (own.velocity, from.velocity),
            (own.acceleration, from.acceleration),
            (own.jerk, from.jerk),
        ];
        let mut limits = [None, None, None];
        for (order, limit) in limits.iter_mut().enumerate() {
            let unscaled = one(kinds[order], index, derivatives[order]);
            let large = unscaled.as_ref().is_some_and(|limit| limit.value >= SMALLEST);
            *limit = scaled(unscaled, factors[order]);
            if let (true, Some(limit)) = (large, limit.as_ref().filter(|l| l.value < SMALLEST)) {
                let (name, value) = (&joint.name, limit.value);
                let detail = format!("{name}'s limit becomes {value:e}, below {SMALLEST:e}");
                faults.add(format!("/limit_scale/{}", DERIVATIVES[order]), detail);
            }
        }
        JointBounds {
            name: joint.name.clone(),
            unit: joint.joint_type.position_unit(),
            lower: one(&overrides.lower, index, (own.lower, from.lower)),
            upper: one(&overrides.upper, index, (own.upper, from.upper)),
            derivatives: limits,
        }
    });
    joints.collect()
}

/// The limit of the tool's speed that a request sets, m/s.
pub fn tcp_speed(
    robot: &Robot,
    overrides: Option<&LimitOverrides>,
    faults: &mut Faults,
) -> Option<f64> {
    let limit = overrides.and_then(|overrides| overrides.tcp_speed)?;
    if !(SMALLEST..=LARGEST).contains(&limit) {
        let detail = format!(
            "tcp speed limit is {limit}, not a positive number of m/s ({SMALLEST:e} to {LARGEST:e}); null means no limit"
        );
        faults.add("/limits/tcp_speed", detail);
    }
    if robot.kinematics().is_none() {
        let detail = format!(
            "{} has no kinematics, without which the speed of its tool is not known",
            robot.name()
        );
        faults.add("/limits/tcp_speed", detail);
    }
    Some(limit)
}

fn one(
    kind: &LimitOverride,
    joint: usize,
    (own, provenance): (Option<f64>, Option<Provenance>),
) -> Option<Limit> {
    let requested = |value: f64| Limit { value, provenance: REQUEST.to_owned() };
    match kind {
        LimitOverride::Keep => own.map(|value| Limit {
            value,
            provenance: provenance.map_or("robot", Provenance::as_str).to_owned(),
        }),
        LimitOverride::Remove => None,
        LimitOverride::Replace(LimitValues::All(value)) => Some(requested(*value)),
        LimitOverride::Replace(LimitValues::PerJoint(values)) => {
            values.get(joint).copied().flatten().map(requested)
        }
    }
}

fn scaled(limit: Option<Limit>, factor: Option<f64>) -> Option<Limit> {
    let (mut limit, factor) = match (limit, factor) {
        (Some(limit), Some(factor)) => (limit, factor),
        (limit, _) => return limit,
    };
    limit.value *= factor;
    limit.provenance = format!("{} × {factor}", limit.provenance);
    Some(limit)
}

fn check_overrides(robot: &Robot, overrides: &LimitOverrides, faults: &mut Faults) {
    let LimitOverrides { lower, upper, velocity, acceleration, jerk, tcp_speed: _ } = overrides;
    let kinds = [
        ("lower", lower, false),
        ("upper", upper, false),
        ("velocity", velocity, true),
        ("acceleration", acceleration, true),
        ("jerk", jerk, true),
    ];
    for (name, kind, positive) in kinds {
        let mut check = |pointer: String, value: f64, whose: &str| {
            if !value.is_finite() {
                faults.add(pointer, format!("{name} limit{whose} is {value}, not a finite number"));
            } else if positive && !(SMALLEST..=LARGEST).contains(&value) {
                let detail = format!(
                    "{name} limit{whose} is {value}, not a positive number ({SMALLEST:e} to {LARGEST:e}); null means no limit"
                );
                faults.add(pointer, detail);
            }
        };
        match kind {
            LimitOverride::Replace(LimitValues::All(value)) => {
                check(format!("/limits/{name}"), *value, "");
            }
            LimitOverride::Replace(LimitValues::PerJoint(values)) => {
                for (index, (value, joint)) in values.iter().zip(robot.joints()).enumerate() {
                    if let Some(value) = value {
                        let whose = format!(" of {}", joint.name);
                        check(format!("/limits/{name}/{index}"), *value, &whose);
                    }
                }
                if values.len() != robot.dof() {
                    let (found, dof) = (values.len(), robot.dof());
                    let detail = format!("{found} values for the {dof} joints of {}", robot.name());
                    faults.add(format!("/limits/{name}"), detail);
                }
            }
            LimitOverride::Keep | LimitOverride::Remove => {}
        }
    }
}
