//! From the tree of a URDF to the chain between base and tip.

use std::collections::{HashMap, HashSet};

use super::document::{Document, Joint, Kind, Mimic};
use super::{UrdfRobot, provenance};
use crate::fault::Faults;
use crate::geometry::{Pose, Transform};
use crate::robot::{self, JointType, LinkDescription, Provenance};

/// The robot under construction, and which link of the chain every link of the document moves with.
pub(super) struct Chained {
    pub(super) robot: UrdfRobot,
    /// By the name of the document's link: the link of the chain (0 is the base) and the place in its frame.
    pub(super) places: HashMap<String, (usize, Transform)>,
}

/// Follows the document from `base` (default the root) to `tip`.
pub(super) fn build(document: &Document, base: Option<&str>, tip: &str) -> Result<Chained, Faults> {
    let mut faults = Faults::default();
    let tree = Tree::new(document, &mut faults);
    let root = tree.root(&mut faults);
    for (link, pointer) in [(Some(tip), "/tip"), (base, "/base_link")] {
        if let Some(link) = link.filter(|link| !tree.links.contains(link)) {
            faults.add(pointer, format!("the URDF has no link {link:?}"));
        }
    }
    let mut faults = match (root, faults.is_empty()) {
        (Some(_), true) => faults,
        _ => return Err(faults),
    };
    let base = base.or(root).unwrap_or_default();
    let Some(path) = tree.path(base, tip) else {
        faults.add("/tip", format!("link {tip:?} does not hang on the base {base:?}"));
        return Err(faults);
    };
    let robot = follow(document, &path, &mut faults);
    let mut chained = Chained { robot, places: HashMap::new() };
    place_links(&tree, base, &path, &mut chained);
    faults.into_result(chained)
}

/// Who is whose parent.
struct Tree<'a> {
    links: HashSet<&'a str>,
    /// The joint that leads to a link.
    above: HashMap<&'a str, &'a Joint>,
    /// The joints that leave a link, in the document's order.
    below: HashMap<&'a str, Vec<&'a Joint>>,
    /// The links in the document's order.
    order: Vec<&'a str>,
}

impl<'a> Tree<'a> {
    fn new(document: &'a Document, faults: &mut Faults) -> Self {
        let order: Vec<&str> = document.links.iter().map(|link| link.name.as_str()).collect();
        let mut tree =
            Self { links: HashSet::new(), above: HashMap::new(), below: HashMap::new(), order };
        for link in &tree.order {
            if !tree.links.insert(link) {
                faults.add("/urdf", format!("two links are called {link:?}"));
            }
        }
        let mut names = HashSet::new();
        for joint in &document.joints {
            let Joint { name, line, .. } = joint;
            let mut fault = |what: String| faults.add("/urdf", format!("line {line}: {what}"));
            if !names.insert(name) {
                fault(format!("two joints are called {name:?}"));
            }
            for end in [&joint.parent, &joint.child] {
                if !tree.links.contains(end.as_str()) {
                    fault(format!("joint {name:?} names link {end:?}, which does not exist"));
                }
            }
            if let Some(other) = tree.above.insert(&joint.child, joint) {
                let child = &joint.child;
                fault(format!("joints {:?} and {name:?} both lead to link {child:?}", other.name));
            }
            tree.below.entry(&joint.parent).or_default().push(joint);
        }
        tree
    }

    /// The one link that no joint leads to.
    fn root(&self, faults: &mut Faults) -> Option<&'a str> {
        let is_root = |link: &&&str| !self.above.contains_key(**link);
        let roots: Vec<&str> = self.order.iter().filter(is_root).copied().collect();
        match roots[..] {
            [root] => {
                if let Some(lost) = self.unreached(root) {
                    faults.add("/urdf", format!("link {lost:?} is part of a loop"));
                    return None;
                }
                Some(root)
            }
            [] if self.order.is_empty() => {
                faults.add("/urdf", "there is no link");
                None
            }
            [] => {
                faults.add("/urdf", "the links form a loop: none of them is the root");
                None
            }
            [first, second, ..] => {
                let count = roots.len();
                let detail = format!(
                    "{count} links are roots, {first:?} and {second:?} among them, but there must be one"
                );
                faults.add("/urdf", detail);
                None
            }
        }
    }

    /// A link that does not hang on `root`.
    fn unreached(&self, root: &'a str) -> Option<&'a str> {
        let mut reached = HashSet::from([root]);
        let mut open = vec![root];
        while let Some(link) = open.pop() {
            let children = self.below.get(link).into_iter().flatten();
            open.extend(
                children.map(|joint| joint.child.as_str()).filter(|child| reached.insert(child)),
            );
        }
        self.order.iter().find(|link| !reached.contains(*link)).copied()
    }

    /// The joints from `base` to `tip`; none if the tip does not hang on the base.
    fn path(&self, base: &str, tip: &str) -> Option<Vec<&'a Joint>> {
        let mut path = Vec::new();
        let mut link = tip;
        while link != base {
            let joint = self.above.get(link)?;
            path.push(*joint);
            link = &joint.parent;
        }
        path.reverse();
        Some(path)
    }
}

/// Turns the joints of `path` into joints and links.
fn follow(document: &Document, path: &[&Joint], faults: &mut Faults) -> UrdfRobot {
    let mut robot = UrdfRobot {
        joints: Vec::new(),
        links: Vec::new(),
        tip: Pose::default(),
        geometry: Vec::new(),
        allowed_pairs: Vec::new(),
        notes: Vec::new(),
    };
    let mut constant = Transform::IDENTITY;
    for joint in path {
        constant = constant * joint.origin;
        let joint_type = match joint.kind {
            Kind::Fixed => continue,
            Kind::Free => {
                let Joint { name, line, .. } = joint;
                let detail = format!(
                    "line {line}: joint {name:?} is floating or planar, which no chain may hold"
                );
                faults.add("/urdf", detail);
                continue;
            }
            Kind::Revolute => JointType::Revolute,
            Kind::Continuous => JointType::Continuous,
            Kind::Prismatic => JointType::Prismatic,
        };
        let leader = match leader(document, joint, path) {
            Ok(leader) => leader,
            Err(problem) => {
                faults.add("/urdf", format!("line {}: {problem}", joint.line));
                continue;
            }
        };
        if joint.mimic.is_none() {
            robot.joints.push(robot::Joint {
                name: joint.name.clone(),
                joint_type,
                limits: joint.limits.clone(),
                provenance: provenance(&joint.limits, Provenance::Urdf),
            });
        }
        robot.links.push(LinkDescription {
            name: Some(joint.child.clone()),
            joint: leader.joint,
            pose: Pose::from(&constant),
            axis: joint.axis.into(),
            ratio: leader.multiplier,
            offset: leader.offset,
        });
        constant = Transform::IDENTITY;
    }
    robot.tip = Pose::from(&constant);
    if robot.joints.is_empty() && faults.is_empty() {
        faults.add("/tip", "no joint moves between base and tip");
    }
    robot
}

/// The joint that `joint` follows in the end: itself, unless it mimics.
fn leader(document: &Document, joint: &Joint, path: &[&Joint]) -> Result<Mimic, String> {
    let mut total = Mimic { joint: joint.name.clone(), multiplier: 1.0, offset: 0.0 };
    let mut current = joint;
    for _ in 0..=document.joints.len() {
        let Some(mimic) = &current.mimic else {
            let within = path.iter().any(|other| other.name == current.name);
            let moves = !matches!(current.kind, Kind::Fixed | Kind::Free);
            return if within && moves && total.multiplier != 0.0 {
                Ok(total)
            } else {
                let (name, leader) = (&joint.name, &current.name);
                Err(format!("joint {name:?} mimics {leader:?}, which does not move the chain"))
            };
        };
        total.offset += total.multiplier * mimic.offset;
        total.multiplier *= mimic.multiplier;
        total.joint.clone_from(&mimic.joint);
        let next = document.joints.iter().find(|other| other.name == mimic.joint);
        current = next.ok_or_else(|| {
            format!("joint {:?} mimics {:?}, which does not exist", joint.name, mimic.joint)
        })?;
    }
    Err(format!("joint {:?} mimics itself", joint.name))
}

/// Finds the link of the chain that every link of the document moves with.
///
/// Joints beside the chain are no degrees of freedom: what they move is kept where they are at 0 or,
/// where that is outside their limits, at the nearest limit.
fn place_links(tree: &Tree<'_>, base: &str, path: &[&Joint], chained: &mut Chained) {
    let mut held = Vec::new();
    let mut open = vec![(base, 0, Transform::IDENTITY)];
    let mut reached = 0;
    while let Some((link, body, place)) = open.pop() {
        chained.places.insert(link.to_owned(), (body, place));
        for joint in tree.below.get(link).into_iter().flatten() {
            let moves = joint.kind != Kind::Fixed;
            let next = if moves && path.iter().any(|other| other.name == joint.name) {
                reached += 1;
                (joint.child.as_str(), reached, Transform::IDENTITY)
            } else {
                if moves {
                    held.push(joint.name.as_str());
                }
                (joint.child.as_str(), body, place * joint.origin * at_rest(joint))
            };
            open.push(next);
        }
    }
    if !held.is_empty() {
        held.sort_unstable();
        chained.robot.notes.push(format!(
            "Joints beside the chain from base to tip are kept at 0 or their nearest limit: {}.",
            held.join(", ")
        ));
    }
}

/// What a joint beside the chain does to the link beyond it.
fn at_rest(joint: &Joint) -> Transform {
    let lower = joint.limits.lower.unwrap_or(f64::NEG_INFINITY);
    let upper = joint.limits.upper.unwrap_or(f64::INFINITY);
    let position = if 0.0 < lower {
        lower
    } else if 0.0 > upper {
        upper
    } else {
        0.0
    };
    match joint.kind {
        Kind::Prismatic => Transform { origin: joint.axis * position, ..Transform::IDENTITY },
        Kind::Revolute if position != 0.0 => Transform::about(&joint.axis, libm::sincos(position)),
        _ => Transform::IDENTITY,
    }
}
