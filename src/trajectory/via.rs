//! How near a trajectory passes its waypoints.

use super::certificate::{Certificate, LAWFUL_TOLERANCE, Violation};
use super::limits::JointBounds;
use super::polynomial_trajectory::{KinematicState, Trajectory};

/// Largest distance of any joint from a waypoint at its time, rad or m; none without waypoints.
pub fn waypoint_error(trajectory: &Trajectory, waypoints: &[(f64, &[f64])]) -> Option<f64> {
    let mut state = KinematicState::new(trajectory.dof());
    let mut worst = None;
    for (t, waypoint) in waypoints {
        trajectory.sample(*t, &mut state);
        for (reached, wanted) in state.position.iter().zip(*waypoint) {
            let error = (reached - wanted).abs();
            // Not-a-number is the largest error of all.
            worst = Some(worst.map_or(error, |worst: f64| {
                if error.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(error) }
            }));
        }
    }
    worst
}

impl Certificate {
    /// The same where waypoints may be missed by no more than `tolerance`, one per joint in rad or m: all of them
    /// count as limits. Those that are due where the trajectory starts or ends are met exactly. `trajectory` is the
    /// one certified, with the limits and waypoints it was certified for.
    pub fn with_via_tolerance(
        mut self,
        trajectory: &Trajectory,
        limits: &[JointBounds],
        waypoints: &[(f64, &[f64])],
        tolerance: Option<&[f64]>,
    ) -> Self {
        let Some(tolerance) = tolerance else { return self };
        let mut state = KinematicState::new(trajectory.dof());
        let mut worst: Vec<Option<Violation>> = vec![None; limits.len()];
        for (t, waypoint) in waypoints {
            trajectory.sample(*t, &mut state);
            let inner = *t > 0.0 && *t < trajectory.duration();
            for (joint, wanted) in waypoint.iter().enumerate() {
                let miss = (state.position[joint] - wanted).abs();
                let most = if inner { tolerance[joint] } else { 0.0 };
                let excess = |violation: &Violation| {
                    violation.value.map_or(f64::INFINITY, |value| value - violation.limit_value)
                };
                // What cannot be computed is not met.
                let met = miss <= most + LAWFUL_TOLERANCE * wanted.abs().max(1.0);
                let slot = &mut worst[joint];
                if !met && slot.as_ref().is_none_or(|known| miss - most > excess(known)) {
                    *slot = Some(missed(&limits[joint], *t, miss, most));
                }
            }
        }
        let found: Vec<Violation> = worst.into_iter().flatten().collect();
        self.lawful &= found.is_empty();
        self.violations.extend(found);
        self.via_tolerance = Some(tolerance.to_vec());
        self
    }
}

fn missed(limits: &JointBounds, at: f64, miss: f64, most: f64) -> Violation {
    let (name, unit) = (&limits.name, limits.unit_of(0));
    let by = if miss < 1e-3 { format!("{miss:.3e}") } else { format!("{miss:.6}") };
    Violation {
        joint: name.clone(),
        limit: "via_tolerance".to_owned(),
        at,
        value: Some(miss).filter(|miss| miss.is_finite()),
        limit_value: most,
        detail: format!(
            "{name} misses the waypoint due at {at:.6} s by {by} {unit}, more than its tolerance of {most} {unit}"
        ),
    }
}
