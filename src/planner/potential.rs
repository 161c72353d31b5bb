//! The potential field that guides some planners: the pull of a goal, and how
//! near obstacles are.

use super::entry::optional;
use super::world::World;
use super::{ValidityChecker, distance};
use crate::fault::parameter::{Parameter, Settings, integer};

/// Moves samples towards an attractor until an obstacle is near: randomised
/// gradient descent of Qureshi and Ayaz 2016, doi:10.1007/s10514-015-9518-0.
pub(super) struct Descent {
    steps: u64,
    stride: f64,
    keep_off: f64,
}

/// Most steps of the descent.
pub(super) const STEPS: Parameter = integer(
    "descent_steps",
    "most steps by which a sample is moved towards the goal; default 30",
    30.0,
    0.0,
    200.0,
);

/// Length of a step of the descent.
pub(super) const STRIDE: Parameter = optional(
    "descent_stride",
    "length of one such step, in the units of the space; default: an eighth of the range",
);

/// Where the descent ends.
pub(super) const KEEP_OFF: Parameter = optional(
    "keep_off",
    "a sample no further from an obstacle than this is not moved; default: a quarter of the range",
);

impl Descent {
    pub fn new(settings: &Settings, range: f64) -> Self {
        Self {
            steps: settings.integer("descent_steps"),
            stride: settings.optional("descent_stride").unwrap_or(range / 8.0),
            keep_off: settings.optional("keep_off").unwrap_or(range / 4.0),
        }
    }

    /// Moves a state; on the attractor it stops.
    pub fn descend<C: ValidityChecker>(
        &self,
        world: &mut World<'_, C>,
        attractor: &[f64],
        state: &mut [f64],
    ) {
        for _ in 0..self.steps {
            let away = distance(state, attractor);
            if away == 0.0 || world.clearance(state) <= self.keep_off {
                return;
            }
            let share = (self.stride / away).min(1.0);
            for (x, &to) in state.iter_mut().zip(attractor) {
                *x += (to - *x) * share;
            }
        }
    }
}

/// Writes the direction in which the clearance grows fastest, of length one; all
/// zero where it is the same on all sides.
///
/// Central differences over `reach`: the clearance is 1-Lipschitz and, away from
/// places equally far from two obstacles, smooth.
pub(super) fn away_from_obstacles<C: ValidityChecker>(
    world: &mut World<'_, C>,
    state: &[f64],
    reach: f64,
    moved: &mut [f64],
    direction: &mut [f64],
) {
    moved.copy_from_slice(state);
    for axis in 0..state.len() {
        moved[axis] = state[axis] + reach;
        let ahead = world.clearance(moved);
        moved[axis] = state[axis] - reach;
        direction[axis] = ahead - world.clearance(moved);
        moved[axis] = state[axis];
    }
    normalise(direction);
}

/// Scales a direction to length one, unless it is none.
pub(super) fn normalise(direction: &mut [f64]) {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        direction.iter_mut().for_each(|x| *x /= length);
    } else {
        direction.fill(0.0);
    }
}
