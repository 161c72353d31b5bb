//! Pairs of links that an SRDF takes out of the collision checks.

use super::xml;

/// The pairs of links whose check is disabled, by name.
pub(super) fn read(text: &str) -> Result<Vec<[String; 2]>, String> {
    let document = xml::document(text)?;
    let pair = |node| {
        let link = |name| Ok::<_, String>(xml::required(node, name)?.trim().to_owned());
        Ok([link("link1")?, link("link2")?])
    };
    xml::children(document.root_element(), "disable_collisions").map(pair).collect()
}
