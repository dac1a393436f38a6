//! The real master and the real workers in a simulated network, from a seed.
//!
//! Everything runs in one thread and in simulated time: a master and one to three workers, hosts that are cut off from each
//! other, in one direction or both, lines that are held up, and hosts that crash and come back, all at moments that the
//! seed decides on. Nothing is simulated of the robot (`engine = "null"`), and the history is kept in memory. It
//! outlives the master, as a disk does.

mod faults;
mod hosts;
mod lines;
mod shelf;

use std::sync::Arc;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk::store::{HistoryDigest, MemoryStore, Store};
use selftalk_sim::Experiment;

use faults::{Plan, What};
use hosts::MASTER;
use lines::Lines;
use shelf::Shelf;

/// Simulated time is dealt out in pieces of this length.
const TICK: Duration = Duration::from_millis(5);
/// Simulated time after which it has not ended and never will.
const LIMIT: Duration = Duration::from_secs(900);

/// What is run: two replications whose generations take as many units as workers can hold, and more.
const EXPERIMENT: &str = "\
name = 'simulated'
engine = 'null'
replications = 2
generations = 5
evolution = { population = 24, parents = 6, offspring = 4, mutation = 0.001 }
";

/// How a simulation went.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Course {
    /// Digests of the replications' histories.
    pub digests: Vec<String>,
    /// What happened until the last commit, and when in simulated time: faults and commits. In which order the master
    /// takes leave of its workers afterwards is left to chance, in a crate that it is built on.
    pub events: Vec<String>,
    /// How often something was done to a host or a line until then.
    pub faults: usize,
    /// Simulated time from each restart of a crashed master to the next commit.
    pub recoveries: Vec<Duration>,
}

/// Runs a simulation without any faults.
///
/// # Panics
/// When it does not end.
#[must_use]
pub fn undisturbed() -> Course {
    play(0, &Plan::default()).expect("an end")
}

/// Runs the simulation of a seed.
///
/// # Errors
/// What went wrong, in words.
pub fn disturbed(seed: u64) -> Result<Course, String> {
    play(seed, &Plan::new(&mut ChaCha8Rng::seed_from_u64(seed)))
}

fn play(seed: u64, plan: &Plan) -> Result<Course, String> {
    let mut dice = ChaCha8Rng::seed_from_u64(!seed);
    let slowest = Duration::from_millis(dice.random_range(1..300));
    let mut network = turmoil::Builder::new();
    network
        .rng_seed(seed)
        .tick_duration(TICK)
        .simulation_duration(LIMIT)
        .min_message_latency(Duration::from_millis(1))
        .max_message_latency(slowest)
        // More than the workers have to say at once: a sender that has to wait for room is not what this is about.
        .tcp_capacity(4096)
        .enable_random_order();
    let mut network = network.build();

    let shelf = Shelf::new(Arc::new(MemoryStore::new()));
    let experiment =
        Experiment::from_toml("simulated.toml", EXPERIMENT, &[]).map_err(|error| error.to_string())?;
    let lines = Lines::default();
    hosts::add_master(&mut network, &lines, &shelf, &experiment);
    for worker in 0..plan.workers {
        hosts::add_worker(&mut network, worker, Duration::from_millis(dice.random_range(10..120)));
    }

    let mut faults = plan.faults.iter().peekable();
    let all = (experiment.replications * experiment.generations) as usize;
    let (mut happened, mut restarted, mut recoveries) = (0, None, Vec::new());
    while !shelf.is_finished() {
        while let Some(fault) = faults.next_if(|fault| fault.at <= network.elapsed()) {
            fault.happen(&mut network, &lines);
            if shelf.commits() < all {
                shelf.note(&format!("{:?}", fault.what), network.elapsed());
                happened += 1;
            }
            if matches!(&fault.what, What::Restart(host) if host == MASTER) {
                restarted = Some((network.elapsed(), shelf.commits()));
            }
        }
        network.step().map_err(|error| error.to_string())?;
        if let Some((at, before)) = restarted
            && shelf.commits() > before
        {
            recoveries.push(network.elapsed() - at);
            restarted = None;
        }
        if network.elapsed() > LIMIT {
            let last = shelf.events().split_off(shelf.events().len().saturating_sub(12));
            return Err(format!("{MASTER} has not finished after {LIMIT:?}; at last: {last:#?}"));
        }
    }
    Ok(Course { digests: digests(shelf.store()), events: shelf.events(), faults: happened, recoveries })
}

fn digests(store: &MemoryStore) -> Vec<String> {
    let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
    let stored = runtime.block_on(store.experiment("simulated")).expect("a history").expect("the experiment");
    let digest = |replication: &selftalk::store::StoredReplication| {
        let mut digest = HistoryDigest::new();
        store.generations(replication.id).iter().for_each(|record| digest.update(record));
        digest.finish()
    };
    stored.replications.iter().map(digest).collect()
}
