//! Reading generations back, genotypes included.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use selftalk_sim::{Genotype, TrialOutcome};
use sqlx::{FromRow, SqliteConnection};

use super::commit::{genotypes_sha256, is_permutation};
use super::{Evaluated, GenerationRecord, ReplicationId, Resumed, StoreError, WorkerId};
use crate::evolution::{Member, Origin, Population, Scored};

#[derive(FromRow)]
struct IndividualRow {
    parent: Option<u32>,
    flipped: Option<String>,
    evaluated_as: u32,
    rank: u32,
}

#[derive(FromRow)]
struct EvaluationRow {
    individual: u32,
    fitness: f64,
    successes: u32,
    worker_id: Option<i64>,
    failure: Option<String>,
}

/// A generation's individuals and their order.
struct Line {
    population: Population,
    ranking: Vec<u32>,
    evaluated_as: Vec<u32>,
}

/// Reads the generations of one replication. Consecutive ones are read in one step each; any other from the nearest
/// generation that is stored whole.
pub(super) struct GenerationReader<'a> {
    path: &'a Path,
    replication: ReplicationId,
    number: u32,
    /// The generation read last, from which the next one follows.
    previous: Option<Population>,
}

impl<'a> GenerationReader<'a> {
    /// A reader of the replication, whose number among its experiment's is `number`.
    pub(super) const fn new(path: &'a Path, replication: ReplicationId, number: u32) -> Self {
        Self { path, replication, number, previous: None }
    }

    /// A generation's population and ranking.
    pub(super) async fn population(
        &mut self,
        connection: &mut SqliteConnection,
        generation: u32,
    ) -> Result<Resumed, StoreError> {
        let Line { population, ranking, .. } = self.line(connection, generation).await?;
        Ok(Resumed { population, ranking })
    }

    /// Everything about a generation.
    pub(super) async fn record(
        &mut self,
        connection: &mut SqliteConnection,
        generation: u32,
    ) -> Result<GenerationRecord, StoreError> {
        let Line { population, ranking, evaluated_as } = self.line(connection, generation).await?;
        let fail = |error| StoreError::from_sqlite(self.path, &error);
        let evaluations: Vec<EvaluationRow> = sqlx::query_as(
            "SELECT individual, fitness, successes, worker_id, failure FROM evaluation \
             WHERE replication_id = ? AND generation = ? ORDER BY individual",
        )
        .bind(self.replication.0)
        .bind(generation)
        .fetch_all(&mut *connection)
        .await
        .map_err(fail)?;
        let trials: Vec<(u32, u32, Option<f64>, bool, u32)> = sqlx::query_as(
            "SELECT individual, trial, score, success, steps FROM trial \
             WHERE replication_id = ? AND generation = ? ORDER BY individual, trial",
        )
        .bind(self.replication.0)
        .bind(generation)
        .fetch_all(connection)
        .await
        .map_err(fail)?;

        let mut scores = HashMap::with_capacity(evaluations.len());
        let mut evaluated = Vec::with_capacity(evaluations.len());
        let mut trials = trials.into_iter().peekable();
        for row in evaluations {
            scores.insert(row.individual, Scored { fitness: row.fitness, successes: row.successes });
            let mut outcomes = Vec::new();
            while let Some((_, trial, score, success, steps)) =
                trials.next_if(|trial| trial.0 == row.individual)
            {
                if trial as usize != outcomes.len() {
                    return Err(self.damaged(generation, "a trial is missing"));
                }
                outcomes.push(TrialOutcome { score: score.unwrap_or(f64::NAN), success, steps });
            }
            let worker = row.worker_id.map(WorkerId);
            evaluated.push(Evaluated { member: row.individual, outcomes, worker, failure: row.failure });
        }
        let scored = evaluated_as.iter().map(|first| scores.get(first).copied()).collect::<Option<Vec<_>>>();
        let scored = scored.ok_or_else(|| self.damaged(generation, "an evaluation is missing"))?;
        Ok(GenerationRecord { population, evaluated, scored, ranking })
    }

    async fn line(&mut self, connection: &mut SqliteConnection, generation: u32) -> Result<Line, StoreError> {
        let fail = |error| StoreError::from_sqlite(self.path, &error);
        let follows = self
            .previous
            .as_ref()
            .is_some_and(|previous| previous.generation.checked_add(1) == Some(generation));
        let mut line = if follows {
            self.step(connection, generation).await?
        } else {
            let keyframe: Option<u32> = sqlx::query_scalar(
                "SELECT max(generation) FROM genotype WHERE replication_id = ? AND generation <= ?",
            )
            .bind(self.replication.0)
            .bind(generation)
            .fetch_one(&mut *connection)
            .await
            .map_err(fail)?;
            let keyframe = keyframe.ok_or_else(|| self.damaged(generation, "the founders are missing"))?;
            self.keyframe(connection, keyframe).await?
        };
        while line.population.generation < generation {
            let next = line.population.generation + 1;
            self.previous = Some(line.population);
            line = self.step(connection, next).await?;
        }
        let checksum: Option<Vec<u8>> = sqlx::query_scalar(
            "SELECT genotypes_sha256 FROM generation WHERE replication_id = ? AND number = ?",
        )
        .bind(self.replication.0)
        .bind(generation)
        .fetch_optional(connection)
        .await
        .map_err(fail)?;
        if checksum.as_deref() != Some(&genotypes_sha256(&line.population)) {
            return Err(self.damaged(generation, "the genotypes do not fit their checksum"));
        }
        self.previous = Some(line.population.clone());
        Ok(line)
    }

    /// A generation that is stored whole.
    async fn keyframe(&self, connection: &mut SqliteConnection, generation: u32) -> Result<Line, StoreError> {
        let genes: Vec<(u32, Vec<u8>)> = sqlx::query_as(
            "SELECT individual, genes FROM genotype WHERE replication_id = ? AND generation = ?",
        )
        .bind(self.replication.0)
        .bind(generation)
        .fetch_all(&mut *connection)
        .await
        .map_err(|error| StoreError::from_sqlite(self.path, &error))?;
        let genotypes: HashMap<u32, Arc<Genotype>> = genes
            .into_iter()
            .filter_map(|(first, genes)| {
                Some((first, Genotype::from_bytes(&genes, genes.len() / 2).ok()?.into()))
            })
            .collect();
        self.build(connection, generation, |row, _| genotypes.get(&row.evaluated_as).map(Arc::clone)).await
    }

    /// The generation after the previous one.
    async fn step(&self, connection: &mut SqliteConnection, generation: u32) -> Result<Line, StoreError> {
        let parents = self.previous.as_ref().map_or(&[][..], |previous| &previous.members);
        self.build(connection, generation, |_, origin| {
            let parent = &parents.get(origin.parent()? as usize)?.genotype;
            match origin.flipped() {
                [] => Some(Arc::clone(parent)),
                flipped => parent.with_flipped(flipped).ok().map(Arc::new),
            }
        })
        .await
    }

    /// Reads the individuals and asks for each one's genotype.
    async fn build(
        &self,
        connection: &mut SqliteConnection,
        generation: u32,
        genotype: impl Fn(&IndividualRow, &Origin) -> Option<Arc<Genotype>>,
    ) -> Result<Line, StoreError> {
        let rows: Vec<IndividualRow> = sqlx::query_as(
            "SELECT parent, flipped, evaluated_as, rank FROM individual \
             WHERE replication_id = ? AND generation = ? ORDER BY number",
        )
        .bind(self.replication.0)
        .bind(generation)
        .fetch_all(connection)
        .await
        .map_err(|error| StoreError::from_sqlite(self.path, &error))?;
        let members = rows.iter().map(|row| {
            let origin = origin(row)?;
            Some(Member { genotype: genotype(row, &origin)?, origin })
        });
        let members = members.collect::<Option<Vec<Member>>>();
        let members = members.ok_or_else(|| self.damaged(generation, "a genotype is missing"))?;
        let mut ranking: Vec<u32> = (0..).take(rows.len()).collect();
        ranking.sort_by_key(|&member| rows[member as usize].rank);
        let ranks: Vec<u32> = rows.iter().map(|row| row.rank).collect();
        if !is_permutation(&ranks, rows.len()) || rows.is_empty() {
            return Err(self.damaged(generation, "an individual or its rank is missing"));
        }
        let population = Population { replication: self.number, generation, members };
        Ok(Line { population, ranking, evaluated_as: rows.iter().map(|row| row.evaluated_as).collect() })
    }

    fn damaged(&self, generation: u32, what: &str) -> StoreError {
        let reason = format!("replication {}, generation {generation}: {what}", self.number);
        StoreError::Corrupt { path: self.path.to_owned(), reason }
    }
}

fn origin(row: &IndividualRow) -> Option<Origin> {
    Some(match (row.parent, &row.flipped) {
        (None, _) => Origin::Founder,
        (Some(parent), None) => Origin::Elite { parent },
        (Some(parent), Some(flipped)) => {
            Origin::Varied { parent, flipped: serde_json::from_str(flipped).ok()? }
        }
    })
}
