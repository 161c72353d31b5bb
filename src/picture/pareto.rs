//! Fronts of motions: what each objective costs in time.

use crate::plan::ParetoFront;
use crate::trajectory::objective::{Measures, ObjectiveName};

use super::canvas::{Align, Canvas, TextLook, draw};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::motion::Section;
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 66.0;
const PLOT_HEIGHT: f64 = 300.0;

/// Space between two charts, for the labels of the upper one.
const BETWEEN: f64 = 80.0;

/// Points of the curve of the stretched fastest motion.
const CURVE_POINTS: usize = 100;

/// Draws the fronts among `sections`, as SVG: a chart for every objective
/// over time, with what stretching the fastest motion would come to and the
/// plan itself. Sections without a front are left out.
pub fn pareto(sections: &[Section<'_>]) -> String {
    let fronts: Vec<_> = sections.iter().filter_map(Panel::all).flatten().collect();
    let legend = Legend::new(legend_entries(), LEFT, RIGHT);
    let top = 48.0 + legend.height() + 26.0;
    let each = PLOT_HEIGHT + BETWEEN;
    draw(WIDTH, top + each * fronts.len().max(1) as f64, "front of motions", |canvas| {
        canvas.text("Pareto front", (LEFT, 20.0), Align::Left, TextLook::TITLE);
        legend.draw(canvas, 30.0);
        for (index, panel) in fronts.iter().enumerate() {
            panel.draw(canvas, top + each * index as f64);
        }
    })
}

fn legend_entries() -> Vec<Entry> {
    let entry = |name: &str, colour, stroke| Entry { name: name.to_owned(), colour, stroke };
    vec![
        entry("motions of the front", palette::series(0), Stroke::Dot),
        entry("the fastest one, only stretched", palette::FADED, Stroke::Thin),
        entry("the plan", palette::series(1), Stroke::Dot),
    ]
}

/// One objective of a front over time.
struct Panel<'a> {
    title: String,
    front: &'a ParetoFront,
    name: ObjectiveName,
    unit: &'a str,
    /// Time and value of every point.
    points: Vec<(f64, f64)>,
    plan: (f64, f64),
}

impl<'a> Panel<'a> {
    /// A panel per objective but time; none without a front.
    fn all(section: &Section<'a>) -> Option<Vec<Self>> {
        let front = section.result.pareto.as_ref()?;
        let time = front.objectives.iter().position(|axis| axis.name == ObjectiveName::Time)?;
        let panel = |(index, axis): (usize, &'a crate::plan::ParetoAxis)| {
            let pair = |point: &crate::plan::ParetoPoint| {
                Some((*point.values.get(time)?, *point.values.get(index)?))
            };
            let plan = &section.result.metrics.objective;
            let robot = &section.result.robot;
            Self {
                title: section.name.map_or(robot.clone(), |name| format!("{robot}, {name}")),
                front,
                name: axis.name,
                unit: &axis.unit,
                points: front.points.iter().filter_map(pair).collect(),
                plan: (plan.time, axis.name.of(plan)),
            }
        };
        let others = front.objectives.iter().enumerate().filter(|(index, _)| *index != time);
        Some(others.map(panel).collect())
    }

    /// The value of the fastest motion stretched to `time`.
    fn stretched(&self, time: f64) -> f64 {
        let Some(&(fastest, value)) = self.points.first() else { return f64::NAN };
        let start = Measures { time: fastest, rms_jerk: value, energy: value };
        self.name.of(&start.scaled(time / fastest))
    }

    fn words(&self) -> &'static str {
        match self.name {
            ObjectiveName::Time => "time",
            ObjectiveName::RmsJerk => "rms jerk",
            ObjectiveName::Energy => "mean squared acceleration",
        }
    }

    /// In words: how many motions, how much better they are than stretching, and
    /// the plan, which has no room for a label between two curves.
    fn subtitle(&self) -> String {
        let saved = |&(time, value): &(f64, f64)| 1.0 - value / self.stretched(time);
        let most = self.points.iter().map(saved).fold(0.0, f64::max);
        let count = self.points.len();
        let gain = format!("up to {} % less than by stretching", figure(100.0 * most));
        let (time, value) = (figure(self.plan.0), figure(self.plan.1));
        let plan = format!("the plan {time} s, {value} {}", self.unit);
        format!("{}: {count} motions, {} {gain}; {plan}", self.title, self.words())
    }

    fn draw(&self, canvas: &Canvas<'_>, top: f64) {
        let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + PLOT_HEIGHT };
        canvas.text(&self.subtitle(), (LEFT, top - 12.0), Align::Left, TextLook::SMALL);
        let (mut x, mut y) = (Range::EMPTY, Range::EMPTY);
        y.include(0.0);
        for &(time, value) in self.points.iter().chain([&self.plan]) {
            x.include(time);
            y.include(value);
        }
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(x, 0.02, frame.left, frame.right),
            y: Scale::new(y, 0.05, frame.bottom, frame.top),
        };
        chart.draw_axes(&format!("{} [{}]", self.words(), self.unit));
        chart.label_x("time [s]");
        self.draw_stretched(&chart, x);
        let two = self.front.objectives.len() == 2;
        let pixels: Vec<_> = self.points.iter().map(|&(x, y)| chart.pixel(x, y)).collect();
        if two {
            // With a third objective neighbours in time are no neighbours.
            canvas.polyline(&pixels, palette::lighter(palette::series(0)), 1.2);
        }
        for &point in &pixels {
            canvas.dot(point, 3.0, palette::series(0));
        }
        canvas.dot(chart.pixel(self.plan.0, self.plan.1), 4.5, palette::series(1));
    }

    fn draw_stretched(&self, chart: &Chart<'_, '_>, range: Range) {
        let at = |index: usize| {
            let share = index as f64 / CURVE_POINTS as f64;
            let time = range.min + share * range.span();
            (time, self.stretched(time))
        };
        let curve = (0..=CURVE_POINTS).map(at).filter(|(_, value)| chart.y.contains(*value));
        let curve: Vec<_> = curve.map(|(time, value)| chart.pixel(time, value)).collect();
        chart.canvas.polyline(&curve, palette::FADED, 1.2);
    }
}
