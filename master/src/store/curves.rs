//! Learning curves, in as many points as can be drawn.

use selftalk_sim::TrialOutcome;
use sqlx::FromRow;

use super::{ReplicationId, SqliteStore, StoreError};

/// A point of a replication's learning curve: what a generation came to.
#[derive(Debug, Clone, PartialEq, FromRow)]
pub struct CurvePoint {
    /// Generation, counted from 0.
    pub generation: u32,
    /// Fitness of its best individual.
    pub best_fitness: f64,
    /// Mean fitness.
    pub mean_fitness: f64,
    /// Successful trials of the best individual.
    pub best_successes: u32,
    /// Individuals that succeeded in all trials.
    pub optimal_individuals: u32,
}

impl SqliteStore {
    /// A replication's generations from `first` on, as far as they are multiples of `stride`, and always its last one.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_curve(
        &self,
        replication: ReplicationId,
        first: u32,
        stride: u32,
    ) -> Result<Vec<CurvePoint>, StoreError> {
        let query = sqlx::query_as(
            "SELECT generation, best_fitness, mean_fitness, best_successes, optimal_individuals \
             FROM generation_summary WHERE replication_id = ?1 AND generation >= ?2 \
             AND (generation % ?3 = 0 \
                OR generation = (SELECT max(number) FROM generation WHERE replication_id = ?1)) \
             ORDER BY generation",
        );
        let mut state = self.state().await;
        let query = query.bind(replication.0).bind(first).bind(stride.max(1));
        query.fetch_all(&mut state.connection).await.map_err(|error| self.fail(&error))
    }

    /// Milliseconds that each of a replication's last generations took, on the mean over so many of them; none before
    /// the first.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn recent_wall_ms(
        &self,
        replication: ReplicationId,
        generations: u32,
    ) -> Result<Option<f64>, StoreError> {
        let query = sqlx::query_scalar(
            "SELECT avg(wall_ms) FROM generation WHERE replication_id = ?1 \
             AND number > (SELECT max(number) FROM generation WHERE replication_id = ?1) - ?2",
        );
        let mut state = self.state().await;
        let query = query.bind(replication.0).bind(generations);
        query.fetch_one(&mut state.connection).await.map_err(|error| self.fail(&error))
    }

    /// The outcomes of an individual's trials in order, whether it was evaluated itself or shares another's result.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_outcomes(
        &self,
        replication: ReplicationId,
        generation: u32,
        individual: u32,
    ) -> Result<Vec<TrialOutcome>, StoreError> {
        let query = sqlx::query_as(
            "SELECT score, success, steps FROM trial_outcome \
             WHERE replication_id = ? AND generation = ? AND individual = ? ORDER BY trial",
        );
        let mut state = self.state().await;
        let query = query.bind(replication.0).bind(generation).bind(individual);
        let rows = query.fetch_all(&mut state.connection).await;
        let rows: Vec<(Option<f64>, bool, u32)> = rows.map_err(|error| self.fail(&error))?;
        let outcome = |(score, success, steps): (Option<f64>, _, _)| TrialOutcome {
            score: score.unwrap_or(f64::NAN),
            success,
            steps,
        };
        Ok(rows.into_iter().map(outcome).collect())
    }
}
