//! `--format json` of every command is what docs/json.md promises.

use std::collections::BTreeMap;

use clap::CommandFactory;
use selftalk::cli::Cli;
use selftalk_tests::{Place, wait_until};
use serde_json::Value;

const DOCUMENT: &str = include_str!("../../docs/json.md");

/// A field and its type, as they are documented.
type Field = (String, String);

/// The documented fields by command, in their order.
fn documented() -> BTreeMap<String, Vec<Field>> {
    let sections = DOCUMENT.split("\n## `selftalk ").skip(1);
    let field = |line: &str| {
        let mut cells = line.strip_prefix("| `")?.split(" | ");
        Some((cells.next()?.trim_end_matches('`').to_owned(), cells.next()?.to_owned()))
    };
    let section = |section: &str| {
        let (command, rest) = section.split_once("`\n").unwrap();
        (command.to_owned(), rest.lines().filter_map(field).collect())
    };
    sections.map(section).collect()
}

fn is(value: &Value, of: &str) -> bool {
    match of.strip_suffix(" or null") {
        Some(of) => value.is_null() || is(value, of),
        None => match of {
            "string" => value.is_string(),
            "integer" => value.is_i64() || value.is_u64(),
            "number" => value.is_number(),
            "boolean" => value.is_boolean(),
            "array of integers" => {
                value.as_array().is_some_and(|values| values.iter().all(|value| value.is_u64()))
            }
            other => panic!("what is `{other}`?"),
        },
    }
}

/// Compares what was printed with what is documented.
fn check(command: &str, stdout: &str, fields: &[Field]) {
    let objects: Vec<Value> = serde_json::from_str(stdout).unwrap();
    assert!(!objects.is_empty(), "{command} printed nothing to compare");
    let expected: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
    // In the order in which they are printed, which a map would lose.
    let line = stdout.lines().nth(1).unwrap().trim().trim_end_matches(',');
    let mut places: Vec<(usize, &str)> =
        expected.iter().filter_map(|name| Some((line.find(&format!("\"{name}\":"))?, *name))).collect();
    places.sort_unstable();
    assert_eq!(places.iter().map(|(_, name)| *name).collect::<Vec<_>>(), expected, "{command}: {line}");
    for object in &objects {
        let object = object.as_object().unwrap();
        assert_eq!(object.len(), expected.len(), "{command}: {object:?}");
        for (name, of) in fields {
            assert!(is(&object[name], of), "{command}: {name} is to be {of}: {object:?}");
        }
    }
}

#[test]
fn every_command_prints_the_fields_that_are_documented() {
    let place = Place::with_history(3);
    let all = "--set replications=1 --set generations=2 --set evolution.population=10 --set evolution.parents=2 \
               --set physics.substeps=4 --set move_to_target.steps=6";
    place.run(&format!("run integrated-le --ancestors none --db second.db {all}")).done();
    place.run("results small --out kept --trials 16").done();
    place.run("run small.toml --set name=other --set generations=3 --seed 8").done();
    place.write("operators", "operators-token-0123456789");
    let mut master =
        place.start("serve --listen 127.0.0.1:0 --operator-token-file operators small.toml --db served.db");
    let operators = format!("--master http://{} --token-file operators", master.address());
    // Held up, so that it is still there when it is asked.
    place.run(&format!("operate pause {operators}")).done();
    let _worker = place.start_worker(&master.address());
    wait_until("the worker", || {
        (!place.ask(&format!("operate workers {operators}")).is_empty()).then_some(())
    });
    let commands = [
        ("history experiments", ""),
        ("history replications", ""),
        ("history generations", ""),
        ("history individuals", ""),
        ("history lineage", ""),
        ("history behaviours", ""),
        ("history behaviours --curves", ""),
        ("history workers", ""),
        ("show", "best --replication 0"),
        ("show --weights", "best --replication 0"),
        ("evaluate", "best --replication 0 --trials 16"),
        ("evaluate --why", "best --replication 0 --trials 16"),
        ("evaluate --post", "--db second.db"),
        ("generalise", "--db second.db"),
        ("compare", ""),
        ("transfer", "best --replication 0 --experiment small --trials 16"),
        ("verify", "--experiment small --best"),
        ("verify --results", "kept"),
        ("export", "--out tables --individuals best"),
        ("backup", "copy.db"),
        ("digest", ""),
        ("operate standings", &operators),
        ("operate workers", &operators),
    ];
    let documented = documented();
    let mut names: Vec<&str> = commands.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    assert_eq!(names, documented.keys().map(String::as_str).collect::<Vec<_>>());
    for (name, rest) in commands {
        let stdout = place.run(&format!("{name} {rest} --format json")).done().stdout;
        check(name, &stdout, &documented[name]);
    }
    // They end with what `history replications` lists.
    let fields = &documented["history replications"];
    let extend = "extend third --generations 2";
    for command in ["run small.toml --set name=third --set generations=1", "resume small", extend] {
        let stdout = place.run(&format!("{command} --format json")).done().stdout;
        check(command, &stdout, fields);
    }
}

#[test]
fn no_command_is_left_out() {
    let documented = documented();
    let (_, silent) = DOCUMENT.split_once("Commands that write files print no data:").unwrap();
    let silent = silent.split("\n## ").next().unwrap();
    let known = |name: &str| {
        let begins = |command: &String| command == name || command.starts_with(&format!("{name} --"));
        documented.keys().any(begins) || silent.contains(&format!("`{name}`"))
    };
    for command in Cli::command().get_subcommands() {
        let name = command.get_name();
        if command.has_subcommands() {
            for part in command.get_subcommands() {
                assert!(
                    known(&format!("{name} {}", part.get_name())),
                    "{name} {} is not documented",
                    part.get_name()
                );
            }
        } else if !["run", "serve", "resume", "extend", "help"].contains(&name) {
            assert!(known(name), "{name} is not documented in docs/json.md");
        }
    }
}

#[test]
fn logs_are_json_if_that_is_asked_for() {
    let place = Place::new();
    let outcome = place.run("run small.toml --set generations=1 -vv --log json").done();
    let logs: Vec<Value> = outcome
        .stderr
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!(!logs.is_empty(), "{}", outcome.stderr);
    for log in logs {
        for key in ["timestamp", "level", "target"] {
            assert!(log[key].is_string(), "{log}");
        }
        assert!(log["fields"]["message"].is_string(), "{log}");
    }
    // stderr is no terminal here.
    for (option, coloured) in [("", false), ("--color always", true), ("--color never", false)] {
        let name = format!("again{}", option.len());
        let words = format!("run small.toml --set generations=1 --set name={name} -vv {option}");
        assert_eq!(place.run(&words).done().stderr.contains('\u{1b}'), coloured, "{option}");
    }
}
