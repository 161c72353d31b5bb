//! Statistics of samples: moments, quantiles, and whether two samples differ.

/// The mean; none of an empty sample.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The sample standard deviation, with `n - 1` in the denominator; none below
/// two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}

/// The quantile at `share` of an ascending sample, linear between neighbours
/// (Hyndman and Fan's type 7); none of an empty sample. Values may be infinite.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = at.floor() as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    let part = at - below as f64;
    // Infinity times zero would be undefined.
    Some(if part == 0.0 || low == high { low } else { low + part * (high - low) })
}

/// Lower quartile, median and upper quartile of an ascending sample.
pub fn quartiles(sorted: &[f64]) -> Option<[f64; 3]> {
    Some([quantile(sorted, 0.25)?, quantile(sorted, 0.5)?, quantile(sorted, 0.75)?])
}

/// Samples up to this size get the exact distribution, if there are no ties.
const EXACT_UP_TO: usize = 8;

/// The p-value of the two-sided Mann-Whitney U test (Mann and Whitney 1947,
/// doi:10.1214/aoms/1177730491) of whether two samples come from one
/// distribution. None if one is empty or holds an undefined value.
///
/// Exact where one sample has at most 8 values and no two values are equal;
/// otherwise the normal approximation, corrected for ties and continuity.
/// Infinite values count as equal to each other.
pub fn mann_whitney(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.is_empty() || b.is_empty() || a.iter().chain(b).any(|value| value.is_nan()) {
        return None;
    }
    let mut all: Vec<(f64, bool)> = a.iter().map(|&value| (value, true)).collect();
    all.extend(b.iter().map(|&value| (value, false)));
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    let (mut rank_sum, mut ties, mut before) = (0.0, 0.0, 0usize);
    for equal in all.chunk_by(|x, y| x.0 == y.0) {
        let count = equal.len() as f64;
        let rank = before as f64 + 0.5 * (count + 1.0);
        rank_sum += rank * equal.iter().filter(|(_, first)| *first).count() as f64;
        ties += count * (count * count - 1.0);
        before += equal.len();
    }
    let (n, m) = (a.len() as f64, b.len() as f64);
    let u = rank_sum - 0.5 * n * (n + 1.0);
    let larger = u.max(n * m - u);
    if ties == 0.0 && a.len().min(b.len()) <= EXACT_UP_TO {
        return Some(exact_tail(a.len(), b.len(), larger as usize));
    }
    let total = n + m;
    let variance = n * m / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)));
    if variance <= 0.0 {
        // All values are equal: nothing tells the samples apart.
        return Some(1.0);
    }
    let z = (larger - 0.5 * n * m - 0.5) / variance.sqrt();
    Some(libm::erfc(z / std::f64::consts::SQRT_2).min(1.0))
}

/// Twice the probability that U of samples of sizes `n` and `m` is at least
/// `u`, at most 1.
///
/// The number of rankings with a given U follows from multiplying out the
/// Gaussian binomial coefficient; counts stay exact or are rounded as floats.
fn exact_tail(n: usize, m: usize, u: usize) -> f64 {
    let (few, many) = (n.min(m), n.max(m));
    let mut counts = vec![0.0f64; few * many + 1];
    counts[0] = 1.0;
    for step in 1..=few {
        // Multiply by 1 - q^(many + step), then divide by 1 - q^step.
        for at in (many + step..counts.len()).rev() {
            counts[at] -= counts[at - many - step];
        }
        for at in step..counts.len() {
            counts[at] += counts[at - step];
        }
    }
    let all: f64 = counts.iter().sum();
    let tail: f64 = counts[u.min(counts.len())..].iter().sum();
    (2.0 * tail / all).min(1.0)
}

/// Corrects p-values for their number after Holm 1979 (Scandinavian Journal of
/// Statistics 6, 65-70): each stays comparable with one level of significance.
pub fn holm(p_values: &mut [f64]) {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut largest = 0.0f64;
    for (rank, &index) in order.iter().enumerate() {
        let corrected = p_values[index] * (order.len() - rank) as f64;
        largest = largest.max(corrected.min(1.0));
        p_values[index] = largest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<f64>, expected: f64) {
        let found = found.unwrap();
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{found} is not {expected}");
    }

    #[test]
    fn moments_and_quantiles_agree_with_numpy() {
        near(mean(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]), 5.0);
        let deviation = standard_deviation(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        near(deviation, 2.138_089_935_299_395);
        let sorted = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        assert_eq!(quartiles(&sorted), Some([2.5, 6.0, 14.0]));
        assert_eq!((quantile(&sorted, 0.0), quantile(&sorted, 1.0)), (Some(1.0), Some(32.0)));
        assert_eq!((mean(&[]), quantile(&[], 0.5), standard_deviation(&[1.0])), (None, None, None));
    }

    #[test]
    fn quantiles_of_infinite_values_are_never_undefined() {
        let sorted = [1.0, 2.0, f64::INFINITY, f64::INFINITY];
        assert_eq!(quartiles(&sorted), Some([1.75, f64::INFINITY, f64::INFINITY]));
    }

    // Expected values of scipy.stats.mannwhitneyu, 1.17.1, two-sided.
    #[test]
    fn the_test_agrees_with_scipy() {
        let (a, b) = ([1.2, 3.4, 2.2, 5.1, 0.3], [2.5, 6.1, 4.4, 3.9, 7.7, 8.2]);
        near(mann_whitney(&a, &b), 0.051_948_051_948_051_95);
        near(mann_whitney(&b, &a), 0.051_948_051_948_051_95);
        let a = [1.0, 2.0, 2.0, 3.0, 5.0, 5.0, 5.0, 8.0, 9.0, 10.0];
        let b = [2.0, 3.0, 5.0, 6.0, 6.0, 7.0, 8.0, 8.0, 11.0, 12.0, 13.0];
        near(mann_whitney(&a, &b), 0.127_530_627_472_658_3);
        let a: Vec<f64> = (0..12).map(|x| 0.37 * x as f64 + 0.5 * (x * 7 % 11) as f64).collect();
        let other = |x| 0.41 * x as f64 + 0.6 * (x * 5 % 13) as f64 + 0.015;
        let b: Vec<f64> = (0..15).map(other).collect();
        near(mann_whitney(&a, &b), 0.074_909_570_158_304_48);
        let b: Vec<f64> = (0..30).map(f64::from).collect();
        near(mann_whitney(&[1.5], &b), 0.193_548_387_096_774_2);
    }

    #[test]
    fn samples_that_say_nothing_differ_in_nothing() {
        assert_eq!(mann_whitney(&[2.0; 9], &[2.0; 12]), Some(1.0));
        assert_eq!(mann_whitney(&[f64::INFINITY; 3], &[f64::INFINITY; 2]), Some(1.0));
        assert_eq!(mann_whitney(&[], &[1.0]), None);
        assert_eq!(mann_whitney(&[f64::NAN], &[1.0]), None);
    }

    // By hand: 0.01 x 4, 0.03 x 3, then 0.04 x 2 is below 0.09, 0.5 x 1.
    #[test]
    fn holm_never_lets_a_larger_p_value_become_the_smaller() {
        let mut p_values = [0.04, 0.01, 0.03, 0.5];
        holm(&mut p_values);
        for (found, expected) in p_values.into_iter().zip([0.09, 0.04, 0.09, 0.5]) {
            near(Some(found), expected);
        }
        let mut large = [0.9, 0.8];
        holm(&mut large);
        assert_eq!(large, [1.0, 1.0]);
    }
}
