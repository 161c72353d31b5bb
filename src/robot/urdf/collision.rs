//! Solids and the pairs of links that are never checked.

use std::collections::{BTreeMap, HashSet};

use super::chain::Chained;
use super::document::Document;
use crate::geometry::{Placed, Pose};

/// Gives `chained` the document's solids, and the pairs of its links that `disabled` takes out altogether.
pub(super) fn attach(document: &Document, chained: &mut Chained, disabled: &[[String; 2]]) {
    let mut missing = Vec::new();
    // The document's links that have solids, by the link of the chain they move with.
    let mut solid: BTreeMap<usize, Vec<&str>> = BTreeMap::new();
    for link in &document.links {
        let Some((body, place)) = chained.places.get(&link.name) else { continue };
        for collision in &link.collisions {
            match &collision.shape {
                Ok(shape) => {
                    let pose = Pose::from(&(*place * collision.origin));
                    chained.robot.geometry.push((*body, Placed { shape: shape.clone(), pose }));
                    solid.entry(*body).or_default().push(&link.name);
                }
                Err(file) => missing.push(format!("{} ({file})", link.name)),
            }
        }
    }
    chained.robot.geometry.sort_by_key(|(body, _)| *body);
    if !missing.is_empty() {
        chained.robot.notes.push(format!(
            "Meshes are files that did not come with the URDF, so these links have no shape for collision checks: {}.",
            missing.join(", ")
        ));
    }
    let disabled: HashSet<[&str; 2]> =
        disabled.iter().flat_map(|[a, b]| [[a.as_str(), b], [b.as_str(), a]]).collect();
    for (&first, links) in &solid {
        for (&second, others) in solid.range(first + 1..) {
            let mut pairs = links.iter().flat_map(|a| others.iter().map(move |b| [*a, *b]));
            // One pair that has to be checked keeps the two links apart.
            if pairs.all(|pair| disabled.contains(&pair)) {
                chained.robot.allowed_pairs.push([first, second]);
            }
        }
    }
}
