//! Sliding joints, then one to three turning ones: the turns make the orientation, the slides the rest.

use nalgebra::{DMatrix, Vector3};

use super::screws::{NEARLY, Screw};
use super::turn::{Few, Turn, between, three_turns};
use crate::geometry::Transform;

/// Such a machine.
#[derive(Clone, Debug)]
pub(super) struct Gantry {
    /// How far each slide has to move per offset: the rows of the pseudoinverse of their directions.
    slides: Vec<Vector3<f64>>,
    turns: Vec<Screw>,
    /// The tool at 0, m.
    tool: Vector3<f64>,
    /// Across the last line.
    across: Vector3<f64>,
}

impl Gantry {
    /// Most joints of such a machine.
    pub(super) const MOST: usize = 6;

    /// The machine with these lines and its tool at `tool`, if it is one.
    pub(super) fn new(screws: &[Screw], tool: Vector3<f64>) -> Option<Self> {
        let count = screws.iter().take_while(|screw| screw.slides).count();
        let (slides, turns) = screws.split_at(count);
        let fits = (1..=3).contains(&slides.len()) && (1..=3).contains(&turns.len());
        let apart = turns.windows(2).all(|pair| !pair[0].is_parallel(&pair[1], NEARLY));
        if !fits || !apart || turns.iter().any(|turn| turn.slides) {
            return None;
        }
        let directions = DMatrix::from_fn(3, count, |row, column| slides[column].direction[row]);
        // Slides along the same line or plane are not told apart.
        let gram = (directions.transpose() * &directions).try_inverse()?;
        if gram.norm() > 1e3 {
            return None;
        }
        let inverse = gram * directions.transpose();
        let row =
            |index| Vector3::new(inverse[(index, 0)], inverse[(index, 1)], inverse[(index, 2)]);
        let across = turns.last()?.any_across();
        Some(Self { slides: (0..count).map(row).collect(), turns: turns.to_vec(), tool, across })
    }

    /// Shows `see` every configuration whose motion comes nearest to `motion`, orientation first.
    #[inline]
    pub(super) fn solve(
        &self,
        motion: &Transform,
        seed: &[f64],
        mut see: impl FnMut([f64; Self::MOST]),
    ) {
        let count = self.slides.len();
        let held = |index: usize| Turn::by(seed[count + index]);
        let rest = Turn { sin: 0.0, cos: 1.0 };
        let turned = |vector: &Vector3<f64>| motion.direction(vector);
        let found: Few<[Turn; 3]> = match &self.turns[..] {
            [s1, s2, s3] => {
                let axes = [&s1.direction, &s2.direction, &s3.direction];
                three_turns(axes, &self.across, turned, || held(0))
            }
            [s1, s2] => {
                let first = between(&s1.direction, &s2.direction, &turned(&s2.direction));
                let first = first.unwrap_or_else(|| held(0));
                let back = first.back().apply(&s1.direction, &turned(&self.across));
                let second = between(&s2.direction, &self.across, &back);
                Few::one([first, second.unwrap_or_else(|| held(1)), rest])
            }
            [s1, ..] => {
                let only = between(&s1.direction, &self.across, &turned(&self.across));
                Few::one([only.unwrap_or_else(|| held(0)), rest, rest])
            }
            [] => Few::none(),
        };
        for turns in found {
            let joined = self.turns.iter().zip(turns).rev();
            let reach = joined.fold(self.tool, |point, (screw, turn)| screw.turn(turn, &point));
            let missing = motion.point(&self.tool) - reach;
            let mut joints = [0.0; Self::MOST];
            for (joint, slide) in joints.iter_mut().zip(&self.slides) {
                *joint = slide.dot(&missing);
            }
            for (joint, turn) in joints[count..].iter_mut().zip(turns) {
                *joint = turn.angle();
            }
            see(joints);
        }
    }
}
