//! What the limits admit, whatever the curve: the fastest motion, how short any could be, and which
//! limits hold it back.

use super::prepared::PreparedWaypoints;
use super::result::Sensitivity;
use crate::budget::Budget;
use crate::trajectory::jerk_limited::{Demand, Fastest, fastest_within};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::{DERIVATIVES, JointBounds, LowerBound, Rooms};

/// Savings below this share of the duration, per relative change of a limit, are rounding.
const LEAST_SAVING: f64 = 1e-4;

/// What the limits admit.
pub(super) struct Optimum {
    /// Duration of the fastest lawful motion known, s.
    pub duration: f64,
    /// A proven lower bound on the duration of any.
    pub bound: Option<LowerBound>,
    /// What the fastest motion would gain, most first.
    pub sensitivities: Vec<Sensitivity>,
}

impl Optimum {
    /// Plans the fastest motion through the waypoints of `task` from rest to rest, as far as `budget` allows.
    pub fn find(task: &PreparedWaypoints, limits: &[JointBounds], budget: &Budget) -> Self {
        let rows: Vec<KernelLimits> = limits.iter().map(|limit| limit.kernel(3)).collect();
        let (waypoints, rooms) = (&task.waypoints, task.rooms(limits));
        let rooms = Rooms::new(&rooms);
        let demand = Demand { rooms, ..Demand::new(waypoints, &rows) };
        let found = fastest_within(&demand, budget, &mut |_| {});
        Self::of(&found, waypoints, limits, rooms, [true; 2])
    }

    /// What the fastest motion found says; it must have been planned with all limits.
    /// `rests` says whether it rests at the start, and at the goal.
    pub fn of(
        found: &Fastest,
        waypoints: &[Vec<f64>],
        limits: &[JointBounds],
        rooms: Rooms,
        rests: [bool; 2],
    ) -> Self {
        Self {
            duration: found.trajectory.duration(),
            bound: LowerBound::proven(waypoints, limits, rooms, rests, found.lower),
            sensitivities: sensitivities(found, limits),
        }
    }
}

/// What one percent more of each limit saves, most first; nothing where closed forms join states of
/// motion, which do not tell.
fn sensitivities(found: &Fastest, limits: &[JointBounds]) -> Vec<Sensitivity> {
    let tells = |row: &Vec<[f64; 3]>| row.iter().flatten().any(|gain| *gain > 0.0);
    if !found.gains.iter().all(tells) {
        return Vec::new();
    }
    let least = LEAST_SAVING * found.trajectory.duration();
    let mut all = Vec::new();
    for (joint, limit) in limits.iter().enumerate() {
        for (order, name) in DERIVATIVES.iter().enumerate() {
            // What stands for a limit that does not exist is none that could be raised.
            let saving: f64 = found.gains.iter().map(|row| row[joint][order]).sum();
            if limit.derivatives[order].is_some() && saving > least {
                all.push(Sensitivity {
                    joint: limit.name.clone(),
                    limit: (*name).to_owned(),
                    seconds_per_percent: 0.01 * saving,
                });
            }
        }
    }
    all.sort_by(|a, b| b.seconds_per_percent.total_cmp(&a.seconds_per_percent));
    all
}
