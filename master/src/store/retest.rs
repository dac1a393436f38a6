//! Trials in which stored individuals were run afterwards.

use selftalk_sim::TrialOutcome;
use sqlx::{QueryBuilder, Sqlite};

use super::{ReplicationId, SqliteStore, StoreError};

/// A test that stored individuals are put to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Test {
    /// Post-evaluation: fresh draws, without a caretaker (paper, section III.B).
    Post,
    /// The places of a grid, without a caretaker (paper, section III.E).
    Generalisation,
    /// The same places with a caretaker.
    Aided,
}

impl Test {
    /// Its name in the database.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Post => "post",
            Self::Generalisation => "generalisation",
            Self::Aided => "aided",
        }
    }
}

/// What an individual came to in a test.
#[derive(Debug, Clone, PartialEq)]
pub struct Retest {
    /// Its generation.
    pub generation: u32,
    /// The first individual of the generation with its genotype: the one that was evaluated.
    pub individual: u32,
    /// The outcomes of trials 0, 1, 2, ...
    pub outcomes: Vec<TrialOutcome>,
}

impl Retest {
    /// Trials that succeeded.
    #[must_use]
    pub fn successes(&self) -> u32 {
        self.outcomes.iter().map(|outcome| u32::from(outcome.success)).sum()
    }
}

/// Rows written by one statement.
const ROWS: usize = 64;

impl SqliteStore {
    /// Keeps what individuals of a replication came to in a test, all of it or nothing. What is kept of them already is
    /// replaced.
    ///
    /// # Errors
    /// [`StoreError`] when there is no such individual, or the history cannot be written.
    pub async fn keep_retests(
        &self,
        replication: ReplicationId,
        test: Test,
        retests: &[Retest],
    ) -> Result<(), StoreError> {
        let mut state = self.begin().await?;
        let rows: Vec<(&Retest, u32, &TrialOutcome)> = retests
            .iter()
            .flat_map(|retest| {
                (0..).zip(&retest.outcomes).map(move |(trial, outcome)| (retest, trial, outcome))
            })
            .collect();
        for rows in rows.chunks(ROWS) {
            let mut insert = QueryBuilder::<Sqlite>::new(
                "INSERT OR REPLACE INTO retest \
                 (replication_id, generation, individual, test, trial, score, success, steps) ",
            );
            insert.push_values(rows, |mut row, (retest, trial, outcome)| {
                row.push_bind(replication.0).push_bind(retest.generation).push_bind(retest.individual);
                row.push_bind(test.name()).push_bind(*trial);
                row.push_bind(Some(outcome.score).filter(|score| score.is_finite()));
                row.push_bind(outcome.success).push_bind(outcome.steps);
            });
            let done = insert.build().execute(&mut state.connection).await;
            done.map_err(|error| self.fail(&error))?;
        }
        self.commit(state).await
    }

    /// What individuals of a replication came to in a test, by generation.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_retests(
        &self,
        replication: ReplicationId,
        test: Test,
    ) -> Result<Vec<Retest>, StoreError> {
        let query = sqlx::query_as(
            "SELECT generation, individual, score, success, steps FROM retest \
             WHERE replication_id = ? AND test = ? ORDER BY generation, individual, trial",
        );
        let mut state = self.state().await;
        let rows = query.bind(replication.0).bind(test.name()).fetch_all(&mut state.connection).await;
        let rows: Vec<(u32, u32, Option<f64>, bool, u32)> = rows.map_err(|error| self.fail(&error))?;
        let individuals = rows.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        let retest = |rows: &[(u32, u32, Option<f64>, bool, u32)]| {
            let &(generation, individual, ..) = rows.first()?;
            let outcome = |&(_, _, score, success, steps): &(u32, u32, Option<f64>, bool, u32)| {
                TrialOutcome { score: score.unwrap_or(f64::NAN), success, steps }
            };
            Some(Retest { generation, individual, outcomes: rows.iter().map(outcome).collect() })
        };
        Ok(individuals.filter_map(retest).collect())
    }
}
