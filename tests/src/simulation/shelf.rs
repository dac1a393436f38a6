//! The history of a simulation, and the record of what happened.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use selftalk::store::{
    GenerationCommit, MemoryStore, ReplicationId, Resumed, Store, StoreError, StoredExperiment, Unproven,
    WorkerId, WorkerInfo,
};
use selftalk_sim::Experiment;
use tokio::time::sleep;

/// How long it takes to write a generation, before and after it is there.
const WRITING: Duration = Duration::from_millis(10);

/// A history in memory that takes its time, as a disk does: a master that crashes meanwhile has written everything or
/// nothing, and does not know. It outlives the master.
#[derive(Debug, Clone)]
pub(super) struct Shelf {
    store: Arc<MemoryStore>,
    events: Arc<Mutex<Vec<String>>>,
    commits: Arc<AtomicUsize>,
    finished: Arc<AtomicBool>,
}

impl Shelf {
    pub(super) fn new(store: Arc<MemoryStore>) -> Self {
        Self { store, events: Arc::default(), commits: Arc::default(), finished: Arc::default() }
    }

    pub(super) fn store(&self) -> &MemoryStore {
        &self.store
    }

    /// Notes what happened after so much simulated time.
    pub(super) fn note(&self, what: &str, after: Duration) {
        self.events.lock().expect("no panic").push(format!("{:>8} ms: {what}", after.as_millis()));
    }

    pub(super) fn events(&self) -> Vec<String> {
        self.events.lock().expect("no panic").clone()
    }

    /// Generations that have been committed.
    pub(super) fn commits(&self) -> usize {
        self.commits.load(Ordering::Relaxed)
    }

    /// The master has finished.
    pub(super) fn finish(&self) {
        self.finished.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_finished(&self) -> bool {
        self.finished.load(Ordering::Relaxed)
    }
}

impl Store for Shelf {
    async fn create_experiment(
        &self,
        experiment: &Experiment,
        fingerprint: &str,
    ) -> Result<StoredExperiment, StoreError> {
        self.store.create_experiment(experiment, fingerprint).await
    }

    async fn experiment(&self, name: &str) -> Result<Option<StoredExperiment>, StoreError> {
        self.store.experiment(name).await
    }

    async fn experiments(&self) -> Result<Vec<StoredExperiment>, StoreError> {
        self.store.experiments().await
    }

    async fn last_generation(&self, replication: ReplicationId) -> Result<Option<Resumed>, StoreError> {
        self.store.last_generation(replication).await
    }

    async fn commit_generation(&self, commit: GenerationCommit<'_>) -> Result<(), StoreError> {
        sleep(WRITING).await;
        let workers: Vec<i64> =
            commit.evaluated.iter().map(|evaluated| evaluated.worker.map_or(-1, |worker| worker.0)).collect();
        let what = format!(
            "replication {}, generation {}: {workers:?}",
            commit.replication.0, commit.population.generation
        );
        self.store.commit_generation(commit).await?;
        self.commits.fetch_add(1, Ordering::Relaxed);
        self.note(&what, turmoil::sim_elapsed().unwrap_or_default());
        sleep(WRITING).await;
        Ok(())
    }

    async fn take_back(&self, replication: ReplicationId, from: u32) -> Result<(), StoreError> {
        self.store.take_back(replication, from).await
    }

    async fn worker_joined(&self, worker: &WorkerInfo) -> Result<WorkerId, StoreError> {
        self.store.worker_joined(worker).await
    }

    async fn worker_left(&self, worker: WorkerId) -> Result<(), StoreError> {
        self.store.worker_left(worker).await
    }

    async fn workers_audited(&self, workers: &[WorkerId]) -> Result<(), StoreError> {
        self.store.workers_audited(workers).await
    }

    async fn unproven(&self) -> Result<Vec<Unproven>, StoreError> {
        self.store.unproven().await
    }
}
