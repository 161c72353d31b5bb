//! A lower bound on what one joint pays for one segment of given duration.
//!
//! The joint pays `p · s` for the state `s = (v, a)` in which it enters and gets back `p' · s'` for the one in which
//! it leaves. The least payment over all lawful curves is a linear programme in infinitely many variables. We relax it to
//! finitely many: the segment is divided into cells of length `T`, the variables are their mean velocities `w_k`, the
//! mean accelerations `m_k` (times `T`) from one cell's centre to the next, and the states at the ends. A mean is
//! within the limits of what it is a mean of, so that
//!
//! ```text
//! |w_k| <= V,   m_k = w_k - w_(k-1),   |m_k| <= A T,   |m_(k+1) - m_k| <= J T²,   sum w_k = D / T
//! ```
//!
//! hold for every lawful curve; at the ends the same holds for half cells, see [`super::programme`].
//!
//! Any multipliers of this finite programme give a lower bound, however they were found. An
//! interior point method finds good ones for eight cases at a time, [`Minorant`] holds
//! what they prove, also of other durations.

use pulp::Arch;

use super::programme::{CELLS, Scaled, Solve};
use crate::math::lanes::{Lanes, WIDTH};

/// Mean accelerations that any velocities admit, in units of their limit: half a cell from one limit to the other.
const ANY_ACCELERATION: f64 = 4.0;

/// Differences of mean accelerations that any accelerations admit, in units of their
/// limit: twice the limit, of which `reach` takes two thirds.
const ANY_JERK: f64 = 3.0;

/// One joint, one segment, one duration.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Duration, s.
    pub duration: f64,
    /// Way, rad or m.
    pub way: f64,
    /// Limits of velocity, acceleration and jerk. Velocity's is finite; prices on acceleration count
    /// only where jerk's is.
    pub limits: [f64; 3],
    /// What velocity and acceleration cost at the start: s per rad/s and per rad/s².
    pub enter: [f64; 2],
    /// What they give back at the end.
    pub leave: [f64; 2],
    /// Whether the joint starts at rest: then `enter` does not count.
    pub from_rest: bool,
    /// By how much the position may deviate to either side at the start and at the end, rad or m.
    pub rooms: [f64; 2],
    /// What a deviation costs at the start and gives back at the end, s per rad or m.
    pub positions: [f64; 2],
}

impl Case {
    /// The same for a joint that ends at rest, with time running backwards: its way and
    /// velocities change sign, accelerations do not.
    pub fn backwards(&self) -> Self {
        let [v, a] = self.enter;
        let (way, enter, leave) = (-self.way, [0.0; 2], [v, -a]);
        let rooms = [self.rooms[1], self.rooms[0]];
        let positions = [-self.positions[1], -self.positions[0]];
        Self { way, enter, leave, from_rest: true, rooms, positions, ..*self }
    }
}

/// What the way of a joint with room adds: `l D - R |p - l| - R' |l - p'|`, where the multiplier `l` of the way scales
/// with the inverse of time. It is the least of four straight lines in `1 / r`.
#[derive(Clone, Copy, Debug)]
struct Turn {
    /// `[constant, factor of 1 / r]` of each.
    lines: [[f64; 2]; 4],
}

impl Turn {
    /// `slope` is the multiplier at the minorant's own duration, s per rad or m.
    fn new(case: &Case, slope: f64) -> Self {
        let Case { way, rooms, positions, .. } = case;
        let line = |signs: [f64; 2]| {
            let [from, to] = [signs[0] * rooms[0], signs[1] * rooms[1]];
            [from * positions[0] - to * positions[1], (way - from + to) * slope]
        };
        Self { lines: [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(line) }
    }

    /// Not above what it adds, and concave in `r`; equal to it at one.
    fn at(&self, r: f64) -> f64 {
        self.lines
            .iter()
            .map(|[fixed, factor]| fixed + factor * inverse(*factor, r))
            .fold(f64::INFINITY, f64::min)
    }

    fn size(&self) -> f64 {
        self.lines.iter().flatten().map(|value| value.abs()).sum()
    }
}

/// What stands for `1 / r` so that its multiple by `factor` is concave in `r` and no larger. Where it is convex its tangent
/// at one is below, so that between two durations the least value is at one of them.
fn inverse(factor: f64, r: f64) -> f64 {
    if factor >= 0.0 { 2.0 - r } else { 1.0 / r }
}

/// A lower bound on the payment for any duration `h = r h0`, good near the one it was made for:
/// `fixed + linear r + inverse / r - square r² - kink |r - 1|`, with more terms in `1 / r` where there is room.
///
/// The multipliers of the way, of velocity, of acceleration and of jerk limits stay the same in units that scale
/// with `h`; only prices on acceleration do not fit any more, by `kink`.
#[derive(Clone, Debug, Default)]
pub struct Minorant {
    /// The duration `h0` for which it was made, s.
    pub duration: f64,
    fixed: f64,
    linear: f64,
    inverse: f64,
    square: f64,
    kink: f64,
    turns: Vec<Turn>,
    /// Sum of the magnitudes of all parts: what rounding is relative to where they cancel.
    size: f64,
}

/// What rounding may change in a value, as a share of the magnitudes of its parts.
const ROUNDING: f64 = 1e-12;

impl Minorant {
    /// What all joints pay, and the time itself; all made for the same duration.
    pub fn sum(joints: &[Self]) -> Self {
        let duration = joints.first().map_or(0.0, |joint| joint.duration);
        let mut sum = Self { duration, linear: duration, size: duration, ..Self::default() };
        for joint in joints {
            sum.fixed += joint.fixed;
            sum.linear += joint.linear;
            sum.inverse += joint.inverse;
            sum.square += joint.square;
            sum.kink += joint.kink;
            sum.turns.extend_from_slice(&joint.turns);
            sum.size += joint.size;
        }
        sum
    }

    /// The bound at a duration.
    pub fn at(&self, duration: f64) -> f64 {
        let r = duration / self.duration;
        let turns: f64 = self.turns.iter().map(|turn| turn.at(r)).sum();
        self.fixed + self.linear * r + self.inverse * inverse(self.inverse, r)
            - self.square * r * r
            - self.kink * (r - 1.0).abs()
            + turns
            - ROUNDING * self.size * (r * r).max(1.0 / r).max(1.0)
    }

    /// False if some number was too large: then it proves nothing.
    pub fn is_finite(&self) -> bool {
        self.size.is_finite()
    }
}

/// The cases in units of the programme.
fn scaled(cases: &[Case]) -> Scaled {
    let each = |f: &dyn Fn(&Case) -> f64| {
        let values: Vec<f64> = cases.iter().map(f).collect();
        Lanes::from_slice(&values, values[0])
    };
    let t = |case: &Case| case.duration / CELLS as f64;
    let price = |case: &Case, price: [f64; 2], e: usize| {
        let per = case.limits[0] / case.duration;
        if e == 0 { price[0] * per } else { price[1] * per / t(case) }
    };
    let acceleration = |c: &Case| {
        let limit = c.limits[1] * t(c) / c.limits[0];
        if limit.is_finite() { limit } else { ANY_ACCELERATION }
    };
    let jerk = |c: &Case| {
        let limit = c.limits[2] * t(c) * t(c) / c.limits[0];
        if limit.is_finite() { limit } else { ANY_JERK * acceleration(c) }
    };
    Scaled {
        limits: [each(&acceleration), each(&jerk)],
        way: each(&|c| c.way / (t(c) * c.limits[0])),
        enter: [0, 1].map(|e| each(&|c| price(c, c.enter, e))),
        leave: [0, 1].map(|e| each(&|c| price(c, c.leave, e))),
        rooms: [0, 1].map(|side| each(&|c| c.rooms[side] / (t(c) * c.limits[0]))),
        positions: [0, 1]
            .map(|side| each(&|c| c.positions[side] * (t(c) * c.limits[0]) / c.duration)),
        from_rest: each(&|c| f64::from(u8::from(c.from_rest))),
    }
}

/// A lower bound on the payment of all joints, a straight line over durations: good for the shortest where deviations can
/// make up for all ways.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    fixed: f64,
    slope: f64,
}

impl Near {
    /// That of `cases`, by any duration.
    ///
    /// The state at the end is nearly that at the start: velocity differs by at most `A h`, acceleration by `J h`, and the positions
    /// by `V h`, each times its price. For the position that is any slope `l` in
    /// `l (D + e' - e) = l times the integral of velocity`.
    pub fn new(cases: &[Case]) -> Self {
        let (mut fixed, mut slope, mut size) = (0.0, 1.0, 0.0);
        // A price of zero also where there is no limit.
        let most = |price: f64, limit: f64| if price == 0.0 { 0.0 } else { price.abs() * limit };
        for Case { way, limits, enter, leave, from_rest, rooms, positions, .. } in cases {
            let lost = (positions[0] - positions[1]).abs();
            let by_enter = positions[0] * way - rooms[1] * lost;
            let by_leave = positions[1] * way - rooms[0] * lost;
            let price = if by_enter > by_leave { positions[0] } else { positions[1] };
            let turns =
                |e: usize| if *from_rest { 0.0 } else { most(enter[e] - leave[e], limits[e]) };
            let parts = [by_enter.max(by_leave), -turns(0), -turns(1)];
            fixed += parts.iter().sum::<f64>();
            slope -= most(price, limits[0]) + most(leave[0], limits[1]) + most(leave[1], limits[2]);
            size += parts.iter().map(|part| part.abs()).sum::<f64>()
                + (lost + price.abs()) * (way.abs() + rooms[0] + rooms[1]);
        }
        Self { fixed: fixed - ROUNDING * size, slope: slope - ROUNDING * slope.abs() }
    }

    /// The bound at a duration.
    pub fn at(&self, duration: f64) -> f64 {
        self.fixed + self.slope * duration
    }
}

/// Bounds for all `cases`, in their order.
pub fn minorants(cases: &[Case]) -> Vec<Minorant> {
    let arch = Arch::new();
    let mut all = Vec::with_capacity(cases.len());
    for chunk in cases.chunks(WIDTH) {
        let scaled = scaled(chunk);
        let values = arch.dispatch(Solve(&scaled, chunk.len()));
        for (lane, case) in chunk.iter().enumerate() {
            let [by_way, velocity, acceleration, jerk, lambda] = values.map(|v| v.0[lane]);
            let h = case.duration;
            let entered = if case.from_rest { 0.0 } else { case.enter[1].abs() };
            let mut minorant = Minorant {
                duration: h,
                fixed: -h * velocity,
                inverse: h * by_way,
                ..Minorant::default()
            };
            // What stands for a limit that does not exist scales as the next that does.
            let [_, has_acceleration, has_jerk] = case.limits.map(f64::is_finite);
            let slower = if has_acceleration { &mut minorant.linear } else { &mut minorant.fixed };
            *slower -= h * acceleration;
            if has_jerk {
                minorant.square = h * jerk;
                minorant.kink = case.limits[1] * (entered + case.leave[1].abs());
            } else {
                *slower -= h * jerk;
            }
            if case.rooms != [0.0; 2] {
                // The multiplier's unit is the duration for a cell's way at full speed.
                let slope = lambda * CELLS as f64 / case.limits[0];
                (minorant.inverse, minorant.turns) = (0.0, vec![Turn::new(case, slope)]);
            }
            minorant.size = minorant.turns.iter().map(Turn::size).sum::<f64>()
                + minorant.fixed.abs()
                + minorant.linear.abs()
                + minorant.inverse.abs()
                + minorant.square;
            all.push(minorant);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;

    /// Nothing but a duration.
    fn none(duration: f64) -> Case {
        Case {
            duration,
            way: 0.0,
            limits: [1.0; 3],
            enter: [0.0; 2],
            leave: [0.0; 2],
            from_rest: false,
            rooms: [0.0; 2],
            positions: [0.0; 2],
        }
    }

    /// A random lawful curve: states at its ends, way and duration. Jerk is piecewise constant; the
    /// whole curve is scaled so that it just keeps `limits`.
    fn curve(
        random: &mut RandomStream,
        limits: [f64; 3],
        from_rest: bool,
    ) -> ([f64; 2], [f64; 2], f64, f64) {
        let mut state = [random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)];
        if from_rest {
            state = [0.0; 2];
        }
        let start = state;
        let (mut way, mut duration) = (0.0, 0.0);
        let mut peaks = [state[0].abs(), state[1].abs(), 0.0f64];
        for _ in 0..1 + (random.unit() * 8.0) as usize {
            let jerk = (random.unit() * 3.0).floor() - 1.0;
            let (steps, length) = (400, random.uniform(0.0, 1.5));
            let dt = length / f64::from(steps);
            for _ in 0..steps {
                let [v, a] = state;
                way += dt * (v + dt * (a / 2.0 + dt * jerk / 6.0));
                state = [v + dt * (a + dt * jerk / 2.0), a + dt * jerk];
                // Speed between the samples is above them by less than this.
                let beyond = dt * dt * jerk.abs() + 1e-9;
                peaks = [
                    peaks[0].max(state[0].abs() + beyond),
                    peaks[1].max(state[1].abs()),
                    peaks[2].max(jerk.abs()),
                ];
            }
            duration += length;
        }
        let scale = (0..3).map(|e| limits[e] / peaks[e]).fold(f64::INFINITY, f64::min);
        (start.map(|s| s * scale), state.map(|s| s * scale), way * scale, duration)
    }

    /// Draws limits over three decades, some of which do not exist, and prices of any size.
    fn draw(random: &mut RandomStream) -> ([f64; 3], [[f64; 2]; 2]) {
        let mut limit = |there: f64| {
            let value = 10f64.powf(random.uniform(-1.5, 1.5));
            if random.unit() < there { value } else { f64::INFINITY }
        };
        let limits = [limit(1.0), limit(0.85), limit(0.8)];
        let mut price = |e: usize| {
            let there = e == 0 || limits[2].is_finite();
            let size = 10f64.powf(random.uniform(-3.0, 1.0));
            if there { random.uniform(-1.0, 1.0) * size } else { 0.0 }
        };
        ([limits[0], limits[1].min(1e3), limits[2]], [[price(0), price(1)], [price(0), price(1)]])
    }

    /// Attack: curves that are lawful must never pay less than the bound, at the
    /// duration it was made for and at others.
    #[test]
    fn no_lawful_curve_pays_less_than_the_bound() {
        let mut random = RandomStream::new(5, 0);
        let (mut checked, mut close) = (0, 0);
        for round in 0..3000 {
            let from_rest = round % 3 == 0;
            let (limits, [enter, leave]) = draw(&mut random);
            let (start, end, way, duration) = curve(&mut random, limits, from_rest);
            let stretch = 2f64.powf(random.uniform(-1.0, 1.0));
            let case = Case { way, limits, enter, leave, from_rest, ..none(duration) };
            let made = [
                case,
                Case { duration: duration * stretch, ..case },
                Case { duration: duration * 1.01, ..case },
            ];
            let pays =
                enter[0] * start[0] + enter[1] * start[1] - leave[0] * end[0] - leave[1] * end[1];
            for minorant in minorants(&made) {
                let bound = minorant.at(duration);
                let size = limits[0] * (enter[0].abs() + leave[0].abs());
                assert!(
                    bound <= pays + 1e-9 * size.max(1.0),
                    "{round}: {bound} > {pays}, {case:?}"
                );
                checked += 1;
                close += usize::from(bound > pays - 0.5 * size);
            }
        }
        assert_eq!(checked, 9000);
        assert!(close > 500, "only {close} bounds are near enough to test anything");
    }

    /// A joint paid for its speed at the end of a run-up from rest gains all that jerk admits, and
    /// what the bound says is that, nearly: `v = J h²/2`.
    #[test]
    fn the_bound_is_tight_where_the_optimum_is_known() {
        let (h, jerk) = (0.5, 8.0);
        let way = jerk * h * h * h / 6.0;
        let limits = [10.0, 50.0, jerk];
        let case = Case { way, limits, leave: [1.0, 0.0], from_rest: true, ..none(h) };
        let bound = minorants(&[case])[0].at(h);
        let optimum = -jerk * h * h / 2.0;
        assert!(bound <= optimum && bound > 1.01 * optimum, "{bound}, optimum {optimum}");
        // Braking to rest from the same speed, priced where it enters, is the same the other way round.
        let braking =
            Case { way: -way, enter: [1.0, 0.0], leave: [0.0; 2], from_rest: false, ..case };
        assert_eq!(minorants(&[braking.backwards()])[0].at(h), bound);
    }

    /// Where no lawful curve exists the bound rises without end, so that prices prove it.
    #[test]
    fn impossible_durations_cost_more_than_any_gain() {
        let limits = [2.0, 3.0, 10.0];
        let case = Case { way: 1.5, limits, leave: [0.1, 0.0], from_rest: true, ..none(1.0) };
        let bounds = minorants(&[case, Case { duration: 1.6, ..case }]);
        assert!(bounds[0].at(1.0) > 1.0, "{}", bounds[0].at(1.0));
        assert!(bounds[1].at(1.6) < 0.0, "{}", bounds[1].at(1.6));
    }
}
