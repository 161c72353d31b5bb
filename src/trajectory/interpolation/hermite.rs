//! The quintic between two states.

use crate::math::lanes::Lanes;
use crate::trajectory::kernel::Piece;

/// The quintic from `start` over `way`, with velocity and acceleration `from`
/// at its start and `to` at its end, all in the segment's own time.
#[inline(always)]
pub fn quintic_piece(start: Lanes, way: Lanes, from: [Lanes; 2], to: [Lanes; 2]) -> Piece {
    let [[v0, a0], [v1, a1]] = [from, to];
    [
        start,
        v0,
        a0 * 0.5,
        way * 10.0 - v1 * 4.0 - v0 * 6.0 - a0 * 1.5 + a1 * 0.5,
        way * -15.0 + v1 * 7.0 + v0 * 8.0 + a0 * 1.5 - a1,
        way * 6.0 - (v1 + v0) * 3.0 + (a1 - a0) * 0.5,
    ]
}
