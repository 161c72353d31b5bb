//! What makes a scene valid.

use std::collections::HashMap;

use super::{Scene, SceneDescription};
use crate::fault::Faults;
use crate::geometry::{check_pose, check_shape};

/// Longest name, in characters.
const MAX_NAME: usize = 64;

/// Finds every fault of `description`.
pub(super) fn check(description: &SceneDescription) -> Result<(), Faults> {
    let mut faults = Faults::default();
    check_scene_name(&description.name, &mut faults);
    for (count, list) in
        [(description.obstacles.len(), "obstacles"), (description.attached.len(), "attached")]
    {
        if count > Scene::MAX_OBSTACLES {
            let most = Scene::MAX_OBSTACLES;
            faults.add(format!("/{list}"), format!("{count} objects, but must be at most {most}"));
            return faults.into_result(());
        }
    }
    let mut taken = HashMap::new();
    for (index, obstacle) in description.obstacles.iter().enumerate() {
        let pointer = format!("/obstacles/{index}");
        check_name(&obstacle.name, &pointer, &mut taken, &mut faults);
        check_shape(&obstacle.shape, &format!("{pointer}/shape"), &obstacle.name, &mut faults);
        check_pose(&obstacle.pose, &format!("{pointer}/pose"), &obstacle.name, &mut faults);
    }
    for (index, object) in description.attached.iter().enumerate() {
        let pointer = format!("/attached/{index}");
        check_name(&object.name, &pointer, &mut taken, &mut faults);
        check_shape(&object.shape, &format!("{pointer}/shape"), &object.name, &mut faults);
        check_pose(&object.pose, &format!("{pointer}/pose"), &object.name, &mut faults);
    }
    faults.into_result(())
}

fn check_scene_name(name: &str, faults: &mut Faults) {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_.-".contains(c);
    let well_formed = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(allowed)
        && name.len() <= MAX_NAME;
    if !well_formed {
        let detail = format!(
            "name {name:?} must start with a letter a-z and go on with at most {} of a-z 0-9 _ . -",
            MAX_NAME - 1
        );
        faults.add("/name", detail);
    }
}

fn check_name<'a>(
    name: &'a str,
    pointer: &str,
    taken: &mut HashMap<&'a str, String>,
    faults: &mut Faults,
) {
    let length = name.chars().count();
    if name.trim().is_empty() || length > MAX_NAME || name.chars().any(char::is_control) {
        let detail =
            format!("name {name:?} must have 1 to {MAX_NAME} characters, none a control character");
        faults.add(format!("{pointer}/name"), detail);
    } else if let Some(first) = taken.insert(name, pointer.to_owned()) {
        faults.add(format!("{pointer}/name"), format!("name {name:?} is taken by {first}"));
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_scene_survives_the_way_through_json() {
        let description: SceneDescription = serde_json::from_value(json!({
            "name": "cell-3",
            "obstacles": [{"name": "table", "shape": {"type": "box", "size": [1, 1, 0.1]},
                "pose": {"position": [0, 0, -0.05]}}],
            "attached": [{"name": "cup", "shape": {"type": "cylinder", "radius": 0.04, "length": 0.1}}],
            "allowed_pairs": [["table", "link_0"]],
        }))
        .unwrap();
        let scene = Scene::new(description.clone()).unwrap();
        let text = serde_json::to_string(scene.description()).unwrap();
        assert_eq!(serde_json::from_str::<SceneDescription>(&text).unwrap(), description);
        assert_eq!((scene.name(), scene.obstacles().len()), ("cell-3", 1));
        assert_eq!(Scene::default().obstacles().len(), 0);
    }

    #[test]
    fn all_faults_come_together() {
        let sphere = json!({"type": "sphere", "radius": 0.1});
        let description: SceneDescription = serde_json::from_value(json!({
            "name": "Cell",
            "obstacles": [
                {"name": "a", "shape": sphere, "pose": {"orientation": [0, 0, 0, 2]}},
                {"name": "", "shape": {"type": "box", "size": [1, -1, 1]}},
            ],
            "attached": [{"name": "a", "shape": sphere, "pose": {"position": [5000, 0, 0]}}],
        }))
        .unwrap();
        let faults = Scene::new(description).unwrap_err();
        let pointers: Vec<_> = faults.0.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(
            pointers,
            [
                "/name",
                "/obstacles/0/pose/orientation",
                "/obstacles/1/name",
                "/obstacles/1/shape/size/1",
                "/attached/0/name",
                "/attached/0/pose/position/0",
            ]
        );
        assert!(faults.0[4].detail.contains("taken by /obstacles/0"), "{faults}");
    }
}
