//! Distances of convex sets that are known by their support points.
//!
//! Source: Gilbert, Johnson and Keerthi, 1988, doi:10.1109/56.2083. Deviation: the nearest point of a simplex is
//! found by looking at all of its faces, which costs little at four points and has no trouble with flat ones.

use nalgebra::Vector3;

type Point = Vector3<f64>;

/// Below this share of the distance nothing is left to gain.
const TOLERANCE: f64 = 1e-12;
/// Round sets need some tens of steps.
const MAX_STEPS: usize = 200;

/// The distance of the origin from the convex set whose furthest point along a direction is `support`; zero where
/// the origin is inside, and never more than the truth by more than rounding.
///
/// For two sets `A` and `B` the set is `A - B`, whose support along `d` is A's along `d` less B's along `-d`.
pub(super) fn distance_from_origin(support: impl Fn(&Point) -> Point) -> f64 {
    let mut simplex = Simplex::of(support(&Vector3::x()));
    let mut nearest = simplex.points[0];
    // A plane with the set beyond it: its distance from the origin can only be too small.
    let mut proven = 0.0f64;
    for _ in 0..MAX_STEPS {
        let distance = nearest.norm();
        if distance <= TOLERANCE {
            return 0.0;
        }
        let point = support(&-nearest);
        proven = proven.max(point.dot(&nearest) / distance);
        if distance - proven <= TOLERANCE * distance || simplex.contains(&point) {
            break;
        }
        let Some((next, next_nearest)) = simplex.with(point).nearest_face() else { return 0.0 };
        if next_nearest.norm() >= distance {
            break;
        }
        (simplex, nearest) = (next, next_nearest);
    }
    proven
}

/// One to four points.
#[derive(Clone, Copy)]
struct Simplex {
    points: [Point; 4],
    count: usize,
}

impl Simplex {
    fn of(point: Point) -> Self {
        Self { points: [point; 4], count: 1 }
    }

    fn contains(&self, point: &Point) -> bool {
        self.points[..self.count].contains(point)
    }

    /// With another point; at most three may be there.
    fn with(mut self, point: Point) -> Self {
        self.points[self.count] = point;
        self.count += 1;
        self
    }

    /// The face that holds the point nearest to the origin, and that point; nothing if the origin is inside.
    fn nearest_face(&self) -> Option<(Self, Point)> {
        if self.count == 4 && self.encloses_origin() {
            return None;
        }
        let mut best = (*self, Point::repeat(f64::INFINITY));
        // Every subset of the points with at most three of them, as bits.
        for subset in 1u32..1 << self.count {
            if subset.count_ones() > 3 {
                continue;
            }
            let face = self.subset(subset);
            if let Some(nearest) = face.inner_nearest()
                && nearest.norm_squared() < best.1.norm_squared()
            {
                best = (face, nearest);
            }
        }
        Some(best)
    }

    fn subset(&self, bits: u32) -> Self {
        let chosen = (0..self.count).filter(|index| bits >> index & 1 == 1);
        let mut face = Self { count: 0, ..*self };
        for index in chosen {
            face = face.with(self.points[index]);
        }
        face
    }

    fn encloses_origin(&self) -> bool {
        let [a, b, c, d] = self.points;
        let side = |p: &Point, q: &Point, r: &Point| p.dot(&q.cross(r));
        let volume = (b - a).dot(&(c - a).cross(&(d - a)));
        // Signed volumes of the four parts into which the origin divides the simplex.
        let parts = [side(&b, &d, &c), side(&a, &c, &d), side(&a, &d, &b), side(&a, &b, &c)];
        let all = |sign: f64| parts.iter().all(|part| sign * part > 0.0);
        volume != 0.0 && (all(1.0) || all(-1.0))
    }

    /// The point of the plane, line or point through all points that is nearest to the origin, if it is within.
    fn inner_nearest(&self) -> Option<Point> {
        let [a, b, c, _] = self.points;
        match self.count {
            1 => Some(a),
            2 => {
                let along = b - a;
                let share = -a.dot(&along) / along.norm_squared();
                (0.0..=1.0).contains(&share).then(|| a + along * share)
            }
            _ => {
                let (u, v) = (b - a, c - a);
                let normal = u.cross(&v);
                let square = normal.norm_squared();
                let share_u = normal.dot(&(v.cross(&a))) / square;
                let share_v = normal.dot(&(a.cross(&u))) / square;
                let within = share_u >= 0.0 && share_v >= 0.0 && share_u + share_v <= 1.0;
                within.then(|| a + u * share_u + v * share_v)
            }
        }
    }
}
