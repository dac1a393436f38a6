//! Which part of a history is meant.

use super::Global;
use super::args::ReplicationFilter;
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store, StoredExperiment, StoredReplication};

/// Opens the history for reading.
///
/// # Errors
/// [`Exit::Database`].
pub async fn open(global: &Global) -> Result<SqliteStore, Failure> {
    Ok(SqliteStore::open_reader(&global.db).await?)
}

/// All experiments, or the one of that name.
///
/// # Errors
/// [`Exit::Usage`] when there is no such experiment.
pub async fn experiments(store: &impl Store, name: Option<&str>) -> Result<Vec<StoredExperiment>, Failure> {
    let all = store.experiments().await?;
    let Some(name) = name else { return Ok(all) };
    let names: Vec<_> = all.iter().map(|stored| stored.experiment.name.clone()).collect();
    let found: Vec<_> = all.into_iter().filter(|stored| stored.experiment.name == name).collect();
    if found.is_empty() && names.is_empty() {
        let message = format!("there is no experiment `{name}`; there is none yet, `selftalk run` makes one");
        return Err(Failure::new(Exit::Usage, message));
    }
    if found.is_empty() {
        let there = names.join(", ");
        return Err(Failure::new(Exit::Usage, format!("there is no experiment `{name}`; there is: {there}")));
    }
    Ok(found)
}

/// The experiments with only those replications that are meant.
///
/// # Errors
/// [`Exit::Usage`] when there is no such experiment or replication.
pub async fn replications(
    store: &impl Store,
    filter: &ReplicationFilter,
) -> Result<Vec<StoredExperiment>, Failure> {
    let mut experiments = experiments(store, filter.experiment.as_deref()).await?;
    let Some(number) = filter.replication else { return Ok(experiments) };
    let most = experiments.iter().map(|stored| stored.replications.len()).max().unwrap_or_default();
    for stored in &mut experiments {
        stored.replications.retain(|replication| replication.number == number);
    }
    experiments.retain(|stored| !stored.replications.is_empty());
    if experiments.is_empty() {
        return Err(missing("replication", number, most));
    }
    Ok(experiments)
}

/// The replications that are meant, each with the generation: the one asked for, or its last.
///
/// # Errors
/// [`Exit::Usage`] when no replication has that generation.
pub fn generations(
    experiments: &[StoredExperiment],
    generation: Option<u32>,
) -> Result<Vec<(&StoredExperiment, &StoredReplication, u32)>, Failure> {
    let all: Vec<_> = experiments
        .iter()
        .flat_map(|stored| stored.replications.iter().map(move |replication| (stored, replication)))
        .collect();
    let meant: Vec<_> = all
        .iter()
        .filter_map(|&(stored, replication)| {
            let last = replication.generations.checked_sub(1)?;
            let generation = generation.unwrap_or(last);
            (generation <= last).then_some((stored, replication, generation))
        })
        .collect();
    match generation {
        Some(generation) if meant.is_empty() => {
            let most = all.iter().map(|(_, replication)| replication.generations).max().unwrap_or_default();
            Err(missing("generation", generation, most as usize))
        }
        _ => Ok(meant),
    }
}

/// There is no such thing; says which there are.
pub fn missing(what: &str, number: u32, count: usize) -> Failure {
    let there = match count {
        0 => "there is none yet".to_owned(),
        1 => format!("there is only {what} 0"),
        _ => format!("they go from 0 to {}", count - 1),
    };
    Failure::new(Exit::Usage, format!("there is no {what} {number}; {there}"))
}
