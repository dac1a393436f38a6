//! Where the replications of a run stand, for whoever shows it.

use std::sync::Arc;

use tokio::sync::watch;

use crate::evolution::Scored;
use crate::store::StoredExperiment;

/// Where the replications of a run stand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Board {
    /// All replications of all experiments, in their order.
    pub standings: Vec<Standing>,
}

/// Where a replication stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Name of the experiment.
    pub experiment: String,
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generations that are committed.
    pub generations: u32,
    /// Generations after which it ends at the latest.
    pub of: u32,
    /// Trials of an individual.
    pub trials: u32,
    /// Whether it is done.
    pub finished: bool,
    /// What the last committed generation came to.
    pub last: Option<Last>,
}

/// What a generation came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Last {
    /// Fitness of the best individual.
    pub best: f64,
    /// Mean fitness of the population.
    pub mean: f64,
    /// Successful trials of the best individual.
    pub successes: u32,
}

impl Last {
    pub(super) fn of(scored: &[Scored], ranking: &[u32]) -> Option<Self> {
        let best = scored.get(*ranking.first()? as usize)?;
        let sum: f64 = scored.iter().map(|scored| scored.fitness).sum();
        Some(Self { best: best.fitness, mean: sum / scored.len() as f64, successes: best.successes })
    }
}

impl Board {
    /// Adds the replications of an experiment whose individuals have so many trials.
    pub(super) fn add(&mut self, stored: &StoredExperiment, trials: u32) {
        self.standings.extend(stored.replications.iter().map(|replication| Standing {
            experiment: stored.experiment.name.clone(),
            replication: replication.number,
            generations: replication.generations,
            of: stored.experiment.generations,
            trials,
            finished: replication.finished,
            last: replication.last.map(|last| Last {
                best: last.best_fitness,
                mean: last.mean_fitness,
                successes: last.best_successes,
            }),
        }));
    }
}

/// A replication's place on the board.
#[derive(Debug, Clone)]
pub(super) struct Place {
    board: Arc<watch::Sender<Board>>,
    index: usize,
}

impl Place {
    pub(super) fn new(board: Arc<watch::Sender<Board>>, index: usize) -> Self {
        Self { board, index }
    }

    /// Notes a committed generation.
    pub(super) fn note(&self, generations: u32, finished: bool, last: Option<Last>) {
        self.board.send_modify(|board| {
            if let Some(standing) = board.standings.get_mut(self.index) {
                standing.generations = generations;
                standing.finished = finished;
                standing.last = last;
            }
        });
    }
}
