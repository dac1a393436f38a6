//! What goes wrong, and when.

use std::time::Duration;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use turmoil::Sim;

use super::hosts::{MASTER, worker};
use super::lines::Lines;

/// Simulated time in which things go wrong; an undisturbed run takes about as long.
const BUSY: Duration = Duration::from_secs(8);

/// How many workers there are, and what goes wrong in the order of time.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) workers: u32,
    pub(super) faults: Vec<Fault>,
}

#[derive(Debug, Clone)]
pub(super) struct Fault {
    pub(super) at: Duration,
    pub(super) what: What,
}

#[derive(Debug, Clone)]
pub(super) enum What {
    /// What is sent between master and worker is lost.
    Cut(String),
    /// What the first sends to the second is lost; the other direction is whole.
    CutOneWay(String, String),
    /// What is sent between master and worker does not arrive before the line is whole again.
    Hold(String),
    Release(String),
    Repair(String),
    /// A host ends in the middle of whatever it does.
    Crash(String),
    /// It starts anew.
    Restart(String),
}

impl Default for Plan {
    fn default() -> Self {
        Self { workers: 2, faults: Vec::new() }
    }
}

impl Plan {
    pub(super) fn new(dice: &mut ChaCha8Rng) -> Self {
        let workers = dice.random_range(1..=3);
        // A unit that five workers are lost with is set aside, which is on record and changes the history. So many are
        // not lost here: each worker may be, whenever its line is cut, and that many more crash.
        let mut crashes = 4 - workers;
        let mut faults = Vec::new();
        let mut add = |at, what| faults.push(Fault { at, what });
        for _ in 0..dice.random_range(1..=8) {
            let at = BUSY.mul_f64(dice.random());
            // From some milliseconds to what both sides take for the end of the line.
            let until = at
                + Duration::from_millis(10 << dice.random_range(0..12)).mul_f64(1.0 + dice.random::<f64>());
            let name = worker(dice.random_range(0..workers));
            match dice.random_range(0..7) {
                0 | 1 => {
                    add(at, What::Cut(name.clone()));
                    add(until, What::Repair(name));
                }
                2 => {
                    let (from, to) = if dice.random() {
                        (name.clone(), MASTER.to_owned())
                    } else {
                        (MASTER.to_owned(), name.clone())
                    };
                    add(at, What::CutOneWay(from, to));
                    add(until, What::Repair(name));
                }
                3 => {
                    add(at, What::Hold(name.clone()));
                    add(until, What::Release(name));
                }
                4 | 5 => {
                    add(at, What::Crash(MASTER.to_owned()));
                    add(until, What::Restart(MASTER.to_owned()));
                }
                _ if crashes > 0 => {
                    crashes -= 1;
                    add(at, What::Crash(name.clone()));
                    add(until, What::Restart(name));
                }
                _ => {}
            }
        }
        faults.sort_by_key(|fault| fault.at);
        Self { workers, faults }
    }
}

impl Fault {
    pub(super) fn happen(&self, network: &mut Sim<'_>, lines: &Lines) {
        match &self.what {
            What::Cut(name) => network.partition(MASTER, name.as_str()),
            What::CutOneWay(from, to) => network.partition_oneway(from.as_str(), to.as_str()),
            What::Hold(name) => network.hold(MASTER, name.as_str()),
            What::Release(name) => network.release(MASTER, name.as_str()),
            What::Repair(name) => network.repair(MASTER, name.as_str()),
            What::Crash(name) => lines.crash(|| network.crash(name.as_str())),
            What::Restart(name) => lines.crash(|| network.bounce(name.as_str())),
        }
    }
}
