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

/// What the document has about settings, by their dotted keys: default, range and meaning.
fn documented_settings() -> BTreeMap<String, [String; 3]> {
    let document = read("docs/experiment-file.md");
    let mut documented = BTreeMap::new();
    for (heading, cells) in rows(&document) {
        let Some(key) = cells[0].strip_prefix('`').and_then(|cell| cell.strip_suffix('`')) else { continue };
        let section =
            heading.strip_prefix("`[").and_then(|rest| rest.split_once("]`")).map(|(section, _)| section);
        let key = section.map_or_else(|| key.to_owned(), |section| format!("{section}.{key}"));
        let [default, range, meaning] = [1, 2, 3].map(|cell| cells.get(cell).copied().unwrap_or_default());
        documented.insert(key, [default.trim_matches('`'), range, meaning].map(str::to_owned));
    }
    documented
}

/// The lines of the default experiment as the program itself writes it out, so that no setting can be forgotten: each with
/// the dotted key of the setting it has, if it has one.
fn default_lines() -> Vec<(String, Option<String>)> {
    let mut section = String::new();
    let toml = Experiment::default().to_toml();
    let lines = toml.lines().map(|line| {
        if let Some(name) = line.strip_prefix('[') {
            section = format!("{}.", name.trim_end_matches(']'));
        }
        let key = line.split_once(" = ").map(|(key, _)| format!("{section}{key}"));
        (line.to_owned(), key)
    });
    lines.collect()
}

#[test]
fn every_setting_is_documented_with_its_default() {
    let documented: BTreeMap<String, String> =
        documented_settings().into_iter().map(|(key, [default, ..])| (key, default)).collect();
    let setting = |(line, key): (String, Option<String>)| {
        line.split_once(" = ").and_then(|(_, value)| Some((key?, value.to_owned())))
    };
    let settings: BTreeMap<String, String> = default_lines().into_iter().filter_map(setting).collect();
    assert!(settings.len() > 40, "{settings:?}");
    assert_eq!(documented, settings);
}

/// What is documented of a key. Where four behaviours have the same key, what it means stands with the first.
fn explained(documented: &BTreeMap<String, [String; 3]>, key: &str) -> Option<[String; 3]> {
    let [default, range, meaning] = documented.get(key)?.clone();
    let first = || Some(format!("reach.{}", key.split_once('.')?.1));
    let meaning = Some(meaning)
        .filter(|meaning| !meaning.is_empty())
        .or_else(|| Some(documented.get(&first()?)?[2].clone()))?;
    Some([default, range, meaning])
}

/// A comment in lines that are not too long.
fn comment(text: &str) -> String {
    let mut comment = String::new();
    let mut line = "#".to_owned();
    for word in text.split_whitespace() {
        if line.len() + 1 + word.len() > 110 {
            comment.push_str(&std::mem::replace(&mut line, "#".to_owned()));
            comment.push('\n');
        }
        line.push(' ');
        line.push_str(word);
    }
    comment + &line + "\n"
}

#[test]
fn there_is_an_experiment_file_with_a_comment_on_every_key() {
    let documented = documented_settings();
    let mut text = comment(
        "An experiment with all its settings, as they are where a file says nothing. A file needs only those that are \
         others: copy this one, keep what you change.",
    );
    for (line, key) in default_lines() {
        if let Some([_, range, meaning]) = key.and_then(|key| explained(&documented, &key)) {
            text.push('\n');
            text.push_str(&comment(&format!("{} ({range})", meaning.trim_end_matches('.'))));
        }
        text.push_str(&line);
        text.push('\n');
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/guide/experiment.toml");
    if std::env::var_os("SELFTALK_WRITE").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == text,
        "docs/guide/experiment.toml is not what docs/experiment-file.md says; \
         SELFTALK_WRITE=1 cargo test --workspace documents:: writes it"
    );
    assert_eq!(Experiment::from_toml("experiment.toml", &kept, &[]).unwrap(), Experiment::default());
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
        let mut expected = columns(body);
        let addition = format!("ALTER TABLE {name} ADD COLUMN ");
        let added = schema.split(&addition).skip(1);
        expected.extend(added.map(|rest| rest.split(' ').next().unwrap().to_owned()));
        assert_eq!(documented.get(name), Some(&expected), "{name}");
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
