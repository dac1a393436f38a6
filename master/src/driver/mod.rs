//! The run loop: takes replications from one generation to the next until they are done.
//!
//! All unfinished replications of all experiments run at the same time and share the workers. The driver knows the
//! history only as a [`Store`] and the workers only as a [`Handle`].

mod board;
mod doubts;
mod field;
mod replication;
mod round;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use selftalk_sim::{Experiment, SimError, Simulator};
use thiserror::Error;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use crate::service::{Finding, Findings, Handle};
use crate::store::{Store, StoreError, StoredExperiment, StoredReplication};
pub use board::{Board, Last, Standing};
pub use doubts::settle_doubts;
use field::Field;
use replication::{Replication, Subject};

/// Why a run cannot go on.
#[derive(Debug, Error)]
pub enum DriverError {
    /// The history cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The simulator cannot be set up.
    #[error(transparent)]
    Simulator(#[from] SimError),
    /// The service that brings units to the workers has ended.
    #[error("the service that hands out the work has ended")]
    ServiceEnded,
    /// A part of the run has panicked.
    #[error("a replication has failed: {0}")]
    Panicked(String),
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
    /// All replications are finished.
    Finished,
    /// It was told to stop. Generations under way are dropped.
    Interrupted,
}

/// What the replications of an experiment share.
#[derive(Debug)]
struct Study {
    experiment: Experiment,
    toml: String,
    simulator: Simulator,
    /// Its number for the service.
    number: u32,
}

/// Everything that is to be run, with the first units already submitted.
#[derive(Debug)]
pub struct Driver<S> {
    replications: Vec<Replication<S>>,
    subjects: Vec<Arc<Subject<S>>>,
    store: Arc<S>,
    handle: Handle,
    findings: Findings,
    board: watch::Receiver<Board>,
}

impl<S: Store> Driver<S> {
    /// Loads where the unfinished replications of these experiments stand and submits their next generations. Workers
    /// should be received only after that, so that results they still hold are of use.
    ///
    /// # Errors
    /// [`DriverError::Store`] when the history cannot be read.
    pub async fn prepare(
        store: Arc<S>,
        (handle, findings): (Handle, Findings),
        experiments: &[StoredExperiment],
    ) -> Result<Self, DriverError> {
        let (board, receiver) = watch::channel(Board::default());
        let board = Arc::new(board);
        let (mut subjects, mut replications) = (Vec::new(), Vec::new());
        let mut index = 0;
        for stored in experiments {
            let toml = stored.experiment.to_toml();
            let number = handle.register(toml.clone()).await;
            let simulator = Simulator::new(&stored.experiment)?;
            board.send_modify(|board| board.add(stored, simulator.trial_count()));
            let study = Study { experiment: stored.experiment.clone(), toml, simulator, number };
            let study = Arc::new(study);
            for &StoredReplication { id, number, finished, .. } in &stored.replications {
                if !finished {
                    let place = board::Place::new(Arc::clone(&board), index);
                    let (study, store, handle) = (Arc::clone(&study), Arc::clone(&store), handle.clone());
                    let subject = Arc::new(Subject { study, id, number, store, handle, place });
                    replications.push(Replication::prepare(Arc::clone(&subject)).await?);
                    subjects.push(subject);
                }
                index += 1;
            }
        }
        Ok(Self { replications, subjects, store, handle, findings, board: receiver })
    }

    /// Where the replications stand, now and from now on.
    #[must_use]
    pub fn board(&self) -> watch::Receiver<Board> {
        self.board.clone()
    }

    /// Runs all replications to their ends or until `shutdown` is cancelled; a generation that is being written then
    /// is still written.
    ///
    /// # Errors
    /// [`DriverError`] of the first replication that cannot go on; the others are stopped.
    pub async fn run(self, shutdown: CancellationToken) -> Result<RunEnd, DriverError> {
        let Self { replications, subjects, store, handle, mut findings, .. } = self;
        let mut field = Field::new(Arc::clone(&store), subjects, shutdown);
        for (index, replication) in replications.into_iter().enumerate() {
            field.start(index, replication);
        }
        loop {
            tokio::select! {
                biased;
                ended = field.next() => match ended {
                    Some(ended) => field.conclude(ended).await?,
                    None => {
                        let end = field.end();
                        // The last answers of every worker are looked into before the run counts as finished.
                        let right = match end {
                            RunEnd::Finished => handle.close_audits().await,
                            RunEnd::Interrupted => Vec::new(),
                        };
                        let mut wrong = false;
                        while let Some(finding) = findings.known() {
                            wrong |= matches!(finding, Finding::Wrong(_));
                            field.follow(finding).await?;
                        }
                        if !wrong {
                            if !right.is_empty() {
                                store.workers_audited(&right).await?;
                            }
                            return Ok(end);
                        }
                    }
                },
                finding = findings.next() => field.follow(finding).await?,
            }
        }
    }
}
