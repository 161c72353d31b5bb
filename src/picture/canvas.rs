//! An SVG drawing: lines and text in fractional pixels.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::palette;

/// The backend knows whole pixels only. Drawing this many times larger and
/// letting the view box shrink it keeps curves smooth.
const SUBPIXELS: f64 = 10.0;

/// Where text stands relative to its point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

/// How text looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextLook {
    pub(super) size: f64,
    pub(super) colour: RGBColor,
    pub(super) bold: bool,
}

impl TextLook {
    /// Of axes and legends.
    pub(super) const NORMAL: Self = Self { size: 12.0, colour: palette::INK, bold: false };
    /// Of notes.
    pub(super) const SMALL: Self = Self { size: 11.0, colour: palette::FADED, bold: false };
    /// Of the headline.
    pub(super) const TITLE: Self = Self { size: 16.0, colour: palette::INK, bold: true };
}

/// A drawing of fixed size.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// Draws a picture of `width` by `height` pixels. `description` is what
/// screen readers say.
pub(super) fn draw(
    width: f64,
    height: f64,
    description: &str,
    content: impl FnOnce(&Canvas<'_>),
) -> String {
    let mut svg = String::new();
    let size = (subpixels(width) as u32, subpixels(height) as u32);
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let canvas = Canvas { area };
        canvas.rectangle(0.0, 0.0, width, height, WHITE);
        content(&canvas);
        ignore(canvas.area.present());
    }
    let head = format!(r#"<svg width="{}" height="{}" "#, size.0, size.1);
    let shrunk = format!(
        r#"<svg width="{width}" height="{height}" role="img" aria-label="{}" "#,
        escaped(description)
    );
    svg.replacen(&head, &shrunk, 1)
}

/// The backend writes into a string, which cannot fail.
fn ignore<T, E>(_: Result<T, E>) {}

fn subpixels(pixels: f64) -> i32 {
    (pixels * SUBPIXELS).round() as i32
}

fn point((x, y): (f64, f64)) -> (i32, i32) {
    (subpixels(x), subpixels(y))
}

/// Text as XML and HTML take it, within and outside of quotes.
pub(super) fn escaped(text: &str) -> String {
    let text = printable(text);
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// XML has no control characters, not even escaped ones.
fn printable(text: &str) -> String {
    let xml =
        |c: char| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c };
    text.chars().map(xml).collect()
}

/// About how wide `text` is, pixels: there are no font metrics here.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    0.58 * size * text.chars().count() as f64
}

impl Canvas<'_> {
    fn style(colour: RGBColor, width: f64) -> ShapeStyle {
        ShapeStyle {
            color: colour.to_rgba(),
            filled: true,
            stroke_width: subpixels(width).unsigned_abs(),
        }
    }

    /// A line through all points.
    pub(super) fn polyline(&self, points: &[(f64, f64)], colour: RGBColor, width: f64) {
        let points: Vec<_> = points.iter().copied().map(point).collect();
        ignore(self.area.draw(&PathElement::new(points, Self::style(colour, width))));
    }

    /// A filled rectangle.
    pub(super) fn rectangle(&self, left: f64, top: f64, right: f64, bottom: f64, colour: RGBColor) {
        let corners = [point((left, top)), point((right, bottom))];
        ignore(self.area.draw(&Rectangle::new(corners, Self::style(colour, 0.0))));
    }

    /// A faint area; lines below shine through.
    pub(super) fn area(&self, outline: &[(f64, f64)], colour: RGBColor) {
        const OPACITY: f64 = 0.12;
        let outline: Vec<_> = outline.iter().copied().map(point).collect();
        ignore(self.area.draw(&Polygon::new(outline, colour.mix(OPACITY))));
    }

    /// A filled circle.
    pub(super) fn dot(&self, centre: (f64, f64), radius: f64, colour: RGBColor) {
        let style = Self::style(colour, 0.0);
        ignore(self.area.draw(&Circle::new(point(centre), subpixels(radius), style)));
    }

    /// A dashed horizontal line.
    ///
    /// The backend has no dashes, and an element for each would outweigh the
    /// curves. So all dashes are one polygon that runs from dash to dash along
    /// a baseline, there and back, where it has no area.
    pub(super) fn dashed(&self, left: f64, right: f64, y: f64, colour: RGBColor) {
        const DASH: f64 = 7.0;
        const GAP: f64 = 5.0;
        const THICKNESS: f64 = 1.2;
        let (top, bottom) = (y - 0.5 * THICKNESS, y + 0.5 * THICKNESS);
        let mut outline = Vec::new();
        let mut x = left;
        while x < right {
            let end = (x + DASH).min(right);
            outline.extend([(x, bottom), (x, top), (end, top), (end, bottom)].map(point));
            x += DASH + GAP;
        }
        ignore(self.area.draw(&Polygon::new(outline, Self::style(colour, 0.0))));
    }

    /// Text whose vertical middle is at the point.
    pub(super) fn text(&self, text: &str, at: (f64, f64), align: Align, look: TextLook) {
        self.draw_text(text, at, align, look, FontTransform::None);
    }

    /// Text that reads upwards, centred at the point.
    pub(super) fn upward_text(&self, text: &str, at: (f64, f64), look: TextLook) {
        self.draw_text(text, at, Align::Centre, look, FontTransform::Rotate270);
    }

    fn draw_text(
        &self,
        text: &str,
        at: (f64, f64),
        align: Align,
        look: TextLook,
        transform: FontTransform,
    ) {
        // The backend divides font sizes by 1.24, the height of a line.
        let size = look.size * SUBPIXELS * 1.24;
        let weight = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
        let horizontal = match align {
            Align::Left => HPos::Left,
            Align::Centre => HPos::Center,
            Align::Right => HPos::Right,
        };
        let style = TextStyle::from(("sans-serif", size, weight).into_font())
            .color(&look.colour)
            .transform(transform)
            .pos(Pos::new(horizontal, VPos::Center));
        ignore(self.area.draw(&Text::new(printable(text), point(at), style)));
    }
}
