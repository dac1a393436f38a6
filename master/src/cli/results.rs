//! `selftalk results`: what an experiment came to, in a folder.

use std::collections::HashMap;
use std::path::Path;

use selftalk_sim::experiment::Task;
use selftalk_sim::{Behaviour, Simulator};

use super::args::ResultsArgs;
use super::digest::checksum;
use super::evaluate::in_fresh_trials;
use super::individuals::{Individual, chosen, foreign};
use super::work::{bar, crew};
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::results::{
    BestRow, DigestRow, GenerationRow, Results, ResultsError, SummaryRow, TrialRow, WorkerRow,
};
use crate::retest::{CANDIDATES, Crew, Tally, VALIDATION_DRAWS};
use crate::store::{SqliteStore, StoredExperiment, StoredReplication, WorkerEntry, kept_bits};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ResultsArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let mut experiments = select::experiments(&store, args.experiment.as_deref()).await?;
    let Some(stored) = experiments.pop() else {
        return Err(Failure::new(Exit::Usage, "there are no experiments yet; `selftalk run` makes one"));
    };
    if let Some(other) = experiments.first() {
        let names = format!("{}, {}", other.experiment.name, stored.experiment.name);
        return Err(Failure::new(
            Exit::Usage,
            format!("which experiment? Name one with --experiment; there is: {names}"),
        ));
    }
    if let Some(words) = foreign(&stored.experiment.name, &stored.fingerprint)? {
        return Err(Failure::new(Exit::Mismatch, format!("{words}; write its results with that release")));
    }
    write(&store, &stored, &args.out, args.fresh.trials, args.fresh.workers).await
}

/// Writes what an experiment came to into a folder, which must not exist or be empty.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub(super) async fn write(
    store: &SqliteStore,
    stored: &StoredExperiment,
    folder: &Path,
    fresh_trials: u32,
    workers: Option<u32>,
) -> Result<(), Failure> {
    if stored.experiment.task != Task::Elementary {
        let name = &stored.experiment.name;
        let message = format!("`{name}` is of the second phase; `selftalk report` writes what it came to");
        return Err(Failure::new(Exit::Usage, message));
    }
    // Before the work, not after it.
    Results::room(folder)?;
    let trials =
        stored.replications.len() as u64 * u64::from(16 * CANDIDATES * VALIDATION_DRAWS + fresh_trials);
    let bar = bar(trials);
    let done = || bar.inc(1);
    let results = gathered(store, stored, fresh_trials, crew(workers, &done)).await?;
    bar.finish_and_clear();
    Ok(results.write(folder)?)
}

async fn gathered(
    store: &SqliteStore,
    stored: &StoredExperiment,
    fresh_trials: u32,
    crew: Crew<'_>,
) -> Result<Results, Failure> {
    let mut results = Results {
        experiment: stored.experiment.clone(),
        generations: Vec::new(),
        summary: Vec::new(),
        best: Vec::new(),
        trials: Vec::new(),
        digests: Vec::new(),
        workers: store.list_workers().await?.into_iter().map(worker).collect(),
    };
    let simulator = Simulator::new(&stored.experiment)?;
    for replication in &stored.replications {
        let generations = generations(store, replication).await?;
        let best_successes_of_16 = generations.iter().map(|row| row.best_successes).max().unwrap_or_default();
        let champion = match replication.generations.checked_sub(1) {
            Some(last) => chosen(store, stored, replication, last, crew).await?,
            None => None,
        };
        let mut fresh = Tally::default();
        if let Some(individual) = champion {
            let one = std::slice::from_ref(&individual);
            let tallies = in_fresh_trials(one, &stored.experiment, fresh_trials, crew)?;
            fresh = tallies.first().copied().unwrap_or_default();
            results.best.push(best(&individual, fresh_trials));
            results.trials.extend(trials(&individual, &simulator));
        }
        results.generations.extend(generations);
        results.summary.push(SummaryRow {
            replication: replication.number,
            generations: replication.generations,
            first_optimal_generation: replication.first_optimal,
            best_successes_of_16,
            fresh_reach: fresh.share_of(Behaviour::Reach),
            fresh_open: fresh.share_of(Behaviour::Open),
            fresh_grasp: fresh.share_of(Behaviour::Grasp),
            fresh_move: fresh.share_of(Behaviour::Move),
        });
        results.digests.push(DigestRow {
            experiment: stored.experiment.name.clone(),
            replication: replication.number,
            generations: replication.generations,
            sha256: checksum(store, replication).await?,
            fingerprint: stored.fingerprint.clone(),
        });
    }
    Ok(results)
}

async fn generations(
    store: &SqliteStore,
    replication: &StoredReplication,
) -> Result<Vec<GenerationRow>, Failure> {
    let entries = store.list_generations(replication.id, None).await?;
    let behaviours: HashMap<u32, _> = store.list_behaviours(replication.id).await?.into_iter().collect();
    let rows = entries.iter().map(|entry| {
        let mut tally = Tally::default();
        behaviours.get(&entry.generation).into_iter().flatten().for_each(|of| tally.add(of));
        GenerationRow {
            replication: replication.number,
            generation: entry.generation,
            best_fitness: entry.best_fitness,
            mean_fitness: entry.mean_fitness,
            best_successes: entry.best_successes,
            reach: tally.successes_of(Behaviour::Reach),
            open: tally.successes_of(Behaviour::Open),
            grasp: tally.successes_of(Behaviour::Grasp),
            transport: tally.successes_of(Behaviour::Move),
        }
    });
    // A master may have added more since.
    Ok(rows.filter(|row| row.generation < replication.generations).collect())
}

fn best(individual: &Individual, fresh_trials: u32) -> BestRow {
    let Individual { name, scored, member, .. } = individual;
    let validation = individual.validation.unwrap_or_default();
    BestRow {
        replication: name.replication,
        generation: name.generation,
        individual: name.individual,
        fitness: scored.fitness,
        successes: scored.successes,
        validation_trials: validation.trials(),
        validation_successes: validation.successes(),
        fresh_trials,
        genes: member.genotype.to_hex(),
    }
}

fn trials(individual: &Individual, simulator: &Simulator) -> Vec<TrialRow> {
    let rows = (0..).zip(&individual.evaluated.outcomes).map(|(trial, outcome)| TrialRow {
        replication: individual.name.replication,
        trial,
        behaviour: simulator.behaviour(trial).name().to_owned(),
        score: outcome.score,
        score_bits: format!("{:016x}", kept_bits(outcome.score)),
        success: outcome.success,
        steps: outcome.steps,
    });
    rows.collect()
}

fn worker(entry: WorkerEntry) -> WorkerRow {
    let WorkerEntry { slots, version, joined_at, left_at, .. } = entry;
    WorkerRow { slots, version, joined_at, left_at }
}

impl From<ResultsError> for Failure {
    fn from(error: ResultsError) -> Self {
        let exit = match error {
            ResultsError::Occupied(_) | ResultsError::Missing(_) => Exit::Usage,
            ResultsError::Experiment(_) => Exit::Experiment,
            ResultsError::Content { .. } => Exit::Mismatch,
            ResultsError::File { .. } | ResultsError::Retest(_) | ResultsError::Sim(_) => Exit::Unexpected,
        };
        Self::new(exit, error)
    }
}
