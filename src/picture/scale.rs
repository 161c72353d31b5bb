//! Axes: ranges, ticks and their labels, for numbers of any size.

/// Beyond this magnitude values are drawn at the axis' end: differences of
/// larger ones could overflow.
const LARGEST: f64 = 1e150;

/// A range of values and the pixels it is drawn to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    min: f64,
    max: f64,
    pixel_min: f64,
    pixel_max: f64,
    /// True if `min` and `max` are powers of ten.
    logarithmic: bool,
    /// What follows every number of the axis.
    unit: &'static str,
}

/// One tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    pub(super) label: String,
}

/// The smallest range that holds a set of values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Range {
    /// A range without any value yet.
    pub(super) const EMPTY: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Widens the range to hold `value`; undefined values are ignored.
    pub(super) fn include(&mut self, value: f64) {
        if !value.is_nan() {
            self.min = self.min.min(value.clamp(-LARGEST, LARGEST));
            self.max = self.max.max(value.clamp(-LARGEST, LARGEST));
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.min > self.max
    }

    pub(super) fn span(&self) -> f64 {
        self.max - self.min
    }

    /// A range that can be divided: not empty, not a single value, and wide
    /// enough for its values to differ in the digits shown.
    fn widened(self) -> Self {
        if self.is_empty() {
            return Self { min: 0.0, max: 1.0 };
        }
        let magnitude = self.min.abs().max(self.max.abs());
        if self.span() > magnitude * 1e-6 {
            return self;
        }
        let half = if magnitude > 1e-150 { magnitude * 0.05 } else { 1.0 };
        let middle = self.min + 0.5 * self.span();
        Self { min: middle - half, max: middle + half }
    }
}

impl Scale {
    /// Draws `range` to the pixels from `pixel_min` to `pixel_max`, leaving
    /// the share `margin` free at both ends.
    pub(super) fn new(range: Range, margin: f64, pixel_min: f64, pixel_max: f64) -> Self {
        let Range { min, max } = range.widened();
        let free = (max - min) * margin;
        Self {
            min: min - free,
            max: max + free,
            pixel_min,
            pixel_max,
            logarithmic: false,
            unit: "",
        }
    }

    /// Like [`new`](Self::new), by orders of magnitude; `range` is of positive
    /// values.
    pub(super) fn logarithmic(range: Range, margin: f64, pixel_min: f64, pixel_max: f64) -> Self {
        let mut powers = Range::EMPTY;
        for end in [range.min, range.max].into_iter().filter(|end| !range.is_empty() && *end > 0.0)
        {
            powers.include(end.log10());
        }
        let scale = Self::new(powers, margin, pixel_min, pixel_max);
        Self { logarithmic: true, ..scale }
    }

    /// The same with `unit` behind every label.
    pub(super) fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Where `value` is drawn; values outside at the nearer end, undefined
    /// ones at the lower.
    pub(super) fn pixel(&self, value: f64) -> f64 {
        let value = if self.logarithmic { value.max(f64::MIN_POSITIVE).log10() } else { value };
        let share = ((value - self.min) / (self.max - self.min)).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.0 } else { share };
        self.pixel_min + share * (self.pixel_max - self.pixel_min)
    }

    /// True if `value` lies on the axis.
    pub(super) fn contains(&self, value: f64) -> bool {
        value >= self.min && value <= self.max
    }

    /// Pixels per unit of value, without sign.
    pub(super) fn resolution(&self) -> f64 {
        (self.pixel_max - self.pixel_min).abs() / (self.max - self.min)
    }

    /// Ticks at multiples of 1, 2 or 5 times a power of ten, about `count`.
    pub(super) fn ticks(&self, count: usize) -> Vec<Tick> {
        let mut step = nice_step((self.max - self.min) / count.max(1) as f64);
        if self.logarithmic {
            step = step.max(1.0);
        }
        let first = (self.min / step).ceil();
        let last = (self.max / step).floor();
        // Less than an order of magnitude may hold no power of ten.
        let number = if last < first { 0 } else { ((last - first) as usize).min(4 * count) + 1 };
        (0..number)
            .map(|index| {
                // Adding 0.0 turns a negative zero into zero.
                let value = (first + index as f64) * step + 0.0;
                let (value, label) = match self.logarithmic {
                    true => (10f64.powf(value), self.power(value)),
                    false => (value, label(value, step)),
                };
                Tick { value, label: label + self.unit }
            })
            .collect()
    }

    /// Ten to the power of `exponent`: in full if the whole axis can be read so.
    fn power(&self, exponent: f64) -> String {
        if exponent != 0.0 && (self.min < -6.5 || self.max > 6.5) {
            return typeset(&format!("1e{exponent}"));
        }
        let decimals = (-exponent).max(0.0) as usize;
        format!("{:.decimals$}", 10f64.powf(exponent))
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = 10f64.powf(raw.log10().floor());
    let nice = [1.0, 2.0, 5.0, 10.0].into_iter().find(|nice| nice * power >= raw * 0.999);
    nice.unwrap_or(10.0) * power
}

/// `value` with as many digits as multiples of `step` need.
fn label(value: f64, step: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if magnitude >= 1e5 || step < 1e-4 {
        let digits = (magnitude.log10().floor() - step.log10().floor()).clamp(0.0, 6.0);
        return typeset(&format!("{value:.*e}", digits as usize));
    }
    let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 6.0);
    typeset(&format!("{value:.*}", decimals as usize))
}

/// A value for a reader: four significant digits, without trailing zeros.
pub(super) fn figure(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || !value.is_finite() {
        return if value.is_finite() { "0".to_owned() } else { "unbounded".to_owned() };
    }
    if !(1e-3..1e5).contains(&magnitude) {
        return typeset(&format!("{value:.2e}"));
    }
    let decimals = (3.0 - magnitude.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    typeset(text)
}

/// A true minus sign is as wide as a digit and does not break lines.
fn typeset(number: &str) -> String {
    number.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(min: f64, max: f64) -> Scale {
        Scale::new(Range { min, max }, 0.0, 0.0, 100.0)
    }

    fn labels(min: f64, max: f64) -> Vec<String> {
        scale(min, max).ticks(5).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(0.0, 5.76), ["0", "2", "4"]);
        assert_eq!(
            labels(-0.35, 0.62),
            ["\u{2212}0.2", "0", "0.2", "0.4", "0.6"].map(String::from)
        );
        assert_eq!(
            labels(0.0, 1e-7),
            ["0", "2e\u{2212}8", "4e\u{2212}8", "6e\u{2212}8", "8e\u{2212}8", "1.0e\u{2212}7"]
        );
        assert_eq!(labels(0.0, 3e6), ["0", "1e6", "2e6", "3e6"]);
    }

    #[test]
    fn powers_of_ten_are_written_out_where_all_can_be_read() {
        let labels = |min, max| -> Vec<String> {
            let scale = Scale::logarithmic(Range { min, max }, 0.0, 0.0, 100.0).in_unit(" %");
            scale.ticks(4).into_iter().map(|tick| tick.label).collect()
        };
        assert_eq!(labels(1e-2, 1e2), ["0.01 %", "0.1 %", "1 %", "10 %", "100 %"]);
        assert_eq!(labels(1e-16, 1.0).first().unwrap(), "1e\u{2212}15 %");
    }

    #[test]
    fn any_range_has_a_few_ticks_inside_it() {
        let values = [0.0, 1e-300, 1e-9, 1.0, 1.0 + 1e-15, 1e9, 1e300, f64::INFINITY];
        for a in values {
            for b in values.into_iter().flat_map(|b| [b, -b]) {
                let mut range = Range::EMPTY;
                range.include(a);
                range.include(b);
                let scale = Scale::new(range, 0.05, 0.0, 100.0);
                let ticks = scale.ticks(5);
                assert!((1..=12).contains(&ticks.len()), "{a} to {b}: {ticks:?}");
                for tick in ticks {
                    assert!(tick.value.is_finite() && tick.label.len() < 16, "{tick:?}");
                    assert!((0.0..=100.0).contains(&scale.pixel(tick.value)));
                }
            }
        }
        assert_eq!(Scale::new(Range::EMPTY, 0.0, 0.0, 1.0).pixel(f64::NAN), 0.0);
    }

    #[test]
    fn figures_keep_four_digits() {
        let expected = [
            (5.756_772, "5.757"),
            (3.0, "3"),
            (-0.25, "\u{2212}0.25"),
            (1234.56, "1235"),
            (1.23e-7, "1.23e\u{2212}7"),
            (0.0, "0"),
            (120.0, "120"),
        ];
        for (value, text) in expected {
            assert_eq!(figure(value), text);
        }
    }
}
