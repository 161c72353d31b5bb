//! What becomes of a published figure when its experiment is run again.

/// How a published figure and ours stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Ours agrees with the published figure.
    Reproduces,
    /// Ours is of the same order of magnitude.
    OrderOfMagnitude,
    /// The paper's own figures do not fit together.
    PaperContradictsItself,
    /// The figure follows from the paper's other figures; nothing was run.
    AddsUp,
    /// What was published breaks the limits stated for it.
    BreaksItsLimits,
    /// The paper leaves out what a comparison would need.
    CannotBeCompared,
    /// Ours differs by more than an order of magnitude, or in what it shows.
    DoesNotReproduce,
}

impl Verdict {
    /// All verdicts, in the order of the summary.
    pub const ALL: [Self; 7] = [
        Self::Reproduces,
        Self::OrderOfMagnitude,
        Self::DoesNotReproduce,
        Self::BreaksItsLimits,
        Self::PaperContradictsItself,
        Self::AddsUp,
        Self::CannotBeCompared,
    ];

    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduces => "reproduces",
            Self::OrderOfMagnitude => "same order of magnitude",
            Self::AddsUp => "adds up, not run",
            Self::PaperContradictsItself => "the paper contradicts itself",
            Self::BreaksItsLimits => "breaks its own limits",
            Self::CannotBeCompared => "cannot be compared",
            Self::DoesNotReproduce => "does not reproduce",
        }
    }

    /// What the verdict means, for who reads the summary alone.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Reproduces => "Ours agrees within the tolerance that the section states.",
            Self::OrderOfMagnitude => {
                "Ours differs by less than a factor of ten; the reason says by how much or why."
            }
            Self::AddsUp => {
                "The figure follows from the paper's other figures, which were not run again."
            }
            Self::PaperContradictsItself => {
                "The figure does not follow from the paper's other figures, or cannot be."
            }
            Self::BreaksItsLimits => {
                "The published motion exceeds the limits that the paper states for it."
            }
            Self::CannotBeCompared => {
                "The paper leaves out what is needed; a substitute shows what comes of it."
            }
            Self::DoesNotReproduce => {
                "Ours differs by more than a factor of ten, or shows the opposite."
            }
        }
    }

    /// From good (0) to bad (1), for colours; none where nothing was compared.
    pub(super) fn heat(self) -> Option<f64> {
        match self {
            Self::Reproduces => Some(0.0),
            Self::OrderOfMagnitude => Some(0.35),
            Self::PaperContradictsItself => Some(0.7),
            Self::BreaksItsLimits => Some(0.85),
            Self::AddsUp | Self::CannotBeCompared => None,
            Self::DoesNotReproduce => Some(1.0),
        }
    }

    /// Judges ours against a published figure that is zero or positive: within
    /// a factor of `1 + tolerance`, up or down, it reproduces; within a factor of
    /// ten it is of the same order. Figures below 1e-30 differ in nothing but when
    /// a search was stopped, and count as one order.
    pub fn of(published: f64, ours: f64, tolerance: f64) -> Self {
        let factor = 1.0 + tolerance;
        if published == ours || ours * factor >= published && ours <= published * factor {
            return Self::Reproduces;
        }
        let tiny = published.max(ours) < 1e-30;
        let near = ours > 0.1 * published && ours < 10.0 * published;
        if tiny || near { Self::OrderOfMagnitude } else { Self::DoesNotReproduce }
    }

    /// Judges a printed sum or share by how far it is from what it is said to be;
    /// half of the second decimal is rounding.
    pub fn adding_up(difference: f64) -> Self {
        if difference.abs() < 0.0051 { Self::AddsUp } else { Self::PaperContradictsItself }
    }

    /// Judges a statement that either shows again or does not.
    pub fn shown(again: bool) -> Self {
        if again { Self::Reproduces } else { Self::DoesNotReproduce }
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict;

    #[test]
    fn figures_are_judged_by_their_ratio() {
        let cases = [
            (7.0, 7.05, Verdict::Reproduces),
            (0.0, 0.0, Verdict::Reproduces),
            (7.0, 30.0, Verdict::OrderOfMagnitude),
            (0.0, 1e-200, Verdict::OrderOfMagnitude),
            (1.0, 11.0, Verdict::DoesNotReproduce),
            (1.0, 0.0, Verdict::DoesNotReproduce),
            (1.0, f64::NAN, Verdict::DoesNotReproduce),
        ];
        for (published, ours, expected) in cases {
            assert_eq!(Verdict::of(published, ours, 0.01), expected, "{published} {ours}");
        }
        // Far better is as far off as far worse.
        assert_eq!(Verdict::of(1.0, 1e-12, 1.0), Verdict::DoesNotReproduce);
        assert_eq!(Verdict::of(1.0, 0.4, 1.0), Verdict::OrderOfMagnitude);
        assert_eq!(Verdict::of(1.0, 0.6, 1.0), Verdict::Reproduces);
    }
}
