//! The path of a point among obstacles: what the planner grew, the path as
//! planned and as smoothed.

use crate::plan::{Obstacle, PathResult};

use super::canvas::{Align, Canvas, TextLook, draw};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 720.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = WIDTH - 30.0;

/// Highest and lowest frame; between, both axes have the same scale.
const HEIGHTS: [f64; 2] = [160.0, 1240.0];

/// Corners of a drawn circle.
const CORNERS: usize = 64;

/// Draws a path as SVG: its first two coordinates, seen along all others.
pub fn path(result: &PathResult) -> String {
    let legend = Legend::new(legend_entries(result), LEFT, RIGHT);
    let top = 56.0 + legend.height();
    let [x, y] = [0, 1].map(|axis| range(result, axis));
    let height = (RIGHT - LEFT) * y.span() / x.span();
    let height = if height.is_finite() { height } else { RIGHT - LEFT };
    let bottom = top + height.clamp(HEIGHTS[0], HEIGHTS[1]);
    let frame = Frame { left: LEFT, right: RIGHT, top, bottom };
    draw(WIDTH, bottom + 46.0, "path among obstacles", |canvas| {
        canvas.text("Path", (LEFT, 20.0), Align::Left, TextLook::TITLE);
        canvas.text(&subtitle(result), (LEFT, 38.0), Align::Left, TextLook::SMALL);
        legend.draw(canvas, 46.0);
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(x, 0.0, frame.left, frame.right),
            y: Scale::new(y, 0.0, frame.bottom, frame.top),
        };
        chart.draw_axes("coordinate 1");
        chart.label_x("coordinate 0");
        for obstacle in &result.space.obstacles {
            draw_obstacle(&chart, obstacle);
        }
        for edge in &result.tree_edges {
            line(&chart, [&edge.from, &edge.to], palette::LINE, 0.7);
        }
        draw_paths(&chart, canvas, result);
    })
}

fn range(result: &PathResult, axis: usize) -> Range {
    let mut range = Range::EMPTY;
    for end in [&result.space.lower, &result.space.upper] {
        range.include(end.get(axis).copied().unwrap_or(0.0));
    }
    range
}

fn legend_entries(result: &PathResult) -> Vec<Entry> {
    let entry = |name: &str, colour, stroke| Entry { name: name.to_owned(), colour, stroke };
    let mut entries = Vec::new();
    if !result.tree_edges.is_empty() {
        entries.push(entry("trees", palette::LINE, Stroke::Thin));
    }
    entries.push(entry("path as planned", palette::series(1), Stroke::Thin));
    if result.smoothed_path.is_some() {
        entries.push(entry("smoothed", palette::series(0), Stroke::Solid));
    }
    entries.push(entry("start", palette::series(2), Stroke::Dot));
    entries.push(entry("goal", palette::INK, Stroke::Dot));
    entries
}

fn subtitle(result: &PathResult) -> String {
    let dimension = result.space.lower.len();
    let seen =
        if dimension > 2 { format!(", 2 of {dimension} coordinates") } else { String::new() };
    let smoothed = result
        .smoothed_length
        .map(|length| format!(", {} after {}", figure(length), result.smoothing))
        .unwrap_or_default();
    format!(
        "{}: length {}{smoothed}; {} nodes, {} iterations{seen}",
        result.planner,
        figure(result.length),
        result.nodes,
        result.iterations
    )
}

fn draw_paths(chart: &Chart<'_, '_>, canvas: &Canvas<'_>, result: &PathResult) {
    line(chart, &result.path, palette::series(1), 1.4);
    if let Some(smoothed) = &result.smoothed_path {
        line(chart, smoothed, palette::series(0), 2.6);
    }
    let ends = [(result.path.first(), palette::series(2)), (result.path.last(), palette::INK)];
    for (end, colour) in ends {
        if let Some(at) = end.and_then(|end| place(chart, end)) {
            canvas.dot(at, 5.0, colour);
        }
    }
}

/// Where a point's first two coordinates are drawn; what leaves the frame is
/// drawn at its edge.
fn place(chart: &Chart<'_, '_>, point: &[f64]) -> Option<(f64, f64)> {
    let [x, y, ..] = *point else { return None };
    let Frame { left, right, top, bottom } = chart.frame;
    let (x, y) = chart.pixel(x, y);
    (x.is_finite() && y.is_finite()).then(|| (x.clamp(left, right), y.clamp(top, bottom)))
}

fn line<P: AsRef<[f64]>>(
    chart: &Chart<'_, '_>,
    points: impl IntoIterator<Item = P>,
    colour: plotters::style::RGBColor,
    width: f64,
) {
    let points = points.into_iter().filter_map(|point| place(chart, point.as_ref()));
    chart.canvas.polyline(&points.collect::<Vec<_>>(), colour, width);
}

fn draw_obstacle(chart: &Chart<'_, '_>, obstacle: &Obstacle) {
    let outline: Vec<[f64; 2]> = match obstacle {
        Obstacle::Ball(ball) => {
            let [x, y, ..] = ball.center[..] else { return };
            let corner = |corner: usize| {
                let angle = std::f64::consts::TAU * corner as f64 / CORNERS as f64;
                let (sine, cosine) = libm::sincos(angle);
                [x + ball.radius * cosine, y + ball.radius * sine]
            };
            (0..=CORNERS).map(corner).collect()
        }
        Obstacle::Box(block) => {
            let ([left, lower, ..], [right, upper, ..]) = (&block.lower[..], &block.upper[..])
            else {
                return;
            };
            let corners = [[left, lower], [right, lower], [right, upper], [left, upper]];
            corners.into_iter().chain([[left, lower]]).map(|corner| corner.map(|x| *x)).collect()
        }
    };
    let outline: Vec<_> = outline.iter().filter_map(|point| place(chart, point)).collect();
    chart.canvas.area(&outline, palette::INK);
    chart.canvas.polyline(&outline, palette::FADED, 1.0);
}
