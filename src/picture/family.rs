//! A family at a glance: durations over what was swept, or as sorted bars.

use crate::plan::{FamilyResult, MemberResult};

use super::canvas::{Align, Canvas, TextLook, draw, text_width};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 900.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 30.0;
const PLOT_HEIGHT: f64 = 320.0;
/// Above the frame: title, line below it and legend.
const ABOVE_LEGEND: f64 = 48.0;
/// Height of a bar that has a name.
const ROW: f64 = 18.0;
/// More bars than this have no names.
const MOST_NAMED: usize = 60;
/// More lines than this cannot be told apart.
const MOST_LINES: usize = 14;

/// Draws the durations of a family, as SVG: over the first swept number with a
/// line per combination of the rest, otherwise as bars from slow to fast.
pub fn family(result: &FamilyResult) -> String {
    match lines(result) {
        Some((title, lines)) => draw_lines(result, &title, &lines),
        None => draw_bars(result),
    }
}

/// Members that differ in the value along the horizontal axis alone.
struct Line<'a> {
    /// The values on the other axes; empty if there are none.
    name: String,
    /// By value along the axis.
    points: Vec<(f64, &'a MemberResult)>,
}

/// The lines of a sweep and what the horizontal axis shows; none if nothing
/// swept is a number, or if there are too many lines.
fn lines(result: &FamilyResult) -> Option<(String, Vec<Line<'_>>)> {
    let axis = result.sweep.iter().position(|axis| {
        axis.values.len() > 1 && axis.values.iter().all(|value| value.is_number())
    })?;
    let mut lines: Vec<Line<'_>> = Vec::new();
    for member in &result.members {
        let x = member.values.get(axis)?.as_f64()?;
        let others = result.sweep.iter().zip(&member.values).enumerate();
        let others = others.filter(|(at, _)| *at != axis);
        let others = others.map(|(_, (other, value))| format!("{} = {value}", end(&other.path)));
        let name = others.collect::<Vec<_>>().join(", ");
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push((x, member)),
            None => lines.push(Line { name, points: vec![(x, member)] }),
        }
    }
    lines.iter_mut().for_each(|line| line.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let title = result.sweep[axis].path.trim_start_matches('/').replace('/', " ");
    let title = title.replace('_', " ");
    (lines.len() <= MOST_LINES).then_some((title, lines))
}

/// The last step of a pointer.
fn end(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

fn headline(canvas: &Canvas<'_>, result: &FamilyResult, left: f64) {
    let count = result.members.len();
    let title = format!("{}: {count} members", result.robot);
    canvas.text(&title, (left, 20.0), Align::Left, TextLook::TITLE);
    let slowest = format!(
        "slowest {}: {} s; fastest {}",
        result.slowest,
        figure(result.worst_case.duration),
        result.fastest
    );
    let failed = match result.failed {
        0 => String::new(),
        failed => format!("; {failed} not planned"),
    };
    canvas.text(&(slowest + &failed), (left, 38.0), Align::Left, TextLook::SMALL);
}

fn draw_lines(result: &FamilyResult, title: &str, lines: &[Line<'_>]) -> String {
    let entry = |name: &str, colour, stroke| Entry { name: name.to_owned(), colour, stroke };
    let mut entries = match lines {
        [_] => vec![entry("duration", palette::series(0), Stroke::Solid)],
        several => {
            let several = several.iter().enumerate();
            several
                .map(|(at, line)| entry(&line.name, palette::series(at), Stroke::Solid))
                .collect()
        }
    };
    let bound = if lines.len() == 1 { palette::INK } else { palette::FADED };
    entries.push(entry("no motion is faster (thin)", bound, Stroke::Thin));
    let legend = Legend::new(entries, LEFT, RIGHT);
    let top = ABOVE_LEGEND + legend.height() + 8.0;
    let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + PLOT_HEIGHT };
    let (mut x, mut y) = (Range::EMPTY, Range::EMPTY);
    for (value, member) in lines.iter().flat_map(|line| &line.points) {
        x.include(*value);
        member.duration.into_iter().chain(member.lower_bound).for_each(|it| y.include(it));
    }
    draw(WIDTH, frame.bottom + 46.0, "durations over the swept value", |canvas| {
        headline(canvas, result, LEFT);
        legend.draw(canvas, ABOVE_LEGEND);
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(x, 0.03, frame.left, frame.right),
            y: Scale::new(y, 0.05, frame.bottom, frame.top),
        };
        chart.draw_axes("duration [s]");
        chart.label_x(title);
        for (at, line) in lines.iter().enumerate() {
            draw_line(&chart, line, at);
        }
    })
}

/// Durations as dots joined by a line, bounds as a thin one; members that were
/// not planned leave a gap.
fn draw_line(chart: &Chart<'_, '_>, line: &Line<'_>, index: usize) {
    let colour = palette::series(index);
    for part in line.points.split(|(_, member)| member.duration.is_none()) {
        let pixels = |of: fn(&MemberResult) -> Option<f64>| -> Vec<(f64, f64)> {
            let pixel = |(x, member): &(f64, &MemberResult)| Some(chart.pixel(*x, of(member)?));
            part.iter().filter_map(pixel).collect()
        };
        let (bounds, durations) = (pixels(|it| it.lower_bound), pixels(|it| it.duration));
        if bounds.len() > 1 {
            let colour = if index == 0 { palette::INK } else { palette::lighter(colour) };
            chart.canvas.polyline(&bounds, colour, 1.2);
        }
        if durations.len() > 1 {
            chart.canvas.polyline(&durations, colour, 2.2);
        }
        durations.into_iter().for_each(|at| chart.canvas.dot(at, 3.5, colour));
    }
}

/// The planned members from slow to fast.
fn sorted(result: &FamilyResult) -> Vec<(&MemberResult, f64)> {
    let planned = result.members.iter().filter_map(|member| Some((member, member.duration?)));
    let mut planned: Vec<_> = planned.collect();
    planned.sort_by(|a, b| b.1.total_cmp(&a.1));
    planned
}

fn draw_bars(result: &FamilyResult) -> String {
    let members = sorted(result);
    let mut durations = Range::EMPTY;
    durations.include(0.0);
    members.iter().for_each(|(_, duration)| durations.include(*duration));
    let entry = |name: &str, colour, stroke| Entry { name: name.to_owned(), colour, stroke };
    let entries = vec![
        entry("slowest", palette::series(1), Stroke::Solid),
        entry("others", palette::series(0), Stroke::Solid),
        entry("no motion is faster", palette::INK, Stroke::Thin),
    ];
    let named = members.len() <= MOST_NAMED;
    let names = members.iter().map(|(it, _)| text_width(&it.name, TextLook::NORMAL.size));
    let names = names.fold(60.0, f64::max).min(0.4 * WIDTH) + 18.0;
    let left = if named { names } else { LEFT };
    let legend = Legend::new(entries, left, RIGHT);
    let top = ABOVE_LEGEND + legend.height() + 8.0;
    let height = if named { ROW * members.len() as f64 } else { PLOT_HEIGHT };
    let frame = Frame { left, right: RIGHT, top, bottom: top + height };
    draw(WIDTH, frame.bottom + 46.0, "durations of all members, slowest first", |canvas| {
        headline(canvas, result, left);
        legend.draw(canvas, ABOVE_LEGEND);
        let bars = Bars { canvas, frame, result, members: &members };
        if named { bars.rows(durations) } else { bars.columns(durations) }
    })
}

/// Bars to be drawn, slowest first.
struct Bars<'a, 'b> {
    canvas: &'a Canvas<'b>,
    frame: Frame,
    result: &'a FamilyResult,
    members: &'a [(&'a MemberResult, f64)],
}

impl Bars<'_, '_> {
    fn colour(&self, member: &MemberResult) -> plotters::style::RGBColor {
        palette::series(usize::from(self.result.is_slowest(member)))
    }

    /// A named row for each member.
    fn rows(&self, durations: Range) {
        let Frame { left, right, top, bottom } = self.frame;
        let x = Scale::new(Range { max: 1.08 * durations.max, ..durations }, 0.0, left, right);
        let y = Scale::new(Range::EMPTY, 0.0, bottom, top);
        let chart = Chart { canvas: self.canvas, frame: self.frame, x, y };
        for tick in chart.x.ticks(10) {
            let at = chart.x.pixel(tick.value);
            self.canvas.polyline(&[(at, top), (at, bottom)], palette::GRID, 1.0);
        }
        chart.label_x("duration [s]");
        for (index, (member, duration)) in self.members.iter().enumerate() {
            let y = top + ROW * (index as f64 + 0.5);
            let end = x.pixel(*duration);
            self.canvas.rectangle(left, y - 6.0, end, y + 6.0, self.colour(member));
            if let Some(bound) = member.lower_bound {
                let at = x.pixel(bound);
                self.canvas.polyline(&[(at, y - 8.0), (at, y + 8.0)], palette::INK, 1.6);
            }
            self.canvas.text(&member.name, (left - 8.0, y), Align::Right, TextLook::NORMAL);
            self.canvas.text(&figure(*duration), (end + 5.0, y), Align::Left, TextLook::SMALL);
        }
    }

    /// A column for each member, without names.
    fn columns(&self, durations: Range) {
        let Frame { left, right, top, bottom } = self.frame;
        let mut numbers = Range::EMPTY;
        numbers.include(0.0);
        numbers.include(self.members.len() as f64);
        let x = Scale::new(numbers, 0.0, left, right);
        let y = Scale::new(Range { max: 1.05 * durations.max, ..durations }, 0.0, bottom, top);
        let chart = Chart { canvas: self.canvas, frame: self.frame, x, y };
        chart.draw_axes("duration [s]");
        chart.label_x("members, slowest first");
        let gap = if x.resolution() > 4.0 { 0.5 } else { 0.0 };
        for (index, (member, duration)) in self.members.iter().enumerate() {
            let (start, end) = (x.pixel(index as f64) + gap, x.pixel(index as f64 + 1.0) - gap);
            let colour = self.colour(member);
            self.canvas.rectangle(start, y.pixel(*duration), end, bottom, colour);
            if let Some(bound) = member.lower_bound {
                let height = y.pixel(bound);
                self.canvas.polyline(&[(start, height), (end, height)], palette::INK, 1.2);
            }
        }
    }
}
