//! Running the individuals of a folder of results again.

use std::sync::Arc;

use selftalk_sim::{Behaviour, Draw, Genotype, Simulator, TrialOutcome};

use super::{BestRow, Results, ResultsError, SummaryRow, TrialRow};
use crate::evolution::{draw, score};
use crate::retest::{Crew, Tally, Task, difference, run, tallies};
use crate::store::kept_bits;

/// Everything in the results that does not come out again or contradicts itself, in words: the champions' trials in
/// their own generations to the last bit, what they came to when they were chosen and in fresh trials, and what the
/// summary says of the generations. How the generations came about is not in the results.
///
/// # Errors
/// [`ResultsError`] when an individual cannot be run.
pub fn check(results: &Results, crew: Crew<'_>) -> Result<Vec<String>, ResultsError> {
    let simulator = Simulator::new(&results.experiment)?;
    let mut found = Vec::new();
    numbers(results, &mut found);
    for summary in &results.summary {
        summarised(results, summary, &mut found);
    }
    for best in &results.best {
        match Genotype::from_hex(&best.genes)
            .ok()
            .filter(|genotype| genotype.genes().len() == simulator.gene_count())
        {
            Some(genotype) => champion(results, best, &simulator, &Arc::new(genotype), crew, &mut found)?,
            None => found.push(format!("{}: the genes are not a genotype", name(results, best))),
        }
    }
    Ok(found)
}

fn name(results: &Results, best: &BestRow) -> String {
    format!("{}/{}/{}/{}", results.experiment.name, best.replication, best.generation, best.individual)
}

/// That every file has the same replications.
fn numbers(results: &Results, found: &mut Vec<String>) {
    let all: Vec<u32> = results.summary.iter().map(|row| row.replication).collect();
    let begun: Vec<u32> =
        results.summary.iter().filter(|row| row.generations > 0).map(|row| row.replication).collect();
    if !results.best.iter().map(|row| row.replication).eq(begun) {
        found.push("best.csv has not one individual for each replication of summary.csv".to_owned());
    }
    if !results.digests.iter().map(|row| row.replication).eq(all) {
        found.push("digest.csv has not the replications of summary.csv".to_owned());
    }
}

/// What the summary says of the generations.
fn summarised(results: &Results, summary: &SummaryRow, found: &mut Vec<String>) {
    let SummaryRow { replication, generations, first_optimal_generation, .. } = *summary;
    let rows = || results.generations.iter().filter(|row| row.replication == replication);
    let mut wrong = |what: String| found.push(format!("{}/{replication}: {what}", results.experiment.name));
    if !rows().map(|row| row.generation).eq(0..generations) {
        wrong(format!("generations.csv does not have {generations} generations, as summary.csv says"));
    }
    for row in rows().filter(|row| row.reach + row.open + row.grasp + row.transport != row.best_successes) {
        wrong(format!("the successes of generation {} do not add up", row.generation));
    }
    let most = rows().map(|row| row.best_successes).max().unwrap_or_default();
    if most != summary.best_successes_of_16 {
        wrong(format!(
            "{} successes in summary.csv are {most} in generations.csv",
            summary.best_successes_of_16
        ));
    }
    let optimal = rows().find(|row| row.best_successes == 16).map(|row| row.generation);
    if optimal.is_some_and(|optimal| first_optimal_generation.is_none_or(|first| first > optimal)) {
        wrong("a best individual was optimal before first_optimal_generation".to_owned());
    }
    let digest = results.digests.iter().find(|row| row.replication == replication);
    if digest.is_some_and(|row| row.generations != generations || row.experiment != results.experiment.name) {
        wrong("digest.csv is of another history".to_owned());
    }
}

/// That a champion comes to the same again.
fn champion(
    results: &Results,
    best: &BestRow,
    simulator: &Simulator,
    genotype: &Arc<Genotype>,
    crew: Crew<'_>,
    found: &mut Vec<String>,
) -> Result<(), ResultsError> {
    let name = name(results, best);
    let mut wrong = |what: String| found.push(format!("{name}: {what}"));
    let rows: Vec<&TrialRow> =
        results.trials.iter().filter(|row| row.replication == best.replication).collect();
    let stored: Option<Vec<TrialOutcome>> = rows.iter().map(|row| row.outcome()).collect();
    let Some(stored) = stored.filter(|_| rows.iter().map(|row| row.trial).eq(0..simulator.trial_count()))
    else {
        wrong("trials.csv does not have its trials".to_owned());
        return Ok(());
    };
    let own = draw(&results.experiment, best.replication, best.generation);
    let tasks: Vec<Task> = Task::all(simulator, genotype, own).collect();
    let again = run(simulator, &tasks, crew)?;
    for (row, (stored, again)) in rows.iter().zip(stored.iter().zip(&again)) {
        let written = kept_bits(row.score) == kept_bits(stored.score);
        if !written || row.behaviour != simulator.behaviour(row.trial).name() {
            wrong(format!("trial {}: score or behaviour is not that of its bits", row.trial));
        }
        if let Some(words) = difference(stored, again) {
            wrong(format!("trial {}: {words}", row.trial));
        }
    }
    let worth = score(simulator, &again);
    if kept_bits(worth.fitness) != kept_bits(best.fitness) || worth.successes != best.successes {
        wrong(format!(
            "fitness {} and {} successes are stored, {} and {} come out",
            best.fitness, best.successes, worth.fitness, worth.successes
        ));
    }
    let anew = |trials: u32, draw: fn(u32) -> Draw| -> Result<Tally, ResultsError> {
        let draws: Vec<Draw> = (0..trials / simulator.trial_count().max(1)).map(draw).collect();
        let tallies = tallies(simulator, std::slice::from_ref(genotype), &draws, crew)?;
        Ok(tallies.first().copied().unwrap_or_default())
    };
    let validation = anew(best.validation_trials, Draw::validation)?;
    if validation.successes() != best.validation_successes {
        let (stored, again) = (best.validation_successes, validation.successes());
        wrong(format!("{stored} successes are stored of its validation, {again} come out"));
    }
    let fresh = anew(best.fresh_trials, Draw::test)?;
    for summary in results.summary.iter().filter(|row| row.replication == best.replication) {
        let shares = [summary.fresh_reach, summary.fresh_open, summary.fresh_grasp, summary.fresh_move];
        for (behaviour, stored) in Behaviour::ELEMENTARY.into_iter().zip(shares) {
            let again = fresh.share_of(behaviour);
            if kept_bits(stored) != kept_bits(again) {
                let behaviour = behaviour.name();
                wrong(format!(
                    "{stored} is stored as share of fresh trials of {behaviour}, {again} comes out"
                ));
            }
        }
    }
    Ok(())
}
