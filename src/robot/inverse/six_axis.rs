//! Six-axis arms with a closed form, from whichever end it is seen.

use super::screws::Screw;
use super::spherical_wrist::SphericalWrist;
use super::three_parallel::ThreeParallel;
use crate::geometry::Transform;

/// A six-axis arm that can be solved in closed form.
#[derive(Clone, Debug)]
pub(super) struct SixAxis {
    form: Form,
    /// True if the form is the arm's seen from the tool: its joints in reverse.
    reversed: bool,
}

#[derive(Clone, Debug)]
enum Form {
    SphericalWrist(SphericalWrist),
    ThreeParallel(ThreeParallel),
}

impl SixAxis {
    /// The arm with these lines, if there is a closed form for it but for `tolerance`.
    pub(super) fn new(screws: [Screw; 6], tolerance: f64) -> Option<Self> {
        let form = |screws: [Screw; 6]| {
            let wrist = SphericalWrist::new(screws, tolerance).map(Form::SphericalWrist);
            wrist.or_else(|| ThreeParallel::new(screws, tolerance).map(Form::ThreeParallel))
        };
        if let Some(form) = form(screws) {
            return Some(Self { form, reversed: false });
        }
        let mut seen = screws.map(|screw| screw.reversed());
        seen.reverse();
        form(seen).map(|form| Self { form, reversed: true })
    }

    /// What kind of arm it is.
    pub(super) fn name(&self) -> &'static str {
        match (&self.form, self.reversed) {
            (Form::SphericalWrist(_), false) => "spherical_wrist",
            (Form::SphericalWrist(_), true) => "spherical_shoulder",
            (Form::ThreeParallel(_), _) => "three_parallel_axes",
        }
    }

    /// Shows `see` every configuration whose motion is `motion`, at most eight; `seed` stands in where a
    /// joint may be anywhere.
    #[inline]
    pub(super) fn solve(&self, motion: &Transform, seed: &[f64; 6], mut see: impl FnMut([f64; 6])) {
        if !self.reversed {
            return self.form.solve(motion, seed, see);
        }
        let mut seed = *seed;
        seed.reverse();
        self.form.solve(&motion.inverse(), &seed, |mut joints| {
            joints.reverse();
            see(joints);
        });
    }
}

impl Form {
    #[inline]
    fn solve(&self, motion: &Transform, seed: &[f64; 6], see: impl FnMut([f64; 6])) {
        match self {
            Self::SphericalWrist(arm) => arm.solve(motion, seed, see),
            Self::ThreeParallel(arm) => arm.solve(motion, seed, see),
        }
    }
}
