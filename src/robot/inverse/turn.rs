//! Turns about an axis, and the two questions about them that closed forms are made of.
//!
//! These are subproblems 1 and 4 of the canon of Elias and Wen 2022, arXiv:2211.05737.

use nalgebra::Vector3;

/// Below this a vector has no direction that would tell a turn: m, or a share of a unit vector.
const FREE: f64 = 1e-10;
/// How far a cosine may lie beyond 1 and still count as 1: what is just out of reach is answered by
/// the nearest that is not, and the pose tells how far off that is.
const BEYOND: f64 = 1e-3;
/// Two answers this close are one: the sine between them, squared.
const TOGETHER: f64 = 1e-14;

/// A turn, by its sine and cosine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) sin: f64,
    pub(super) cos: f64,
}

impl Turn {
    /// The turn by `angle`, rad.
    pub(super) fn by(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { sin, cos }
    }

    /// In (-π, π].
    #[inline]
    pub(super) fn angle(self) -> f64 {
        libm::atan2(self.sin, self.cos)
    }

    /// The same turn, back.
    #[inline]
    pub(super) fn back(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    /// The same turn about the axis, or about its opposite where `sense` is -1.
    #[inline]
    pub(super) fn sensed(self, sense: f64) -> Self {
        Self { sin: sense * self.sin, ..self }
    }

    /// `vector` turned about the unit vector `axis`.
    #[inline]
    pub(super) fn apply(self, axis: &Vector3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
        let along = axis.dot(vector) * (1.0 - self.cos);
        vector * self.cos + axis.cross(vector) * self.sin + axis * along
    }
}

/// The turn about `axis` that takes `from` to `to`, seen along the axis; none if either lies along it.
#[inline]
pub(super) fn between(axis: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<Turn> {
    let sin = axis.dot(&from.cross(to));
    let cos = from.dot(to) - axis.dot(from) * axis.dot(to);
    let norm = (sin * sin + cos * cos).sqrt();
    (norm > FREE).then(|| Turn { sin: sin / norm, cos: cos / norm })
}

/// The turns that reach a height.
pub(super) enum Turns {
    /// Every turn does, or none.
    Free,
    /// At most two.
    Some(Few<Turn>),
}

impl Turns {
    /// The turns, or what `otherwise` gives if all of them are as good.
    #[inline]
    pub(super) fn or(self, otherwise: impl FnOnce() -> Turn) -> Few<Turn> {
        match self {
            Self::Free => Few::one(otherwise()),
            Self::Some(turns) => turns,
        }
    }
}

/// At most two of something.
#[derive(Clone, Copy)]
pub(super) struct Few<T>([Option<T>; 2]);

impl<T> Few<T> {
    pub(super) fn none() -> Self {
        Self([None, None])
    }

    pub(super) fn one(item: T) -> Self {
        Self([Some(item), None])
    }

    pub(super) fn map<U>(self, change: impl FnMut(T) -> U) -> Few<U> {
        let mut change = change;
        Few(self.0.map(|item| item.map(&mut change)))
    }
}

impl<T> IntoIterator for Few<T> {
    type Item = T;
    type IntoIter = std::iter::Flatten<std::array::IntoIter<Option<T>, 2>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter().flatten()
    }
}

/// The turns of `arm` about `axis` after which its height along `up`, `up · arm`, is `height`.
#[inline]
pub(super) fn to_height(
    axis: &Vector3<f64>,
    up: &Vector3<f64>,
    arm: &Vector3<f64>,
    height: f64,
) -> Turns {
    // up · turned = constant + a cos + b sin.
    let constant = axis.dot(arm) * axis.dot(up);
    let (a, b) = (up.dot(arm) - constant, up.dot(&axis.cross(arm)));
    let norm = (a * a + b * b).sqrt();
    if norm <= FREE {
        return Turns::Free;
    }
    let (a, b, cos) = (a / norm, b / norm, (height - constant) / norm);
    if cos.abs() > 1.0 + BEYOND {
        return Turns::Some(Few::none());
    }
    let squared = (1.0 - cos) * (1.0 + cos);
    if squared < TOGETHER {
        let cos = 1.0_f64.copysign(cos);
        return Turns::Some(Few::one(Turn { sin: b * cos, cos: a * cos }));
    }
    let sin = squared.sqrt();
    Turns::Some(Few([
        Some(Turn { sin: b * cos + a * sin, cos: a * cos - b * sin }),
        Some(Turn { sin: b * cos - a * sin, cos: a * cos + b * sin }),
    ]))
}

/// The turns of two parallel joints that bring the end of two links to `goal`.
///
/// `first` and `second` are the links, `goal` counts from the first joint; all of them across `axis`.
/// `held` is the first joint's turn where any is as good.
#[inline]
pub(super) fn two_links(
    axis: &Vector3<f64>,
    [first, second, goal]: [&Vector3<f64>; 3],
    held: impl Fn() -> [Turn; 2],
) -> Few<[Turn; 2]> {
    // The elbow follows from the distance alone.
    let height = 0.5 * (goal.norm_squared() - first.norm_squared() - second.norm_squared());
    let elbows = to_height(axis, first, second, height).or(|| held()[1]);
    elbows.map(|elbow| {
        let reach = first + elbow.apply(axis, second);
        [between(axis, &reach, goal).unwrap_or_else(|| held()[0]), elbow]
    })
}

/// The turns about three axes, the first two and the last two not parallel, that together make `rotation`
/// (given by what it does to a vector).
///
/// `across` is a vector across the third axis. `held` is the first turn where only its sum with
/// the third is determined.
#[inline]
pub(super) fn three_turns(
    [first, second, third]: [&Vector3<f64>; 3],
    across: &Vector3<f64>,
    rotation: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    held: impl Fn() -> Turn,
) -> Few<[Turn; 3]> {
    let (pointing, sideways) = (rotation(third), rotation(across));
    let middles = to_height(second, first, third, first.dot(&pointing)).or(&held);
    middles.map(|middle| {
        let reached = middle.apply(second, third);
        let start = between(first, &reached, &pointing).unwrap_or_else(&held);
        let back = middle.back().apply(second, &start.back().apply(first, &sideways));
        // `across` lies across the axis, so there is a turn.
        let end = between(third, across, &back).unwrap_or(Turn { sin: 0.0, cos: 1.0 });
        [start, middle, end]
    })
}
