//! The guide to a new behaviour: what it says is done, built and tested.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const GUIDE: &str = include_str!("../../docs/guide/new-behaviour.md");

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Runs a program to its end; none where it is not installed.
fn run(command: &mut Command) -> Option<Output> {
    let output = command.output().ok()?;
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}{said}", String::from_utf8_lossy(&output.stdout));
    Some(output)
}

/// All changes in the guide, as one patch. Git wants a line more before each file than people do.
fn patch() -> String {
    let blocks = GUIDE.split("```diff\n").skip(1);
    let lines: Vec<&str> =
        blocks.flat_map(|rest| rest.split("```\n").next().unwrap().split_inclusive('\n')).collect();
    let mut patch = String::new();
    for (at, line) in lines.iter().enumerate() {
        if let Some(file) = lines.get(at + 1).and_then(|next| next.trim_end().strip_prefix("+++ b/")) {
            patch.push_str(&format!("diff --git a/{file} b/{file}\n"));
            if line.trim_end() == "--- /dev/null" {
                patch.push_str("new file mode 100644\n");
            }
        }
        patch.push_str(line);
    }
    patch
}

/// A copy of the project with what the guide says; none where there is no git, or the project is not in one. It is in the same
/// place every time, as what cargo compiles of it depends on the place.
fn followed(name: &str) -> Option<PathBuf> {
    let root = root();
    if !root.join(".git").exists() {
        return None;
    }
    let tests = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = tests.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    let list = ["ls-files", "-z", "--cached", "--others", "--exclude-standard"];
    let listed = run(Command::new("git").current_dir(&root).args(list))?;
    for file in String::from_utf8(listed.stdout).unwrap().split_terminator('\0') {
        let copy = folder.join(file);
        // Of the repository and not in the folder: deleted and not yet committed.
        if root.join(file).exists() {
            fs::create_dir_all(copy.parent().unwrap()).unwrap();
            fs::copy(root.join(file), copy).unwrap();
        }
    }
    // Cargo tells packages of the same name and version apart by their places within their workspaces: what it compiles of
    // the copy would pass for what it has compiled of the project.
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let version = concat!("version = \"", env!("CARGO_PKG_VERSION"));
    assert_eq!(manifest.matches(version).count(), 1, "the version of the project");
    let renamed = manifest.replacen(version, &format!("{version}-{name}"), 1);
    fs::write(folder.join("Cargo.toml"), renamed).unwrap();
    let changes = folder.join("guide.patch");
    fs::write(&changes, patch()).unwrap();
    // The numbers of lines in the guide need not be right, what stands around the changes has to be.
    let mut apply = Command::new("git");
    apply.current_dir(&folder).args(["apply", "--recount", "guide.patch"]);
    // The project's own repository, in which the copy may lie, is not meant.
    run(apply.env("GIT_CEILING_DIRECTORIES", tests))?;
    fs::remove_file(changes).unwrap();
    Some(folder)
}

fn cargo(folder: &Path, arguments: &[&str]) -> String {
    // Tests lie in <target>/<profile>/deps; what the project is built on has been compiled there.
    let test = std::env::current_exe().unwrap();
    let target = test.ancestors().nth(3).unwrap();
    let mut command = selftalk_tests::cargo();
    command.current_dir(folder).args(arguments).env("CARGO_TARGET_DIR", target);
    String::from_utf8(run(&mut command).expect("cargo").stdout).unwrap()
}

#[test]
fn the_guide_to_a_new_behaviour_leads_to_one_whose_tests_pass() {
    let Some(folder) = followed("push") else {
        eprintln!("skipped: no git");
        return;
    };
    let said = cargo(&folder, &["test", "--workspace", "--test", "push"]);
    assert!(said.contains("test result: ok. 3 passed"), "{said}");
}

#[test]
#[ignore = "costs next to nothing only after clippy has been run"]
fn the_guide_to_a_new_behaviour_leaves_nothing_to_complain_about() {
    let Some(folder) = followed("push-lints") else {
        eprintln!("skipped: no git");
        return;
    };
    cargo(&folder, &["fmt", "--all", "--check"]);
    cargo(&folder, &["clippy", "--workspace", "--all-targets", "--all-features", "--", "-D", "warnings"]);
}
