//! Seven joints: a six-axis arm with a closed form, and one more joint at either end.
//!
//! With that joint held, the others follow in closed form; what is left is a search along one line. Franka's
//! arms are of this kind with joint 7 held (He and Liu 2021, doi:10.1109/ICCMA54375.2021.9646185), and so are six-axis
//! arms on a rail.

use super::screws::Screw;
use super::six_axis::SixAxis;
use crate::geometry::Transform;

/// Such an arm.
#[derive(Clone, Debug)]
pub(super) struct Redundant {
    /// The joint that is held.
    held: Screw,
    /// True if it is the first one, false if it is the last.
    first: bool,
    arm: SixAxis,
}

impl Redundant {
    /// Joints of such an arm.
    pub(super) const COUNT: usize = 7;

    /// The arm with these lines, if there is a closed form for it but for `tolerance`.
    pub(super) fn new(screws: &[Screw], tolerance: f64) -> Option<Self> {
        let [first, .., last] = screws else { return None };
        let part = |part: &[Screw]| SixAxis::new(part.try_into().ok()?, tolerance);
        if let Some(arm) = part(&screws[..screws.len() - 1]) {
            return Some(Self { held: *last, first: false, arm });
        }
        part(&screws[1..]).map(|arm| Self { held: *first, first: true, arm })
    }

    /// The index of the joint that is held.
    pub(super) fn held(&self) -> usize {
        if self.first { 0 } else { Self::COUNT - 1 }
    }

    /// Shows `see` every configuration with the held joint at `position` whose motion is `motion`.
    #[inline]
    pub(super) fn solve(
        &self,
        motion: &Transform,
        position: f64,
        seed: &[f64],
        mut see: impl FnMut([f64; Self::COUNT]),
    ) {
        let held = self.held.to(position).inverse();
        let start = usize::from(self.first);
        let rest = if self.first { held * *motion } else { *motion * held };
        let part = std::array::from_fn(|joint| seed[start + joint]);
        let mut joints = [position; Self::COUNT];
        self.arm.solve(&rest, &part, |six| {
            joints[start..start + 6].copy_from_slice(&six);
            see(joints);
        });
    }
}

/// Positions spread over `[lower, upper]`, ever more densely: every power of two many of them are even.
pub(super) fn spread([lower, upper]: [f64; 2]) -> impl Iterator<Item = f64> {
    (1_u32..).map(move |index| {
        // The bits of the index, mirrored at the binary point (van der Corput).
        let share = f64::from(index.reverse_bits()) / (f64::from(u32::MAX) + 1.0);
        lower + (upper - lower) * share
    })
}
