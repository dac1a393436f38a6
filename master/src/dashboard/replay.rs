//! A replay of any stored individual: its trials run again, on one thread, one replay at a time.

use std::sync::Arc;

use selftalk_sim::{Case, Simulator};
use sha2::{Digest, Sha256};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

use super::answer::Refusal;
use super::sources::Sources;
use crate::evolution::{Member, draw};
use crate::replay::{Recording, page};
use crate::retest::difference;
use crate::store::{Evaluated, GenerationRecord, StoredExperiment, StoredReplication};

/// Replays that are being made or waited for at most.
const WAITING: usize = 4;

/// Where replays are made: the workers need the machine more.
#[derive(Debug, Clone)]
pub(super) struct Studio {
    queue: Arc<Semaphore>,
    stage: Arc<Semaphore>,
    shutdown: CancellationToken,
}

impl Studio {
    pub(super) fn new(shutdown: CancellationToken) -> Self {
        Self { queue: Arc::new(Semaphore::new(WAITING)), stage: Arc::new(Semaphore::new(1)), shutdown }
    }

    /// The page that plays an individual's trials.
    pub(super) async fn replay(
        &self,
        sources: Arc<Sources>,
        stored: StoredExperiment,
        replication: StoredReplication,
        generation: u32,
        number: u32,
    ) -> Result<String, Refusal> {
        let name = format!("{}/{}/{generation}/{number}", stored.experiment.name, replication.number);
        if let Some(foreign) = sources.foreign(&stored) {
            return Err(Refusal::Impossible(format!("{name} cannot be replayed: {foreign}")));
        }
        if generation >= replication.generations {
            return Err(Refusal::missing("generation", generation));
        }
        let _waiting = self.queue.try_acquire().map_err(|_| Refusal::Busy)?;
        let _alone = self.stage.acquire().await.map_err(|_| Refusal::Dark)?;
        let record = sources.store().generations(&replication).read(generation).await?;
        // The file is not held while the trials run.
        drop(sources);
        let (member, evaluated) =
            found(&record, number).ok_or_else(|| Refusal::missing("individual", number))?;
        let shutdown = self.shutdown.clone();
        let made = tokio::task::spawn_blocking(move || {
            let place = (replication.number, generation);
            let recordings = record_trials(&stored, place, &name, &member, &evaluated, &shutdown)?;
            page(&recordings).map_err(Refusal::failed)
        });
        made.await.map_err(Refusal::failed)?
    }
}

/// An individual and what its genotype came to; copies were evaluated as the first of them.
fn found(record: &GenerationRecord, number: u32) -> Option<(Member, Evaluated)> {
    let members = &record.population.members;
    let member = members.get(number as usize)?;
    let same = |evaluated: &&Evaluated| {
        members.get(evaluated.member as usize).is_some_and(|other| other.genotype == member.genotype)
    };
    Some((member.clone(), record.evaluated.iter().find(same)?.clone()))
}

/// Runs the trials again, which have to come to what is stored.
fn record_trials(
    stored: &StoredExperiment,
    (replication, generation): (u32, u32),
    name: &str,
    member: &Member,
    evaluated: &Evaluated,
    shutdown: &CancellationToken,
) -> Result<Vec<Recording>, Refusal> {
    let simulator = Simulator::new(&stored.experiment).map_err(Refusal::failed)?;
    let draw = draw(&stored.experiment, replication, generation);
    let mut recordings = Vec::new();
    for trial in 0..simulator.trial_count() {
        if shutdown.is_cancelled() {
            return Err(Refusal::Dark);
        }
        let trace =
            simulator.trace(&member.genotype, Case::Drawn { draw, trial }).map_err(Refusal::failed)?;
        let before = evaluated.outcomes.get(trial as usize);
        if let Some(words) = before.and_then(|before| difference(before, &trace.outcome)) {
            return Err(Refusal::Failed(format!("{name}, trial {trial}: {words}")));
        }
        let recording = Recording::new(name.to_owned(), trial, simulator.behaviour(trial), &trace);
        recordings.push(recording.map_err(Refusal::failed)?);
    }
    Ok(recordings)
}

/// What a replay's page may load: nothing. Its own script and style are allowed by their hashes.
pub(super) fn policy(page: &str) -> String {
    use base64::Engine;
    let hash = |element: &str| {
        let text = page.split_once(&format!("<{element}>")).map_or("", |(_, rest)| rest);
        let text = text.split_once(&format!("</{element}>")).map_or("", |(text, _)| text);
        base64::engine::general_purpose::STANDARD.encode(Sha256::digest(text))
    };
    format!(
        "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'",
        hash("script"),
        hash("style")
    )
}
