//! Takt from the outside, a module per area.

mod bad_requests;
mod grpc;
mod grpc_support;
mod http;
mod http_results;
mod support;
