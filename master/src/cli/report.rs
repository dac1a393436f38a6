//! `selftalk report`: what the second training phase came to, as figures, tables and a page.

use selftalk_sim::experiment::{Speaks, Task};

use super::args::ReportArgs;
use super::battery::best;
use super::digest::checksum;
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::report::{Condition, CurveRow, ReportError, Robot, Study, label};
use crate::store::{Retest, SqliteStore, StoredExperiment, StoredReplication, Test};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ReportArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let mut experiments = Vec::new();
    for name in &args.experiments {
        experiments.extend(select::experiments(&store, Some(name)).await?);
    }
    if args.experiments.is_empty() {
        experiments = select::experiments(&store, None).await?;
        experiments.retain(|stored| stored.experiment.task == Task::MoveToTarget);
    }
    if experiments.is_empty() {
        let message = "there is no experiment of the second phase; `selftalk run integrated-lst --ancestors elementary` runs \
                       one";
        return Err(Failure::new(Exit::Usage, message));
    }
    let study = gathered(&store, &experiments).await?;
    study.write(&args.out)?;
    eprintln!("{} has the page", args.out.join("report.md").display());
    Ok(())
}

/// Reads what was kept of the experiments' robots.
///
/// # Errors
/// [`Exit::Usage`] when a test is missing.
pub(super) async fn gathered(
    store: &SqliteStore,
    experiments: &[StoredExperiment],
) -> Result<Study, Failure> {
    let mut conditions = Vec::with_capacity(experiments.len());
    for stored in experiments {
        conditions.push(condition(store, stored).await?);
    }
    Ok(Study::new(conditions))
}

async fn condition(store: &SqliteStore, stored: &StoredExperiment) -> Result<Condition, Failure> {
    let label = label(&stored.experiment);
    let mut condition = Condition {
        label: label.clone(),
        experiment: stored.experiment.clone(),
        robots: Vec::new(),
        curve: Vec::new(),
        digests: Vec::new(),
        fingerprint: stored.fingerprint.clone(),
    };
    for replication in &stored.replications {
        condition.robots.push(robot(store, stored, replication).await?);
        let post = store.list_retests(replication.id, Test::Post).await?;
        for entry in store.list_generations(replication.id, None).await? {
            let Some(kept) = post.iter().find(|kept| kept.generation == entry.generation) else { continue };
            condition.curve.push(CurveRow {
                condition: label.clone(),
                replication: replication.number,
                generation: entry.generation,
                fitness: entry.best_fitness,
                successes_of_8: entry.best_successes,
                post_successes_of_40: kept.successes(),
            });
        }
        condition.digests.push((replication.number, checksum(store, replication).await?));
    }
    Ok(condition)
}

async fn robot(
    store: &SqliteStore,
    stored: &StoredExperiment,
    replication: &StoredReplication,
) -> Result<Robot, Failure> {
    let name = &stored.experiment.name;
    let missing = |command: &str| {
        let message = format!(
            "replication {} of `{name}` has not been tested; `selftalk {command} --experiment {name}` does",
            replication.number
        );
        Failure::new(Exit::Usage, message)
    };
    let Some(post) = best(store, replication).await? else { return Err(missing("evaluate --post")) };
    let mut tests = Vec::new();
    for test in [Test::Generalisation, Test::Aided] {
        let kept = store.list_retests(replication.id, test).await?;
        tests.push(kept.into_iter().find(|kept| kept.generation == post.generation));
    }
    let aided = tests.pop().flatten();
    let generalisation = tests.pop().flatten().ok_or_else(|| missing("generalise"))?;
    if aided.is_none() && stored.experiment.caretaker.speaks != Speaks::Never {
        return Err(missing("generalise"));
    }
    let record = store.generations(replication).read(post.generation).await?;
    let Retest { generation, individual, outcomes: post } = post;
    let member = record.population.members.get(individual as usize);
    Ok(Robot {
        replication: replication.number,
        generation,
        individual,
        genes: member.map_or(String::new(), |member| member.genotype.to_hex()),
        post,
        generalisation: generalisation.outcomes,
        aided: aided.map(|kept| kept.outcomes),
    })
}

impl From<ReportError> for Failure {
    fn from(error: ReportError) -> Self {
        Self::new(Exit::Unexpected, error)
    }
}
