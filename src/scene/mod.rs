//! What stands around a robot, and what it carries.
//!
//! A [`SceneDescription`] is what people write; [`Scene::new`] checks it once, and what comes out never changes. What
//! a scene says about a robot's links is checked when both meet, in `collision`.

mod description;
mod moveit;
mod validation;

pub use description::{AttachedObject, Obstacle, SceneDescription};

use crate::fault::Faults;

/// A scene whose description was found valid; it never changes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    description: SceneDescription,
}

impl Scene {
    /// The most obstacles a scene may have, and the most objects a robot may carry.
    pub const MAX_OBSTACLES: usize = 10_000;

    /// Checks `description`.
    ///
    /// # Errors
    ///
    /// All faults together, their pointers relative to the description.
    pub fn new(description: SceneDescription) -> Result<Self, Faults> {
        validation::check(&description)?;
        Ok(Self { description })
    }

    /// The scene's name.
    pub fn name(&self) -> &str {
        &self.description.name
    }

    /// What stands around the robot, in the world.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.description.obstacles
    }

    /// What the robot carries.
    pub fn attached(&self) -> &[AttachedObject] {
        &self.description.attached
    }

    /// Pairs that may touch, by name.
    pub fn allowed_pairs(&self) -> &[[String; 2]] {
        &self.description.allowed_pairs
    }

    /// The description the scene was built from.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }
}
