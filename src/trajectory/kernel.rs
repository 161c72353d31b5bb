//! The hot path: curve and exact peaks of one candidate, eight joints at a time.
//!
//! A candidate is a list of segment durations. Its curve is computed in each
//! segment's own time `u` in [0, 1], where `c0 + c1 u + ... + c5 u^5` is the
//! position; the d-th derivative in seconds is that in `u` over `h^d`. Peaks
//! come from roots, as in the certificate, but for all joints at once and
//! without allocation.

use crate::math::lanes::{Lanes, WIDTH, vectorized};

/// One segment of eight joints: coefficients of `u^0` to `u^5`.
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
            let values: Vec<f64> = limits.iter().map(|limit| limit.position[side]).collect();
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
    /// The curve: `[segment * groups + group]`.
    pub(super) pieces: Vec<Piece>,
    /// Per inner waypoint and group, what a family solves for.
    pub(super) knots: Vec<[Lanes; 2]>,
    /// Per inner waypoint, a family's factorised system.
    pub(super) blocks: Vec<[f64; 8]>,
    /// Ratios of the last call: velocity, acceleration, jerk,
    /// `[segment * groups + group]`.
    ratios: Vec<[Lanes; 3]>,
}

impl Workspace {
    /// Memory for problems of the size of `joints`.
    pub fn new(joints: &JointLanes) -> Self {
        let cells = joints.segments * joints.groups;
        Self {
            pieces: vec![[Lanes::ZERO; 6]; cells],
            knots: vec![[Lanes::ZERO; 2]; cells + joints.groups],
            blocks: vec![[0.0; 8]; joints.segments],
            ratios: vec![[Lanes::ZERO; 3]; cells],
        }
    }

    /// Peak over limit of `order` (0 velocity, 1 acceleration, 2 jerk) in a
    /// segment, as the last [`Kernel::ratios`] found it.
    pub fn ratio(&self, joints: &JointLanes, segment: usize, joint: usize, order: usize) -> f64 {
        self.ratios[segment * joints.groups + joint / WIDTH][order][joint % WIDTH]
    }

    /// The largest ratio of a segment over all joints: velocity, acceleration, jerk.
    pub fn segment_ratios(&self, joints: &JointLanes, segment: usize) -> [f64; 3] {
        let cells = &self.ratios[segment * joints.groups..(segment + 1) * joints.groups];
        let mut worst = [0.0f64; 3];
        for cell in cells {
            for (worst, ratio) in worst.iter_mut().zip(cell) {
                *worst = worst.max(ratio.largest());
            }
        }
        worst
    }

    /// The ratios of the last [`Kernel::ratios`], cell by cell.
    pub fn all_ratios(&self) -> &[[Lanes; 3]] {
        &self.ratios
    }
}

/// A family of curves through waypoints, given the durations between them.
pub trait Family: Send + Sync {
    /// Highest power in any segment: 3 or 5.
    const DEGREE: usize;

    /// Fills `work.pieces` for these durations, s.
    fn fit(joints: &JointLanes, durations: &[f64], work: &mut Workspace);
}

/// What the timing problem asks of a family of curves.
pub trait Kernel: Send + Sync {
    /// The smallest multiple of `durations` that keeps all derivative limits:
    /// the scaling law's `s*`.
    fn scale(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) -> f64;

    /// Peaks over limits of every segment, joint and derivative, into `work`.
    fn ratios(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace);

    /// By how much the curve of the last call leaves the position limits,
    /// rad or m; zero or less if it does not. Scaling does not change it.
    fn position_excess(&self, joints: &JointLanes, work: &Workspace) -> f64;

    /// The curve alone, into `work`.
    fn fit(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace);

    /// Joint `joint`'s coefficients in ascending powers of time in a segment
    /// of the curve last computed.
    fn coefficients(
        &self,
        joints: &JointLanes,
        durations: &[f64],
        work: &Workspace,
        segment: usize,
        joint: usize,
    ) -> Vec<f64>;
}

impl<F: Family> Kernel for F {
    fn scale(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) -> f64 {
        vectorized(
            #[inline(always)]
            || {
                F::fit(joints, durations, work);
                scale::<F>(joints, durations, work)
            },
        )
    }

    fn ratios(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        vectorized(
            #[inline(always)]
            || {
                F::fit(joints, durations, work);
                for segment in 0..joints.segments {
                    let inverse = 1.0 / durations[segment];
                    for group in 0..joints.groups {
                        let cell = segment * joints.groups + group;
                        let curve = Curve::new(&work.pieces[cell]);
                        let mut peaks = curve.slow_peaks::<F>();
                        peaks[0] = peaks[0].max(curve.velocity_peak::<F>());
                        work.ratios[cell] = over_limits(joints, group, inverse, peaks);
                    }
                }
            },
        );
    }

    fn position_excess(&self, joints: &JointLanes, work: &Workspace) -> f64 {
        let Some(position) = &joints.position else { return f64::NEG_INFINITY };
        vectorized(
            #[inline(always)]
            || {
                let mut worst = f64::NEG_INFINITY;
                for (cell, piece) in work.pieces.iter().enumerate() {
                    let [lower, upper] = position[cell % joints.groups];
                    let [least, most] = position_hull(piece);
                    // The control points enclose the curve: mostly that settles it.
                    if (least - lower).min(upper - most).below(Lanes::ZERO).any() {
                        let [least, most] = Curve::new(piece).position_range::<F>(piece);
                        worst = (lower - least).max(most - upper).largest().max(worst);
                    }
                }
                worst
            },
        )
    }

    fn fit(&self, joints: &JointLanes, durations: &[f64], work: &mut Workspace) {
        vectorized(
            #[inline(always)]
            || F::fit(joints, durations, work),
        );
    }

    fn coefficients(
        &self,
        joints: &JointLanes,
        durations: &[f64],
        work: &Workspace,
        segment: usize,
        joint: usize,
    ) -> Vec<f64> {
        let piece = &work.pieces[segment * joints.groups + joint / WIDTH];
        let mut power = 1.0;
        let in_time = piece[..=F::DEGREE].iter().map(|c| {
            let coefficient = c[joint % WIDTH] / power;
            power *= durations[segment];
            coefficient
        });
        in_time.collect()
    }
}

/// Peaks in `u` as ratios to the limits in seconds; `inverse` is `1 / h`.
#[inline(always)]
fn over_limits(joints: &JointLanes, group: usize, inverse: f64, peaks: [Lanes; 3]) -> [Lanes; 3] {
    let [velocity, acceleration, jerk] = &joints.inverse_limits;
    [
        peaks[0] * velocity[group] * inverse,
        peaks[1] * acceleration[group] * (inverse * inverse),
        peaks[2] * jerk[group] * (inverse * inverse * inverse),
    ]
}

/// The scale that velocity, acceleration and jerk ratios ask for.
#[inline(always)]
fn scale_of(worst: [f64; 3]) -> f64 {
    worst[0].max(worst[1].sqrt()).max(libm::cbrt(worst[2]))
}

#[inline(always)]
fn scale<F: Family>(joints: &JointLanes, durations: &[f64], work: &Workspace) -> f64 {
    let mut worst = [Lanes::ZERO; 3];
    for segment in 0..joints.segments {
        let inverse = 1.0 / durations[segment];
        for group in 0..joints.groups {
            let curve = Curve::new(&work.pieces[segment * joints.groups + group]);
            let ratios = over_limits(joints, group, inverse, curve.slow_peaks::<F>());
            for order in 0..3 {
                worst[order] = worst[order].max(ratios[order]);
            }
        }
    }
    let mut scale = scale_of(worst.map(Lanes::largest));
    // Inside a segment speed peaks at roots of a cubic, the dear part. The
    // control points bound it, so only segments that may matter are looked at.
    for segment in 0..joints.segments {
        let inverse = 1.0 / durations[segment];
        for group in 0..joints.groups {
            let curve = Curve::new(&work.pieces[segment * joints.groups + group]);
            let unit = joints.inverse_limits[0][group] * inverse;
            if (curve.velocity_bound() * unit).largest() > scale {
                scale = scale.max((curve.velocity_peak::<F>() * unit).largest());
            }
        }
    }
    scale
}

/// Derivatives of a segment in `u`: velocity `v0 + v1 u + ...`, acceleration
/// `a0 + ... + a3 u^3`.
struct Curve {
    velocity: [Lanes; 5],
    acceleration: [Lanes; 4],
}

impl Curve {
    #[inline(always)]
    fn new(c: &Piece) -> Self {
        Self {
            velocity: [c[1], c[2] * 2.0, c[3] * 3.0, c[4] * 4.0, c[5] * 5.0],
            acceleration: [c[2] * 2.0, c[3] * 6.0, c[4] * 12.0, c[5] * 20.0],
        }
    }

    /// Jerk at `u`.
    #[inline(always)]
    fn jerk(&self, u: Lanes) -> Lanes {
        let [_, a1, a2, a3] = self.acceleration;
        (a3 * 3.0 * u + a2 * 2.0) * u + a1
    }

    /// Where acceleration turns, ascending; zero where it does not inside (0, 1).
    #[inline(always)]
    fn turns(&self) -> [Lanes; 2] {
        let [_, a1, a2, a3] = self.acceleration;
        let discriminant = a2 * a2 - a1 * a3 * 3.0;
        let root = discriminant.max(Lanes::ZERO).sqrt();
        // The two sums of equal signs: nothing cancels.
        let negative = a2.below(Lanes::ZERO);
        let q = negative.select(root - a2, -(root + a2));
        let first = inside(q / (a3 * 3.0));
        let second = inside(a1 / q);
        [first.min(second), first.max(second)]
    }

    /// Peaks that cost no iteration: speed at the ends, acceleration, jerk.
    #[inline(always)]
    fn slow_peaks<F: Family>(&self) -> [Lanes; 3] {
        let one = Lanes::splat(1.0);
        let speed = self.velocity[0].abs().max(horner(&self.velocity, one).abs());
        let [a0, a1, a2, a3] = self.acceleration;
        if F::DEGREE == 3 {
            let acceleration = a0.abs().max((a0 + a1).abs());
            return [speed, acceleration, a1.abs()];
        }
        let mut acceleration = a0.abs().max(horner(&self.acceleration, one).abs());
        for turn in self.turns() {
            acceleration = acceleration.max(horner(&self.acceleration, turn).abs());
        }
        let vertex = inside(-a2 / (a3 * 3.0));
        let jerk = a1.abs().max(self.jerk(one).abs()).max(self.jerk(vertex).abs());
        [speed, acceleration, jerk]
    }

    /// Largest speed inside the segment, where acceleration is zero.
    #[inline(always)]
    fn velocity_peak<F: Family>(&self) -> Lanes {
        let mut peak = Lanes::ZERO;
        if F::DEGREE == 3 {
            let turn = inside(-self.acceleration[0] / self.acceleration[1]);
            return peak.max(horner(&self.velocity, turn).abs());
        }
        for root in self.acceleration_roots() {
            peak = peak.max(horner(&self.velocity, root).abs());
        }
        peak
    }

    /// Roots of acceleration, ascending; an interval's start where it holds none.
    #[inline(always)]
    fn acceleration_roots(&self) -> [Lanes; 3] {
        let [low, high] = self.turns();
        let breaks = [Lanes::ZERO, low, high, Lanes::splat(1.0)];
        monotone_roots(&self.acceleration, breaks)
    }

    /// The control points of speed (Bernstein form) bound it.
    #[inline(always)]
    fn velocity_bound(&self) -> Lanes {
        let [v0, v1, v2, v3, v4] = self.velocity;
        let b1 = v0 + v1 * 0.25;
        let b2 = v0 + v1 * 0.5 + v2 * (1.0 / 6.0);
        let b3 = v0 + v1 * 0.75 + v2 * 0.5 + v3 * 0.25;
        let b4 = v0 + v1 + v2 + v3 + v4;
        v0.abs().max(b1.abs()).max(b2.abs()).max(b3.abs()).max(b4.abs())
    }

    /// Smallest and largest position, from the roots of velocity.
    #[inline(always)]
    fn position_range<F: Family>(&self, piece: &Piece) -> [Lanes; 2] {
        let one = Lanes::splat(1.0);
        let end = horner(piece, one);
        let mut range = [piece[0].min(end), piece[0].max(end)];
        let [r0, r1, r2] = if F::DEGREE == 3 {
            [inside(-self.acceleration[0] / self.acceleration[1]), one, one]
        } else {
            self.acceleration_roots()
        };
        let breaks = [Lanes::ZERO, r0, r0.max(r1), r0.max(r1).max(r2), one];
        let roots: [Lanes; 4] = monotone_roots(&self.velocity, breaks);
        for root in roots {
            let position = horner(piece, root);
            range = [range[0].min(position), range[1].max(position)];
        }
        range
    }
}

/// The control points of position (Bernstein form) enclose it.
#[inline(always)]
fn position_hull(c: &Piece) -> [Lanes; 2] {
    let points = [
        c[0],
        c[0] + c[1] * 0.2,
        c[0] + c[1] * 0.4 + c[2] * 0.1,
        c[0] + c[1] * 0.6 + c[2] * 0.3 + c[3] * 0.1,
        c[0] + c[1] * 0.8 + c[2] * 0.6 + c[3] * 0.4 + c[4] * 0.2,
        c[0] + c[1] + c[2] + c[3] + c[4] + c[5],
    ];
    let mut hull = [points[0], points[0]];
    for point in points {
        hull = [hull[0].min(point), hull[1].max(point)];
    }
    hull
}

/// `u` where it lies inside (0, 1), else zero; not-a-number counts as outside.
#[inline(always)]
fn inside(u: Lanes) -> Lanes {
    let lawful = Lanes::ZERO.below(u).and(u.below(Lanes::splat(1.0)));
    lawful.select(u, Lanes::ZERO)
}

#[inline(always)]
fn horner<const N: usize>(c: &[Lanes; N], u: Lanes) -> Lanes {
    let mut sum = c[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum * u + c[k];
    }
    sum
}

/// Value and slope at `u`.
#[inline(always)]
fn horner_slope<const N: usize>(c: &[Lanes; N], u: Lanes) -> (Lanes, Lanes) {
    let mut sum = c[N - 1];
    let mut slope = Lanes::ZERO;
    for k in (0..N - 1).rev() {
        slope = slope * u + sum;
        sum = sum * u + c[k];
    }
    (sum, slope)
}

/// The root in each interval between neighbouring `breaks`, where the
/// polynomial is monotone; the interval's start where the sign does not change.
///
/// Newton's method inside a shrinking bracket, for all intervals side by side.
/// The roots serve as places of extrema, where an error of `e` shifts the value
/// by the order of `e^2`: at 1e-8 the extremum is exact to rounding.
#[inline(always)]
fn monotone_roots<const N: usize, const B: usize, const R: usize>(
    c: &[Lanes; N],
    breaks: [Lanes; B],
) -> [Lanes; R] {
    const { assert!(B == R + 1) };
    let values: [Lanes; B] = each(|b| horner(c, breaks[b]));
    let mut low: [Lanes; R] = each(|r| breaks[r]);
    let mut high: [Lanes; R] = each(|r| breaks[r + 1]);
    // +1 where the polynomial rises through its root, -1 where it falls.
    let rising: [Lanes; R] =
        each(|r| values[r].below(values[r + 1]).select(Lanes::splat(1.0), Lanes::splat(-1.0)));
    let crossing: [_; R] = each_mask(|r| {
        (values[r] * rising[r]).below(Lanes::ZERO).and(Lanes::ZERO.below(values[r + 1] * rising[r]))
    });
    for r in 0..R {
        high[r] = crossing[r].select(high[r], low[r]);
    }
    if !crossing.iter().fold(false, |any, mask| any | mask.any()) {
        return low;
    }
    let mut u: [Lanes; R] = each(|r| {
        let secant = low[r] - values[r] * (high[r] - low[r]) / (values[r + 1] - values[r]);
        crossing[r].select(secant, low[r])
    });
    for _ in 0..60 {
        let mut widest = Lanes::ZERO;
        for r in 0..R {
            let (value, slope) = horner_slope(c, u[r]);
            let under = (value * rising[r]).below(Lanes::ZERO);
            low[r] = under.select(u[r], low[r]);
            high[r] = under.select(high[r], u[r]);
            let newton = u[r] - value / slope;
            let lawful = low[r].below(newton).and(newton.below(high[r]));
            let next = lawful.select(newton, (low[r] + high[r]) * 0.5);
            let next = crossing[r].select(next, u[r]);
            widest = widest.max((next - u[r]).abs());
            u[r] = next;
        }
        if widest.largest() < 1e-8 {
            break;
        }
    }
    u
}

#[inline(always)]
fn each<const R: usize>(f: impl Fn(usize) -> Lanes) -> [Lanes; R] {
    let mut out = [Lanes::ZERO; R];
    for (index, value) in out.iter_mut().enumerate() {
        *value = f(index);
    }
    out
}

#[inline(always)]
fn each_mask<const R: usize>(
    f: impl Fn(usize) -> crate::math::lanes::Mask,
) -> [crate::math::lanes::Mask; R] {
    std::array::from_fn(f)
}
