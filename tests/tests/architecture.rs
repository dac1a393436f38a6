//! What ARCHITECTURE.md promises, as far as it can be told by reading the tree.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Which crates of ours each crate may be built on. The arrows point down only.
const ARROWS: [(&str, &[&str]); 6] = [
    ("sim-core", &[]),
    ("proto", &["selftalk-sim"]),
    ("worker", &["selftalk-proto", "selftalk-sim"]),
    ("master", &["selftalk-proto", "selftalk-sim", "selftalk-worker"]),
    ("tests", &["selftalk", "selftalk-proto", "selftalk-sim", "selftalk-worker"]),
    ("tests/fuzz", &["selftalk-tests"]),
];

/// The simulator's modules, the lowest first.
const SIMULATOR: &str = "scene genotype experiment stream robot controller physics behaviours caretaker body situation score trial null simulator \
     fingerprint";

/// What the simulator does not use.
const WAYS_OUT: &str = "std::env std::fs std::io std::net std::os std::process std::sync::mpsc std::thread std::time \
    thread_local OnceLock LazyLock Mutex RwLock tokio tracing println eprintln";

/// Tests of the simulator that ask another program.
const REFEREE: &str = "sim-core/src/physics/lockstep/tests/referee/";

/// What evolution and scheduler do not use.
const IMPURE: &str =
    "tokio tonic sqlx std::time std::fs std::net std::thread std::env Instant SystemTime async await";

/// Lines in a source file: beyond that it has more than one subject.
const LONGEST: usize = 450;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap()
}

/// The text files of the project, by their paths from the root with forward slashes.
fn files() -> BTreeMap<String, String> {
    let root = root();
    let paths = known_to_git(&root).unwrap_or_else(|| {
        let mut found = Vec::new();
        walk(&root, "", &mut found);
        found
    });
    let read = |path: String| {
        let bytes = fs::read(root.join(&path)).ok()?;
        Some((path, String::from_utf8(bytes).ok()?))
    };
    let files: BTreeMap<String, String> = paths.into_iter().filter_map(read).collect();
    for crate_folder in ARROWS.map(|(folder, _)| folder) {
        assert!(files.contains_key(&format!("{crate_folder}/Cargo.toml")), "{crate_folder} was not found");
    }
    files
}

/// Committed files and new ones that are not ignored; none where there is no git or no repository.
fn known_to_git(root: &Path) -> Option<Vec<String>> {
    let arguments = ["ls-files", "-z", "--cached", "--others", "--exclude-standard"];
    let output = Command::new("git").args(arguments).current_dir(root).output().ok()?;
    let list =
        String::from_utf8(output.stdout).ok().filter(|list| output.status.success() && !list.is_empty())?;
    Some(list.split_terminator('\0').map(str::to_owned).collect())
}

fn walk(root: &Path, folder: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(root.join(folder)).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        let path = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
        if !entry.file_type().unwrap().is_dir() {
            found.push(path);
        } else if name != ".git" && name != "target" {
            walk(root, &path, found);
        }
    }
}

fn sources(files: &BTreeMap<String, String>) -> impl Iterator<Item = (&String, &String)> {
    files.iter().filter(|(path, _)| path.ends_with(".rs"))
}

/// Whether `text` uses a name: as a whole word, as `name::...` or `...::name`.
fn names(text: &str, name: &str) -> bool {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(name)
        .any(|(at, _)| !text[..at].ends_with(word) && !text[at + name.len()..].starts_with(word))
}

/// The code without its comments, which may speak of what the code does not use.
fn code(text: &str) -> String {
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .fold(String::new(), |code, line| code + line + "\n")
}

/// A file must use none of these names. Groups of imports would hide them.
fn assert_without(path: &str, text: &str, forbidden: &str) {
    let code = code(text);
    assert!(!code.contains("std::{"), "{path}: import from std one module at a time");
    for name in forbidden.split_whitespace() {
        assert!(!names(&code, name), "{path} uses {name}");
    }
}

#[test]
fn crates_are_built_on_those_below_them_only() {
    let files = files();
    let members: BTreeSet<&str> = ARROWS.iter().map(|(folder, _)| *folder).collect();
    let found: BTreeSet<&str> = files.keys().filter_map(|path| path.strip_suffix("/Cargo.toml")).collect();
    assert_eq!(found, members, "a crate without its place in the order");
    for (folder, allowed) in ARROWS {
        for line in files[&format!("{folder}/Cargo.toml")].lines() {
            let name = line.split(['.', ' ', '=']).next().unwrap_or_default();
            let ours = name == "selftalk" || name.starts_with("selftalk-");
            assert!(!ours || allowed.contains(&name), "{folder} must not use {name}");
        }
    }
}

#[test]
fn the_simulator_has_no_way_out() {
    let files = files();
    let inside = |path: &str| path.starts_with("sim-core/src/") && !path.starts_with(REFEREE);
    for (path, text) in sources(&files).filter(|(path, _)| inside(path)) {
        assert_without(path, text, WAYS_OUT);
    }
}

#[test]
fn only_the_store_knows_sql() {
    let files = files();
    for (path, text) in sources(&files) {
        let store = path.starts_with("master/src/store/");
        // System tests look into the files that a program has left.
        let test = path.starts_with("tests/") || path.ends_with("tests.rs") || path.contains("/tests/");
        assert!(store || test || !names(&code(text), "sqlx"), "{path} knows of sqlx");
    }
}

#[test]
fn pure_modules_stay_pure() {
    let files = files();
    for folder in ["master/src/evolution/", "master/src/scheduler/", "master/src/statistics/"] {
        assert!(files.keys().any(|path| path.starts_with(folder)), "{folder} is gone");
        for (path, text) in sources(&files).filter(|(path, _)| path.starts_with(folder)) {
            assert_without(path, text, IMPURE);
        }
    }
    // The scheduler draws no random numbers either; its tests do.
    for (path, text) in sources(&files).filter(|(path, _)| path.starts_with("master/src/scheduler/")) {
        assert!(path.ends_with("tests.rs") || !names(&code(text), "rand"), "{path} uses rand");
    }
}

/// Files of `folder` must not name these modules of their crate.
fn assert_below(files: &BTreeMap<String, String>, folder: &str, module: &str, above: &[&str]) {
    let (file, folder) = (format!("{folder}/{module}.rs"), format!("{folder}/{module}/"));
    let mut found = sources(files).filter(|(path, _)| **path == file || path.starts_with(&folder)).peekable();
    assert!(found.peek().is_some(), "{file} is gone");
    // Tests put parts together that know nothing of each other.
    for (path, text) in found.filter(|(path, _)| !path.ends_with("tests.rs") && !path.contains("/tests/")) {
        let code = code(text);
        assert!(!code.contains("crate::{"), "{path}: import from one module at a time");
        for module in above {
            assert!(!names(&code, &format!("crate::{module}")), "{path} reaches up to {module}");
        }
    }
}

#[test]
fn a_module_of_the_simulator_knows_those_below_it_only() {
    let files = files();
    let modules: Vec<&str> = SIMULATOR.split(' ').collect();
    for (place, module) in modules.iter().enumerate() {
        assert_below(&files, "sim-core/src", module, &modules[place + 1..]);
    }
}

#[test]
fn a_module_of_the_master_knows_those_below_it_only() {
    let files = files();
    for (module, others) in [
        ("statistics", "evolution scheduler store service driver master retest results dashboard exit cli"),
        ("evolution", "scheduler store service driver master retest results dashboard exit cli"),
        ("scheduler", "evolution store service driver master retest results dashboard exit cli"),
        ("store", "scheduler service driver master retest results dashboard exit cli"),
        ("retest", "scheduler service driver master results dashboard exit cli"),
        (
            "replay",
            "evolution scheduler store service driver master retest results report export dashboard exit cli",
        ),
        (
            "picture",
            "evolution scheduler store service driver master retest results replay report export dashboard exit cli",
        ),
        (
            "weights",
            "evolution scheduler store service driver master retest results report export dashboard exit cli",
        ),
        (
            "export",
            "evolution scheduler store service driver master retest results report dashboard exit cli",
        ),
        ("results", "scheduler service driver master dashboard exit cli report"),
        ("report", "evolution scheduler store service driver master retest results dashboard exit cli"),
        ("service", "evolution driver master retest results dashboard exit cli"),
        ("driver", "master retest results dashboard exit cli"),
        ("dashboard", "scheduler master results report statistics export weights exit cli"),
        ("master", "retest results dashboard exit cli"),
        ("exit", "scheduler service driver master retest results dashboard cli"),
    ] {
        assert_below(&files, "master/src", module, &others.split(' ').collect::<Vec<_>>());
    }
}

#[test]
fn a_file_has_one_subject() {
    let files = files();
    let read_by_people = |path: &str| [".rs", ".proto", ".sql"].iter().any(|end| path.ends_with(end));
    for (path, text) in files.iter().filter(|(path, _)| read_by_people(path)) {
        let lines = text.lines().count();
        assert!(lines <= LONGEST, "{path} has {lines} lines, more than {LONGEST}");
    }
}

#[test]
fn no_file_knows_the_machine_it_was_written_on() {
    let files = files();
    let folders = ["work", "tmp", "root", "home", "Users"].map(|folder| format!("/{folder}/"));
    for (path, text) in &files {
        for (number, line) in (1..).zip(text.lines()) {
            for folder in &folders {
                // Not where it is the middle of a longer path or of an address.
                let begins =
                    |at: usize| !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-}$~)".contains(c));
                let named = line.match_indices(folder.as_str()).any(|(at, _)| begins(at));
                assert!(!named, "{path}:{number} names a folder of one machine: {line}");
            }
        }
    }
}
