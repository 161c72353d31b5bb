//! The largest speed of the tool centre point, proven over continuous time.
//!
//! # The bound
//!
//! Let `p(t)` be the tool's position and `v = p' = J(q) q'` its velocity, whose magnitude is the speed. Within a piece of a
//! trajectory everything is smooth. Let `K` bound `|v''|` there ([`Kinematics::tool_jerk_bound`], from
//! the joints' exact extrema over the piece). On an interval `[a, b]` of length `w` the straight line `l` from `v(a)` to `v(b)` stays
//! near `v`: componentwise in any direction `n`, the error of linear interpolation is at most `w²/8` times the largest
//! `|n · v''|`, so that `|v - l| <= K w²/8`. The magnitude of a straight line's points is convex, hence
//!
//! ```text
//! |v(t)| <= max(|v(a)|, |v(b)|) + K w²/8    on [a, b].
//! ```
//!
//! The excess shrinks with the square of the interval, so that even a speed that is constant for long is soon
//! known: a Lipschitz bound, whose excess shrinks with the interval itself, would need the square of as many.
//!
//! # Branch and bound
//!
//! The speed at any time is a lower bound of the peak; the largest of the above over all intervals an upper one. The interval
//! whose bound is highest is halved until both differ by less than a millionth. Because the tolerance is relative, the same
//! motion slowed down takes the same steps, and both bounds scale exactly as speeds do.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::polynomial_trajectory::Trajectory;
use crate::math::polynomial::{Extremes, derivatives};
use crate::robot::{Jacobian, JointRange, Kinematics, LinkFrames};

/// How far the upper bound may be from the lower one, relative to the peak or, where that is larger, to the limit.
pub const TOLERANCE: f64 = 1e-6;

/// Most speeds that are looked at beyond two per piece: about a second's work. The upper bound is
/// one even if it is not tight by then.
const MOST_EVALUATIONS: usize = 1 << 20;

/// A limit on the speed of the tool centre point.
#[derive(Clone, Copy, Debug)]
pub struct TcpLimit<'a> {
    /// Where the tool is and how it moves with the joints.
    pub kinematics: &'a Kinematics,
    /// The limit, m/s.
    pub speed: f64,
}

/// The largest speed of the tool centre point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TcpPeak {
    /// No speed is higher, m/s; infinite where that cannot be computed.
    pub upper: f64,
    /// The speed at [`at`](Self::at), m/s: the highest that was seen.
    pub lower: f64,
    /// When, s.
    pub at: f64,
}

/// A part of a piece, in the piece's own time.
struct Span {
    /// No speed in it is higher.
    bound: f64,
    piece: usize,
    from: f64,
    to: f64,
    /// At its two ends.
    speeds: [f64; 2],
    /// A bound on the tool's jerk in its piece.
    jerk: f64,
}

impl Ord for Span {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |span: &Self| (span.piece, span.from.to_bits());
        self.bound.total_cmp(&other.bound).then_with(|| place(other).cmp(&place(self)))
    }
}

impl PartialOrd for Span {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Span {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Span {}

impl TcpLimit<'_> {
    /// The largest speed over a whole valid trajectory of the robot.
    pub fn peak(&self, trajectory: &Trajectory) -> TcpPeak {
        self.peak_between(trajectory, [0.0, trajectory.duration()])
    }

    /// The largest speed between two times, s.
    pub fn peak_between(&self, trajectory: &Trajectory, window: [f64; 2]) -> TcpPeak {
        let mut search = Search::new(self, trajectory);
        let [first, last] = window.map(|t| trajectory.locate(t).0);
        for piece in first..=last {
            search.add_piece(piece, window);
        }
        search.run()
    }
}

/// A search for the peak, with its working memory.
struct Search<'a> {
    limit: &'a TcpLimit<'a>,
    trajectory: &'a Trajectory,
    open: BinaryHeap<Span>,
    best: (f64, f64),
    position: Vec<f64>,
    velocity: Vec<f64>,
    frames: LinkFrames,
    jacobian: Jacobian,
}

impl<'a> Search<'a> {
    fn new(limit: &'a TcpLimit<'a>, trajectory: &'a Trajectory) -> Self {
        let dof = limit.kinematics.dof();
        Self {
            limit,
            trajectory,
            open: BinaryHeap::new(),
            best: (0.0, 0.0),
            position: vec![0.0; dof],
            velocity: vec![0.0; dof],
            frames: LinkFrames::new(limit.kinematics),
            jacobian: Jacobian::new(dof),
        }
    }

    /// Adds what of `piece` lies in the window.
    fn add_piece(&mut self, piece: usize, window: [f64; 2]) {
        let [start, end] = [0, 1].map(|side| self.trajectory.breakpoints[piece + side]);
        let length = end - start;
        let [from, to] = window.map(|t| (t - start).max(0.0).min(length));
        if to <= from {
            return;
        }
        let range = |coefficients: &Vec<f64>| {
            let extremes = Extremes::new(coefficients, length);
            let peak = |order: usize| extremes.of(order).peak().0;
            JointRange { position: peak(0), derivatives: [peak(1), peak(2), peak(3)] }
        };
        let joints: Vec<JointRange> = self.trajectory.pieces[piece].iter().map(range).collect();
        let jerk = self.limit.kinematics.tool_jerk_bound(&joints);
        let speeds = [from, to].map(|local| self.look(piece, local));
        self.add(Span { bound: 0.0, piece, from, to, speeds, jerk });
    }

    /// Adds a span, whose bound is still missing, unless it cannot hold the peak.
    fn add(&mut self, mut span: Span) {
        let width = span.to - span.from;
        let excess = span.jerk * width * width / 8.0;
        let bound = span.speeds[0].max(span.speeds[1]) + excess;
        // What cannot be computed is not bounded.
        span.bound = if bound.is_nan() { f64::INFINITY } else { bound };
        if span.bound > self.best.0 {
            self.open.push(span);
        }
    }

    /// Halves the spans that may hold the peak, the most promising first.
    fn run(mut self) -> TcpPeak {
        for _ in 0..MOST_EVALUATIONS {
            let close = self.best.0 + TOLERANCE * self.best.0.max(self.limit.speed);
            let Some(span) = self.open.pop() else { break };
            let middle = 0.5 * (span.from + span.to);
            let narrow = middle <= span.from || middle >= span.to;
            if span.bound <= close || span.bound.is_infinite() || narrow {
                self.open.push(span);
                break;
            }
            let speed = self.look(span.piece, middle);
            let [left, right] = span.speeds;
            self.add(Span { to: middle, speeds: [left, speed], ..span });
            self.add(Span { from: middle, speeds: [speed, right], ..span });
        }
        let (lower, at) = self.best;
        let upper = self.open.peek().map_or(lower, |span| span.bound.max(lower));
        TcpPeak { upper, lower, at }
    }

    /// The speed `local` seconds into `piece`, remembered if it is the highest yet.
    fn look(&mut self, piece: usize, local: f64) -> f64 {
        let speed = self.speed(piece, local);
        if speed > self.best.0 {
            self.best = (speed, self.trajectory.breakpoints[piece] + local);
        }
        speed
    }

    fn speed(&mut self, piece: usize, local: f64) -> f64 {
        for (joint, coefficients) in self.trajectory.pieces[piece].iter().enumerate() {
            let [position, velocity, ..] = derivatives(coefficients, local);
            self.position[joint] = position;
            self.velocity[joint] = velocity;
        }
        let kinematics = self.limit.kinematics;
        kinematics.forward(&self.position, &mut self.frames);
        kinematics.jacobian(&self.frames, &mut self.jacobian);
        kinematics.tool_velocity(&self.jacobian, &self.velocity).norm()
    }
}
