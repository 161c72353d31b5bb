//! What makes one motion better than another: weights, and several aims at once.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::request::{Clock, ConstraintHandling, DurationGoal, WaypointsTask};
use crate::fault::Faults;
use crate::trajectory::objective::{Measures, ObjectiveName};

/// Weights of time, jerk and energy; at least one is positive.
///
/// The motion minimises `time T/T₀ + rms_jerk J/J₀ + energy E/E₀`, with `T`, `J`
/// and `E` as in a result's `metrics.objective` and `T₀`, `J₀`, `E₀` those of
/// the fastest motion of the same curves within the same limits
/// (`metrics.reference`). So weights have no unit: with 1 and 1, a motion that
/// takes 10 % of `T₀` longer has to save 10 % of `J₀`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectiveWeights {
    /// Weight of the total duration.
    pub time: f64,
    /// Weight of the root mean square jerk.
    pub rms_jerk: f64,
    /// Weight of the mean squared acceleration, which stands for energy: no
    /// robot's dynamics are known, and so no torques.
    pub energy: f64,
}

/// How a front is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ParetoMethod {
    /// Least jerk or energy for each of a list of durations: deterministic and
    /// precise, for two objectives.
    #[default]
    EpsilonConstraint,
    /// The genetic algorithm of Deb et al. 2002 (doi:10.1109/4235.996017), seeded;
    /// for two or three objectives.
    Nsga2,
}

/// Asks for the front of motions of which none is better in one objective
/// without being worse in another. The planned motion itself is still that of
/// `objective`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ParetoRequest {
    /// Two or three different ones, `time` among them: without it slower would
    /// always be better.
    #[schema(min_items = 2, max_items = 3)]
    pub objectives: Vec<ObjectiveName>,
    /// Points wanted, 2 to 200; default 20. There may be fewer where motions
    /// are equally good.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<u32>,
    /// How it is found.
    #[serde(default)]
    pub method: ParetoMethod,
    /// Longest motions considered, as a multiple of the fastest: above 1 to 10,
    /// default 1.5. From where the gentlest proportions are within the limits,
    /// longer motions are these, stretched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_stretch: Option<f64>,
    /// With `nsga2`, candidates per generation: 8 to 400, default 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub population: Option<u32>,
    /// With `nsga2`, generations after the initial one: 1 to 10000, default 200.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub generations: Option<u32>,
}

impl ObjectiveWeights {
    /// Time alone, which needs no weighing.
    pub const TIME: Self = Self { time: 1.0, rms_jerk: 0.0, energy: 0.0 };

    /// True if more than time counts.
    pub fn is_weighted(&self) -> bool {
        self.rms_jerk > 0.0 || self.energy > 0.0
    }

    pub(super) fn measures(self) -> Measures {
        let Self { time, rms_jerk, energy } = self;
        Measures { time, rms_jerk, energy }
    }
}

impl ParetoRequest {
    /// Points wanted.
    pub fn points(&self) -> usize {
        self.points.unwrap_or(20) as usize
    }

    /// Longest motions considered, as a multiple of the fastest.
    pub fn max_stretch(&self) -> f64 {
        self.max_stretch.unwrap_or(1.5)
    }

    /// Candidates per generation of `nsga2`.
    pub fn population(&self) -> usize {
        self.population.unwrap_or(100) as usize
    }

    /// Generations of `nsga2` after the initial one.
    pub fn generations(&self) -> u64 {
        self.generations.unwrap_or(200).into()
    }
}

/// Largest weight taken: more would leave the others no digits.
const LARGEST_WEIGHT: f64 = 1e9;

/// Checks everything a task says about its objectives; `own` tells
/// whether its interpolation leaves nothing to search.
pub(super) fn check(
    task: &WaypointsTask,
    own: Option<&'static str>,
    pointer: &str,
    faults: &mut Faults,
) {
    if let Some(weights) = &task.objective {
        check_weights(weights, &format!("{pointer}/objective"), faults);
        if weights.is_weighted() {
            check_weighted(task, weights, own, pointer, faults);
        }
    }
    if let Some(pareto) = &task.pareto {
        check_pareto(pareto, &format!("{pointer}/pareto"), faults);
        check_front(task, own, pointer, faults);
    }
    if let Some(durations) = &task.fixed_durations {
        check_fixed(task, durations, own, pointer, faults);
    }
}

fn check_weights(weights: &ObjectiveWeights, pointer: &str, faults: &mut Faults) {
    let ObjectiveWeights { time, rms_jerk, energy } = *weights;
    for (name, weight) in [("time", time), ("rms_jerk", rms_jerk), ("energy", energy)] {
        if !(0.0..=LARGEST_WEIGHT).contains(&weight) {
            let detail = format!("weight {weight} is outside 0 to {LARGEST_WEIGHT:e}");
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
    if time + rms_jerk + energy == 0.0 {
        faults.add(pointer, "all weights are 0: at least one has to be positive");
    }
}

fn check_weighted(
    task: &WaypointsTask,
    weights: &ObjectiveWeights,
    own: Option<&'static str>,
    pointer: &str,
    faults: &mut Faults,
) {
    let place = format!("{pointer}/objective");
    if let Some(own) = own {
        faults.add(&place, own_fault(task, own, "weigh"));
    }
    if task.clock == Clock::PerJoint {
        let detail = "weights are for all joints together: use clock shared";
        faults.add(format!("{pointer}/clock"), detail);
    }
    let searches_directions = task.constraint_handling == ConstraintHandling::RepairUniform;
    if !searches_directions && task.optimizer.name != "exact" {
        let detail = "with weights only repair_uniform knows how long a candidate should last";
        faults.add(format!("{pointer}/constraint_handling"), detail);
    }
    if weights.time == 0.0 && task.duration.is_none() && task.durations.is_none() {
        let detail = "without a weight on time the slowest motion would be the best: give time a \
                      weight, or set `duration` or `durations`";
        faults.add(format!("{place}/time"), detail);
    }
}

fn own_fault(task: &WaypointsTask, own: &str, what: &str) -> String {
    let name = &task.interpolation;
    format!("{name} {own}, there is nothing to {what}; quintic is searched")
}

fn check_pareto(pareto: &ParetoRequest, pointer: &str, faults: &mut Faults) {
    let objectives = &pareto.objectives;
    let place = format!("{pointer}/objectives");
    let count = objectives.len();
    if !(2..=3).contains(&count) {
        faults.add(&place, format!("{count} objectives; a front has 2 or 3"));
    }
    for (index, name) in objectives.iter().enumerate() {
        if objectives[..index].contains(name) {
            let detail = format!("{} is named more than once", name.as_str());
            faults.add(format!("{place}/{index}"), detail);
        }
    }
    if !objectives.contains(&ObjectiveName::Time) {
        faults.add(&place, "time is missing: without it slower would always be better");
    }
    let nsga2 = pareto.method == ParetoMethod::Nsga2;
    if count > 2 && !nsga2 {
        let detail = "epsilon_constraint takes time and one more objective; nsga2 takes three";
        faults.add(format!("{pointer}/method"), detail);
    }
    let numbers = [
        ("points", pareto.points, 2, 200, true),
        ("population", pareto.population, 8, 400, nsga2),
        ("generations", pareto.generations, 1, 10_000, nsga2),
    ];
    for (name, value, min, max, used) in numbers {
        let Some(value) = value else { continue };
        if !used {
            let detail = format!("epsilon_constraint has no {name}; it is for method nsga2");
            faults.add(format!("{pointer}/{name}"), detail);
        } else if !(min..=max).contains(&value) {
            let detail = format!("{name} is {value}, outside {min} to {max}");
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
    let stretch = pareto.max_stretch();
    if !(stretch > 1.0 && stretch <= 10.0) {
        let detail = format!("max_stretch is {stretch}, not above 1 and at most 10");
        faults.add(format!("{pointer}/max_stretch"), detail);
    }
}

fn check_front(
    task: &WaypointsTask,
    own: Option<&'static str>,
    pointer: &str,
    faults: &mut Faults,
) {
    if let Some(own) = own {
        faults.add(format!("{pointer}/pareto"), own_fault(task, own, "choose from"));
    }
    if task.clock == Clock::PerJoint {
        let detail = "a front is for all joints together: use clock shared";
        faults.add(format!("{pointer}/clock"), detail);
    }
    if let Some(DurationGoal::Exactly(wanted)) = task.duration {
        let detail =
            format!("a front has motions of many durations, not only {wanted} s; use at_most");
        faults.add(format!("{pointer}/duration"), detail);
    }
    if task.optimizer.name != "exact" {
        let detail = "a front is searched by `pareto.method`: leave out the optimizer";
        faults.add(format!("{pointer}/optimizer"), detail);
    }
}

fn check_fixed(
    task: &WaypointsTask,
    durations: &[f64],
    own: Option<&'static str>,
    pointer: &str,
    faults: &mut Faults,
) {
    use super::prepare::{LONGEST, SHORTEST};
    let place = format!("{pointer}/fixed_durations");
    let (count, segments) = (durations.len(), task.waypoints.len().saturating_sub(1));
    if count != segments {
        faults.add(&place, format!("{count} durations for {segments} segments"));
    }
    for (index, value) in durations.iter().enumerate() {
        if !(SHORTEST..=LONGEST).contains(value) {
            let detail = format!("{value} s is outside {SHORTEST} to {LONGEST} s");
            faults.add(format!("{place}/{index}"), detail);
        }
    }
    if let Some(own) = own {
        let name = &task.interpolation;
        faults.add(&place, format!("{name} {own}: none can be given"));
    }
    let searched = [
        ("objective", task.objective.is_some()),
        ("pareto", task.pareto.is_some()),
        ("durations", task.durations.is_some()),
        ("duration", task.duration.is_some()),
        ("clock", task.clock == Clock::PerJoint),
        ("optimizer", task.optimizer.name != "exact"),
    ];
    for (name, given) in searched {
        if given {
            let detail = format!("with fixed_durations nothing is searched: leave out {name}");
            faults.add(format!("{pointer}/{name}"), detail);
        }
    }
}
