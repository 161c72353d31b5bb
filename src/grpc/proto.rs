//! The messages of `proto/takt/v1`, with clients and servers, as generated.

#![allow(missing_docs, clippy::all, reason = "generated; the .proto files document it")]

tonic::include_proto!("takt.v1");

/// The descriptors of all `.proto` files, encoded, for reflection.
pub const FILE_DESCRIPTOR_SET: &[u8] = tonic::include_file_descriptor_set!("takt.v1");
