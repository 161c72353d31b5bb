//! Ends in motion of a `waypoints` task: what they must keep.

use super::prepare::Check;
use super::request::{Constraints, DurationGoal, EndMotion, Leg, WaypointsTask};
use crate::fault::Faults;
use crate::trajectory::interpolation::{Interpolation, Timing};
use crate::trajectory::jerk_limited::state_to_state::{End, State, StateFault, check};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::{DERIVATIVES, Ends, JointBounds};

impl Check<'_> {
    /// The ends of a task, which is `sound` in all else; none if they are at rest. What is wrong with them goes
    /// to `faults`.
    pub(super) fn ends(
        &self,
        task: &WaypointsTask,
        interpolation: &Interpolation,
        sound: Option<&[Vec<f64>]>,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<Ends> {
        let before = faults.0.len();
        let free = matches!(interpolation.timing, Timing::Free);
        for (name, end) in [("start", &task.start), ("goal", &task.goal)] {
            if end.is_some() && !free {
                let detail = format!(
                    "{} starts and ends at rest; only jerk_limited takes ends in motion",
                    interpolation.name
                );
                faults.add(format!("{pointer}/{name}"), detail);
            }
        }
        let ends = Ends {
            start: self.end(task.start.as_ref(), &format!("{pointer}/start"), faults),
            goal: self.end(task.goal.as_ref(), &format!("{pointer}/goal"), faults),
        };
        if faults.0.len() > before || ends.are_at_rest() {
            return None;
        }
        if let Some(waypoints) = sound {
            self.check_moving(task, waypoints, &ends, pointer, faults);
        }
        Some(ends)
    }

    /// Velocity and acceleration of every joint; zero where none is given, and zero acceleration
    /// where jerk has no limit: there it may jump and says nothing.
    fn end(&self, end: Option<&EndMotion>, place: &str, faults: &mut Faults) -> Vec<[f64; 2]> {
        let dof = self.limits.len();
        let mut states = vec![[0.0; 2]; dof];
        let Some(EndMotion { velocity, acceleration }) = end else { return states };
        for (order, name, values) in [(0, "velocity", velocity), (1, "acceleration", acceleration)]
        {
            let Some(values) = values else { continue };
            let place = format!("{place}/{name}");
            if values.len() != dof {
                let detail =
                    format!("{} values; {} has {dof} joints", values.len(), self.robot.name());
                faults.add(place, detail);
                continue;
            }
            for (joint, (value, limit)) in values.iter().zip(self.limits).enumerate() {
                let most = limit.derivative(order);
                let unit = limit.unit_of(order + 1);
                if !value.is_finite() {
                    let detail = format!("{}: {value} is not a finite number", limit.name);
                    faults.add(format!("{place}/{joint}"), detail);
                } else if value.abs() > most {
                    let detail = format!(
                        "{}: {name} {value} {unit} is beyond its limit of {most} {unit}",
                        limit.name
                    );
                    faults.add(format!("{place}/{joint}"), detail);
                }
                if order == 0 || limit.derivative(2).is_finite() {
                    states[joint][order] = *value;
                }
            }
        }
        states
    }

    /// What a task with ends in motion cannot ask for, and what its states cannot be together.
    fn check_moving(
        &self,
        task: &WaypointsTask,
        waypoints: &[Vec<f64>],
        ends: &Ends,
        pointer: &str,
        faults: &mut Faults,
    ) {
        if let Some(DurationGoal::Exactly(_)) = task.duration {
            let detail = "a motion that starts or ends at speed cannot be stretched to a duration; use at_most";
            faults.add(format!("{pointer}/duration/exactly"), detail);
        }
        if task.constraints == Constraints::VelocityOnly {
            let detail = "ends in motion are planned within all limits; remove those that shall not count \
                          with `limits`: null";
            faults.add(format!("{pointer}/constraints"), detail);
        }
        let (Some(first), Some(last)) = (waypoints.first(), waypoints.last()) else {
            return;
        };
        let states = |end: &[[f64; 2]], positions: &[f64]| -> Vec<State> {
            let state = |([velocity, acceleration], position): (&[f64; 2], &f64)| State {
                position: *position,
                velocity: *velocity,
                acceleration: *acceleration,
            };
            end.iter().zip(positions).map(state).collect()
        };
        let limits: Vec<KernelLimits> = self.limits.iter().map(|limit| limit.kernel(3)).collect();
        for fault in check(&states(&ends.start, first), Some(&states(&ends.goal, last)), &limits) {
            self.state_fault(waypoints, ends, &fault, pointer, faults);
        }
    }

    /// A fault of two states in terms of the request. Waypoints and values alone are checked already.
    fn state_fault(
        &self,
        waypoints: &[Vec<f64>],
        ends: &Ends,
        fault: &StateFault,
        pointer: &str,
        faults: &mut Faults,
    ) {
        match *fault {
            StateFault::Unlimited { joint } => {
                let rests = |end: &[[f64; 2]]| end[joint] == [0.0; 2];
                let stays = waypoints.windows(2).all(|pair| pair[0][joint] == pair[1][joint]);
                if !(stays && rests(&ends.start) && rests(&ends.goal)) {
                    let detail = format!(
                        "{}: with ends in motion a joint that moves needs an acceleration or jerk limit",
                        self.limits[joint].name
                    );
                    faults.add("/limits", detail);
                }
            }
            StateFault::Carried { joint, end, velocity, acceleration, peak, limit } => {
                let bounds = &self.limits[joint];
                let (unit, rate) = (bounds.unit_of(1), bounds.unit_of(2));
                let when = if end == End::Start { "will be" } else { "was" };
                let detail = format!(
                    "{}: with velocity {velocity} {unit} and acceleration {acceleration} {rate} the jerk limit \
                     means that velocity {when} {peak} {unit}, beyond its limit of {limit} {unit}",
                    bounds.name
                );
                faults.add(format!("{pointer}/{end}/acceleration/{joint}"), detail);
            }
            ref other => faults.add(pointer, other.to_string()),
        }
    }
}

/// A leg starts as fast as the one before it ends.
pub(super) fn connection(
    before: &Leg,
    leg: &Leg,
    limits: &[JointBounds],
    place: &str,
    faults: &mut Faults,
) {
    let value = |end: &Option<EndMotion>, order: usize, joint: usize| {
        let EndMotion { velocity, acceleration } = end.as_ref()?;
        [velocity, acceleration][order].as_ref()?.get(joint).copied()
    };
    for (joint, limit) in limits.iter().enumerate() {
        for (order, name) in DERIVATIVES.iter().enumerate().take(2) {
            let end = value(&before.task.goal, order, joint).unwrap_or(0.0);
            let start = value(&leg.task.start, order, joint).unwrap_or(0.0);
            if (end - start).abs() > 1e-9 {
                let detail = format!(
                    "leg {} starts with {name} {start} of {}, but leg {} ends with {end}",
                    leg.name, limit.name, before.name
                );
                faults.add(format!("{place}/task/start/{name}/{joint}"), detail);
            }
        }
    }
}
