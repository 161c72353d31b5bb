//! Planning as a library: published and independently computed values, and
//! certificates against dense sampling.

mod certificates;
mod golden;
mod limits;
mod support;
