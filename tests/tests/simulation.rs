//! The real master and workers in a simulated network that goes wrong in every way: the history is the undisturbed one.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use selftalk_tests::simulation::{Course, disturbed, undisturbed};

/// Seeds of an ordinary run of the tests.
const SEEDS: u64 = 500;

/// Runs seeds on all cores, prints how it went, and returns what was done to hosts and lines altogether, and the seeds that
/// went wrong.
fn play(seeds: std::ops::Range<u64>) -> (u64, BTreeSet<(u64, String)>) {
    let expected = undisturbed().digests;
    let (next, faults) = (AtomicU64::new(seeds.start), AtomicU64::new(0));
    let recoveries = Mutex::new(Vec::<Duration>::new());
    let work = || {
        let mut wrong = BTreeSet::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return wrong;
            }
            match disturbed(seed) {
                Ok(Course { digests, .. }) if digests != expected => {
                    wrong.insert((seed, "the history is another one".to_owned()));
                }
                Ok(course) => {
                    faults.fetch_add(course.faults as u64, Ordering::Relaxed);
                    recoveries.lock().expect("no panic").extend(course.recoveries);
                }
                Err(error) => {
                    wrong.insert((seed, error));
                }
            }
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let wrong = thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no panic")).collect()
    });
    let (faults, mut recoveries) = (faults.into_inner(), recoveries.into_inner().expect("no panic"));
    recoveries.sort_unstable();
    println!(
        "{} seeds, {faults} faults, {} restarts of the master; a generation later: median {:?}, worst {:?}, simulated",
        seeds.end - seeds.start,
        recoveries.len(),
        recoveries.get(recoveries.len() / 2).copied().unwrap_or_default(),
        recoveries.last().copied().unwrap_or_default(),
    );
    (faults, wrong)
}

#[test]
fn the_history_is_the_same_whatever_happens_to_hosts_and_lines() {
    let (faults, wrong) = play(0..SEEDS);
    assert!(wrong.is_empty(), "of {SEEDS} seeds, these went wrong: {wrong:#?}");
    assert!(faults > SEEDS, "{faults} faults in {SEEDS} simulations");
}

/// `SELFTALK_SEEDS` says how many, 100 000 otherwise.
#[test]
#[ignore = "takes a night"]
fn the_history_is_the_same_for_a_night_of_seeds() {
    let count = std::env::var("SELFTALK_SEEDS").map_or(100_000, |count| count.parse().expect("a number"));
    let (_, wrong) = play(SEEDS..SEEDS + count);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_seed_plays_out_in_the_same_way_every_time() {
    // The master crashes in these while several lines are open, or faults go on after the last commit. One play leaves the
    // process with other task numbers than the one before, which once changed the next.
    for seed in [4, 6, 77, 80, 83, 91] {
        let once = disturbed(seed);
        for _ in 0..3 {
            assert_eq!(once, disturbed(seed), "seed {seed}");
        }
        let commits =
            once.expect("an end").events.iter().filter(|event| event.contains("generation")).count();
        assert_eq!(commits, 10);
    }
}
