//! A joint's chain of cells in registers: dynamics and limits.

use crate::math::lanes::{Lanes, Mask, Simd, Vector};

use super::problem::{Berth, Cell, Group, Iterate, Problem, speeds_of};

/// Inequalities of a cell: `J T ∓ d`, `A ∓ a'`, `V ∓ v'`, and `V ∓` the middle control
/// point of velocity, all positive.
pub const ROWS: usize = 8;

/// The limits of one register of joints and how acceleration changes in a cell.
#[derive(Clone, Copy)]
pub struct Limits<S: Simd> {
    /// Velocity, acceleration and jerk.
    pub derivatives: [Vector<S>; 3],
    /// One where a lane is a joint, else zero.
    pub real: Vector<S>,
    /// One where jerk is limited, else zero.
    pub smooth: Vector<S>,
    /// What a change of acceleration adds to the position, over `T²`, and to velocity, over `T`.
    pub change: [Vector<S>; 2],
    /// Position since the first waypoint, velocity and acceleration at the start.
    start: [Vector<S>; 3],
}

impl<S: Simd> Limits<S> {
    #[inline(always)]
    fn load(simd: S, group: &Group, part: usize) -> Self {
        let load = |lanes: &Lanes| Vector::load(simd, lanes, part);
        let smooth = load(&group.smooth);
        let half = Vector::splat(simd, 0.5);
        Self {
            derivatives: [load(&group.limits[0]), load(&group.limits[1]), load(&group.limits[2])],
            real: load(&group.real),
            smooth,
            change: [half - smooth * (1.0 / 3.0), Vector::splat(simd, 1.0) - smooth * 0.5],
            start: [load(&group.start[0]), load(&group.start[1]), load(&group.start[2])],
        }
    }
}

/// One register of joints at a point.
#[derive(Clone, Copy)]
pub struct Chain<'a, S: Simd> {
    pub simd: S,
    pub group: usize,
    pub part: usize,
    /// Segments.
    pub segments: usize,
    /// Cells per segment.
    pub cells: usize,
    pub limits: Limits<S>,
    durations: &'a [f64],
    at: &'a [Cell],
    change: &'a [Lanes],
    berths: &'a [Option<Berth>],
    berth_multipliers: &'a [[Lanes; 2]],
    shares: &'a [Lanes],
    speeds: &'a [[Lanes; 2]],
}

impl<'a, S: Simd> Chain<'a, S> {
    /// Register `part` of `group`'s joints.
    #[inline(always)]
    pub fn new(
        simd: S,
        problem: &'a Problem,
        point: &'a Iterate,
        group: usize,
        part: usize,
    ) -> Self {
        let all = problem.segments * problem.cells;
        let own = group * all..(group + 1) * all;
        let segments = group * problem.segments..(group + 1) * problem.segments;
        Self {
            simd,
            group,
            part,
            segments: problem.segments,
            cells: problem.cells,
            limits: Limits::load(simd, &problem.groups[group], part),
            durations: &point.durations,
            at: &point.cells[own.clone()],
            change: &problem.change[segments.clone()],
            berths: &problem.berths[segments.clone()],
            berth_multipliers: &point.berths[segments.clone()],
            shares: &problem.shares[own],
            speeds: &problem.speeds[segments],
        }
    }

    /// Cells of all segments.
    #[inline(always)]
    pub fn all(&self) -> usize {
        self.segments * self.cells
    }

    /// This register of `lanes`.
    #[inline(always)]
    pub fn load(&self, lanes: &Lanes) -> Vector<S> {
        Vector::load(self.simd, lanes, self.part)
    }

    /// A constant.
    #[inline(always)]
    pub fn splat(&self, value: f64) -> Vector<S> {
        Vector::splat(self.simd, value)
    }

    /// Multiplier of inequality `row` of cell `c`.
    #[inline(always)]
    pub fn multiplier(&self, c: usize, row: usize) -> Vector<S> {
        self.load(&self.at[c].z[row])
    }

    /// Whether inequality `row` of cell `c` counts: velocity at the goal is given.
    #[inline(always)]
    pub fn counts(&self, c: usize, row: usize) -> bool {
        c + 1 != self.all() || !(4..6).contains(&row)
    }

    /// Deviations where segment `i` ends; none if all joints meet the waypoint.
    #[inline(always)]
    pub fn room(&self, i: usize) -> Option<Room<S>> {
        let Berth { open, bounds } = self.berths[i].as_ref()?;
        let open = self.splat(0.5).below(self.load(open));
        let deviation =
            self.load(&self.at[(i + 1) * self.cells - 1].s[0]) - self.load(&self.change[i]);
        let slack = [deviation - self.load(&bounds[0]), self.load(&bounds[1]) - deviation];
        let (zero, one) = (self.splat(0.0), self.splat(1.0));
        let [lower, upper] = &self.berth_multipliers[i];
        Some(Room {
            open,
            slack: slack.map(|slack| open.select(slack, one)),
            z: [lower, upper].map(|z| open.select(self.load(z), zero)),
        })
    }

    /// Cell `c`.
    #[inline(always)]
    pub fn view(&self, c: usize) -> View<S> {
        let [x, v, a] = if c == 0 {
            self.limits.start
        } else {
            let [x, v, a] = &self.at[c - 1].s;
            [self.load(x), self.load(v), self.load(a)]
        };
        // From the waypoint on positions count from there: what is left is the deviation, if any.
        let x = if c > 0 && c.is_multiple_of(self.cells) {
            x - self.load(&self.change[c / self.cells - 1])
        } else {
            x
        };
        let [x1, v1, a1] = &self.at[c].s;
        let end = [self.load(x1), self.load(v1), self.load(a1)];
        let share = self.load(&self.shares[c]);
        let t = share * self.durations[c / self.cells];
        let middle = if c == 0 { self.splat(0.0) } else { self.limits.smooth * 0.5 };
        let (one, two) = (self.splat(1.0), self.splat(2.0));
        let last = c + 1 == self.all();
        let room = [
            if c == 0 || last { two } else { one },
            if last { one + self.limits.smooth } else { one },
        ];
        let [at_end, inside] = speeds_of(self.speeds, self.cells, c);
        let speeds = [self.load(at_end), self.load(inside)];
        View { share, t, d: end[2] - a, x, v, a, end, middle, room, speeds }
    }
}

/// Deviations from a waypoint and their bounds.
pub struct Room<S: Simd> {
    /// Which joints may deviate.
    pub open: Mask<S>,
    /// From the lower bound and to the upper one; one where nothing may deviate.
    pub slack: [Vector<S>; 2],
    /// Multipliers of both.
    pub z: [Vector<S>; 2],
}

/// A cell's quantities.
#[derive(Clone, Copy)]
pub struct View<S: Simd> {
    /// Share of the segment's duration.
    pub share: Vector<S>,
    /// Duration.
    pub t: Vector<S>,
    /// Change of acceleration.
    pub d: Vector<S>,
    /// State at the start.
    pub x: Vector<S>,
    pub v: Vector<S>,
    pub a: Vector<S>,
    /// State at the end.
    pub end: [Vector<S>; 3],
    /// Share of `T a` in the middle control point of velocity; none in the first
    /// cell, whose start is given and may lie on a limit.
    pub middle: Vector<S>,
    /// How many times the limits of velocity at the middle control point and of acceleration at the end
    /// count: twice where they bound what the start or the goal gives, which may lie on a limit.
    room: [Vector<S>; 2],
    /// Limits of velocity at the end and in the middle.
    speeds: [Vector<S>; 2],
}

impl<S: Simd> View<S> {
    /// By how much position and velocity miss the dynamics.
    #[inline(always)]
    pub fn residual(&self, limits: &Limits<S>) -> [Vector<S>; 2] {
        let Self { t, d, x, v, a, end, .. } = *self;
        [
            x + t * (v + t * (a * 0.5 + d * limits.change[0])) - end[0],
            v + t * (a + d * limits.change[1]) - end[1],
        ]
    }

    /// The left sides of the inequalities.
    #[inline(always)]
    pub fn slack(&self, limits: &Limits<S>) -> [Vector<S>; ROWS] {
        let middle = self.v + self.t * self.a * self.middle;
        let [_, v1, a1] = self.end;
        let [_, acceleration, jerk] = limits.derivatives;
        let [velocity, most_in_middle] = [self.speeds[0], self.speeds[1] * self.room[0]];
        let acceleration = acceleration * self.room[1];
        let most = jerk * self.t;
        [
            most - self.d,
            most + self.d,
            acceleration - a1,
            acceleration + a1,
            velocity - v1,
            velocity + v1,
            most_in_middle - middle,
            most_in_middle + middle,
        ]
    }

    /// How position and velocity at the end grow with the cell's duration.
    #[inline(always)]
    pub fn along_duration(&self, limits: &Limits<S>) -> [Vector<S>; 2] {
        let Self { t, d, v, a, .. } = *self;
        [v + t * (a + d * limits.change[0] * 2.0), a + d * limits.change[1]]
    }

    /// How position and velocity at the end grow with the change of acceleration.
    #[inline(always)]
    pub fn along_change(&self, limits: &Limits<S>) -> [Vector<S>; 2] {
        [self.t * self.t * limits.change[0], self.t * limits.change[1]]
    }
}

/// The sum over a register's lanes, in order.
#[inline(always)]
pub fn total<S: Simd>(vector: Vector<S>) -> f64 {
    let mut lanes = Lanes::ZERO;
    vector.store(&mut lanes, 0);
    let mut sum = 0.0;
    for lane in lanes.0 {
        sum += lane;
    }
    sum
}
