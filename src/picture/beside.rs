//! Published figures beside ours: a row per figure.

use super::canvas::{Align, Canvas, TextLook, draw, text_width};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale};

const WIDTH: f64 = 900.0;
const RIGHT: f64 = WIDTH - 30.0;
const ROW: f64 = 22.0;

/// One figure as a paper prints it, as it came out here, and what is possible.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beside {
    /// What the figure is.
    pub name: String,
    /// As printed.
    pub published: Option<f64>,
    /// Lower quartile, median and upper quartile over our runs.
    pub ours: Option<[f64; 3]>,
    /// The true optimum.
    pub optimum: Option<f64>,
}

/// What a legend calls published figures, ours and optima.
pub const NAMES: [&str; 3] =
    ["published", "ours, median and quartiles", "true optimum (upright line)"];

/// Draws the rows under a title; `axis` names the values with their unit, `names` is as [`NAMES`].
pub fn beside(title: &str, axis: &str, names: [&str; 3], rows: &[Beside]) -> String {
    let widths = rows.iter().map(|row| text_width(&row.name, TextLook::NORMAL.size));
    let left = widths.fold(60.0, f64::max).min(0.4 * WIDTH) + 24.0;
    let legend = Legend::new(entries(names, rows), left, RIGHT);
    let top = 34.0 + legend.height() + 8.0;
    let frame = Frame { left, right: RIGHT, top, bottom: top + ROW * rows.len() as f64 };
    draw(WIDTH, frame.bottom + 46.0, title, |canvas| {
        canvas.text(title, (left, 18.0), Align::Left, TextLook::TITLE);
        legend.draw(canvas, 32.0);
        let x = Scale::new(range(rows), 0.05, frame.left, frame.right);
        // Rows are set by hand: the vertical scale has no values.
        let y = Scale::new(Range::EMPTY, 0.0, frame.bottom, frame.top);
        let chart = Chart { canvas, frame, x, y };
        for tick in chart.x.ticks(10) {
            let at = chart.x.pixel(tick.value);
            canvas.polyline(&[(at, frame.top), (at, frame.bottom)], palette::GRID, 1.0);
        }
        chart.label_x(axis);
        for (index, row) in rows.iter().enumerate() {
            draw_row(canvas, &chart, row, top + ROW * (index as f64 + 0.5));
        }
    })
}

fn entries([published, ours, optimum]: [&str; 3], rows: &[Beside]) -> Vec<Entry> {
    let entry = |name: &str, colour, stroke| Entry { name: name.to_owned(), colour, stroke };
    let mut entries = Vec::new();
    if rows.iter().any(|row| row.published.is_some()) {
        entries.push(entry(published, palette::series(1), Stroke::Dot));
    }
    if rows.iter().any(|row| row.ours.is_some()) {
        entries.push(entry(ours, palette::series(0), Stroke::Solid));
    }
    if rows.iter().any(|row| row.optimum.is_some()) {
        entries.push(entry(optimum, palette::INK, Stroke::Thin));
    }
    entries
}

fn range(rows: &[Beside]) -> Range {
    let mut range = Range::EMPTY;
    for row in rows {
        let values = row.published.into_iter().chain(row.ours.into_iter().flatten());
        values.chain(row.optimum).for_each(|value| range.include(value));
    }
    range
}

fn draw_row(canvas: &Canvas<'_>, chart: &Chart<'_, '_>, row: &Beside, y: f64) {
    canvas.text(&row.name, (chart.frame.left - 10.0, y), Align::Right, TextLook::NORMAL);
    let at = |value: f64| chart.x.pixel(value);
    canvas.polyline(&[(chart.frame.left, y), (chart.frame.right, y)], palette::GRID, 1.0);
    if let Some(optimum) = row.optimum {
        canvas.polyline(&[(at(optimum), y - 9.0), (at(optimum), y + 9.0)], palette::INK, 1.6);
    }
    if let Some([lower, median, upper]) = row.ours {
        canvas.polyline(&[(at(lower), y), (at(upper), y)], palette::series(0), 5.0);
        canvas.dot((at(median), y), 5.0, palette::series(0));
    }
    if let Some(published) = row.published {
        canvas.dot((at(published), y), 3.5, palette::series(1));
    }
}
