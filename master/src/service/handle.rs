//! The hub as others see it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use selftalk_proto::{FromMaster, SLOT_LIMIT, UnitKey};
use selftalk_sim::TrialOutcome;
use tokio::sync::{mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;

use super::floor::Floor;
use crate::scheduler::{Event, PeerId, Place, Work};
use crate::store::WorkerId;

/// How a submitted unit ended.
#[derive(Debug, Clone, PartialEq)]
pub enum UnitEnd {
    /// It was evaluated.
    Evaluated {
        /// An outcome for each trial, in order.
        outcomes: Vec<TrialOutcome>,
        /// Who evaluated it, if that is still known.
        worker: Option<WorkerId>,
    },
    /// It took too many workers with it.
    SetAside {
        /// How many.
        losses: u32,
        /// What the last of them said, if it could say anything.
        reason: Option<String>,
    },
}

/// The workers that are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crew {
    /// Workers.
    pub workers: u32,
    /// Their slots, together.
    pub slots: u32,
}

/// What came of looking into answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finding {
    /// A worker has answered wrongly: what it has contributed to is to be taken back. Of each replication the first generation.
    Wrong(Vec<Place>),
    /// Workers that have left, and whose last answers were right.
    Right(Vec<WorkerId>),
}

/// What is found by looking into answers.
#[derive(Debug)]
pub struct Findings(pub(super) mpsc::UnboundedReceiver<Finding>);

impl Findings {
    /// The next one. Waits for ever if there is none.
    pub async fn next(&mut self) -> Finding {
        match self.0.recv().await {
            Some(finding) => finding,
            None => std::future::pending().await,
        }
    }

    /// The next one, if it is known now.
    pub fn known(&mut self) -> Option<Finding> {
        self.0.try_recv().ok()
    }
}

/// What the hub is told.
#[derive(Debug)]
pub(super) enum Command {
    Register { experiment: u32, toml: String },
    Submit { works: Vec<Arc<Work>>, ends: mpsc::UnboundedSender<(UnitKey, UnitEnd)> },
    Joined { peer: PeerId, instance: u64, slots: u32, holds: Vec<UnitKey>, line: Line },
    Events(Vec<Event>),
    Pause(bool),
    Closing { closed: oneshot::Sender<Vec<WorkerId>> },
    Farewell { finished: bool },
}

/// The way to a connected worker.
#[derive(Debug)]
pub(super) struct Line {
    /// What it does not take soon piles up in here, up to [`Line::ROOM`] messages.
    pub(super) outgoing: mpsc::Sender<FromMaster>,
    pub(super) worker: WorkerId,
    /// What it is called in the history: its machine and process.
    pub(super) name: Arc<str>,
    pub(super) host: Arc<str>,
    /// Cancelled to cut the connection.
    pub(super) cut: CancellationToken,
}

impl Line {
    /// Messages that may wait to be sent to a worker: twice as many as it takes to fill up the largest one.
    pub(super) const ROOM: usize = 4 * SLOT_LIMIT as usize + 64;
}

/// Brings work to the hub. Cheap to clone; the hub ends when all handles are gone.
#[derive(Debug, Clone)]
pub struct Handle {
    pub(super) commands: mpsc::Sender<Command>,
    pub(super) crew: watch::Receiver<Crew>,
    pub(super) floor: watch::Receiver<Floor>,
    pub(super) experiments: Arc<AtomicU32>,
    pub(super) peers: Arc<AtomicU64>,
}

impl Handle {
    /// Makes an experiment known; units refer to it by the number that is returned.
    pub async fn register(&self, toml: String) -> u32 {
        let experiment = self.experiments.fetch_add(1, Ordering::Relaxed);
        self.tell(Command::Register { experiment, toml }).await;
        experiment
    }

    /// Asks for units to be evaluated. Each ends once; the channel closes early only if the hub is gone.
    pub async fn submit(&self, works: Vec<Arc<Work>>) -> mpsc::UnboundedReceiver<(UnitKey, UnitEnd)> {
        let (ends, receiver) = mpsc::unbounded_channel();
        self.tell(Command::Submit { works, ends }).await;
        receiver
    }

    /// Waits until everyone who has answered has been looked into. What that comes to is among the [`Findings`]; those of the
    /// workers that are connected whose last answers were right are returned.
    pub async fn close_audits(&self) -> Vec<WorkerId> {
        let (closed, wait) = oneshot::channel();
        self.tell(Command::Closing { closed }).await;
        wait.await.unwrap_or_else(|_| {
            tracing::debug!("the hub is gone");
            Vec::new()
        })
    }

    /// Holds units back, or gives them out again.
    pub async fn pause(&self, paused: bool) {
        self.tell(Command::Pause(paused)).await;
    }

    /// Tells the workers that the master ends; `finished` when it is not expected back.
    pub async fn farewell(&self, finished: bool) {
        self.tell(Command::Farewell { finished }).await;
    }

    /// The workers that are connected, now and from now on.
    #[must_use]
    pub fn crew(&self) -> watch::Receiver<Crew> {
        self.crew.clone()
    }

    /// What each worker is at, now and from now on, second by second.
    #[must_use]
    pub fn floor(&self) -> watch::Receiver<Floor> {
        self.floor.clone()
    }

    pub(super) fn next_peer(&self) -> PeerId {
        PeerId(self.peers.fetch_add(1, Ordering::Relaxed))
    }

    pub(super) async fn tell(&self, command: Command) {
        // The hub lives as long as its handles, unless the whole runtime is going down.
        if self.commands.send(command).await.is_err() {
            tracing::debug!("the hub is gone");
        }
    }
}
