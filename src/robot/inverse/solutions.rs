//! The solutions of one question, and the memory it takes to find them.

use super::numeric::Scratch;
use super::{InverseKinematics, PoseError};

/// Two solutions whose joints differ by less are one, rad or m.
const SAME: f64 = 1e-6;

/// Solutions and working memory, to be used again: after the first use nothing is allocated.
#[derive(Clone, Debug)]
pub struct Solutions {
    dof: usize,
    joints: Vec<f64>,
    errors: Vec<PoseError>,
    pub(super) scratch: Scratch,
}

impl Solutions {
    /// Room for the solutions of `inverse`.
    pub fn new(inverse: &InverseKinematics) -> Self {
        Self {
            dof: inverse.kinematics.dof(),
            joints: Vec::new(),
            errors: Vec::new(),
            scratch: Scratch::new(&inverse.kinematics),
        }
    }

    /// Number of solutions.
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// The solutions, each with how far its pose is from the wanted one.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (&[f64], PoseError)> {
        self.joints.chunks_exact(self.dof).zip(self.errors.iter().copied())
    }

    pub(super) fn clear(&mut self) {
        self.joints.clear();
        self.errors.clear();
    }

    pub(super) fn push(&mut self, joints: &[f64], error: PoseError) {
        self.joints.extend_from_slice(joints);
        self.errors.push(error);
    }

    pub(super) fn holds(&self, joints: &[f64]) -> bool {
        let same = |(left, right): (&f64, &f64)| (left - right).abs() < SAME;
        self.iter().any(|(found, _)| found.iter().zip(joints).all(same))
    }
}
