//! Exact distances of one configuration: for reports, and for what is proven over time.

use super::checker::{CollisionChecker, CollisionScratch, ExactFrames};
use super::cover::ball;
use super::kernel::Touch;
use super::model::Model;

/// How near the robot comes to anything it must not touch, and to what.
#[derive(Clone, Debug, PartialEq)]
pub struct Clearance {
    /// The distance, m; not positive where they touch, and then at least as deep.
    pub distance_m: f64,
    /// The robot's body or attached object, then the obstacle or the other body.
    pub pair: [String; 2],
}

/// Two bodies, or a body and an obstacle, and how far they move against each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) touch: Touch,
    /// Of group or pair, in the list of rates.
    pub(super) rate: usize,
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
        let mut nearest: Option<(f64, Touch)> = None;
        for candidate in self.model.candidates() {
            let best = nearest.map_or(f64::INFINITY, |(distance, _)| distance);
            if self.model.surely_apart(candidate.touch, &scratch.exact, best) {
                continue;
            }
            let distance = self.model.distance(candidate.touch, &scratch.exact.frames);
            if distance < best {
                nearest = Some((distance, candidate.touch));
            }
        }
        nearest
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
        let distances = self.model.candidates().map(|Candidate { touch, .. }| Clearance {
            distance_m: self.model.distance(touch, &scratch.exact.frames),
            pair: self.model.pair_names(touch),
        });
        let mut contacts: Vec<_> =
            distances.filter(|contact| contact.distance_m <= self.model.margin).collect();
        contacts.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        contacts
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
    /// Every two solids that must not touch, bodies against obstacles first.
    pub(super) fn candidates(&self) -> impl Iterator<Item = Candidate> {
        let scene = self.groups.iter().enumerate().flat_map(|(rate, group)| {
            group.bodies.clone().flat_map(move |body| {
                let touch = move |&obstacle: &usize| Touch::Obstacle { body, obstacle };
                group.kept_from.iter().map(touch).map(move |touch| Candidate { touch, rate })
            })
        });
        let own = self.pairs.iter().enumerate().flat_map(move |(rate, pair)| {
            self.groups[pair.first].bodies.clone().flat_map(move |first| {
                let touch = move |second: usize| Touch::Bodies { first, second };
                let seconds = self.groups[pair.second].bodies.clone();
                seconds.map(touch).map(move |touch| Candidate { touch, rate })
            })
        });
        scene.chain(own)
    }

    /// True if bounding spheres are `distance` apart already.
    pub(super) fn surely_apart(&self, touch: Touch, exact: &ExactFrames, distance: f64) -> bool {
        match touch {
            Touch::Obstacle { body, obstacle } => {
                let (body_origin, reach) =
                    (self.origin(body, &exact.frames), self.bodies[body].reach);
                let obstacle = &self.obstacles[obstacle];
                let spheres = (body_origin - obstacle.solid.frame.origin).norm();
                spheres - reach - obstacle.reach >= distance
                    || obstacle.solid.distance(&ball(body_origin, reach)) >= distance
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
