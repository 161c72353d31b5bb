//! From waypoints and limits to a programme in units of its own, with a start.
//!
//! Time is measured in the mean of the durations that the joints would need from
//! rest to rest, each joint's way in the longest of its ways. So all numbers are near 1
//! however far the limits are apart.

use crate::math::lanes::{Lanes, WIDTH};
use crate::trajectory::kernel::KernelLimits;
use crate::trajectory::rest_to_rest::quintic;

use super::berths;
use super::problem::{Cell, FREE, Group, Iterate, Problem, Window};
use super::profile::{Motion, Phase};
use super::speeds::Bounds;

/// How much slower than necessary the start is, so that it lies inside the limits.
const EASE: f64 = 1.1;

/// Shortest start of a segment next to an end in motion, as a share of a slow one.
const HASTE: f64 = 0.02;

/// Rounds in which the duration of a coasting segment is found.
const COASTING: usize = 5;

/// Share of the jerk limit that a start uses at most to join accelerations.
const EASY: f64 = 0.9;

/// Shortest ramp that stands for a jump of velocity, as a share of the whole motion.
const SHORTEST_RAMP: f64 = 1e-6;

/// How fast cells grow at most from a waypoint towards the middle of a segment, and the share of the segment up to
/// which they do where ramps are shortest.
const GROWTH: f64 = 4.0;
const LONGEST_CELL: f64 = 0.2;

/// Units: seconds per unit of time, rad or m per unit of each joint's length.
#[derive(Clone, Debug)]
pub struct Units {
    pub time: f64,
    pub length: Vec<f64>,
}

/// Durations in which fifth-order polynomials from rest to rest keep all limits, s.
fn quintics(ways: &[Vec<f64>], limits: Bounds) -> Vec<f64> {
    let longest = |(segment, row): (usize, &Vec<f64>)| {
        let of = |(joint, way): (usize, &f64)| quintic(*way, limits.of(segment, joint));
        row.iter().enumerate().map(of).fold(0.0, f64::max)
    };
    ways.iter().enumerate().map(longest).collect()
}

impl Units {
    fn new(ways: &[Vec<f64>], limits: &[KernelLimits], durations: &[f64]) -> Self {
        let time = durations.iter().sum::<f64>() / durations.len() as f64;
        let longest = |joint: usize| ways.iter().map(|row| row[joint].abs()).fold(0.0, f64::max);
        let length = (0..limits.len()).map(|joint| {
            // A joint that hardly moves is measured by how far it could.
            let mut reach = f64::INFINITY;
            let mut power = 1.0;
            for limit in limits[joint].derivatives {
                power *= time;
                reach = reach.min(limit * power);
            }
            let reach = if reach.is_finite() { 1e-2 * reach } else { f64::MIN_POSITIVE };
            longest(joint).max(reach).max(1e-300)
        });
        Self { time, length: length.collect() }
    }
}

/// Limits of joint `joint` in its units; what does not exist is far away.
fn scaled(limit: &KernelLimits, units: &Units, joint: usize) -> [f64; 3] {
    let mut power = 1.0;
    limit.derivatives.map(|limit| {
        power *= units.time;
        (limit * power / units.length[joint]).min(FREE)
    })
}

/// The same limits, but with finite acceleration where neither acceleration nor
/// jerk is limited.
///
/// The optimum would have jumps of velocity there. Ramps that are short
/// compared with any segment stand for them, but long enough that the rounding of
/// times does not count in them.
pub fn effective(ways: &[Vec<f64>], limits: &[KernelLimits]) -> Vec<KernelLimits> {
    let durations = quintics(ways, Bounds::everywhere(limits));
    let shortest = durations.iter().copied().filter(|h| *h > 0.0).fold(f64::INFINITY, f64::min);
    let shortest = if shortest.is_finite() { shortest } else { 1.0 };
    let ramp = (1e-3 * shortest).max(SHORTEST_RAMP * durations.iter().sum::<f64>());
    let mut limits = limits.to_vec();
    for (joint, limit) in limits.iter_mut().enumerate() {
        let [velocity, acceleration, jerk] = limit.derivatives;
        if acceleration.is_finite() || jerk.is_finite() {
            continue;
        }
        let longest = ways.iter().map(|row| row[joint].abs()).fold(0.0, f64::max);
        let speed = if velocity.is_finite() { velocity } else { 1e3 * longest / shortest };
        limit.derivatives[1] = if speed > 0.0 { speed / ramp } else { 1.0 };
    }
    limits
}

/// A problem with `cells` cells per segment, and a point inside its limits.
pub fn pose(window: &Window, cells: usize, mu: f64) -> (Problem, Iterate, Units) {
    let Window { ways, limits, ends, .. } = *window;
    let between = window.between_middles();
    let durations = quintics(&between, limits);
    let units = Units::new(&between, &limits, &durations);
    let (segments, dof) = (ways.len(), limits.len());
    let groups: Vec<Group> = (0..dof.div_ceil(WIDTH))
        .map(|group| {
            let used = (dof - group * WIDTH).min(WIDTH);
            let mut g = Group {
                used,
                real: Lanes::ZERO,
                limits: [Lanes([1.0; WIDTH]); 3],
                smooth: Lanes([1.0; WIDTH]),
                start: [Lanes::ZERO; 3],
                goal: [Lanes::ZERO; 2],
            };
            for lane in 0..used {
                let joint = group * WIDTH + lane;
                g.real.0[lane] = 1.0;
                let values = scaled(&limits[joint], &units, joint);
                for (limit, value) in g.limits.iter_mut().zip(values) {
                    limit.0[lane] = value;
                }
                let speed = units.time / units.length[joint];
                g.start[0].0[lane] = window.from[joint] / units.length[joint];
                for (end, [v, a]) in
                    [(&mut g.start[1..], ends.start[joint]), (&mut g.goal[..], ends.goal[joint])]
                {
                    end[0].0[lane] = v * speed;
                    end[1].0[lane] = a * speed * units.time;
                }
                g.smooth.0[lane] = if values[2] < FREE { 1.0 } else { 0.0 };
                // Where acceleration may jump, that at the goal is free.
                g.goal[1].0[lane] *= g.smooth.0[lane];
            }
            g
        })
        .collect();
    let mut change = vec![Lanes::ZERO; groups.len() * segments];
    for (segment, row) in ways.iter().enumerate() {
        for (joint, way) in row.iter().enumerate() {
            let at = joint / WIDTH * segments + segment;
            change[at].0[joint % WIDTH] = way / units.length[joint];
        }
    }
    let mut shares = vec![Lanes([1.0 / cells as f64; WIDTH]); groups.len() * segments * cells];
    for (joint, limit) in limits.iter().enumerate() {
        let ramp = ramp(limit.derivatives);
        for (segment, duration) in durations.iter().enumerate() {
            let first = (joint / WIDTH * segments + segment) * cells;
            for (q, share) in division(cells, ramp / duration).enumerate() {
                shares[first + q].0[joint % WIDTH] = share;
            }
        }
    }
    let speeds = speeds(limits, &groups, segments, &units);
    let berths = berths::berths(window, groups.len(), &units);
    let problem = Problem { segments, cells, groups, change, berths, speeds, shares };
    let durations: Vec<f64> = durations.iter().map(|h| (h / units.time).max(1e-6) * EASE).collect();
    let point = start(&problem, durations, mu);
    (problem, point, units)
}

/// Limits of velocity by segment, in the programme's units.
fn speeds(limits: Bounds, groups: &[Group], segments: usize, units: &Units) -> Vec<[Lanes; 2]> {
    let mut speeds = Vec::with_capacity(groups.len() * segments);
    for (group, g) in groups.iter().enumerate() {
        let inside = |segment: usize| {
            let mut lanes = g.limits[0];
            for lane in 0..g.used {
                let joint = group * WIDTH + lane;
                let limit = limits.of(segment, joint)[0];
                lanes.0[lane] = (limit * units.time / units.length[joint]).min(FREE);
            }
            lanes
        };
        for segment in 0..segments {
            let [own, next] = [segment, (segment + 1).min(segments - 1)].map(inside);
            let mut at_end = own;
            at_end.0.iter_mut().zip(next.0).for_each(|(own, next)| *own = own.min(next));
            speeds.push([own, at_end]);
        }
    }
    speeds
}

/// How long a joint takes from rest to its highest speed, s; infinite if it has none.
fn ramp([velocity, acceleration, jerk]: [f64; 3]) -> f64 {
    if velocity.is_infinite() {
        f64::INFINITY
    } else if velocity * jerk >= acceleration * acceleration {
        velocity / acceleration + acceleration / jerk
    } else {
        2.0 * libm::sqrt(velocity / jerk)
    }
}

/// Shares of an even number of cells in their segment, the same from both ends, for a joint whose ramps take
/// the share `ramp` of it.
///
/// A joint that reaches its speed limit in a moment does all that matters next to the waypoints. Equal
/// cells would be far longer than its ramps, and the coarse programme
/// would not see what its speed there is worth. So its first cell is half a ramp, and cells grow
/// towards the middle until they are equal.
fn division(cells: usize, ramp: f64) -> impl Iterator<Item = f64> {
    let equal = 1.0 / cells as f64;
    let half = cells / 2;
    // Short enough cells would not fill the segment: two of the longest must be among them.
    let shortest = LONGEST_CELL * GROWTH.powi(2 - half as i32);
    let first = (0.5 * ramp).max(shortest).min(equal);
    let length = move |q: usize, most: f64| most.min(first * GROWTH.powi(q as i32));
    let mut range = [equal, 0.5];
    for _ in 0..60 {
        let most = 0.5 * (range[0] + range[1]);
        let sum: f64 = (0..half).map(|q| length(q, most)).sum();
        range[usize::from(sum > 0.5)] = most;
    }
    let graded = first < equal;
    (0..cells).map(move |q| if graded { length(q.min(cells - 1 - q), range[0]) } else { equal })
}

/// Stops at every waypoint but the ends, along fifth-order polynomials.
fn start(problem: &Problem, durations: Vec<f64>, mu: f64) -> Iterate {
    let (n, k) = (problem.segments, problem.cells);
    let mut cells = Vec::with_capacity(problem.shares.len());
    for group in 0..problem.groups.len() {
        for (segment, h) in durations.iter().enumerate() {
            let from = if segment == 0 {
                problem.groups[group].start[0]
            } else {
                berths::middle(problem, group, segment - 1)
            };
            let to = problem.change[group * n + segment] + berths::middle(problem, group, segment);
            let mut passed = Lanes::ZERO;
            for q in 0..k {
                passed = passed + problem.shares[(group * n + segment) * k + q];
                let mut cell = Cell::ZERO;
                if q + 1 == k {
                    cell.s[0] = to;
                } else {
                    for lane in 0..WIDTH {
                        let (u, from) = (passed.0[lane], from.0[lane]);
                        let way = to.0[lane] - from;
                        let (u2, u3) = (u * u, u * u * u);
                        cell.s[0].0[lane] =
                            from + way * (10.0 * u3 - 15.0 * u2 * u2 + 6.0 * u3 * u2);
                        cell.s[1].0[lane] = way * ((30.0 * u2 - 60.0 * u3 + 30.0 * u2 * u2) / h);
                        cell.s[2].0[lane] = way * ((60.0 * u - 180.0 * u2 + 120.0 * u3) / (h * h));
                    }
                }
                cells.push(cell);
            }
        }
        if let Some(last) = cells.last_mut() {
            [last.s[1], last.s[2]] = problem.groups[group].goal;
        }
    }
    let mut point = Iterate {
        durations,
        cells,
        lambda: vec![Lanes::ZERO; problem.groups.len() * n],
        berths: vec![[Lanes::ZERO; 2]; problem.groups.len() * n],
        goal: vec![[Lanes::ZERO; 2]; problem.groups.len()],
    };
    ease_in(problem, &mut point);
    center(problem, &mut point, mu);
    point
}

/// Makes the first segments of `point` follow `guess`, which may be shorter or longer, slowed down until all limits are kept.
/// False, and `point` of no use, if they cannot be.
pub fn follow(
    problem: &Problem,
    units: &Units,
    guess: &Motion,
    point: &mut Iterate,
    mu: f64,
) -> bool {
    let k = problem.cells;
    let all = problem.segments * k;
    let mut slower = 1.0;
    for _ in 0..6 {
        slower *= EASE;
        for (segment, duration) in guess.durations.iter().take(problem.segments).enumerate() {
            point.durations[segment] = duration * slower / units.time;
            for (joint, phases) in guess.phases.iter().enumerate() {
                let (group, lane) = (joint / WIDTH, joint % WIDTH);
                let speed = units.time / (units.length[joint] * slower);
                let mut u = 0.0;
                for q in 0..k {
                    u += problem.shares[group * all + segment * k + q].0[lane];
                    let [x, v, a, _] = sample(&phases[segment], u * duration);
                    let cell = &mut point.cells[group * all + segment * k + q];
                    if q + 1 < k {
                        cell.s[0].0[lane] = x / units.length[joint];
                    } else {
                        let next = phases.get(segment + 1).and_then(|phases| phases.first());
                        let miss = next.map_or(0.0, |phase| phase.state[0] / units.length[joint]);
                        let index = group * problem.segments + segment;
                        cell.s[0].0[lane] = berths::end_near(problem, index, lane, miss);
                    }
                    if segment * k + q + 1 < all {
                        cell.s[1].0[lane] = v * speed;
                        cell.s[2].0[lane] = a * speed * units.time / slower;
                    }
                }
            }
        }
        ease_in(problem, point);
        if is_inside(problem, point) {
            center(problem, point, mu);
            return true;
        }
    }
    false
}

/// Crosses the segments of `point` that are next to an end in motion about as fast as the joints
/// go there, where they go the right way.
///
/// Often the waypoint can be met in a very short time, then for long not at all, and
/// again once the joints have swung back. Descent from slow motions finds the far side of such a gap, and
/// from here the near one. False, and `point` of no use, if there is no such start.
pub fn hasten(problem: &Problem, point: &mut Iterate, mu: f64) -> bool {
    let n = problem.segments;
    let mut hastened = false;
    for (segment, at_goal) in [(0, false), (n - 1, true)] {
        let slow = point.durations[segment];
        let h = coasting(problem, segment, at_goal);
        if h < slow {
            point.durations[segment] = h.max(HASTE * slow);
            run(problem, point, segment, at_goal);
            hastened = true;
        }
    }
    ease_in(problem, point);
    let inside = hastened && is_inside(problem, point);
    if inside {
        center(problem, point, mu);
    }
    inside
}

/// How long the joints take for a segment, at least nearly and all together, if they keep the acceleration
/// that they have at its end in motion; infinite if they go the wrong way.
fn coasting(problem: &Problem, segment: usize, at_goal: bool) -> f64 {
    let mut h = 0.0;
    for _ in 0..COASTING {
        let (mut along, mut speed) = (0.0, 0.0);
        for (group, g) in problem.groups.iter().enumerate() {
            let [v, a] = if at_goal { g.goal } else { [g.start[1], g.start[2]] };
            let half = if at_goal { -0.5 * h } else { 0.5 * h };
            for lane in 0..g.used {
                // The mean velocity, by joint compared with the greatest.
                let mean = v.0[lane] + half * a.0[lane];
                let most = g.limits[0].0[lane];
                along += mean / most
                    * (problem.change[group * problem.segments + segment].0[lane] / most);
                speed += mean / most * (mean / most);
            }
        }
        if !(along > 0.0 && speed > 0.0) {
            return f64::INFINITY;
        }
        h = along / speed;
    }
    h
}

/// Lets velocity change evenly over a segment from (at the goal: to) that at its end in motion.
fn run(problem: &Problem, point: &mut Iterate, segment: usize, at_goal: bool) {
    let (n, k) = (problem.segments, problem.cells);
    let h = point.durations[segment];
    for (group, g) in problem.groups.iter().enumerate() {
        for lane in 0..g.used {
            let way = problem.change[group * n + segment].0[lane];
            let most = 0.9 * g.limits[0].0[lane];
            let near = if at_goal { g.goal[0] } else { g.start[1] }.0[lane];
            let far = 2.0 * way / h - near;
            let [from, to] = if at_goal { [far, near] } else { [near, far] };
            let mut u = 0.0;
            for q in 0..k {
                let index = (group * n + segment) * k + q;
                u += problem.shares[index].0[lane];
                let cell = &mut point.cells[index];
                if q + 1 < k {
                    cell.s[0].0[lane] = h * u * (from + 0.5 * u * (to - from));
                }
                if segment * k + q + 1 < n * k {
                    cell.s[1].0[lane] = (from + u * (to - from)).max(-most).min(most);
                    cell.s[2].0[lane] = 0.0;
                }
            }
        }
    }
}

/// Whether `point` keeps all limits strictly and leads to the goal.
fn is_inside(problem: &Problem, point: &Iterate) -> bool {
    let all = problem.segments * problem.cells;
    let inside = |group: usize, c: usize, lane: usize| {
        let counts = |row: usize| c + 1 < all || !(4..6).contains(&row);
        let slacks = slack(problem, point, group, c, lane);
        slacks.iter().enumerate().all(|(row, g)| *g > 0.0 || !counts(row))
    };
    let lanes = |group: usize| 0..problem.groups[group].used;
    let groups = 0..problem.groups.len();
    leads_to_goal(problem, point)
        && groups
            .into_iter()
            .all(|group| (0..all).all(|c| lanes(group).all(|lane| inside(group, c, lane))))
}

/// Whether `point` ends as its problem's goal demands, which no Newton step would change.
pub fn leads_to_goal(problem: &Problem, point: &Iterate) -> bool {
    let all = problem.segments * problem.cells;
    let ends = point.cells.chunks(all).filter_map(<[Cell]>::last);
    problem
        .groups
        .iter()
        .zip(ends)
        .all(|(group, end)| (0..group.used).all(|lane| end.s[2].0[lane] == group.goal[1].0[lane]))
}

/// State at time `t` of a segment.
fn sample(phases: &[Phase], t: f64) -> [f64; 4] {
    let next = phases.partition_point(|phase| phase.start <= t);
    let phase = &phases[next.saturating_sub(1)];
    phase.at((t - phase.start).min(phase.length))
}

/// Lets acceleration follow from that at the start, and lead to that at the goal, no faster than
/// jerk allows.
fn ease_in(problem: &Problem, point: &mut Iterate) {
    let all = problem.segments * problem.cells;
    for group in 0..problem.groups.len() {
        for lane in 0..WIDTH {
            let goal = problem.groups[group].goal.map(|end| end.0[lane]);
            let moves = goal.iter().any(|value| *value != 0.0);
            if moves {
                // An earlier point may have missed it.
                point.cells[group * all + all - 1].s[2].0[lane] = goal[1];
            }
            for c in (1..all).rev().take_while(|_| moves) {
                let [t, ..] = before(problem, point, group, c, lane);
                let most = EASY * problem.groups[group].limits[2].0[lane] * t;
                let a = point.cells[group * all + c].s[2].0[lane];
                let from = &mut point.cells[group * all + c - 1].s[2].0[lane];
                *from = from.max(a - most).min(a + most);
            }
            for c in 0..all {
                let [t, _, a] = before(problem, point, group, c, lane);
                let most = EASY * problem.groups[group].limits[2].0[lane] * t;
                let to = &mut point.cells[group * all + c].s[2].0[lane];
                *to = to.max(a - most).min(a + most);
            }
        }
    }
}

/// Sets all multipliers to where they belong on the central path.
pub fn center(problem: &Problem, point: &mut Iterate, mu: f64) {
    let all = problem.segments * problem.cells;
    for index in 0..point.cells.len() {
        for lane in 0..WIDTH {
            let g = slack(problem, point, index / all, index % all, lane);
            for (z, g) in point.cells[index].z.iter_mut().zip(g) {
                z.0[lane] = mu / g;
            }
        }
    }
    point.berths.fill([Lanes::ZERO; 2]);
    berths::raise_multipliers(problem, point, mu);
}

/// Position where cell `c` starts, since the last waypoint.
pub fn start_of(problem: &Problem, point: &Iterate, group: usize, c: usize, lane: usize) -> f64 {
    let k = problem.cells;
    if c == 0 {
        return problem.groups[group].start[0].0[lane];
    }
    let x = point.cells[group * problem.segments * k + c - 1].s[0].0[lane];
    let passed = group * problem.segments + c / k;
    if c.is_multiple_of(k) { x - problem.change[passed - 1].0[lane] } else { x }
}

/// Duration of a cell, and velocity and acceleration where it starts.
pub fn before(problem: &Problem, point: &Iterate, group: usize, c: usize, lane: usize) -> [f64; 3] {
    let all = problem.segments * problem.cells;
    let t = problem.shares[group * all + c].0[lane] * point.durations[c / problem.cells];
    if c == 0 {
        let [_, v, a] = problem.groups[group].start;
        [t, v.0[lane], a.0[lane]]
    } else {
        let [_, v, a] = point.cells[group * all + c - 1].s;
        [t, v.0[lane], a.0[lane]]
    }
}

/// The slacks of one joint's cell, in the order of [`super::chain::View::slack`].
pub fn slack(problem: &Problem, point: &Iterate, group: usize, c: usize, lane: usize) -> [f64; 8] {
    let all = problem.segments * problem.cells;
    let [t, v, a] = before(problem, point, group, c, lane);
    let [_, v1, a1] = point.cells[group * all + c].s.map(|s| s.0[lane]);
    let g = &problem.groups[group];
    let [_, acceleration, jerk] = g.limits.map(|limit| limit.0[lane]);
    let [velocity, inside] = problem.speeds_of(group, c).map(|limit| limit.0[lane]);
    let middle = if c == 0 { v } else { v + 0.5 * g.smooth.0[lane] * t * a };
    let last = c + 1 == all;
    let most_in_middle = if c == 0 || last { 2.0 * inside } else { inside };
    let acceleration = if last { acceleration * (1.0 + g.smooth.0[lane]) } else { acceleration };
    [
        jerk * t - (a1 - a),
        jerk * t + (a1 - a),
        acceleration - a1,
        acceleration + a1,
        velocity - v1,
        velocity + v1,
        most_in_middle - middle,
        most_in_middle + middle,
    ]
}
