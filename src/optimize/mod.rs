//! Search: `Objective`, `Optimizer`, one `minimize` loop and the registry.
//!
//! Nothing here knows what is optimised. One file per method.

mod entry;
mod evaluator;
mod exact;
pub mod front;
mod improved_pso;
mod interior;
mod minimize;
pub mod nsga2;
mod pso;
mod pso_linear;
mod registry;
mod swarm;

pub use entry::{OptimizerEntry, OptimizerInfo, Parameter, ParameterInfo, ParameterKind, Settings};
pub use evaluator::Evaluator;
pub use minimize::{ConvergencePoint, Solution, minimize};
pub use registry::{OPTIMIZERS, optimizer, optimizer_names};

/// What is minimised, over a box.
pub trait Objective: Sync {
    /// The box; one interval per variable.
    fn bounds(&self) -> &Bounds;

    /// Memory and code to evaluate candidates in one thread.
    fn candidate(&self) -> Box<dyn Candidate + '_>;

    /// Roughly how long one evaluation takes, ns; decides whether threads pay.
    fn evaluation_ns(&self) -> f64;

    /// Candidates worth starting from; may be empty.
    fn starts(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// True if [`Candidate::homogeneous`] is offered.
    fn is_homogeneous(&self) -> bool {
        false
    }

    /// True if [`Candidate::constrained`] and [`Candidate::scale`] are offered.
    fn is_constrained(&self) -> bool {
        false
    }
}

/// Evaluates candidates in one thread.
pub trait Candidate: Send {
    /// The value to minimise; infinite for a candidate that is not to be used.
    fn fitness(&mut self, position: &[f64]) -> f64;

    /// Moves a candidate that breaks a constraint to one nearby that does not.
    fn repair(&mut self, _position: &mut [f64]) {}

    /// For problems `minimise sum(x) subject to r_k(x) <= 1` whose nonnegative
    /// constraint functions obey a scaling law: writes all of them.
    ///
    /// Returns a measure of what no scaling can mend, positive if broken.
    /// Only called where [`Objective::is_homogeneous`].
    fn homogeneous(&mut self, _position: &[f64], ratios: &mut Ratios) -> f64 {
        ratios.iter_mut().for_each(Vec::clear);
        f64::INFINITY
    }

    /// For problems `minimise f(x) subject to g_k(x) <= 1` over positive `x`
    /// with a positive `f`, all of them smooth but for kinks: writes the `g_k`
    /// and returns `f`.
    ///
    /// Only called where [`Objective::is_constrained`].
    fn constrained(&mut self, _position: &[f64], constraints: &mut Vec<f64>) -> f64 {
        constraints.clear();
        f64::INFINITY
    }

    /// The multiple of a candidate that its fitness speaks of.
    fn scale(&mut self, _position: &[f64]) -> f64 {
        1.0
    }
}

/// Constraint functions by degree: those in list `d - 1` obey
/// `r(s x) = r(x) / s^d`.
pub type Ratios = [Vec<f64>; 3];

/// A box.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower ends.
    pub lower: Vec<f64>,
    /// Upper ends, each above its lower end.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// Number of variables.
    pub fn dimension(&self) -> usize {
        self.lower.len()
    }
}

/// How one generation follows from the last. The loop around it, limits,
/// counting and progress are [`minimize`]'s.
pub trait Optimizer {
    /// Makes and evaluates the next generation; the first call the initial one.
    fn step(&mut self, evaluator: &mut Evaluator<'_>) -> Step;
}

/// What a generation came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Mean fitness of the generation's feasible candidates.
    pub mean: Option<f64>,
    /// True if there is nothing left to improve.
    pub converged: bool,
}
