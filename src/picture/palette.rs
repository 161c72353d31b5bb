//! Colours that remain distinct for colour-blind readers.

use plotters::style::RGBColor;

/// Okabe and Ito's palette, 2008, without its yellow, which vanishes on white.
const BASE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
];

/// Text and whatever belongs to all joints.
pub(super) const INK: RGBColor = RGBColor(38, 38, 38);
/// Secondary text.
pub(super) const FADED: RGBColor = RGBColor(110, 110, 110);
/// Axes and waypoint lines.
pub(super) const LINE: RGBColor = RGBColor(160, 160, 160);
/// Grid.
pub(super) const GRID: RGBColor = RGBColor(229, 229, 229);

/// The colour of series `index`. After the palette's end it starts again
/// darker, then lighter, so that many joints still differ from neighbours.
pub(super) fn series(index: usize) -> RGBColor {
    let colour = BASE[index % BASE.len()];
    match (index / BASE.len()) % 3 {
        0 => colour,
        1 => mix(colour, RGBColor(0, 0, 0), 0.45),
        _ => lighter(colour),
    }
}

/// The same colour, faded towards white.
pub(super) fn lighter(colour: RGBColor) -> RGBColor {
    mix(colour, RGBColor(255, 255, 255), 0.5)
}

fn mix(a: RGBColor, b: RGBColor, share_b: f64) -> RGBColor {
    let channel =
        |a: u8, b: u8| (f64::from(a) * (1.0 - share_b) + f64::from(b) * share_b).round() as u8;
    RGBColor(channel(a.0, b.0), channel(a.1, b.1), channel(a.2, b.2))
}
