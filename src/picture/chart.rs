//! What every chart has: a frame with grid and ticks, titles and a legend.

use plotters::style::RGBColor;

use super::canvas::{Align, Canvas, TextLook, text_width};
use super::palette;
use super::scale::Scale;

/// Where a chart stands, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// Axes in a frame on a canvas.
pub(super) struct Chart<'a, 'b> {
    pub(super) canvas: &'a Canvas<'b>,
    pub(super) frame: Frame,
    pub(super) x: Scale,
    pub(super) y: Scale,
}

impl Chart<'_, '_> {
    /// Where a pair of values is drawn.
    pub(super) fn pixel(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.pixel(x), self.y.pixel(y))
    }

    /// Grid, axes, ticks and the vertical axis' title.
    pub(super) fn draw_axes(&self, y_title: &str) {
        let Frame { left, right, top, bottom } = self.frame;
        for tick in self.x.ticks(10) {
            let x = self.x.pixel(tick.value);
            self.canvas.polyline(&[(x, top), (x, bottom)], palette::GRID, 1.0);
        }
        for tick in self.y.ticks(5) {
            let y = self.y.pixel(tick.value);
            let colour = if tick.value == 0.0 { palette::LINE } else { palette::GRID };
            self.canvas.polyline(&[(left, y), (right, y)], colour, 1.0);
            self.canvas.text(&tick.label, (left - 6.0, y), Align::Right, TextLook::NORMAL);
        }
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        self.canvas.polyline(&corners, palette::LINE, 1.0);
        let middle = 0.5 * (top + bottom);
        self.canvas.upward_text(y_title, (18.0, middle), TextLook::NORMAL);
    }

    /// Labels of the horizontal axis and its title.
    pub(super) fn label_x(&self, title: &str) {
        let Frame { left, right, bottom, .. } = self.frame;
        for tick in self.x.ticks(10) {
            let at = (self.x.pixel(tick.value), bottom + 12.0);
            self.canvas.text(&tick.label, at, Align::Centre, TextLook::NORMAL);
        }
        let middle = 0.5 * (left + right);
        self.canvas.text(title, (middle, bottom + 31.0), Align::Centre, TextLook::NORMAL);
    }

    /// Writes values beside the right axis at their heights. Labels that would
    /// cover an earlier one are left out.
    pub(super) fn label_right(&self, labels: &[(f64, String, RGBColor)]) {
        let mut taken: Vec<f64> = Vec::new();
        for (value, text, colour) in labels {
            let y = self.y.pixel(*value);
            if taken.iter().all(|other| (other - y).abs() >= 11.0) {
                let look = TextLook { colour: *colour, ..TextLook::SMALL };
                self.canvas.text(text, (self.frame.right + 5.0, y), Align::Left, look);
                taken.push(y);
            }
        }
    }
}

/// How a legend shows a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    Solid,
    Thin,
    Dashed,
    Dot,
}

/// One entry of a legend.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) colour: RGBColor,
    pub(super) stroke: Stroke,
}

/// A legend in as many rows as it needs.
pub(super) struct Legend {
    entries: Vec<(f64, f64, Entry)>,
    rows: usize,
}

impl Legend {
    const ROW: f64 = 18.0;
    const SWATCH: f64 = 24.0;

    /// Sets `entries` between `left` and `right`.
    pub(super) fn new(entries: Vec<Entry>, left: f64, right: f64) -> Self {
        let (mut x, mut rows) = (left, 1);
        let mut placed = Vec::with_capacity(entries.len());
        for entry in entries {
            let width = Self::SWATCH + 6.0 + text_width(&entry.name, TextLook::NORMAL.size) + 16.0;
            if x > left && x + width > right {
                (x, rows) = (left, rows + 1);
            }
            placed.push((x, Self::ROW * (rows as f64 - 0.5), entry));
            x += width;
        }
        Self { entries: placed, rows }
    }

    /// Height of all rows.
    pub(super) fn height(&self) -> f64 {
        Self::ROW * self.rows as f64
    }

    /// Draws the legend below `top`.
    pub(super) fn draw(&self, canvas: &Canvas<'_>, top: f64) {
        for (x, y, entry) in &self.entries {
            let (start, end, y) = (*x, x + Self::SWATCH, top + y);
            match entry.stroke {
                Stroke::Solid => canvas.polyline(&[(start, y), (end, y)], entry.colour, 2.5),
                Stroke::Thin => canvas.polyline(&[(start, y), (end, y)], entry.colour, 1.2),
                Stroke::Dashed => canvas.dashed(start, end, y, entry.colour),
                Stroke::Dot => canvas.dot((0.5 * (start + end), y), 3.5, entry.colour),
            }
            canvas.text(&entry.name, (end + 6.0, y), Align::Left, TextLook::NORMAL);
        }
    }
}
