//! Which limit of which joint holds which instant: a row per joint, a lane per
//! limit, bars while it holds.

use plotters::style::RGBColor;

use crate::trajectory::{BindingTimeline, DERIVATIVES, LimitTimeline};

use super::canvas::{Align, TextLook, draw, text_width};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::motion::Section;
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 1000.0;
const RIGHT: f64 = WIDTH - 66.0;
/// Height of a limit's lane and of its bars.
const LANE: f64 = 12.0;
const BAR: f64 = 9.0;
/// Height of a joint's row: its lanes and what separates it from the next.
const ROW: f64 = 3.0 * LANE + 8.0;
/// Waypoint lines closer than this would make a grey area.
const CLOSEST_LINES: f64 = 3.0;

/// Draws when which limits hold, of all sections on one time axis, as SVG.
pub fn timeline(sections: &[Section<'_>]) -> String {
    let timelines: Vec<BindingTimeline> = sections.iter().map(of_section).collect();
    let Some(first) = timelines.first() else {
        return draw(WIDTH, 60.0, "empty timeline", |canvas| {
            canvas.text("nothing to show", (WIDTH / 2.0, 30.0), Align::Centre, TextLook::NORMAL);
        });
    };
    let names = first.joints.iter().map(|it| text_width(&it.joint, TextLook::NORMAL.size));
    let left = names.fold(60.0, f64::max).min(0.3 * WIDTH) + 20.0;
    let legend = Legend::new(entries(), left, RIGHT);
    let top = 48.0 + legend.height() + 8.0;
    let frame = Frame { left, right: RIGHT, top, bottom: top + ROW * first.joints.len() as f64 };
    let mut time = Range::EMPTY;
    for section in sections {
        time.include(section.start);
        time.include(section.end());
    }
    let title = title(sections);
    draw(WIDTH, frame.bottom + 46.0, &title, |canvas| {
        canvas.text(&title, (left, 20.0), Align::Left, TextLook::TITLE);
        canvas.text(&subtitle(&timelines), (left, 38.0), Align::Left, TextLook::SMALL);
        legend.draw(canvas, 48.0);
        // Rows are set by hand: the vertical scale has no values.
        let x = Scale::new(time, 0.0, frame.left, frame.right);
        let y = Scale::new(Range::EMPTY, 0.0, frame.bottom, frame.top);
        let chart = Chart { canvas, frame, x, y };
        axes(&chart, sections);
        for (index, joint) in first.joints.iter().enumerate() {
            let top = top + ROW * index as f64;
            row(&chart, &joint.joint, top);
            for (lane, name) in DERIVATIVES.iter().enumerate() {
                let limits: Vec<_> = timelines.iter().map(|it| limit(it, index, name)).collect();
                let middle = top + 4.0 + LANE * (lane as f64 + 0.5);
                bars(&chart, sections, &limits, colour(lane), middle);
                label(&chart, &timelines, &limits, middle);
            }
        }
    })
}

fn of_section(section: &Section<'_>) -> BindingTimeline {
    BindingTimeline::new(&section.result.trajectory, &section.result.certificate.joints)
}

fn title(sections: &[Section<'_>]) -> String {
    let robot = sections.first().map_or("", |section| section.result.robot.as_str());
    match sections {
        [Section { name: Some(name), .. }] => format!("{robot}, {name}: what holds it back"),
        _ => format!("{robot}: what holds it back"),
    }
}

fn subtitle(timelines: &[BindingTimeline]) -> String {
    let time = |of: fn(&BindingTimeline) -> f64| timelines.iter().map(of).sum::<f64>();
    let duration = time(|it| it.duration);
    format!(
        "bars: within {} % of the limit; at least one limit holds {} % of {} s",
        figure(100.0 * timelines.first().map_or(0.0, |it| it.tolerance)),
        percent(time(|it| it.held * it.duration) / duration),
        figure(duration)
    )
}

fn percent(share: f64) -> String {
    // A motion without any duration has no shares.
    format!("{:.1}", if share.is_finite() { 100.0 * share } else { 0.0 })
}

fn colour(lane: usize) -> RGBColor {
    palette::series(lane)
}

fn entries() -> Vec<Entry> {
    let limits = DERIVATIVES.iter().enumerate().map(|(lane, name)| Entry {
        name: format!("{name} at its limit"),
        colour: colour(lane),
        stroke: Stroke::Solid,
    });
    let waypoint =
        Entry { name: "waypoint".to_owned(), colour: palette::LINE, stroke: Stroke::Thin };
    limits.chain([waypoint]).collect()
}

/// The time axis and the waypoints' lines.
fn axes(chart: &Chart<'_, '_>, sections: &[Section<'_>]) {
    let Frame { left, right, top, bottom } = chart.frame;
    for tick in chart.x.ticks(10) {
        let at = chart.x.pixel(tick.value);
        chart.canvas.polyline(&[(at, top), (at, bottom)], palette::GRID, 1.0);
    }
    let mut before = f64::NEG_INFINITY;
    for section in sections {
        for time in &section.result.waypoint_times {
            let at = chart.x.pixel(section.start + time);
            if at >= before + CLOSEST_LINES {
                chart.canvas.polyline(&[(at, top), (at, bottom)], palette::LINE, 1.0);
                before = at;
            }
        }
    }
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    chart.canvas.polyline(&corners, palette::LINE, 1.0);
    chart.label_x("time [s]; at the right the share of the time");
}

/// A joint's name and what separates its row from the one above.
fn row(chart: &Chart<'_, '_>, name: &str, top: f64) {
    let Frame { left, right, .. } = chart.frame;
    chart.canvas.polyline(&[(left, top), (right, top)], palette::LINE, 1.0);
    let at = (left - 8.0, top + 0.5 * ROW);
    chart.canvas.text(name, at, Align::Right, TextLook::NORMAL);
}

fn limit<'a>(timeline: &'a BindingTimeline, joint: usize, name: &str) -> Option<&'a LimitTimeline> {
    timeline.joints.get(joint)?.limits.iter().find(|limit| limit.limit == name)
}

fn bars(
    chart: &Chart<'_, '_>,
    sections: &[Section<'_>],
    limits: &[Option<&LimitTimeline>],
    colour: RGBColor,
    middle: f64,
) {
    for (section, limit) in sections.iter().zip(limits) {
        for interval in limit.iter().flat_map(|limit| &limit.intervals) {
            let from = chart.x.pixel(section.start + interval.start);
            let until = chart.x.pixel(section.start + interval.end).max(from + 1.0);
            let (top, bottom) = (middle - 0.5 * BAR, middle + 0.5 * BAR);
            chart.canvas.rectangle(from, top, until, bottom, colour);
        }
    }
}

/// The share of the time, beside the lane; nothing where the limit never holds.
fn label(
    chart: &Chart<'_, '_>,
    timelines: &[BindingTimeline],
    limits: &[Option<&LimitTimeline>],
    middle: f64,
) {
    let all: f64 = timelines.iter().map(|it| it.duration).sum();
    let held = timelines.iter().zip(limits);
    let held = held.map(|(it, limit)| it.duration * limit.map_or(0.0, |it| it.share));
    let share = held.sum::<f64>() / all;
    if share > 0.0 {
        let look = TextLook { size: 10.0, ..TextLook::SMALL };
        let at = (chart.frame.right + 5.0, middle);
        let text =
            if share < 1e-3 { "< 0.1 %".to_owned() } else { format!("{} %", percent(share)) };
        chart.canvas.text(&text, at, Align::Left, look);
    }
}
