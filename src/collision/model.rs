//! A robot in a scene, compiled for checking.

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::Vector3;

use super::chain::{Chain, Screw};
use super::cover::{CoverSphere, ball, cluster, cover, enclose};
use super::lane_chain::KernelScrew;
use super::lane_obstacle::{LaneObstacle, UNIT_ROUNDOFF};
use super::travel::Arms;
use crate::fault::Faults;
use crate::geometry::{Core, Solid};
use crate::robot::{Robot, link_name};
use crate::scene::Scene;

/// All that moves as one: the bodies of a link, or an attached object.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// What reports call it where its bodies have no names.
    pub(super) name: String,
    /// The link it is or hangs on: two groups on one link never meet.
    link: usize,
    /// It moves with the frame after so many screws.
    pub(super) screws: usize,
    /// A sphere around all of it, in that frame.
    pub(super) coarse: KernelSphere,
    /// The same in double precision and without anything for rounding: centre and radius, m.
    pub(super) around: (Vector3<f64>, f64),
    /// Its spheres, some neighbours at a time.
    pub(super) clusters: Range<usize>,
    pub(super) bodies: Range<usize>,
    pub(super) arms: Arms,
    /// How far the origin of its frame is at most from that of each screw before it, m.
    pub(super) levers: Vec<f64>,
    /// The obstacles it has to keep away from.
    pub(super) kept_from: Vec<usize>,
    /// Those of them that it can come near to.
    pub(super) obstacles: Vec<usize>,
}

/// A solid of the robot.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) name: String,
    /// It moves with the frame after so many screws.
    pub(super) screws: usize,
    /// In that frame.
    pub(super) solid: Solid,
    /// All of it is within this distance of its origin, m.
    pub(super) reach: f64,
    pub(super) arms: Arms,
}

/// Some spheres of a group that are near each other.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// A sphere around them.
    pub(super) coarse: KernelSphere,
    pub(super) spheres: Range<usize>,
}

/// A sphere in single precision, in the frame of its group.
#[derive(Clone, Copy, Debug)]
pub(super) struct KernelSphere {
    pub(super) center: [f32; 3],
    /// Where nothing is within this distance of the centre, the body touches nothing, whatever rounding did.
    pub(super) outer: f32,
    /// What is within this distance of the centre surely touches the body; negative if nothing is sure.
    pub(super) inner: f32,
    pub(super) body: usize,
    pub(super) arms: Arms,
}

/// Something that stands still.
#[derive(Clone, Debug)]
pub(super) struct Obstacle {
    pub(super) name: String,
    pub(super) solid: Solid,
    pub(super) lanes: LaneObstacle,
}

/// Two groups that must not touch, the one nearer to the base first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) first: usize,
    pub(super) second: usize,
    /// The first screw that moves them against each other.
    pub(super) from_screw: usize,
}

impl Pair {
    /// Where the spheres around both groups are further apart than this, nothing touches.
    pub(super) fn outer(&self, model: &Model) -> f32 {
        model.groups[self.first].coarse.outer + model.groups[self.second].coarse.outer
    }
}

/// A robot in a scene; it never changes.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) chain: Chain,
    pub(super) groups: Vec<Group>,
    pub(super) bodies: Vec<Body>,
    pub(super) clusters: Vec<Cluster>,
    pub(super) spheres: Vec<KernelSphere>,
    pub(super) obstacles: Vec<Obstacle>,
    pub(super) pairs: Vec<Pair>,
    /// The chain in single precision.
    pub(super) screws: Vec<KernelScrew>,
    /// The distance that has to be kept, m.
    pub(super) margin: f64,
}

/// Angles and positions are off by no more than this in the kernel, rad; see [`rounding`].
const ANGLE_ERROR: f64 = 5e-6;

/// A bound on how far the kernel's position of a point is off, m, that is within `radius` of its frame's origin and within
/// `extent` of the world's.
///
/// Angles along a motion are `base + share * travel` with `|base| <= 2 pi` and `|travel| <= 4 pi`, so no more than 51 units of
/// `u = 2^-24` are lost, 3.1e-6 rad; sines and cosines lose 6e-7, and turning the axes 8 units more. Together that is
/// less than 5e-6 rad of error per screw, which moves the point by its distance from it. Positions of sliding joints lose
/// less than eight units of their largest. Origins add up with fewer than 16 roundings per screw of numbers up to the extent.
fn rounding(screws: &[Screw], levers: &[f64], radius: f64, extent: f64) -> f64 {
    let moved = screws.iter().zip(levers).map(|(screw, lever)| match screw.turns {
        true => ANGLE_ERROR * (lever + radius + 1e-3),
        false => 8.0 * UNIT_ROUNDOFF * screw.travel,
    });
    moved.sum::<f64>() + 16.0 * (levers.len() + 2) as f64 * UNIT_ROUNDOFF * extent
}

/// Makes spheres single, with what their distances may be off.
struct Singly {
    margin: f64,
    off: f64,
}

impl Singly {
    fn sphere(&self, sphere: &CoverSphere, body: usize) -> KernelSphere {
        KernelSphere {
            center: [sphere.center.x as f32, sphere.center.y as f32, sphere.center.z as f32],
            outer: (sphere.outer + self.margin + self.off) as f32,
            inner: (sphere.inner + self.margin - self.off) as f32,
            body,
            arms: sphere.arms,
        }
    }

    /// One around all `spheres`, within which nothing is sure.
    fn around(&self, spheres: &[(CoverSphere, usize)]) -> KernelSphere {
        let (center, outer) = enclose(spheres.iter().map(|(sphere, _)| *sphere));
        let arms = arms_of(spheres);
        let around = CoverSphere { center, outer, inner: f64::NEG_INFINITY, arms };
        self.sphere(&around, spheres.first().map_or(0, |(_, body)| *body))
    }
}

/// Of all spheres together.
fn arms_of(spheres: &[(CoverSphere, usize)]) -> Arms {
    spheres.iter().fold(Arms::default(), |arms, (sphere, _)| arms.max(sphere.arms))
}

/// Builds a [`Model`].
struct Builder<'a> {
    robot: &'a Robot,
    scene: &'a Scene,
    model: Model,
    /// Which group, or which obstacle, a name stands for.
    names: HashMap<String, Part>,
    faults: Faults,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Link(usize),
    Attached(usize),
    Obstacle(usize),
}

impl Model {
    /// `robot` in `scene`, to be kept `margin` (m, not negative) apart.
    ///
    /// # Errors
    ///
    /// A robot without kinematics or bodies, and all that the scene says of links and names that are not there;
    /// pointers as in robot and scene.
    pub(super) fn new(robot: &Robot, scene: &Scene, margin: f64) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let Some(chain) = Chain::new(robot) else {
            faults.add("/kinematics", format!("robot {:?} needs kinematics", robot.name()));
            return Err(faults);
        };
        if robot.bodies().is_empty() {
            let name = robot.name();
            faults.add(
                "/geometry",
                format!("robot {name:?} has no bodies; give `geometry` or `link_radius`"),
            );
            return Err(faults);
        }
        let model = Self {
            screws: chain.screws.iter().map(KernelScrew::new).collect(),
            chain,
            groups: Vec::new(),
            bodies: Vec::new(),
            clusters: Vec::new(),
            spheres: Vec::new(),
            obstacles: Vec::new(),
            pairs: Vec::new(),
            margin,
        };
        let mut builder = Builder { robot, scene, model, names: HashMap::new(), faults };
        builder.add_links();
        builder.add_attached();
        builder.add_obstacles();
        let allowed = builder.allowed_pairs();
        builder.add_pairs(&allowed);
        builder.assign_obstacles(&allowed);
        builder.faults.into_result(builder.model)
    }

    /// How far from the origin anything of the robot can be, m.
    fn extent(&self) -> f64 {
        let radius = |group: &Group| self.room(group).1;
        let base = self.chain.world_from_base.origin.norm();
        let screws = self.chain.screws.first().map_or(0.0, |screw| screw.constant.origin.norm());
        base + screws + self.groups.iter().map(radius).fold(0.0, f64::max)
    }

    /// A ball in the world that the group never leaves.
    fn room(&self, group: &Group) -> (Vector3<f64>, f64) {
        let radius = |body: &Body| body.solid.frame.origin.norm() + body.reach;
        let radius = self.bodies[group.bodies.clone()].iter().map(radius).fold(0.0, f64::max);
        self.chain.room(group.screws, radius)
    }
}

impl Builder<'_> {
    fn add_links(&mut self) {
        let (robot, dof) = (self.robot, self.robot.dof());
        for link in 0..=dof {
            self.names.insert(link_name(link), Part::Link(link));
            let on_link = robot.bodies().iter().filter(|body| body.link == link);
            let place = self.model.chain.links[link].clone();
            let solids: Vec<_> = on_link
                .map(|body| {
                    let name = body.name.clone().unwrap_or_else(|| link_name(link));
                    let solid = Solid::new(&body.shape, &body.pose).moved(&place.frame_from_link);
                    (name, solid)
                })
                .collect();
            for (name, _) in &solids {
                self.names.entry(name.clone()).or_insert(Part::Link(link));
            }
            if !solids.is_empty() {
                self.add_group(link_name(link), link, place.screws, solids);
            }
        }
    }

    fn add_attached(&mut self) {
        let dof = self.robot.dof();
        for (index, object) in self.scene.attached().iter().enumerate() {
            // The tool's frame stands behind the links and moves with the last one.
            let place = object.link.unwrap_or(dof + 1);
            if object.link.is_some_and(|link| link > dof) {
                let detail =
                    format!("link {place}, but robot {:?} has links 0 to {dof}", self.robot.name());
                self.faults.add(format!("/attached/{index}/link"), detail);
                continue;
            }
            let place = self.model.chain.links[place].clone();
            let solid = Solid::new(&object.shape, &object.pose).moved(&place.frame_from_link);
            self.insert_name(
                &object.name,
                Part::Attached(index),
                format!("/attached/{index}/name"),
            );
            let link = object.link.unwrap_or(dof);
            self.add_group(
                object.name.clone(),
                link,
                place.screws,
                vec![(object.name.clone(), solid)],
            );
        }
    }

    fn insert_name(&mut self, name: &str, part: Part, pointer: String) {
        if self.names.insert(name.to_owned(), part).is_some() {
            let detail =
                format!("name {name:?} is taken by a part of robot {:?}", self.robot.name());
            self.faults.add(pointer, detail);
        }
    }

    fn add_group(
        &mut self,
        name: String,
        link: usize,
        screws: usize,
        solids: Vec<(String, Solid)>,
    ) {
        let model = &mut self.model;
        let (first_body, first_sphere) = (model.bodies.len(), model.spheres.len());
        let covers = solids.iter().enumerate().map(|(index, (_, solid))| {
            cover(solid).into_iter().map(move |sphere| (sphere, first_body + index))
        });
        let mut all: Vec<(CoverSphere, usize)> = covers.flatten().collect();
        let ends = cluster(&mut all, &|(sphere, _)| sphere.center);
        let radius = all.iter().map(|(s, _)| s.center.norm() + s.outer).fold(0.0, f64::max);
        let levers = model.chain.levers(screws);
        let extent = model.chain.room(screws, radius).1 + model.chain.world_from_base.origin.norm();
        let off = rounding(&model.chain.screws[..screws], &levers, radius, extent);
        let single = Singly { margin: model.margin, off };
        let first_cluster = model.clusters.len();
        let starts = std::iter::once(0).chain(ends.iter().copied());
        for (start, &end) in starts.zip(&ends) {
            model.clusters.push(Cluster {
                coarse: single.around(&all[start..end]),
                spheres: first_sphere + start..first_sphere + end,
            });
        }
        model.spheres.extend(all.iter().map(|(sphere, body)| single.sphere(sphere, *body)));
        for (index, (name, solid)) in solids.into_iter().enumerate() {
            let own = all.iter().filter(|(_, body)| *body == first_body + index);
            let arms = own.fold(Arms::default(), |arms, (sphere, _)| arms.max(sphere.arms));
            let reach = solid.reach();
            model.bodies.push(Body { name, screws, solid, reach, arms });
        }
        model.groups.push(Group {
            name,
            link,
            screws,
            coarse: single.around(&all),
            around: enclose(all.iter().map(|(sphere, _)| *sphere)),
            clusters: first_cluster..model.clusters.len(),
            bodies: first_body..model.bodies.len(),
            arms: arms_of(&all),
            levers,
            kept_from: Vec::new(),
            obstacles: Vec::new(),
        });
    }

    fn add_obstacles(&mut self) {
        let extent = self.model.extent();
        for (index, obstacle) in self.scene.obstacles().iter().enumerate() {
            self.insert_name(
                &obstacle.name,
                Part::Obstacle(index),
                format!("/obstacles/{index}/name"),
            );
            let solid = Solid::new(&obstacle.shape, &obstacle.pose);
            self.model.obstacles.push(Obstacle {
                name: obstacle.name.clone(),
                lanes: LaneObstacle::new(&solid, extent),
                solid,
            });
        }
    }

    /// The scene's allowed pairs, names resolved.
    fn allowed_pairs(&mut self) -> Vec<[Part; 2]> {
        let mut allowed = Vec::new();
        for (index, pair) in self.scene.allowed_pairs().iter().enumerate() {
            let mut parts = Vec::new();
            for (place, name) in pair.iter().enumerate() {
                match self.names.get(name) {
                    Some(part) => parts.push(*part),
                    None => self.faults.add(
                        format!("/allowed_pairs/{index}/{place}"),
                        format!("{name:?} is no obstacle, attached object, link or body"),
                    ),
                }
            }
            if let [first, second] = parts[..] {
                allowed.push([first, second]);
            }
        }
        allowed
    }

    /// What a group is called in allowed pairs.
    fn part(&self, group: usize) -> Part {
        let name = &self.model.groups[group].name;
        self.names.get(name).copied().unwrap_or(Part::Link(self.model.groups[group].link))
    }

    fn add_pairs(&mut self, allowed: &[[Part; 2]]) {
        for second in 0..self.model.groups.len() {
            for first in 0..second {
                let parts = [self.part(first), self.part(second)];
                if self.has_to_be_checked(first, second) && !is_allowed(allowed, parts) {
                    let (a, b) = (&self.model.groups[first], &self.model.groups[second]);
                    let pair = if a.screws <= b.screws { (first, second) } else { (second, first) };
                    let from_screw = self.first_screw_beyond(pair.0);
                    self.model.pairs.push(Pair { first: pair.0, second: pair.1, from_screw });
                }
            }
        }
    }

    /// The first screw that moves what is beyond a group against it. That is not the next one if the group is round
    /// about its axis, as the foot of an arm often is.
    fn first_screw_beyond(&self, group: usize) -> usize {
        /// Off the axis by no more than a drawing's rounding, m.
        const ON_AXIS_M: f64 = 1e-12;
        let group = &self.model.groups[group];
        let Some(screw) = self.model.chain.screws.get(group.screws) else { return group.screws };
        let is_round = |body: &Body| {
            let half_length = match body.solid.core {
                Core::Point => 0.0,
                Core::Segment { half_length } => half_length,
                _ => return false,
            };
            let (center, half) = (body.solid.frame.origin, body.solid.frame.z * half_length);
            let off_axis = |end: Vector3<f64>| screw.constant.inverse_point(&end).xy().norm();
            off_axis(center - half) <= ON_AXIS_M && off_axis(center + half) <= ON_AXIS_M
        };
        let round = screw.turns && self.model.bodies[group.bodies.clone()].iter().all(is_round);
        group.screws + usize::from(round)
    }

    /// Links by the robot's own list; an attached object against all but what it moves with, or where that is nothing, the
    /// nearest body before it, on which it is mounted.
    fn has_to_be_checked(&self, first: usize, second: usize) -> bool {
        let (a, b) = (&self.model.groups[first], &self.model.groups[second]);
        let pair = [a.link.min(b.link), a.link.max(b.link)];
        match (self.part(first), self.part(second)) {
            (Part::Link(_), Part::Link(_)) => self.robot.checked_pairs().contains(&pair),
            (Part::Link(link), Part::Attached(_)) => link != self.mount(b.link),
            _ => a.screws != b.screws,
        }
    }

    /// The link with a body that something attached to `link` is mounted on.
    fn mount(&self, link: usize) -> usize {
        let links = self.robot.bodies().iter().map(|body| body.link);
        links.filter(|body| *body <= link).max().unwrap_or(link)
    }

    fn assign_obstacles(&mut self, allowed: &[[Part; 2]]) {
        for index in 0..self.model.groups.len() {
            let part = self.part(index);
            let (center, radius) = self.model.room(&self.model.groups[index]);
            let room = ball(center, radius + self.model.margin + ROOM_SLACK_M);
            let kept_from: Vec<usize> = (0..self.model.obstacles.len())
                .filter(|&obstacle| {
                    !is_allowed(allowed, [part, Part::Obstacle(obstacle)])
                        && !self.always_apart(index, obstacle)
                })
                .collect();
            let near =
                |obstacle: &usize| self.model.obstacles[*obstacle].solid.distance(&room) <= 0.0;
            let obstacles = kept_from.iter().copied().filter(near).collect();
            self.model.groups[index].kept_from = kept_from;
            self.model.groups[index].obstacles = obstacles;
        }
    }
}

impl Builder<'_> {
    /// True if neither moves and they do not touch: then nothing is left to check.
    fn always_apart(&self, group: usize, obstacle: usize) -> bool {
        let (model, group) = (&self.model, &self.model.groups[group]);
        let solid = &model.obstacles[obstacle].solid;
        let apart = |body: &Body| {
            body.solid.moved(&model.chain.world_from_base).distance(solid) > model.margin
        };
        group.screws == 0 && model.bodies[group.bodies.clone()].iter().all(apart)
    }
}

/// Rooms are taken a little larger, so that rounding leaves out nothing.
const ROOM_SLACK_M: f64 = 1e-3;

fn is_allowed(allowed: &[[Part; 2]], [a, b]: [Part; 2]) -> bool {
    allowed.iter().any(|pair| *pair == [a, b] || *pair == [b, a])
}
