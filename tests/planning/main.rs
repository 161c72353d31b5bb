//! Planning as a library: published and independently computed values, and
//! certificates against dense sampling.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says where")]

mod certificates;
mod extremes;
mod golden;
mod honesty;
mod kernel;
mod limits;
mod objectives;
mod optimizers;
mod snapshots;
mod support;
