//! The robot in its scene as planners see it.

use crate::collision::{CollisionChecker, CollisionScratch};
use crate::planner::ValidityChecker;

/// A checker with one thread's working memory.
pub struct FreeMotions<'a> {
    pub checker: &'a CollisionChecker,
    pub scratch: CollisionScratch,
}

impl<'a> FreeMotions<'a> {
    pub fn new(checker: &'a CollisionChecker) -> Self {
        Self { checker, scratch: checker.scratch() }
    }
}

impl ValidityChecker for FreeMotions<'_> {
    fn is_state_valid(&mut self, state: &[f64]) -> bool {
        self.checker.is_valid(state, &mut self.scratch)
    }

    fn is_motion_valid(&mut self, from: &[f64], to: &[f64]) -> bool {
        self.checker.is_motion_valid(from, to, &mut self.scratch)
    }
}
