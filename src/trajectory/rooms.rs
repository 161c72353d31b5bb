//! How far a motion may pass inner waypoints by.

use super::kernel::KernelLimits;

/// From where to where a joint's position may deviate from a waypoint, rad or m; zero lies in it.
pub type Room = [f64; 2];

/// No room: the waypoint is met exactly.
pub const NONE: Room = [0.0; 2];

/// Rooms at the waypoints of a list; none at its ends, which are always met exactly.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rooms<'a> {
    /// `[waypoint][joint]`; empty if all waypoints are met exactly.
    table: &'a [Vec<Room>],
}

impl<'a> Rooms<'a> {
    /// All waypoints are met exactly.
    pub fn none() -> Self {
        Self { table: &[] }
    }

    /// Those of `table[waypoint][joint]`, whose ends do not count.
    pub fn new(table: &'a [Vec<Room>]) -> Self {
        Self { table }
    }

    /// That of a joint at a waypoint.
    pub fn of(&self, waypoint: usize, joint: usize) -> Room {
        let inner = waypoint > 0 && waypoint + 1 < self.table.len();
        if inner { self.table[waypoint][joint] } else { NONE }
    }

    /// Those of the part of the list that starts and ends at these waypoints.
    pub fn between(&self, first: usize, last: usize) -> Self {
        Self { table: self.table.get(first..=last).unwrap_or_default() }
    }

    /// The same table backwards.
    pub fn reversed(&self) -> Vec<Vec<Room>> {
        self.table.iter().rev().cloned().collect()
    }

    /// Whether all waypoints are met exactly.
    pub fn are_none(&self) -> bool {
        let inner = self.table.get(1..self.table.len().max(2) - 1).unwrap_or_default();
        inner.iter().flatten().all(|room| *room == NONE)
    }
}

/// Rooms of `tolerance` rad or m by joint around `waypoints[waypoint][joint]`, cut to the
/// position limits; a table for [`Rooms`].
pub fn rooms(waypoints: &[Vec<f64>], limits: &[KernelLimits], tolerance: &[f64]) -> Vec<Vec<Room>> {
    let room = |((at, limit), tolerance): ((&f64, &KernelLimits), &f64)| {
        let [lower, upper] = limit.position;
        [(lower - at).max(-tolerance).min(0.0), (upper - at).min(*tolerance).max(0.0)]
    };
    let row = |row: &Vec<f64>| row.iter().zip(limits).zip(tolerance).map(room).collect();
    waypoints.iter().map(row).collect()
}
