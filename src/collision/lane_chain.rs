//! The chain in single precision, for all lanes of a register.

use nalgebra::Vector3;

use super::chain::Screw;
use super::lane_obstacle::Points;
use crate::geometry::Transform;
use crate::math::singles::{SINGLES, Simd, SingleVector, Singles};

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
        let single = |v: &Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
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

/// The frame before the first screw, the same in all lanes.
pub(super) fn base_frame(base: &Transform) -> [Singles; 12] {
    let vectors = [base.x, base.y, base.z, base.origin];
    let mut frame = [Singles::ZERO; 12];
    for (lanes, value) in frame.iter_mut().zip(vectors.iter().flat_map(|vector| vector.iter())) {
        *lanes = Singles([*value as f32; SINGLES]);
    }
    frame
}

/// Axes and origin.
pub(super) type Frame<S> = [Points<S>; 4];

/// Forward kinematics of one register of lanes.
#[inline(always)]
pub(super) fn forward<S: Simd>(
    simd: S,
    part: usize,
    screws: &[KernelScrew],
    lanes: &Lanes<'_>,
    frames: &mut [[Singles; 12]],
) {
    let [mut x, mut y, mut z, mut origin] = load_frame(simd, &frames[0], part);
    for (index, screw) in screws.iter().enumerate() {
        for (axis, &shift) in [x, y, z].iter().zip(&screw.shift) {
            if shift != 0.0 {
                for row in 0..3 {
                    origin[row] = axis[row].mul_add_number(shift, origin[row]);
                }
            }
        }
        match &screw.turn {
            Turn::None => {}
            Turn::Quarter => (y, z) = (z, [-y[0], -y[1], -y[2]]),
            Turn::Back => (y, z) = ([-z[0], -z[1], -z[2]], y),
            Turn::Any(columns) => {
                [x, y, z] = [
                    combine(&x, &y, &z, &columns[0]),
                    combine(&x, &y, &z, &columns[1]),
                    combine(&x, &y, &z, &columns[2]),
                ];
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
    let mut sum = *z;
    for row in 0..3 {
        sum[row] = y[row].mul_add_number(column[1], z[row] * column[2]);
        sum[row] = x[row].mul_add_number(column[0], sum[row]);
    }
    sum
}

/// A point of a frame in the world.
#[inline(always)]
pub(super) fn place<S: Simd>([x, y, z, origin]: &Frame<S>, point: &[f32; 3]) -> Points<S> {
    let mut sum = *origin;
    for row in 0..3 {
        sum[row] = z[row].mul_add_number(point[2], sum[row]);
        sum[row] = y[row].mul_add_number(point[1], sum[row]);
        sum[row] = x[row].mul_add_number(point[0], sum[row]);
    }
    sum
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, lanes: &[Singles; 3], part: usize) -> Points<S> {
    [
        SingleVector::load(simd, &lanes[0], part),
        SingleVector::load(simd, &lanes[1], part),
        SingleVector::load(simd, &lanes[2], part),
    ]
}

#[inline(always)]
pub(super) fn store<S: Simd>(points: &Points<S>, lanes: &mut [Singles; 3], part: usize) {
    for (row, lanes) in points.iter().zip(lanes) {
        row.store(lanes, part);
    }
}

#[inline(always)]
pub(super) fn load_frame<S: Simd>(simd: S, lanes: &[Singles; 12], part: usize) -> Frame<S> {
    let zero = SingleVector::splat(simd, 0.0);
    let mut frame = [[zero; 3]; 4];
    for (vector, lanes) in frame.iter_mut().zip(lanes.as_chunks::<3>().0) {
        *vector = load(simd, lanes, part);
    }
    frame
}

#[inline(always)]
fn store_frame<S: Simd>(frame: &Frame<S>, lanes: &mut [Singles; 12], part: usize) {
    for (row, lanes) in frame.iter().flatten().zip(lanes) {
        row.store(lanes, part);
    }
}
