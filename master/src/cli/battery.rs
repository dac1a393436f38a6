//! `selftalk evaluate --post` and `selftalk generalise`: the tests of the second phase, whose outcomes are kept.

use std::sync::Arc;

use selftalk_sim::Genotype;
use selftalk_sim::experiment::{Speaks, Task};

use super::args::{GeneraliseArgs, ReplicationFilter};
use super::choose::open_existing;
use super::individuals::foreign;
use super::output::{Cell, Table};
use super::work::{bar, crew};
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::retest::{Crew, battery};
use crate::store::{GenerationRecord, Retest, SqliteStore, StoredExperiment, StoredReplication, Test};

/// Generations whose outcomes are kept at once: what is lost when the program is killed.
const AT_ONCE: usize = 20;

/// Post-evaluation: the best individual of every generation, in 40 fresh trials without a caretaker.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub(super) async fn post_evaluate(
    of: &ReplicationFilter,
    workers: Option<u32>,
    global: &Global,
) -> Result<(), Failure> {
    let store = open_existing(global).await?;
    let experiments = meant(&store, of).await?;
    let mut table = Table::new(["experiment", "replication", "best_generation", "trials", "successes"]);
    for stored in &experiments {
        for replication in &stored.replications {
            post_evaluate_replication(&store, stored, replication, workers, &|| Ok(())).await?;
            if let Some(best) = best(&store, replication).await? {
                table.push([
                    stored.experiment.name.as_str().into(),
                    replication.number.into(),
                    best.generation.into(),
                    (best.outcomes.len() as u64).into(),
                    best.successes().into(),
                ]);
            }
        }
    }
    store.close().await?;
    table.print(global.format)
}

/// Generalisation: the best robot of each replication, at the places of a grid; where there is a caretaker, with it and
/// without.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn generalise(args: GeneraliseArgs, global: &Global) -> Result<(), Failure> {
    let store = open_existing(global).await?;
    let experiments = meant(&store, &args.of).await?;
    let mut table = Table::new([
        "experiment",
        "replication",
        "generation",
        "trials",
        "successes",
        "steps_to_goal",
        "aided_successes",
        "aided_steps_to_goal",
    ]);
    for stored in &experiments {
        for replication in &stored.replications {
            generalise_replication(&store, stored, replication, args.workers, &|| Ok(())).await?;
            let alone = store.list_retests(replication.id, Test::Generalisation).await?;
            let aided = store.list_retests(replication.id, Test::Aided).await?;
            let Some(best) = best(&store, replication).await? else { continue };
            let of = |all: &[Retest]| all.iter().find(|kept| kept.generation == best.generation).cloned();
            let Some(alone) = of(&alone) else { continue };
            let aided = of(&aided);
            table.push([
                stored.experiment.name.as_str().into(),
                replication.number.into(),
                best.generation.into(),
                (alone.outcomes.len() as u64).into(),
                alone.successes().into(),
                steps_to_goal(&alone),
                aided.as_ref().map(Retest::successes).into(),
                aided.as_ref().map_or(Cell::Empty, steps_to_goal),
            ]);
        }
    }
    store.close().await?;
    table.print(global.format)
}

/// Mean length of the trials that succeeded.
fn steps_to_goal(retest: &Retest) -> Cell {
    let steps = retest.outcomes.iter().filter(|outcome| outcome.success).map(|outcome| outcome.steps);
    let sum: u32 = steps.sum();
    if sum == 0 { Cell::Empty } else { (f64::from(sum) / f64::from(retest.successes())).into() }
}

/// The experiments of the second phase that are meant.
async fn meant(store: &SqliteStore, of: &ReplicationFilter) -> Result<Vec<StoredExperiment>, Failure> {
    let mut experiments = select::replications(store, of).await?;
    experiments.retain(|stored| stored.experiment.task == Task::MoveToTarget);
    for stored in &experiments {
        if let Some(words) = foreign(&stored.experiment.name, &stored.fingerprint)? {
            return Err(Failure::new(Exit::Mismatch, format!("{words}; test its robots with that release")));
        }
    }
    if experiments.is_empty() {
        let message = "there is no experiment of the second phase; `selftalk run integrated-lst --ancestors elementary` runs \
                       one";
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(experiments)
}

/// What the best robot of a replication came to in post-evaluation: the one with most successes, of several the latest.
///
/// # Errors
/// [`Failure`] when the history cannot be read.
pub(super) async fn best(
    store: &SqliteStore,
    replication: &StoredReplication,
) -> Result<Option<Retest>, Failure> {
    let kept = store.list_retests(replication.id, Test::Post).await?;
    Ok(kept.into_iter().max_by_key(Retest::successes))
}

/// Whether to go on with the tests, asked now and then.
pub(super) type GoOn<'a> = &'a (dyn Fn() -> Result<(), Failure> + Sync);

/// Runs what is not kept yet.
pub(super) async fn post_evaluate_replication(
    store: &SqliteStore,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    workers: Option<u32>,
    go_on: GoOn<'_>,
) -> Result<(), Failure> {
    let kept = store.list_retests(replication.id, Test::Post).await?;
    let mut generations = store.generations(replication);
    let missing: Vec<u32> = (0..replication.generations)
        .filter(|generation| kept.iter().all(|retest| retest.generation != *generation))
        .collect();
    let bar = bar(missing.len() as u64 * 40);
    for now in missing.chunks(AT_ONCE) {
        go_on()?;
        let mut robots = Vec::new();
        for generation in now {
            robots.extend(robot(&generations.read(*generation).await?));
        }
        let done = || bar.inc(1);
        let retests = tested(stored, Test::Post, &robots, crew(workers, &done))?;
        store.keep_retests(replication.id, Test::Post, &retests).await?;
    }
    bar.finish_and_clear();
    Ok(())
}

/// Runs what is not kept yet.
pub(super) async fn generalise_replication(
    store: &SqliteStore,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    workers: Option<u32>,
    go_on: GoOn<'_>,
) -> Result<(), Failure> {
    let Some(best) = best(store, replication).await? else {
        let name = &stored.experiment.name;
        let message = format!(
            "which robots of `{name}` are best is not known yet; `selftalk evaluate --post --experiment {name}` \
             finds out"
        );
        return Err(Failure::new(Exit::Usage, message));
    };
    let hears = stored.experiment.caretaker.speaks != Speaks::Never;
    for test in [Test::Generalisation, Test::Aided].into_iter().filter(|test| hears || *test != Test::Aided) {
        let kept = store.list_retests(replication.id, test).await?;
        if kept.iter().any(|retest| retest.generation == best.generation) {
            continue;
        }
        go_on()?;
        let record = store.generations(replication).read(best.generation).await?;
        let robots: Vec<Robot> = robot(&record).into_iter().collect();
        let bar = bar(u64::from(selftalk_sim::Case::GRID_TRIALS));
        let done = || bar.inc(1);
        let retests = tested(stored, test, &robots, crew(workers, &done))?;
        bar.finish_and_clear();
        store.keep_retests(replication.id, test, &retests).await?;
    }
    Ok(())
}

/// The best individual of a generation.
struct Robot {
    generation: u32,
    /// The individual that was evaluated with its genotype.
    evaluated: u32,
    genotype: Arc<Genotype>,
}

fn robot(record: &GenerationRecord) -> Option<Robot> {
    let members = &record.population.members;
    let genotype = &members.get(*record.ranking.first()? as usize)?.genotype;
    let same = |number: &u32| members.get(*number as usize).is_some_and(|other| other.genotype == *genotype);
    let evaluated = record.evaluated.iter().map(|evaluated| evaluated.member).find(same)?;
    Some(Robot { generation: record.population.generation, evaluated, genotype: Arc::clone(genotype) })
}

fn tested(
    stored: &StoredExperiment,
    test: Test,
    robots: &[Robot],
    crew: Crew<'_>,
) -> Result<Vec<Retest>, Failure> {
    let genotypes: Vec<_> = robots.iter().map(|robot| Arc::clone(&robot.genotype)).collect();
    let outcomes = battery(&stored.experiment, test, &genotypes, crew)?;
    let retest = |(robot, outcomes): (&Robot, _)| Retest {
        generation: robot.generation,
        individual: robot.evaluated,
        outcomes,
    };
    Ok(robots.iter().zip(outcomes).map(retest).collect())
}
