//! The programme that the interior point method solves, in units of its own.

use crate::math::lanes::Lanes;
use crate::trajectory::Ends;
use crate::trajectory::rooms::Rooms;

use super::speeds::Bounds;

/// Stands for a limit that does not exist: far enough to take no part.
pub const FREE: f64 = 1e12;

/// What is planned at once.
pub struct Window<'a> {
    /// `[segment][joint]`, from waypoint to waypoint.
    pub ways: &'a [Vec<f64>],
    pub limits: Bounds<'a>,
    pub rooms: Rooms<'a>,
    pub ends: &'a Ends,
    /// Each joint's position since the first waypoint where the motion starts.
    pub from: &'a [f64],
}

impl Window<'_> {
    /// The ways from the middle of one room to that of the next.
    pub fn between_middles(&self) -> Vec<Vec<f64>> {
        let middle = |at: usize, joint: usize| {
            let [lower, upper] = self.rooms.of(at, joint);
            if at == 0 { self.from[joint] } else { 0.5 * (lower + upper) }
        };
        let row = |(segment, row): (usize, &Vec<f64>)| {
            let joints = row.iter().enumerate();
            joints
                .map(|(joint, way)| way + middle(segment + 1, joint) - middle(segment, joint))
                .collect()
        };
        self.ways.iter().enumerate().map(row).collect()
    }
}

/// Eight joints' limits and ends, each joint in its own unit of length.
#[derive(Clone, Debug)]
pub struct Group {
    /// Lanes that are joints, always the first ones.
    pub used: usize,
    /// One where a lane is a joint, else zero.
    pub real: Lanes,
    /// Limits of velocity, acceleration and jerk.
    pub limits: [Lanes; 3],
    /// One where jerk is limited, else zero: then acceleration jumps at the
    /// start of a cell and is constant in it.
    pub smooth: Lanes,
    /// Position since the first waypoint, velocity and acceleration at the start.
    pub start: [Lanes; 3],
    /// Those at the goal; the last cell of every point ends with them.
    pub goal: [Lanes; 2],
}

/// From where to where eight joints' positions may deviate from a waypoint.
#[derive(Clone, Debug)]
pub struct Berth {
    /// One where a lane is a joint that may deviate, else zero.
    pub open: Lanes,
    /// Lower and upper bound; those of a joint that may not are of no meaning and not zero.
    pub bounds: [Lanes; 2],
}

/// Waypoints and limits, laid out for the interior point method.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Segments between waypoints.
    pub segments: usize,
    /// Cells per segment.
    pub cells: usize,
    /// Eight joints each.
    pub groups: Vec<Group>,
    /// Way of each segment: `[group * segments + segment]`.
    pub change: Vec<Lanes>,
    /// Where each segment ends, in the same order; none where every joint meets the waypoint.
    pub berths: Vec<Option<Berth>>,
    /// Limit of velocity in each segment and where it ends, in the same order; the latter is the lower of both
    /// segments that meet there.
    pub speeds: Vec<[Lanes; 2]>,
    /// Each cell's share of its segment's duration, joint by joint: `[group][segment][cell]`.
    pub shares: Vec<Lanes>,
}

impl Problem {
    /// Limits of velocity at the end of cell `c` and in its middle.
    pub fn speeds_of(&self, group: usize, c: usize) -> [&Lanes; 2] {
        speeds_of(&self.speeds[group * self.segments..], self.cells, c)
    }
}

/// The same from one group's [`Problem::speeds`].
#[inline(always)]
pub fn speeds_of(speeds: &[[Lanes; 2]], cells: usize, c: usize) -> [&Lanes; 2] {
    let [inside, at_end] = &speeds[c / cells];
    [if (c + 1).is_multiple_of(cells) { at_end } else { inside }, inside]
}

/// One cell of eight joints.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Position since the last waypoint, velocity and acceleration at the cell's end.
    pub s: [Lanes; 3],
    /// Multipliers of the cell's inequalities, see [`super::chain`].
    pub z: [Lanes; 8],
}

impl Cell {
    /// All zero.
    pub const ZERO: Self = Self { s: [Lanes::ZERO; 3], z: [Lanes::ZERO; 8] };
}

/// A primal and dual point.
#[derive(Clone, Debug)]
pub struct Iterate {
    /// Duration of each segment.
    pub durations: Vec<f64>,
    /// `[group][segment][cell]`.
    pub cells: Vec<Cell>,
    /// Multiplier of each segment's way: `[group * segments + segment]`; zero where the position at its end
    /// is a variable.
    pub lambda: Vec<Lanes>,
    /// Multipliers of the lower and the upper bound on deviations where segments end, in the same order.
    pub berths: Vec<[Lanes; 2]>,
    /// Multipliers of the goal's velocity and acceleration, per group.
    pub goal: Vec<[Lanes; 2]>,
}
