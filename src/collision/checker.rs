//! Which configurations and motions are free.

use nalgebra::Vector3;

use super::kernel::{Buffers, Found, Pass, Touch, Widths};
use super::lane_chain::Lanes;
use super::model::Model;
use super::motion::Interval;
use super::travel::Rate;
use crate::fault::Faults;
use crate::geometry::Transform;
use crate::math::singles::{SINGLES, Singles};
use crate::robot::Robot;
use crate::scene::Scene;

/// Most configurations that are checked at once.
pub const BATCH: usize = SINGLES;

/// How straight motions are checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionCheck {
    /// At configurations spread evenly, at least so many per rad (or m) of the Euclidean length in joint space; what happens
    /// between them is not looked at.
    Resolution(f64),
    /// Over all of the motion: it is free only if that is proven.
    Proven,
}

/// A robot in a scene, ready for checking; it never changes, so threads share it.
#[derive(Clone, Debug)]
pub struct CollisionChecker {
    pub(super) model: Model,
    motion_check: MotionCheck,
}

/// Working memory of one thread for one checker.
#[derive(Clone, Debug)]
pub struct CollisionScratch {
    pub(super) buffers: Buffers,
    pub(super) positions: Vec<Singles>,
    /// Where a motion starts and how far it goes, per joint.
    pub(super) from: Vec<f64>,
    pub(super) delta: Vec<f64>,
    /// The same per screw, for the kernel.
    pub(super) base: Vec<f32>,
    pub(super) travel: Vec<f32>,
    /// How far groups and pairs move on it.
    pub(super) group_rates: Vec<Rate>,
    pub(super) pair_rates: Vec<Rate>,
    pub(super) intervals: Vec<Interval>,
    pub(super) exact: ExactFrames,
}

/// The frames of one configuration in double precision.
#[derive(Clone, Debug, Default)]
pub(super) struct ExactFrames {
    pub(super) configuration: Vec<f64>,
    pub(super) frames: Vec<Transform>,
    /// The lane they belong to, if any.
    lane: Option<usize>,
}

impl CollisionChecker {
    /// Compiles `robot` in `scene`, with a distance of `margin_m` (not negative) to be kept between them and between the
    /// robot's own links.
    ///
    /// # Errors
    ///
    /// A robot without kinematics or bodies, and links and names of the scene that the robot does not have. Pointers are the
    /// robot's (`/kinematics`, `/geometry`) and the scene's (`/attached`, `/allowed_pairs`, `/obstacles`).
    pub fn new(
        robot: &Robot,
        scene: &Scene,
        margin_m: f64,
        motion_check: MotionCheck,
    ) -> Result<Self, Faults> {
        Ok(Self { model: Model::new(robot, scene, margin_m)?, motion_check })
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.model.chain.dof
    }

    /// Working memory for one thread.
    pub fn scratch(&self) -> CollisionScratch {
        let (dof, screws) = (self.dof(), self.model.screws.len());
        CollisionScratch {
            buffers: Buffers::new(&self.model),
            positions: vec![Singles::ZERO; screws],
            from: vec![0.0; dof],
            delta: vec![0.0; dof],
            base: vec![0.0; screws],
            travel: vec![0.0; screws],
            group_rates: vec![Rate::default(); self.model.groups.len()],
            pair_rates: vec![Rate::default(); self.model.pairs.len()],
            intervals: Vec::new(),
            exact: ExactFrames { configuration: vec![0.0; dof], ..ExactFrames::default() },
        }
    }

    /// True if the robot touches nothing at `state` (rad or m per joint). False, too, for positions that are not finite
    /// or beyond the limits of sliding joints; other limits are not looked at.
    ///
    /// # Panics
    ///
    /// If `state` has another number of joints, or `scratch` is another checker's.
    pub fn is_valid(&self, state: &[f64], scratch: &mut CollisionScratch) -> bool {
        self.are_valid(state, scratch)
    }

    /// True if the robot touches nothing at any of up to [`BATCH`] states, one after the other in `states`.
    ///
    /// # Panics
    ///
    /// If `states` is empty, longer than [`BATCH`] states or not a whole number of them.
    pub fn are_valid(&self, states: &[f64], scratch: &mut CollisionScratch) -> bool {
        let dof = self.dof();
        let count = states.len() / dof;
        assert!((1..=BATCH).contains(&count) && states.len() == count * dof, "1 to 16 states");
        if !states.chunks_exact(dof).all(|state| self.is_within_reach(state)) {
            return false;
        }
        for (screw, lanes) in self.model.chain.screws.iter().zip(&mut scratch.positions) {
            for (lane, slot) in lanes.0.iter_mut().enumerate() {
                // Lanes without a state of their own repeat the first one.
                let state = if lane < count { lane * dof } else { 0 };
                *slot = wrapped(screw.turns, screw.position(states[state + screw.joint])) as f32;
            }
        }
        let CollisionScratch { buffers, positions, exact, .. } = scratch;
        exact.lane = None;
        let mut measure = |lane: usize, touch: Touch| {
            let state = if lane < count { lane * dof } else { 0 };
            self.distance_in_lane(lane, touch, exact, |configuration| {
                configuration.copy_from_slice(&states[state..state + dof]);
            })
        };
        let widths = Widths { half_widths: &Singles::ZERO, groups: &[], pairs: &[] };
        let pass = Pass::<false> {
            model: &self.model,
            lanes: Lanes::States(positions),
            widths,
            buffers,
            exact: &mut measure,
        };
        pulp::Arch::new().dispatch(pass) != Found::Touching
    }

    /// True if the straight motion between two valid states is free, checked as the checker was told to; `from` itself
    /// is not looked at by samples.
    ///
    /// # Panics
    ///
    /// If a state has another number of joints, or `scratch` is another checker's.
    pub fn is_motion_valid(
        &self,
        from: &[f64],
        to: &[f64],
        scratch: &mut CollisionScratch,
    ) -> bool {
        match self.motion_check {
            MotionCheck::Resolution(resolution) => {
                self.is_motion_free_at(resolution, from, to, scratch)
            }
            MotionCheck::Proven => self.is_motion_proven_free(from, to, scratch),
        }
    }

    /// True if all positions are finite and sliding joints within what bounds on their motion rest on.
    pub(super) fn is_within_reach(&self, state: &[f64]) -> bool {
        let slides_too_far = |screw: &super::chain::Screw| {
            !screw.turns && state[screw.joint].abs() > screw.travel * (1.0 + 1e-9)
        };
        state.iter().all(|position| position.is_finite())
            && !self.model.chain.screws.iter().any(slides_too_far)
    }

    /// The exact distance of two solids, less the margin, m; `configure` writes the lane's configuration.
    pub(super) fn distance_in_lane(
        &self,
        lane: usize,
        touch: Touch,
        exact: &mut ExactFrames,
        configure: impl Fn(&mut [f64]),
    ) -> f64 {
        if exact.lane != Some(lane) {
            configure(&mut exact.configuration);
            self.model.chain.forward(&exact.configuration, &mut exact.frames);
            exact.lane = Some(lane);
        }
        self.model.distance(touch, &exact.frames) - self.model.margin
    }
}

impl ExactFrames {
    /// Lanes are about to change.
    pub(super) fn forget(&mut self) {
        self.lane = None;
    }
}

impl Model {
    /// The exact distance of two solids, m.
    pub(super) fn distance(&self, touch: Touch, frames: &[Transform]) -> f64 {
        let placed = |body: usize| self.bodies[body].solid.moved(&frames[self.bodies[body].screws]);
        match touch {
            Touch::Obstacle { body, obstacle } => {
                placed(body).distance(&self.obstacles[obstacle].solid)
            }
            Touch::Bodies { first, second } => placed(first).distance(&placed(second)),
        }
    }

    /// Where a body's origin is.
    pub(super) fn origin(&self, body: usize, frames: &[Transform]) -> Vector3<f64> {
        let body = &self.bodies[body];
        frames[body.screws].point(&body.solid.frame.origin)
    }
}

/// The same turn, within a whole one of zero; a slide as it is.
pub(super) fn wrapped(turns: bool, position: f64) -> f64 {
    const TURN: f64 = std::f64::consts::TAU;
    // Nearly all are there already, and rounding is slow.
    if turns && position.abs() > TURN {
        position - TURN * (position / TURN).round()
    } else {
        position
    }
}
