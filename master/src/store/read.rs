//! Reading experiments and their replications.

use std::path::Path;

use selftalk_sim::Experiment;
use sqlx::{FromRow, SqliteConnection};

use super::{
    ExperimentId, GenerationSummary, ReplicationId, StoreError, StoredExperiment, StoredReplication,
};

#[derive(FromRow)]
struct ExperimentRow {
    id: i64,
    name: String,
    settings: String,
    fingerprint: String,
    created_at: String,
}

#[derive(FromRow)]
struct ReplicationRow {
    id: i64,
    number: u32,
    finished: bool,
    last: Option<u32>,
    best_fitness: Option<f64>,
    mean_fitness: Option<f64>,
    best_successes: Option<u32>,
    most_successes: Option<u32>,
    optimal: Option<u32>,
    distinct_genotypes: Option<u32>,
    first_optimal: Option<u32>,
}

/// The replications of an experiment with what their last generation came to.
const REPLICATIONS: &str = "\
    SELECT replication.id, replication.number, finished_at IS NOT NULL AS finished, generation.number AS last, \
        best_fitness, mean_fitness, best_successes, most_successes, \
        optimal_individuals AS optimal, distinct_genotypes, \
        (SELECT min(number) FROM generation INDEXED BY generation_optimal \
            WHERE replication_id = replication.id AND optimal_individuals > 0) \
            AS first_optimal \
    FROM replication \
    LEFT JOIN generation ON generation.replication_id = replication.id AND generation.number = \
        (SELECT max(number) FROM generation WHERE replication_id = replication.id) \
    WHERE experiment_id = ? ORDER BY replication.number";

/// The experiments, or only that of a name, in the order of their creation.
pub(super) async fn experiments(
    path: &Path,
    connection: &mut SqliteConnection,
    name: Option<&str>,
) -> Result<Vec<StoredExperiment>, StoreError> {
    let fail = |error| StoreError::from_sqlite(path, &error);
    let rows: Vec<ExperimentRow> = sqlx::query_as(
        "SELECT id, name, settings, fingerprint, created_at FROM experiment \
         WHERE name = coalesce(?, name) ORDER BY id",
    )
    .bind(name)
    .fetch_all(&mut *connection)
    .await
    .map_err(fail)?;
    let mut experiments = Vec::with_capacity(rows.len());
    for row in rows {
        let experiment =
            Experiment::from_toml(&row.name, &row.settings, &[]).map_err(|error| StoreError::Corrupt {
                path: path.to_owned(),
                reason: format!("the settings of experiment {error}"),
            })?;
        let replications: Vec<ReplicationRow> =
            sqlx::query_as(REPLICATIONS).bind(row.id).fetch_all(&mut *connection).await.map_err(fail)?;
        experiments.push(StoredExperiment {
            id: ExperimentId(row.id),
            experiment,
            fingerprint: row.fingerprint,
            created_at: row.created_at,
            replications: replications.into_iter().map(StoredReplication::from).collect(),
        });
    }
    Ok(experiments)
}

impl From<ReplicationRow> for StoredReplication {
    fn from(row: ReplicationRow) -> Self {
        Self {
            id: ReplicationId(row.id),
            number: row.number,
            finished: row.finished,
            generations: row.last.map_or(0, |last| last + 1),
            last: row.summary(),
            first_optimal: row.first_optimal,
        }
    }
}

impl ReplicationRow {
    fn summary(&self) -> Option<GenerationSummary> {
        Some(GenerationSummary {
            best_fitness: self.best_fitness?,
            mean_fitness: self.mean_fitness?,
            best_successes: self.best_successes?,
            most_successes: self.most_successes?,
            optimal: self.optimal?,
            distinct: self.distinct_genotypes?,
        })
    }
}

/// How far a replication is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromRow)]
pub(super) struct Position {
    /// Its number in its experiment.
    pub(super) number: u32,
    pub(super) finished: bool,
    /// Committed generations.
    pub(super) generations: u32,
}

/// How far a replication is.
pub(super) async fn replication(
    connection: &mut SqliteConnection,
    replication: ReplicationId,
) -> Result<Position, sqlx::Error> {
    sqlx::query_as(
        "SELECT number, finished_at IS NOT NULL AS finished, \
         (SELECT coalesce(max(number) + 1, 0) FROM generation WHERE replication_id = id) AS generations \
         FROM replication WHERE id = ?",
    )
    .bind(replication.0)
    .fetch_one(connection)
    .await
}
