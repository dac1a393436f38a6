//! Compiles the .proto files with protox, so that no `protoc` has to be installed, and notes what is being built.

use std::path::Path;
use std::process::Command;

use prost::Message;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=proto");
    let files = protox::compile(["selftalk/v1/evaluation.proto", "selftalk/v1/operation.proto"], ["proto"])?;
    let folder = std::env::var("OUT_DIR")?;
    std::fs::write(Path::new(&folder).join("descriptors.bin"), files.encode_to_vec())?;
    tonic_prost_build::configure().compile_fds(files)?;
    let (target, profile) = (std::env::var("TARGET")?, std::env::var("PROFILE")?);
    println!("cargo::rustc-env=SELFTALK_BUILD={target}, {profile}{}", commit(&profile).unwrap_or_default());
    Ok(())
}

/// The commit that is being built, if it can be told: by who builds a package without the repository, or by git. In debug
/// builds nobody asks git, as everything would be built again with each commit.
fn commit(profile: &str) -> Option<String> {
    const REFERENCES: &str = "../.git/logs/HEAD";
    println!("cargo::rerun-if-env-changed=SELFTALK_COMMIT");
    let told = std::env::var("SELFTALK_COMMIT").ok().filter(|commit| !commit.is_empty());
    let commit = told.or_else(|| {
        if profile != "release" || !Path::new(REFERENCES).exists() {
            return None;
        }
        println!("cargo::rerun-if-changed={REFERENCES}");
        let output = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok()?;
        let commit = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| commit.trim().to_owned())
    })?;
    Some(format!(", commit {commit}"))
}
