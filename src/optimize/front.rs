//! Fronts: which points none other dominates, and how evenly they lie.
//!
//! Deb et al. 2002, doi:10.1109/4235.996017, sections III-A and III-B.

/// True if `a` is nowhere larger than `b` and somewhere smaller.
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    let mut smaller = false;
    for (a, b) in a.iter().zip(b) {
        if a > b {
            return false;
        }
        smaller |= a < b;
    }
    smaller
}

/// Groups `0..count` into fronts: of each group, none is beaten by one of the
/// same or a later group.
pub fn non_dominated_sort(count: usize, beats: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut beaten_by = vec![0usize; count];
    let mut beaten: Vec<Vec<usize>> = vec![Vec::new(); count];
    for a in 0..count {
        for b in a + 1..count {
            if beats(a, b) {
                beaten[a].push(b);
                beaten_by[b] += 1;
            } else if beats(b, a) {
                beaten[b].push(a);
                beaten_by[a] += 1;
            }
        }
    }
    let mut fronts = Vec::new();
    let mut front: Vec<usize> = (0..count).filter(|index| beaten_by[*index] == 0).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for index in &front {
            for other in &beaten[*index] {
                beaten_by[*other] -= 1;
                if beaten_by[*other] == 0 {
                    next.push(*other);
                }
            }
        }
        next.sort_unstable();
        fronts.push(std::mem::replace(&mut front, next));
    }
    fronts
}

/// Crowding distances: the sides of the box between a point's neighbours,
/// relative to the front's extent; infinite for the extremes.
pub fn crowding(values: &[&[f64]]) -> Vec<f64> {
    let mut distances = vec![0.0; values.len()];
    let objectives = values.first().map_or(0, |first| first.len());
    for objective in 0..objectives {
        let value = |index: usize| values[index][objective];
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|a, b| value(*a).total_cmp(&value(*b)));
        let [first, last] = [order[0], order[order.len() - 1]];
        let extent = value(last) - value(first);
        distances[first] = f64::INFINITY;
        distances[last] = f64::INFINITY;
        if extent > 0.0 {
            for near in order.windows(3) {
                distances[near[1]] += (value(near[2]) - value(near[0])) / extent;
            }
        }
    }
    distances
}

/// Takes out the most crowded point until at most `count` are left.
pub fn thin<T>(points: &mut Vec<T>, count: usize, values: impl Fn(&T) -> &Vec<f64>) {
    while points.len() > count.max(1) {
        let all: Vec<&[f64]> = points.iter().map(|point| values(point).as_slice()).collect();
        let distances = crowding(&all).into_iter().enumerate();
        let Some((crowded, _)) = distances.min_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        points.remove(crowded);
    }
}

/// Takes out every point that another one dominates or equals.
pub fn keep_non_dominated<T>(points: &mut Vec<T>, values: impl Fn(&T) -> &Vec<f64>) {
    let kept: Vec<bool> = (0..points.len())
        .map(|a| {
            let mine = values(&points[a]);
            (0..points.len()).all(|b| {
                let theirs = values(&points[b]);
                !dominates(theirs, mine) && (a <= b || theirs != mine)
            })
        })
        .collect();
    let mut kept = kept.into_iter();
    points.retain(|_| kept.next().unwrap_or(false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorts_into_fronts() {
        let points = [[1.0, 4.0], [2.0, 2.0], [4.0, 1.0], [2.0, 5.0], [3.0, 3.0], [5.0, 5.0]];
        let fronts = non_dominated_sort(6, |a, b| dominates(&points[a], &points[b]));
        assert_eq!(fronts, [vec![0, 1, 2], vec![3, 4], vec![5]]);
        assert!(!dominates(&points[0], &points[0]));
    }

    #[test]
    fn crowding_is_the_box_between_neighbours() {
        let points = [[0.0, 10.0], [1.0, 6.0], [2.0, 5.0], [4.0, 0.0]];
        let values: Vec<&[f64]> = points.iter().map(<[f64; 2]>::as_slice).collect();
        let inf = f64::INFINITY;
        assert_eq!(crowding(&values), [inf, 2.0 / 4.0 + 5.0 / 10.0, 3.0 / 4.0 + 6.0 / 10.0, inf]);
        let mut thinned: Vec<Vec<f64>> = points.iter().map(|p| p.to_vec()).collect();
        thin(&mut thinned, 3, |point| point);
        assert_eq!(thinned, [vec![0.0, 10.0], vec![2.0, 5.0], vec![4.0, 0.0]]);
    }

    #[test]
    fn dominated_and_repeated_points_go() {
        let mut points = vec![vec![1.0, 2.0], vec![2.0, 1.0], vec![1.0, 2.0], vec![2.0, 2.0]];
        keep_non_dominated(&mut points, |point| point);
        assert_eq!(points, [vec![1.0, 2.0], vec![2.0, 1.0]]);
    }
}
