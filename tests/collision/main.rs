//! Collision checks against an independent reference: parry3d in double precision, on random robots' states, motions and
//! solids. A false "free" would let a robot hit something.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says where")]

mod distances;
mod motions;
mod reference;
mod scenes;
mod states;
