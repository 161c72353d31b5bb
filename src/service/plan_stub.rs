//! Stands in for planning functions until they are there.

use std::sync::Arc;

use serde_json::Value;

use crate::budget::Budget;
use crate::fault::Faults;
pub use crate::plan::*;
use crate::robot::Robot;

pub struct Progress {
    pub leg: Option<String>,
    pub iteration: u64,
    pub evaluations: u64,
    pub elapsed_s: f64,
    pub best: Option<f64>,
    pub mean: Option<f64>,
    pub lower_bound: Option<f64>,
}

#[derive(Debug)]
pub struct PlanError {
    pub code: &'static str,
    pub message: String,
    pub details: Value,
    pub partial: Option<Box<PlanResult>>,
}

pub struct PreparedPlan {
    task: &'static str,
    robot: Arc<Robot>,
}

pub fn validate(
    request: &PlanRequest,
    robots: &dyn Fn(&str) -> Option<Arc<Robot>>,
) -> Result<PreparedPlan, Faults> {
    let mut faults = Faults::default();
    let robot = match &request.robot {
        RobotRef::Name(name) => robots(name).or_else(|| {
            faults.add("/robot", format!("unknown robot `{name}`"));
            None
        }),
        RobotRef::Inline(robot) => Some(Arc::new(Robot::new((**robot).clone())?)),
    };
    let Some(robot) = robot else { return Err(faults) };
    faults.into_result(PreparedPlan { task: request.task.name(), robot })
}

impl PreparedPlan {
    pub fn run(
        &self,
        budget: &Budget,
        progress: &dyn Fn(Progress),
    ) -> Result<PlanResult, PlanError> {
        progress(Progress {
            leg: None,
            iteration: 1,
            evaluations: 1,
            elapsed_s: budget.elapsed_s(),
            best: Some(1.0),
            mean: None,
            lower_bound: None,
        });
        Err(PlanError {
            code: "limits_unreachable",
            message: "planning is not there yet".into(),
            details: Value::Null,
            partial: None,
        })
    }
    pub fn estimate_s(&self) -> f64 {
        0.01
    }
    pub fn task(&self) -> &str {
        self.task
    }
    pub fn method(&self) -> String {
        "exact".into()
    }
    pub fn robot(&self) -> &str {
        self.robot.name()
    }
}

pub mod verify {
    use super::*;
    use crate::trajectory::Certificate;

    #[derive(utoipa::ToSchema, serde::Serialize)]
    pub struct VerifyRequest {
        pub robot: Value,
    }
    impl VerifyRequest {
        pub fn parse(value: Value) -> Result<Self, Faults> {
            Ok(Self { robot: value })
        }
    }
    pub fn verify(
        _: &VerifyRequest,
        _: &dyn Fn(&str) -> Option<Arc<Robot>>,
    ) -> Result<Certificate, Faults> {
        let mut faults = Faults::default();
        faults.add("", "verification is not there yet");
        Err(faults)
    }
}

pub mod scenarios {
    use serde_json::Value;

    #[derive(utoipa::ToSchema, serde::Serialize, Clone)]
    pub struct Scenario {
        pub name: &'static str,
        pub title: &'static str,
        pub description: &'static str,
        pub source: &'static str,
        pub request: Value,
    }
    pub fn all() -> &'static [Scenario] {
        &[]
    }
}
