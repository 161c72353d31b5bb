//! The certificate: exact extrema against every limit, over continuous time.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use utoipa::ToSchema;

use super::ends::Ends;
use super::limits::{DERIVATIVES, JointBounds, Limit};
use super::polynomial_trajectory::Trajectory;
use super::tcp_speed::{TcpLimit, TcpPeak};
use super::via::waypoint_error;
use crate::math::polynomial::{Extremes, derivative_at};

/// How far rounding may carry a peak over its limit, relative to the limit.
pub const LAWFUL_TOLERANCE: f64 = 1e-9;

/// A derivative counts as continuous if it jumps by no more than this share of
/// its own peak in the two pieces that meet. Of a position far from zero not
/// the whole counts: at most 1 rad or m, or the way travelled there.
const JUMP_TOLERANCE: f64 = 1e-6;

/// What rounding may add to a jump of the position, relative to the position.
const POSITION_ROUNDING: f64 = 1e-13;

/// What rounding may add to a jump of another derivative, relative to the joint's largest
/// in the whole trajectory: between two pieces in which it is nothing but rounding, no
/// share of those is large enough.
const ROUNDING: f64 = 1e-12;

/// What a trajectory, as delivered, does to every limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Certificate {
    /// True if no known limit is exceeded at any time, nor the tolerance at waypoints where there is one.
    pub lawful: bool,
    /// Largest ratio of a finite velocity, acceleration, jerk or tool speed peak to its
    /// limit; infinite peaks are among the violations.
    pub worst_ratio: f64,
    /// Highest derivative that is continuous at every inner breakpoint
    /// (0 position, 1 velocity, ...); the polynomial degree if there is none.
    pub continuity: u32,
    /// True if velocity is zero at the start.
    pub starts_at_rest: bool,
    /// True if velocity is zero at the end.
    pub ends_at_rest: bool,
    /// Per joint, in joint order.
    pub joints: Vec<JointCertificate>,
    /// With a limit on it, the largest speed of the tool centre point, m/s: a proven bound, at most a
    /// millionth above a speed that is reached at `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tcp_speed: Option<Peak>,
    /// Where limits are exceeded; empty if lawful.
    pub violations: Vec<Violation>,
    /// Largest distance from a waypoint at its time, rad or m; null without waypoints.
    pub waypoint_error: Option<f64>,
    /// By how much each joint may miss inner waypoints, rad or m; absent where that is no limit, and then
    /// `waypoint_error` only tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub via_tolerance: Option<Vec<f64>>,
    /// Smallest distance to an obstacle; null where no scene was given.
    pub clearance: Option<Clearance>,
    /// SHA-256 of the delivered coefficients: breakpoints, then the
    /// coefficients piece by piece and joint by joint, each list preceded by
    /// its length as a 64-bit integer, all little-endian, as lower-case hex.
    pub sha256: String,
}

/// One joint's extrema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JointCertificate {
    /// Joint name.
    pub name: String,
    /// Extrema of the position, rad or m.
    pub position: PositionRange,
    /// Peak speed.
    pub velocity: Peak,
    /// Peak acceleration.
    pub acceleration: Peak,
    /// Peak jerk.
    pub jerk: Peak,
}

/// The largest magnitude of a derivative and its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Peak {
    /// Largest magnitude; null if it is infinite, because the derivative below jumps.
    pub peak: Option<f64>,
    /// When, s; if it is infinite, where the largest jump is.
    pub at: f64,
    /// The limit; null if none is known, and then none is enforced.
    pub limit: Option<f64>,
    /// `peak / limit`; null without a limit or with an infinite peak.
    pub ratio: Option<f64>,
    /// Where the limit comes from; null if none is known.
    pub provenance: Option<String>,
}

/// The extrema of a joint's position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PositionRange {
    /// Smallest position, rad or m.
    pub min: f64,
    /// When, s.
    pub min_at: f64,
    /// Largest position, rad or m.
    pub max: f64,
    /// When, s.
    pub max_at: f64,
    /// Lower limit; null if none is known.
    pub lower: Option<f64>,
    /// Upper limit; null if none is known.
    pub upper: Option<f64>,
    /// Where the limits come from; null if none is known.
    pub provenance: Option<String>,
}

/// A limit exceeded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Violation {
    /// Joint name; `tcp` for the tool centre point.
    pub joint: String,
    /// `position`, `velocity`, `acceleration`, `jerk`, `via_tolerance` or, of the tool centre point, `tcp_speed`.
    pub limit: String,
    /// When it is exceeded most, s.
    pub at: f64,
    /// The value there; null if infinite.
    pub value: Option<f64>,
    /// The limit.
    pub limit_value: f64,
    /// In words; where the value is infinite, with the size of the jump behind it.
    pub detail: String,
}

/// Smallest distance between the robot and what stands around it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Clearance {
    /// Distance, m.
    pub smallest_m: f64,
    /// When, s.
    pub at: f64,
    /// The two bodies.
    pub pair: [String; 2],
}

impl Certificate {
    /// Certifies a valid trajectory against one limit set per joint.
    ///
    /// `waypoints` are configurations with the times at which they are due.
    /// Before and after, the robot is taken to stand still where the trajectory
    /// is at rest: acceleration that then steps is infinite jerk.
    pub fn new(
        trajectory: &Trajectory,
        limits: &[JointBounds],
        waypoints: &[(f64, &[f64])],
    ) -> Self {
        Self::joined(trajectory, limits, waypoints, None)
    }

    /// The same for a trajectory that continues a motion and is continued: where
    /// velocity or acceleration at its ends are not those of `ends`, they jump.
    pub fn joined(
        trajectory: &Trajectory,
        limits: &[JointBounds],
        waypoints: &[(f64, &[f64])],
        ends: Option<&Ends>,
    ) -> Self {
        let study = |joint: usize| {
            let given = ends.map(|ends| [ends.start[joint], ends.goal[joint]]);
            JointStudy::new(trajectory, joint, given)
        };
        let studies: Vec<JointStudy> = (0..limits.len()).map(study).collect();
        let joints: Vec<JointCertificate> =
            studies.iter().zip(limits).map(|(study, limits)| study.certify(limits)).collect();
        let violations: Vec<Violation> = joints
            .iter()
            .zip(&studies)
            .zip(limits)
            .flat_map(|((joint, study), limits)| joint.violations(study, limits))
            .collect();
        let ratios = joints.iter().flat_map(|joint| {
            [&joint.velocity, &joint.acceleration, &joint.jerk].map(|peak| peak.ratio)
        });
        Self {
            lawful: violations.is_empty(),
            worst_ratio: ratios.flatten().fold(0.0, f64::max),
            continuity: studies.iter().map(|study| study.continuity).min().unwrap_or(0),
            starts_at_rest: studies.iter().all(|study| study.rests[0]),
            ends_at_rest: studies.iter().all(|study| study.rests[1]),
            joints,
            tcp_speed: None,
            violations,
            waypoint_error: waypoint_error(trajectory, waypoints),
            via_tolerance: None,
            clearance: None,
            sha256: trajectory.sha256(),
        }
    }

    /// The same with a limit on the speed of the tool centre point; `trajectory` is the one certified.
    pub fn with_tcp_limit(mut self, trajectory: &Trajectory, limit: Option<&TcpLimit>) -> Self {
        let Some(limit) = limit else { return self };
        // Where a joint jumps, so does the tool.
        let jump = self.joints.iter().find(|joint| joint.velocity.peak.is_none());
        let TcpPeak { upper, at, .. } = match jump {
            Some(joint) => {
                TcpPeak { upper: f64::INFINITY, lower: f64::INFINITY, at: joint.velocity.at }
            }
            None => limit.peak(trajectory),
        };
        let finite = Some(upper).filter(|upper| upper.is_finite());
        let ratio = finite.map(|upper| upper / limit.speed);
        self.worst_ratio = self.worst_ratio.max(ratio.unwrap_or(0.0));
        if upper > limit.speed * (1.0 + LAWFUL_TOLERANCE) {
            let reached = match finite {
                Some(upper) => format!("reaches {upper:.6} m/s at {at:.6} s"),
                None => format!("is infinite or too large to compute at {at:.6} s"),
            };
            self.lawful = false;
            self.violations.push(Violation {
                joint: "tcp".to_owned(),
                limit: "tcp_speed".to_owned(),
                at,
                value: finite,
                limit_value: limit.speed,
                detail: format!("tcp speed {reached}, above its limit of {} m/s", limit.speed),
            });
        }
        let provenance = Some("request".to_owned());
        self.tcp_speed =
            Some(Peak { peak: finite, at, limit: Some(limit.speed), ratio, provenance });
        self
    }
}

/// The largest magnitude of one derivative over the trajectory.
#[derive(Clone, Copy)]
struct Largest {
    value: f64,
    at: f64,
}

impl Largest {
    /// A value that cannot be computed counts as infinite.
    fn include(&mut self, value: f64, at: f64) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if value > self.value {
            *self = Self { value, at };
        }
    }
}

/// Where a derivative jumps, which makes all higher ones infinite.
#[derive(Clone, Copy)]
struct Jump {
    /// 0 position, 1 velocity, 2 acceleration, ...
    order: usize,
    /// rad or m, per second to the order; infinite if it cannot be computed.
    size: f64,
    at: f64,
}

impl Jump {
    /// A jump of a lower derivative is worse than any of a higher one.
    fn is_worse_than(&self, other: &Self) -> bool {
        self.order < other.order || self.order == other.order && self.size > other.size
    }

    fn in_words(&self, limits: &JointBounds) -> String {
        let name = if self.order == 0 { "position" } else { DERIVATIVES[self.order - 1] };
        let (size, unit) = (self.size, limits.unit_of(self.order));
        if size < 1e-3 {
            format!("{name} jumps by {size:.3e} {unit}")
        } else {
            format!("{name} jumps by {size:.6} {unit}")
        }
    }
}

/// What one joint does.
struct JointStudy {
    position: [Largest; 2],
    peaks: [Largest; 3],
    /// The worst jump behind each infinite peak.
    causes: [Option<Jump>; 3],
    continuity: u32,
    rests: [bool; 2],
}

impl JointStudy {
    /// `given` are velocity and acceleration before the start and after the end, where known.
    fn new(trajectory: &Trajectory, joint: usize, given: Option<[[f64; 2]; 2]>) -> Self {
        let lowest = Largest { value: f64::NEG_INFINITY, at: 0.0 };
        let none = Largest { value: 0.0, at: 0.0 };
        let mut study = Self {
            position: [lowest; 2],
            peaks: [none; 3],
            causes: [None; 3],
            continuity: 0,
            rests: [true; 2],
        };
        let (mut all, mut degree) = (Vec::with_capacity(trajectory.pieces.len()), 0);
        for (joints, ends) in trajectory.pieces.iter().zip(trajectory.breakpoints.windows(2)) {
            let start = ends[0];
            let extremes = Extremes::new(&joints[joint], ends[1] - start);
            degree = degree.max(joints[joint].len() as u32 - 1);
            let position = extremes.of(0);
            study.position[0].include(-position.min, start + position.min_at);
            study.position[1].include(position.max, start + position.max_at);
            for (order, peak) in study.peaks.iter_mut().enumerate() {
                let (value, at) = extremes.of(order + 1).peak();
                peak.include(value, start + at);
            }
            all.push(extremes);
        }
        study.continuity = degree;
        study.look_at_seams(trajectory, joint, &all);
        study.look_at_ends(trajectory, joint, given);
        study
    }

    /// Finds the jumps between pieces with these extremes.
    fn look_at_seams(&mut self, trajectory: &Trajectory, joint: usize, all: &[Extremes]) {
        let rounding = self.peaks.each_ref().map(|peak| ROUNDING * peak.value);
        for (seam, extremes) in all.windows(2).enumerate() {
            let [left, right] =
                [seam, seam + 1].map(|piece| trajectory.pieces[piece][joint].as_slice());
            let at = trajectory.breakpoints[seam + 1];
            let length = at - trajectory.breakpoints[seam];
            let jump = first_jump([left, right], [&extremes[0], &extremes[1]], length, rounding);
            if let Some((order, size)) = jump {
                self.continuity = self.continuity.min((order as u32).saturating_sub(1));
                self.blame(Jump { order, size, at });
            }
        }
    }

    /// A derivative that jumps makes all higher ones infinite there.
    fn blame(&mut self, jump: Jump) {
        for (peak, cause) in self.peaks.iter_mut().zip(&mut self.causes).skip(jump.order) {
            if cause.is_none_or(|known| jump.is_worse_than(&known)) {
                *peak = Largest { value: f64::INFINITY, at: jump.at };
                *cause = Some(jump);
            }
        }
    }

    fn look_at_ends(
        &mut self,
        trajectory: &Trajectory,
        joint: usize,
        given: Option<[[f64; 2]; 2]>,
    ) {
        let last = trajectory.pieces.len() - 1;
        let length = trajectory.breakpoints[last + 1] - trajectory.breakpoints[last];
        for (side, piece, local) in [(0, 0, 0.0), (1, last, length)] {
            let coefficients = &trajectory.pieces[piece][joint];
            let here = [1, 2].map(|order| derivative_at(coefficients, order, local));
            let tolerances = [0, 1].map(|order| JUMP_TOLERANCE * self.peaks[order].value);
            self.rests[side] = here[0].abs() <= tolerances[0];
            let outside = given.map(|ends| ends[side]);
            let Some(outside) = outside.or(self.rests[side].then_some([0.0; 2])) else { continue };
            let at = if side == 0 { 0.0 } else { trajectory.duration() };
            for order in [1, 2] {
                let size = (here[order - 1] - outside[order - 1]).abs();
                if size > tolerances[order - 1] {
                    self.blame(Jump { order, size, at });
                }
            }
        }
    }

    fn certify(&self, limits: &JointBounds) -> JointCertificate {
        let peak = |order: usize| {
            let Largest { value, at } = self.peaks[order];
            let limit = limits.derivatives[order].as_ref();
            let finite = Some(value).filter(|value| value.is_finite());
            Peak {
                peak: finite,
                at,
                limit: limit.map(|limit| limit.value),
                ratio: finite.zip(limit).map(|(value, limit)| value / limit.value),
                provenance: limit.map(|limit| limit.provenance.clone()),
            }
        };
        let [min, max] = self.position;
        let provenance = limits.lower.as_ref().or(limits.upper.as_ref());
        JointCertificate {
            name: limits.name.clone(),
            position: PositionRange {
                min: -min.value,
                min_at: min.at,
                max: max.value,
                max_at: max.at,
                lower: limits.lower.as_ref().map(|limit| limit.value),
                upper: limits.upper.as_ref().map(|limit| limit.value),
                provenance: provenance.map(|limit| limit.provenance.clone()),
            },
            velocity: peak(0),
            acceleration: peak(1),
            jerk: peak(2),
        }
    }
}

/// The lowest derivative that jumps between two pieces, if any does, and by how much. Velocity,
/// acceleration and jerk may jump by `rounding`.
fn first_jump(
    pieces: [&[f64]; 2],
    extremes: [&Extremes; 2],
    length: f64,
    rounding: [f64; 3],
) -> Option<(usize, f64)> {
    let [left, right] = pieces;
    (0..extremes[0].orders().max(extremes[1].orders())).find_map(|order| {
        let jump = derivative_at(left, order, length) - derivative_at(right, order, 0.0);
        let [a, b] = extremes.map(|extremes| extremes.of(order));
        let peak = a.peak().0.max(b.peak().0);
        let tolerance = if order == 0 {
            let way = a.max.max(b.max) - a.min.min(b.min);
            JUMP_TOLERANCE * peak.min(way.max(1.0)) + POSITION_ROUNDING * peak
        } else {
            JUMP_TOLERANCE * peak + rounding.get(order - 1).unwrap_or(&0.0)
        };
        // What cannot be computed is not continuous.
        let size = if jump.is_nan() { f64::INFINITY } else { jump.abs() };
        (jump.is_nan() || size > tolerance).then_some((order, size))
    })
}

impl JointCertificate {
    fn violations(&self, study: &JointStudy, limits: &JointBounds) -> Vec<Violation> {
        let mut found = Vec::new();
        let range = &self.position;
        let sides = [
            (&limits.lower, range.min, range.min_at, -1.0, "below"),
            (&limits.upper, range.max, range.max_at, 1.0, "above"),
        ];
        for (limit, value, at, sign, word) in sides {
            let Some(Limit { value: limit, .. }) = limit else { continue };
            let excess = sign * (value - limit);
            if excess > LAWFUL_TOLERANCE * limit.abs().max(1.0) {
                let unit = limits.unit_of(0);
                let detail = format!(
                    "{} reaches {value:.6} {unit} at {at:.6} s, {word} its limit of {limit} {unit}",
                    self.name
                );
                found.push(self.violation("position", at, Some(value), *limit, detail));
            }
        }
        for (order, peak) in [&self.velocity, &self.acceleration, &self.jerk].iter().enumerate() {
            let Some(limit) = peak.limit else { continue };
            if peak.peak.is_some_and(|peak| peak <= limit * (1.0 + LAWFUL_TOLERANCE)) {
                continue;
            }
            let (name, unit) = (DERIVATIVES[order], limits.unit_of(order + 1));
            let at = peak.at;
            let reached = match (peak.peak, &study.causes[order]) {
                (Some(peak), _) => format!("reaches {peak:.6} {unit} at {at:.6} s"),
                (None, Some(jump)) => {
                    format!("is infinite at {at:.6} s, where {}", jump.in_words(limits))
                }
                (None, None) => format!("is too large to compute at {at:.6} s"),
            };
            let detail =
                format!("{} {name} {reached}, above its limit of {limit} {unit}", self.name);
            found.push(self.violation(name, peak.at, peak.peak, limit, detail));
        }
        found
    }

    fn violation(
        &self,
        limit: &str,
        at: f64,
        value: Option<f64>,
        limit_value: f64,
        detail: String,
    ) -> Violation {
        Violation {
            joint: self.name.clone(),
            limit: limit.to_owned(),
            at,
            value,
            limit_value,
            detail,
        }
    }
}

impl Trajectory {
    /// SHA-256 of the coefficients, see [`Certificate::sha256`].
    pub fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        let mut list = |values: &[f64]| {
            hash.update((values.len() as u64).to_le_bytes());
            for value in values {
                hash.update(value.to_le_bytes());
            }
        };
        list(&self.breakpoints);
        self.pieces.iter().flatten().for_each(|coefficients| list(coefficients));
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
