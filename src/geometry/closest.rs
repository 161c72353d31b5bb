//! Distances from a segment: to another one in closed form, to a convex set by its projection.

use nalgebra::Vector3;

type Point = Vector3<f64>;

/// A segment from `start` along `along`, whose norm is the length; zero makes a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) start: Point,
    pub(super) along: Point,
}

impl Segment {
    fn at(&self, share: f64) -> Point {
        self.start + self.along * share
    }

    /// Where along the segment it is nearest to `point`, in [0, 1].
    fn nearest_to(&self, point: &Point) -> f64 {
        let square = self.along.norm_squared();
        if square > 0.0 {
            (self.along.dot(&(point - self.start)) / square).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    fn distance_to_point(&self, point: &Point) -> f64 {
        (self.at(self.nearest_to(point)) - point).norm()
    }

    /// The distance of two segments.
    ///
    /// It is taken between the insides of both, or at one of four ends. All five are measured and the least
    /// counts, so that near parallels, where the insides are ill-conditioned, lose nothing.
    pub(super) fn distance_to_segment(&self, other: &Self) -> f64 {
        let (own, others) = (self.along, other.along);
        let between = self.start - other.start;
        let (a, b, c) = (own.norm_squared(), own.dot(&others), others.norm_squared());
        let (d, e) = (own.dot(&between), others.dot(&between));
        let determinant = a * c - b * b;
        let ends = [
            other.distance_to_point(&self.start),
            other.distance_to_point(&self.at(1.0)),
            self.distance_to_point(&other.start),
            self.distance_to_point(&other.at(1.0)),
        ];
        let ends = ends.into_iter().fold(f64::INFINITY, f64::min);
        let share = (b * e - c * d) / determinant;
        if determinant > 0.0 && (0.0..=1.0).contains(&share) {
            ends.min(other.distance_to_point(&self.at(share)))
        } else {
            ends
        }
    }

    /// The distance to a convex set whose nearest point to any point is `project`.
    ///
    /// The distance is convex along the segment and its slope has the sign of `(p - project(p)) · along`, which
    /// grows along it: its zero is found by the Illinois variant of regula falsi, bisecting whenever that is slow.
    pub(super) fn distance_to_convex(&self, project: impl Fn(&Point) -> Point) -> f64 {
        let measure = |share: f64| {
            let point = self.at(share);
            let away = point - project(&point);
            (away.dot(&self.along), away.norm())
        };
        let (mut low, mut high) = (0.0, 1.0);
        let (mut slope_low, distance_low) = measure(low);
        if slope_low >= 0.0 || distance_low == 0.0 {
            return distance_low;
        }
        let (mut slope_high, distance_high) = measure(high);
        if slope_high <= 0.0 || distance_high == 0.0 {
            return distance_high;
        }
        let mut least = distance_low.min(distance_high);
        for step in 0..MAX_STEPS {
            let middle = 0.5 * (low + high);
            let secant = (low * slope_high - high * slope_low) / (slope_high - slope_low);
            let usable = step % 3 != 2 && secant > low && secant < high;
            let share = if usable { secant } else { middle };
            if share <= low || share >= high {
                break;
            }
            let (slope, distance) = measure(share);
            least = least.min(distance);
            if slope == 0.0 || distance == 0.0 {
                break;
            }
            // The end that stays counts half, or regula falsi would creep.
            if slope < 0.0 {
                (low, slope_low, slope_high) = (share, slope, 0.5 * slope_high);
            } else {
                (high, slope_high, slope_low) = (share, slope, 0.5 * slope_low);
            }
        }
        least
    }
}

/// Every third step halves the interval, so this comes down to the last bits.
const MAX_STEPS: usize = 160;
