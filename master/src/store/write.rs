//! The statements that write a generation.

use std::fmt::Write;

use selftalk_sim::Experiment;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use super::commit::{Checked, genotypes_sha256};
use super::{GenerationCommit, ReplicationId, WorkerId, WorkerInfo};
use crate::evolution::{Member, Origin};

/// Generations after which all distinct genotypes are stored whole again, which bounds how many have to be read to
/// know one. They take 5 % of the file.
pub(super) const KEYFRAME_EVERY: u32 = 50;

/// Most rows written by one statement. Statements are prepared once for each number of rows and used again.
const ROWS: usize = 256;

/// The present time as the tables have it.
pub(super) const NOW: &str = "strftime('%Y-%m-%dT%H:%M:%SZ', 'now')";

type Result = std::result::Result<(), sqlx::Error>;

/// Writes an experiment and its replications. The caller holds a transaction.
pub(super) async fn experiment(
    connection: &mut SqliteConnection,
    experiment: &Experiment,
    fingerprint: &str,
) -> Result {
    let mut insert =
        QueryBuilder::<Sqlite>::new("INSERT INTO experiment (name, settings, fingerprint, created_at) ");
    insert.push_values([experiment], |mut row, experiment| {
        row.push_bind(&experiment.name).push_bind(experiment.to_toml()).push_bind(fingerprint).push(NOW);
    });
    let id = insert.build().execute(&mut *connection).await?.last_insert_rowid();
    for number in 0..experiment.replications {
        sqlx::query("INSERT INTO replication (experiment_id, number) VALUES (?, ?)")
            .bind(id)
            .bind(number)
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}

/// Notes that a worker has joined.
pub(super) async fn worker(
    connection: &mut SqliteConnection,
    worker: &WorkerInfo,
) -> std::result::Result<WorkerId, sqlx::Error> {
    let mut insert =
        QueryBuilder::<Sqlite>::new("INSERT INTO worker (name, host, process, version, slots, joined_at) ");
    insert.push_values([worker], |mut row, worker| {
        row.push_bind(&worker.name).push_bind(&worker.host).push_bind(worker.process);
        row.push_bind(&worker.version).push_bind(worker.slots).push(NOW);
    });
    insert.build().execute(connection).await.map(|done| WorkerId(done.last_insert_rowid()))
}

/// Notes that a worker has left.
pub(super) async fn worker_left(connection: &mut SqliteConnection, worker: WorkerId) -> Result {
    let mut update = QueryBuilder::<Sqlite>::new("UPDATE worker SET left_at = ");
    update.push(NOW).push(" WHERE id = ").push_bind(worker.0);
    update.build().execute(connection).await?;
    Ok(())
}

/// Notes that the last answers of a worker were right.
pub(super) async fn worker_audited(connection: &mut SqliteConnection, worker: WorkerId) -> Result {
    let mut update = QueryBuilder::<Sqlite>::new("UPDATE worker SET audited_at = ");
    update.push(NOW).push(" WHERE id = ").push_bind(worker.0);
    update.build().execute(connection).await?;
    Ok(())
}

/// Removes all rows of the generations from this one on. The caller holds a transaction.
pub(super) async fn take_back(
    connection: &mut SqliteConnection,
    replication: ReplicationId,
    from: u32,
) -> Result {
    // Rows go before those they refer to.
    for statement in [
        "DELETE FROM retest WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM best_behaviour WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM genotype WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM individual WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM trial WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM evaluation WHERE replication_id = ? AND generation >= ?",
        "DELETE FROM generation WHERE replication_id = ? AND number >= ?",
    ] {
        sqlx::query(statement).bind(replication.0).bind(from).execute(&mut *connection).await?;
    }
    sqlx::query("UPDATE replication SET finished_at = NULL WHERE id = ?")
        .bind(replication.0)
        .execute(connection)
        .await?;
    Ok(())
}

/// Writes all rows of a generation. The caller holds a transaction.
pub(super) async fn generation(connection: &mut SqliteConnection, checked: &Checked<'_>) -> Result {
    summary(connection, checked).await?;
    behaviours(connection, checked).await?;
    evaluations(connection, &checked.commit).await?;
    trials(connection, &checked.commit).await?;
    individuals(connection, checked).await?;
    if checked.commit.population.generation.is_multiple_of(KEYFRAME_EVERY) {
        genotypes(connection, &checked.commit).await?;
    }
    if checked.commit.finished {
        finished(connection, checked.commit.replication).await?;
    }
    Ok(())
}

async fn summary(connection: &mut SqliteConnection, checked: &Checked<'_>) -> Result {
    let Checked { commit, summary, .. } = checked;
    let mut insert = QueryBuilder::<Sqlite>::new(
        "INSERT INTO generation (replication_id, number, best_individual, best_fitness, best_successes, \
         mean_fitness, most_successes, optimal_individuals, distinct_genotypes, genotypes_sha256, wall_ms, \
         committed_at) VALUES (",
    );
    let mut values = insert.separated(", ");
    values.push_bind(commit.replication.0).push_bind(commit.population.generation);
    values.push_bind(commit.ranking.first().copied()).push_bind(summary.best_fitness);
    values.push_bind(summary.best_successes).push_bind(summary.mean_fitness);
    values.push_bind(summary.most_successes).push_bind(summary.optimal).push_bind(summary.distinct);
    values.push_bind(genotypes_sha256(commit.population).to_vec());
    values
        .push_bind(i64::try_from(commit.wall.as_millis()).unwrap_or(i64::MAX))
        .push(NOW)
        .push_unseparated(")");
    insert.build().execute(connection).await?;
    Ok(())
}

async fn behaviours(connection: &mut SqliteConnection, checked: &Checked<'_>) -> Result {
    if checked.behaviours.is_empty() {
        return Ok(());
    }
    let Checked { commit, behaviours, .. } = checked;
    let mut insert = QueryBuilder::<Sqlite>::new(
        "INSERT INTO best_behaviour (replication_id, behaviour, generation, trials, successes, score) ",
    );
    insert.push_values(behaviours, |mut row, of| {
        row.push_bind(commit.replication.0).push_bind(of.behaviour.name());
        row.push_bind(commit.population.generation);
        row.push_bind(of.trials).push_bind(of.successes).push_bind(of.score);
    });
    insert.build().execute(connection).await?;
    Ok(())
}

async fn evaluations(connection: &mut SqliteConnection, commit: &GenerationCommit<'_>) -> Result {
    for chunk in commit.evaluated.chunks(ROWS) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO evaluation (replication_id, generation, individual, fitness, successes, worker_id, failure) ",
        );
        insert.push_values(chunk, |mut row, evaluated| {
            let scored = commit.scored[evaluated.member as usize];
            key(&mut row, commit, evaluated.member).push_bind(scored.fitness).push_bind(scored.successes);
            row.push_bind(evaluated.worker.map(|worker| worker.0)).push_bind(evaluated.failure.as_deref());
        });
        run(connection, insert).await?;
    }
    Ok(())
}

async fn trials(connection: &mut SqliteConnection, commit: &GenerationCommit<'_>) -> Result {
    let rows: Vec<_> = commit
        .evaluated
        .iter()
        .flat_map(|evaluated| (0_u32..).zip(&evaluated.outcomes).map(|trial| (evaluated.member, trial)))
        .collect();
    for chunk in rows.chunks(ROWS) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO trial (replication_id, generation, individual, trial, score, success, steps) ",
        );
        insert.push_values(chunk, |mut row, (member, (trial, outcome))| {
            // SQLite has neither infinities nor NaN.
            let score = Some(outcome.score).filter(|score| score.is_finite());
            key(&mut row, commit, *member).push_bind(*trial).push_bind(score);
            row.push_bind(outcome.success).push_bind(outcome.steps);
        });
        run(connection, insert).await?;
    }
    Ok(())
}

async fn individuals(connection: &mut SqliteConnection, checked: &Checked<'_>) -> Result {
    let commit = &checked.commit;
    let mut ranks = vec![0_u32; commit.ranking.len()];
    for (rank, &member) in (0..).zip(commit.ranking) {
        ranks[member as usize] = rank;
    }
    let rows: Vec<(u32, &Member)> = (0..).zip(&commit.population.members).collect();
    for chunk in rows.chunks(ROWS) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO individual (replication_id, generation, number, parent, flipped, evaluated_as, rank) ",
        );
        insert.push_values(chunk, |mut row, (number, member)| {
            key(&mut row, commit, *number)
                .push_bind(member.origin.parent())
                .push_bind(flipped(&member.origin));
            row.push_bind(checked.evaluated_as[*number as usize]).push_bind(ranks[*number as usize]);
        });
        run(connection, insert).await?;
    }
    Ok(())
}

/// The flipped bits as a JSON array; none for what was not varied.
fn flipped(origin: &Origin) -> Option<String> {
    let Origin::Varied { flipped, .. } = origin else { return None };
    let mut bits = String::with_capacity(6 * flipped.len());
    for (place, bit) in flipped.iter().enumerate() {
        let separator = if place == 0 { "" } else { "," };
        // A string takes whatever is written to it.
        let _ = write!(bits, "{separator}{bit}");
    }
    Some(format!("[{bits}]"))
}

async fn genotypes(connection: &mut SqliteConnection, commit: &GenerationCommit<'_>) -> Result {
    for chunk in commit.evaluated.chunks(ROWS) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO genotype (replication_id, generation, individual, genes) ",
        );
        insert.push_values(chunk, |mut row, evaluated| {
            let genotype = &commit.population.members[evaluated.member as usize].genotype;
            key(&mut row, commit, evaluated.member).push_bind(genotype.to_bytes());
        });
        run(connection, insert).await?;
    }
    Ok(())
}

async fn finished(connection: &mut SqliteConnection, replication: ReplicationId) -> Result {
    let mut update = QueryBuilder::<Sqlite>::new("UPDATE replication SET finished_at = ");
    update.push(NOW).push(" WHERE id = ").push_bind(replication.0);
    update.build().execute(connection).await?;
    Ok(())
}

/// The columns with which every row of a generation begins.
fn key<'row, 'query>(
    row: &'row mut sqlx::query_builder::Separated<'query, Sqlite, &'static str>,
    commit: &GenerationCommit<'_>,
    individual: u32,
) -> &'row mut sqlx::query_builder::Separated<'query, Sqlite, &'static str> {
    row.push_bind(commit.replication.0).push_bind(commit.population.generation).push_bind(individual)
}

async fn run(connection: &mut SqliteConnection, mut insert: QueryBuilder<Sqlite>) -> Result {
    insert.build().persistent(true).execute(connection).await?;
    Ok(())
}
