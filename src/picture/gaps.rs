//! How far every method ended from the best known value, problem by problem.

use plotters::style::RGBColor;

use crate::plan::{ComparisonResult, MethodResult, ProblemResult, Standing};

use super::bands::{axis_title, gap, unit};
use super::canvas::{Align, Canvas, TextLook, draw, text_width};
use super::chart::{Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale};

const WIDTH: f64 = 900.0;
/// Panels stand side by side up to this number.
const ACROSS: usize = 3;
/// Height of a method's line.
const LINE: f64 = 17.0;
/// Between panels; above and below them stand the problem's name and the ticks.
const BETWEEN: f64 = 26.0;
const ABOVE: f64 = 24.0;
const BELOW: f64 = 40.0;

/// Draws the gap of each method on each problem, as SVG: a dot for the median,
/// a bar from quartile to quartile, methods in the order of `ranking`, gaps on
/// one logarithmic axis for all problems.
pub fn gaps(result: &ComparisonResult, ranking: &[Standing]) -> String {
    let columns = result.problems.len().clamp(1, ACROSS);
    let rows = result.problems.len().div_ceil(columns);
    let legend = Legend::new(entries(ranking), 0.0, WIDTH);
    let top = legend.height();
    let panel = ABOVE + LINE * ranking.len() as f64 + BELOW;
    let range = range(result);
    let names = ranking.iter().map(|it| text_width(&it.label, TextLook::NORMAL.size));
    let left = names.fold(0.0, f64::max).min(0.5 * WIDTH) + 12.0;
    let width = (WIDTH - left) / columns as f64;
    let description = "gap of every method to the best known value on every problem";
    draw(WIDTH, top + panel * rows as f64, description, |canvas| {
        legend.draw(canvas, 0.0);
        for (at, problem) in result.problems.iter().enumerate() {
            let (row, column) = (at / columns, at % columns);
            let left = left + width * column as f64;
            let top = top + panel * row as f64 + ABOVE;
            let bottom = top + LINE * ranking.len() as f64;
            let frame = Frame { left, right: left + width - BETWEEN, top, bottom };
            let x = Scale::logarithmic(range, 0.04, frame.left, frame.right).in_unit(unit(problem));
            let panel = Panel { canvas, frame, x };
            panel.axes(problem);
            panel.methods(problem, ranking, column == 0);
        }
    })
}

fn entries(ranking: &[Standing]) -> Vec<Entry> {
    let entry = |name: &str, deterministic| Entry {
        name: name.to_owned(),
        colour: colour(deterministic),
        stroke: Stroke::Dot,
    };
    let mut entries = vec![entry("median of the runs, bar from quartile to quartile", false)];
    if ranking.iter().any(|standing| standing.deterministic) {
        entries.push(entry("deterministic, one run", true));
    }
    entries
}

fn colour(deterministic: bool) -> RGBColor {
    palette::series(usize::from(deterministic))
}

/// The span of all gaps.
fn range(result: &ComparisonResult) -> Range {
    let mut range = Range::EMPTY;
    for problem in &result.problems {
        for row in &problem.methods {
            quartiles(row).into_iter().flatten().for_each(|it| range.include(gap(problem, it)));
        }
    }
    range
}

fn quartiles(row: &MethodResult) -> [Option<f64>; 3] {
    [row.lower_quartile, row.median, row.upper_quartile]
}

/// One problem.
struct Panel<'a, 'b> {
    canvas: &'a Canvas<'b>,
    frame: Frame,
    x: Scale,
}

impl Panel<'_, '_> {
    fn axes(&self, problem: &ProblemResult) {
        let Frame { left, right, top, bottom } = self.frame;
        let look = TextLook { bold: true, ..TextLook::NORMAL };
        self.canvas.text(&problem.name, (left, top - 10.0), Align::Left, look);
        // Percentages are written out and need more room.
        let ticks = if unit(problem).is_empty() { 5 } else { 3 };
        for tick in self.x.ticks(ticks) {
            let x = self.x.pixel(tick.value);
            self.canvas.polyline(&[(x, top), (x, bottom)], palette::GRID, 1.0);
            self.canvas.text(&tick.label, (x, bottom + 11.0), Align::Centre, TextLook::SMALL);
        }
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        self.canvas.polyline(&corners, palette::LINE, 1.0);
        let middle = (0.5 * (left + right), bottom + 25.0);
        self.canvas.text(axis_title(problem), middle, Align::Centre, TextLook::SMALL);
    }

    fn methods(&self, problem: &ProblemResult, ranking: &[Standing], named: bool) {
        for (at, standing) in ranking.iter().enumerate() {
            let y = self.frame.top + LINE * (at as f64 + 0.5);
            if named {
                let at = (self.frame.left - 8.0, y);
                self.canvas.text(&standing.label, at, Align::Right, TextLook::NORMAL);
            }
            if let Some(row) = problem.methods.get(standing.index) {
                self.method(problem, row, y);
            }
        }
    }

    fn method(&self, problem: &ProblemResult, row: &MethodResult, y: f64) {
        let colour = colour(row.is_deterministic());
        let pixel = |value: Option<f64>| value.map(|value| self.x.pixel(gap(problem, value)));
        let [Some(lower), Some(median), Some(upper)] = quartiles(row).map(pixel) else {
            let at = (self.frame.right - 6.0, y);
            return self.canvas.text("none found", at, Align::Right, TextLook::SMALL);
        };
        self.canvas.polyline(&[(lower, y), (upper, y)], palette::lighter(colour), 5.0);
        self.canvas.dot((median, y), 3.5, colour);
    }
}
