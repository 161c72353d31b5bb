//! The true optimum: every joint's motion is free between the waypoints.
//!
//! All there is to it stands in [`crate::trajectory::jerk_limited`].

use super::{Interpolation, Timing};

/// Its registry entry.
pub const ENTRY: Interpolation = Interpolation {
    name: "jerk_limited",
    title: "Free form, the fastest",
    description: "The fastest motion through the waypoints within velocity, acceleration and jerk limits: joints \
                  meet the waypoints together and are free in between, jerk is constant piece by piece. \
                  Needs no optimizer. Without a jerk limit acceleration is constant piece by piece and jumps.",
    source: "Takt; interior point method after Wächter and Biegler 2006, doi:10.1007/s10107-004-0559-y",
    continuity: 2,
    min_segments: 1,
    max_segments: Some(1_999),
    bounded_jerk: true,
    executable: true,
    timing: Timing::Free,
};
