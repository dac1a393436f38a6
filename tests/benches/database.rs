//! How large a history gets, and how soon it answers: `cargo bench -p selftalk-tests --bench database [-- REPLICATIONS
//! GENERATIONS]`.
//!
//! Makes a history of 40 replications of 1500 generations with `selftalk run` and two workers (`engine = "null"`: everything but
//! the simulator is real; some 20 minutes and 6 GB), then puts every question of `selftalk history` to it, each as a program of
//! its own, several times.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::path::Path;
use std::time::Instant;

use selftalk_tests::{Place, selftalk};

const TURNS: usize = 5;

/// Questions, with `LAST` for the last generation.
const QUESTIONS: [&str; 12] = [
    "experiments",
    "replications",
    "generations --experiment null --replication 0",
    "generations --experiment null --replication 0 --generation LAST",
    "generations --best",
    "generations",
    "individuals",
    "individuals --experiment null --replication 0 --generation LAST",
    "individuals --best",
    "lineage --experiment null --replication 0",
    "behaviours",
    "workers",
];

fn main() {
    // Cargo adds a `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let number = |place: usize, otherwise: u32| {
        words.get(place).map_or(otherwise, |word| word.parse().expect("a number"))
    };
    let (replications, generations) = (number(0, 40), number(1, 1500));
    let place = Place::new();
    place.write(
        "null.toml",
        format!(
            "name = 'null'\nengine = 'null'\nreplications = {replications}\ngenerations = {generations}\n\
             evolution.mutation = 0.005\n"
        ),
    );
    let history = place.path("history.db");
    let mut making = selftalk();
    making.arg("run").arg(place.path("null.toml")).arg("--db").arg(&history).args(["--dashboard", "off"]);
    let begin = Instant::now();
    let made = making.output().expect("the program");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    println!("made in {:.0} s", begin.elapsed().as_secs_f64());
    let bytes = std::fs::metadata(&history).expect("a history").len() as f64;
    let all = f64::from(replications) * f64::from(generations);
    println!(
        "{:.2} GB: {:.1} kB a generation, {:.1} MB a replication",
        bytes / 1e9,
        bytes / all / 1e3,
        bytes / f64::from(replications) / 1e6
    );
    ask(&history, generations - 1);
}

fn ask(history: &Path, last: u32) {
    let last = last.to_string();
    println!("| selftalk history | median | slowest |\n|---|---|---|");
    for question in QUESTIONS {
        let mut times: Vec<f64> = (0..TURNS)
            .map(|_| {
                let mut command = selftalk();
                command.arg("history").args(question.replace("LAST", &last).split(' '));
                command.arg("--db").arg(history).args(["--format", "csv"]);
                let begin = Instant::now();
                let output = command.output().expect("the program");
                assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
                1e3 * begin.elapsed().as_secs_f64()
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("| `{question}` | {:.0} ms | {:.0} ms |", times[TURNS / 2], times[TURNS - 1]);
    }
}
