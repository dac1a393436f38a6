//! A history is taken away as tables, and other programs can open what is written.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use selftalk::export::Topic;
use selftalk_tests::Place;
use serde_json::Value;
use sqlx::Connection;

const GENERATIONS: u64 = 3;

fn document(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name)).unwrap()
}

fn lines(place: &Place, name: &str) -> Vec<Vec<String>> {
    let text = String::from_utf8(place.read(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// The values of a column.
fn column(table: &[Vec<String>], name: &str) -> Vec<String> {
    let at = table[0].iter().position(|other| other == name).unwrap_or_else(|| panic!("no {name}"));
    table[1..].iter().map(|row| row[at].clone()).collect()
}

#[test]
fn the_tables_hold_what_history_lists() {
    let place = Place::with_history(GENERATIONS);
    let written = place.ask("export small --out tables");
    let rows: Vec<u64> = written.iter().map(|line| line["rows"].as_u64().unwrap()).collect();
    assert_eq!(rows[..2], [2 * GENERATIONS, 2 * GENERATIONS * 20]);
    for (line, topic) in written.iter().zip(["generations", "individuals", "trials"]) {
        assert_eq!(line["table"], topic);
        let table = lines(&place, line["file"].as_str().unwrap());
        assert_eq!(table.len() as u64, 1 + line["rows"].as_u64().unwrap());
    }

    let fitness = column(&lines(&place, "tables/generations.csv"), "best_fitness");
    for (fitness, line) in fitness.iter().zip(place.ask("history generations")) {
        assert_eq!(fitness.parse::<f64>().unwrap(), line["best_fitness"].as_f64().unwrap());
    }
    let individuals = lines(&place, "tables/individuals.csv");
    let ranks: Vec<u64> = column(&individuals, "rank").iter().map(|rank| rank.parse().unwrap()).collect();
    for generation in ranks.chunks(20) {
        let mut generation = generation.to_vec();
        generation.sort_unstable();
        assert_eq!(generation, (0..20).collect::<Vec<_>>());
    }

    // Every individual has the trials that it was evaluated by.
    let trials = lines(&place, "tables/trials.csv");
    let key = |table: &[Vec<String>], last: &str| -> Vec<String> {
        let columns = ["replication", "generation", last].map(|name| column(table, name));
        (0..columns[0].len()).map(|at| columns.each_ref().map(|column| &*column[at]).join("/")).collect()
    };
    let mut successes: BTreeMap<String, (u32, u32)> = BTreeMap::new();
    for (key, success) in key(&trials, "individual").into_iter().zip(column(&trials, "success")) {
        let (count, sum) = successes.entry(key).or_default();
        *count += 1;
        *sum += u32::from(success == "true");
    }
    for (key, expected) in key(&individuals, "evaluated_as").iter().zip(column(&individuals, "successes")) {
        assert_eq!(successes[key], (16, expected.parse().unwrap()), "{key}");
    }
}

#[test]
fn parquet_has_the_same_rows() {
    let place = Place::with_history(1);
    place.run("export --out csv --individuals best,small/0/0/3").done();
    place.run("export --out parquet --to parquet --individuals best,small/0/0/3").done();
    for topic in Topic::ALL.map(Topic::name) {
        let csv = lines(&place, &format!("csv/{topic}.csv"));
        let file = File::open(place.path(&format!("parquet/{topic}.parquet"))).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let schema = reader.metadata().file_metadata().schema_descr();
        let names: Vec<&str> = schema.columns().iter().map(|column| column.name()).collect();
        assert_eq!(names, csv[0], "{topic}");
        assert_eq!(reader.metadata().file_metadata().num_rows(), csv.len() as i64 - 1);
        for (row, line) in reader.get_row_iter(None).unwrap().zip(&csv[1..]) {
            let row = row.unwrap();
            for (at, field) in line.iter().enumerate() {
                let same = match field.parse::<f64>() {
                    Ok(number) => row.get_double(at).map_or_else(
                        |_| row.get_long(at).map_or(topic == "individuals", |long| long as f64 == number),
                        |double| double == number,
                    ),
                    Err(_) if field.is_empty() => true,
                    Err(_) => row.get_string(at).is_ok_and(|text| text == field) || row.get_bool(at).is_ok(),
                };
                assert!(same, "{topic}: {}: {field}", names[at]);
            }
        }
    }
    let signals = lines(&place, "csv/signals.csv");
    let steps = column(&signals, "step");
    assert_eq!(steps.iter().filter(|step| *step == "0").count(), 3 * 16, "three individuals, 16 trials");
}

#[test]
fn nothing_is_overwritten_without_a_word() {
    let place = Place::with_history(1);
    place.run("export --out out --tables generations").done();
    place.write("out/individuals.csv", "mine");
    let message = place.run("export --out out").refused(2);
    assert!(
        message.contains("generations.csv: is there already") && message.contains("--force"),
        "{message}"
    );
    place.run("export --out out --tables trials").done();
    assert_eq!(place.read("out/individuals.csv"), b"mine");
    place.run("export --out out --force").done();
    assert!(place.read("out/individuals.csv").starts_with(b"experiment,"));
    let message = place.run("export --out out --tables trials --individuals best").refused(2);
    assert!(message.contains("add `signals` to --tables"), "{message}");
    let message = place.run("export large --out other").refused(2);
    assert!(message.contains("there is: small") && !place.path("other").exists(), "{message}");
    place.write("file", "");
    let message = place.run("export --out file/x").refused(1);
    assert!(message.starts_with("file/x: "), "{message}");
}

#[test]
fn every_column_is_documented() {
    let document = document("export.md");
    for topic in Topic::ALL {
        let (_, section) = document.split_once(&format!("\n### {}\n", topic.name())).unwrap();
        let section = section.split("\n## ").next().unwrap().split("\n### ").next().unwrap();
        let documented: Vec<&str> = section
            .lines()
            .filter_map(|line| line.strip_prefix("| `")?.split(" | ").next())
            .flat_map(|names| names.split(", "))
            .map(|name| name.trim_matches('`'))
            .collect();
        let mut names: Vec<String> = Vec::new();
        for column in topic.columns().unwrap() {
            // A family of columns is documented by its first word.
            let family = |end: &str| Some(format!("{}_{end}", column.name.split_once('_')?.0));
            let known = |name: &String| documented.contains(&name.as_str());
            let families = ["JOINT", "SENSOR", "NEURON", "NUMBER"].into_iter().filter_map(family);
            let name = std::iter::once(column.name.to_string()).chain(families).find(known);
            let name = name.unwrap_or_else(|| panic!("{}: {} is not documented", topic.name(), column.name));
            if names.last() != Some(&name) {
                names.push(name);
            }
        }
        assert_eq!(names, documented, "{}", topic.name());
    }
}

/// The columns of every table and view of a database, by its name.
fn schema(path: &Path) -> BTreeMap<String, Vec<String>> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
        let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        let rows: Vec<(String, String)> = sqlx::query_as(
            "SELECT master.name, info.name FROM sqlite_master AS master, pragma_table_info(master.name) AS info \
             WHERE master.type IN ('table', 'view') ORDER BY master.name, info.cid",
        )
        .fetch_all(&mut connection)
        .await
        .unwrap();
        let mut schema: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (table, column) in rows {
            schema.entry(table).or_default().push(column);
        }
        schema
    })
}

#[test]
fn datasette_is_told_of_every_table_and_column() {
    let place = Place::with_history(1);
    let metadata: Value = serde_json::from_str(&document("datasette.json")).unwrap();
    let tables = metadata["databases"]["selftalk"]["tables"].as_object().unwrap();
    let mut schema = schema(&place.path("history.db"));
    assert_eq!(tables["_sqlx_migrations"], serde_json::json!({ "hidden": true }));
    schema.remove("_sqlx_migrations");
    assert_eq!(tables.len(), schema.len() + 1);
    for (name, columns) in schema {
        let table = &tables[&name];
        for key in ["title", "description"] {
            assert!(table[key].as_str().is_some_and(|text| !text.is_empty()), "{name}: {key}");
        }
        let described = table["columns"].as_object().unwrap();
        let mut names: Vec<&String> = described.keys().collect();
        names.sort();
        let mut columns: Vec<&String> = columns.iter().collect();
        columns.sort();
        assert_eq!(names, columns, "{name}");
        assert!(described.values().all(|text| text.as_str().is_some_and(|text| !text.is_empty())), "{name}");
        let units = table["units"].as_object();
        assert!(
            units.is_none_or(|units| units.keys().all(|column| described.contains_key(column))),
            "{name}"
        );
    }
}

/// Python that has these modules, if there is one: that of SELFTALK_PYTHON, or of the system.
fn python(modules: &str) -> Option<PathBuf> {
    let named = std::env::var_os("SELFTALK_PYTHON").map(PathBuf::from);
    let python = named.unwrap_or_else(|| "python3".into());
    let found = Command::new(&python).args(["-c", &format!("import {modules}")]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: no Python with {modules}; SELFTALK_PYTHON may name one");
    None
}

#[test]
fn the_document_s_snippets_read_the_tables() {
    let Some(python) = python("pandas, polars, pyarrow") else { return };
    let place = Place::with_history(GENERATIONS);
    place.run("export --out tables --to parquet").done();
    place.run("export --out tables --to csv").done();
    let document = document("export.md");
    let snippets: Vec<&str> =
        document.split("```python\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0)).collect();
    assert_eq!(snippets.len(), 2);
    for snippet in snippets {
        let csv = snippet.replace("read_parquet", "read_csv").replace("scan_parquet", "scan_csv");
        for text in [snippet.to_owned(), csv.replace(".parquet\"", ".csv\"")] {
            let output =
                Command::new(&python).current_dir(place.path("")).args(["-c", &text]).output().unwrap();
            assert!(output.status.success(), "{text}: {}", String::from_utf8_lossy(&output.stderr));
            assert!(String::from_utf8_lossy(&output.stdout).contains("small"));
        }
    }
}
