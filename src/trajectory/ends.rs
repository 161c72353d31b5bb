//! How a motion begins and ends.

/// Each joint's velocity and acceleration where a motion begins and where it ends, in
/// rad or m per s and s².
#[derive(Clone, Debug, PartialEq)]
pub struct Ends {
    /// At the first waypoint.
    pub start: Vec<[f64; 2]>,
    /// At the last one.
    pub goal: Vec<[f64; 2]>,
}

impl Ends {
    /// `joints` joints at rest at both ends.
    pub fn at_rest(joints: usize) -> Self {
        Self { start: vec![[0.0; 2]; joints], goal: vec![[0.0; 2]; joints] }
    }

    /// Whether all joints rest at the start, and at the goal.
    pub fn rests(&self) -> [bool; 2] {
        [&self.start, &self.goal].map(|end| end.iter().flatten().all(|value| *value == 0.0))
    }

    /// Whether all joints rest at both ends.
    pub fn are_at_rest(&self) -> bool {
        self.rests() == [true; 2]
    }

    /// The same backwards in time: velocities change sign, accelerations do not.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let back = |end: &Vec<[f64; 2]>| end.iter().map(|[v, a]| [-v, *a]).collect();
        Self { start: back(&self.goal), goal: back(&self.start) }
    }

    /// The same where `start` and `goal` say so, and rest elsewhere.
    #[must_use]
    pub fn only(&self, start: bool, goal: bool) -> Self {
        let mut ends = Self::at_rest(self.start.len());
        if start {
            ends.start.clone_from(&self.start);
        }
        if goal {
            ends.goal.clone_from(&self.goal);
        }
        ends
    }
}
