//! Runs a prepared plan: one arm per task.

use super::error::PlanError;
use super::prepared::{PreparedPlan, PreparedTask, Progress};
use super::result::PlanResult;
use super::{family, motion, path, program, study, waypoints};
use crate::budget::Budget;

impl PreparedPlan {
    /// Plans. `progress` is called after every generation, of many runs side by
    /// side about every millisecond; perhaps from several threads.
    ///
    /// # Errors
    ///
    /// If the limits do not admit what was asked, or `budget` ends the run;
    /// with what exists of the plan.
    pub fn run(
        &self,
        budget: &Budget,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<PlanResult, PlanError> {
        match &self.task {
            PreparedTask::Waypoints(task) => {
                let result = waypoints::plan(self, task, self.seed, budget, progress)?;
                Ok(PlanResult::Trajectory(Box::new(result)))
            }
            PreparedTask::Path(task) => path::run(task, self.seed, budget, progress),
            PreparedTask::Motion(task) => motion::run(self, task, self.seed, budget, progress),
            PreparedTask::Program(legs) => program::plan(self, legs, budget, progress),
            PreparedTask::Family(members) => family::run(members, self.seed, budget, progress),
            PreparedTask::Study(study) => study::run(study, self.seed, budget, progress),
        }
    }
}
