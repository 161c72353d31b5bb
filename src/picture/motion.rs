//! A motion over time: every joint's position and its derivatives beside
//! their limits.

use std::collections::BTreeSet;

use plotters::style::RGBColor;

use crate::math::polynomial::{self, Extremes};
use crate::plan::{PlanResult, TrajectoryResult};
use crate::trajectory::{JointCertificate, Quantity};

use super::canvas::{Align, Canvas, TextLook, draw, text_width};
use super::chart::{Chart, Entry, Frame, Legend, Stroke};
use super::palette;
use super::scale::{Range, Scale, figure};

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 66.0;
const PANEL_HEIGHT: f64 = 178.0;
const PANEL_GAP: f64 = 24.0;
/// Room for the names of sections above the first panel.
const SECTION_NAMES: f64 = 16.0;
/// Waypoint lines closer than this would make a grey area.
const CLOSEST_LINES: f64 = 3.0;

/// One trajectory on a time axis.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    /// The leg's name within a program, or the member's within a family.
    pub name: Option<&'a str>,
    /// When it starts, s.
    pub start: f64,
    /// The trajectory with its certificate.
    pub result: &'a TrajectoryResult,
}

impl<'a> Section<'a> {
    /// Everything `result` holds, in order.
    pub fn all(result: &'a PlanResult) -> Vec<Self> {
        match result {
            PlanResult::Trajectory(result) => vec![Self { name: None, start: 0.0, result }],
            PlanResult::Program(program) => program
                .legs
                .iter()
                .map(|leg| Self { name: Some(&leg.name), start: leg.start, result: &leg.result })
                .collect(),
            // Of all members only the worst case's motion is kept.
            PlanResult::Family(family) => {
                let (name, result) = (Some(family.slowest.as_str()), &*family.worst_case);
                vec![Self { name, start: 0.0, result }]
            }
            // Neither a path nor durations that are compared are motions.
            PlanResult::Path(_) | PlanResult::Comparison(_) => Vec::new(),
        }
    }

    /// The leg called `name`, starting at zero; none if there is no such leg.
    pub fn leg(result: &'a PlanResult, name: &str) -> Option<Self> {
        let leg = Self::all(result).into_iter().find(|section| section.name == Some(name))?;
        Some(Self { start: 0.0, ..leg })
    }

    /// When it ends, s.
    pub(super) fn end(&self) -> f64 {
        self.start + self.result.trajectory.duration()
    }
}

/// Draws `quantities` of all joints over time as SVG, a panel for each
/// quantity and unit, with limits as dashed lines and waypoints as vertical
/// ones. Limits far outside a panel are written beside it instead.
pub fn plot(sections: &[Section<'_>], quantities: &[Quantity]) -> String {
    let panels = panels(sections, quantities);
    let Some(first) = sections.first().filter(|_| !panels.is_empty()) else {
        return draw(WIDTH, 60.0, "empty plot", |canvas| {
            canvas.text("nothing to show", (WIDTH / 2.0, 30.0), Align::Centre, TextLook::NORMAL);
        });
    };
    let legend = Legend::new(legend_entries(first.result, &panels), LEFT, RIGHT);
    let names = if sections.len() > 1 { SECTION_NAMES } else { 0.0 };
    let top = 52.0 + legend.height() + names + PANEL_GAP;
    let height = top + panels.len() as f64 * (PANEL_HEIGHT + PANEL_GAP) + 22.0;
    let title = title(sections);
    draw(WIDTH, height, &title, |canvas| {
        canvas.text(&title, (LEFT, 20.0), Align::Left, TextLook::TITLE);
        canvas.text(&subtitle(sections), (LEFT, 40.0), Align::Left, TextLook::SMALL);
        legend.draw(canvas, 52.0);
        for (index, panel) in panels.iter().enumerate() {
            let top = top + index as f64 * (PANEL_HEIGHT + PANEL_GAP);
            let frame = Frame { left: LEFT, right: RIGHT, top, bottom: top + PANEL_HEIGHT };
            let chart = panel.draw(canvas, frame, sections);
            // A single one is named in the title.
            if index == 0 && sections.len() > 1 {
                name_sections(&chart, sections);
            }
            if index + 1 == panels.len() {
                chart.label_x("time [s]");
            }
        }
    })
}

fn title(sections: &[Section<'_>]) -> String {
    let robot = sections.first().map_or("", |section| section.result.robot.as_str());
    let duration: f64 = sections.iter().map(|section| section.result.duration).sum();
    match sections {
        [Section { name: Some(name), .. }] => format!("{robot}, {name}: {} s", figure(duration)),
        [_] => format!("{robot}: {} s", figure(duration)),
        _ => format!("{robot}: {} sections, {} s", sections.len(), figure(duration)),
    }
}

/// Method and lawfulness in a line.
fn subtitle(sections: &[Section<'_>]) -> String {
    let method = |section: &Section<'_>| {
        format!("{}, {}", section.result.interpolation, section.result.optimizer)
    };
    let methods: BTreeSet<String> = sections.iter().map(method).collect();
    let mut text = methods.into_iter().collect::<Vec<_>>().join(" / ");
    let mut violations = sections.iter().flat_map(|s| &s.result.certificate.violations);
    let worst = sections.iter().map(|s| s.result.certificate.worst_ratio).fold(0.0, f64::max);
    if let Some(violation) = violations.next() {
        text.push_str(&format!(" · NOT LAWFUL: {}", violation.detail));
    } else if sections.iter().all(|section| section.result.certificate.lawful) {
        text.push_str(&format!(" · lawful, largest peak {:.2} % of its limit", 100.0 * worst));
    }
    text
}

fn legend_entries(result: &TrajectoryResult, panels: &[Panel<'_>]) -> Vec<Entry> {
    let joint = |(index, name): (usize, &String)| Entry {
        name: name.clone(),
        colour: palette::series(index),
        stroke: Stroke::Solid,
    };
    let mut entries: Vec<Entry> = result.joint_names.iter().enumerate().map(joint).collect();
    if panels.iter().any(|panel| !panel.limits.is_empty()) {
        let (name, colour) = ("limit".to_owned(), palette::FADED);
        entries.push(Entry { name, colour, stroke: Stroke::Dashed });
    }
    entries
}

fn name_sections(chart: &Chart<'_, '_>, sections: &[Section<'_>]) {
    for section in sections {
        let Some(name) = section.name else { continue };
        let (left, right) = (chart.x.pixel(section.start), chart.x.pixel(section.end()));
        // A name wider than its section would run into its neighbour's.
        if text_width(name, TextLook::NORMAL.size) <= right - left {
            let look = TextLook { bold: true, ..TextLook::NORMAL };
            let at = (0.5 * (left + right), chart.frame.top - SECTION_NAMES - 9.0);
            chart.canvas.text(name, at, Align::Centre, look);
        }
    }
}

/// A limit and the joints that share it.
struct Limit {
    value: f64,
    joints: Vec<usize>,
}

/// One quantity of all joints of one unit.
struct Panel<'a> {
    quantity: Quantity,
    unit: &'a str,
    joints: Vec<usize>,
    range: Range,
    limits: Vec<Limit>,
    /// Limits too far away to draw.
    beyond: Vec<Limit>,
}

fn panels<'a>(sections: &[Section<'a>], quantities: &[Quantity]) -> Vec<Panel<'a>> {
    let Some(first) = sections.first() else { return Vec::new() };
    let units = &first.result.joint_units;
    let distinct: BTreeSet<&str> = units.iter().map(String::as_str).collect();
    let mut panels = Vec::new();
    for &quantity in quantities {
        // Radians come first: most joints turn.
        for &unit in distinct.iter().rev() {
            let joints: Vec<usize> =
                (0..units.len()).filter(|&joint| units[joint] == unit).collect();
            panels.push(Panel::new(sections, quantity, unit, joints));
        }
    }
    panels
}

impl<'a> Panel<'a> {
    fn new(
        sections: &[Section<'_>],
        quantity: Quantity,
        unit: &'a str,
        joints: Vec<usize>,
    ) -> Self {
        let mut range = Range::EMPTY;
        for section in sections {
            for &joint in &joints {
                include_motion(&mut range, section, joint, quantity);
            }
        }
        if quantity != Quantity::Position {
            range.include(0.0);
        }
        // Limits may take as much room again as the motion itself, on both
        // sides together; for those further off, flattened curves would be
        // too high a price.
        let share = if quantity == Quantity::Position { 0.5 } else { 1.0 };
        let reach = if range.span() > 0.0 { share * range.span() } else { f64::INFINITY };
        let near = Range { min: range.min - reach, max: range.max + reach };
        let (limits, beyond): (Vec<Limit>, Vec<Limit>) = limits(sections, quantity, &joints)
            .into_iter()
            .partition(|limit| limit.value >= near.min && limit.value <= near.max);
        for limit in &limits {
            range.include(limit.value);
        }
        Self { quantity, unit, joints, range, limits, beyond }
    }

    fn draw<'c, 'd>(
        &self,
        canvas: &'c Canvas<'d>,
        frame: Frame,
        sections: &[Section<'_>],
    ) -> Chart<'c, 'd> {
        let mut time = Range::EMPTY;
        for section in sections {
            time.include(section.start);
            time.include(section.end());
        }
        let chart = Chart {
            canvas,
            frame,
            x: Scale::new(time, 0.0, frame.left, frame.right),
            y: Scale::new(self.range, 0.06, frame.bottom, frame.top),
        };
        let unit = self.quantity.unit(self.unit).replace("^2", "²").replace("^3", "³");
        chart.draw_axes(&format!("{} [{unit}]", self.quantity));
        draw_waypoints(&chart, sections);
        self.draw_limits(&chart);
        for &joint in &self.joints {
            for section in sections {
                let points = curve(&chart, section, joint, self.quantity);
                canvas.polyline(&points, palette::series(joint), 1.6);
            }
        }
        self.mark_violations(&chart, sections);
        self.note_limits_beyond(&chart, sections);
        chart
    }

    fn limit_colour(&self, limit: &Limit) -> RGBColor {
        match limit.joints[..] {
            [joint] if self.joints.len() > 1 => palette::series(joint),
            _ => palette::FADED,
        }
    }

    fn draw_limits(&self, chart: &Chart<'_, '_>) {
        let Frame { left, right, .. } = chart.frame;
        let mut labels = Vec::with_capacity(self.limits.len());
        for limit in &self.limits {
            let colour = self.limit_colour(limit);
            chart.canvas.dashed(left, right, chart.y.pixel(limit.value), colour);
            labels.push((limit.value, figure(limit.value), colour));
        }
        chart.label_right(&labels);
    }

    fn mark_violations(&self, chart: &Chart<'_, '_>, sections: &[Section<'_>]) {
        for section in sections {
            let names = &section.result.joint_names;
            for violation in &section.result.certificate.violations {
                let joint = self.joints.iter().find(|&&joint| names[joint] == violation.joint);
                let here = violation.limit == self.quantity.as_str();
                let (Some(&joint), Some(value), true) = (joint, violation.value, here) else {
                    continue;
                };
                let value = match self.quantity {
                    Quantity::Position => value,
                    // Peaks may be told without their sign: mark the side it is on.
                    quantity => {
                        value.abs().copysign(value_at(section, joint, quantity, violation.at))
                    }
                };
                let at = chart.pixel(section.start + violation.at, value);
                chart.canvas.dot(at, 4.0, palette::INK);
            }
        }
    }

    /// Writes above the panel which limits lie too far outside.
    fn note_limits_beyond(&self, chart: &Chart<'_, '_>, sections: &[Section<'_>]) {
        const SHOWN: usize = 6;
        let Some(first) = sections.first().filter(|_| !self.beyond.is_empty()) else { return };
        let described = |limit: &Limit| match limit.joints[..] {
            [joint] => format!("{} {}", first.result.joint_names[joint], figure(limit.value)),
            _ => format!("{} joints {}", limit.joints.len(), figure(limit.value)),
        };
        let listed: Vec<String> = self.beyond.iter().take(SHOWN).map(described).collect();
        let hidden = self.beyond.len().saturating_sub(SHOWN);
        let more = if hidden > 0 { format!(" and {hidden} more") } else { String::new() };
        let note = format!("limits beyond the axis: {}{more}", listed.join(", "));
        let at = (chart.frame.right, chart.frame.top - 9.0);
        let look = TextLook { size: 10.0, ..TextLook::SMALL };
        chart.canvas.text(&note, at, Align::Right, look);
    }
}

/// The limits of `joints`, equal ones together.
fn limits(sections: &[Section<'_>], quantity: Quantity, joints: &[usize]) -> Vec<Limit> {
    let mut limits: Vec<Limit> = Vec::new();
    let mut add = |value: f64, joint: usize| {
        if !value.is_finite() {
            return;
        }
        match limits.iter_mut().find(|limit| limit.value == value) {
            Some(limit) if limit.joints.contains(&joint) => {}
            Some(limit) => limit.joints.push(joint),
            None => limits.push(Limit { value, joints: vec![joint] }),
        }
    };
    for section in sections {
        for &joint in joints {
            let Some(certificate) = section.result.certificate.joints.get(joint) else { continue };
            for value in limits_of(certificate, quantity).into_iter().flatten() {
                add(value, joint);
            }
        }
    }
    limits
}

/// Lower and upper limit.
fn limits_of(joint: &JointCertificate, quantity: Quantity) -> [Option<f64>; 2] {
    let symmetric = |limit: Option<f64>| [limit.map(|limit| -limit), limit];
    match quantity {
        Quantity::Position => [joint.position.lower, joint.position.upper],
        Quantity::Velocity => symmetric(joint.velocity.limit),
        Quantity::Acceleration => symmetric(joint.acceleration.limit),
        Quantity::Jerk => symmetric(joint.jerk.limit),
    }
}

fn draw_waypoints(chart: &Chart<'_, '_>, sections: &[Section<'_>]) {
    let Frame { top, bottom, .. } = chart.frame;
    let mut last = f64::NEG_INFINITY;
    for section in sections {
        for time in &section.result.waypoint_times {
            let x = chart.x.pixel(section.start + time);
            if x - last >= CLOSEST_LINES {
                chart.canvas.polyline(&[(x, top), (x, bottom)], palette::LINE, 0.8);
                last = x;
            }
        }
        if sections.len() > 1 {
            let x = chart.x.pixel(section.start);
            chart.canvas.polyline(&[(x, top), (x, bottom)], palette::FADED, 1.6);
        }
    }
}

/// One joint's coefficients, each with its piece's start and length.
fn pieces<'a>(
    section: &'a Section<'_>,
    joint: usize,
) -> impl Iterator<Item = (f64, f64, &'a [f64])> {
    let trajectory = &section.result.trajectory;
    trajectory.breakpoints.windows(2).zip(&trajectory.pieces).filter_map(move |(ends, piece)| {
        let coefficients = piece.get(joint)?;
        Some((ends[0], ends[1] - ends[0], coefficients.as_slice()))
    })
}

fn include_motion(range: &mut Range, section: &Section<'_>, joint: usize, quantity: Quantity) {
    for (_, length, coefficients) in pieces(section, joint) {
        if !coefficients.is_empty() && coefficients.len() <= polynomial::MAX_COEFFICIENTS {
            let extrema = Extremes::new(coefficients, length).of(quantity.order());
            range.include(extrema.min);
            range.include(extrema.max);
        }
    }
}

fn value_at(section: &Section<'_>, joint: usize, quantity: Quantity, t: f64) -> f64 {
    let (piece, local) = section.result.trajectory.locate(t);
    let coefficients = section.result.trajectory.pieces.get(piece).and_then(|p| p.get(joint));
    coefficients.map_or(0.0, |c| polynomial::derivatives(c, local)[quantity.order()])
}

/// One joint's curve in pixels. Where the quantity jumps between pieces, the
/// curve has both values and so a vertical line.
fn curve(
    chart: &Chart<'_, '_>,
    section: &Section<'_>,
    joint: usize,
    quantity: Quantity,
) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for (start, length, coefficients) in pieces(section, joint) {
        let at = |local: f64| {
            let value = polynomial::derivatives(coefficients, local)[quantity.order()];
            chart.pixel(section.start + start + local, value)
        };
        points.push(at(0.0));
        // A straight line needs its ends only; others begin with several
        // parts, lest a symmetric swing look flat at its middle.
        let straight = coefficients.len() <= quantity.order() + 2;
        let width = length * chart.x.resolution();
        let parts = if straight { 1 } else { (width / 12.0).clamp(1.0, 16.0) as usize };
        for part in 0..parts {
            let end = |k: usize| length * k as f64 / parts as f64;
            let depth = if straight { 0 } else { 7 };
            refine(&at, end(part), end(part + 1), depth, &mut points);
        }
    }
    points
}

/// Adds points up to `b` until the curve is less than a fifth of a pixel away
/// from the lines between them.
fn refine(
    at: &impl Fn(f64) -> (f64, f64),
    a: f64,
    b: f64,
    depth: u32,
    points: &mut Vec<(f64, f64)>,
) {
    let middle = 0.5 * (a + b);
    let (start, half, end) = (at(a), at(middle), at(b));
    let sag = (half.1 - 0.5 * (start.1 + end.1)).abs();
    if depth == 0 || sag < 0.2 || end.0 - start.0 < 0.5 {
        points.push(end);
    } else {
        refine(at, a, middle, depth - 1, points);
        refine(at, middle, b, depth - 1, points);
    }
}
