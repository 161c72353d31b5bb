//! Search: `Objective`, `Optimizer`, one `minimize` loop and the registry.
//!
//! Nothing here knows what is optimised. One file per method.

mod aga;
mod cfpso;
mod coa;
mod dual_pso;
mod entry;
mod evaluator;
mod exact;
pub mod front;
pub mod functions;
mod ga;
mod genetic;
mod gold_sa;
mod golds_pso;
mod improved_pso;
mod interior;
mod minimize;
pub mod nsga2;
mod particles;
mod pso;
mod pso_linear;
mod registry;
mod spso;
mod swarm;

pub use entry::{OptimizerEntry, OptimizerInfo, Parameter, ParameterInfo, ParameterKind, Settings};
pub use evaluator::Evaluator;
pub use minimize::{ConvergencePoint, Solution, minimize};
pub use registry::{EXACT, OPTIMIZERS, optimizer, optimizer_names};

use pulp::Arch;

use crate::math::random::RandomStream;

/// What is minimised, over a box.
pub trait Objective: Sync {
    /// The box; one interval per variable.
    fn bounds(&self) -> &Bounds;

    /// Memory and code to evaluate candidates in one thread.
    fn candidate(&self) -> Box<dyn Candidate + '_>;

    /// Roughly how long one evaluation takes, ns; decides whether threads pay.
    fn evaluation_ns(&self) -> f64;

    /// False where others keep all threads busy: candidates are then evaluated
    /// in the calling thread alone.
    fn may_use_threads(&self) -> bool {
        true
    }

    /// Candidates worth starting from; may be empty.
    fn starts(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// Optima of similar problems, worth starting from in addition; may be
    /// empty.
    fn hints(&self) -> &[Vec<f64>] {
        &[]
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

/// An objective for one of many searches that run side by side.
pub struct SideBySide<'a>(pub &'a dyn Objective);

impl Objective for SideBySide<'_> {
    fn bounds(&self) -> &Bounds {
        self.0.bounds()
    }

    fn candidate(&self) -> Box<dyn Candidate + '_> {
        self.0.candidate()
    }

    fn evaluation_ns(&self) -> f64 {
        self.0.evaluation_ns()
    }

    fn may_use_threads(&self) -> bool {
        false
    }

    fn starts(&self) -> Vec<Vec<f64>> {
        self.0.starts()
    }

    fn hints(&self) -> &[Vec<f64>] {
        self.0.hints()
    }

    fn is_homogeneous(&self) -> bool {
        self.0.is_homogeneous()
    }

    fn is_constrained(&self) -> bool {
        self.0.is_constrained()
    }
}

/// Evaluates candidates in one thread.
pub trait Candidate: Send {
    /// The value to minimise; infinite for a candidate that is not to be used.
    fn fitness(&mut self, position: &[f64]) -> f64;

    /// Writes the fitness of several candidates that lie one behind the other;
    /// that of the first is evaluation number `first` of the search. For
    /// objectives that evaluate many at less cost, or with noise, which must not
    /// depend on the thread that evaluates.
    fn batch(&mut self, _first: u64, positions: &[f64], fitness: &mut [f64]) {
        let dimension = positions.len() / fitness.len().max(1);
        for (position, fitness) in positions.chunks_exact(dimension.max(1)).zip(fitness) {
            *fitness = self.fitness(position);
        }
    }

    /// The fitness together with what it is made of, where the objective can
    /// tell cost and broken constraints apart; by default all of it is cost.
    fn appraise(&mut self, position: &[f64]) -> Appraisal {
        let fitness = self.fitness(position);
        Appraisal { fitness, cost: fitness, excess: 0.0 }
    }

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

/// A candidate's fitness and its parts, for methods that weigh them otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appraisal {
    /// The value to minimise, as of [`Candidate::fitness`].
    pub fitness: f64,
    /// What it costs, broken constraints aside.
    pub cost: f64,
    /// Sum of the squared relative excesses over the limits; zero if all are kept.
    pub excess: f64,
}

impl Appraisal {
    /// That of a candidate that is not to be used.
    pub const UNUSABLE: Self =
        Self { fitness: f64::INFINITY, cost: f64::INFINITY, excess: f64::INFINITY };
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

    /// Puts every candidate of `positions` at a random place of the box.
    pub fn scatter(&self, positions: &mut [f64], random: &mut RandomStream) {
        for candidate in positions.chunks_exact_mut(self.dimension()) {
            for ((x, &lower), &upper) in candidate.iter_mut().zip(&self.lower).zip(&self.upper) {
                *x = random.uniform(lower, upper);
            }
        }
    }

    /// Moves every component of `positions` that left the box to its edge.
    pub fn clamp(&self, positions: &mut [f64]) {
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for candidate in positions.chunks_exact_mut(self.dimension()) {
                    let ends = self.lower.iter().zip(&self.upper);
                    for (x, (&lower, &upper)) in candidate.iter_mut().zip(ends) {
                        // Without a branch, so that registers are filled.
                        let raised = if *x < lower { lower } else { *x };
                        *x = if raised > upper { upper } else { raised };
                    }
                }
            },
        );
    }

    /// The middle of the box.
    pub fn centre(&self) -> Vec<f64> {
        self.lower.iter().zip(&self.upper).map(|(lower, upper)| 0.5 * (lower + upper)).collect()
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
