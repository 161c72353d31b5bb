//! Takt from the outside, a module per area.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod bad_requests;
mod cells;
mod comparisons;
mod families;
mod grpc;
mod grpc_support;
mod http;
mod http_results;
mod operations;
mod paths;
mod support;
