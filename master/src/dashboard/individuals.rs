//! The individuals of a generation, and one of them with its trials, ancestors and children.

use serde::Serialize;

use super::answer::Refusal;
use super::sources::Sources;
use crate::store::{IndividualEntry, StoredExperiment, StoredReplication};

/// A generation and its individuals by rank.
#[derive(Debug, Serialize)]
pub(super) struct Generation {
    generation: u32,
    /// Generations that are committed.
    generations: u32,
    /// Trials of an individual.
    trials: Option<usize>,
    /// Why they cannot be replayed, if so.
    foreign: Option<String>,
    mean_fitness: f64,
    optimal_individuals: u32,
    distinct_genotypes: u32,
    wall_ms: i64,
    committed_at: String,
    individuals: Vec<Row>,
}

/// An individual in a list.
#[derive(Debug, Serialize)]
struct Row {
    generation: u32,
    individual: u32,
    rank: u32,
    fitness: f64,
    successes: u32,
    origin: String,
    parent: Option<u32>,
    /// How many bits differ from the parent.
    flips: usize,
    evaluated_as: u32,
    worker: Option<String>,
    failure: Option<String>,
}

/// An individual.
#[derive(Debug, Serialize)]
pub(super) struct Individual {
    #[serde(flatten)]
    row: Row,
    /// Generations that are committed.
    generations: u32,
    foreign: Option<String>,
    /// The bits in which it differs from its parent.
    flipped: Vec<u32>,
    trials: Vec<Trial>,
    /// It and its ancestors, back to the founder.
    lineage: Vec<Row>,
    /// Its children in the next generation, by rank.
    children: Vec<u32>,
}

#[derive(Debug, Serialize)]
struct Trial {
    trial: usize,
    behaviour: Option<&'static str>,
    score: f64,
    success: bool,
    steps: u32,
}

/// The individuals of a generation.
pub(super) async fn generation(
    sources: &Sources,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    generation: u32,
) -> Result<Generation, Refusal> {
    let store = sources.store();
    let entry = store.list_generations(replication.id, Some(generation)).await?.pop();
    let entry = entry.ok_or_else(|| Refusal::missing("generation", generation))?;
    let individuals = store.list_individuals(replication.id, generation, false).await?;
    Ok(Generation {
        generation,
        generations: replication.generations,
        trials: sources.kind(stored).map(|kind| kind.trials()),
        foreign: sources.foreign(stored),
        mean_fitness: entry.mean_fitness,
        optimal_individuals: entry.optimal_individuals,
        distinct_genotypes: entry.distinct_genotypes,
        wall_ms: entry.wall_ms,
        committed_at: entry.committed_at,
        individuals: individuals.into_iter().map(Row::from).collect(),
    })
}

/// One individual.
pub(super) async fn individual(
    sources: &Sources,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    generation: u32,
    number: u32,
) -> Result<Individual, Refusal> {
    let store = sources.store();
    let lineage = store.lineage(replication.id, generation, number).await?;
    let Some(entry) = lineage.first().cloned() else {
        let missing = if generation < replication.generations { "individual" } else { "generation" };
        return Err(Refusal::missing(missing, if missing == "individual" { number } else { generation }));
    };
    let behaviours = sources.kind(stored).map(|kind| kind.behaviours).unwrap_or_default();
    let outcomes = store.list_outcomes(replication.id, generation, number).await?;
    let trials = outcomes.iter().enumerate().map(|(trial, outcome)| Trial {
        trial,
        behaviour: behaviours.get(trial).copied(),
        score: outcome.score,
        success: outcome.success,
        steps: outcome.steps,
    });
    let next = store.list_individuals(replication.id, generation.saturating_add(1), false).await?;
    let is_child = |child: &&IndividualEntry| child.parent == Some(number);
    Ok(Individual {
        flipped: entry.flipped.clone(),
        row: Row::from(entry),
        generations: replication.generations,
        foreign: sources.foreign(stored),
        trials: trials.collect(),
        lineage: lineage.into_iter().map(Row::from).collect(),
        children: next.iter().filter(is_child).map(|child| child.individual).collect(),
    })
}

impl From<IndividualEntry> for Row {
    fn from(entry: IndividualEntry) -> Self {
        Self {
            generation: entry.generation,
            individual: entry.individual,
            rank: entry.rank,
            fitness: entry.fitness,
            successes: entry.successes,
            origin: entry.origin,
            parent: entry.parent,
            flips: entry.flipped.len(),
            evaluated_as: entry.evaluated_as,
            worker: entry.worker,
            failure: entry.failure,
        }
    }
}
