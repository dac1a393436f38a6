//! `selftalk evaluate`: how good individuals are in trials that nobody was selected by.

use std::sync::Arc;

use selftalk_sim::experiment::Engine;
use selftalk_sim::{Behaviour, Draw, Experiment, Simulator};

use super::args::{EvaluateArgs, Fresh};
use super::battery::post_evaluate;
use super::individuals::{Individual, find, warn_foreign};
use super::output::{Cell, Table};
use super::work::{bar, crew};
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::retest::{Crew, Tally, tallies, why};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: EvaluateArgs, global: &Global) -> Result<(), Failure> {
    let EvaluateArgs { which, fresh, post, why } = args;
    if post {
        return post_evaluate(&which.of, fresh.workers, global).await;
    }
    let store = select::open(global).await?;
    let individuals = find(&store, &which, crew(fresh.workers, &|| {})).await?;
    warn_foreign(&individuals)?;
    if why {
        return reasons(&individuals, fresh.trials)?.print(global.format);
    }
    let shares = evaluated(&individuals, None, &fresh)?;
    let mut table = Table::new(WHO.into_iter().chain(SHARES).collect::<Vec<_>>());
    for (individual, tally) in individuals.iter().zip(shares) {
        let mut row = who(individual, &tally);
        row.extend(shares_of(&tally));
        table.push(row);
    }
    table.print(global.format)
}

/// The object's areas, as the trials of a behaviour have them.
const AREAS: [&str; 4] = ["front", "back", "left", "right"];

/// A line for each of an individual's trials.
fn reasons(individuals: &[Individual], trials: u32) -> Result<Table, Failure> {
    let mut table = Table::new([
        "experiment",
        "replication",
        "generation",
        "individual",
        "trial",
        "behaviour",
        "area",
        "trials",
        "successes",
        "score",
        "focus",
        "reasons",
    ]);
    let bar = bar(individuals.len() as u64 * u64::from(trials));
    for Individual { name, experiment, member, .. } in individuals {
        let experiment = &experiment.unaided();
        let simulator = Simulator::new(experiment)?;
        let draws = fresh_draws(&simulator, &name.experiment, trials)?;
        for trial in 0..simulator.trial_count() {
            let area = AREAS[Behaviour::area_of_trial(experiment.task, trial)];
            let why = why(experiment, &simulator, &member.genotype, &draws, trial)?;
            bar.inc(why.trials.into());
            table.push([
                name.experiment.as_str().into(),
                name.replication.into(),
                name.generation.into(),
                name.individual.into(),
                trial.into(),
                simulator.behaviour(trial).name().into(),
                area.into(),
                why.trials.into(),
                why.successes.into(),
                why.score.into(),
                why.focus.into(),
                why.reasons.into(),
            ]);
        }
    }
    bar.finish_and_clear();
    Ok(table)
}

/// The draws of so many fresh trials of an experiment's individual.
fn fresh_draws(simulator: &Simulator, experiment: &str, trials: u32) -> Result<Vec<Draw>, Failure> {
    let each = simulator.trial_count();
    if !trials.is_multiple_of(each) {
        let message = format!(
            "--trials {trials}: an individual of `{experiment}` has {each} trials in each draw of positions, so a \
             multiple of {each} is needed"
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok((0..trials / each).map(Draw::test).collect())
}

/// Columns that say whose trials they are and how many.
pub(super) const WHO: [&str; 6] =
    ["experiment", "replication", "generation", "individual", "fitness", "trials"];
/// Columns of what trials came to.
const SHARES: [&str; 6] = ["reach", "open", "grasp", "move", "move_to_target", "all"];

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
    let shares = Behaviour::ALL.map(|behaviour| of(tally, behaviour, Tally::share_of));
    shares.into_iter().chain([tally.share().into()])
}

/// What the trials of a behaviour came to; nothing if there were none.
pub(super) fn of(tally: &Tally, behaviour: Behaviour, what: fn(&Tally, Behaviour) -> f64) -> Cell {
    if tally.trials_of(behaviour) == 0 { Cell::Empty } else { what(tally, behaviour).into() }
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
    let simulator = Simulator::new(&experiment.unaided())?;
    let draws = fresh_draws(&simulator, &experiment.name, trials)?;
    let genotypes: Vec<_> =
        individuals.iter().map(|individual| Arc::clone(&individual.member.genotype)).collect();
    Ok(tallies(&simulator, &genotypes, &draws, crew)?)
}
