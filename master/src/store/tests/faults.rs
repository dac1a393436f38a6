//! Interruptions, a full disk, a damaged file.

use std::path::Path;

use super::*;
use crate::store::SqliteStore;

async fn begun(path: &Path, generations: u32) -> (SqliteStore, Experiment, ReplicationId) {
    let store = SqliteStore::open_writer(path).await.unwrap();
    let experiment = experiment("a");
    run(&store, &experiment, generations).await;
    let id = store.experiment("a").await.unwrap().unwrap().replications[0].id;
    (store, experiment, id)
}

async fn execute(store: &SqliteStore, statement: &'static str) {
    sqlx::query(statement).execute(&mut store.state().await.connection).await.unwrap();
}

async fn count(store: &SqliteStore, statement: &'static str) -> i64 {
    sqlx::query_scalar(statement).fetch_one(&mut store.state().await.connection).await.unwrap()
}

#[tokio::test]
async fn a_failure_within_a_generation_leaves_nothing_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let (store, experiment, id) = begun(&folder.path().join("a.db"), 2).await;
    execute(
        &store,
        "CREATE TEMP TRIGGER fault BEFORE INSERT ON individual WHEN new.number = 99 \
         BEGIN SELECT raise(ABORT, 'injected'); END",
    )
    .await;
    let record = next(&store, &experiment, id, 0).await;
    let error = commit(&store, id, &record, true).await.unwrap_err();
    assert!(error.to_string().contains("injected"), "{error}");
    for rows in ["SELECT count(*) FROM generation", "SELECT count(*) FROM individual"] {
        assert!([4, 400].contains(&count(&store, rows).await));
    }
    assert_eq!(count(&store, "SELECT max(generation) FROM trial").await, 1);
    execute(&store, "DROP TRIGGER fault").await;
    commit(&store, id, &record, true).await.unwrap();
    assert_eq!(count(&store, "SELECT max(generation) FROM trial").await, 2);
}

#[tokio::test]
async fn a_dropped_commit_is_all_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (store, experiment, id) = begun(&folder.path().join("a.db"), 1).await;
    let mut dropped = 0;
    for round in 0..60 {
        let record = next(&store, &experiment, id, 0).await;
        let patience = Duration::from_micros(round * 150);
        dropped +=
            u32::from(tokio::time::timeout(patience, commit(&store, id, &record, false)).await.is_err());
        let last = store.last_generation(id).await.unwrap().unwrap().population;
        let before = record.population.generation - 1;
        assert!(last == record.population || last.generation == before, "{round}");
        let complete = count(&store, "SELECT count(*) FROM individual WHERE replication_id = 1").await;
        assert_eq!(complete, 100 * i64::from(last.generation + 1), "{round}");
    }
    assert!(dropped > 0, "no commit was interrupted");
}

#[tokio::test]
async fn a_master_killed_within_a_commit_resumes_at_the_generation_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let (store, experiment, id) = begun(&path, 2).await;
    let expected = store.last_generation(id).await.unwrap();
    // With next to no cache the rows reach the log before the transaction ends.
    execute(&store, "PRAGMA cache_size = 1").await;
    let record = next(&store, &experiment, id, 0).await;
    let mut state = store.begin().await.unwrap();
    let at = crate::store::read::replication(&mut state.connection, id).await.unwrap();
    let GenerationRecord { population, evaluated, scored, ranking } = &record;
    let (task, finished, wall) = (Task::Elementary, true, Duration::ZERO);
    let commit =
        GenerationCommit { replication: id, task, population, evaluated, scored, ranking, finished, wall };
    let checked = crate::store::commit::Checked::new(commit, at).unwrap();
    crate::store::write::generation(&mut state.connection, &checked).await.unwrap();

    let copy = folder.path().join("copy.db");
    std::fs::copy(&path, &copy).unwrap();
    let log = folder.path().join("copy.db-wal");
    std::fs::copy(folder.path().join("a.db-wal"), &log).unwrap();
    let survivor = SqliteStore::open_writer(&copy).await.unwrap();
    assert_eq!(survivor.last_generation(id).await.unwrap(), expected);
    assert_eq!(count(&survivor, "SELECT max(generation) FROM trial").await, 1);
    super::commit(&survivor, id, &record, true).await.unwrap();
}

#[tokio::test]
async fn a_full_disk_keeps_what_was_committed_and_can_be_recovered_from() {
    let folder = tempfile::tempdir().unwrap();
    let (store, experiment, id) = begun(&folder.path().join("a.db"), 2).await;
    let pages = count(&store, "PRAGMA page_count").await;
    let limit = sqlx::AssertSqlSafe(format!("PRAGMA max_page_count = {}", pages + 3));
    sqlx::query(limit).execute(&mut store.state().await.connection).await.unwrap();
    let error = loop {
        let record = next(&store, &experiment, id, 0).await;
        if let Err(error) = commit(&store, id, &record, false).await {
            break error;
        }
    };
    assert!(matches!(error, StoreError::Full { .. }), "{error}");
    let kept = store.last_generation(id).await.unwrap().unwrap().population.generation;
    assert!(kept >= 1);
    execute(&store, "PRAGMA max_page_count = 1000000").await;
    let record = next(&store, &experiment, id, 0).await;
    assert_eq!(record.population.generation, kept + 1);
    commit(&store, id, &record, false).await.unwrap();
    assert_eq!(count(&store, "SELECT count(*) FROM pragma_foreign_key_check").await, 0);
}

#[tokio::test]
async fn a_changed_genotype_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let (store, _, id) = begun(&folder.path().join("a.db"), 3).await;
    execute(&store, "UPDATE individual SET flipped = '[1]' WHERE generation = 2 AND number = 98").await;
    let error = store.last_generation(id).await.unwrap_err();
    assert!(matches!(error, StoreError::Corrupt { .. }), "{error}");
    assert!(error.to_string().contains("replication 0, generation 2"), "{error}");
    execute(&store, "DELETE FROM genotype").await;
    let error = store.last_generation(id).await.unwrap_err();
    assert!(error.to_string().contains("founders"), "{error}");
}

#[tokio::test]
async fn settings_no_release_would_accept_are_reported_as_damage() {
    let folder = tempfile::tempdir().unwrap();
    let (store, _, _) = begun(&folder.path().join("a.db"), 1).await;
    execute(&store, "UPDATE experiment SET settings = 'seed = true'").await;
    let error = store.experiments().await.unwrap_err();
    assert!(matches!(error, StoreError::Corrupt { .. }), "{error}");
}

#[tokio::test]
async fn readers_see_complete_generations_while_a_master_writes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let (store, experiment, _) = begun(&path, 1).await;
    let reader = SqliteStore::open_reader(&path).await.unwrap();
    let stored = store.experiment("a").await.unwrap().unwrap();
    for expected in 2..6 {
        run(&store, &experiment, 1).await;
        let seen = reader.experiment("a").await.unwrap().unwrap();
        assert_eq!(seen.replications[0].generations, expected);
        reader.generations(&stored.replications[1]).read(expected - 1).await.unwrap();
    }
    let error = reader.create_experiment(&super::experiment("b"), "sim-1").await.unwrap_err();
    assert!(matches!(error, StoreError::ReadOnly { .. }), "{error}");
}
