//! Working memory of the Newton steps.

use crate::math::lanes::Lanes;

use super::chain::ROWS;
use super::problem::{Cell, Problem};

/// Most segments of one programme.
pub const MAX_SEGMENTS: usize = 16;

/// Columns: what is known, one per duration, three multipliers.
pub const COLUMNS: usize = MAX_SEGMENTS + 4;

/// What the forward pass needs of a cell: `u = -(state s + columns)`.
#[derive(Clone, Copy)]
pub struct Gain {
    pub state: [Lanes; 3],
    /// How much acceleration changes along with the segment's duration.
    pub lean: Lanes,
}

/// A multiplier as a function of columns before it and the state.
#[derive(Clone, Copy)]
pub struct Elimination {
    pub columns: [Lanes; COLUMNS],
    pub state: [Lanes; 3],
}

/// Working memory for one problem.
pub struct Work {
    /// `[group][cell]`.
    pub gains: Vec<Gain>,
    /// `[group][cell][column]`, `stride` columns each.
    pub columns: Vec<Lanes>,
    pub stride: usize,
    /// One over each slack, `[group][cell]`: to divide is what costs most in a step, so it is done once.
    pub inverses: Vec<[Lanes; ROWS]>,
    /// The same of deviations where segments end, `[group * segments + segment]`.
    pub berth_inverses: Vec<[Lanes; 2]>,
    /// `[group][segment][3]`.
    pub eliminations: Vec<Elimination>,
    /// Curvature over durations `[row][column]`, summed over joints.
    pub curvature: Vec<f64>,
    /// The model's slope over durations, summed over joints.
    pub slope: Vec<f64>,
    /// The Lagrangian's slope over durations, without the objective.
    pub gradient: Vec<f64>,
    /// The Lagrangian's slope over the state where a segment starts:
    /// `[group * segments + segment]`.
    pub prices: Vec<[Lanes; 3]>,
    /// Steps of the cells.
    pub steps: Vec<Cell>,
    /// Steps of the multipliers of deviations, as in [`Iterate`].
    pub berths: Vec<[Lanes; 2]>,
    /// Steps of the durations.
    pub durations: Vec<f64>,
    /// New multipliers, as in [`Iterate`].
    pub lambda: Vec<Lanes>,
    pub goal: Vec<[Lanes; 2]>,
}

impl Work {
    /// Memory for `problem`.
    pub fn new(problem: &Problem) -> Self {
        let (n, groups) = (problem.segments, problem.groups.len());
        let cells = n * problem.cells * groups;
        let zero = Lanes::ZERO;
        let stride = n + 4;
        let none = Elimination { columns: [zero; COLUMNS], state: [zero; 3] };
        Self {
            gains: vec![Gain { state: [zero; 3], lean: zero }; cells],
            columns: vec![zero; cells * stride],
            stride,
            inverses: vec![[zero; ROWS]; cells],
            berth_inverses: vec![[zero; 2]; n * groups],
            eliminations: vec![none; n * groups * 3],
            curvature: vec![0.0; n * n],
            slope: vec![0.0; n],
            gradient: vec![0.0; n],
            prices: vec![[zero; 3]; n * groups],
            steps: vec![Cell::ZERO; cells],
            berths: vec![[zero; 2]; n * groups],
            durations: vec![0.0; n],
            lambda: vec![zero; n * groups],
            goal: vec![[zero; 2]; groups],
        }
    }
}

/// How far the point is from the solution of its barrier problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct Residuals {
    /// Largest slope of the Lagrangian over what a variable can change.
    pub dual: f64,
    /// Largest miss of the dynamics.
    pub primal: f64,
    /// Sum of all misses.
    pub sum: f64,
    /// Largest product of a slack and its multiplier.
    pub product: f64,
}

impl Residuals {
    /// Those of both.
    pub fn include(&mut self, other: &Self) {
        self.dual = self.dual.max(other.dual);
        self.primal = self.primal.max(other.primal);
        self.sum += other.sum;
        self.product = self.product.max(other.product);
    }
}
