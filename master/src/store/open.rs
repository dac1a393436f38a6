//! Opening a history: what the file has to be before it is touched.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Duration;

use sqlx::migrate::{MigrateError, Migrator};
use sqlx::sqlite::{SqliteConnectOptions, SqliteSynchronous};
use sqlx::{ConnectOptions, Connection, SqliteConnection};

use super::StoreError;

/// Marks a file as ours; "slft" in SQLite's header.
pub(super) const APPLICATION_ID: i64 = 0x736c_6674;

static MIGRATIONS: Migrator = sqlx::migrate!("../migrations");

/// Rows that SQLite's thread may be ahead of their reader: with few the two wait for each other again and again.
const ROWS_AHEAD: usize = 4096;

/// How long to wait for another program that has the file.
const PATIENCE: Duration = Duration::from_secs(10);

/// The schema version this release writes: the number of its last migration, which sets `user_version` to it.
#[must_use]
pub fn schema_version() -> i64 {
    MIGRATIONS.iter().map(|migration| migration.version).max().unwrap_or_default()
}

/// Opens or creates a file for writing, and brings its schema up to date. Nothing is written to a file that is not
/// ours.
pub(super) async fn writer(path: &Path) -> Result<SqliteConnection, StoreError> {
    if log_in_use(path) && std::fs::metadata(path).is_ok_and(|file| file.len() == 0) {
        // SQLite would discard the log, with which the file can perhaps be rescued.
        let reason = "it is empty, but its write-ahead log is there".to_owned();
        return Err(StoreError::Corrupt { path: path.to_owned(), reason });
    }
    whole(path)?;
    let fail = |error| StoreError::from_sqlite(path, &error);
    let options = options(path).create_if_missing(true).synchronous(SqliteSynchronous::Full);
    let mut connection = options.connect().await.map_err(fail)?;
    let tables: i64 = pragma(&mut connection, "SELECT count(*) FROM sqlite_schema").await.map_err(fail)?;
    if tables == 0 && pragma(&mut connection, "PRAGMA application_id").await.map_err(fail)? == 0 {
        let mark = format!("PRAGMA application_id = {APPLICATION_ID}");
        sqlx::query(sqlx::AssertSqlSafe(mark)).execute(&mut connection).await.map_err(fail)?;
    }
    check(path, &mut connection).await?;
    MIGRATIONS.run(&mut connection).await.map_err(|error| match error {
        MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => fail(error),
        other => StoreError::Database { path: path.to_owned(), reason: other.to_string() },
    })?;
    // Only now: turning on the log writes to the file, which had to be known as ours before.
    sqlx::query("PRAGMA journal_mode = WAL").execute(&mut connection).await.map_err(fail)?;
    Ok(connection)
}

/// Opens a file that exists for reading, while a master may be writing it.
pub(super) async fn reader(path: &Path) -> Result<SqliteConnection, StoreError> {
    let refuse = |reason: &str| StoreError::Foreign { path: path.to_owned(), reason: reason.to_owned() };
    match std::fs::metadata(path) {
        Ok(file) if file.is_dir() => return Err(refuse("it is a folder")),
        Ok(file) if file.len() == 0 => return Err(refuse("the file is empty")),
        Ok(_) => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(StoreError::Missing { path: path.to_owned() });
        }
        Err(error) => return Err(StoreError::Database { path: path.to_owned(), reason: error.to_string() }),
    }
    whole(path)?;
    let mut opened = open_existing(path, false).await;
    if matches!(opened, Err(StoreError::ReadOnly { .. } | StoreError::Database { .. })) && !log_in_use(path) {
        // Where nothing can be written, readers cannot coordinate with a writer, but neither can there be one.
        opened = open_existing(path, true).await;
    }
    let (connection, version) = opened?;
    if version < schema_version() {
        return Err(StoreError::Older { path: path.to_owned(), found: version, known: schema_version() });
    }
    Ok(connection)
}

async fn open_existing(path: &Path, immutable: bool) -> Result<(SqliteConnection, i64), StoreError> {
    let options = options(path).read_only(true).immutable(immutable);
    let mut connection = options.connect().await.map_err(|error| StoreError::from_sqlite(path, &error))?;
    let version = check(path, &mut connection).await?;
    Ok((connection, version))
}

fn options(path: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .foreign_keys(true)
        .busy_timeout(PATIENCE)
        .row_buffer_size(ROWS_AHEAD)
        .disable_statement_logging()
}

/// Makes sure that the file is a history this release knows, and returns its schema version.
async fn check(path: &Path, connection: &mut SqliteConnection) -> Result<i64, StoreError> {
    let fail = |error| StoreError::from_sqlite(path, &error);
    if pragma(connection, "PRAGMA application_id").await.map_err(fail)? != APPLICATION_ID {
        let reason = "it is another program's SQLite database".to_owned();
        return Err(StoreError::Foreign { path: path.to_owned(), reason });
    }
    let (found, known) = (pragma(connection, "PRAGMA user_version").await.map_err(fail)?, schema_version());
    if found > known {
        return Err(StoreError::Newer { path: path.to_owned(), found, known });
    }
    Ok(found)
}

async fn pragma(connection: &mut SqliteConnection, statement: &'static str) -> Result<i64, sqlx::Error> {
    sqlx::query_scalar(statement).fetch_one(connection).await
}

/// Refuses a file that was cut within a page, which SQLite would fill up with zeros. Missing pages it notices itself.
fn whole(path: &Path) -> Result<(), StoreError> {
    let mut header = [0; 18];
    let read = File::open(path).and_then(|mut file| {
        file.read_exact(&mut header)?;
        file.metadata()
    });
    // What cannot be read is left to SQLite, and what the log may still complete as well.
    let Ok(file) = read else { return Ok(()) };
    if !header.starts_with(b"SQLite format 3\0") || log_in_use(path) {
        return Ok(());
    }
    let page = match u64::from(u16::from_be_bytes([header[16], header[17]])) {
        1 => 65_536,
        size => size,
    };
    if file.len().checked_rem(page).is_some_and(|rest| rest != 0) {
        let reason = "its end is missing".to_owned();
        return Err(StoreError::Corrupt { path: path.to_owned(), reason });
    }
    Ok(())
}

/// Whether SQLite's write-ahead log holds something that the file may not.
fn log_in_use(path: &Path) -> bool {
    let mut name = path.as_os_str().to_owned();
    name.push("-wal");
    std::fs::metadata(name).is_ok_and(|log| log.len() > 0)
}

/// Ends a connection, folding the write-ahead log into the file.
pub(super) async fn close(path: &Path, connection: SqliteConnection) -> Result<(), StoreError> {
    connection.close().await.map_err(|error| StoreError::from_sqlite(path, &error))
}
