//! `selftalk evaluate`: how good individuals are in trials that nobody was selected by.

use std::sync::Arc;

use selftalk_sim::experiment::Engine;
use selftalk_sim::{Behaviour, Draw, Experiment, Simulator};

use super::args::{EvaluateArgs, Fresh};
use super::individuals::{Individual, find, warn_foreign};
use super::output::{Cell, Table};
use super::work::{bar, crew};
use super::{Global, select};
use crate::exit::Failure;
use crate::retest::{Crew, Tally, tallies};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: EvaluateArgs, global: &Global) -> Result<(), Failure> {
    let EvaluateArgs { which, fresh } = args;
    let store = select::open(global).await?;
    let individuals = find(&store, &which, crew(fresh.workers, &|| {})).await?;
    warn_foreign(&individuals)?;
    let shares = evaluated(&individuals, None, &fresh)?;
    let mut table = Table::new(WHO.into_iter().chain(SHARES).collect::<Vec<_>>());
    for (individual, tally) in individuals.iter().zip(shares) {
        let mut row = who(individual, &tally);
        row.extend(shares_of(&tally));
        table.push(row);
    }
    table.print(global.format)
}

/// Columns that say whose trials they are and how many.
pub(super) const WHO: [&str; 6] =
    ["experiment", "replication", "generation", "individual", "fitness", "trials"];
/// Columns of what trials came to.
const SHARES: [&str; 5] = ["reach", "open", "grasp", "move", "all"];

pub(super) fn who(individual: &Individual, tally: &Tally) -> Vec<Cell> {
    let Individual { name, scored, .. } = individual;
    vec![
        name.experiment.as_str().into(),
        name.replication.into(),
        name.generation.into(),
        name.individual.into(),
        scored.fitness.into(),
        tally.trials().into(),
    ]
}

/// The share of successes of each behaviour, and of all.
pub(super) fn shares_of(tally: &Tally) -> impl Iterator<Item = Cell> {
    Behaviour::ALL
        .map(|behaviour| tally.share_of(behaviour))
        .into_iter()
        .chain([tally.share()])
        .map(Cell::from)
}

/// Runs individuals in fresh trials, in their own engine or in another, and adds up what each comes to.
///
/// # Errors
/// [`crate::exit::Exit::Unexpected`] when an individual does not fit its experiment.
pub(super) fn evaluated(
    individuals: &[Individual],
    engine: Option<Engine>,
    fresh: &Fresh,
) -> Result<Vec<Tally>, Failure> {
    let bar = bar(individuals.len() as u64 * u64::from(fresh.trials));
    let done = || bar.inc(1);
    let crew = crew(fresh.workers, &done);
    let mut all = Vec::with_capacity(individuals.len());
    // The individuals of an experiment run side by side.
    for of_one in individuals.chunk_by(|a, b| a.name.experiment == b.name.experiment) {
        let Some(first) = of_one.first() else { continue };
        let engine = engine.unwrap_or(first.experiment.engine);
        all.extend(in_fresh_trials(
            of_one,
            &Experiment { engine, ..first.experiment.clone() },
            fresh.trials,
            crew,
        )?);
    }
    bar.finish_and_clear();
    Ok(all)
}

/// Runs individuals of one experiment in fresh trials.
///
/// # Errors
/// [`crate::exit::Exit::Unexpected`] when an individual does not fit the experiment.
pub(super) fn in_fresh_trials(
    individuals: &[Individual],
    experiment: &Experiment,
    trials: u32,
    crew: Crew<'_>,
) -> Result<Vec<Tally>, Failure> {
    let simulator = Simulator::new(experiment)?;
    let draws: Vec<Draw> = (0..trials / simulator.trial_count().max(1)).map(Draw::test).collect();
    let genotypes: Vec<_> =
        individuals.iter().map(|individual| Arc::clone(&individual.member.genotype)).collect();
    Ok(tallies(&simulator, &genotypes, &draws, crew)?)
}
