//! Compiles the `.proto` files to Rust. protox reads them, so no protoc is needed.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

use prost::Message;

const PROTOS: &[&str] = &[
    "takt/v1/plan.proto",
    "takt/v1/planning.proto",
    "takt/v1/result.proto",
    "takt/v1/robot.proto",
];

fn main() -> Result<(), Box<dyn Error>> {
    // tonic's builder names no files to cargo: without these lines every build
    // would compile everything again.
    println!("cargo:rerun-if-changed=build.rs");
    for path in PROTOS {
        println!("cargo:rerun-if-changed=proto/{path}");
    }
    let descriptors = protox::compile(PROTOS, ["proto"])?;
    // Reflection serves the descriptors to clients that have no `.proto` files.
    let out_dir = PathBuf::from(env::var("OUT_DIR")?);
    fs::write(out_dir.join("takt.v1.bin"), descriptors.encode_to_vec())?;
    tonic_prost_build::configure().btree_map(".").compile_fds(descriptors)?;
    Ok(())
}
