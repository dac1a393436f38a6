//! The records of a history.

use std::sync::Arc;
use std::time::Duration;

use selftalk_sim::experiment::Task;
use selftalk_sim::{Behaviour, Experiment, Genotype, TrialOutcome};

use crate::evolution::{Population, Scored};

/// Key of an experiment in its database.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExperimentId(pub i64);

/// Key of a replication in its database.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ReplicationId(pub i64);

/// Key of a worker in its database: one connection of one worker process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WorkerId(pub i64);

/// How far a replication or an experiment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplicationState {
    /// There are generations left to run, whether a master is at it or not.
    Running,
    /// All generations were run, or the first optimum was found and that was to be the end.
    Finished,
}

impl ReplicationState {
    /// Lower-case name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Finished => "finished",
        }
    }
}

/// An experiment as it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredExperiment {
    /// Its key.
    pub id: ExperimentId,
    /// Its settings, complete.
    pub experiment: Experiment,
    /// Fingerprint of the simulator it was begun with.
    pub fingerprint: String,
    /// When it was created: RFC 3339, UTC.
    pub created_at: String,
    /// Its replications, ordered by number.
    pub replications: Vec<StoredReplication>,
}

impl StoredExperiment {
    /// Finished when all replications are.
    #[must_use]
    pub fn state(&self) -> ReplicationState {
        let finished = self.replications.iter().all(|replication| replication.finished);
        if finished { ReplicationState::Finished } else { ReplicationState::Running }
    }
}

/// A replication as it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredReplication {
    /// Its key.
    pub id: ReplicationId,
    /// Replication, counted from 0.
    pub number: u32,
    /// Whether it is done.
    pub finished: bool,
    /// Committed generations.
    pub generations: u32,
    /// What the last of them came to.
    pub last: Option<GenerationSummary>,
    /// The first generation with an individual that succeeded in all trials.
    pub first_optimal: Option<u32>,
}

impl StoredReplication {
    /// How far it is.
    #[must_use]
    pub const fn state(&self) -> ReplicationState {
        if self.finished { ReplicationState::Finished } else { ReplicationState::Running }
    }
}

/// What a generation came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GenerationSummary {
    /// Fitness of the best individual.
    pub best_fitness: f64,
    /// Mean fitness of the population.
    pub mean_fitness: f64,
    /// Successful trials of the best individual.
    pub best_successes: u32,
    /// Most successful trials of any individual.
    pub most_successes: u32,
    /// Individuals that succeeded in all trials.
    pub optimal: u32,
    /// Distinct genotypes, each of them evaluated once.
    pub distinct: u32,
}

/// What trials of a behaviour came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BehaviourSummary {
    /// The behaviour.
    pub behaviour: Behaviour,
    /// Trials of it, at least one.
    pub trials: u32,
    /// Those that succeeded.
    pub successes: u32,
    /// Their mean score; one that is not a finite number counts as 0.
    pub score: f64,
}

/// What the evaluation of a distinct genotype gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluated {
    /// The first member that carries the genotype.
    pub member: u32,
    /// The outcomes of trials 0, 1, 2, ... A score that is not a finite number is kept as NaN.
    pub outcomes: Vec<TrialOutcome>,
    /// Who ran the trials, or the last of them.
    pub worker: Option<WorkerId>,
    /// Why there are no real outcomes, if the evaluation was given up.
    pub failure: Option<String>,
}

/// A generation to be written.
#[derive(Debug, Clone, Copy)]
pub struct GenerationCommit<'a> {
    /// The replication it belongs to.
    pub replication: ReplicationId,
    /// What its trials ask for.
    pub task: Task,
    /// Its individuals.
    pub population: &'a Population,
    /// The results, in the order of [`crate::evolution::distinct`].
    pub evaluated: &'a [Evaluated],
    /// A score for every member; equal for equal genotypes.
    pub scored: &'a [Scored],
    /// The members' indices, the best first.
    pub ranking: &'a [u32],
    /// Whether this is the replication's last generation.
    pub finished: bool,
    /// Wall time the generation took. Kept for people, never part of a digest.
    pub wall: Duration,
}

/// Everything about a generation that does not depend on how the run went, and who ran it.
#[derive(Debug, Clone, PartialEq)]
pub struct GenerationRecord {
    /// Its individuals.
    pub population: Population,
    /// The results of its distinct genotypes.
    pub evaluated: Vec<Evaluated>,
    /// The members' scores.
    pub scored: Vec<Scored>,
    /// The members' indices, the best first.
    pub ranking: Vec<u32>,
}

impl GenerationRecord {
    /// What a worker has evaluated, the last of the generation, and what came of it.
    pub(super) fn latest_of(&self, worker: WorkerId) -> Option<(Arc<Genotype>, Vec<TrialOutcome>)> {
        let of_worker = |evaluated: &&Evaluated| evaluated.worker == Some(worker);
        let evaluated = self.evaluated.iter().rfind(of_worker)?;
        let member = self.population.members.get(evaluated.member as usize)?;
        Some((Arc::clone(&member.genotype), evaluated.outcomes.clone()))
    }
}

/// The generation from which a replication goes on. The next population is [`crate::evolution::reproduce`]d from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Resumed {
    /// The last committed population.
    pub population: Population,
    /// Its ranking.
    pub ranking: Vec<u32>,
}

/// An answer of a worker that nobody has looked into: its latest on record in an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Unproven {
    /// The worker.
    pub worker: WorkerId,
    /// The name it goes by.
    pub name: String,
    /// The experiment.
    pub experiment: ExperimentId,
    /// The replication that the answer belongs to, counted from 0.
    pub replication: u32,
    /// The generation that it belongs to.
    pub generation: u32,
    /// What was evaluated.
    pub genotype: Arc<Genotype>,
    /// What was answered: the outcomes of trials 0, 1, 2, ...
    pub outcomes: Vec<TrialOutcome>,
    /// The first generation to which the worker has contributed, for each replication of the experiment in which there is one.
    pub since: Vec<(ReplicationId, u32)>,
}

/// A worker that joins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkerInfo {
    /// The name it goes by.
    pub name: String,
    /// Its machine.
    pub host: String,
    /// Its process on that machine.
    pub process: u32,
    /// Its release.
    pub version: String,
    /// Threads it runs trials on.
    pub slots: u32,
}
