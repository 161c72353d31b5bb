//! The hot kernel: sixteen configurations at once, in single precision.
//!
//! Bodies are covered by spheres. One sphere around each group is held against an obstacle or another group first, and only
//! where some lane comes near, the group's own. Single precision and spheres are a filter: an outer radius that allows for all rounding
//! tells what is surely free, an inner one what surely touches, and what lies between is decided by exact
//! distances in double precision. So the answer is that of exact distances, on every machine.

use pulp::WithSimd;

use super::chain::Screw;
use super::lane_obstacle::{Points, squared};
use super::model::{Group, KernelSphere, Model, Pair};
use crate::math::singles::{SINGLES, Simd, SingleMask, SingleVector, Singles, single_registers};

/// A screw in single precision.
#[derive(Clone, Debug)]
pub(super) struct KernelScrew {
    turn: Turn,
    shift: [f32; 3],
    turns: bool,
}

/// The rotation before a screw; nearly all are multiples of a right angle about x.
#[derive(Clone, Debug)]
enum Turn {
    None,
    /// y becomes z, z becomes -y.
    Quarter,
    /// y becomes -z, z becomes y.
    Back,
    /// Columns.
    Any([[f32; 3]; 3]),
}

impl KernelScrew {
    pub(super) fn new(screw: &Screw) -> Self {
        let frame = &screw.constant;
        let single = |v: &nalgebra::Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
        let columns = [single(&frame.x), single(&frame.y), single(&frame.z)];
        let turn = match columns {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] => Turn::None,
            [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]] => Turn::Quarter,
            [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]] => Turn::Back,
            _ => Turn::Any(columns),
        };
        Self { turn, shift: single(&frame.origin), turns: screw.turns }
    }
}

/// Where the lanes are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lanes<'a> {
    /// On one straight motion: `base + share * travel` per screw.
    Motion { shares: &'a Singles, base: &'a [f32], travel: &'a [f32] },
    /// Anywhere: a position per screw and lane.
    States(&'a [Singles]),
}

/// How far things move around each lane's configuration: `rate * half_width`, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Widths<'a> {
    pub(super) half_widths: &'a Singles,
    /// Per group, against what stands still.
    pub(super) groups: &'a [f32],
    /// Per pair, against each other.
    pub(super) pairs: &'a [f32],
}

/// Two solids whose distance the kernel needs to know exactly.
#[derive(Clone, Copy, Debug)]
pub(super) enum Touch {
    Obstacle { body: usize, obstacle: usize },
    Bodies { first: usize, second: usize },
}

/// Working memory: frames and centres of all lanes.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    /// Axes x, y, z and origin of the frame before the first and after each screw.
    frames: Vec<[Singles; 12]>,
    coarse: Vec<[Singles; 3]>,
    fine: Vec<[Singles; 3]>,
    /// Which groups' `fine` are there.
    ready: Vec<bool>,
}

impl Buffers {
    pub(super) fn new(model: &Model) -> Self {
        let mut frames = vec![[Singles::ZERO; 12]; model.screws.len() + 1];
        let base = &model.chain.world_from_base;
        let vectors = [base.x, base.y, base.z, base.origin];
        for (slot, value) in frames[0].iter_mut().zip(vectors.iter().flat_map(|v| v.iter())) {
            *slot = Singles([*value as f32; SINGLES]);
        }
        Self {
            frames,
            coarse: vec![[Singles::ZERO; 3]; model.groups.len()],
            fine: vec![[Singles::ZERO; 3]; model.spheres.len()],
            ready: vec![false; model.groups.len()],
        }
    }
}

/// What the kernel found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// Some lane's configuration touches something.
    Touching,
    /// No lane's configuration touches anything as far as known; bit i tells that around lane i something may be touched within its width.
    Open(u32),
}

/// Some lane touches: the rest need not be looked at.
struct Stop;

/// One run over sixteen lanes.
pub(super) struct Pass<'a, 'e, const WIDE: bool> {
    pub(super) model: &'a Model,
    pub(super) lanes: Lanes<'a>,
    /// Looked at only if `WIDE`: otherwise lanes are single configurations.
    pub(super) widths: Widths<'a>,
    pub(super) buffers: &'a mut Buffers,
    /// The exact distance of two solids in a lane's configuration, less the margin, m.
    pub(super) exact: &'e mut dyn FnMut(usize, Touch) -> f64,
}

/// Wider than this, a lane is left open rather than measured, m: its halves will tell.
const MEASURED_WIDTH_M: f64 = 0.005;

impl<const WIDE: bool> WithSimd for Pass<'_, '_, WIDE> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Found {
        let mut open = 0;
        for part in 0..single_registers::<S>() {
            match self.check(simd, part) {
                Ok(bits) => open |= bits << (part * S::F32_LANES),
                Err(Stop) => return Found::Touching,
            }
        }
        Found::Open(open)
    }
}

impl<const WIDE: bool> Pass<'_, '_, WIDE> {
    /// One register of lanes; the bits of those that stay open.
    #[inline(always)]
    fn check<S: Simd>(&mut self, simd: S, part: usize) -> Result<u32, Stop> {
        let model = self.model;
        forward(simd, part, model, &self.lanes, &mut self.buffers.frames);
        self.buffers.ready.fill(false);
        let mut open = 0;
        for (index, group) in model.groups.iter().enumerate() {
            let frame = load_frame(simd, &self.buffers.frames[group.screws], part);
            let center = place(&frame, &group.coarse.center);
            store(&center, &mut self.buffers.coarse[index], part);
            let grown = self.grown(simd, part, self.widths.groups, index);
            let radius = grown + group.coarse.outer;
            for &obstacle in &group.obstacles {
                let solid = &model.obstacles[obstacle].lanes;
                if solid.within(simd, &center, radius + solid.slack).any() {
                    open |= self.group_and_obstacle(simd, part, index, obstacle)?;
                }
            }
        }
        for (index, pair) in model.pairs.iter().enumerate() {
            let first = load(simd, &self.buffers.coarse[pair.first], part);
            let second = load(simd, &self.buffers.coarse[pair.second], part);
            let (a, b) = (&model.groups[pair.first].coarse, &model.groups[pair.second].coarse);
            let radius = self.grown(simd, part, self.widths.pairs, index) + (a.outer + b.outer);
            if squared(&between(&first, &second)).at_most(radius * radius).any() {
                open |= self.two_groups(simd, part, index, pair)?;
            }
        }
        Ok(open)
    }

    /// How far group or pair `index` moves within each lane's width.
    #[inline(always)]
    fn grown<S: Simd>(&self, simd: S, part: usize, rates: &[f32], index: usize) -> SingleVector<S> {
        if WIDE {
            SingleVector::load(simd, self.widths.half_widths, part) * rates[index]
        } else {
            SingleVector::splat(simd, 0.0)
        }
    }

    #[inline(always)]
    fn group_and_obstacle<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        index: usize,
        obstacle: usize,
    ) -> Result<u32, Stop> {
        let model = self.model;
        let group = &model.groups[index];
        self.place_fine(simd, part, index, group);
        let grown = self.grown(simd, part, self.widths.groups, index);
        let solid = &model.obstacles[obstacle].lanes;
        let slack = solid.slack;
        let mut open = 0;
        for sphere in group.spheres.clone() {
            let center = load(simd, &self.buffers.fine[sphere], part);
            let KernelSphere { outer, inner, body, .. } = model.spheres[sphere];
            let near = solid.within(simd, &center, grown + (outer + slack));
            if near.any() {
                let inner = inner - slack;
                let radius = SingleVector::splat(simd, inner);
                if solid.exact && inner > 0.0 && solid.within(simd, &center, radius).any() {
                    return Err(Stop);
                }
                let rate = if WIDE { self.widths.groups[index] } else { 0.0 };
                open |= self.decide(near, part, rate, open, Touch::Obstacle { body, obstacle })?;
            }
        }
        Ok(open)
    }

    #[inline(always)]
    fn two_groups<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        index: usize,
        pair: &Pair,
    ) -> Result<u32, Stop> {
        let model = self.model;
        let (first, second) = (&model.groups[pair.first], &model.groups[pair.second]);
        self.place_fine(simd, part, pair.first, first);
        self.place_fine(simd, part, pair.second, second);
        let grown = self.grown(simd, part, self.widths.pairs, index);
        let other = load(simd, &self.buffers.coarse[pair.second], part);
        let mut open = 0;
        for a in first.spheres.clone() {
            let (center, sphere) = (load(simd, &self.buffers.fine[a], part), &model.spheres[a]);
            let radius = grown + (sphere.outer + second.coarse.outer);
            if !squared(&between(&center, &other)).at_most(radius * radius).any() {
                continue;
            }
            for b in second.spheres.clone() {
                let (away, other) =
                    (between(&center, &load(simd, &self.buffers.fine[b], part)), &model.spheres[b]);
                let square = squared(&away);
                let radius = grown + (sphere.outer + other.outer);
                let near = square.at_most(radius * radius);
                if near.any() {
                    // The margin is in both radii, but counts once.
                    let inner = sphere.inner + other.inner - model.margin as f32;
                    let least = sphere.inner.min(other.inner);
                    let sure = SingleVector::splat(simd, inner * inner);
                    if least > 0.0 && square.at_most(sure).any() {
                        return Err(Stop);
                    }
                    let rate = if WIDE { self.widths.pairs[index] } else { 0.0 };
                    let touch = Touch::Bodies { first: sphere.body, second: other.body };
                    open |= self.decide(near, part, rate, open, touch)?;
                }
            }
        }
        Ok(open)
    }

    /// Measures the lanes of `near` that are not `open` anyway.
    #[inline(never)]
    fn decide<S: Simd>(
        &mut self,
        near: SingleMask<S>,
        part: usize,
        rate: f32,
        mut open: u32,
        touch: Touch,
    ) -> Result<u32, Stop> {
        let near = near.bits();
        for bit in (0..S::F32_LANES).filter(|bit| near >> bit & 1 == 1) {
            if open >> bit & 1 == 1 {
                continue;
            }
            let lane = part * S::F32_LANES + bit;
            let half_width = if WIDE { self.widths.half_widths.0[lane] } else { 0.0 };
            let width = f64::from(rate) * f64::from(half_width);
            let distance = if width > MEASURED_WIDTH_M { width } else { (self.exact)(lane, touch) };
            if distance <= 0.0 {
                return Err(Stop);
            }
            open |= u32::from(distance <= width) << bit;
        }
        Ok(open)
    }

    #[inline(always)]
    fn place_fine<S: Simd>(&mut self, simd: S, part: usize, index: usize, group: &Group) {
        if self.buffers.ready[index] {
            return;
        }
        self.buffers.ready[index] = true;
        let frame = load_frame(simd, &self.buffers.frames[group.screws], part);
        for sphere in group.spheres.clone() {
            let center = place(&frame, &self.model.spheres[sphere].center);
            store(&center, &mut self.buffers.fine[sphere], part);
        }
    }
}

/// Axes and origin.
type Frame<S> = [Points<S>; 4];

/// Forward kinematics of one register of lanes.
#[inline(always)]
fn forward<S: Simd>(
    simd: S,
    part: usize,
    model: &Model,
    lanes: &Lanes<'_>,
    frames: &mut [[Singles; 12]],
) {
    let [mut x, mut y, mut z, mut origin] = load_frame(simd, &frames[0], part);
    for (index, screw) in model.screws.iter().enumerate() {
        for (axis, &shift) in [x, y, z].iter().zip(&screw.shift) {
            if shift != 0.0 {
                for row in 0..3 {
                    origin[row] = axis[row].mul_add_number(shift, origin[row]);
                }
            }
        }
        match &screw.turn {
            Turn::None => {}
            Turn::Quarter => (y, z) = (z, y.map(|value| -value)),
            Turn::Back => (y, z) = (z.map(|value| -value), y),
            Turn::Any(columns) => {
                let turned = columns.map(|column| combine(&x, &y, &z, &column));
                [x, y, z] = turned;
            }
        }
        let position = match lanes {
            Lanes::Motion { shares, base, travel } => SingleVector::load(simd, shares, part)
                .mul_add_number(travel[index], SingleVector::splat(simd, base[index])),
            Lanes::States(positions) => SingleVector::load(simd, &positions[index], part),
        };
        if screw.turns {
            let (sin, cos) = position.sin_cos();
            for row in 0..3 {
                let (old_x, old_y) = (x[row], y[row]);
                x[row] = old_y.mul_add(sin, old_x * cos);
                y[row] = old_y.mul_add(cos, -(old_x * sin));
            }
        } else {
            for row in 0..3 {
                origin[row] = z[row].mul_add(position, origin[row]);
            }
        }
        store_frame(&[x, y, z, origin], &mut frames[index + 1], part);
    }
}

#[inline(always)]
fn combine<S: Simd>(x: &Points<S>, y: &Points<S>, z: &Points<S>, column: &[f32; 3]) -> Points<S> {
    let row = |row: usize| {
        let sum = y[row].mul_add_number(column[1], z[row] * column[2]);
        x[row].mul_add_number(column[0], sum)
    };
    [row(0), row(1), row(2)]
}

/// A point of a frame in the world.
#[inline(always)]
fn place<S: Simd>([x, y, z, origin]: &Frame<S>, point: &[f32; 3]) -> Points<S> {
    let row = |row: usize| {
        let sum = z[row].mul_add_number(point[2], origin[row]);
        let sum = y[row].mul_add_number(point[1], sum);
        x[row].mul_add_number(point[0], sum)
    };
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn between<S: Simd>(a: &Points<S>, b: &Points<S>) -> Points<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[Singles; 3], part: usize) -> Points<S> {
    let row = |row: usize| SingleVector::load(simd, &lanes[row], part);
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn store<S: Simd>(points: &Points<S>, lanes: &mut [Singles; 3], part: usize) {
    for (row, lanes) in points.iter().zip(lanes) {
        row.store(lanes, part);
    }
}

#[inline(always)]
fn load_frame<S: Simd>(simd: S, lanes: &[Singles; 12], part: usize) -> Frame<S> {
    let row = |row: usize| SingleVector::load(simd, &lanes[row], part);
    [
        [row(0), row(1), row(2)],
        [row(3), row(4), row(5)],
        [row(6), row(7), row(8)],
        [row(9), row(10), row(11)],
    ]
}

#[inline(always)]
fn store_frame<S: Simd>(frame: &Frame<S>, lanes: &mut [Singles; 12], part: usize) {
    for (row, lanes) in frame.iter().flatten().zip(lanes) {
        row.store(lanes, part);
    }
}
