//! Everything at a glance: the experiments, how far they are, and who is at work.

use serde::Serialize;

use super::answer::{Refusal, rounded};
use super::sources::{Live, Sources};
use crate::driver::Board;
use crate::service::Attendance;
use crate::store::{Store, StoredExperiment, StoredReplication};

/// A replication's pace is that of so many last generations.
const RECENT: u32 = 20;

/// The experiments and the master.
#[derive(Debug, Serialize)]
pub(super) struct Overview {
    version: &'static str,
    file: String,
    fingerprint: String,
    experiments: Vec<Condition>,
    /// Nothing where no master is in this process.
    live: Option<Now>,
}

#[derive(Debug, Serialize)]
pub(super) struct Condition {
    name: String,
    created_at: String,
    state: &'static str,
    /// Generations planned.
    generations: u32,
    population: u32,
    /// Trials of an individual, if this release can run it.
    trials: Option<usize>,
    /// Why its individuals cannot be replayed, if so.
    foreign: Option<String>,
    replications: Vec<Progress>,
}

#[derive(Debug, Serialize)]
struct Progress {
    number: u32,
    /// `running` where this process is at it, `finished`, or `unfinished`.
    state: &'static str,
    /// Generations committed.
    generations: u32,
    best_fitness: Option<f64>,
    mean_fitness: Option<f64>,
    best_successes: Option<u32>,
    optimal: Option<u32>,
    first_optimal: Option<u32>,
}

#[derive(Debug, Serialize)]
struct Now {
    workers: Vec<Worker>,
    slots: u32,
    units_waiting: usize,
    units_leased: usize,
    trials: u64,
    trials_per_second: f64,
    generations_per_minute: Option<f64>,
    seconds_left: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Worker {
    name: String,
    host: String,
    slots: u32,
    units: usize,
    trials: u64,
    trials_per_second: f64,
    silent_seconds: f64,
}

/// Looks at everything.
pub(super) async fn overview(sources: &Sources) -> Result<Overview, Refusal> {
    let experiments = sources.store().experiments().await?;
    let board = sources.live().map(|live| live.board.borrow().clone()).unwrap_or_default();
    let live = match sources.live() {
        Some(live) => Some(now(sources, live, &board, &experiments).await?),
        None => None,
    };
    Ok(Overview {
        version: env!("CARGO_PKG_VERSION"),
        file: sources.file().to_owned(),
        fingerprint: sources.fingerprint().to_owned(),
        experiments: experiments.iter().map(|stored| condition(sources, stored, &board)).collect(),
        live,
    })
}

/// How far one experiment is.
pub(super) fn condition(sources: &Sources, stored: &StoredExperiment, board: &Board) -> Condition {
    let experiment = &stored.experiment;
    let replications: Vec<Progress> = stored
        .replications
        .iter()
        .map(|replication| progress(replication, is_running(board, &experiment.name, replication.number)))
        .collect();
    let any = |state: &&str| replications.iter().any(|replication| replication.state == *state);
    Condition {
        name: experiment.name.clone(),
        created_at: stored.created_at.clone(),
        state: ["running", "unfinished"].into_iter().find(|state| any(state)).unwrap_or("finished"),
        generations: experiment.generations,
        population: experiment.evolution.population,
        trials: sources.kind(stored).map(|kind| kind.trials()),
        foreign: sources.foreign(stored),
        replications,
    }
}

fn is_running(board: &Board, experiment: &str, replication: u32) -> bool {
    let same = |standing: &&crate::driver::Standing| {
        standing.experiment == experiment && standing.replication == replication
    };
    board.standings.iter().find(same).is_some_and(|standing| !standing.finished)
}

fn progress(replication: &StoredReplication, running: bool) -> Progress {
    let last = replication.last;
    Progress {
        number: replication.number,
        state: match (replication.finished, running) {
            (true, _) => "finished",
            (false, true) => "running",
            (false, false) => "unfinished",
        },
        generations: replication.generations,
        best_fitness: last.map(|last| rounded(last.best_fitness)),
        mean_fitness: last.map(|last| rounded(last.mean_fitness)),
        best_successes: last.map(|last| last.best_successes),
        optimal: last.map(|last| last.optimal),
        first_optimal: replication.first_optimal,
    }
}

async fn now(
    sources: &Sources,
    live: &Live,
    board: &Board,
    experiments: &[StoredExperiment],
) -> Result<Now, Refusal> {
    let floor = live.floor.borrow().clone();
    let mut paces = Vec::new();
    for stored in experiments {
        for replication in &stored.replications {
            if is_running(board, &stored.experiment.name, replication.number) && !replication.finished {
                let left = stored.experiment.generations.saturating_sub(replication.generations);
                let wall_ms = sources.store().recent_wall_ms(replication.id, RECENT).await?;
                paces.push(wall_ms.map(|wall_ms| Pace { left, wall_ms }));
            }
        }
    }
    let paces: Option<Vec<Pace>> = paces.into_iter().collect();
    let worker = |worker: &Attendance| Worker {
        name: worker.name.to_string(),
        host: worker.host.to_string(),
        slots: worker.slots,
        units: worker.units,
        trials: worker.trials,
        trials_per_second: rounded(worker.trials_per_second),
        silent_seconds: worker.silence.as_secs_f64(),
    };
    let workers: Vec<Worker> = floor.workers.iter().map(worker).collect();
    Ok(Now {
        slots: workers.iter().map(|worker| worker.slots).sum(),
        trials_per_second: workers.iter().map(|worker| worker.trials_per_second).sum(),
        workers,
        units_waiting: floor.waiting,
        units_leased: floor.leased,
        trials: floor.trials,
        generations_per_minute: paces.as_deref().map(per_minute),
        seconds_left: paces.as_deref().map(seconds_left),
    })
}

/// What a replication has before it.
#[derive(Debug, Clone, Copy)]
struct Pace {
    /// Generations.
    left: u32,
    /// Time that one takes while all replications share the workers.
    wall_ms: f64,
}

fn per_minute(paces: &[Pace]) -> f64 {
    paces.iter().map(|pace| 60_000.0 / pace.wall_ms.max(1.0)).sum()
}

/// Replications that share the workers each take a part of their time, which the others get when one is done.
fn seconds_left(paces: &[Pace]) -> f64 {
    let alone: f64 = paces.iter().map(|pace| f64::from(pace.left) * pace.wall_ms).sum();
    alone / paces.len().max(1) as f64 / 1000.0
}

#[cfg(test)]
mod pace {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_all_replications_together() {
        let pace = |left, wall_ms| Pace { left, wall_ms };
        assert_eq!(seconds_left(&[]), 0.0);
        assert_eq!(seconds_left(&[pace(30, 2000.0)]), 60.0);
        assert_eq!(seconds_left(&[pace(30, 2000.0), pace(30, 2000.0)]), 60.0);
        // When one is done the other has twice the workers.
        assert_eq!(seconds_left(&[pace(10, 2000.0), pace(30, 2000.0)]), 40.0);
        assert_eq!(per_minute(&[pace(10, 2000.0), pace(30, 2000.0)]), 60.0);
    }
}
