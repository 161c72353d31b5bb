//! Numbers: polynomials and their exact extrema, lanes, seeded random streams.

pub mod lanes;
pub mod polynomial;
pub mod random;
pub mod singles;
pub mod statistics;
pub mod trigonometry;
