//! The documents say what is there: every setting with its default, every table and view with its columns.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use selftalk_sim::Experiment;
use selftalk_sim::experiment::PRESETS;

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)).unwrap()
}

/// All migrations, the oldest first.
fn schema() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../migrations");
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|path| fs::read_to_string(path).unwrap()).collect()
}

/// The rows of a document's tables, with the heading they stand under.
fn rows(text: &str) -> Vec<(&str, Vec<&str>)> {
    let mut heading = "";
    let mut rows = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("##") {
            heading = title.trim_start_matches('#').trim();
        } else if let Some(row) = line.strip_prefix('|').and_then(|line| line.strip_suffix('|')) {
            rows.push((heading, row.split(" | ").map(str::trim).collect()));
        }
    }
    rows
}

#[test]
fn every_setting_is_documented_with_its_default() {
    let document = read("docs/experiment-file.md");
    let mut documented = BTreeMap::new();
    for (heading, cells) in rows(&document) {
        let Some(key) = cells[0].strip_prefix('`').and_then(|cell| cell.strip_suffix('`')) else { continue };
        let section =
            heading.strip_prefix("`[").and_then(|rest| rest.split_once("]`")).map(|(section, _)| section);
        let key = section.map_or_else(|| key.to_owned(), |section| format!("{section}.{key}"));
        documented.insert(key, cells[1].trim_matches('`').to_owned());
    }
    let mut settings = BTreeMap::new();
    let mut section = String::new();
    // Written out by the program itself, so a new setting cannot be forgotten here.
    for line in Experiment::default().to_toml().lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = format!("{}.", name.trim_end_matches(']'));
        } else if let Some((key, value)) = line.split_once(" = ") {
            settings.insert(format!("{section}{key}"), value.to_owned());
        }
    }
    assert!(settings.len() > 40, "{settings:?}");
    assert_eq!(documented, settings);
}

#[test]
fn every_preset_is_documented() {
    let document = read("docs/experiment-file.md");
    for preset in PRESETS {
        assert!(document.contains(&format!("- `{}`", preset.name)), "{}", preset.name);
    }
}

/// Names of a table's columns, as a migration creates it: each stands first in its line.
fn columns(body: &str) -> Vec<String> {
    let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_lowercase());
    body.lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(is_name)
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_table_and_column_is_documented() {
    let document = read("docs/database.md");
    let mut documented: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (heading, cells) in rows(&document) {
        let names = cells[0]
            .split(", ")
            .filter_map(|cell| cell.trim_matches('*').strip_prefix('`')?.strip_suffix('`'));
        documented.entry(heading.to_owned()).or_default().extend(names.map(str::to_owned));
    }
    let schema = schema();
    let tables: Vec<&str> = schema.split("CREATE TABLE ").skip(1).collect();
    assert!(!tables.is_empty());
    for table in tables {
        let (name, rest) = table.split_once(" (\n").unwrap();
        let (body, _) = rest.split_once("\n)").unwrap();
        assert_eq!(documented.get(name), Some(&columns(body)), "{name}");
    }
}

#[test]
fn every_view_and_its_columns_are_documented() {
    let document = read("docs/database.md");
    let schema = schema();
    let common = ["experiment", "replication", "experiment_id", "replication_id"];
    for view in schema.split("CREATE VIEW ").skip(1) {
        let (name, query) = view.split_once(" AS\n").unwrap();
        let row = rows(&document)
            .into_iter()
            .find(|(heading, cells)| *heading == "Views" && cells[0] == format!("`{name}`"));
        let (_, cells) = row.unwrap_or_else(|| panic!("{name} is not documented"));
        let (selected, _) = query.trim_start_matches("SELECT ").split_once("\nFROM").unwrap();
        // A column's name is the last word of its expression; commas end lines only.
        for column in selected.split(",\n").filter_map(|column| column.split([' ', '.', '\n']).next_back()) {
            let known = common.contains(&column) || cells[2].contains(&format!("`{column}`"));
            assert!(known || column == "*", "{name}.{column}");
        }
    }
}

#[test]
fn every_metric_is_documented() {
    let document = read("docs/dashboard.md");
    let source = read("master/src/dashboard/metrics.rs");
    let is_name = |word: &&str| word.starts_with("selftalk_") && !word.contains([' ', '{']);
    let names: Vec<&str> = source.split('"').filter(is_name).collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        assert!(document.contains(&format!("`{name}`")), "{name}");
    }
}
