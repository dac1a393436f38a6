//! One replication, generation after generation.

use std::sync::Arc;

use tokio_util::sync::CancellationToken;

use super::board::{Last, Place};
use super::round::{Known, Round};
use super::{DriverError, RunEnd, Study};
use crate::evolution::{Scored, founders, ranking, reproduce};
use crate::service::Handle;
use crate::store::{GenerationCommit, ReplicationId, Store, StoredReplication};

/// A replication with its next generation under way.
#[derive(Debug)]
pub(super) struct Replication<S> {
    study: Arc<Study>,
    id: ReplicationId,
    store: Arc<S>,
    handle: Handle,
    place: Place,
    round: Round,
}

impl<S: Store> Replication<S> {
    /// Begins with the generation after the last one committed.
    pub(super) async fn prepare(
        study: Arc<Study>,
        stored: &StoredReplication,
        store: Arc<S>,
        handle: Handle,
        place: Place,
    ) -> Result<Self, DriverError> {
        let population = match store.last_generation(stored.id).await? {
            Some(last) => reproduce(&study.experiment, &last.population, &last.ranking),
            None => founders(&study.experiment, study.simulator.gene_count(), stored.number),
        };
        let round = Round::begin(&study, &handle, population, &Known::default()).await;
        Ok(Self { study, id: stored.id, store, handle, place, round })
    }

    /// Runs until the last generation is committed or `stop` is cancelled.
    pub(super) async fn run(mut self, stop: CancellationToken) -> Result<RunEnd, DriverError> {
        loop {
            tokio::select! {
                biased;
                () = stop.cancelled() => return Ok(RunEnd::Interrupted),
                complete = self.round.complete(&self.study) => complete?,
            }
            if self.conclude().await? {
                return Ok(RunEnd::Finished);
            }
        }
    }

    /// Commits the generation and begins the next one; true if it was the last.
    async fn conclude(&mut self) -> Result<bool, DriverError> {
        let wall = self.round.wall();
        let (evaluated, scored) = self.round.scored(&self.study);
        let ranking = ranking(&scored);
        let finished = self.is_last(&scored);
        // The workers are busy with the next generation while this one is written.
        let next = if finished {
            None
        } else {
            let children = reproduce(&self.study.experiment, &self.round.population, &ranking);
            let known = self.round.known(&self.study, &evaluated);
            Some(Round::begin(&self.study, &self.handle, children, &known).await)
        };
        let population = &self.round.population;
        let commit = GenerationCommit {
            replication: self.id,
            population,
            evaluated: &evaluated,
            scored: &scored,
            ranking: &ranking,
            finished,
            wall,
        };
        self.store.commit_generation(commit).await?;
        self.place.note(population.generation + 1, finished, Last::of(&scored, &ranking));
        if let Some(next) = next {
            self.round = next;
        }
        Ok(finished)
    }

    fn is_last(&self, scored: &[Scored]) -> bool {
        let Study { experiment, simulator, .. } = &*self.study;
        let optimal = |scored: &Scored| scored.successes >= simulator.trial_count();
        self.round.population.generation + 1 >= experiment.generations
            || (experiment.evolution.stop_at_optimum && scored.iter().any(optimal))
    }
}
