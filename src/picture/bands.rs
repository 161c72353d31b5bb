//! Methods compared: how far the median run is from the best known value, with
//! the band between the quartiles.

use crate::plan::{CurvePoint, MethodResult, ProblemResult};

use super::canvas::{Align, TextLook, draw};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 30.0;
const PLOT_HEIGHT: f64 = 340.0;

/// Draws the gap to the best known value over evaluations for all methods on a
/// problem, as SVG; the vertical axis is logarithmic.
pub fn bands(problem: &ProblemResult) -> String {
    let entry = |(index, row): (usize, &MethodResult)| Entry {
        name: row.label.clone(),
        colour: palette::series(index),
        stroke: Stroke::Solid,
    };
    let legend = Legend::new(problem.methods.iter().enumerate().map(entry).collect(), LEFT, RIGHT);
    let top = 56.0 + legend.height();
    let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + PLOT_HEIGHT };
    let (x_range, y_range) = ranges(problem);
    let description = format!("{}: gap to the best known value over evaluations", problem.name);
    draw(WIDTH, frame.bottom + 46.0, &description, |canvas| {
        canvas.text(&problem.name, (LEFT, 20.0), Align::Left, TextLook::TITLE);
        canvas.text(&subtitle(problem), (LEFT, 38.0), Align::Left, TextLook::SMALL);
        legend.draw(canvas, 48.0);
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(x_range, 0.0, frame.left, frame.right),
            y: Scale::logarithmic(y_range, 0.03, frame.bottom, frame.top).in_unit(unit(problem)),
        };
        chart.draw_axes(axis_title(problem));
        chart.label_x("evaluations");
        for (index, row) in problem.methods.iter().enumerate() {
            draw_band(&chart, problem, row, index);
        }
        for (index, row) in problem.methods.iter().enumerate() {
            draw_median(&chart, problem, row, index);
        }
    })
}

fn subtitle(problem: &ProblemResult) -> String {
    let value = |value: f64| format!("{} {}", figure(value), problem.unit);
    match problem.best_known {
        Some(best) => format!(
            "best known {}; lines are medians over the runs, areas reach from quartile to quartile",
            value(best).trim_end()
        ),
        None => "no method found anything within the limits".to_owned(),
    }
}

/// True if gaps are shares, in percent, of the best known value.
fn relative(problem: &ProblemResult) -> bool {
    problem.best_known.is_some_and(|best| best != 0.0)
}

/// What follows a gap as drawn.
pub(super) fn unit(problem: &ProblemResult) -> &'static str {
    if relative(problem) { " %" } else { "" }
}

/// What an axis of gaps shows.
pub(super) fn axis_title(problem: &ProblemResult) -> &'static str {
    if relative(problem) { "gap to the best known" } else { "value above the optimum" }
}

/// How far `value` is from the best known, as drawn: what rounding hides is at
/// the edge.
pub(super) fn gap(problem: &ProblemResult, value: f64) -> f64 {
    let best = problem.best_known.unwrap_or(0.0);
    let gap = if best == 0.0 { value } else { (value - best) / best.abs() };
    gap.max(problem.rounding()) * if relative(problem) { 100.0 } else { 1.0 }
}

/// The spans of evaluations and gaps.
fn ranges(problem: &ProblemResult) -> (Range, Range) {
    let (mut x, mut y) = (Range::EMPTY, Range::EMPTY);
    x.include(0.0);
    for point in problem.methods.iter().flat_map(|row| &row.curve) {
        x.include(point.evaluations as f64);
        for value in [point.lower_quartile, point.median, point.upper_quartile] {
            value.into_iter().for_each(|value| y.include(gap(problem, value)));
        }
    }
    (x, y)
}

/// The points of one of a curve's lines, where it has any.
fn line(
    chart: &Chart<'_, '_>,
    problem: &ProblemResult,
    row: &MethodResult,
    of: fn(&CurvePoint) -> Option<f64>,
) -> Vec<(f64, f64)> {
    let pixel =
        |point: &CurvePoint| Some(chart.pixel(point.evaluations as f64, gap(problem, of(point)?)));
    row.curve.iter().filter_map(pixel).collect()
}

fn draw_band(chart: &Chart<'_, '_>, problem: &ProblemResult, row: &MethodResult, index: usize) {
    let mut outline = line(chart, problem, row, |point| point.upper_quartile);
    // The upper line may begin later: the band is drawn where both are.
    let start = outline.first().map_or(f64::INFINITY, |(x, _)| *x);
    let lower = line(chart, problem, row, |point| point.lower_quartile);
    outline.extend(lower.into_iter().rev().filter(|(x, _)| *x >= start));
    if outline.len() > 2 {
        chart.canvas.area(&outline, palette::series(index));
    }
}

fn draw_median(chart: &Chart<'_, '_>, problem: &ProblemResult, row: &MethodResult, index: usize) {
    let points = line(chart, problem, row, |point| point.median);
    let points = if row.is_deterministic() { stairs(&points) } else { points };
    if !points.is_empty() {
        chart.canvas.polyline(&points, palette::series(index), 1.8);
    }
}

/// The same points joined by level lines: one run's best holds until the next,
/// where a median over runs glides.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let before = points.iter().take(1).chain(points);
    before.zip(points).flat_map(|(before, point)| [(point.0, before.1), *point]).collect()
}
