//! Reading XML: elements, attributes and numbers, with the line of what is wrong.

use nalgebra::Vector3;
use roxmltree::{Document, Node, ParsingOptions};

use crate::geometry::Transform;

/// Longest document, in bytes.
const MAX_BYTES: usize = 4 << 20;
/// Most elements, attributes and texts.
const MAX_NODES: u32 = 200_000;

/// Reads a document whose root element is `robot`.
pub(super) fn document(text: &str) -> Result<Document<'_>, String> {
    if text.len() > MAX_BYTES {
        return Err(format!("{} bytes, but must be at most {MAX_BYTES}", text.len()));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let hint =
            if text.contains("xacro:") { "; xacro files must be processed first" } else { "" };
        format!("not a well-formed XML document: {error}{hint}")
    })?;
    match document.root_element().tag_name().name() {
        "robot" => Ok(document),
        other => Err(format!("the root element is <{other}>, but must be <robot>")),
    }
}

/// `problem` with the line it was found in.
pub(super) fn at(node: Node<'_, '_>, problem: impl std::fmt::Display) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    format!("line {line}: {problem}")
}

/// The elements called `name` directly below `node`.
pub(super) fn children<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The first element called `name` directly below `node`.
pub(super) fn child<'a, 'input>(
    node: Node<'a, 'input>,
    name: &'static str,
) -> Option<Node<'a, 'input>> {
    children(node, name).next()
}

/// An attribute that must be there.
pub(super) fn required<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, String> {
    let missing = || at(node, format!("<{}> has no {name}", node.tag_name().name()));
    node.attribute(name).ok_or_else(missing)
}

/// The name an element gives itself: not empty.
pub(super) fn name(node: Node<'_, '_>) -> Result<String, String> {
    let name = required(node, "name")?.trim();
    if name.is_empty() {
        return Err(at(node, format!("<{}> has an empty name", node.tag_name().name())));
    }
    Ok(name.to_owned())
}

/// A finite number, if the attribute is there.
pub(super) fn number(node: Node<'_, '_>, name: &str) -> Result<Option<f64>, String> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let problem = || at(node, format!("{name}={text:?} must be a finite number"));
    number.map(Some).ok_or_else(problem)
}

/// Three finite numbers, if the attribute is there.
pub(super) fn vector(node: Node<'_, '_>, name: &str) -> Result<Option<Vector3<f64>>, String> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let numbers: Vec<f64> =
        text.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|number| number.is_finite()) => {
            Ok(Some(Vector3::new(x, y, z)))
        }
        _ => Err(at(node, format!("{name}={text:?} must be three finite numbers"))),
    }
}

/// The transform of the `<origin>` below `node`; the identity if there is none.
///
/// `rpy` turns about the fixed x, then y, then z axis: RotZ(yaw) RotY(pitch) RotX(roll).
pub(super) fn origin(node: Node<'_, '_>) -> Result<Transform, String> {
    let Some(origin) = child(node, "origin") else { return Ok(Transform::IDENTITY) };
    let rpy = vector(origin, "rpy")?.unwrap_or_default();
    let xyz = vector(origin, "xyz")?.unwrap_or_default();
    let [(sr, cr), (sp, cp), (sy, cy)] = [rpy.x, rpy.y, rpy.z].map(libm::sincos);
    Ok(Transform {
        x: Vector3::new(cy * cp, sy * cp, -sp),
        y: Vector3::new(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
        z: Vector3::new(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
        origin: xyz,
    })
}
