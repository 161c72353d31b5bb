//! The URDF as it stands: every link and joint, checked one by one.

use nalgebra::Vector3;
use roxmltree::Node;

use super::xml;
use crate::fault::Faults;
use crate::geometry::{Shape, Transform};
use crate::robot::JointLimits;

/// Limits beyond this mean that there is none.
const ENDLESS: f64 = 1e12;
/// How far from 1 the length of an axis may be: they are often written with few digits.
const AXIS_TOLERANCE: f64 = 1e-3;

/// All links and joints, in the document's order.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
}

/// A link and its solids.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) name: String,
    pub(super) collisions: Vec<Collision>,
}

/// A solid in its link's frame.
#[derive(Debug)]
pub(super) struct Collision {
    pub(super) origin: Transform,
    /// The shape, or the name of the file that would hold it.
    pub(super) shape: Result<Shape, String>,
}

/// A joint between two links.
#[derive(Debug)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) origin: Transform,
    /// Unit vector in the joint's frame.
    pub(super) axis: Vector3<f64>,
    pub(super) limits: JointLimits,
    pub(super) mimic: Option<Mimic>,
    /// Where the document has it.
    pub(super) line: u32,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// Floating or planar.
    Free,
}

/// The joint follows another one.
#[derive(Clone, Debug)]
pub(super) struct Mimic {
    pub(super) joint: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// Reads a URDF; pointers are relative to the kinematics.
pub(super) fn read(text: &str) -> Result<Document, Faults> {
    let mut faults = Faults::default();
    let xml = match xml::document(text) {
        Ok(xml) => xml,
        Err(error) => {
            faults.add("/urdf", error);
            return Err(faults);
        }
    };
    let root = xml.root_element();
    let mut keep = |result: Result<(), String>| {
        if let Err(error) = result {
            faults.add("/urdf", error);
        }
    };
    let mut document = Document { links: Vec::new(), joints: Vec::new() };
    for node in xml::children(root, "link") {
        keep(link(node).map(|link| document.links.push(link)));
    }
    for node in xml::children(root, "joint") {
        keep(joint(node).map(|joint| document.joints.push(joint)));
    }
    faults.into_result(document)
}

fn link(node: Node<'_, '_>) -> Result<Link, String> {
    let collisions = xml::children(node, "collision").map(collision);
    Ok(Link { name: xml::name(node)?, collisions: collisions.collect::<Result<_, _>>()? })
}

fn collision(node: Node<'_, '_>) -> Result<Collision, String> {
    let geometry =
        xml::child(node, "geometry").ok_or_else(|| xml::at(node, "<collision> has no geometry"))?;
    let solid = geometry.children().find(Node::is_element);
    let solid = solid.ok_or_else(|| xml::at(geometry, "<geometry> is empty"))?;
    let length = |name: &str| match xml::number(solid, name)? {
        Some(length) if length > 0.0 => Ok(length),
        _ => Err(xml::at(solid, format!("{name} must be positive"))),
    };
    let shape = match solid.tag_name().name() {
        "sphere" => Ok(Shape::Sphere { radius: length("radius")? }),
        "cylinder" => Ok(Shape::Cylinder { radius: length("radius")?, length: length("length")? }),
        "capsule" => Ok(Shape::Capsule { radius: length("radius")?, length: length("length")? }),
        "box" => {
            let size = xml::vector(solid, "size")?.filter(|size| size.min() > 0.0);
            let size = size.ok_or_else(|| xml::at(solid, "size must be three positive numbers"))?;
            Ok(Shape::Box { size: size.into() })
        }
        "mesh" => Err(xml::required(solid, "filename")?.to_owned()),
        other => return Err(xml::at(solid, format!("unknown geometry <{other}>"))),
    };
    Ok(Collision { origin: xml::origin(node)?, shape })
}

fn joint(node: Node<'_, '_>) -> Result<Joint, String> {
    let name = xml::name(node)?;
    let kind = match xml::required(node, "type")? {
        "fixed" => Kind::Fixed,
        "revolute" => Kind::Revolute,
        "continuous" => Kind::Continuous,
        "prismatic" => Kind::Prismatic,
        "floating" | "planar" => Kind::Free,
        other => return Err(xml::at(node, format!("joint {name:?} has unknown type {other:?}"))),
    };
    let end = |end: &'static str| {
        let child = xml::child(node, end);
        let child = child.ok_or_else(|| xml::at(node, format!("joint {name:?} has no {end}")))?;
        Ok::<_, String>(xml::required(child, "link")?.trim().to_owned())
    };
    let mimic = xml::child(node, "mimic").map(|mimic| {
        Ok::<_, String>(Mimic {
            joint: xml::required(mimic, "joint")?.trim().to_owned(),
            multiplier: xml::number(mimic, "multiplier")?.unwrap_or(1.0),
            offset: xml::number(mimic, "offset")?.unwrap_or(0.0),
        })
    });
    Ok(Joint {
        kind,
        parent: end("parent")?,
        child: end("child")?,
        origin: xml::origin(node)?,
        axis: axis(node, &name, kind)?,
        limits: limits(node, &name, kind)?,
        mimic: mimic.transpose()?,
        line: node.document().text_pos_at(node.range().start).row,
        name,
    })
}

fn axis(node: Node<'_, '_>, name: &str, kind: Kind) -> Result<Vector3<f64>, String> {
    let element = xml::child(node, "axis");
    let axis = element.map(|element| xml::vector(element, "xyz")).transpose()?.flatten();
    // The specification's default.
    let axis = axis.unwrap_or_else(Vector3::x);
    let norm = axis.norm();
    if kind == Kind::Fixed || kind == Kind::Free {
        return Ok(Vector3::x());
    }
    if (norm - 1.0).abs() <= AXIS_TOLERANCE {
        return Ok(if norm == 1.0 { axis } else { axis / norm });
    }
    let [x, y, z] = axis.into();
    let detail =
        format!("axis [{x}, {y}, {z}] of joint {name:?} has length {norm}, but must have length 1");
    Err(xml::at(element.unwrap_or(node), detail))
}

/// The limits of a joint; those that are missing or mean nothing are unknown.
fn limits(node: Node<'_, '_>, name: &str, kind: Kind) -> Result<JointLimits, String> {
    let Some(element) = xml::child(node, "limit") else { return Ok(JointLimits::default()) };
    let read = |attribute: &str| {
        let value = xml::number(element, attribute)?;
        Ok::<_, String>(value.filter(|value| value.abs() < ENDLESS))
    };
    // A zero is written where nobody knows; robots that cannot move need no plan.
    let rate = |attribute: &str| match read(attribute)? {
        Some(value) if value < 0.0 => Err(xml::at(
            element,
            format!("{attribute}={value} of joint {name:?} must not be negative"),
        )),
        value => Ok(value.filter(|value| *value > 0.0)),
    };
    let ends = match kind {
        Kind::Continuous => [None, None],
        _ => [read("lower")?, read("upper")?],
    };
    // Both at zero: a file that leaves them out by writing the default.
    let ends = if ends == [Some(0.0), Some(0.0)] { [None, None] } else { ends };
    if let [Some(lower), Some(upper)] = ends
        && lower >= upper
    {
        let detail = format!("lower={lower} of joint {name:?} must be below upper={upper}");
        return Err(xml::at(element, detail));
    }
    Ok(JointLimits {
        lower: ends[0],
        upper: ends[1],
        velocity: rate("velocity")?,
        acceleration: rate("acceleration")?,
        jerk: rate("jerk")?,
        effort: rate("effort")?,
    })
}
