//! How far a motion may pass inner waypoints by.

use super::prepare::Check;
use super::prepared::PreparedWaypoints;
use super::request::{ViaTolerance, WaypointsTask};
use crate::fault::Faults;
use crate::trajectory::interpolation::{Interpolation, Timing};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::{JointBounds, Room, rooms};

impl ViaTolerance {
    /// One value per joint, rad or m; what is wrong with them goes to `faults`.
    pub(super) fn resolve(
        &self,
        limits: &[JointBounds],
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<Vec<f64>> {
        let (before, dof) = (faults.0.len(), limits.len());
        let mut check = |value: f64, place: String, whose: &str| {
            if !(value.is_finite() && value >= 0.0) {
                let detail = format!(
                    "{whose}{value} is no tolerance; give a finite number that is not negative"
                );
                faults.add(place, detail);
            }
        };
        let values = match self {
            Self::All(value) => {
                check(*value, pointer.to_owned(), "");
                vec![*value; dof]
            }
            Self::PerJoint(values) if values.len() != dof => {
                faults.add(pointer, format!("{} values for {dof} joints", values.len()));
                return None;
            }
            Self::PerJoint(values) => {
                for (joint, (value, limit)) in values.iter().zip(limits).enumerate() {
                    check(*value, format!("{pointer}/{joint}"), &format!("{}: ", limit.name));
                }
                values.clone()
            }
        };
        (faults.0.len() == before).then_some(values)
    }
}

impl Check<'_> {
    /// The tolerance of a task, one value per joint; none if waypoints are just met.
    pub(super) fn via_tolerance(
        &self,
        task: &WaypointsTask,
        interpolation: &Interpolation,
        pointer: &str,
        faults: &mut Faults,
    ) -> Option<Vec<f64>> {
        let tolerance = task.via_tolerance.as_ref()?;
        let place = format!("{pointer}/via_tolerance");
        if !matches!(interpolation.timing, Timing::Free) {
            let detail = format!(
                "{} passes exactly through its waypoints; only jerk_limited can use a tolerance",
                interpolation.name
            );
            faults.add(&place, detail);
        }
        tolerance.resolve(self.limits, &place, faults)
    }
}

impl PreparedWaypoints {
    /// Rooms at the waypoints within the position limits; none if all are met exactly.
    pub(super) fn rooms(&self, limits: &[JointBounds]) -> Vec<Vec<Room>> {
        let Some(tolerance) = &self.via_tolerance else { return Vec::new() };
        let limits: Vec<KernelLimits> = limits.iter().map(|limit| limit.kernel(3)).collect();
        rooms(&self.waypoints, &limits, tolerance)
    }
}
