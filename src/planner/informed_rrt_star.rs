//! Informed RRT*.
//!
//! Gammell et al. 2014, doi:10.1109/IROS.2014.6942976. RRT* that, once a path is known, draws its
//! samples from the ellipsoid through which a shorter one can lead.
//!
//! Deviations: as for RRT*; when the path has become shorter, nodes outside the ellipsoid are
//! forgotten, and the near radius takes the ellipsoid's volume for the box's. With `cut_corners` every
//! new best path is made shorter as it is, so that samples need not find every corner's place.

use super::entry::{PlannerEntry, RANGE, iterations};
use super::informed::Ellipsoid;
use super::roadmap::Roadmap;
use super::star::{GOAL_BIAS, GOAL_REACH, ITERATIONS, Star};
use super::world::World;
use super::{Planner, PlanningProblem, ValidityChecker};
use crate::fault::parameter::{Parameter, Settings, flag};

/// Its registry entry.
pub(super) const ENTRY: PlannerEntry = PlannerEntry {
    name: "informed_rrt_star",
    title: "Informed RRT*",
    description: "RRT* that, once a path is known, samples only where a shorter one can lead.",
    source: "Gammell et al. 2014, doi:10.1109/IROS.2014.6942976",
    anytime: true,
    needs_clearance: false,
    parameters: &[iterations(ITERATIONS), RANGE, GOAL_BIAS, GOAL_REACH, CUT_CORNERS],
};

const CUT_CORNERS: Parameter = flag(
    "cut_corners",
    "leave out nodes of every new best path and cut its corners where that is free; false as \
     published, default true: some ten times fewer samples for the same length",
    true,
);

/// Nodes are forgotten when the ellipsoid has shrunk to this share of itself.
const PRUNED_FROM: f64 = 0.5;

pub(super) fn build(settings: &Settings, problem: &PlanningProblem) -> InformedRrtStar {
    InformedRrtStar {
        star: Star::new(settings, problem, 0),
        ellipsoid: Ellipsoid::new(problem),
        shortens: settings.flag("cut_corners"),
        tightens: false,
        length: f64::INFINITY,
        share: 1.0,
    }
}

pub(super) struct InformedRrtStar {
    star: Star,
    ellipsoid: Ellipsoid,
    /// Whether corners of the path are cut.
    shortens: bool,
    /// Whether the last round of that made the path shorter.
    tightens: bool,
    /// Length of the path that the ellipsoid is of.
    length: f64,
    /// The ellipsoid's share of the box when nodes were forgotten last.
    share: f64,
}

impl Planner for InformedRrtStar {
    fn step<C: ValidityChecker>(&mut self, world: &mut World<'_, C>) {
        if self.star.roadmap.length() < self.length || self.tightens {
            // One round per iteration, so that whoever cancels need not wait.
            self.tightens = self.shortens && self.star.tighten(world);
            self.length = self.star.roadmap.length();
            self.ellipsoid.shrink(self.length);
            if self.ellipsoid.share().min(1.0) <= self.share * PRUNED_FROM {
                self.prune(world.problem);
            }
        }
        if self.length.is_finite() {
            self.ellipsoid.sample(world, &mut self.star.target);
        } else {
            let Star { goal_bias, target, .. } = &mut self.star;
            world.sample_or_goal(*goal_bias, target);
        }
        self.star.grow(world);
    }

    fn roadmap(&mut self) -> &mut Roadmap {
        &mut self.star.roadmap
    }

    fn into_roadmap(self) -> Roadmap {
        self.star.roadmap
    }
}

impl InformedRrtStar {
    /// Forgets what no shorter path leads through.
    fn prune(&mut self, problem: &PlanningProblem) {
        self.share = self.ellipsoid.share().min(1.0);
        let Star { roadmap, rewiring, .. } = &mut self.star;
        rewiring.restrict(self.share);
        let Some([end, _]) = roadmap.join() else { return };
        let tree = &roadmap.trees[0];
        let on_path: Vec<u32> = std::iter::once(end).chain(tree.ancestors(end)).collect();
        let ellipsoid = &self.ellipsoid;
        // States of the path itself lie on the ellipsoid's skin or within, but for rounding.
        let is_kept =
            |node, state: &[f64]| ellipsoid.contains(problem, state) || on_path.contains(&node);
        if let (pruned, Some(end)) = tree.pruned(problem, end, is_kept) {
            roadmap.replace_tree(pruned, end);
        }
    }
}
