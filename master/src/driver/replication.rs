//! One replication, generation after generation.

use std::sync::Arc;

use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use super::board::{Last, Place};
use super::round::{Known, Round};
use super::{DriverError, RunEnd, Study};
use crate::evolution::{Scored, founders, ranking, reproduce};
use crate::service::Handle;
use crate::store::{GenerationCommit, ReplicationId, Store};

/// Which replication, and what it needs to go on.
#[derive(Debug)]
pub(super) struct Subject<S> {
    pub(super) study: Arc<Study>,
    pub(super) id: ReplicationId,
    /// Its number in its experiment.
    pub(super) number: u32,
    pub(super) store: Arc<S>,
    pub(super) handle: Handle,
    pub(super) place: Place,
}

/// A replication with its next generation under way.
#[derive(Debug)]
pub(super) struct Replication<S> {
    subject: Arc<Subject<S>>,
    round: Round,
}

impl<S: Store> Replication<S> {
    /// Begins with the generation after the last one committed.
    pub(super) async fn prepare(subject: Arc<Subject<S>>) -> Result<Self, DriverError> {
        let Subject { study, id, number, store, handle, .. } = &*subject;
        let population = match store.last_generation(*id).await? {
            Some(last) => reproduce(&study.experiment, &last.population, &last.ranking),
            None => founders(&study.experiment, study.simulator.gene_count(), *number),
        };
        let round = Round::begin(study, handle, population, &Known::default()).await;
        Ok(Self { subject, round })
    }

    /// The generation under way: as many are committed.
    pub(super) fn generation(&self) -> u32 {
        self.round.population.generation
    }

    /// Runs until the last generation is committed or `stop` is cancelled.
    pub(super) async fn run(mut self, stop: CancellationToken) -> Result<RunEnd, DriverError> {
        loop {
            let span = self.round.span();
            tokio::select! {
                biased;
                () = stop.cancelled() => return Ok(RunEnd::Interrupted),
                complete = self.round.complete(&self.subject.study).instrument(span) => complete?,
            }
            if self.conclude().await? {
                return Ok(RunEnd::Finished);
            }
        }
    }

    /// Commits the generation and begins the next one; true if it was the last.
    async fn conclude(&mut self) -> Result<bool, DriverError> {
        let Subject { study, id, store, handle, place, .. } = &*self.subject;
        let wall = self.round.wall();
        let (evaluated, scored) = self.round.scored(study);
        let ranking = ranking(&scored);
        let finished = is_last(study, self.round.population.generation, &scored);
        // The workers are busy with the next generation while this one is written.
        let next = if finished {
            None
        } else {
            let children = reproduce(&study.experiment, &self.round.population, &ranking);
            let known = self.round.known(study, &evaluated);
            Some(Round::begin(study, handle, children, &known).await)
        };
        let population = &self.round.population;
        let commit = GenerationCommit {
            replication: *id,
            task: study.experiment.task,
            population,
            evaluated: &evaluated,
            scored: &scored,
            ranking: &ranking,
            finished,
            wall,
        };
        let span = tracing::info_span!(parent: self.round.span(), "commit");
        store.commit_generation(commit).instrument(span).await?;
        place.note(population.generation + 1, finished, Last::of(&scored, &ranking));
        if let Some(next) = next {
            self.round = next;
        }
        Ok(finished)
    }
}

fn is_last(study: &Study, generation: u32, scored: &[Scored]) -> bool {
    let Study { experiment, simulator, .. } = study;
    let optimal = |scored: &Scored| scored.successes >= simulator.trial_count();
    generation + 1 >= experiment.generations
        || (experiment.evolution.stop_at_optimum && scored.iter().any(optimal))
}
