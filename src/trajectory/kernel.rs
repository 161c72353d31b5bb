//! The hot path: curve and exact peaks of one candidate, eight joints at a time.
//!
//! A candidate is a list of segment durations. Its curve is one polynomial
//! piece per segment, or several where a family splits segments, each computed
//! in its own time `u` in [0, 1], where `c0 + c1 u + ... + c5 u^5` is the
//! position; the d-th derivative in seconds is that in `u` over `h^d`, with `h`
//! the duration of the piece. Peaks come from roots, as in the certificate, but
//! for all joints at once and without allocation.

use std::marker::PhantomData;

use pulp::{Arch, WithSimd};

use super::certificate::LAWFUL_TOLERANCE;
use super::curve::Curve;
use super::polynomial_trajectory::Trajectory;
use crate::math::lanes::{Lanes, Simd, Vector, WIDTH, registers};

/// How far a curve may pass a position limit, relative to the limit or to 1:
/// by rounding alone where a waypoint lies on it. Below what the certificate allows.
const POSITION_SLACK: f64 = 0.1 * LAWFUL_TOLERANCE;

/// One piece of eight joints: coefficients of `u^0` to `u^5`.
pub type Piece = [Lanes; 6];

/// Waypoints and limits of a timing problem, laid out for the kernel.
#[derive(Clone, Debug)]
pub struct JointLanes {
    dof: usize,
    groups: usize,
    segments: usize,
    /// Position at each waypoint: `[waypoint * groups + group]`.
    pub(super) start: Vec<Lanes>,
    /// Way to the next waypoint: `[segment * groups + group]`.
    pub(super) change: Vec<Lanes>,
    /// Per group, the inverse limits of velocity, acceleration and jerk; zero
    /// where there is no limit.
    inverse_limits: [Vec<Lanes>; 3],
    /// Per group, lower and upper position limits; none if there are none.
    position: Option<Vec<[Lanes; 2]>>,
}

/// One joint's limits as the kernel takes them; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelLimits {
    /// Velocity, acceleration and jerk.
    pub derivatives: [f64; 3],
    /// Lower and upper position.
    pub position: [f64; 2],
}

impl JointLanes {
    /// Lays out `waypoints[waypoint][joint]` and one limit set per joint.
    pub fn new(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Self {
        let dof = limits.len();
        let groups = dof.div_ceil(WIDTH);
        let group_of = |values: &[f64], group: usize, fill: f64| {
            Lanes::from_slice(&values[group * WIDTH..dof.min((group + 1) * WIDTH)], fill)
        };
        let layout = |rows: &[Vec<f64>]| -> Vec<Lanes> {
            let row = |row: &Vec<f64>| (0..groups).map(|g| group_of(row, g, 0.0)).collect();
            rows.iter().flat_map::<Vec<Lanes>, _>(row).collect()
        };
        let change = |pair: &[Vec<f64>]| -> Vec<f64> {
            pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect()
        };
        let changes: Vec<Vec<f64>> = waypoints.windows(2).map(change).collect();
        let inverse = |order: usize| -> Vec<Lanes> {
            let values: Vec<f64> =
                limits.iter().map(|limit| 1.0 / limit.derivatives[order]).collect();
            (0..groups).map(|group| group_of(&values, group, 0.0)).collect()
        };
        let bound = |side: usize, group: usize| {
            let outwards = if side == 0 { -POSITION_SLACK } else { POSITION_SLACK };
            let widened = |limit: f64| limit + outwards * limit.abs().max(1.0);
            let values: Vec<f64> =
                limits.iter().map(|limit| widened(limit.position[side])).collect();
            group_of(&values, group, if side == 0 { f64::NEG_INFINITY } else { f64::INFINITY })
        };
        let limited = limits.iter().any(|limit| limit.position.iter().any(|p| p.is_finite()));
        Self {
            dof,
            groups,
            segments: changes.len(),
            start: layout(waypoints),
            change: layout(&changes),
            inverse_limits: [inverse(0), inverse(1), inverse(2)],
            position: limited
                .then(|| (0..groups).map(|group| [bound(0, group), bound(1, group)]).collect()),
        }
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Groups of eight joints.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Segments between waypoints.
    pub fn segments(&self) -> usize {
        self.segments
    }
}

/// Working memory of one evaluating thread.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The curve: `[piece * groups + group]`.
    pub(super) pieces: Vec<Piece>,
    /// The first piece of each segment, and the number of pieces.
    first: Vec<usize>,
    /// Per inner waypoint and group, what a family solves for.
    pub(super) knots: Vec<[Lanes; 2]>,
    /// Per inner waypoint, a family's factorised system.
    pub(super) blocks: Vec<[f64; 8]>,
    /// Ratios of the last call: velocity, acceleration, jerk, each to its lower
    /// and its upper side; `[piece * groups + group]`.
    ratios: Vec<[[Lanes; 2]; 3]>,
}

impl Workspace {
    /// Memory for a family's curves through the waypoints of `joints`.
    fn new<F: Family>(joints: &JointLanes) -> Self {
        let mut pieces = 0;
        let mut first = vec![0];
        for segment in 0..joints.segments {
            pieces += F::shares(segment, joints.segments).len();
            first.push(pieces);
        }
        let cells = pieces * joints.groups;
        Self {
            pieces: vec![[Lanes::ZERO; 6]; cells],
            first,
            knots: vec![[Lanes::ZERO; 2]; (joints.segments + 1) * joints.groups],
            blocks: vec![[0.0; 8]; joints.segments],
            ratios: vec![[[Lanes::ZERO; 2]; 3]; cells],
        }
    }

    /// Cells of a segment's pieces.
    fn cells(&self, joints: &JointLanes, segment: usize) -> std::ops::Range<usize> {
        self.first[segment] * joints.groups..self.first[segment + 1] * joints.groups
    }

    /// Peak over limit of `order` (0 velocity, 1 acceleration, 2 jerk) in a
    /// segment, as the last [`Kernel::ratios`] found it.
    pub fn ratio(&self, joints: &JointLanes, segment: usize, joint: usize, order: usize) -> f64 {
        let cells = &self.ratios[self.cells(joints, segment)];
        let of_joint = cells.iter().skip(joint / WIDTH).step_by(joints.groups);
        let sides = of_joint.flat_map(|cell| cell[order].map(|side| side.0[joint % WIDTH]));
        sides.fold(0.0, f64::max)
    }

    /// The largest ratio of a segment over all joints: velocity, acceleration, jerk.
    pub fn segment_ratios(&self, joints: &JointLanes, segment: usize) -> [f64; 3] {
        let cells = &self.ratios[self.cells(joints, segment)];
        let mut worst = [0.0f64; 3];
        for cell in cells {
            for (worst, [lower, upper]) in worst.iter_mut().zip(cell) {
                *worst = worst.max(lower.largest()).max(upper.largest());
            }
        }
        worst
    }

    /// All ratios of the last [`Kernel::ratios`], one list per derivative. The
    /// two sides are apart, and so are the pieces of a segment: peaks that bind
    /// together would otherwise make one function with a kink.
    pub fn collect(&self, joints: &JointLanes, lists: &mut [Vec<f64>; 3]) {
        for (order, list) in lists.iter_mut().enumerate() {
            list.clear();
            for (index, cell) in self.ratios.iter().enumerate() {
                let used = (joints.dof - index % joints.groups * WIDTH).min(WIDTH);
                for side in &cell[order] {
                    list.extend_from_slice(&side.0[..used]);
                }
            }
        }
    }
}

/// A family of curves through waypoints, given the durations between them.
pub trait Family: Send + Sync {
    /// Highest power in any piece: 3, 4 or 5.
    const DEGREE: usize;

    /// The shares of a segment's duration that its pieces take, in order. They
    /// sum to 1; one piece fills the segment unless the family splits it.
    #[inline(always)]
    fn shares(_segment: usize, _segments: usize) -> &'static [f64] {
        &[1.0]
    }

    /// Computes what does not depend on durations, once for a workspace.
    fn prepare(_joints: &JointLanes, _work: &mut Workspace) {}

    /// Fills `work.pieces` for these durations, s.
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace);
}

/// What the timing problem asks of a family of curves.
pub trait Kernel: Send + Sync {
    /// Working memory for curves through the waypoints of `joints`.
    fn workspace(&self, joints: &JointLanes) -> Workspace;

    /// The smallest multiple of `durations` that keeps all derivative limits:
    /// the scaling law's `s*`.
    fn scale(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) -> f64;

    /// Peaks over limits of every segment, joint and derivative, into `work`.
    fn ratios(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace);

    /// By how much the curve of the last call leaves the position limits,
    /// rad or m; zero or less if it does not. Scaling does not change it.
    fn position_excess(&self, joints: &JointLanes, work: &Workspace) -> f64;

    /// [`Family::shares`].
    fn shares(&self, segment: usize, segments: usize) -> &'static [f64];

    /// The curve as a trajectory; it is also left in `work`.
    fn trajectory(
        &self,
        joints: &JointLanes,
        durations: &[f64],
        work: &mut Workspace,
    ) -> Trajectory;
}

impl<F: Family> Kernel for F {
    fn workspace(&self, joints: &JointLanes) -> Workspace {
        let mut work = Workspace::new::<F>(joints);
        F::prepare(joints, &mut work);
        work
    }

    fn scale(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) -> f64 {
        Arch::new().dispatch(Scale::<F> { joints, durations, work, family: PhantomData })
    }

    fn ratios(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        Arch::new().dispatch(Ratios::<F> { joints, durations, work, family: PhantomData });
    }

    fn shares(&self, segment: usize, segments: usize) -> &'static [f64] {
        F::shares(segment, segments)
    }

    fn position_excess(&self, joints: &JointLanes, work: &Workspace) -> f64 {
        let Some(position) = &joints.position else { return f64::NEG_INFINITY };
        Arch::new().dispatch(Excess::<F> { joints, position, work, family: PhantomData })
    }

    fn trajectory(
        &self,
        joints: &JointLanes,
        durations: &[f64],
        work: &mut Workspace,
    ) -> Trajectory {
        F::fit(joints, durations, work);
        let (mut breakpoints, mut pieces) = (vec![0.0], Vec::new());
        let mut start = 0.0;
        for (segment, duration) in durations.iter().enumerate() {
            let mut passed = 0.0;
            for share in F::shares(segment, joints.segments) {
                passed += share;
                breakpoints.push(start + passed * duration);
                let row = &work.pieces[pieces.len() * joints.groups..];
                let joint = |j: usize| in_time::<F>(&row[j / WIDTH], j % WIDTH, share * duration);
                pieces.push((0..joints.dof).map(joint).collect());
            }
            start += duration;
        }
        Trajectory { breakpoints, pieces }
    }
}

/// One joint's coefficients in ascending powers of time in a piece that lasts
/// `duration`.
fn in_time<F: Family>(piece: &Piece, lane: usize, duration: f64) -> Vec<f64> {
    let mut power = 1.0;
    let coefficient = |c: &Lanes| {
        let coefficient = c.0[lane] / power;
        power *= duration;
        coefficient
    };
    piece[..=F::DEGREE].iter().map(coefficient).collect()
}

/// [`Kernel::scale`] for the machine's registers.
struct Scale<'a, F> {
    joints: &'a JointLanes,
    durations: &'a [f64],
    work: &'a mut Workspace,
    family: PhantomData<F>,
}

impl<F: Family> WithSimd for Scale<'_, F> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { joints, durations, work, .. } = self;
        F::fit(joints, durations, work);
        let zero = Vector::splat(simd, 0.0);
        let mut worst = [zero; 3];
        joints.each_register::<F, S>(
            durations,
            #[inline(always)]
            |cell, part, inverse| {
                let curve = Curve::new(simd, &work.pieces[cell.index], part);
                let [velocity, acceleration, jerk] = curve.cheap_ranges::<F>();
                let peaks = [velocity.peak(), acceleration.peak(), jerk.peak()];
                let ratios = joints.over_limits(simd, cell, part, inverse, peaks);
                for order in 0..3 {
                    worst[order] = worst[order].max(ratios[order]);
                }
            },
        );
        let [velocity, acceleration, jerk] =
            [worst[0].largest(), worst[1].largest(), worst[2].largest()];
        let mut scale = velocity.max(acceleration.sqrt()).max(libm::cbrt(jerk));
        // Inside a piece speed peaks at roots of a cubic, the dear part. The
        // control points bound it, so only pieces that may matter are looked at.
        joints.each_register::<F, S>(
            durations,
            #[inline(always)]
            |cell, part, inverse| {
                let curve = Curve::new(simd, &work.pieces[cell.index], part);
                let unit =
                    Vector::load(simd, &joints.inverse_limits[0][cell.group], part) * inverse;
                if (curve.velocity_bound() * unit).largest() > scale {
                    scale = scale.max((curve.velocity_range::<F>().peak() * unit).largest());
                }
            },
        );
        scale
    }
}

/// [`Kernel::ratios`] for the machine's registers.
struct Ratios<'a, F> {
    joints: &'a JointLanes,
    durations: &'a [f64],
    work: &'a mut Workspace,
    family: PhantomData<F>,
}

impl<F: Family> WithSimd for Ratios<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { joints, durations, work, .. } = self;
        F::fit(joints, durations, work);
        let Workspace { pieces, ratios, .. } = work;
        joints.each_register::<F, S>(
            durations,
            #[inline(always)]
            |cell, part, inverse| {
                let curve = Curve::new(simd, &pieces[cell.index], part);
                let mut ranges = curve.cheap_ranges::<F>();
                ranges[0] = ranges[0].join(curve.velocity_range::<F>());
                let lower = [-ranges[0].low, -ranges[1].low, -ranges[2].low];
                let upper = [ranges[0].high, ranges[1].high, ranges[2].high];
                let lower = joints.over_limits(simd, cell, part, inverse, lower);
                let upper = joints.over_limits(simd, cell, part, inverse, upper);
                let zero = Vector::splat(simd, 0.0);
                for order in 0..3 {
                    let [low, high] = &mut ratios[cell.index][order];
                    lower[order].max(zero).store(low, part);
                    upper[order].max(zero).store(high, part);
                }
            },
        );
    }
}

/// [`Kernel::position_excess`] for the machine's registers.
struct Excess<'a, F> {
    joints: &'a JointLanes,
    position: &'a [[Lanes; 2]],
    work: &'a Workspace,
    family: PhantomData<F>,
}

impl<F: Family> WithSimd for Excess<'_, F> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { joints, position, work, .. } = self;
        let mut worst = f64::NEG_INFINITY;
        for (index, piece) in work.pieces.iter().enumerate() {
            let group = index % joints.groups;
            for part in 0..joints.registers::<S>(group) {
                let [lower, upper] = &position[group];
                let lower = Vector::load(simd, lower, part);
                let upper = Vector::load(simd, upper, part);
                let curve = Curve::new(simd, piece, part);
                // The control points enclose the curve: mostly that settles it.
                let [least, most] = curve.position_hull();
                if (lower - least).max(most - upper).largest() > 0.0 {
                    let [least, most] = curve.position_range::<F>();
                    worst = (lower - least).max(most - upper).largest().max(worst);
                }
            }
        }
        worst
    }
}

/// Where a piece of eight joints stands.
#[derive(Clone, Copy)]
struct Cell {
    /// `piece * groups + group`.
    index: usize,
    group: usize,
}

impl JointLanes {
    /// Registers that hold the joints of `group`.
    #[inline(always)]
    fn registers<S: Simd>(&self, group: usize) -> usize {
        registers::<S>(self.dof - group * WIDTH)
    }

    /// Calls `f` with every cell, register and inverse duration of the piece.
    #[inline(always)]
    fn each_register<F: Family, S: Simd>(
        &self,
        durations: &[f64],
        mut f: impl FnMut(Cell, usize, f64),
    ) {
        let mut index = 0;
        for (segment, duration) in durations.iter().enumerate() {
            for share in F::shares(segment, self.segments) {
                let inverse = 1.0 / (duration * share);
                for group in 0..self.groups {
                    for part in 0..self.registers::<S>(group) {
                        f(Cell { index, group }, part, inverse);
                    }
                    index += 1;
                }
            }
        }
    }

    /// Peaks in `u` as ratios to the limits in seconds; `inverse` is `1 / h`.
    #[inline(always)]
    fn over_limits<S: Simd>(
        &self,
        simd: S,
        cell: Cell,
        part: usize,
        inverse: f64,
        peaks: [Vector<S>; 3],
    ) -> [Vector<S>; 3] {
        let [velocity, acceleration, jerk] = &self.inverse_limits;
        let group = cell.group;
        [
            peaks[0] * Vector::load(simd, &velocity[group], part) * inverse,
            peaks[1] * Vector::load(simd, &acceleration[group], part) * (inverse * inverse),
            peaks[2] * Vector::load(simd, &jerk[group], part) * (inverse * inverse * inverse),
        ]
    }
}
