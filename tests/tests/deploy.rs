//! What is in `deploy/` fits the programs, and is what systemd and Kubernetes take.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use selftalk_tests::{selftalk, worker};

fn deploy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../deploy")
}

/// The files of a kind in a folder of `deploy/`.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(deploy().join(folder)).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|of| of == extension));
    files.sort();
    files
}

/// What looks like an option, such as `--keys`.
fn options(text: &str) -> BTreeSet<String> {
    let is_part = |c: char| c.is_ascii_lowercase() || c == '-';
    let words = text.split(|c: char| !is_part(c));
    words.filter(|word| word.starts_with("--") && !word.ends_with('-')).map(str::to_owned).collect()
}

fn help(mut of: Command, words: &[&str]) -> String {
    String::from_utf8(of.args(words).arg("--help").output().unwrap().stdout).unwrap()
}

#[test]
fn programs_are_started_with_options_that_they_have() {
    let mut known = options(&help(selftalk(), &["serve"]));
    known.extend(options(&help(selftalk(), &["keys", "init"])));
    known.extend(options(&help(worker(), &[])));
    let composing = ["--build", "--scale"].map(str::to_owned);
    let mut count = 0;
    let manifests = files("kubernetes", "yaml")
        .into_iter()
        .chain(files("docker", "yaml"))
        .chain(files("systemd", "service"));
    for file in manifests {
        for option in options(&fs::read_to_string(&file).unwrap()) {
            assert!(known.contains(&option) || composing.contains(&option), "{}: {option}", file.display());
            count += 1;
        }
    }
    assert!(count > 10, "{count} options were found");
}

#[test]
fn systemd_takes_the_units_and_finds_them_well_shut() {
    if !Command::new("systemd-analyze").arg("--version").output().is_ok_and(|output| output.status.success())
    {
        eprintln!("skipped: there is no systemd-analyze");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let programs = Path::new(selftalk().get_program()).parent().unwrap().to_owned();
    for unit in files("systemd", "service") {
        // As if the programs were installed.
        let text = fs::read_to_string(&unit).unwrap().replace("/usr/local/bin", programs.to_str().unwrap());
        let unit = folder.path().join(unit.file_name().unwrap());
        fs::write(&unit, text).unwrap();
        let analyze = |words: &[&str]| {
            let output = Command::new("systemd-analyze").args(words).arg(&unit).output().unwrap();
            let said = [output.stdout, output.stderr].concat();
            assert!(
                output.status.success(),
                "{words:?} {}: {}",
                unit.display(),
                String::from_utf8_lossy(&said)
            );
        };
        analyze(&["verify"]);
        // Of 0 to 100: below 20 is what systemd calls OK.
        analyze(&["security", "--offline=true", "--threshold=20"]);
    }
}

/// Python with the validator, if there is one: that of SELFTALK_PYTHON, or of the system.
fn python() -> Option<PathBuf> {
    let python = PathBuf::from(std::env::var_os("SELFTALK_PYTHON").unwrap_or_else(|| "python3".into()));
    let there = Command::new(&python).args(["-c", "import kubernetes_validate"]).output();
    there.is_ok_and(|output| output.status.success()).then_some(python)
}

#[test]
fn kubernetes_takes_the_manifests() {
    let Some(python) = python() else {
        eprintln!("skipped: no Python with kubernetes-validate; SELFTALK_PYTHON may name one");
        return;
    };
    let mut manifests = files("kubernetes", "yaml");
    manifests.retain(|file| !file.ends_with("kustomization.yaml"));
    let folder = tempfile::tempdir().unwrap();
    // All together as kustomize makes them, where it is there.
    if let Ok(output) = Command::new("kubectl").arg("kustomize").arg(deploy().join("kubernetes")).output() {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let all = folder.path().join("all.yaml");
        fs::write(&all, output.stdout).unwrap();
        manifests.push(all);
    }
    let validate = ["-m", "kubernetes_validate", "--strict"];
    let output = Command::new(python).args(validate).args(&manifests).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}
