//! Exact distances of one configuration: for reports, and for what is proven over time.

use super::checker::{CollisionChecker, CollisionScratch, ExactFrames};
use super::cover::ball;
use super::kernel::Touch;
use super::model::{Group, Model};
use super::travel::Arms;
use crate::geometry::Solid;

/// How near the robot comes to anything it must not touch, and to what.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// The distance, m; not positive where they touch, and then at least as deep.
    pub distance_m: f64,
    /// The robot's body or attached object, then the obstacle or the other body.
    pub pair: [String; 2],
}

/// What is looked for among everything that must not touch.
pub(super) trait Search {
    /// From this distance on, m, what moves like `mover` is of no interest.
    fn enough(&self, mover: Mover<'_>) -> f64;

    /// Two solids whose distance is below that, m.
    fn found(&mut self, touch: Touch, mover: Mover<'_>, distance: f64);
}

/// What moves against an obstacle, or in a pair against the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover<'a> {
    pub(super) of: Owner,
    pub(super) arms: &'a Arms,
}

/// Whose rate it has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Owner {
    Group(usize),
    Pair(usize),
}

/// The nearest of all.
#[derive(Default)]
struct Nearest(Option<(f64, Touch)>);

impl Search for Nearest {
    fn enough(&self, _: Mover<'_>) -> f64 {
        self.0.map_or(f64::INFINITY, |(distance, _)| distance)
    }

    fn found(&mut self, touch: Touch, _: Mover<'_>, distance: f64) {
        self.0 = Some((distance, touch));
    }
}

/// All that is too near.
struct TooNear {
    margin: f64,
    found: Vec<(f64, Touch)>,
}

impl Search for TooNear {
    fn enough(&self, _: Mover<'_>) -> f64 {
        // A distance that equals the margin is too near.
        self.margin + f64::EPSILON
    }

    fn found(&mut self, touch: Touch, _: Mover<'_>, distance: f64) {
        if distance <= self.margin {
            self.found.push((distance, touch));
        }
    }
}

impl CollisionChecker {
    /// The smallest clearance at `state` (rad or m per joint), whatever margin is to be kept; nothing if there is nothing
    /// to keep away from. What neither moves nor touches does not count.
    ///
    /// # Panics
    ///
    /// If `state` has another number of joints or positions that are not finite.
    pub fn clearance(&self, state: &[f64], scratch: &mut CollisionScratch) -> Option<Clearance> {
        assert!(self.is_within_reach(state), "positions are finite and within reach");
        scratch.exact.place(&self.model, state);
        let mut nearest = Nearest::default();
        self.model.search(&scratch.exact, &mut nearest);
        nearest
            .0
            .map(|(distance_m, touch)| Clearance { distance_m, pair: self.model.pair_names(touch) })
    }

    /// Everything that is nearer than the margin at `state`, the deepest first.
    ///
    /// # Panics
    ///
    /// If `state` has another number of joints or positions that are not finite.
    pub fn contacts(&self, state: &[f64], scratch: &mut CollisionScratch) -> Vec<Clearance> {
        assert!(self.is_within_reach(state), "positions are finite and within reach");
        scratch.exact.place(&self.model, state);
        let mut near = TooNear { margin: self.model.margin, found: Vec::new() };
        self.model.search(&scratch.exact, &mut near);
        near.found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let contact =
            |(distance_m, touch)| Clearance { distance_m, pair: self.model.pair_names(touch) };
        near.found.into_iter().map(contact).collect()
    }
}

impl ExactFrames {
    /// Moves everything to `state`.
    pub(super) fn place(&mut self, model: &Model, state: &[f64]) {
        self.forget();
        self.configuration.copy_from_slice(state);
        model.chain.forward(state, &mut self.frames);
    }
}

impl Model {
    /// Shows `search` every two solids that must not touch and are near enough for it.
    pub(super) fn search(&self, exact: &ExactFrames, search: &mut impl Search) {
        for (index, group) in self.groups.iter().enumerate() {
            let (around, of) = (self.around(group, exact), Owner::Group(index));
            for &obstacle in &group.kept_from {
                let distance = self.obstacles[obstacle].solid.distance(&around);
                if distance >= search.enough(Mover { of, arms: &group.arms }) {
                    continue;
                }
                for body in group.bodies.clone() {
                    let mover = Mover { of, arms: &self.bodies[body].arms };
                    self.show(Touch::Obstacle { body, obstacle }, mover, exact, search);
                }
            }
        }
        for (index, pair) in self.pairs.iter().enumerate() {
            let [first, second] = [pair.first, pair.second].map(|group| &self.groups[group]);
            let distance = self.around(first, exact).distance(&self.around(second, exact));
            let of = Owner::Pair(index);
            if distance >= search.enough(Mover { of, arms: &second.arms }) {
                continue;
            }
            for first in first.bodies.clone() {
                for second in second.bodies.clone() {
                    let mover = Mover { of, arms: &self.bodies[second].arms };
                    self.show(Touch::Bodies { first, second }, mover, exact, search);
                }
            }
        }
    }

    fn show(&self, touch: Touch, mover: Mover<'_>, exact: &ExactFrames, search: &mut impl Search) {
        let enough = search.enough(mover);
        if !self.surely_apart(touch, exact, enough) {
            let distance = self.distance(touch, &exact.frames);
            if distance < enough {
                search.found(touch, mover, distance);
            }
        }
    }

    /// A ball around all of a group.
    fn around(&self, group: &Group, exact: &ExactFrames) -> Solid {
        let (center, radius) = group.around;
        ball(exact.frames[group.screws].point(&center), radius)
    }

    /// True if bounding spheres are `distance` apart already.
    fn surely_apart(&self, touch: Touch, exact: &ExactFrames, distance: f64) -> bool {
        match touch {
            Touch::Obstacle { body, obstacle } => {
                let around = ball(self.origin(body, &exact.frames), self.bodies[body].reach);
                self.obstacles[obstacle].solid.distance(&around) >= distance
            }
            Touch::Bodies { first, second } => {
                let away = self.origin(first, &exact.frames) - self.origin(second, &exact.frames);
                away.norm() - self.bodies[first].reach - self.bodies[second].reach >= distance
            }
        }
    }

    /// What reports call the two.
    pub(super) fn pair_names(&self, touch: Touch) -> [String; 2] {
        let body = |body: usize| self.bodies[body].name.clone();
        match touch {
            Touch::Obstacle { body: own, obstacle } => {
                [body(own), self.obstacles[obstacle].name.clone()]
            }
            Touch::Bodies { first, second } => [body(first), body(second)],
        }
    }
}
