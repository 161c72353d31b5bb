//! Takt plans robot trajectories: as fast as the limits allow, certified over
//! continuous time, repeatable from a seed.
//!
//! The folders are the architecture; a module imports only from layers below
//! its own. `docs/ARCHITECTURE.md` is the map and `tests/architecture.rs`
//! holds the crate to it.

pub mod budget;
pub mod fault;
pub mod math;

pub mod geometry;
pub mod optimize;
pub mod planner;

pub mod robot;
pub mod scene;

pub mod collision;
pub mod trajectory;

pub mod plan;

pub mod job;
pub mod picture;

pub mod reproduce;
pub mod service;
pub mod store;

pub mod grpc;
pub mod http;

pub mod app;
pub mod cli;
pub mod config;
