//! The search's convergence: best and mean duration over evaluations.

use crate::optimize::ConvergencePoint;
use crate::plan::{PathResult, PlanResult};

use super::canvas::{Align, TextLook, draw};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::motion::Section;
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 66.0;
const PLOT_HEIGHT: f64 = 340.0;

/// One search to draw.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    /// What the legend calls it.
    pub name: String,
    /// Its states, evaluations ascending.
    pub points: &'a [ConvergencePoint],
    /// A value to compare with and what it is, such as `optimum`; s.
    pub reference: Option<(&'a str, f64)>,
    /// What the values are.
    pub fitness: Fitness,
}

/// What a search makes small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitness {
    /// A duration, s.
    Duration,
    /// A weighted sum.
    Objective,
    /// A length, in the units of its space.
    Length,
}

impl<'a> Curve<'a> {
    /// The searches behind `result`, a curve per leg.
    pub fn all(result: &'a PlanResult) -> Vec<Self> {
        Section::all(result).into_iter().map(|section| Self::of(&section)).collect()
    }

    /// The search behind one trajectory.
    pub fn of(section: &Section<'a>) -> Self {
        let result = section.result;
        let method = format!("{}, {}", result.optimizer, result.interpolation);
        let name = section.name.map_or(method.clone(), |name| format!("{name} ({method})"));
        // The bound is on the whole motion: single joints may well be below it.
        let alone = result.per_joint.is_some();
        let weighted = result.metrics.reference.is_some();
        let bound = result.bound.as_ref().filter(|_| !alone && !weighted);
        let reference = bound.map(|bound| ("lower bound", bound.lower));
        let fitness = if weighted { Fitness::Objective } else { Fitness::Duration };
        Self { name, points: &result.convergence, reference, fitness }
    }

    /// The search behind a path.
    pub fn of_path(result: &'a PathResult) -> Self {
        let reference = Some(("straight line", result.straight_length));
        let name = result.planner.clone();
        Self { name, points: &result.convergence, reference, fitness: Fitness::Length }
    }

    /// The searches that follow each other: where each joint is planned alone,
    /// iterations start again with each.
    fn runs(&self) -> impl Iterator<Item = &'a [ConvergencePoint]> + use<'a> {
        self.points.chunk_by(|a, b| b.iteration > a.iteration)
    }

    fn best(&self) -> impl Iterator<Item = (f64, f64)> + use<'a> {
        best(self.points)
    }

    fn mean(&self) -> impl Iterator<Item = (f64, f64)> + use<'a> {
        mean(self.points)
    }
}

fn best(points: &[ConvergencePoint]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().filter_map(|p| Some((p.evaluations as f64, finite(p.best)?)))
}

fn mean(points: &[ConvergencePoint]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().filter_map(|p| Some((p.evaluations as f64, finite(p.mean)?)))
}

fn finite(value: Option<f64>) -> Option<f64> {
    value.filter(|value| value.is_finite())
}

/// Draws how each search's best duration, and the mean of its candidates, fell
/// with the number of evaluations, as SVG.
pub fn convergence(curves: &[Curve<'_>]) -> String {
    let legend = Legend::new(legend_entries(curves), LEFT, RIGHT);
    let top = 56.0 + legend.height();
    let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + PLOT_HEIGHT };
    let (x_range, y_range) = ranges(curves);
    draw(WIDTH, frame.bottom + 46.0, "convergence", |canvas| {
        canvas.text("Convergence", (LEFT, 20.0), Align::Left, TextLook::TITLE);
        canvas.text(&subtitle(curves), (LEFT, 38.0), Align::Left, TextLook::SMALL);
        legend.draw(canvas, 48.0);
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(x_range, 0.0, frame.left, frame.right),
            y: Scale::new(y_range, 0.05, frame.bottom, frame.top),
        };
        let (title, evaluations) = match fitness(curves) {
            Fitness::Duration => ("duration [s]", "evaluations"),
            Fitness::Objective => ("objective", "evaluations"),
            Fitness::Length => ("length", "motions checked"),
        };
        chart.draw_axes(title);
        chart.label_x(evaluations);
        draw_means(&chart, curves);
        draw_references(&chart, curves);
        draw_bests(&chart, curves);
    })
}

/// What the values are; of several kinds that which is no duration.
fn fitness(curves: &[Curve<'_>]) -> Fitness {
    let mut kinds = curves.iter().map(|curve| curve.fitness);
    kinds.find(|kind| *kind != Fitness::Duration).unwrap_or(Fitness::Duration)
}

fn subtitle(curves: &[Curve<'_>]) -> String {
    let evaluations: u64 = curves.iter().filter_map(|c| Some(c.points.last()?.evaluations)).sum();
    let best: f64 = curves.iter().filter_map(|curve| Some(curve.best().last()?.1)).sum();
    if curves.iter().any(|curve| curve.runs().nth(1).is_some()) {
        return format!("each joint alone, one after the other: {evaluations} evaluations");
    }
    let unit = if fitness(curves) == Fitness::Duration { " s" } else { "" };
    match curves.iter().any(|curve| curve.best().next().is_some()) {
        true if curves.len() > 1 => {
            format!("best together {}{unit} after {evaluations} evaluations", figure(best))
        }
        true => format!("best {}{unit} after {evaluations} evaluations", figure(best)),
        false => format!("no feasible candidate in {evaluations} evaluations"),
    }
}

fn legend_entries(curves: &[Curve<'_>]) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (index, curve) in curves.iter().enumerate() {
        let (name, colour) = (curve.name.clone(), palette::series(index));
        entries.push(Entry { name, colour, stroke: Stroke::Solid });
    }
    if curves.iter().any(|curve| curve.mean().next().is_some()) {
        let name = "mean of the candidates".to_owned();
        entries.push(Entry { name, colour: palette::FADED, stroke: Stroke::Thin });
    }
    for (index, curve) in curves.iter().enumerate() {
        let Some((what, value)) = curve.reference else { continue };
        let colour = if curves.len() > 1 { palette::series(index) } else { palette::INK };
        let name = format!("{what} {} s", figure(value));
        entries.push(Entry { name, colour, stroke: Stroke::Dashed });
    }
    entries
}

/// The values shown. Means far above every best are cut off: how high a
/// search began matters less than how it ended.
fn ranges(curves: &[Curve<'_>]) -> (Range, Range) {
    let (mut x, mut y, mut means) = (Range::EMPTY, Range::EMPTY, Range::EMPTY);
    x.include(0.0);
    for curve in curves {
        for (evaluations, best) in curve.best() {
            x.include(evaluations);
            y.include(best);
        }
        if let Some((_, value)) = curve.reference {
            y.include(value);
        }
        curve.mean().for_each(|(evaluations, mean)| {
            x.include(evaluations);
            means.include(mean);
        });
    }
    if !means.is_empty() {
        let cut =
            if y.is_empty() { means.max } else { y.max + (2.0 * y.span()).max(0.5 * y.max.abs()) };
        y.include(means.min.min(cut));
        y.include(means.max.min(cut));
    }
    (x, y)
}

fn draw_means(chart: &Chart<'_, '_>, curves: &[Curve<'_>]) {
    for (index, curve) in curves.iter().enumerate() {
        let colour = palette::lighter(palette::series(index));
        for run in curve.runs() {
            let points: Vec<(f64, f64)> = mean(run).collect();
            // What is cut off at the top leaves a gap, not a line along the edge.
            for part in points.split(|&(_, mean)| !chart.y.contains(mean)) {
                let part: Vec<_> = part.iter().map(|&(x, y)| chart.pixel(x, y)).collect();
                chart.canvas.polyline(&part, colour, 1.2);
            }
        }
    }
}

fn draw_references(chart: &Chart<'_, '_>, curves: &[Curve<'_>]) {
    for (index, curve) in curves.iter().enumerate() {
        let Some((_, value)) = curve.reference else { continue };
        let colour = if curves.len() > 1 { palette::series(index) } else { palette::INK };
        chart.canvas.dashed(chart.frame.left, chart.frame.right, chart.y.pixel(value), colour);
    }
}

/// The best stays as it is until it improves: stairs, not slopes.
fn draw_bests(chart: &Chart<'_, '_>, curves: &[Curve<'_>]) {
    let mut labels = Vec::new();
    for (index, curve) in curves.iter().enumerate() {
        let colour = palette::series(index);
        for run in curve.runs() {
            let mut points: Vec<(f64, f64)> = Vec::new();
            for (x, y) in best(run).map(|(x, y)| chart.pixel(x, y)) {
                match points.last() {
                    Some(&(_, before)) if before != y => points.extend([(x, before), (x, y)]),
                    _ => points.push((x, y)),
                }
            }
            chart.canvas.polyline(&points, colour, 2.0);
            if let (Some(&end), Some((_, best))) = (points.last(), best(run).last()) {
                chart.canvas.dot(end, 3.0, colour);
                labels.push((best, figure(best), colour));
            }
        }
    }
    chart.label_right(&labels);
}
