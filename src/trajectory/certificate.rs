//! The certificate: exact extrema against every limit, over continuous time.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a trajectory, as delivered, does to every limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Certificate {
    /// True if no known limit is exceeded at any time.
    pub lawful: bool,
    /// Largest ratio of a velocity, acceleration or jerk peak to its limit.
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
    /// Where limits are exceeded; empty if lawful.
    pub violations: Vec<Violation>,
    /// Largest distance from a waypoint at its time, rad or m; null without waypoints.
    pub waypoint_error: Option<f64>,
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
    /// When, s.
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
    /// Joint name.
    pub joint: String,
    /// `position`, `velocity`, `acceleration` or `jerk`.
    pub limit: String,
    /// When it is exceeded most, s.
    pub at: f64,
    /// The value there; null if infinite.
    pub value: Option<f64>,
    /// The limit.
    pub limit_value: f64,
    /// In words.
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
