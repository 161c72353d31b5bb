//! Nearest neighbours: a k-d tree whose leaves are buckets of registers.
//!
//! A bucket stores eight points per group, coordinate by coordinate, and is
//! searched whole. So small trees are searched by brute force, which nothing
//! beats, and large ones in logarithmic time. Cells are halved at the middle of
//! their widest side, so the depth is bounded whatever the order of the points;
//! searches are cut off by the tight boxes of the points in each cell.
//!
//! Memory is allocated when the number of points doubles, never by a search.

use pulp::Arch;

use crate::math::lanes::{Lanes, WIDTH};

/// Points of any dimension that can be added and searched.
pub(super) struct Neighbours {
    dimension: usize,
    /// Groups of eight points per bucket.
    groups: usize,
    /// The box that is halved, lower ends and then upper ones.
    bounds: Vec<f64>,
    cells: Vec<Cell>,
    /// The tight box of each cell's points: lower ends, then upper ones.
    boxes: Vec<f64>,
    /// Coordinates of group `g`: one `Lanes` per coordinate.
    points: Vec<Lanes>,
    /// Names of each group's points.
    names: Vec<[u32; WIDTH]>,
    /// Cells that a search left for later, with the squared distance to their boxes.
    stack: Vec<(u32, f64)>,
    arch: Arch,
}

#[derive(Clone, Copy)]
enum Cell {
    Leaf { bucket: u32, count: u32 },
    Halved { axis: u32, at: f64, children: [u32; 2] },
}

impl Neighbours {
    pub fn new(lower: &[f64], upper: &[f64]) -> Self {
        let dimension = lower.len();
        // Measured: the more coordinates, the less a search in halves saves.
        let groups = match dimension {
            ..=3 => 3,
            4..=6 => 8,
            _ => 32,
        };
        let mut new = Self {
            dimension,
            groups,
            bounds: [lower, upper].concat(),
            cells: vec![Cell::Leaf { bucket: 0, count: 0 }],
            boxes: Vec::new(),
            points: Vec::new(),
            names: Vec::new(),
            stack: Vec::new(),
            arch: Arch::new(),
        };
        new.add_box();
        new
    }

    fn add_box(&mut self) {
        self.boxes.extend(std::iter::repeat_n(f64::INFINITY, self.dimension));
        self.boxes.extend(std::iter::repeat_n(f64::NEG_INFINITY, self.dimension));
    }

    /// Groups of missing points, which are infinitely far away.
    fn add_groups(&mut self, count: usize) {
        let far = Lanes([f64::INFINITY; WIDTH]);
        self.points.extend(std::iter::repeat_n(far, count * self.dimension));
        self.names.extend(std::iter::repeat_n([0; WIDTH], count));
    }

    /// Adds a point under a name.
    pub fn add(&mut self, point: &[f64], name: u32) {
        let mut cell = 0;
        loop {
            self.enlarge(cell, point);
            let found = self.cells[cell];
            match found {
                Cell::Halved { axis, at, children } => {
                    cell = children[usize::from(point[axis as usize] >= at)] as usize;
                }
                Cell::Leaf { bucket, count } if (count as usize) < self.groups * WIDTH => {
                    self.put(bucket, count as usize, point, name);
                    self.cells[cell] = Cell::Leaf { bucket, count: count + 1 };
                    return;
                }
                // Points that no plane can tell apart stand for one another.
                Cell::Leaf { .. } if !self.halve(cell) => return,
                Cell::Leaf { .. } => {}
            }
        }
    }

    fn enlarge(&mut self, cell: usize, point: &[f64]) {
        let start = 2 * self.dimension * cell;
        let (lower, upper) =
            self.boxes[start..start + 2 * self.dimension].split_at_mut(self.dimension);
        for ((lower, upper), &x) in lower.iter_mut().zip(upper).zip(point) {
            *lower = lower.min(x);
            *upper = upper.max(x);
        }
    }

    fn put(&mut self, bucket: u32, slot: usize, point: &[f64], name: u32) {
        let group = bucket as usize * self.groups + slot / WIDTH;
        if group == self.names.len() {
            // The first bucket grows with its points: most trees stay small.
            self.add_groups(1);
        }
        let lanes = &mut self.points[group * self.dimension..][..self.dimension];
        for (lanes, &x) in lanes.iter_mut().zip(point) {
            lanes.0[slot % WIDTH] = x;
        }
        self.names[group][slot % WIDTH] = name;
    }

    /// Divides a full leaf; false if its points cannot be told apart.
    fn halve(&mut self, cell: usize) -> bool {
        let Cell::Leaf { bucket, .. } = self.cells[cell] else { return false };
        let Some((axis, at)) = self.plane(cell) else { return false };
        let first = bucket as usize * self.groups;
        let groups = first..first + self.groups;
        let points = self.points[first * self.dimension..][..self.groups * self.dimension].to_vec();
        let names = self.names[groups].to_vec();
        self.points[first * self.dimension..][..self.groups * self.dimension]
            .fill(Lanes([f64::INFINITY; WIDTH]));
        let buckets = [bucket, (self.names.len() / self.groups) as u32];
        self.add_groups(self.groups);
        let children = [self.cells.len(), self.cells.len() + 1];
        self.cells.extend(buckets.map(|bucket| Cell::Leaf { bucket, count: 0 }));
        self.add_box();
        self.add_box();
        self.cells[cell] =
            Cell::Halved { axis: axis as u32, at, children: children.map(|child| child as u32) };
        let mut counts = [0; 2];
        let mut point = vec![0.0; self.dimension];
        for slot in 0..self.groups * WIDTH {
            for (axis, x) in point.iter_mut().enumerate() {
                *x = points[slot / WIDTH * self.dimension + axis].0[slot % WIDTH];
            }
            let side = usize::from(point[axis] >= at);
            self.enlarge(children[side], &point);
            self.put(buckets[side], counts[side], &point, names[slot / WIDTH][slot % WIDTH]);
            counts[side] += 1;
        }
        for (side, child) in children.into_iter().enumerate() {
            self.cells[child] = Cell::Leaf { bucket: buckets[side], count: counts[side] as u32 };
        }
        true
    }

    /// The plane that halves a leaf's cell, halved again as long as one half is
    /// empty.
    fn plane(&self, cell: usize) -> Option<(usize, f64)> {
        let (mut lower, mut upper) = self.region(cell);
        let start = 2 * self.dimension * cell;
        let (low, high) = self.boxes[start..start + 2 * self.dimension].split_at(self.dimension);
        loop {
            let widths = lower.iter().zip(&upper).map(|(lower, upper)| upper - lower);
            let (axis, _) = widths.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
            let at = 0.5 * (lower[axis] + upper[axis]);
            if at <= lower[axis] || at >= upper[axis] {
                return None;
            }
            if low[axis] >= at {
                lower[axis] = at;
            } else if high[axis] < at {
                upper[axis] = at;
            } else {
                return Some((axis, at));
            }
        }
    }

    /// The part of the box that leads to a cell.
    fn region(&self, cell: usize) -> (Vec<f64>, Vec<f64>) {
        let (lower, upper) = self.bounds.split_at(self.dimension);
        let (mut lower, mut upper) = (lower.to_vec(), upper.to_vec());
        // Any point of the cell leads there.
        let inside = &self.boxes[2 * self.dimension * cell..][..self.dimension];
        let mut at_cell = 0;
        while let (true, Cell::Halved { axis, at, children }) =
            (at_cell != cell, self.cells[at_cell])
        {
            let side = usize::from(inside[axis as usize] >= at);
            let end = if side == 0 { &mut upper } else { &mut lower };
            end[axis as usize] = at;
            at_cell = children[side] as usize;
        }
        (lower, upper)
    }

    /// The nearest point's name and squared distance; infinitely far if there is none.
    pub fn nearest(&mut self, point: &[f64]) -> (u32, f64) {
        let arch = self.arch;
        arch.dispatch(
            #[inline(always)]
            || match self.dimension {
                // The compiler unrolls what it knows.
                2 => self.search_nearest(2, point),
                3 => self.search_nearest(3, point),
                6 => self.search_nearest(6, point),
                7 => self.search_nearest(7, point),
                dimension => self.search_nearest(dimension, point),
            },
        )
    }

    #[inline(always)]
    fn search_nearest(&mut self, dimension: usize, point: &[f64]) -> (u32, f64) {
        let point = &point[..dimension];
        let mut best = (0, f64::INFINITY);
        self.stack.clear();
        let (mut cell, mut bound) = (0, 0.0);
        loop {
            if bound < best.1 {
                match self.cells[cell as usize] {
                    Cell::Leaf { bucket, count } => {
                        self.search_bucket(dimension, bucket, count, point, &mut best);
                    }
                    Cell::Halved { children, .. } => {
                        let bounds =
                            children.map(|child| self.box_distance(dimension, child, point));
                        let near = usize::from(bounds[1] < bounds[0]);
                        self.stack.push((children[1 - near], bounds[1 - near]));
                        (cell, bound) = (children[near], bounds[near]);
                        continue;
                    }
                }
            }
            let Some(next) = self.stack.pop() else { return best };
            (cell, bound) = next;
        }
    }

    /// Squared distance to the box of a cell's points.
    #[inline(always)]
    fn box_distance(&self, dimension: usize, cell: u32, point: &[f64]) -> f64 {
        let ends = &self.boxes[2 * dimension * cell as usize..][..2 * dimension];
        let mut squared = 0.0;
        for (axis, &x) in point.iter().enumerate() {
            let off = (ends[axis] - x).max(x - ends[dimension + axis]).max(0.0);
            squared += off * off;
        }
        squared
    }

    #[inline(always)]
    fn search_bucket(
        &self,
        dimension: usize,
        bucket: u32,
        count: u32,
        point: &[f64],
        best: &mut (u32, f64),
    ) {
        let first = bucket as usize * self.groups;
        let mut least = [f64::INFINITY; WIDTH];
        let mut groups = [0u64; WIDTH];
        for group in 0..(count as usize).div_ceil(WIDTH) {
            let squared = self.squared_distances(dimension, first + group, point);
            for lane in 0..WIDTH {
                let nearer = squared.0[lane] < least[lane];
                least[lane] = if nearer { squared.0[lane] } else { least[lane] };
                groups[lane] = if nearer { group as u64 } else { groups[lane] };
            }
        }
        for lane in 0..WIDTH {
            if least[lane] < best.1 {
                *best = (self.names[first + groups[lane] as usize][lane], least[lane]);
            }
        }
    }

    #[inline(always)]
    fn squared_distances(&self, dimension: usize, group: usize, point: &[f64]) -> Lanes {
        let coordinates = &self.points[group * dimension..][..dimension];
        let mut squared = Lanes::ZERO;
        for (lanes, &x) in coordinates.iter().zip(point) {
            for lane in 0..WIDTH {
                let off = lanes.0[lane] - x;
                squared.0[lane] += off * off;
            }
        }
        squared
    }

    /// Writes name and squared distance of all points at most `radius` away.
    pub fn within(&mut self, point: &[f64], radius: f64, found: &mut Vec<(u32, f64)>) {
        found.clear();
        let arch = self.arch;
        arch.dispatch(
            #[inline(always)]
            || match self.dimension {
                2 => self.search_within(2, point, radius, found),
                3 => self.search_within(3, point, radius, found),
                6 => self.search_within(6, point, radius, found),
                7 => self.search_within(7, point, radius, found),
                dimension => self.search_within(dimension, point, radius, found),
            },
        );
    }

    #[inline(always)]
    fn search_within(
        &mut self,
        dimension: usize,
        point: &[f64],
        radius: f64,
        found: &mut Vec<(u32, f64)>,
    ) {
        let (point, limit) = (&point[..dimension], radius * radius);
        self.stack.clear();
        self.stack.push((0, 0.0));
        while let Some((cell, _)) = self.stack.pop() {
            match self.cells[cell as usize] {
                Cell::Leaf { bucket, count } => {
                    let first = bucket as usize * self.groups;
                    for group in first..first + (count as usize).div_ceil(WIDTH) {
                        let squared = self.squared_distances(dimension, group, point);
                        for lane in 0..WIDTH {
                            if squared.0[lane] <= limit {
                                found.push((self.names[group][lane], squared.0[lane]));
                            }
                        }
                    }
                }
                Cell::Halved { children, .. } => {
                    for child in children {
                        if self.box_distance(dimension, child, point) <= limit {
                            self.stack.push((child, 0.0));
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::RandomStream;
    use crate::planner::squared_distance;

    /// Clouds, rows, grids with equal coordinates, and many equal points.
    fn points(dimension: usize, kind: usize) -> Vec<Vec<f64>> {
        let mut random = RandomStream::new(kind as u64, dimension as u64);
        let mut one = |index: usize| -> Vec<f64> {
            let index = index as f64;
            let mut coordinate = |axis: usize| match kind {
                0 => random.unit(),
                1 => index / 2000.0,
                2 => ((index as usize >> axis) % 4) as f64 * 0.25,
                _ => (random.unit() * 3.0).floor() * 1e-300,
            };
            (0..dimension).map(&mut coordinate).collect()
        };
        (0..1500).map(&mut one).collect()
    }

    #[test]
    fn searches_find_what_looking_at_all_points_finds() {
        for dimension in [1, 2, 3, 5, 6, 7, 12] {
            for kind in 0..4 {
                let points = points(dimension, kind);
                let mut found = Neighbours::new(&vec![0.0; dimension], &vec![1.0; dimension]);
                let mut random = RandomStream::new(9, 1);
                let mut near = Vec::new();
                for (name, point) in points.iter().enumerate() {
                    found.add(point, name as u32);
                    let query: Vec<f64> = (0..dimension).map(|_| random.unit()).collect();
                    let known = &points[..=name];
                    let distances = || known.iter().map(|point| squared_distance(point, &query));
                    let least = distances().fold(f64::INFINITY, f64::min);
                    let (nearest, squared) = found.nearest(&query);
                    let case = format!("{dimension}, {kind}, {name}");
                    assert_eq!(squared, least, "{case}");
                    assert_eq!(
                        squared_distance(&points[nearest as usize], &query),
                        least,
                        "{case}"
                    );
                    if kind < 2 {
                        found.within(&query, 0.3, &mut near);
                        near.sort_by_key(|(name, _)| *name);
                        let all = distances().enumerate().filter(|(_, squared)| *squared <= 0.09);
                        let all: Vec<(u32, f64)> = all.map(|(name, d)| (name as u32, d)).collect();
                        assert_eq!(near, all, "{case}");
                    }
                }
            }
        }
    }
}
