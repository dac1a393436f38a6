//! Compiles the .proto file of replays with protox, so that no `protoc` has to be installed. The migrations are compiled
//! in: build again when one is added.

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=../migrations");
    println!("cargo::rerun-if-changed=src/replay/mcap/foxglove.proto");
    let mut compiler = protox::Compiler::new(["src/replay/mcap"])?;
    compiler.include_imports(true).include_source_info(false).open_file("foxglove.proto")?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo says where to write")?);
    std::fs::write(out.join("foxglove.bin"), compiler.encode_file_descriptor_set())?;
    prost_build::Config::new().compile_fds(compiler.file_descriptor_set())?;
    Ok(())
}
