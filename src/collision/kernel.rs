//! The hot kernel: sixteen configurations at once, in single precision.
//!
//! Bodies are covered by spheres. One sphere around each group is held against an obstacle or another group first, and only
//! where some lane comes near, the group's own. Single precision and spheres are a filter: an outer radius that allows for all rounding
//! tells what is surely free, an inner one what surely touches, and what lies between is decided by exact
//! distances in double precision. So the answer is that of exact distances, on every machine.

use pulp::WithSimd;

use super::lane_chain::{Lanes, base_frame, forward, load, load_frame, place, store};
use super::lane_obstacle::{Points, squared};
use super::model::{KernelSphere, Model, Pair};
use super::travel::{Arms, Rate};
use crate::math::singles::{Simd, SingleMask, SingleVector, Singles, single_registers};

/// How far things move around each lane's configuration: by their rate times the half width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Widths<'a> {
    pub(super) half_widths: &'a Singles,
    /// Per group, against what stands still.
    pub(super) groups: &'a [Rate],
    /// Per pair, against each other.
    pub(super) pairs: &'a [Rate],
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
    clusters: Vec<[Singles; 3]>,
    fine: Vec<[Singles; 3]>,
    /// Which groups' clusters, and which clusters' spheres are there.
    groups_ready: Vec<bool>,
    clusters_ready: Vec<bool>,
}

impl Buffers {
    pub(super) fn new(model: &Model) -> Self {
        let mut frames = vec![[Singles::ZERO; 12]; model.screws.len() + 1];
        frames[0] = base_frame(&model.chain.world_from_base);
        Self {
            frames,
            coarse: vec![[Singles::ZERO; 3]; model.groups.len()],
            clusters: vec![[Singles::ZERO; 3]; model.clusters.len()],
            fine: vec![[Singles::ZERO; 3]; model.spheres.len()],
            groups_ready: vec![false; model.groups.len()],
            clusters_ready: vec![false; model.clusters.len()],
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
        forward(simd, part, &model.screws, &self.lanes, &mut self.buffers.frames);
        self.buffers.groups_ready.fill(false);
        self.buffers.clusters_ready.fill(false);
        Ok(self.all_groups(simd, part)? | self.all_pairs(simd, part)?)
    }

    /// Every group against the obstacles it can reach.
    #[inline(always)]
    fn all_groups<S: Simd>(&mut self, simd: S, part: usize) -> Result<u32, Stop> {
        let model = self.model;
        let mut open = 0;
        for (index, group) in model.groups.iter().enumerate() {
            let frame = load_frame(simd, &self.buffers.frames[group.screws], part);
            let center = place(&frame, &group.coarse.center);
            store(&center, &mut self.buffers.coarse[index], part);
            let grown = self.grown(simd, part, &self.group_rate(index), &group.coarse.arms);
            let radius = grown + group.coarse.outer;
            for obstacles in group.obstacles.chunks(CHUNK) {
                let near = bits(
                    obstacles.len(),
                    #[inline(always)]
                    |place| {
                        let solid = &model.obstacles[obstacles[place]].lanes;
                        solid.within(simd, &center, radius + solid.slack).any()
                    },
                );
                for place in ones(near) {
                    open |= self.group_and_obstacle(simd, part, index, obstacles[place])?;
                }
            }
        }
        Ok(open)
    }

    /// Every two groups that must not touch.
    #[inline(always)]
    fn all_pairs<S: Simd>(&mut self, simd: S, part: usize) -> Result<u32, Stop> {
        let model = self.model;
        let mut open = 0;
        for (chunk, pairs) in model.pairs.chunks(CHUNK).enumerate() {
            let first = chunk * CHUNK;
            let near = bits(
                pairs.len(),
                #[inline(always)]
                |place| {
                    let pair = &pairs[place];
                    let a = load(simd, &self.buffers.coarse[pair.first], part);
                    let b = load(simd, &self.buffers.coarse[pair.second], part);
                    let outer = pair.outer(model);
                    let arms = &model.groups[pair.second].coarse.arms;
                    let rate = self.pair_rate(first + place);
                    let radius = self.grown(simd, part, &rate, arms) + outer;
                    squared(&between(&a, &b)).at_most(radius * radius).any()
                },
            );
            for place in ones(near) {
                open |= self.two_groups(simd, part, first + place, &pairs[place])?;
            }
        }
        Ok(open)
    }

    /// How far a sphere with these arms moves within each lane's width, m.
    #[inline(always)]
    fn grown<S: Simd>(&self, simd: S, part: usize, rate: &Rate, arms: &Arms) -> SingleVector<S> {
        if WIDE {
            SingleVector::load(simd, self.widths.half_widths, part) * rate.of(arms) as f32
        } else {
            SingleVector::splat(simd, 0.0)
        }
    }

    /// How far group `index` moves against what stands still.
    #[inline(always)]
    fn group_rate(&self, index: usize) -> Rate {
        if WIDE { self.widths.groups[index] } else { Rate::default() }
    }

    /// How far the groups of pair `index` move against each other.
    #[inline(always)]
    fn pair_rate(&self, index: usize) -> Rate {
        if WIDE { self.widths.pairs[index] } else { Rate::default() }
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
        self.place_clusters(simd, part, index);
        let solid = &model.obstacles[obstacle].lanes;
        let rate = self.group_rate(index);
        let mut open = 0;
        let all = model.groups[index].clusters.clone();
        for first in all.clone().step_by(CHUNK) {
            let near = bits(
                CHUNK.min(all.end - first),
                #[inline(always)]
                |place| {
                    let center = load(simd, &self.buffers.clusters[first + place], part);
                    let coarse = &model.clusters[first + place].coarse;
                    let grown = self.grown(simd, part, &rate, &coarse.arms);
                    solid.within(simd, &center, grown + (coarse.outer + solid.slack)).any()
                },
            );
            for cluster in ones(near).map(|place| first + place) {
                self.place_fine(simd, part, index, cluster);
                for sphere in model.clusters[cluster].spheres.clone() {
                    let center = load(simd, &self.buffers.fine[sphere], part);
                    let KernelSphere { outer, inner, body, ref arms, .. } = model.spheres[sphere];
                    let grown = self.grown(simd, part, &rate, arms);
                    let near = solid.within(simd, &center, grown + (outer + solid.slack));
                    if near.any() {
                        let inner = inner - solid.slack;
                        let radius = SingleVector::splat(simd, inner);
                        if solid.exact && inner > 0.0 && solid.within(simd, &center, radius).any() {
                            return Err(Stop);
                        }
                        let touch = Touch::Obstacle { body, obstacle };
                        open = self.decide(near, part, rate.of(arms), open, touch)?;
                    }
                }
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
        self.place_clusters(simd, part, pair.first);
        self.place_clusters(simd, part, pair.second);
        let rate = self.pair_rate(index);
        let mut open = 0;
        for first in model.groups[pair.first].clusters.clone() {
            let center = load(simd, &self.buffers.clusters[first], part);
            let outer = model.clusters[first].coarse.outer;
            let all = model.groups[pair.second].clusters.clone();
            for start in all.clone().step_by(CHUNK) {
                let near = bits(
                    CHUNK.min(all.end - start),
                    #[inline(always)]
                    |place| {
                        let other = load(simd, &self.buffers.clusters[start + place], part);
                        let coarse = &model.clusters[start + place].coarse;
                        let grown = self.grown(simd, part, &rate, &coarse.arms);
                        let radius = grown + (outer + coarse.outer);
                        squared(&between(&center, &other)).at_most(radius * radius).any()
                    },
                );
                for second in ones(near).map(|place| start + place) {
                    self.place_fine(simd, part, pair.first, first);
                    self.place_fine(simd, part, pair.second, second);
                    open |= self.two_clusters(simd, part, rate, [first, second])?;
                }
            }
        }
        Ok(open)
    }

    #[inline(always)]
    fn two_clusters<S: Simd>(
        &mut self,
        simd: S,
        part: usize,
        rate: Rate,
        [first, second]: [usize; 2],
    ) -> Result<u32, Stop> {
        let model = self.model;
        let mut open = 0;
        for a in model.clusters[first].spheres.clone() {
            let (center, sphere) = (load(simd, &self.buffers.fine[a], part), &model.spheres[a]);
            let all = model.clusters[second].spheres.clone();
            let near = bits(
                all.len(),
                #[inline(always)]
                |place| {
                    let other = &model.spheres[all.start + place];
                    let grown = self.grown(simd, part, &rate, &other.arms);
                    let radius = grown + (sphere.outer + other.outer);
                    let other = load(simd, &self.buffers.fine[all.start + place], part);
                    squared(&between(&center, &other)).at_most(radius * radius).any()
                },
            );
            for b in ones(near).map(|place| all.start + place) {
                let other = &model.spheres[b];
                let square = squared(&between(&center, &load(simd, &self.buffers.fine[b], part)));
                // The margin is in both radii, but counts once.
                let inner = sphere.inner + other.inner - model.margin as f32;
                let sure = SingleVector::splat(simd, inner * inner);
                if inner > 0.0 && square.at_most(sure).any() {
                    return Err(Stop);
                }
                let grown = self.grown(simd, part, &rate, &other.arms);
                let radius = grown + (sphere.outer + other.outer);
                let touch = Touch::Bodies { first: sphere.body, second: other.body };
                open = self.decide(
                    square.at_most(radius * radius),
                    part,
                    rate.of(&other.arms),
                    open,
                    touch,
                )?;
            }
        }
        Ok(open)
    }

    /// Measures the lanes of `near` that are not `open` anyway; the two move by `moved` (m) on the whole motion.
    #[inline(never)]
    fn decide<S: Simd>(
        &mut self,
        near: SingleMask<S>,
        part: usize,
        moved: f64,
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
            let width = moved * f64::from(half_width);
            let distance = if width > MEASURED_WIDTH_M { width } else { (self.exact)(lane, touch) };
            if distance <= 0.0 {
                return Err(Stop);
            }
            open |= u32::from(distance <= width) << bit;
        }
        Ok(open)
    }

    #[inline(always)]
    fn place_clusters<S: Simd>(&mut self, simd: S, part: usize, index: usize) {
        let (model, buffers) = (self.model, &mut *self.buffers);
        if std::mem::replace(&mut buffers.groups_ready[index], true) {
            return;
        }
        let group = &model.groups[index];
        let frame = load_frame(simd, &buffers.frames[group.screws], part);
        for cluster in group.clusters.clone() {
            let center = place(&frame, &model.clusters[cluster].coarse.center);
            store(&center, &mut buffers.clusters[cluster], part);
        }
    }

    /// Places the spheres of a cluster of group `index`.
    #[inline(always)]
    fn place_fine<S: Simd>(&mut self, simd: S, part: usize, index: usize, cluster: usize) {
        let (model, buffers) = (self.model, &mut *self.buffers);
        if std::mem::replace(&mut buffers.clusters_ready[cluster], true) {
            return;
        }
        let frame = load_frame(simd, &buffers.frames[model.groups[index].screws], part);
        for sphere in model.clusters[cluster].spheres.clone() {
            let center = place(&frame, &model.spheres[sphere].center);
            store(&center, &mut buffers.fine[sphere], part);
        }
    }
}

/// So many tests run before any of their answers is looked at: branches that nobody can predict cost more than tests.
const CHUNK: usize = 64;

/// Bit i tells whether `test` holds for i, below `count`.
#[inline(always)]
fn bits(count: usize, mut test: impl FnMut(usize) -> bool) -> u64 {
    let mut bits = 0;
    for place in 0..count {
        bits |= u64::from(test(place)) << place;
    }
    bits
}

/// The places of the bits that are set.
#[inline(always)]
fn ones(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        let some = bits != 0;
        bits &= bits.wrapping_sub(1);
        some.then_some(place)
    })
}

#[inline(always)]
fn between<S: Simd>(a: &Points<S>, b: &Points<S>) -> Points<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
