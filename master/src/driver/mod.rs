//! The run loop: takes replications from one generation to the next until they are done.
//!
//! All unfinished replications of all experiments run at the same time and share the workers. The driver knows the
//! history only as a [`Store`] and the workers only as a [`Handle`].

mod board;
mod replication;
mod round;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use selftalk_sim::{Experiment, SimError, Simulator};
use thiserror::Error;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::service::Handle;
use crate::store::{Store, StoreError, StoredExperiment};
pub use board::{Board, Last, Standing};
use replication::Replication;

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
        handle: Handle,
        experiments: &[StoredExperiment],
    ) -> Result<Self, DriverError> {
        let (board, receiver) = watch::channel(Board::default());
        let board = Arc::new(board);
        let mut replications = Vec::new();
        let mut place = 0;
        for stored in experiments {
            let toml = stored.experiment.to_toml();
            let number = handle.register(toml.clone()).await;
            let simulator = Simulator::new(&stored.experiment)?;
            board.send_modify(|board| board.add(stored, simulator.trial_count()));
            let study = Study { experiment: stored.experiment.clone(), toml, simulator, number };
            let study = Arc::new(study);
            for replication in &stored.replications {
                if !replication.finished {
                    let (store, handle, board) = (Arc::clone(&store), handle.clone(), Arc::clone(&board));
                    let standing = board::Place::new(board, place);
                    replications.push(
                        Replication::prepare(Arc::clone(&study), replication, store, handle, standing)
                            .await?,
                    );
                }
                place += 1;
            }
        }
        Ok(Self { replications, board: receiver })
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
        let stop = shutdown.child_token();
        let mut tasks = JoinSet::new();
        for replication in self.replications {
            tasks.spawn(replication.run(stop.clone()));
        }
        let mut end = Ok(RunEnd::Finished);
        while let Some(joined) = tasks.join_next().await {
            let result = joined.unwrap_or_else(|error| Err(DriverError::Panicked(error.to_string())));
            match (&end, result) {
                (Ok(_), Err(error)) => {
                    stop.cancel();
                    end = Err(error);
                }
                (Ok(_), Ok(RunEnd::Interrupted)) => end = Ok(RunEnd::Interrupted),
                (Err(_), _) | (Ok(_), Ok(RunEnd::Finished)) => {}
            }
        }
        end
    }
}
