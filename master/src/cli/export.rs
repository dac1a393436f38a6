//! `selftalk export`: the history as tables for other programs.

use indicatif::ProgressBar;
use selftalk_sim::{Behaviour, Simulator};

use super::args::{ExportArgs, ExportTable, ExportType, ReplicationFilter, Which};
use super::individuals::{Individual, find, warn_foreign};
use super::output::Table;
use super::replay::recording;
use super::work::{bar_of, crew};
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::export::{ExportError, FileType, Folder, Sheet, Topic, Value, Written, rows};
use crate::store::{SqliteStore, StoredExperiment, StoredReplication};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ExportArgs, global: &Global) -> Result<(), Failure> {
    let topics = topics(&args)?;
    let store = select::open(global).await?;
    let mut experiments = Vec::new();
    for name in &args.experiments {
        experiments.extend(select::experiments(&store, Some(name)).await?);
    }
    if args.experiments.is_empty() {
        experiments = select::experiments(&store, None).await?;
    }
    // Before anything is written.
    let signals = topics.contains(&Topic::Signals);
    let individuals = if signals { individuals(&store, &experiments, &args).await? } else { Vec::new() };
    let to = match args.to {
        ExportType::Csv => FileType::Csv,
        ExportType::Parquet => FileType::Parquet,
    };
    let folder = Folder::prepare(&args.out, to, &topics, args.force)?;
    let mut written = Vec::new();
    for &topic in &topics {
        let bar = bar_of(steps(topic, &experiments, &individuals), unit(topic));
        let mut sheet = folder.begin(topic)?;
        if topic == Topic::Signals {
            write_signals(&mut sheet, &individuals, &bar)?;
        } else {
            for stored in &experiments {
                for replication in &stored.replications {
                    write_replication(&mut sheet, topic, &store, stored, replication, &bar).await?;
                }
            }
        }
        bar.finish_and_clear();
        written.push(sheet.finish()?);
    }
    listed(written)?.print(global.format)
}

/// The tables that are asked for, each once.
fn topics(args: &ExportArgs) -> Result<Vec<Topic>, Failure> {
    let asked = |table: &ExportTable| match table {
        ExportTable::Generations => Topic::Generations,
        ExportTable::Individuals => Topic::Individuals,
        ExportTable::Trials => Topic::Trials,
        ExportTable::Signals => Topic::Signals,
    };
    let mut topics: Vec<Topic> = args.tables.iter().map(asked).collect();
    if topics.is_empty() {
        topics = Topic::ALL.to_vec();
        topics.retain(|topic| *topic != Topic::Signals || !args.individuals.is_empty());
    }
    topics.sort();
    topics.dedup();
    if !args.individuals.is_empty() && !topics.contains(&Topic::Signals) {
        let message = "--individuals says whose signals are written; add `signals` to --tables";
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(topics)
}

/// The individuals of these experiments whose signals are meant, each once.
async fn individuals(
    store: &SqliteStore,
    experiments: &[StoredExperiment],
    args: &ExportArgs,
) -> Result<Vec<Individual>, Failure> {
    let mut names = args.individuals.clone();
    if names.is_empty() {
        names.push("best".to_owned());
    }
    let mut found: Vec<Individual> = Vec::new();
    for stored in experiments.iter().filter(|stored| stored.replications.iter().any(|r| r.generations > 0)) {
        let of = ReplicationFilter {
            experiment: Some(stored.experiment.name.clone()),
            ..ReplicationFilter::default()
        };
        let which = Which { individuals: names.clone(), of, generation: None };
        for individual in find(store, &which, crew(args.workers, &|| {})).await? {
            if !found.iter().any(|other| other.name == individual.name) {
                found.push(individual);
            }
        }
    }
    if found.is_empty() {
        return Err(Failure::new(
            Exit::Usage,
            "there are no individuals yet whose signals could be written; leave out `signals`",
        ));
    }
    warn_foreign(&found)?;
    Ok(found)
}

/// How much a table has to be made of: generations or, of signals, trials.
fn steps(topic: Topic, experiments: &[StoredExperiment], individuals: &[Individual]) -> u64 {
    if topic == Topic::Signals {
        return individuals.iter().map(|individual| individual.evaluated.outcomes.len() as u64).sum();
    }
    let replications = experiments.iter().flat_map(|stored| &stored.replications);
    replications.map(|replication| u64::from(replication.generations)).sum()
}

/// What that is called.
const fn unit(topic: Topic) -> &'static str {
    match topic {
        Topic::Generations => "generations",
        Topic::Individuals => "generations of individuals",
        Topic::Trials => "generations of trials",
        Topic::Signals => "trials of signals",
    }
}

/// Writes a replication's rows, generation by generation, so that no more than one is in memory. Those that a master
/// commits meanwhile are in none of the tables.
async fn write_replication(
    sheet: &mut Sheet,
    topic: Topic,
    store: &SqliteStore,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    bar: &ProgressBar,
) -> Result<(), Failure> {
    let simulator = Simulator::new(&stored.experiment)?;
    for generation in 0..replication.generations {
        let keys = (stored.experiment.name.as_str(), replication, generation);
        match topic {
            Topic::Generations => generations(sheet, store, keys).await?,
            Topic::Individuals => rank_and_file(sheet, store, keys).await?,
            Topic::Trials => trials(sheet, store, keys, &simulator).await?,
            Topic::Signals => {}
        }
        bar.inc(1);
    }
    Ok(())
}

type Keys<'a> = (&'a str, &'a StoredReplication, u32);

async fn generations(
    sheet: &mut Sheet,
    store: &SqliteStore,
    (experiment, replication, generation): Keys<'_>,
) -> Result<(), Failure> {
    for entry in store.list_generations(replication.id, Some(generation)).await? {
        sheet.push(&[
            experiment.into(),
            replication.number.into(),
            entry.generation.into(),
            entry.best_fitness.into(),
            entry.mean_fitness.into(),
            entry.best_individual.into(),
            entry.best_successes.into(),
            entry.most_successes.into(),
            entry.optimal_individuals.into(),
            entry.distinct_genotypes.into(),
            entry.wall_ms.into(),
            entry.committed_at.as_str().into(),
        ])?;
    }
    Ok(())
}

/// All individuals of a generation.
async fn rank_and_file(
    sheet: &mut Sheet,
    store: &SqliteStore,
    (experiment, replication, generation): Keys<'_>,
) -> Result<(), Failure> {
    let mut entries = store.list_individuals(replication.id, generation, false).await?;
    entries.sort_by_key(|entry| entry.individual);
    for entry in &entries {
        let flipped = entry.flipped.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        sheet.push(&[
            experiment.into(),
            replication.number.into(),
            generation.into(),
            entry.individual.into(),
            entry.rank.into(),
            entry.fitness.into(),
            entry.successes.into(),
            entry.origin.as_str().into(),
            entry.parent.into(),
            Value::Integer(entry.flipped.len() as i64),
            flipped.as_str().into(),
            entry.evaluated_as.into(),
            entry.failure.as_deref().into(),
        ])?;
    }
    Ok(())
}

async fn trials(
    sheet: &mut Sheet,
    store: &SqliteStore,
    (experiment, replication, generation): Keys<'_>,
    simulator: &Simulator,
) -> Result<(), Failure> {
    for entry in store.list_trials(replication.id, generation).await? {
        sheet.push(&[
            experiment.into(),
            replication.number.into(),
            generation.into(),
            entry.individual.into(),
            entry.trial.into(),
            Behaviour::name(simulator.behaviour(entry.trial)).into(),
            entry.score.into(),
            entry.success.into(),
            entry.steps.into(),
        ])?;
    }
    Ok(())
}

fn write_signals(sheet: &mut Sheet, individuals: &[Individual], bar: &ProgressBar) -> Result<(), Failure> {
    // What was given up has no trials to be run again.
    for individual in individuals.iter().filter(|individual| individual.evaluated.failure.is_none()) {
        let simulator = Simulator::new(&individual.experiment)?;
        let name = &individual.name;
        let keys = (name.experiment.as_str(), name.replication, name.generation, name.individual);
        for trial in 0..simulator.trial_count() {
            rows(sheet, keys, &recording(&simulator, individual, trial)?)?;
            bar.inc(1);
        }
    }
    Ok(())
}

/// Gives the files their names and lists them.
fn listed(written: Vec<Written>) -> Result<Table, Failure> {
    let mut table = Table::new(["table", "rows", "file"]);
    for written in written {
        let (topic, rows) = (written.topic, written.rows);
        let path = written.keep()?;
        table.push([topic.name().into(), rows.into(), path.display().to_string().into()]);
    }
    Ok(table)
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        let exit = if matches!(error, ExportError::Occupied(_)) { Exit::Usage } else { Exit::Unexpected };
        Self::new(exit, error)
    }
}
