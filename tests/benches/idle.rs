//! How idle workers are at the ends of generations: `cargo bench -p selftalk-tests --bench idle`.
//!
//! The master's own scheduler in simulated time, with 2, 64 and 1000 cores and 1, 10 and 40 replications side by side. A
//! worker has one slot. A unit takes 20 to 40 ms, a message half a millisecond, and the next generation is there a
//! millisecond after the last answer. Nothing else is simulated; the numbers are the same on every machine.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, VecDeque};
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk::scheduler::{Effect, Event, Limits, PeerId, Scheduler, Work};
use selftalk_proto::UnitKey;
use selftalk_sim::{Draw, Genotype, TrialOutcome};

/// Units of a generation: its distinct genotypes.
const UNITS: u32 = 100;
const GENERATIONS: u32 = 30;
/// Times in microseconds.
const UNIT: std::ops::Range<u64> = 20_000..40_000;
const MESSAGE: u64 = 500;
const SELECTION: u64 = 1_000;
const TICK: u64 = 250_000;
/// Generations of the whole study: ten replications of 1500 and four conditions of ten with 100.
const STUDY: f64 = 19_000.0;

/// A unit by its replication, generation and number.
type Unit = (u32, u32, u32);

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Tick,
    Submit { replication: u32, generation: u32 },
    Arrive { worker: usize, units: Vec<Unit> },
    Evaluated { worker: usize, unit: Unit },
    Answer { worker: usize, unit: Unit },
}

#[derive(Default)]
struct Worker {
    waiting: VecDeque<Unit>,
    busy: bool,
    worked: u64,
}

struct Simulation {
    scheduler: Scheduler,
    now: u64,
    events: BinaryHeap<Reverse<(u64, u64, What)>>,
    count: u64,
    workers: Vec<Worker>,
    /// Units left of each replication's generation.
    left: HashMap<u32, u32>,
    /// The open units by their keys.
    open: HashMap<UnitKey, Unit>,
    dice: ChaCha8Rng,
}

fn key((replication, generation, number): Unit) -> UnitKey {
    let mut bytes = [0; 16];
    bytes[0..4].copy_from_slice(&replication.to_le_bytes());
    bytes[4..8].copy_from_slice(&generation.to_le_bytes());
    bytes[8..12].copy_from_slice(&number.to_le_bytes());
    UnitKey::from_bytes(bytes)
}

impl Simulation {
    fn at(&mut self, time: u64, what: What) {
        self.count += 1;
        self.events.push(Reverse((time, self.count, what)));
    }

    fn submit(&mut self, replication: u32, generation: u32) {
        let genotype = |number: u32| Arc::new(Genotype::new([u16::try_from(number).expect("few units")]));
        let work = |number| {
            Arc::new(Work {
                key: key((replication, generation, number)),
                experiment: 0,
                generation,
                draw: Draw { replication, generation },
                genotype: genotype(number),
                trials: 0..1,
            })
        };
        self.left.insert(replication, UNITS);
        let units = (0..UNITS).map(|number| (replication, generation, number));
        self.open.extend(units.map(|unit| (key(unit), unit)));
        self.scheduler.handle(Event::Submitted((0..UNITS).map(work).collect()));
    }

    /// Lets a worker begin its next unit.
    fn begin(&mut self, number: usize) {
        let worker = &mut self.workers[number];
        if worker.busy {
            return;
        }
        let Some(unit) = worker.waiting.pop_front() else { return };
        let time = self.dice.random_range(UNIT);
        worker.busy = true;
        worker.worked += time;
        self.at(self.now + time, What::Evaluated { worker: number, unit });
    }

    fn happen(&mut self, what: What) {
        match what {
            What::Tick => {
                for worker in 0..self.workers.len() {
                    self.scheduler.handle(Event::Heard(PeerId(worker as u64)));
                }
                self.scheduler.handle(Event::Tick(self.now / 1000));
                self.at(self.now + TICK, What::Tick);
            }
            What::Submit { replication, generation } => self.submit(replication, generation),
            What::Arrive { worker, units } => {
                self.workers[worker].waiting.extend(units);
                self.begin(worker);
            }
            What::Evaluated { worker, unit } => {
                self.workers[worker].busy = false;
                self.at(self.now + MESSAGE, What::Answer { worker, unit });
                self.begin(worker);
            }
            What::Answer { worker, unit } => {
                let outcome = TrialOutcome { score: 0.0, success: false, steps: 1 };
                self.scheduler.handle(Event::Answered(PeerId(worker as u64), key(unit), vec![outcome]));
            }
        }
        for effect in self.scheduler.settle() {
            match effect {
                Effect::Lease(peer, units) => {
                    let units = units.iter().map(|(work, _)| self.open[&work.key]).collect();
                    self.at(self.now + MESSAGE, What::Arrive { worker: peer.0 as usize, units });
                }
                Effect::Cancel(peer, keys) => {
                    self.workers[peer.0 as usize].waiting.retain(|unit| !keys.contains(&key(*unit)));
                }
                Effect::Ended(ended, _) => self.end(ended),
                Effect::Disconnect(..) | Effect::Audit(_) | Effect::Revoke(_) | Effect::Cleared(_) => {}
            }
        }
    }

    fn end(&mut self, ended: UnitKey) {
        let (replication, generation, _) = self.open.remove(&ended).expect("an open unit");
        let left = self.left.get_mut(&replication).expect("a replication");
        *left -= 1;
        if *left == 0 {
            self.left.remove(&replication);
            if generation + 1 < GENERATIONS {
                self.at(self.now + SELECTION, What::Submit { replication, generation: generation + 1 });
            }
        }
    }
}

/// Wall time in seconds, and the share of the workers' time in which they had nothing to do.
fn run(cores: usize, replications: u32, limits: Limits) -> (f64, f64) {
    let mut simulation = Simulation {
        scheduler: Scheduler::new(limits),
        now: 0,
        events: BinaryHeap::new(),
        count: 0,
        workers: (0..cores).map(|_| Worker::default()).collect(),
        left: HashMap::new(),
        open: HashMap::new(),
        dice: ChaCha8Rng::seed_from_u64(1),
    };
    for worker in 0..cores as u64 {
        let joined = Event::Joined { peer: PeerId(worker), instance: worker, slots: 1, holds: Vec::new() };
        simulation.scheduler.handle(joined);
    }
    simulation.at(0, What::Tick);
    for replication in 0..replications {
        simulation.at(0, What::Submit { replication, generation: 0 });
    }
    let mut ended = 0;
    while let Some(Reverse((time, _, what))) = simulation.events.pop() {
        // Ticks would go on for ever.
        if what == What::Tick && simulation.left.is_empty() && simulation.events.is_empty() {
            break;
        }
        simulation.now = time;
        ended = if matches!(what, What::Answer { .. }) { time } else { ended };
        simulation.happen(what);
    }
    let worked: u64 = simulation.workers.iter().map(|worker| worker.worked).sum();
    let wall = ended as f64 / 1e6;
    (wall, 1.0 - worked as f64 / 1e6 / (wall * cores as f64))
}

fn main() {
    println!(
        "| cores | replications | idle | with batches of 16 throughout | seconds a generation of all | hours for the study |"
    );
    println!("|---|---|---|---|---|---|");
    for cores in [2, 64, 1000] {
        for replications in [1, 10, 40] {
            let (wall, idle) = run(cores, replications, Limits::default());
            let coarse = Limits { batch: 16, batches_a_slot: 1, ..Limits::default() };
            let (_, before) = run(cores, replications, coarse);
            let generation = wall / f64::from(GENERATIONS);
            let hours = STUDY / f64::from(replications) * generation / 3600.0;
            println!(
                "| {cores} | {replications} | {:.1} % | {:.1} % | {generation:.3} | {hours:.2} |",
                100.0 * idle,
                100.0 * before
            );
        }
    }
}
