//! Keeps a fast planner from flooding the store with progress.

use std::time::Duration;

use super::Progress;

/// Lets at most 20 events a second through in a run's first two seconds and
/// four a second after; the first at once, and the last kept for the end.
#[derive(Debug, Default)]
pub(super) struct Throttle {
    last: Option<Duration>,
    held: Option<Progress>,
}

impl Throttle {
    const LIVELY: Duration = Duration::from_secs(2);
    const LIVELY_INTERVAL: Duration = Duration::from_millis(50);
    const CALM_INTERVAL: Duration = Duration::from_millis(250);

    /// `progress`, made `elapsed` after the run's start, if it may pass now.
    pub(super) fn admit(&mut self, elapsed: Duration, progress: Progress) -> Option<Progress> {
        let lively = elapsed < Self::LIVELY;
        let interval = if lively { Self::LIVELY_INTERVAL } else { Self::CALM_INTERVAL };
        if self.last.is_some_and(|last| elapsed < last + interval) {
            self.held = Some(progress);
            return None;
        }
        self.last = Some(elapsed);
        self.held = None;
        Some(progress)
    }

    /// The latest progress if it was held back.
    pub(super) fn take_held(&mut self) -> Option<Progress> {
        self.held.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(iteration: u64) -> Progress {
        Progress { iteration, ..<_>::default() }
    }

    // A planner that reports every millisecond for ten seconds.
    #[test]
    fn a_busy_planner_is_heard_twenty_then_four_times_a_second() {
        let mut throttle = Throttle::default();
        let passed: Vec<u64> = (0..10_000)
            .filter_map(|ms| throttle.admit(Duration::from_millis(ms), progress(ms)))
            .map(|progress| progress.iteration)
            .collect();
        assert_eq!(passed[..3], [0, 50, 100]);
        assert_eq!(passed.iter().filter(|&&ms| ms < 2000).count(), 40);
        assert_eq!(passed.iter().filter(|&&ms| ms >= 2000).count(), 32);
        assert_eq!(throttle.take_held(), Some(progress(9999)));
        assert_eq!(throttle.take_held(), None);
    }

    #[test]
    fn progress_that_passed_is_not_held_as_well() {
        let mut throttle = Throttle::default();
        assert!(throttle.admit(Duration::ZERO, progress(1)).is_some());
        assert!(throttle.admit(Duration::from_millis(1), progress(2)).is_none());
        assert!(throttle.admit(Duration::from_millis(50), progress(3)).is_some());
        assert_eq!(throttle.take_held(), None);
    }
}
