//! Prints the share of wall time that workers spend simulating, from a real run.
//!
//! `cargo bench -p selftalk-tests --bench utilisation [-- GENERATIONS [PRESET]]` runs a few generations of the
//! `elementary` preset, all of its ten replications, with two workers. The aim is 95 % or more.
//!
//! A slot measures the time it is in the simulator. On a machine with fewer free cores than slots it also waits there
//! for a core; the time on a core is given as well, and is what a machine loaded by other things falls short in.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::time::Instant;

use selftalk_tests::{Outcome, Place};

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
    let begin = Instant::now();
    let outcome = place.run(&run).done();
    let wall = begin.elapsed().as_secs_f64() * WORKERS;
    let sum = |name| values(&outcome, name).iter().sum::<f64>();
    let (simulated, on_core) = (sum("simulated_ms=") / 1e3, sum("on_core_ms=") / 1e3);
    let shares = values(&outcome, "share=");
    assert_eq!(shares.len(), WORKERS as usize, "{}", outcome.stderr);
    let between = shares.iter().sum::<f64>() / WORKERS;
    println!("{preset}, {generations} generations, {WORKERS} workers: {:.1} s", wall / WORKERS);
    println!("share of wall time the workers simulate: {:.1} %", 100.0 * simulated / wall);
    println!("  between their first and last trial:    {:.1} %", 100.0 * between);
    println!("  and are on a core:                     {:.1} %", 100.0 * on_core / wall);
}

/// The values of a field in the slots' last words.
fn values(outcome: &Outcome, name: &str) -> Vec<f64> {
    let lines = outcome.stderr.lines().filter(|line| line.contains("a slot ends"));
    let value = |line: &str| line.split(name).nth(1)?.split(' ').next()?.parse().ok();
    lines.filter_map(value).collect()
}
