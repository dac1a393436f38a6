//! Looks into workers that the master before could not look into any more, as it was killed or told to stop.

use std::collections::{BTreeMap, BTreeSet};

use selftalk_sim::Simulator;

use super::DriverError;
use crate::evolution::draw;
use crate::service::is_right;
use crate::store::{ExperimentId, ReplicationId, Store, StoredExperiment, Unproven, WorkerId};

/// What is to be done about the workers that were looked into.
#[derive(Debug, Default)]
struct Judgement {
    right: BTreeSet<WorkerId>,
    /// The first generation of each replication that is in doubt.
    doubted: BTreeMap<ReplicationId, u32>,
}

/// Evaluates the last answer of every worker again of which it is not known that it was right, as far as it has contributed to
/// these experiments, and takes back all that wrong ones have contributed to. Returns the experiments as they stand then.
///
/// # Errors
/// [`DriverError`] when the history cannot be read or written, or the simulator not be set up.
pub async fn settle_doubts<S: Store>(
    store: &S,
    experiments: &[StoredExperiment],
) -> Result<Vec<StoredExperiment>, DriverError> {
    let known: BTreeSet<ExperimentId> = experiments.iter().map(|stored| stored.id).collect();
    let (unproven, foreign): (Vec<Unproven>, Vec<Unproven>) =
        store.unproven().await?.into_iter().partition(|unproven| known.contains(&unproven.experiment));
    if unproven.is_empty() {
        return Ok(experiments.to_vec());
    }
    tracing::info!(answers = unproven.len(), "looking into what was left of the run before");
    let settings = experiments.to_vec();
    let judge = tokio::task::spawn_blocking(move || judge(&settings, unproven));
    let Judgement { mut right, doubted } =
        judge.await.map_err(|error| DriverError::Panicked(error.to_string()))??;
    // What they have contributed to other experiments is looked into with those.
    let elsewhere: BTreeSet<WorkerId> = foreign.iter().map(|unproven| unproven.worker).collect();
    right.retain(|worker| !elsewhere.contains(worker));
    for (replication, from) in &doubted {
        tracing::warn!(replication = replication.0, from, "taken back from this generation on");
        store.take_back(*replication, *from).await?;
    }
    store.workers_audited(&right.into_iter().collect::<Vec<_>>()).await?;
    let mut now = Vec::with_capacity(experiments.len());
    for stored in experiments {
        now.extend(store.experiment(&stored.experiment.name).await?);
    }
    Ok(now)
}

/// Evaluates answers again. One wrong answer of a worker puts all it has contributed to in doubt.
fn judge(experiments: &[StoredExperiment], unproven: Vec<Unproven>) -> Result<Judgement, DriverError> {
    let mut simulators: BTreeMap<ExperimentId, (&StoredExperiment, Simulator)> = BTreeMap::new();
    for stored in experiments {
        simulators.insert(stored.id, (stored, Simulator::new(&stored.experiment)?));
    }
    let is_wrong = |answer: &Unproven| {
        simulators.get(&answer.experiment).is_some_and(|(stored, simulator)| {
            let draw = draw(&stored.experiment, answer.replication, answer.generation);
            !is_right(simulator, draw, &answer.genotype, &answer.outcomes)
        })
    };
    let mut wrong: BTreeMap<WorkerId, &str> = BTreeMap::new();
    for answer in unproven.iter().filter(|answer| is_wrong(answer)) {
        wrong.insert(answer.worker, &answer.name);
    }
    for (worker, name) in &wrong {
        tracing::error!(worker = worker.0, name, "a worker had given wrong results before the master ended");
    }
    let mut judgement = Judgement::default();
    for answer in &unproven {
        if !wrong.contains_key(&answer.worker) {
            judgement.right.insert(answer.worker);
            continue;
        }
        for &(replication, first) in &answer.since {
            let from = judgement.doubted.entry(replication).or_insert(first);
            *from = first.min(*from);
        }
    }
    Ok(judgement)
}
