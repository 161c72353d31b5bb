//! The fastest trajectory through waypoints under limits on velocity, acceleration and jerk.

#![allow(missing_docs)]

mod interior_point;
mod layout;
mod newton;
mod problem;
mod profile;
mod refine;
mod stopping;

use super::Trajectory;
use super::kernel::KernelLimits;
use interior_point::{Settings, solve};

/// A fastest trajectory.
#[derive(Clone, Debug)]
pub struct Fastest {
    pub trajectory: Trajectory,
    /// When each waypoint is reached, s.
    pub times: Vec<f64>,
    /// Iterations of both stages.
    pub iterations: [usize; 2],
    /// Whether both stages converged.
    pub converged: bool,
    /// Whether the result stops at every waypoint because nothing faster was found.
    pub stops: bool,
    /// By how much the repair made the motion longer, relative.
    pub loss: f64,
}

/// Cells per segment, first coarse, then where they matter.
const CELLS: [usize; 2] = [12, 32];

/// The fastest trajectory through `waypoints[waypoint][joint]`, from rest to rest.
pub fn fastest(waypoints: &[Vec<f64>], limits: &[KernelLimits]) -> Fastest {
    let ways: Vec<Vec<f64>> = waypoints
        .windows(2)
        .map(|pair| pair[1].iter().zip(&pair[0]).map(|(to, from)| to - from).collect())
        .collect();
    let limits = layout::effective(&ways, limits);
    let mut settings = Settings::default(); settings.verbose = std::env::var("VERB").is_ok();
    settings.mu_end = 1e-5;
    settings.primal = 1.0;
    let (problem, mut point, units) = layout::pose(&ways, &limits, CELLS[0], settings.mu_start);
    let first = solve(&problem, &mut point, &settings);
    let (problem, mut point) = refine::refine(&problem, &point, CELLS[1], 1e-5);
    settings = Settings { mu_start: 1e-5, verbose: settings.verbose, ..Settings::default() };
    let second = solve(&problem, &mut point, &settings);
    let mut best = stopping::stopping(&ways, &limits);
    rescale(&mut best, &limits);
    let mut stops = true;
    let mut found = profile::motion(&problem, &point, &units);
    let loss = found.ratio(&limits) - 1.0;
    rescale(&mut found, &limits);
    if found.duration() < best.duration() {
        best = found;
        stops = false;
    }
    let (trajectory, times) = best.trajectory(waypoints);
    Fastest {
        trajectory,
        times,
        iterations: [first.iterations, second.iterations],
        converged: first.converged && second.converged,
        stops,
        loss,
    }
}

/// Uses the limits exactly, by the scaling law.
fn rescale(motion: &mut profile::Motion, limits: &[KernelLimits]) {
    let ratio = motion.ratio(limits);
    motion.stretch(ratio);
}
