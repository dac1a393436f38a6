//! The documentation holds together: every page is in the book, every link leads somewhere, and the commands' page is what the
//! commands say of themselves.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Component, Path, PathBuf};

use clap::{Command, CommandFactory};
use selftalk::cli::Cli;
use selftalk_tests::{Running, worker};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// All pages below a folder of the repository, by their paths in it.
fn pages(folder: &str) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.insert(path.strip_prefix(root()).unwrap().to_owned());
            }
        }
    }
    found
}

/// What a page links to, without what is in blocks of code.
fn links(text: &str) -> Vec<String> {
    let mut links = Vec::new();
    let prose: Vec<&str> = text.split("```").step_by(2).collect();
    for rest in prose.iter().flat_map(|prose| prose.split("](").skip(1)) {
        links.extend(rest.split([')', ' ']).next().map(str::to_owned));
    }
    links
}

/// A heading's anchor, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().trim().to_lowercase().replace(' ', "-")
}

fn anchors(text: &str) -> BTreeSet<String> {
    let prose = text.split("```").step_by(2);
    let headings = prose.flat_map(str::lines).filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

/// A path without `..` in it.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            other => plain.push(other),
        }
    }
    plain
}

#[test]
fn every_link_leads_somewhere() {
    let mut checked = 0;
    let mut dead = Vec::new();
    let mut all = pages("docs");
    all.extend(pages("deploy"));
    all.extend(["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(PathBuf::from));
    for page in all {
        let text = fs::read_to_string(root().join(&page)).unwrap();
        for link in links(&text).into_iter().filter(|link| !link.contains("://")) {
            checked += 1;
            let (path, fragment) = link.split_once('#').unwrap_or((&link, ""));
            let target = match path {
                "" => page.clone(),
                path => plain(&page.parent().unwrap().join(path)),
            };
            let there = root().join(&target);
            let found = if fragment.is_empty() {
                there.exists()
            } else {
                fs::read_to_string(there).is_ok_and(|text| anchors(&text).contains(fragment))
            };
            if !found {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(checked > 50, "{checked} links");
    assert!(dead.is_empty(), "{dead:#?}");
}

#[test]
fn every_page_is_in_the_book() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed: BTreeSet<PathBuf> =
        links(&summary).into_iter().map(|link| Path::new("docs").join(link)).collect();
    let mut there = pages("docs");
    assert!(there.remove(Path::new("docs/SUMMARY.md")));
    assert_eq!(listed, there);
}

const BEGIN: &str = "\
# Commands

What the commands say of themselves with `--help`; a test compares this page with it. Each has a manual page as well: `selftalk
man`.
";

/// Adds a command and those below it. Options that it shares with the one above are told there.
fn add(page: &mut String, name: &str, command: &Command) {
    let help = command.clone().bin_name(name).term_width(100).render_long_help().to_string();
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    write!(page, "\n## `{name}`\n\n```text\n{}\n```\n", lines.join("\n").trim_end()).unwrap();
    for part in command.get_subcommands().filter(|part| part.get_name() != "help") {
        add(page, &format!("{name} {}", part.get_name()), part);
    }
}

#[test]
fn the_commands_page_is_what_they_say() {
    let mut page = BEGIN.to_owned();
    add(&mut page, "selftalk", &Cli::command());
    let mut help = worker();
    help.arg("--help");
    let help = Running::start(help).end().done().stdout;
    let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
    write!(page, "\n## `selftalk-worker`\n\n```text\n{}\n```\n", lines.join("\n").trim_end()).unwrap();

    let path = root().join("docs/commands.md");
    if std::env::var_os("SELFTALK_WRITE").is_some() {
        fs::write(&path, &page).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    let differing = page.lines().zip(kept.lines()).find(|(now, kept)| now != kept);
    assert!(
        page == kept,
        "docs/commands.md is not what the commands say; SELFTALK_WRITE=1 cargo test --workspace book:: writes it. \
         First: {differing:?}"
    );
}
