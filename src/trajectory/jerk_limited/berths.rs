//! Rooms at waypoints in the programme's units.

use crate::math::lanes::{Lanes, WIDTH};

use super::layout::Units;
use super::problem::{Berth, Iterate, Problem, Window};

/// Width of a room, in units of length, below which it counts as none: its barrier would be too steep to
/// compute with, and it would gain nothing that counts.
const NARROW: f64 = 1e-4;

/// How far from the bounds of a room a start stays, as a share of its width.
const INSIDE: f64 = 0.02;

/// Rooms where segments end, in the programme's units.
pub fn berths(window: &Window, groups: usize, units: &Units) -> Vec<Option<Berth>> {
    let (segments, dof) = (window.ways.len(), units.length.len());
    let berth = |group: usize, segment: usize| {
        let mut berth =
            Berth { open: Lanes::ZERO, bounds: [Lanes([-1.0; WIDTH]), Lanes([1.0; WIDTH])] };
        for joint in group * WIDTH..dof.min((group + 1) * WIDTH) {
            let room = window.rooms.of(segment + 1, joint);
            let [lower, upper] = room.map(|bound| bound / units.length[joint]);
            if upper - lower > NARROW {
                let lane = joint % WIDTH;
                berth.open.0[lane] = 1.0;
                [berth.bounds[0].0[lane], berth.bounds[1].0[lane]] = [lower, upper];
            }
        }
        (berth.open != Lanes::ZERO).then_some(berth)
    };
    let all = (0..groups).flat_map(|group| (0..segments).map(move |segment| (group, segment)));
    all.map(|(group, segment)| berth(group, segment)).collect()
}

/// The middles of rooms where a segment ends, since the waypoint there.
pub fn middle(problem: &Problem, group: usize, segment: usize) -> Lanes {
    let berth = problem.berths[group * problem.segments + segment].as_ref();
    berth.map_or(Lanes::ZERO, |Berth { open, bounds: [lower, upper] }| {
        (*lower + *upper) * 0.5 * *open
    })
}

/// Where segment `index` (as in [`Problem::berths`]) ends that deviates by `miss` from its waypoint, well inside
/// its room.
pub fn end_near(problem: &Problem, index: usize, lane: usize, miss: f64) -> f64 {
    let way = problem.change[index].0[lane];
    match &problem.berths[index] {
        Some(berth) if berth.open.0[lane] > 0.0 => {
            let [lower, upper] = berth.bounds.map(|bound| bound.0[lane]);
            let margin = INSIDE * (upper - lower);
            way + miss.max(lower + margin).min(upper - margin)
        }
        _ => way,
    }
}

/// Puts multipliers that are too small for their slacks on the central path.
pub fn raise_multipliers(problem: &Problem, point: &mut Iterate, mu: f64) {
    for (index, berth) in problem.berths.iter().enumerate() {
        let Some(berth) = berth else { continue };
        let end = point.cells[(index + 1) * problem.cells - 1].s[0];
        for lane in (0..WIDTH).filter(|lane| berth.open.0[*lane] > 0.0) {
            let deviation = end.0[lane] - problem.change[index].0[lane];
            let [lower, upper] = berth.bounds.map(|bound| bound.0[lane]);
            let slacks = [deviation - lower, upper - deviation];
            for (z, slack) in point.berths[index].iter_mut().zip(slacks) {
                z.0[lane] = z.0[lane].max(mu / slack);
            }
        }
    }
}
