//! `selftalk verify`: whether what is stored comes out again.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use indicatif::ProgressBar;
use selftalk_sim::{Case, Simulator, TrialOutcome};
use sha2::{Digest, Sha256};

use super::args::VerifyArgs;
use super::individuals::foreign;
use super::output::Table;
use super::work::{bar, crew};
use super::{Global, select};
use crate::evolution::draw;
use crate::exit::{Exit, Failure};
use crate::results::{BestRow, KeptStudy, Results, check};
use crate::retest::{Crew, Mismatch, Task, difference, examine, run as run_trials};
use crate::store::{GenerationEntry, GenerationRecord, SqliteStore, StoredExperiment, StoredReplication};

/// Trials that are run at a time, so that the threads seldom wait for each other.
const BATCH: usize = 20_000;
/// Mismatches that are named; of more only the number is told.
const NAMED: usize = 100;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: VerifyArgs, global: &Global) -> Result<(), Failure> {
    if let Some(folder) = &args.results {
        return results(folder, args.workers, global);
    }
    let store = select::open(global).await?;
    let scope = Scope::read(&store, &args).await?;
    let bar = bar(scope.trials());
    let mut table = Table::new([
        "experiment",
        "replication",
        "first",
        "last",
        "genotypes",
        "trials",
        "set_aside",
        "mismatches",
    ]);
    let mut found = Vec::new();
    for part in &scope.parts {
        let verified = verify(&store, part, args.workers, &bar).await?;
        let before = format!("{}/{}", part.stored.experiment.name, part.replication.number);
        table.push([
            part.stored.experiment.name.as_str().into(),
            part.replication.number.into(),
            part.entries.first().map(|entry| entry.generation).into(),
            part.entries.last().map(|entry| entry.generation).into(),
            verified.genotypes.into(),
            verified.trials.into(),
            Some(verified.set_aside).filter(|count| *count > 0).into(),
            (verified.mismatches.len() as u64).into(),
        ]);
        found.extend(verified.mismatches.into_iter().map(|mismatch| format!("{before}/{mismatch}")));
    }
    bar.finish_and_clear();
    table.print(global.format)?;
    told(&found)
}

/// Verifies a folder of results.
fn results(folder: &Path, workers: Option<u32>, global: &Global) -> Result<(), Failure> {
    if KeptStudy::is_in(folder) {
        return study(folder, workers, global);
    }
    let results = Results::read(folder)?;
    let name = &results.experiment.name;
    for digest in &results.digests {
        same_simulator(name, &digest.fingerprint)?;
    }
    let trials = |best: &BestRow| u64::from(16 + best.validation_trials + best.fresh_trials);
    let bar = bar(results.best.iter().map(trials).sum());
    let done = || bar.inc(1);
    let found = check(&results, crew(workers, &done))?;
    bar.finish_and_clear();
    let mut table = Table::new(["experiment", "individuals", "trials", "mismatches"]);
    table.push([
        name.as_str().into(),
        (results.best.len() as u64).into(),
        bar.position().into(),
        (found.len() as u64).into(),
    ]);
    table.print(global.format)?;
    told(&found)
}

/// Verifies a folder with a report of the second phase.
fn study(folder: &Path, workers: Option<u32>, global: &Global) -> Result<(), Failure> {
    let study = KeptStudy::read(folder)?;
    for (experiment, fingerprint) in study.fingerprints() {
        same_simulator(experiment, fingerprint)?;
    }
    let bar = bar(study.trials());
    let done = || bar.inc(1);
    let examined = study.check(crew(workers, &done))?;
    bar.finish_and_clear();
    let mut table = Table::new(["experiment", "individuals", "trials", "mismatches"]);
    for of in &examined {
        table.push([
            of.experiment.as_str().into(),
            of.robots.into(),
            of.trials.into(),
            (of.mismatches.len() as u64).into(),
        ]);
    }
    table.print(global.format)?;
    told(&examined.into_iter().flat_map(|of| of.mismatches).collect::<Vec<_>>())
}

/// # Errors
/// [`Exit::Mismatch`] when results were made with another simulator than this one.
fn same_simulator(experiment: &str, fingerprint: &str) -> Result<(), Failure> {
    match foreign(experiment, fingerprint)? {
        Some(words) => Err(Failure::new(Exit::Mismatch, format!("{words}; verify it with that release"))),
        None => Ok(()),
    }
}

/// Names mismatches on stderr.
///
/// # Errors
/// [`Exit::Mismatch`] when there are any.
fn told(found: &[String]) -> Result<(), Failure> {
    let Some(first) = found.first() else { return Ok(()) };
    for mismatch in found.iter().take(NAMED) {
        eprintln!("mismatch: {mismatch}");
    }
    if found.len() > NAMED {
        eprintln!("and {} more", found.len() - NAMED);
    }
    let message = match found.len() {
        1 => format!("1 mismatch: {first}"),
        count => format!("{count} mismatches; the first: {first}"),
    };
    Err(Failure::new(Exit::Mismatch, message))
}

/// What is verified.
struct Scope {
    parts: Vec<Part>,
}

/// Generations of a replication, and which of their genotypes are run again.
struct Part {
    stored: StoredExperiment,
    replication: StoredReplication,
    entries: Vec<GenerationEntry>,
    again: Again,
}

/// Which genotypes are run again.
enum Again {
    All,
    Best,
    /// Those at these places in the order in which the part has them, ascending.
    Places(Vec<u64>),
}

impl Scope {
    async fn read(store: &SqliteStore, args: &VerifyArgs) -> Result<Self, Failure> {
        let experiments = select::replications(store, &args.of).await?;
        let mut parts = Vec::new();
        for stored in &experiments {
            if let Some(words) = foreign(&stored.experiment.name, &stored.fingerprint)? {
                return Err(Failure::new(Exit::Mismatch, format!("{words}; verify it with that release")));
            }
            for replication in &stored.replications {
                let mut entries = store.list_generations(replication.id, None).await?;
                // A master may have added more since.
                entries.retain(|entry| {
                    entry.generation < replication.generations
                        && args.generation.is_none_or(|range| range.has(entry.generation))
                });
                if !entries.is_empty() {
                    let again = if args.best { Again::Best } else { Again::All };
                    parts.push(Part {
                        stored: stored.clone(),
                        replication: replication.clone(),
                        entries,
                        again,
                    });
                }
            }
        }
        if let (Some(range), true) = (args.generation, parts.is_empty()) {
            let all = experiments.iter().flat_map(|stored| &stored.replications);
            let most = all.map(|replication| replication.generations).max().unwrap_or_default();
            return Err(select::missing("generation", range.first, most as usize));
        }
        let mut scope = Self { parts };
        if let Some(size) = args.sample {
            scope.sample(size);
        }
        Ok(scope)
    }

    /// Leaves so many genotypes, evenly strewn over all.
    fn sample(&mut self, size: u64) {
        let total: u64 = self.parts.iter().map(Part::genotypes).sum();
        let size = size.min(total);
        let mut places = (0..size).map(|number| place(number, size, total)).peekable();
        let mut before = 0;
        for part in &mut self.parts {
            let end = before + part.genotypes();
            let mut inside = Vec::new();
            while let Some(place) = places.next_if(|place| *place < end) {
                inside.push(place - before);
            }
            before = end;
            part.again = Again::Places(inside);
        }
    }

    fn trials(&self) -> u64 {
        let genotypes = |part: &Part| match &part.again {
            Again::All => part.genotypes(),
            Again::Best => part.entries.len() as u64,
            Again::Places(places) => places.len() as u64,
        };
        16 * self.parts.iter().map(genotypes).sum::<u64>()
    }
}

/// The place of one of `size` among `total`: somewhere in its share of them, always the same.
fn place(number: u64, size: u64, total: u64) -> u64 {
    let share = |number: u64| (u128::from(number) * u128::from(total) / u128::from(size.max(1))) as u64;
    let (first, end) = (share(number), share(number + 1));
    let hash = Sha256::digest([number, size, total].map(u64::to_le_bytes).concat());
    let random = hash.iter().take(8).fold(0_u64, |number, byte| number << 8 | u64::from(*byte));
    first + random % (end - first).max(1)
}

impl Part {
    fn genotypes(&self) -> u64 {
        self.entries.iter().map(|entry| u64::from(entry.distinct_genotypes)).sum()
    }

    /// Which evaluations of a generation are run again; `before` is how many the part has before them.
    fn again(&self, record: &GenerationRecord, before: u64) -> Vec<usize> {
        let members = &record.population.members;
        let genotype = |member: u32| members.get(member as usize).map(|member| &member.genotype);
        let best = record.ranking.first().and_then(|best| genotype(*best));
        (0..record.evaluated.len())
            .filter(|at| match &self.again {
                Again::All => true,
                Again::Best => genotype(record.evaluated[*at].member) == best,
                Again::Places(places) => places.binary_search(&(before + *at as u64)).is_ok(),
            })
            .collect()
    }
}

#[derive(Default)]
struct Verified {
    genotypes: u64,
    trials: u64,
    set_aside: u64,
    mismatches: Vec<Mismatch>,
}

async fn verify(
    store: &SqliteStore,
    part: &Part,
    workers: Option<u32>,
    bar: &ProgressBar,
) -> Result<Verified, Failure> {
    let Part { stored, replication, entries, .. } = part;
    let experiment = &stored.experiment;
    let simulator = Simulator::new(experiment)?;
    let mut verified = Verified::default();
    let mut batch = Batch::default();
    let done = || bar.inc(1);
    let crew = crew(workers, &done);
    let behaviours: HashMap<u32, _> = store.list_behaviours(replication.id).await?.into_iter().collect();
    let mut generations = store.generations(replication);
    let before = entries.first().and_then(|entry| entry.generation.checked_sub(1));
    let mut previous = match before {
        Some(before) => Some(generations.read(before).await?),
        None => None,
    };
    let mut before = 0;
    for entry in entries {
        let record = generations.read(entry.generation).await?;
        let behaviours = behaviours.get(&entry.generation).map_or(&[][..], Vec::as_slice);
        verified.mismatches.extend(examine(
            experiment,
            &simulator,
            previous.as_ref(),
            &record,
            entry,
            behaviours,
        ));
        for at in part.again(&record, before) {
            let evaluated = &record.evaluated[at];
            let Some(member) = record.population.members.get(evaluated.member as usize) else { continue };
            if evaluated.failure.is_some() {
                verified.set_aside += 1;
                continue;
            }
            verified.genotypes += 1;
            let draw = draw(experiment, replication.number, entry.generation);
            for (trial, stored) in (0..simulator.trial_count()).zip(&evaluated.outcomes) {
                let genotype = Arc::clone(&member.genotype);
                batch.tasks.push(Task { genotype, case: Case::Drawn { draw, trial } });
                batch.stored.push(Stored {
                    generation: entry.generation,
                    individual: evaluated.member,
                    trial,
                    outcome: *stored,
                });
            }
        }
        before += u64::from(entry.distinct_genotypes);
        if batch.tasks.len() >= BATCH {
            batch.run(&simulator, crew, &mut verified)?;
        }
        previous = Some(record);
    }
    batch.run(&simulator, crew, &mut verified)?;
    Ok(verified)
}

/// Trials to be run, and what is stored of them.
#[derive(Default)]
struct Batch {
    tasks: Vec<Task>,
    stored: Vec<Stored>,
}

/// The outcome that is stored of a trial.
struct Stored {
    generation: u32,
    individual: u32,
    trial: u32,
    outcome: TrialOutcome,
}

impl Batch {
    fn run(&mut self, simulator: &Simulator, crew: Crew<'_>, verified: &mut Verified) -> Result<(), Failure> {
        let outcomes = run_trials(simulator, &self.tasks, crew)?;
        verified.trials += outcomes.len() as u64;
        self.tasks.clear();
        for (Stored { generation, individual, trial, outcome }, again) in self.stored.drain(..).zip(outcomes)
        {
            if let Some(what) = difference(&outcome, &again) {
                let (individual, trial) = (Some(individual), Some(trial));
                verified.mismatches.push(Mismatch { generation, individual, trial, what });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_strewn_over_all_and_stays_the_same() {
        let places: Vec<u64> = (0..10).map(|number| place(number, 10, 1000)).collect();
        assert_eq!(places, (0..10).map(|number| place(number, 10, 1000)).collect::<Vec<_>>());
        for (number, place) in (0..).zip(&places) {
            assert!((100 * number..100 * (number + 1)).contains(place), "{places:?}");
        }
        let offsets: std::collections::BTreeSet<u64> = places.iter().map(|place| place % 100).collect();
        assert!(offsets.len() > 5, "{places:?}");
        assert!((0..7).map(|number| place(number, 7, 7)).eq(0..7));
        assert_eq!(place(0, 3, 0), 0);
    }
}
