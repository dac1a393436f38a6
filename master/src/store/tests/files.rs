//! Files that are not what they should be, and places where there can be none.

use std::fs;
use std::path::{Path, PathBuf};

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection};

use super::*;
use crate::store::SqliteStore;

/// A sound, closed history of a few generations.
async fn sound(folder: &Path) -> PathBuf {
    let path = folder.join("a.db");
    let store = SqliteStore::open_writer(&path).await.unwrap();
    run(&store, &experiment("a"), 3).await;
    store.close().await.unwrap();
    path
}

/// Runs a statement on any SQLite file, creating it.
async fn alter(path: &Path, statement: &'static str) {
    let options = SqliteConnectOptions::new().filename(path).create_if_missing(true);
    let mut connection = options.connect().await.unwrap();
    sqlx::query(statement).execute(&mut connection).await.unwrap();
    connection.close().await.unwrap();
}

/// What opening says, for writing and for reading.
async fn refusals(path: &Path) -> [StoreError; 2] {
    let errors = [
        SqliteStore::open_writer(path).await.map(drop).unwrap_err(),
        SqliteStore::open_reader(path).await.map(drop).unwrap_err(),
    ];
    for error in &errors {
        let message = error.to_string();
        assert!(message.starts_with(&path.display().to_string()), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    errors
}

#[tokio::test]
async fn a_second_master_is_refused_and_a_reader_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = sound(folder.path()).await;
    let first = SqliteStore::open_writer(&path).await.unwrap();
    let error = SqliteStore::open_writer(&path).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::Locked { .. }), "{error}");
    assert!(error.to_string().contains(&format!("process {}", std::process::id())), "{error}");
    #[cfg(unix)]
    {
        let alias = folder.path().join("alias.db");
        std::os::unix::fs::symlink(&path, &alias).unwrap();
        let error = SqliteStore::open_writer(&alias).await.map(drop).unwrap_err();
        assert!(matches!(error, StoreError::Locked { .. }), "{error}");
    }
    SqliteStore::open_reader(&path).await.unwrap();
    drop(first);
    SqliteStore::open_writer(&path).await.unwrap();
}

#[tokio::test]
async fn a_missing_file_is_created_by_a_writer_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.db");
    let error = SqliteStore::open_reader(&path).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::Missing { .. }), "{error}");
    assert!(!path.exists());
    SqliteStore::open_writer(&path).await.unwrap();
    assert!(path.exists());
    let [write, read] = refusals(&folder.path().join("no/where.db")).await;
    assert!(matches!(write, StoreError::NoFolder { .. }), "{write}");
    assert!(matches!(read, StoreError::Missing { .. }), "{read}");
}

#[tokio::test]
async fn an_empty_file_becomes_a_history_unless_a_log_belongs_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.db");
    fs::write(&path, "").unwrap();
    let error = SqliteStore::open_reader(&path).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
    fs::write(folder.path().join("empty.db-wal"), "something").unwrap();
    let error = SqliteStore::open_writer(&path).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::Corrupt { .. }), "{error}");
    fs::remove_file(folder.path().join("empty.db-wal")).unwrap();
    SqliteStore::open_writer(&path).await.unwrap();
}

#[tokio::test]
async fn foreign_files_are_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("text.db");
    fs::write(&text, "Dear diary, ".repeat(1000)).unwrap();
    let other = folder.path().join("other.db");
    alter(&other, "CREATE TABLE recipe (name TEXT)").await;
    for path in [&text, &other] {
        let before = fs::read(path).unwrap();
        for error in refusals(path).await {
            assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
        }
        assert_eq!(fs::read(path).unwrap(), before);
    }
    let [_, read] = refusals(folder.path()).await;
    assert!(matches!(read, StoreError::Foreign { .. }), "{read}");
}

#[tokio::test]
async fn later_releases_files_are_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = sound(folder.path()).await;
    alter(&path, "PRAGMA user_version = 99").await;
    let before = fs::read(&path).unwrap();
    for error in refusals(&path).await {
        assert!(matches!(error, StoreError::Newer { found: 99, .. }), "{error}");
    }
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[tokio::test]
async fn a_file_whose_creation_was_interrupted_is_completed_by_a_writer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    alter(&path, "PRAGMA application_id = 1936483956").await;
    let error = SqliteStore::open_reader(&path).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::Older { found: 0, .. }), "{error}");
    let store = SqliteStore::open_writer(&path).await.unwrap();
    run(&store, &experiment("a"), 1).await;
}

#[tokio::test]
async fn truncated_files_are_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = sound(folder.path()).await;
    let whole = fs::read(&path).unwrap();
    let cut = async |length: usize| {
        // A place of its own: what a refused connection leaves behind may only be tidied up later.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.db");
        fs::write(&path, &whole[..length]).unwrap();
        refusals(&path).await
    };
    for length in [whole.len() - 4096, whole.len() - 1, whole.len() / 2, 8192, 5000, 4096] {
        for error in cut(length).await {
            assert!(matches!(error, StoreError::Corrupt { .. }), "{length}: {error}");
        }
    }
    for length in [2, 50, 1000] {
        for error in cut(length).await {
            let told = matches!(error, StoreError::Corrupt { .. } | StoreError::Foreign { .. });
            assert!(told, "{length}: {error}");
        }
    }
}

#[tokio::test]
async fn overwritten_pages_are_damage_wherever_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = sound(folder.path()).await;
    let whole = fs::read(&path).unwrap();
    let mut noticed = 0;
    for page in 0..whole.len() / 4096 {
        let mut damaged = whole.clone();
        // The first page's header stays, so that the file is still taken for a history.
        let start = page * 4096 + if page == 0 { 100 } else { 0 };
        damaged[start..(page + 1) * 4096].fill(0xa5);
        fs::write(&path, damaged).unwrap();
        if let Err(error) = read_everything(&path).await {
            noticed += 1;
            assert!(matches!(error, StoreError::Corrupt { .. }), "page {page}: {error}");
        }
    }
    // Pages that only indexes or migrations use are not read.
    assert!(noticed * 10 > whole.len() / 4096 * 8, "{noticed} of {}", whole.len() / 4096);
}

async fn read_everything(path: &Path) -> Result<(), StoreError> {
    let store = SqliteStore::open_reader(path).await?;
    for experiment in store.experiments().await? {
        for replication in &experiment.replications {
            let mut generations = store.generations(replication);
            for generation in 0..replication.generations {
                generations.read(generation).await?;
            }
        }
    }
    Ok(())
}

/// Permissions do not bind the superuser; /sys refuses new files to everybody.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_folder_that_cannot_be_written_is_said_to_be_so() {
    let error = SqliteStore::open_writer(Path::new("/sys/selftalk.db")).await.map(drop).unwrap_err();
    assert!(matches!(error, StoreError::ReadOnly { .. }), "{error}");
}

#[cfg(unix)]
#[tokio::test]
async fn a_history_on_a_read_only_medium_can_be_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = sound(folder.path()).await;
    let lock = folder.path().join("a.db.lock");
    let protect = |folder_mode, file_mode| {
        fs::set_permissions(&path, fs::Permissions::from_mode(file_mode)).unwrap();
        fs::set_permissions(&lock, fs::Permissions::from_mode(file_mode)).unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(folder_mode)).unwrap();
    };
    protect(0o555, 0o444);
    read_everything(&path).await.unwrap();
    let writer = SqliteStore::open_writer(&path).await.map(drop);
    protect(0o755, 0o644);
    match writer {
        Err(error) => assert!(matches!(error, StoreError::ReadOnly { .. }), "{error}"),
        Ok(()) => eprintln!("not tested: permissions do not bind this user"),
    }
}
