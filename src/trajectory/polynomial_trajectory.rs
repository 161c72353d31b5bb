//! The one trajectory type: a piecewise polynomial per joint.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::math::polynomial;

/// A timed motion: per piece and joint a polynomial in local time.
///
/// Piece `i` holds from `breakpoints[i]` to `breakpoints[i + 1]`; its local
/// time starts at zero. `pieces[i][j]` are joint `j`'s coefficients in
/// ascending powers: rad, rad/s, rad/s², ... or the same in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    /// Ascending, starting at 0, s; one more than there are pieces.
    pub breakpoints: Vec<f64>,
    /// Coefficients: piece, joint, power.
    pub pieces: Vec<Vec<Vec<f64>>>,
}

/// Why numbers do not make a trajectory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// There is nothing to follow.
    #[error("a trajectory needs at least one piece")]
    Empty,
    /// Breakpoints and pieces do not fit.
    #[error("{pieces} pieces need {} breakpoints, not {breakpoints}", pieces + 1)]
    BreakpointCount {
        /// Number of pieces.
        pieces: usize,
        /// Number of breakpoints.
        breakpoints: usize,
    },
    /// Time does not start at zero, stands still or runs backwards.
    #[error("breakpoint {index} is {value}: breakpoints start at 0 and ascend")]
    BreakpointOrder {
        /// Index of the breakpoint.
        index: usize,
        /// Its value, s.
        value: f64,
    },
    /// A piece is too short or too long to compute with.
    #[error(
        "piece {piece} lasts {length:e} s; {:e} to {:e} s are possible",
        Trajectory::SHORTEST_PIECE,
        Trajectory::LONGEST_PIECE
    )]
    PieceLength {
        /// Index of the piece.
        piece: usize,
        /// Its duration, s.
        length: f64,
    },
    /// A piece has the wrong number of joints.
    #[error("piece {piece} has {found} joints, not {expected}")]
    JointCount {
        /// Index of the piece.
        piece: usize,
        /// Joints found.
        found: usize,
        /// Joints expected.
        expected: usize,
    },
    /// A polynomial has no coefficient or too many.
    #[error(
        "piece {piece}, joint {joint} has {found} coefficients; 1 to {} are possible",
        polynomial::MAX_COEFFICIENTS
    )]
    CoefficientCount {
        /// Index of the piece.
        piece: usize,
        /// Index of the joint.
        joint: usize,
        /// Coefficients found.
        found: usize,
    },
    /// A coefficient is not finite, or what it contributes by the end of its
    /// piece is beyond computing.
    #[error("piece {piece}, joint {joint}: coefficient {power} is not finite or far too large")]
    NotFinite {
        /// Index of the piece.
        piece: usize,
        /// Index of the joint.
        joint: usize,
        /// Power of local time.
        power: usize,
    },
}

/// Position and its derivatives at one time, each one value per joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KinematicState {
    /// rad or m.
    pub position: Vec<f64>,
    /// rad/s or m/s.
    pub velocity: Vec<f64>,
    /// rad/s² or m/s².
    pub acceleration: Vec<f64>,
    /// rad/s³ or m/s³.
    pub jerk: Vec<f64>,
}

impl KinematicState {
    /// A state of `dof` joints at zero.
    pub fn new(dof: usize) -> Self {
        let zero = vec![0.0; dof];
        Self {
            position: zero.clone(),
            velocity: zero.clone(),
            acceleration: zero.clone(),
            jerk: zero,
        }
    }
}

impl Trajectory {
    /// Most coefficients of one polynomial: degree 15 is far beyond any
    /// interpolation in use and keeps root finding well conditioned.
    pub const MAX_COEFFICIENTS: usize = polynomial::MAX_COEFFICIENTS;

    /// Shortest piece, s: any shorter, and the powers of its duration vanish.
    pub const SHORTEST_PIECE: f64 = 1e-12;

    /// Longest piece, s: any longer, and the powers of its duration overflow.
    pub const LONGEST_PIECE: f64 = 1e12;

    /// Most a single power may contribute to a position, rad or m.
    const LARGEST_TERM: f64 = 1e100;

    /// Checks that the numbers make a trajectory of `dof` joints.
    ///
    /// # Errors
    ///
    /// The first thing that does not fit.
    pub fn validate(&self, dof: usize) -> Result<(), TrajectoryError> {
        if self.pieces.is_empty() {
            return Err(TrajectoryError::Empty);
        }
        if self.breakpoints.len() != self.pieces.len() + 1 {
            let (pieces, breakpoints) = (self.pieces.len(), self.breakpoints.len());
            return Err(TrajectoryError::BreakpointCount { pieces, breakpoints });
        }
        let mut before = 0.0;
        for (index, &value) in self.breakpoints.iter().enumerate() {
            let lawful = if index == 0 { value == 0.0 } else { value > before };
            if !lawful || !value.is_finite() {
                return Err(TrajectoryError::BreakpointOrder { index, value });
            }
            before = value;
        }
        for (piece, joints) in self.pieces.iter().enumerate() {
            let length = self.breakpoints[piece + 1] - self.breakpoints[piece];
            if !(Self::SHORTEST_PIECE..=Self::LONGEST_PIECE).contains(&length) {
                return Err(TrajectoryError::PieceLength { piece, length });
            }
            if joints.len() != dof {
                return Err(TrajectoryError::JointCount {
                    piece,
                    found: joints.len(),
                    expected: dof,
                });
            }
            for (joint, coefficients) in joints.iter().enumerate() {
                let found = coefficients.len();
                if found == 0 || found > Self::MAX_COEFFICIENTS {
                    return Err(TrajectoryError::CoefficientCount { piece, joint, found });
                }
                let mut scale = 1.0;
                let computable = |c: &f64| {
                    let term = c.abs() * scale;
                    scale *= length;
                    c.is_finite() && term <= Self::LARGEST_TERM
                };
                if let Some(power) = coefficients.iter().map(computable).position(|fine| !fine) {
                    return Err(TrajectoryError::NotFinite { piece, joint, power });
                }
            }
        }
        Ok(())
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.pieces.first().map_or(0, Vec::len)
    }

    /// Total duration, s.
    pub fn duration(&self) -> f64 {
        self.breakpoints.last().copied().unwrap_or(0.0)
    }

    /// The piece that holds at time `t` and the local time in it. At a
    /// breakpoint the later piece counts; outside, the nearer end.
    pub fn locate(&self, t: f64) -> (usize, f64) {
        let t = t.clamp(0.0, self.duration());
        let inner = &self.breakpoints[1..self.breakpoints.len() - 1];
        let piece = inner.partition_point(|&breakpoint| breakpoint <= t);
        (piece, t - self.breakpoints[piece])
    }

    /// Samples the trajectory at time `t`.
    ///
    /// Outside `[0, duration]` the nearer end position is held, at rest.
    ///
    /// # Panics
    ///
    /// If `state` was built for a different number of joints.
    pub fn sample(&self, t: f64, state: &mut KinematicState) {
        assert_eq!(state.position.len(), self.dof(), "state of another robot");
        let outside = t < 0.0 || t > self.duration();
        let (piece, local) = self.locate(t);
        for (joint, coefficients) in self.pieces[piece].iter().enumerate() {
            let [x, v, a, j] = polynomial::derivatives(coefficients, local);
            let at_rest = |value: f64| if outside { 0.0 } else { value };
            state.position[joint] = x;
            state.velocity[joint] = at_rest(v);
            state.acceleration[joint] = at_rest(a);
            state.jerk[joint] = at_rest(j);
        }
    }

    /// The same path, `factor` times as long.
    ///
    /// By the scaling law the d-th derivative is divided by `factor^d`.
    pub fn stretch(&mut self, factor: f64) {
        for breakpoint in &mut self.breakpoints {
            *breakpoint *= factor;
        }
        for coefficients in self.pieces.iter_mut().flatten() {
            let mut divisor = 1.0;
            for coefficient in coefficients {
                *coefficient /= divisor;
                divisor *= factor;
            }
        }
    }
}
