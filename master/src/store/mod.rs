//! The history: every generation of every replication, in one SQLite file.
//!
//! [`Store`] is what a master needs of it.

mod backup;
mod commit;
mod curves;
mod digest;
mod error;
mod extend;
mod generations;
mod listing;
mod lock;
mod memory;
mod model;
mod open;
mod packed;
mod read;
mod retest;
mod sqlite;
#[cfg(test)]
pub(crate) mod tests;
mod unproven;
mod write;

use std::future::Future;

use selftalk_sim::Experiment;

pub use curves::CurvePoint;
pub use digest::{HistoryDigest, kept_bits};
pub use error::StoreError;
pub use listing::{GenerationEntry, IndividualEntry, TrialEntry, WorkerEntry};
pub use memory::MemoryStore;
pub use model::{
    BehaviourSummary, Evaluated, ExperimentId, GenerationCommit, GenerationRecord, GenerationSummary,
    ReplicationId, ReplicationState, Resumed, StoredExperiment, StoredReplication, Unproven, WorkerId,
    WorkerInfo,
};
pub use open::schema_version;
pub use retest::{Retest, Test};
pub use sqlite::{Generations, SqliteStore};

/// Where a master keeps its history. There is one writer at a time; calls may come from many tasks.
///
/// A generation that was committed changes only by being [taken back](Store::take_back).
///
/// What a call that returned has written is durable; of workers, with the next generation. A call that failed has written
/// nothing, one that was dropped everything or nothing.
pub trait Store: Send + Sync + 'static {
    /// Creates an experiment with all its replications, at generation none.
    ///
    /// `fingerprint` is the simulator's ([`selftalk_sim::fingerprint()`]).
    ///
    /// # Errors
    /// [`StoreError::Exists`] when the name is taken, whatever the settings.
    fn create_experiment(
        &self,
        experiment: &Experiment,
        fingerprint: &str,
    ) -> impl Future<Output = Result<StoredExperiment, StoreError>> + Send;

    /// The experiment of that name.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    fn experiment(
        &self,
        name: &str,
    ) -> impl Future<Output = Result<Option<StoredExperiment>, StoreError>> + Send;

    /// All experiments, in the order of their creation.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    fn experiments(&self) -> impl Future<Output = Result<Vec<StoredExperiment>, StoreError>> + Send;

    /// The generation from which a replication goes on: its last committed one, none before the first.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read, or does not hold what was committed.
    fn last_generation(
        &self,
        replication: ReplicationId,
    ) -> impl Future<Output = Result<Option<Resumed>, StoreError>> + Send;

    /// Writes a generation, and that the replication is finished if it is, in one transaction.
    ///
    /// # Errors
    /// [`StoreError::Commit`] when the generation is not the replication's next one or its parts do not fit
    /// together; others when the history cannot be written.
    fn commit_generation(
        &self,
        commit: GenerationCommit<'_>,
    ) -> impl Future<Output = Result<(), StoreError>> + Send;

    /// Takes back the generations of a replication from this one on, in one transaction: what was found to be wrong is
    /// evaluated again. The replication goes on after the last that is left.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be written.
    fn take_back(
        &self,
        replication: ReplicationId,
        from: u32,
    ) -> impl Future<Output = Result<(), StoreError>> + Send;

    /// Notes that a worker has joined.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be written.
    fn worker_joined(&self, worker: &WorkerInfo)
    -> impl Future<Output = Result<WorkerId, StoreError>> + Send;

    /// Notes that a worker has left or was lost.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be written.
    fn worker_left(&self, worker: WorkerId) -> impl Future<Output = Result<(), StoreError>> + Send;

    /// Notes that the last answers of these workers were [looked into](Store::unproven) and right.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be written.
    fn workers_audited(&self, workers: &[WorkerId]) -> impl Future<Output = Result<(), StoreError>> + Send;

    /// The latest answers on record of the workers of which it is not noted that they were right, one for each experiment to
    /// which a worker has contributed.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read, or does not hold what was committed.
    fn unproven(&self) -> impl Future<Output = Result<Vec<Unproven>, StoreError>> + Send;
}
