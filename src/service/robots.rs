//! Robots: those of the catalogue and those that users register.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::{ErrorCode, Service, ServiceError, blocking};
use crate::fault::{Faults, read};
use crate::job::{JobsError, Reply};
use crate::robot::{Robot, RobotDescription, catalogue};

/// Keeps the robots that users registered, as JSON text by name.
pub trait RobotStore: Send + Sync {
    /// Stores a robot, in place of an earlier one of that name. True if there
    /// was none.
    fn put_robot(&self, name: &str, json: &str) -> Reply<bool>;

    /// The robot of that name.
    fn robot(&self, name: &str) -> Reply<Option<String>>;

    /// All robots, by name in order.
    fn robots(&self) -> Reply<Vec<(String, String)>>;

    /// Deletes a robot. False if there was none.
    fn delete_robot(&self, name: &str) -> Reply<bool>;
}

/// Where a robot comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotOrigin {
    /// Built in; cannot be replaced or deleted.
    Catalogue,
    /// Registered by a user.
    Registered,
}

/// A robot in the list of all robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotSummary {
    /// Name to use in requests.
    pub name: String,
    /// Where it comes from.
    pub origin: RobotOrigin,
    /// What it is, in a sentence.
    pub description: Option<String>,
    /// Number of joints.
    pub dof: usize,
    /// The joints' names in order.
    pub joint_names: Vec<String>,
    /// True if its kinematics are known.
    pub kinematics: bool,
}

impl RobotSummary {
    fn new(robot: &Robot, origin: RobotOrigin) -> Self {
        Self {
            name: robot.name().to_owned(),
            origin,
            description: robot.description().description.clone(),
            dof: robot.dof(),
            joint_names: robot.joint_names().to_vec(),
            kinematics: robot.kinematics().is_some(),
        }
    }
}

/// A registered robot and whether it is new.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPut {
    /// The robot as it is kept.
    pub robot: RobotDescription,
    /// False if it replaced one of the same name.
    pub created: bool,
}

/// Finds robots by name; for threads that may block.
pub(super) struct Resolver {
    store: Arc<dyn RobotStore>,
    /// A robot that could not be read is not the same as one that is unknown.
    failure: std::cell::Cell<Option<ServiceError>>,
}

impl Resolver {
    pub(super) fn new(store: Arc<dyn RobotStore>) -> Self {
        Self { store, failure: std::cell::Cell::default() }
    }

    /// The robot called `name`, if there is one and it could be read.
    pub(super) fn find(&self, name: &str) -> Option<Arc<Robot>> {
        catalogue::get(name).or_else(|| match self.registered(name) {
            Ok(robot) => robot,
            Err(error) => {
                self.failure.set(Some(error));
                None
            }
        })
    }

    /// Passes `found` on, unless a robot could not be read meanwhile.
    pub(super) fn settle<T>(self, found: Result<T, Faults>) -> Result<T, ServiceError> {
        self.failure.into_inner().map_or_else(|| Ok(found?), Err)
    }

    fn registered(&self, name: &str) -> Result<Option<Arc<Robot>>, ServiceError> {
        let text = self.store.robot(name).wait().map_err(JobsError::from)?;
        text.map(|text| parse_stored(name, &text).map(Arc::new)).transpose()
    }
}

fn parse_stored(name: &str, text: &str) -> Result<Robot, ServiceError> {
    let broken =
        |why: &dyn std::fmt::Display| ServiceError::internal(format!("stored robot {name}: {why}"));
    let description = serde_json::from_str(text).map_err(|error| broken(&error))?;
    Robot::new(description).map_err(|faults| broken(&faults))
}

fn unknown(name: &str) -> ServiceError {
    ServiceError::new(ErrorCode::NotFound, format!("there is no robot `{name}`"))
}

fn built_in(name: &str) -> ServiceError {
    let message = format!(
        "robot `{name}` is part of the catalogue and stays as it is; register yours under another name"
    );
    ServiceError::new(ErrorCode::Conflict, message)
}

/// Reads a robot that is to be called `name`; its own name may be left out.
fn named(name: &str, mut value: Value) -> Result<Robot, Faults> {
    let mut faults = Faults::default();
    if let Value::Object(members) = &mut value {
        match members.get("name").and_then(Value::as_str) {
            Some(other) if other != name => {
                faults.add("/name", format!("`{other}` differs from the address, `{name}`"));
            }
            Some(_) => {}
            None if members.contains_key("name") => {}
            None => {
                members.insert("name".to_owned(), Value::from(name));
            }
        }
    }
    let Some(description) = read::<RobotDescription>(value, "", &mut faults) else {
        return Err(faults);
    };
    match Robot::new(description) {
        Ok(robot) => faults.into_result(robot),
        Err(more) => {
            faults.add_below("", more);
            Err(faults)
        }
    }
}

impl Service {
    /// All robots: the catalogue's, then those registered, each by name.
    ///
    /// # Errors
    ///
    /// If the store fails.
    pub async fn list_robots(&self) -> Result<Vec<RobotSummary>, ServiceError> {
        let stored = self.inner.robots.robots().await.map_err(JobsError::from)?;
        let built_in = catalogue::all().iter();
        let mut all: Vec<_> =
            built_in.map(|robot| RobotSummary::new(robot, RobotOrigin::Catalogue)).collect();
        for (name, text) in stored {
            let robot = parse_stored(&name, &text)?;
            all.push(RobotSummary::new(&robot, RobotOrigin::Registered));
        }
        Ok(all)
    }

    /// The robot called `name`.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], or the store's.
    pub async fn robot(&self, name: &str) -> Result<Arc<Robot>, ServiceError> {
        if let Some(robot) = catalogue::get(name) {
            return Ok(robot);
        }
        let text = self.inner.robots.robot(name).await.map_err(JobsError::from)?;
        let text = text.ok_or_else(|| unknown(name))?;
        parse_stored(name, &text).map(Arc::new)
    }

    /// Registers the robot that `value` describes as `name`, in place of an
    /// earlier one. Jobs already accepted keep the robot they came with.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::Invalid`] with all faults, [`ErrorCode::Conflict`] if the
    /// catalogue has the name, or the store's.
    pub async fn put_robot(&self, name: &str, value: Value) -> Result<RobotPut, ServiceError> {
        if catalogue::get(name).is_some() {
            return Err(built_in(name));
        }
        let robot = named(name, value)?.description().clone();
        let text = serde_json::to_string(&robot).map_err(ServiceError::internal)?;
        let created = self.inner.robots.put_robot(name, &text).await.map_err(JobsError::from)?;
        Ok(RobotPut { robot, created })
    }

    /// Deletes a registered robot. Jobs already accepted keep it.
    ///
    /// # Errors
    ///
    /// [`ErrorCode::NotFound`], [`ErrorCode::Conflict`] if it is the
    /// catalogue's, or the store's.
    pub async fn delete_robot(&self, name: &str) -> Result<(), ServiceError> {
        if catalogue::get(name).is_some() {
            return Err(built_in(name));
        }
        let existed = self.inner.robots.delete_robot(name).await.map_err(JobsError::from)?;
        if existed { Ok(()) } else { Err(unknown(name)) }
    }

    /// Runs `work` on a thread that may block, with a way to find robots.
    pub(super) async fn with_robots<T: Send + 'static>(
        &self,
        work: impl FnOnce(&dyn Fn(&str) -> Option<Arc<Robot>>) -> Result<T, Faults> + Send + 'static,
    ) -> Result<T, ServiceError> {
        let store = self.inner.robots.clone();
        blocking(move || {
            let resolver = Resolver::new(store);
            let found = work(&|name| resolver.find(name));
            resolver.settle(found)
        })
        .await
    }
}
