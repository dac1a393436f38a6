//! Where the programs are.
//!
//! Cargo tells a test where the programs of its own package are, but these belong to others. It does build them: the
//! packages `selftalk` and `selftalk-worker` have an integration test `command_line`, and with a package's
//! integration test come its programs. Building that test once more here costs nothing after
//! `cargo test --workspace`, and after `cargo test --test system` it brings programs up to date that would be
//! missing or old. The packages are those of the whole workspace so that nothing is compiled twice with different
//! features.
//!
//! `SELFTALK_PROFILE=release` has the tests, however they were built, look into the programs of that profile.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The `selftalk` command.
#[must_use]
pub fn selftalk() -> Command {
    command("selftalk")
}

/// The `selftalk-worker` command.
#[must_use]
pub fn worker() -> Command {
    command("selftalk-worker")
}

/// Cargo, as it is in a shell. What the cargo that runs a test tells it of its package, build scripts of dependencies take for
/// told to them: everything that depends on those would be compiled again, and again by the next cargo from a shell.
#[must_use]
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into()));
    for (name, _) in std::env::vars_os() {
        let told = name
            .to_str()
            .is_some_and(|name| ["CARGO_PKG_", "CARGO_MANIFEST_"].iter().any(|of| name.starts_with(of)));
        if told {
            command.env_remove(name);
        }
    }
    command
}

fn command(name: &str) -> Command {
    let mut command = Command::new(folder().join(format!("{name}{}", std::env::consts::EXE_SUFFIX)));
    // What the developer has set must not change what is printed.
    command.env_remove("RUST_LOG").env_remove("RUST_BACKTRACE");
    command
}

/// The folder with the programs of the profile that is asked for, or that this test was built with.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        // Tests lie in <target>/<profile>/deps, and the folder of the profile `dev` is `debug`.
        let test = std::env::current_exe().unwrap();
        let own = test.parent().and_then(Path::parent).expect("a test lies in its profile's folder");
        let asked = std::env::var("SELFTALK_PROFILE").ok();
        let name = asked.as_deref().or_else(|| own.file_name()?.to_str()).unwrap_or("debug");
        let (profile, name) = if matches!(name, "dev" | "debug") { ("dev", "debug") } else { (name, name) };
        let folder = own.with_file_name(name);
        let built = cargo()
            .args(["test", "--quiet", "--no-run", "--workspace", "--test", "command_line"])
            .args([
                "--profile",
                profile,
                "--manifest-path",
                concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"),
            ])
            .arg("--target-dir")
            .arg(folder.parent().expect("a profile lies in the target folder"))
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        folder
    })
}
