//! Tests of the stores, and made-up evolution to fill them with.

mod faults;
mod files;
mod round_trip;

use std::time::Duration;

use selftalk_sim::experiment::Task;
use selftalk_sim::{Experiment, TrialOutcome};

use super::{Evaluated, GenerationCommit, GenerationRecord, ReplicationId, Store, StoreError, WorkerId};
use crate::evolution::{Population, Scored, distinct, founders, ranking, reproduce};

pub(crate) const GENES: usize = 40;

/// An experiment whose individuals are small.
pub(crate) fn experiment(name: &str) -> Experiment {
    let mut experiment =
        Experiment { name: name.to_owned(), replications: 2, generations: 130, ..Experiment::default() };
    experiment.evolution.mutation = 0.001;
    experiment
}

/// A generation with made-up results: scores are a function of the genes.
pub(crate) fn evaluate(population: Population, worker: Option<WorkerId>) -> GenerationRecord {
    let outcome = |bytes: &[u8], trial: u32| {
        let value = u32::from(bytes[trial as usize]) + u32::from(bytes[trial as usize + 20]);
        // 511 makes the score a number that no short decimal stands for.
        TrialOutcome { score: f64::from(value) / 511.0, success: value > 300, steps: 60 - value % 7 }
    };
    let evaluated: Vec<Evaluated> = distinct(&population)
        .into_iter()
        .map(|member| {
            let bytes = population.members[member as usize].genotype.to_bytes();
            let outcomes = (0..16).map(|trial| outcome(&bytes, trial)).collect();
            Evaluated { member, outcomes, worker, failure: None }
        })
        .collect();
    let scored: Vec<Scored> = population
        .members
        .iter()
        .map(|member| {
            let same = |e: &&Evaluated| population.members[e.member as usize].genotype == member.genotype;
            let outcomes = &evaluated.iter().find(same).unwrap().outcomes;
            Scored {
                fitness: outcomes.iter().map(|outcome| outcome.score).sum::<f64>() / 16.0,
                successes: outcomes.iter().filter(|outcome| outcome.success).count() as u32,
            }
        })
        .collect();
    let ranking = ranking(&scored);
    GenerationRecord { population, evaluated, scored, ranking }
}

pub(crate) async fn commit(
    store: &impl Store,
    replication: ReplicationId,
    record: &GenerationRecord,
    finished: bool,
) -> Result<(), StoreError> {
    let GenerationRecord { population, evaluated, scored, ranking } = record;
    let wall = Duration::from_millis(1234);
    store
        .commit_generation(GenerationCommit {
            replication,
            task: Task::Elementary,
            population,
            evaluated,
            scored,
            ranking,
            finished,
            wall,
        })
        .await
}

/// The next generation after what a store holds.
pub(crate) async fn next(
    store: &impl Store,
    experiment: &Experiment,
    replication: ReplicationId,
    number: u32,
) -> GenerationRecord {
    let population = match store.last_generation(replication).await.unwrap() {
        None => founders(experiment, GENES, number),
        Some(last) => reproduce(experiment, &last.population, &last.ranking),
    };
    evaluate(population, None)
}

/// Runs generations of all replications, the way a master does; returns all records by replication.
pub(crate) async fn run(
    store: &impl Store,
    experiment: &Experiment,
    generations: u32,
) -> Vec<Vec<GenerationRecord>> {
    let stored = match store.experiment(&experiment.name).await.unwrap() {
        Some(stored) => stored,
        None => store.create_experiment(experiment, "sim-1").await.unwrap(),
    };
    let mut records = vec![Vec::new(); stored.replications.len()];
    for _ in 0..generations {
        for (replication, records) in stored.replications.iter().zip(&mut records) {
            let record = next(store, experiment, replication.id, replication.number).await;
            let finished = record.population.generation + 1 == experiment.generations;
            commit(store, replication.id, &record, finished).await.unwrap();
            records.push(record);
        }
    }
    records
}
