//! Prints the share of wall time that workers spend simulating, from a real run.
//!
//! `cargo bench -p selftalk-tests --bench utilisation [-- GENERATIONS [PRESET]]` runs a few generations of the
//! `elementary` preset, all of its ten replications, with two workers. The aim is 95 % or more.
//!
//! A slot measures the time it is in the simulator. On a machine with fewer free cores than slots it also waits there
//! for a core. What other programs take does not show in the second number, on Linux: the share of the run's
//! processor time that goes to the slots; the rest is the master, the network, the database and the start.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::time::Instant;

use selftalk_tests::{Outcome, Place, processor_time_of_children};

const WORKERS: f64 = 2.0;

fn main() {
    // Cargo adds a `--bench`.
    let mut words = std::env::args().skip(1).filter(|word| !word.starts_with("--"));
    let generations = words.next().unwrap_or_else(|| "6".to_owned());
    let preset = words.next().unwrap_or_else(|| "elementary".to_owned());
    let run = format!("run {preset} --workers {WORKERS} --set generations={generations} -vv");
    // Finding the program may build it.
    let place = Place::new();
    place.run("--version").done();
    let (begin, before) = (Instant::now(), processor_time_of_children());
    let outcome = place.run(&run).done();
    let wall = begin.elapsed().as_secs_f64();
    let used = processor_time_of_children().zip(before).map(|(after, before)| after - before);
    let (simulated, on_core) = (values(&outcome, "simulated_ms="), values(&outcome, "on_core_ms="));
    assert_eq!(simulated.len(), WORKERS as usize, "{}", outcome.stderr);
    let share = simulated.iter().sum::<f64>() / 1e3 / WORKERS / wall;
    println!("{preset}, {generations} generations, {WORKERS} workers: {wall:.1} s");
    println!("share of wall time the workers simulate: {:.1} %", 100.0 * share);
    if let Some(used) = used {
        println!(
            "share of processor time the workers use: {:.1} %",
            100.0 * on_core.iter().sum::<f64>() / 1e3 / used
        );
    }
}

/// The values of a field in the slots' last words.
fn values(outcome: &Outcome, name: &str) -> Vec<f64> {
    let lines = outcome.stderr.lines().filter(|line| line.contains("a slot ends"));
    let value = |line: &str| line.split(name).nth(1)?.split(' ').next()?.parse().ok();
    lines.filter_map(value).collect()
}
