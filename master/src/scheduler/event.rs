//! What happens to the scheduler and what it wants done.

use std::ops::Range;
use std::sync::Arc;

use selftalk_proto::UnitKey;
use selftalk_sim::{Draw, Genotype, TrialOutcome};

use super::audit::{Claim, Place};

/// A connected worker; a worker that reconnects gets a new one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PeerId(pub u64);

/// A unit of work: one genotype and a range of its trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Work {
    /// Identifies the unit by its content.
    pub key: UnitKey,
    /// The experiment, by a number that the service knows.
    pub experiment: u32,
    /// The generation for which it is evaluated.
    pub generation: u32,
    /// Object and target positions.
    pub draw: Draw,
    /// The genotype to be evaluated.
    pub genotype: Arc<Genotype>,
    /// The trials.
    pub trials: Range<u32>,
}

impl Work {
    /// The generation to which its outcomes belong.
    #[must_use]
    pub fn place(&self) -> Place {
        Place { experiment: self.experiment, replication: self.draw.replication, generation: self.generation }
    }
}

/// What can happen.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Units are to be evaluated. A unit that is open already is not opened again.
    Submitted(Vec<Arc<Work>>),
    /// A worker is connected and accepted.
    Joined {
        /// The connection.
        peer: PeerId,
        /// The worker's process, the same after a reconnect.
        instance: u64,
        /// Threads that simulate.
        slots: u32,
        /// Units it still holds from an earlier connection.
        holds: Vec<UnitKey>,
    },
    /// A worker said goodbye.
    Left(PeerId),
    /// The line to a worker is cut.
    Lost(PeerId),
    /// A worker is alive.
    Heard(PeerId),
    /// A worker does not take what is sent to it.
    Stalled(PeerId),
    /// A worker has evaluated a unit.
    Answered(PeerId, UnitKey, Vec<TrialOutcome>),
    /// A worker could not evaluate a unit.
    Failed(PeerId, UnitKey, String),
    /// The master has evaluated an answer again.
    Audited {
        /// The process that had answered.
        instance: u64,
        /// The number of its claim.
        serial: u64,
        /// Whether the answer was right.
        right: bool,
    },
    /// Units are held back from now on (true), or given out again.
    Paused(bool),
    /// The run is about to end: whoever has answered since it was last found right is looked into.
    Closing,
    /// Time has passed: milliseconds since some start.
    Tick(u64),
}

/// What is to be done, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// Send units to a worker, each with the number of times it has been given out, this time included.
    Lease(PeerId, Vec<(Arc<Work>, u32)>),
    /// Tell a worker that units need not be evaluated any more.
    Cancel(PeerId, Vec<UnitKey>),
    /// Cut the line to a worker that is forgotten from now on.
    Disconnect(PeerId, Cut),
    /// A unit has ended.
    Ended(UnitKey, Verdict),
    /// Evaluate an answer again; [`Event::Audited`] tells what came of it.
    Audit(Claim),
    /// Take back these generations and all after them: what a worker contributed to them is in doubt.
    Revoke(Vec<Place>),
    /// All answers of a process until now were looked into, by what its last one was.
    Cleared(u64),
}

/// Why the line to a worker is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// Nothing was heard from it for too long.
    Silent,
    /// The same worker has connected again.
    Replaced,
    /// An answer of its process was wrong.
    Wrong,
    /// It is alive, and others have had to evaluate all that it was given for a long time.
    Hanging,
    /// It does not take what is sent to it.
    Stalled,
    /// It sends too much that is of no use.
    Flooding,
}

/// How a unit ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// A worker has evaluated it.
    Evaluated {
        /// The worker.
        by: PeerId,
        /// An outcome for each trial, in order.
        outcomes: Vec<TrialOutcome>,
    },
    /// It took too many workers with it; it counts as failed in every trial.
    SetAside {
        /// How many.
        losses: u32,
        /// What the last of them said, if it could say anything.
        reason: Option<String>,
    },
}
