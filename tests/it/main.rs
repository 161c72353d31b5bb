//! Takt from the outside, a module per area.

mod bad_requests;
mod http;
mod http_results;
mod support;
