//! Planning as a library: published and independently computed values, and
//! certificates against dense sampling.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says where")]

mod bounds;
mod calibration;
mod cells;
mod certificates;
mod comparison;
mod dual_search;
mod ends;
mod extremes;
mod families;
mod family;
mod fastest;
mod first_generations;
mod golden;
mod honesty;
mod independent;
mod jerk_limited;
mod kernel;
mod limits;
mod motions;
mod moving_ends;
mod objectives;
mod optimizers;
mod paths;
mod planners;
mod poses;
mod reproduce;
mod samples;
mod snapshots;
mod state_to_state;
mod support;
mod tcp_speed;
mod timeline;
mod via;
mod watched;
