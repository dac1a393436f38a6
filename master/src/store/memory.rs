//! A history that ends with the process.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError};

use selftalk_sim::Experiment;

use super::commit::Checked;
use super::read::Position;
use super::{
    ExperimentId, GenerationCommit, GenerationRecord, ReplicationId, Resumed, Store, StoreError,
    StoredExperiment, StoredReplication, Unproven, WorkerId, WorkerInfo,
};

/// Keeps a history in memory: for trying things out and for tests. It refuses what an SQLite history refuses.
#[derive(Debug, Default)]
pub struct MemoryStore {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    experiments: Vec<StoredExperiment>,
    /// The generations of each replication; a [`ReplicationId`] is an index.
    generations: Vec<Vec<GenerationRecord>>,
    /// Every worker that joined, and whether it has left; a [`WorkerId`] is an index.
    workers: Vec<(WorkerInfo, bool)>,
    /// Those whose last answers were right.
    audited: BTreeSet<WorkerId>,
}

impl MemoryStore {
    /// An empty history.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The committed generations of a replication.
    #[must_use]
    pub fn generations(&self, replication: ReplicationId) -> Vec<GenerationRecord> {
        self.state().generations.get(replication.0 as usize).cloned().unwrap_or_default()
    }

    /// The workers that joined, and whether each has left.
    #[must_use]
    pub fn workers(&self) -> Vec<(WorkerInfo, bool)> {
        self.state().workers.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // No call leaves the state half changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn replication(&mut self, id: ReplicationId) -> Option<&mut StoredReplication> {
        self.experiments.iter_mut().flat_map(|stored| &mut stored.replications).find(|found| found.id == id)
    }

    fn commit(&mut self, commit: GenerationCommit<'_>) -> Result<(), String> {
        let replication = self.replication(commit.replication).ok_or("there is no such replication")?;
        let StoredReplication { number, finished, generations, .. } = *replication;
        let checked = Checked::new(commit, Position { number, finished, generations })?;
        replication.generations += 1;
        replication.finished = commit.finished;
        replication.last = Some(checked.summary);
        if checked.summary.optimal > 0 {
            replication.first_optimal.get_or_insert(generations);
        }
        if let Some(records) = self.generations.get_mut(commit.replication.0 as usize) {
            records.push(GenerationRecord {
                population: commit.population.clone(),
                evaluated: commit.evaluated.to_vec(),
                scored: commit.scored.to_vec(),
                ranking: commit.ranking.to_vec(),
            });
        }
        Ok(())
    }
}

impl State {
    fn take_back(&mut self, id: ReplicationId, from: u32) {
        let Some(records) = self.generations.get_mut(id.0 as usize) else { return };
        records.truncate(from as usize);
        let (left, last) = (records.len() as u32, records.last().and_then(GenerationRecord::summary));
        if let Some(replication) = self.replication(id).filter(|replication| replication.generations > left) {
            replication.generations = left;
            replication.finished = false;
            replication.last = last;
            replication.first_optimal = replication.first_optimal.filter(|first| *first < left);
        }
    }
}

impl State {
    /// The latest answers in an experiment of the workers of which it is not known that they were right.
    fn unproven(&self, stored: &StoredExperiment) -> Vec<Unproven> {
        let mut contributions: BTreeMap<WorkerId, Vec<(&StoredReplication, u32, u32)>> = BTreeMap::new();
        for replication in &stored.replications {
            let records = self.generations.get(replication.id.0 as usize).map_or(&[][..], Vec::as_slice);
            for (generation, record) in (0..).zip(records) {
                let workers: BTreeSet<WorkerId> =
                    record.evaluated.iter().filter_map(|evaluated| evaluated.worker).collect();
                for worker in workers.difference(&self.audited) {
                    let of_worker = contributions.entry(*worker).or_default();
                    match of_worker.last_mut().filter(|(of, ..)| of.id == replication.id) {
                        Some((_, _, last)) => *last = generation,
                        None => of_worker.push((replication, generation, generation)),
                    }
                }
            }
        }
        let latest = |(worker, contributions): (WorkerId, Vec<(&StoredReplication, u32, u32)>)| {
            let &(replication, _, generation) = contributions.last()?;
            let record = self.generations.get(replication.id.0 as usize)?.get(generation as usize)?;
            let (genotype, outcomes) = record.latest_of(worker)?;
            let since = contributions.iter().map(|(of, first, _)| (of.id, *first)).collect();
            let (experiment, replication) = (stored.id, replication.number);
            let name = self.workers.get(worker.0 as usize)?.0.name.clone();
            Some(Unproven { worker, name, experiment, replication, generation, genotype, outcomes, since })
        };
        contributions.into_iter().filter_map(latest).collect()
    }
}

impl Store for MemoryStore {
    async fn create_experiment(
        &self,
        experiment: &Experiment,
        fingerprint: &str,
    ) -> Result<StoredExperiment, StoreError> {
        let mut state = self.state();
        if state.experiments.iter().any(|stored| stored.experiment.name == experiment.name) {
            return Err(StoreError::Exists { path: "memory".into(), name: experiment.name.clone() });
        }
        let first = state.generations.len();
        let replication = |number: u32| StoredReplication {
            id: ReplicationId(first as i64 + i64::from(number)),
            number,
            finished: false,
            generations: 0,
            last: None,
            first_optimal: None,
        };
        let stored = StoredExperiment {
            id: ExperimentId(state.experiments.len() as i64),
            experiment: experiment.clone(),
            fingerprint: fingerprint.to_owned(),
            created_at: "1970-01-01T00:00:00Z".to_owned(),
            replications: (0..experiment.replications).map(replication).collect(),
        };
        state.generations.resize(first + stored.replications.len(), Vec::new());
        state.experiments.push(stored.clone());
        Ok(stored)
    }

    async fn experiment(&self, name: &str) -> Result<Option<StoredExperiment>, StoreError> {
        Ok(self.state().experiments.iter().find(|stored| stored.experiment.name == name).cloned())
    }

    async fn experiments(&self) -> Result<Vec<StoredExperiment>, StoreError> {
        Ok(self.state().experiments.clone())
    }

    async fn last_generation(&self, replication: ReplicationId) -> Result<Option<Resumed>, StoreError> {
        let state = self.state();
        let last = state.generations.get(replication.0 as usize).and_then(|records| records.last());
        Ok(last
            .map(|record| Resumed { population: record.population.clone(), ranking: record.ranking.clone() }))
    }

    async fn commit_generation(&self, commit: GenerationCommit<'_>) -> Result<(), StoreError> {
        self.state().commit(commit).map_err(|reason| StoreError::Commit { path: "memory".into(), reason })
    }

    async fn take_back(&self, replication: ReplicationId, from: u32) -> Result<(), StoreError> {
        self.state().take_back(replication, from);
        Ok(())
    }

    async fn worker_joined(&self, worker: &WorkerInfo) -> Result<WorkerId, StoreError> {
        let mut state = self.state();
        state.workers.push((worker.clone(), false));
        Ok(WorkerId(state.workers.len() as i64 - 1))
    }

    async fn worker_left(&self, worker: WorkerId) -> Result<(), StoreError> {
        if let Some((_, left)) = self.state().workers.get_mut(worker.0 as usize) {
            *left = true;
        }
        Ok(())
    }

    async fn workers_audited(&self, workers: &[WorkerId]) -> Result<(), StoreError> {
        self.state().audited.extend(workers);
        Ok(())
    }

    async fn unproven(&self) -> Result<Vec<Unproven>, StoreError> {
        let state = self.state();
        Ok(state.experiments.iter().flat_map(|stored| state.unproven(stored)).collect())
    }
}
