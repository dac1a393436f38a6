//! `selftalk history`: what happened.

use super::args::{GenerationFilter, HistoryArgs, HistoryCommand, IndividualFilter, LineageFilter};
use super::behaviours::behaviours;
use super::output::{Cell, Lines, Table};
use super::{Format, Global, select};
use crate::exit::Failure;
use crate::store::{GenerationEntry, IndividualEntry, ReplicationState, SqliteStore, StoredExperiment};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: HistoryArgs, global: &Global) -> Result<(), Failure> {
    lines(&select::open(global).await?, &args.what, global.format).await?.print()
}

pub(super) async fn lines(
    store: &SqliteStore,
    what: &HistoryCommand,
    format: Format,
) -> Result<Lines, Failure> {
    let table = match what {
        HistoryCommand::Experiments(filter) => {
            experiments(&select::experiments(store, filter.experiment.as_deref()).await?)
        }
        HistoryCommand::Replications(filter) => replications(&select::replications(store, filter).await?),
        HistoryCommand::Generations(filter) => return generations(store, filter, format).await,
        HistoryCommand::Individuals(filter) => individuals(store, filter).await?,
        HistoryCommand::Lineage(filter) => lineage(store, filter).await?,
        HistoryCommand::Behaviours(filter) => behaviours(store, filter).await?,
        HistoryCommand::Workers => workers(store).await?,
    };
    Ok(Lines::of(table, format))
}

/// A line an experiment.
fn experiments(experiments: &[StoredExperiment]) -> Table {
    let mut table = Table::new([
        "experiment",
        "state",
        "replications",
        "finished",
        "generations",
        "planned",
        "best_fitness",
        "seed",
        "created_at",
        "fingerprint",
    ]);
    for stored in experiments {
        let (settings, replications) = (&stored.experiment, &stored.replications);
        let finished = replications.iter().filter(|r| r.state() == ReplicationState::Finished).count();
        let best = replications.iter().filter_map(|r| r.last).map(|last| last.best_fitness).reduce(f64::max);
        table.push([
            settings.name.as_str().into(),
            stored.state().name().into(),
            settings.replications.into(),
            (finished as u64).into(),
            replications.iter().map(|r| u64::from(r.generations)).sum::<u64>().into(),
            (u64::from(settings.replications) * u64::from(settings.generations)).into(),
            best.into(),
            settings.seed.into(),
            stored.created_at.as_str().into(),
            stored.fingerprint.as_str().into(),
        ]);
    }
    table
}

/// A line a replication, with what its last generation came to.
#[must_use]
pub fn replications(experiments: &[StoredExperiment]) -> Table {
    let mut table = Table::new([
        "experiment",
        "replication",
        "state",
        "generations",
        "planned",
        "best_fitness",
        "mean_fitness",
        "successes",
        "first_optimal",
    ]);
    for stored in experiments {
        for replication in &stored.replications {
            table.push([
                stored.experiment.name.as_str().into(),
                replication.number.into(),
                replication.state().name().into(),
                replication.generations.into(),
                stored.experiment.generations.into(),
                replication.last.map(|last| last.best_fitness).into(),
                replication.last.map(|last| last.mean_fitness).into(),
                replication.last.map(|last| last.best_successes).into(),
                replication.first_optimal.into(),
            ]);
        }
    }
    table
}

/// A line a generation, written as they are read: there can be many.
async fn generations(
    store: &SqliteStore,
    filter: &GenerationFilter,
    format: Format,
) -> Result<Lines, Failure> {
    let columns = [
        "experiment",
        "replication",
        "generation",
        "best_fitness",
        "mean_fitness",
        "best_successes",
        "most_successes",
        "optimal",
        "distinct",
        "best_individual",
        "wall_ms",
        "committed_at",
    ];
    let mut lines = Lines::new(columns, format);
    let experiments = select::replications(store, &filter.of).await?;
    let meant = select::generations(&experiments, filter.generation)?;
    let mut add = |place: usize, entries: Vec<GenerationEntry>| {
        let (stored, replication, _) = meant[place];
        for entry in entries {
            lines.push([
                stored.experiment.name.as_str().into(),
                replication.number.into(),
                entry.generation.into(),
                entry.best_fitness.into(),
                entry.mean_fitness.into(),
                entry.best_successes.into(),
                entry.most_successes.into(),
                entry.optimal_individuals.into(),
                entry.distinct_genotypes.into(),
                entry.best_individual.into(),
                entry.wall_ms.into(),
                entry.committed_at.into(),
            ]);
        }
    };
    if filter.best {
        for (place, (_, replication, _)) in meant.iter().enumerate() {
            add(place, store.best_generation(replication.id).await?.into_iter().collect());
        }
    } else {
        let replications: Vec<_> = meant.iter().map(|(_, replication, _)| replication.id).collect();
        store.each_generations(&replications, filter.generation, add).await?;
    }
    Ok(lines)
}

const INDIVIDUAL: [&str; 13] = [
    "experiment",
    "replication",
    "generation",
    "individual",
    "rank",
    "fitness",
    "successes",
    "origin",
    "parent",
    "flipped",
    "evaluated_as",
    "worker",
    "failure",
];

fn individual(stored: &StoredExperiment, replication: u32, entry: IndividualEntry) -> Vec<Cell> {
    vec![
        stored.experiment.name.as_str().into(),
        replication.into(),
        entry.generation.into(),
        entry.individual.into(),
        entry.rank.into(),
        entry.fitness.into(),
        entry.successes.into(),
        entry.origin.into(),
        entry.parent.into(),
        entry.flipped.into(),
        entry.evaluated_as.into(),
        entry.worker.into(),
        entry.failure.into(),
    ]
}

async fn individuals(store: &SqliteStore, filter: &IndividualFilter) -> Result<Table, Failure> {
    let mut columns = INDIVIDUAL.to_vec();
    if filter.genes {
        columns.push("genes");
    }
    let mut table = Table::new(columns);
    let experiments = select::replications(store, &filter.of).await?;
    for (stored, replication, generation) in select::generations(&experiments, filter.generation)? {
        let genotypes = match filter.genes {
            true => Some(store.generations(replication).read(generation).await?.population.members),
            false => None,
        };
        for entry in store.list_individuals(replication.id, generation, filter.best).await? {
            let member = genotypes.as_ref().and_then(|members| members.get(entry.individual as usize));
            let mut row = individual(stored, replication.number, entry);
            if let Some(member) = member {
                row.push(member.genotype.to_hex().into());
            }
            table.push(row);
        }
    }
    Ok(table)
}

async fn lineage(store: &SqliteStore, filter: &LineageFilter) -> Result<Table, Failure> {
    let mut table = Table::new(INDIVIDUAL);
    let experiments = select::replications(store, &filter.of).await?;
    for (stored, replication, generation) in select::generations(&experiments, filter.generation)? {
        let number = match filter.individual {
            Some(number) => Some(number),
            None => store
                .list_individuals(replication.id, generation, true)
                .await?
                .first()
                .map(|best| best.individual),
        };
        let Some(number) = number else { continue };
        for entry in store.lineage(replication.id, generation, number).await? {
            table.push(individual(stored, replication.number, entry));
        }
    }
    match filter.individual {
        Some(number) if table.is_empty() => {
            let most = experiments.iter().map(|stored| stored.experiment.evolution.population).max();
            Err(select::missing("individual", number, most.unwrap_or_default() as usize))
        }
        _ => Ok(table),
    }
}

async fn workers(store: &SqliteStore) -> Result<Table, Failure> {
    let mut table = Table::new([
        "worker",
        "name",
        "host",
        "process",
        "version",
        "slots",
        "joined_at",
        "left_at",
        "audited_at",
    ]);
    for entry in store.list_workers().await? {
        table.push([
            entry.id.into(),
            entry.name.into(),
            entry.host.into(),
            entry.process.into(),
            entry.version.into(),
            entry.slots.into(),
            entry.joined_at.into(),
            Cell::from(entry.left_at),
            Cell::from(entry.audited_at),
        ]);
    }
    Ok(table)
}
