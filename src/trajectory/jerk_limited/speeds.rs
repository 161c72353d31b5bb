//! Limits of velocity that differ from segment to segment.

use std::ops::Deref;

use crate::trajectory::kernel::KernelLimits;

/// Limits by joint; those of velocity also by segment.
#[derive(Clone, Copy)]
pub struct Bounds<'a> {
    joints: &'a [KernelLimits],
    /// `[segment][joint]`, rad/s or m/s; empty if the joints' own hold everywhere.
    speeds: &'a [Vec<f64>],
}

impl<'a> Bounds<'a> {
    /// The joints' limits, and lower ones of velocity, `speeds[segment][joint]`, where they are lower.
    pub fn new(joints: &'a [KernelLimits], speeds: &'a [Vec<f64>]) -> Self {
        Self { joints, speeds }
    }

    /// The joints' limits in all segments.
    pub fn everywhere(joints: &'a [KernelLimits]) -> Self {
        Self { joints, speeds: &[] }
    }

    /// Those of the segments from `first` on.
    pub fn from(&self, first: usize) -> Self {
        Self { speeds: self.speeds.get(first..).unwrap_or_default(), ..*self }
    }

    /// Limits of velocity, acceleration and jerk of a joint in a segment.
    pub fn of(&self, segment: usize, joint: usize) -> [f64; 3] {
        let [velocity, acceleration, jerk] = self.joints[joint].derivatives;
        let lower = self.speeds.get(segment).map_or(velocity, |row| row[joint].min(velocity));
        [lower, acceleration, jerk]
    }
}

impl Deref for Bounds<'_> {
    type Target = [KernelLimits];

    fn deref(&self) -> &[KernelLimits] {
        self.joints
    }
}
