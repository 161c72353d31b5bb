//! What the genetic algorithms `ga` and `aga` share.

use super::Bounds;
use crate::math::random::RandomStream;

/// A random whole number below `count`; 0 if that is 0.
///
/// A number below 1 times a whole one never rounds up to it.
pub fn index(count: usize, random: &mut RandomStream) -> usize {
    (random.unit() * count as f64) as usize
}

/// Single-point crossover: exchanges all genes behind a random one.
pub fn cross(first: &mut [f64], second: &mut [f64], random: &mut RandomStream) {
    let cut = 1 + index(first.len().saturating_sub(1), random);
    first[cut..].swap_with_slice(&mut second[cut..]);
}

/// Arithmetic crossover: both move towards each other's place by one random share.
pub fn blend(first: &mut [f64], second: &mut [f64], random: &mut RandomStream) {
    let share = random.unit();
    for (a, b) in first.iter_mut().zip(second) {
        let way = share * (*b - *a);
        let (low, high) = (a.min(*b), a.max(*b));
        // Rounding must not carry a gene out of the box.
        (*a, *b) = ((*a + way).clamp(low, high), (*b - way).clamp(low, high));
    }
}

/// Single-point mutation: draws one random gene anew.
pub fn mutate(individual: &mut [f64], bounds: &Bounds, random: &mut RandomStream) {
    let gene = index(individual.len(), random);
    individual[gene] = random.uniform(bounds.lower[gene], bounds.upper[gene]);
}

/// A wheel with one field per individual, as wide as the individual's weight.
#[derive(Default)]
pub struct Roulette {
    /// Where each field ends.
    ends: Vec<f64>,
}

impl Roulette {
    /// A wheel for that many individuals.
    pub fn with_capacity(population: usize) -> Self {
        Self { ends: Vec::with_capacity(population) }
    }

    /// Lays out the fields.
    pub fn set(&mut self, weights: impl Iterator<Item = f64>) {
        self.ends.clear();
        let mut end = 0.0;
        self.ends.extend(weights.map(|weight| {
            end += weight;
            end
        }));
    }

    /// The individual on whose field the wheel stops; any one if none has weight.
    pub fn spin(&self, random: &mut RandomStream) -> usize {
        match self.ends.last() {
            Some(&end) if end > 0.0 => {
                let stop = random.unit() * end;
                // The product of the tiniest numbers may round up to the end.
                self.ends.partition_point(|&end| end <= stop).min(self.ends.len() - 1)
            }
            _ => index(self.ends.len(), random),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wheel_stops_as_often_as_a_field_is_wide() {
        let mut wheel = Roulette::default();
        let mut random = RandomStream::new(3, 0);
        wheel.set([0.0, 1.0, 0.0, 3.0, 0.0].into_iter());
        let mut counts = [0u32; 5];
        for _ in 0..40_000 {
            counts[wheel.spin(&mut random)] += 1;
        }
        assert_eq!((counts[0], counts[2], counts[4]), (0, 0, 0));
        // Four standard deviations of a share of 1/4 among 40 000.
        assert!((9_653..10_347).contains(&counts[1]), "{counts:?}");
    }

    #[test]
    fn without_weights_every_individual_has_its_turn() {
        let mut wheel = Roulette::default();
        let mut random = RandomStream::new(3, 0);
        wheel.set([0.0; 3].into_iter());
        let mut seen = [false; 3];
        (0..100).for_each(|_| seen[wheel.spin(&mut random)] = true);
        assert_eq!(seen, [true; 3]);
    }

    #[test]
    fn crossover_exchanges_genes_behind_a_cut() {
        let mut random = RandomStream::new(1, 0);
        let mut cuts = [false; 4];
        for _ in 0..100 {
            let (mut a, mut b) = ([1.0; 4], [2.0; 4]);
            cross(&mut a, &mut b, &mut random);
            let cut = a.iter().filter(|&&gene| gene == 1.0).count();
            assert!(a[..cut].iter().all(|&gene| gene == 1.0), "{a:?}");
            assert!(a.iter().zip(&b).all(|(x, y)| x + y == 3.0), "{a:?} {b:?}");
            cuts[cut] = true;
        }
        // At least the first gene stays and at least the last one goes.
        assert_eq!(cuts, [false, true, true, true]);
    }

    #[test]
    fn blending_keeps_the_middle_and_the_box() {
        let mut random = RandomStream::new(2, 0);
        let (mut a, mut b) = ([1.0, -3.0], [2.0, 5.0]);
        blend(&mut a, &mut b, &mut random);
        assert!((a[0] + b[0] - 3.0).abs() < 1e-15 && (a[1] + b[1] - 2.0).abs() < 1e-15);
        let share = a[0] - 1.0;
        assert!(share > 0.0 && share < 1.0);
        assert!((a[1] - (-3.0 + 8.0 * share)).abs() < 1e-15);
    }

    #[test]
    fn mutation_draws_one_gene_anew() {
        let bounds = Bounds { lower: vec![0.0; 3], upper: vec![1.0; 3] };
        let mut random = RandomStream::new(2, 0);
        for _ in 0..50 {
            let mut x = [7.0; 3];
            mutate(&mut x, &bounds, &mut random);
            let drawn: Vec<f64> = x.into_iter().filter(|&gene| gene != 7.0).collect();
            assert!(drawn.len() == 1 && (0.0..1.0).contains(&drawn[0]), "{x:?}");
        }
    }
}
