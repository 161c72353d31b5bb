//! NSGA-II: the front of a problem with several objectives.
//!
//! Deb, Pratap, Agarwal and Meyarivan 2002, doi:10.1109/4235.996017: fast
//! non-dominated sorting, crowding distance, binary tournaments by both, with
//! constrained domination; simulated binary crossover and polynomial mutation as
//! in their real-coded version (probabilities 0.9 and 1/n, indices 20).
//! Deviations: given starts join the first generation, and the best points seen
//! are thinned to a wanted number by crowding, one at a time.

use super::Bounds;
use super::front::{crowding, dominates, non_dominated_sort, thin};
use crate::budget::{Budget, StopReason};
use crate::math::random::RandomStream;

/// Several objectives over a box, all to be minimised.
pub trait MultiObjective {
    /// The box; one interval per variable.
    fn bounds(&self) -> &Bounds;

    /// Number of objectives.
    fn objectives(&self) -> usize;

    /// Writes the objectives of a candidate and returns by how much it breaks
    /// the constraints, zero or less if it keeps them.
    fn evaluate(&mut self, position: &[f64], values: &mut [f64]) -> f64;
}

/// How [`nsga2`] searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nsga2 {
    /// Candidates per generation, at least 4.
    pub population: usize,
    /// Generations after the initial one.
    pub generations: u64,
    /// Points wanted at the end, at most.
    pub points: usize,
    /// Seed of the random stream.
    pub seed: u64,
}

/// What [`nsga2`] found.
#[derive(Clone, Debug, PartialEq)]
pub struct Front {
    /// Positions and values, mutually non-dominated, by the first objective.
    pub members: Vec<(Vec<f64>, Vec<f64>)>,
    /// Why the search ended.
    pub stop_reason: StopReason,
    /// Candidates evaluated.
    pub evaluations: u64,
}

/// Probability that two parents are crossed.
const CROSSOVER: f64 = 0.9;

/// Distribution index of crossover and mutation: large ones stay near.
const INDEX: f64 = 20.0;

/// A candidate with what is known of it.
#[derive(Clone, Debug)]
struct Member {
    position: Vec<f64>,
    values: Vec<f64>,
    violation: f64,
    rank: usize,
    crowding: f64,
}

/// Searches the front; `progress` sees every generation and its evaluations.
///
/// The same seed gives the same front. Candidates outside the constraints are
/// never part of it.
pub fn nsga2(
    problem: &mut dyn MultiObjective,
    settings: &Nsga2,
    starts: &[Vec<f64>],
    budget: &Budget,
    progress: &mut dyn FnMut(u64, u64),
) -> Front {
    let mut search = Search {
        problem,
        budget,
        random: RandomStream::new(settings.seed, 0),
        evaluations: 0,
        stopped: None,
    };
    let mut population = search.initial(settings.population, starts);
    rank(&mut population);
    progress(0, search.evaluations);
    for generation in 1..=settings.generations {
        if search.stopped.is_some() || population.is_empty() {
            break;
        }
        let children = search.children(&population, settings.population);
        if children.is_empty() {
            break;
        }
        population.extend(children);
        population = survivors(population, settings.population);
        progress(generation, search.evaluations);
    }
    population.retain(|member| member.rank == 0 && member.violation <= 0.0);
    let mut members: Vec<_> = population.into_iter().map(|m| (m.position, m.values)).collect();
    members.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    members.dedup_by(|a, b| a.1 == b.1);
    thin(&mut members, settings.points, |member| &member.1);
    let stop_reason = search.stopped.unwrap_or(StopReason::IterationLimit);
    Front { members, stop_reason, evaluations: search.evaluations }
}

struct Search<'a> {
    problem: &'a mut dyn MultiObjective,
    budget: &'a Budget,
    random: RandomStream,
    evaluations: u64,
    stopped: Option<StopReason>,
}

impl Search<'_> {
    /// Evaluates a position; none once the search has to end.
    fn member(&mut self, position: Vec<f64>) -> Option<Member> {
        self.stopped = self.stopped.or_else(|| self.budget.stop_reason(self.evaluations));
        if self.stopped.is_some() {
            return None;
        }
        self.evaluations += 1;
        let mut values = vec![0.0; self.problem.objectives()];
        let violation = self.problem.evaluate(&position, &mut values);
        let undefined = violation.is_nan() || !values.iter().all(|value| value.is_finite());
        let violation = if undefined { f64::INFINITY } else { violation };
        Some(Member { position, values, violation, rank: 0, crowding: 0.0 })
    }

    fn initial(&mut self, count: usize, starts: &[Vec<f64>]) -> Vec<Member> {
        let Bounds { lower, upper } = self.problem.bounds().clone();
        let mut members = Vec::with_capacity(count);
        for index in 0..count {
            let position = match starts.get(index) {
                Some(start) => inside(start, &lower, &upper),
                None => {
                    let ends = lower.iter().zip(&upper);
                    ends.map(|(&low, &high)| self.random.uniform(low, high)).collect()
                }
            };
            let Some(member) = self.member(position) else { break };
            members.push(member);
        }
        members
    }

    fn children(&mut self, parents: &[Member], count: usize) -> Vec<Member> {
        let mut children = Vec::with_capacity(count);
        while children.len() < count {
            let [a, b] = [self.tournament(parents), self.tournament(parents)];
            let pair = self.cross(&parents[a].position, &parents[b].position);
            for mut position in pair {
                self.mutate(&mut position);
                let Some(member) = self.member(position) else { return children };
                children.push(member);
            }
        }
        children.truncate(count);
        children
    }

    /// The better of two drawn at random: by rank, then by space around it.
    fn tournament(&mut self, members: &[Member]) -> usize {
        let count = members.len();
        let mut draw = || ((self.random.unit() * count as f64) as usize).min(count - 1);
        let [a, b] = [draw(), draw()];
        let key = |index: usize| (members[index].rank, -members[index].crowding);
        if key(b) < key(a) { b } else { a }
    }

    /// Simulated binary crossover within the box.
    fn cross(&mut self, first: &[f64], second: &[f64]) -> [Vec<f64>; 2] {
        let Bounds { lower, upper } = self.problem.bounds().clone();
        let mut pair = [first.to_vec(), second.to_vec()];
        if self.random.unit() > CROSSOVER {
            return pair;
        }
        for i in 0..first.len() {
            let (low, high) = (first[i].min(second[i]), first[i].max(second[i]));
            if self.random.unit() > 0.5 || high - low < 1e-14 {
                continue;
            }
            let draw = self.random.unit();
            // The nearer a bound, the less a child may leave its parents.
            let child = |room: f64, side: f64| {
                let alpha = 2.0 - libm::pow(1.0 + 2.0 * room / (high - low), -(INDEX + 1.0));
                let base = draw * alpha;
                let base = if base <= 1.0 { base } else { 1.0 / (2.0 - base) };
                let spread = libm::pow(base, 1.0 / (INDEX + 1.0));
                (0.5 * (low + high + side * spread * (high - low))).clamp(lower[i], upper[i])
            };
            let children = [child(low - lower[i], -1.0), child(upper[i] - high, 1.0)];
            let swap = usize::from(self.random.unit() < 0.5);
            pair[0][i] = children[swap];
            pair[1][i] = children[1 - swap];
        }
        pair
    }

    /// Polynomial mutation, one variable in the mean.
    fn mutate(&mut self, position: &mut [f64]) {
        let probability = 1.0 / position.len() as f64;
        for (i, x) in position.iter_mut().enumerate() {
            if self.random.unit() >= probability {
                continue;
            }
            let bounds = self.problem.bounds();
            let (lower, upper) = (bounds.lower[i], bounds.upper[i]);
            let width = upper - lower;
            let draw = self.random.unit();
            let step = if draw < 0.5 {
                let rest = libm::pow(1.0 - (*x - lower) / width, INDEX + 1.0);
                libm::pow(2.0 * draw + (1.0 - 2.0 * draw) * rest, 1.0 / (INDEX + 1.0)) - 1.0
            } else {
                let rest = libm::pow(1.0 - (upper - *x) / width, INDEX + 1.0);
                let base = 2.0 * (1.0 - draw) + (2.0 * draw - 1.0) * rest;
                1.0 - libm::pow(base, 1.0 / (INDEX + 1.0))
            };
            *x = (*x + step * width).clamp(lower, upper);
        }
    }
}

fn inside(position: &[f64], lower: &[f64], upper: &[f64]) -> Vec<f64> {
    let ends = lower.iter().zip(upper);
    position.iter().zip(ends).map(|(x, (low, high))| x.clamp(*low, *high)).collect()
}

/// A feasible candidate beats an infeasible one, a less infeasible one a more
/// infeasible one; among feasible ones domination decides.
fn beats(a: &Member, b: &Member) -> bool {
    let (broken_a, broken_b) = (a.violation.max(0.0), b.violation.max(0.0));
    if broken_a > 0.0 || broken_b > 0.0 {
        return broken_a < broken_b;
    }
    dominates(&a.values, &b.values)
}

/// Writes rank and crowding distance; returns the indices by rank.
fn rank(members: &mut [Member]) -> Vec<Vec<usize>> {
    let fronts = non_dominated_sort(members.len(), |a, b| beats(&members[a], &members[b]));
    for (rank, front) in fronts.iter().enumerate() {
        let values: Vec<&[f64]> = front.iter().map(|i| members[*i].values.as_slice()).collect();
        let distances = crowding(&values);
        for (index, distance) in front.iter().zip(distances) {
            members[*index].rank = rank;
            members[*index].crowding = distance;
        }
    }
    fronts
}

/// The next generation: whole fronts while they fit, then the least crowded.
fn survivors(mut members: Vec<Member>, count: usize) -> Vec<Member> {
    rank(&mut members);
    // Stable, so that equal ones keep their order.
    members.sort_by(|a, b| a.rank.cmp(&b.rank).then(b.crowding.total_cmp(&a.crowding)));
    members.truncate(count);
    members
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Function {
        bounds: Bounds,
        function: fn(&[f64], &mut [f64]) -> f64,
    }

    impl MultiObjective for Function {
        fn bounds(&self) -> &Bounds {
            &self.bounds
        }

        fn objectives(&self) -> usize {
            2
        }

        fn evaluate(&mut self, position: &[f64], values: &mut [f64]) -> f64 {
            (self.function)(position, values)
        }
    }

    fn run(
        lower: f64,
        upper: f64,
        dimension: usize,
        generations: u64,
        function: fn(&[f64], &mut [f64]) -> f64,
    ) -> Front {
        let bounds = Bounds { lower: vec![lower; dimension], upper: vec![upper; dimension] };
        let mut problem = Function { bounds, function };
        let settings = Nsga2 { population: 100, generations, points: 40, seed: 3 };
        nsga2(&mut problem, &settings, &[], &Budget::default(), &mut |_, _| {})
    }

    fn zdt1(x: &[f64], values: &mut [f64]) -> f64 {
        let g = 1.0 + 9.0 * x[1..].iter().sum::<f64>() / (x.len() - 1) as f64;
        values[0] = x[0];
        values[1] = g * (1.0 - (x[0] / g).sqrt());
        0.0
    }

    /// The paper's SCH: the front is `x` in [0, 2], `(sqrt(f1) - 2)² = f2`.
    #[test]
    fn finds_schaffers_front() {
        let front = run(-1000.0, 1000.0, 1, 150, |x, values| {
            values.copy_from_slice(&[x[0] * x[0], (x[0] - 2.0) * (x[0] - 2.0)]);
            0.0
        });
        assert_eq!(front.members.len(), 40);
        for (_, values) in &front.members {
            assert!((values[1].sqrt() + values[0].sqrt() - 2.0).abs() < 1e-6, "{values:?}");
        }
        let ends = [&front.members[0].1, &front.members[39].1];
        assert!(ends[0][0] < 0.01 && ends[1][1] < 0.01, "{ends:?}");
        let gaps = front.members.windows(2).map(|pair| pair[1].1[0] - pair[0].1[0]);
        assert!(gaps.fold(0.0, f64::max) < 0.5, "spread evenly");
    }

    /// The paper's ZDT1 with 30 variables: the front is `f2 = 1 - sqrt(f1)`; its
    /// Table II tells a mean distance of 0.033 after 250 generations.
    #[test]
    fn finds_the_front_of_zdt1() {
        let front = run(0.0, 1.0, 30, 250, zdt1);
        assert_eq!(front.evaluations, 25_100);
        let off = |values: &[f64]| values[1] - (1.0 - values[0].sqrt());
        let mean = front.members.iter().map(|m| off(&m.1)).sum::<f64>() / 40.0;
        assert!(front.members.len() == 40 && (0.0..0.033).contains(&mean), "{mean}");
        assert!(front.members[0].1[0] < 0.02 && front.members[39].1[0] > 0.9);
    }

    #[test]
    fn keeps_constraints() {
        // Only points on or above the line `f1 + f2 = 1.5` count.
        let front = run(0.0, 2.0, 2, 100, |x, values| {
            values.copy_from_slice(x);
            1.5 - x[0] - x[1]
        });
        for (_, values) in &front.members {
            let sum = values[0] + values[1];
            assert!((1.5 - 1e-12..1.53).contains(&sum), "{values:?}");
        }
        let none = run(0.0, 1.0, 2, 5, |x, values| {
            values.copy_from_slice(x);
            f64::NAN
        });
        assert!(none.members.is_empty());
    }

    #[test]
    fn repeats_and_obeys_its_budget() {
        assert_eq!(run(0.0, 1.0, 5, 20, zdt1), run(0.0, 1.0, 5, 20, zdt1));
        let bounds = Bounds { lower: vec![0.0; 5], upper: vec![1.0; 5] };
        let mut problem = Function { bounds, function: zdt1 };
        let settings = Nsga2 { population: 100, generations: 50, points: 10, seed: 3 };
        let budget = Budget::default().with_max_evaluations(Some(250));
        let front = nsga2(&mut problem, &settings, &[], &budget, &mut |_, _| {});
        assert_eq!(front.evaluations, 250);
        assert_eq!(front.stop_reason, StopReason::EvaluationLimit);
        assert!(!front.members.is_empty() && front.members.len() <= 10);
    }
}
