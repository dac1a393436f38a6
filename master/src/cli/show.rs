//! `selftalk show`: an individual and its trials, with what went wrong in them.

use selftalk_sim::{Case, Simulator};

use super::args::ShowArgs;
use super::individuals::{Individual, find, foreign};
use super::output::{Cell, Table, print_tables};
use super::reference::Name;
use super::work::crew;
use super::{Format, Global, select, weights};
use crate::exit::{Exit, Failure};
use crate::retest::{Course, Tally, difference};
use crate::store::SqliteStore;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ShowArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let individuals = find(&store, &args.which, crew(args.workers, &|| {})).await?;
    if let Some(path) = &args.image {
        return weights::draw(&individuals, path);
    }
    if args.weights {
        return weights::print(&individuals, global);
    }
    if global.format != Format::Table {
        return trials(&individuals)?.print(global.format);
    }
    let mut tables = Vec::new();
    for individual in &individuals {
        tables.push(origin(&store, individual).await?);
        tables.push(behaviours(individual)?);
        tables.push(trials(std::slice::from_ref(individual))?.without(&IDENTITY));
    }
    print_tables(&tables)
}

/// Columns that are the same for all trials of an individual.
const IDENTITY: [&str; 5] = ["experiment", "replication", "generation", "individual", "fitness"];

/// The individual, and below it its parent.
async fn origin(store: &SqliteStore, individual: &Individual) -> Result<Table, Failure> {
    let mut table = Table::new([
        "individual",
        "rank",
        "fitness",
        "successes",
        "validation",
        "origin",
        "parent",
        "flipped",
    ]);
    let name = &individual.name;
    let line = store.lineage(individual.replication, name.generation, name.individual).await?;
    for (step, entry) in (0..2).zip(line) {
        let validation = individual.validation.filter(|_| step == 0);
        let shown = |tally: Tally| format!("{} of {}", tally.successes(), tally.trials());
        let call = |generation, individual| Name { generation, individual, ..name.clone() }.to_string();
        let parent = entry.parent.and_then(|parent| Some(call(entry.generation.checked_sub(1)?, parent)));
        table.push([
            call(entry.generation, entry.individual).into(),
            entry.rank.into(),
            entry.fitness.into(),
            entry.successes.into(),
            validation.map(shown).into(),
            entry.origin.into(),
            parent.into(),
            bits(&entry.flipped).into(),
        ]);
    }
    Ok(table)
}

/// Which bits were flipped, or how many if that would fill the screen.
fn bits(flipped: &[u32]) -> String {
    if flipped.len() > 12 {
        return format!("{} bits", flipped.len());
    }
    flipped.iter().map(u32::to_string).collect::<Vec<_>>().join(" ")
}

/// A line a behaviour.
fn behaviours(individual: &Individual) -> Result<Table, Failure> {
    let simulator = Simulator::new(&individual.experiment)?;
    let tally = Tally::of(&simulator, &individual.evaluated.outcomes);
    let mut table = Table::new(["behaviour", "trials", "successes", "score"]);
    for &behaviour in simulator.behaviours() {
        table.push([
            behaviour.name().into(),
            tally.trials_of(behaviour).into(),
            tally.successes_of(behaviour).into(),
            tally.score_of(behaviour).into(),
        ]);
    }
    Ok(table)
}

/// A line a trial. The trials are run again, and must come to what is stored.
pub(super) fn trials(individuals: &[Individual]) -> Result<Table, Failure> {
    let mut table = Table::new(
        IDENTITY
            .into_iter()
            .chain(["trial", "behaviour", "score", "success", "steps", "held", "focus", "reason"])
            .collect::<Vec<_>>(),
    );
    for individual in individuals {
        let Individual { name, experiment, evaluated, .. } = individual;
        let simulator = Simulator::new(experiment)?;
        for (trial, stored) in (0..).zip(&evaluated.outcomes) {
            let behaviour = simulator.behaviour(trial);
            let mut row: Vec<Cell> = vec![
                name.experiment.as_str().into(),
                name.replication.into(),
                name.generation.into(),
                name.individual.into(),
                individual.scored.fitness.into(),
                trial.into(),
                behaviour.name().into(),
                stored.score.into(),
                stored.success.into(),
                stored.steps.into(),
            ];
            if let Some(failure) = &evaluated.failure {
                row.extend([Cell::Empty, Cell::Empty, failure.as_str().into()]);
            } else {
                let case = Case::Drawn { draw: individual.draw(), trial };
                let trace = simulator.trace(&individual.member.genotype, case)?;
                if let Some(words) = difference(stored, &trace.outcome) {
                    return Err(differs(individual, trial, &words)?);
                }
                let course = Course::new(experiment, behaviour, &trace);
                row.extend([course.held().into(), course.focus().into(), course.reason().into()]);
            }
            table.push(row);
        }
    }
    Ok(table)
}

pub(super) fn differs(individual: &Individual, trial: u32, words: &str) -> Result<Failure, Failure> {
    let Individual { name, fingerprint, .. } = individual;
    let why = foreign(&name.experiment, fingerprint)?.map(|words| format!("; {words}")).unwrap_or_default();
    Ok(Failure::new(Exit::Mismatch, format!("{name}: trial {trial}: {words}{why}")))
}
