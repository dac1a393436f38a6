//! The questions people ask of a history.

use std::ops::RangeInclusive;

use selftalk_sim::Behaviour;
use serde::Deserialize;
use sqlx::FromRow;
use tokio_stream::StreamExt;

use super::{BehaviourSummary, ReplicationId, SqliteStore, StoreError, packed};

/// What a generation came to; the fields in the order in which they are asked for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct GenerationEntry {
    /// Generation, counted from 0.
    pub generation: u32,
    /// Fitness of its best individual.
    #[serde(deserialize_with = "packed::real")]
    pub best_fitness: f64,
    /// Mean fitness.
    #[serde(deserialize_with = "packed::real")]
    pub mean_fitness: f64,
    /// Successful trials of the best individual.
    pub best_successes: u32,
    /// Most successful trials of any individual.
    pub most_successes: u32,
    /// Individuals that succeeded in all trials.
    pub optimal_individuals: u32,
    /// Distinct genotypes.
    pub distinct_genotypes: u32,
    /// The best individual's number.
    pub best_individual: u32,
    /// Wall time it took, in milliseconds.
    pub wall_ms: i64,
    /// When it was written: RFC 3339, UTC.
    pub committed_at: String,
}

/// Where an individual comes from and what it came to.
#[derive(Debug, Clone, PartialEq, FromRow)]
pub struct IndividualEntry {
    /// Its generation.
    pub generation: u32,
    /// Its number in the generation.
    pub individual: u32,
    /// Its rank, 0 for the best.
    pub rank: u32,
    /// Its fitness.
    pub fitness: f64,
    /// Its successful trials.
    pub successes: u32,
    /// founder, elite or varied.
    pub origin: String,
    /// Its parent's number in the previous generation.
    pub parent: Option<u32>,
    /// The bits in which it differs from its parent.
    #[sqlx(try_from = "Bits")]
    pub flipped: Vec<u32>,
    /// The first individual of the generation with the same genotype, often itself.
    pub evaluated_as: u32,
    /// Who ran its trials.
    pub worker: Option<String>,
    /// Why there are no real results, if the evaluation was given up.
    pub failure: Option<String>,
}

/// A JSON array of bit positions, or null.
#[derive(sqlx::Type)]
#[sqlx(transparent)]
struct Bits(Option<String>);

impl TryFrom<Bits> for Vec<u32> {
    type Error = serde_json::Error;

    fn try_from(bits: Bits) -> Result<Self, Self::Error> {
        bits.0.as_deref().map_or(Ok(Self::new()), serde_json::from_str)
    }
}

/// A trial of a distinct genotype.
#[derive(Debug, Clone, PartialEq, FromRow)]
pub struct TrialEntry {
    /// The first individual of the generation with the genotype.
    pub individual: u32,
    /// Trial, counted from 0.
    pub trial: u32,
    /// Its score, unless that was not a finite number.
    pub score: Option<f64>,
    /// Whether the goal was reached and held.
    pub success: bool,
    /// Control steps it lasted.
    pub steps: u32,
}

/// A worker's connection.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct WorkerEntry {
    /// Its key.
    pub id: i64,
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
    /// When it joined: RFC 3339, UTC.
    pub joined_at: String,
    /// When it left, unless it is connected or the master was killed meanwhile.
    pub left_at: Option<String>,
    /// When the last of its answers had been looked into and was right.
    pub audited_at: Option<String>,
}

/// The generations of the replications in the JSON array ?1 from ?2 to ?3, packed: a row a replication, with its place in
/// the array.
fn generations() -> String {
    let (best_fitness, mean_fitness) = (packed::column("best_fitness"), packed::column("mean_fitness"));
    format!(
        "SELECT asked.key, (SELECT json_group_array(json_array(number, {best_fitness}, {mean_fitness}, best_successes, \
            most_successes, optimal_individuals, distinct_genotypes, best_individual, wall_ms, committed_at)) \
            FROM generation WHERE replication_id = asked.value AND number BETWEEN ?2 AND ?3) \
         FROM json_each(?1) AS asked"
    )
}

/// The generation with the fittest individual of replication ?1, the first of them.
const BEST_GENERATION: &str =
    "SELECT number FROM generation WHERE replication_id = ?1 ORDER BY best_fitness DESC, number LIMIT 1";

/// What the best individuals of replication ?1 came to.
const BEST_BEHAVIOURS: &str = "SELECT generation, behaviour, trials, successes, score FROM best_behaviour \
     WHERE replication_id = ?1 ORDER BY generation";

/// Bin, behaviour, trials, successes and mean score.
type SumRow = (u32, u32, Option<u32>, Option<u32>, Option<f64>);

/// Most parts that a question may be put together of; SQLite takes 500.
const PARTS: usize = 400;

/// What the best individuals of replication ?1 came to in each behaviour and bin: the bin's number, the behaviour's, and the
/// sums. Part by part, as grouping would have to sort.
fn sums(parts: &[(usize, Behaviour, &RangeInclusive<u32>)]) -> String {
    let part = |(bin, behaviour, generations): &(usize, Behaviour, &RangeInclusive<u32>)| {
        format!(
            "SELECT {bin}, {}, sum(trials), sum(successes), sum(score * trials) / sum(trials) FROM best_behaviour \
             WHERE replication_id = ?1 AND behaviour = '{}' AND generation BETWEEN {} AND {}",
            *behaviour as usize,
            behaviour.name(),
            generations.start(),
            generations.end()
        )
    };
    parts.iter().map(part).collect::<Vec<_>>().join(" UNION ALL ")
}

impl SqliteStore {
    /// A replication's generations, or one of them.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_generations(
        &self,
        replication: ReplicationId,
        generation: Option<u32>,
    ) -> Result<Vec<GenerationEntry>, StoreError> {
        let mut all = Vec::new();
        self.each_generations(&[replication], generation, |_, entries| all = entries).await?;
        Ok(all)
    }

    /// Hands over each replication's generations, or one of them, with its place in `replications`. The next are read
    /// meanwhile.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn each_generations(
        &self,
        replications: &[ReplicationId],
        generation: Option<u32>,
        mut take: impl FnMut(usize, Vec<GenerationEntry>),
    ) -> Result<(), StoreError> {
        let asked: serde_json::Value = replications.iter().map(|replication| replication.0).collect();
        let (first, last) = generation.map_or((0, u32::MAX), |generation| (generation, generation));
        let query = sqlx::query_as(sqlx::AssertSqlSafe(generations()));
        let query = query.bind(asked.to_string()).bind(first).bind(last);
        let mut state = self.state().await;
        let mut rows = query.fetch(&mut state.connection);
        while let Some(row) = rows.next().await {
            let (place, packed): (u32, String) = row.map_err(|error| self.fail(&error))?;
            let mut entries: Vec<GenerationEntry> =
                packed::rows(&packed).map_err(|error| self.fail(&error))?;
            entries.sort_by_key(|entry| entry.generation);
            take(place as usize, entries);
        }
        Ok(())
    }

    /// The generation with a replication's fittest individual, the first of them.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn best_generation(
        &self,
        replication: ReplicationId,
    ) -> Result<Option<GenerationEntry>, StoreError> {
        let query = sqlx::query_scalar(BEST_GENERATION).bind(replication.0);
        let best = query.fetch_optional(&mut self.state().await.connection).await;
        let best: Option<u32> = best.map_err(|error| self.fail(&error))?;
        let Some(best) = best else { return Ok(None) };
        Ok(self.list_generations(replication, Some(best)).await?.pop())
    }

    /// What the best individual of each generation came to in each behaviour, generation by generation, the behaviours in
    /// their order.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_behaviours(
        &self,
        replication: ReplicationId,
    ) -> Result<Vec<(u32, Vec<BehaviourSummary>)>, StoreError> {
        let query = sqlx::query_as(BEST_BEHAVIOURS);
        let mut state = self.state().await;
        let rows = query.bind(replication.0).fetch_all(&mut state.connection).await;
        let rows: Vec<(u32, String, u32, u32, f64)> = rows.map_err(|error| self.fail(&error))?;
        let summary = |(_, name, trials, successes, score): &(u32, String, u32, u32, f64)| {
            let behaviour = Behaviour::ALL.into_iter().find(|behaviour| behaviour.name() == name)?;
            Some(BehaviourSummary { behaviour, trials: *trials, successes: *successes, score: *score })
        };
        let of_generation = |rows: &[(u32, String, u32, u32, f64)]| {
            // One that this release does not know is none of an experiment that it knows.
            let mut summaries: Vec<_> = rows.iter().filter_map(summary).collect();
            summaries.sort_by_key(|summary| summary.behaviour);
            Some((rows.first()?.0, summaries))
        };
        Ok(rows.chunk_by(|a, b| a.0 == b.0).filter_map(of_generation).collect())
    }

    /// What the best individuals of each bin of generations came to in these behaviours, those of a bin together. What it
    /// has no trials of is left out.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn sum_behaviours(
        &self,
        replication: ReplicationId,
        behaviours: &[Behaviour],
        bins: &[RangeInclusive<u32>],
    ) -> Result<Vec<Vec<BehaviourSummary>>, StoreError> {
        let parts = bins.iter().enumerate();
        let parts: Vec<_> = parts
            .flat_map(|(bin, generations)| behaviours.iter().map(move |of| (bin, *of, generations)))
            .collect();
        let mut summaries = vec![Vec::new(); bins.len()];
        let mut state = self.state().await;
        for parts in parts.chunks(PARTS) {
            // Numbers and names of behaviours.
            let query = sqlx::query_as(sqlx::AssertSqlSafe(sums(parts))).bind(replication.0);
            let rows = query.fetch_all(&mut state.connection).await;
            let rows: Vec<SumRow> = rows.map_err(|error| self.fail(&error))?;
            for (bin, behaviour, trials, successes, score) in rows {
                let (Some(trials), Some(successes), Some(score)) = (trials, successes, score) else {
                    continue;
                };
                let behaviour = Behaviour::ALL[behaviour as usize];
                summaries[bin as usize].push(BehaviourSummary { behaviour, trials, successes, score });
            }
        }
        Ok(summaries)
    }

    /// The individuals of a generation by rank, or only the best of them.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_individuals(
        &self,
        replication: ReplicationId,
        generation: u32,
        best: bool,
    ) -> Result<Vec<IndividualEntry>, StoreError> {
        let query = sqlx::query_as(if best {
            "SELECT * FROM best_individual WHERE replication_id = ? AND generation = ?"
        } else {
            "SELECT * FROM individual_summary WHERE replication_id = ? AND generation = ? ORDER BY rank"
        });
        let mut state = self.state().await;
        let rows = query.bind(replication.0).bind(generation).fetch_all(&mut state.connection).await;
        rows.map_err(|error| self.fail(&error))
    }

    /// The trials of a generation's distinct genotypes, in order.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_trials(
        &self,
        replication: ReplicationId,
        generation: u32,
    ) -> Result<Vec<TrialEntry>, StoreError> {
        let query = sqlx::query_as(
            "SELECT individual, trial, score, success, steps FROM trial \
             WHERE replication_id = ? AND generation = ? ORDER BY individual, trial",
        );
        let mut state = self.state().await;
        let rows = query.bind(replication.0).bind(generation).fetch_all(&mut state.connection).await;
        rows.map_err(|error| self.fail(&error))
    }

    /// An individual and its ancestors, back to the founder. Empty when there is no such individual.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn lineage(
        &self,
        replication: ReplicationId,
        generation: u32,
        individual: u32,
    ) -> Result<Vec<IndividualEntry>, StoreError> {
        let query = sqlx::query_as(
            "WITH RECURSIVE line (replication, generation, number, parent) AS ( \
                SELECT replication_id, generation, number, parent FROM individual \
                WHERE replication_id = ? AND generation = ? AND number = ? \
                UNION ALL \
                SELECT replication_id, individual.generation, individual.number, individual.parent \
                FROM line JOIN individual ON individual.replication_id = line.replication \
                    AND individual.generation = line.generation - 1 AND individual.number = line.parent) \
             SELECT summary.* FROM line CROSS JOIN individual_summary AS summary \
                ON summary.replication_id = line.replication \
                AND summary.generation = line.generation AND summary.individual = line.number \
             ORDER BY summary.generation DESC",
        );
        let mut state = self.state().await;
        let rows = query
            .bind(replication.0)
            .bind(generation)
            .bind(individual)
            .fetch_all(&mut state.connection)
            .await;
        rows.map_err(|error| self.fail(&error))
    }

    /// All workers' connections, in the order they joined.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read.
    pub async fn list_workers(&self) -> Result<Vec<WorkerEntry>, StoreError> {
        let query = sqlx::query_as("SELECT * FROM worker ORDER BY id");
        let mut state = self.state().await;
        query.fetch_all(&mut state.connection).await.map_err(|error| self.fail(&error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn questions_about_all_generations_look_at_no_individuals_and_sort_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let store = SqliteStore::open_writer(&folder.path().join("history.db")).await.unwrap();
        let mut state = store.state().await;
        let (first, second) = (0..=4, 5..=9);
        let sums = sums(&[(0, Behaviour::Reach, &first), (1, Behaviour::Move, &second)]);
        for question in [BEST_GENERATION, &generations(), &sums] {
            let plan = sqlx::AssertSqlSafe(format!("EXPLAIN QUERY PLAN {question}"));
            let query = sqlx::query_as(plan);
            let plan: Vec<(i64, i64, i64, String)> = query.fetch_all(&mut state.connection).await.unwrap();
            for (_, _, _, step) in plan {
                let of_individuals = ["individual", "evaluation", "trial"];
                let of_individuals = of_individuals.iter().any(|table| step.contains(&format!(" {table} ")));
                let sorts = question != BEST_GENERATION && step.contains("TEMP B-TREE");
                assert!(!of_individuals && !sorts && !step.starts_with("SCAN best_behaviour"), "{step}");
            }
        }
    }
}
