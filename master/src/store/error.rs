//! What can go wrong with a history.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a history cannot be opened, read or written. Every message is one line and names the file.
#[derive(Debug, Error)]
pub enum StoreError {
    /// There is no such file.
    #[error("{}: no such file; `selftalk run` creates it", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The folder the file should be created in does not exist.
    #[error("{}: the folder does not exist; create it, or name another file with --db", path.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
    },
    /// The file or its folder cannot be written.
    #[error("{}: cannot be written: {reason}; make it writable, or name another file with --db", path.display())]
    ReadOnly {
        /// The file.
        path: PathBuf,
        /// Which of the two it is.
        reason: String,
    },
    /// The file is not an SQLite database.
    #[error("{}: not a selftalk history: {reason}; name one with --db", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        reason: String,
    },
    /// The file is damaged.
    #[error("{}: the file is damaged: {reason}; go back to a copy of it", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// The disk is full. What was committed before is intact.
    #[error(
        "{}: the disk is full; everything up to the last complete generation is kept, make room and resume",
        path.display()
    )]
    Full {
        /// The file.
        path: PathBuf,
    },
    /// Another master, or any other program, has the file.
    #[error("{}: in use by {holder}; wait until it has ended, or end it", path.display())]
    Locked {
        /// The file.
        path: PathBuf,
        /// Who has it, as far as is known.
        holder: String,
    },
    /// The file was written by a later release.
    #[error("{}: written by a later release (schema {found}, this one knows up to {known}); use that one", path.display())]
    Newer {
        /// The file.
        path: PathBuf,
        /// The file's schema version.
        found: i64,
        /// The newest version this release can read.
        known: i64,
    },
    /// The file was written by an earlier release, and is only being read.
    #[error("{}: written by an earlier release (schema {found}, this one has {known}); `selftalk resume` upgrades it", path.display())]
    Older {
        /// The file.
        path: PathBuf,
        /// The file's schema version.
        found: i64,
        /// This release's schema version.
        known: i64,
    },
    /// An experiment of that name is there already.
    #[error("{}: experiment `{name}` exists already; give the new one another name with `--set name=...`", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
        /// The experiment's name.
        name: String,
    },
    /// A generation does not continue the replication, or its parts do not fit together.
    #[error("{}: a generation was refused: {reason}", path.display())]
    Commit {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// Anything else the database reports.
    #[error("{}: {reason}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// The database's words.
        reason: String,
    },
}

/// SQLite's primary result codes, <https://sqlite.org/rescode.html>.
mod code {
    pub(super) const BUSY: i32 = 5;
    pub(super) const LOCKED: i32 = 6;
    pub(super) const READONLY: i32 = 8;
    pub(super) const IOERR: i32 = 10;
    pub(super) const CORRUPT: i32 = 11;
    pub(super) const FULL: i32 = 13;
    pub(super) const CANTOPEN: i32 = 14;
    pub(super) const NOTADB: i32 = 26;
    /// Extended: the file shared between readers and writer could not grow.
    pub(super) const IOERR_SHMSIZE: i32 = 4874;
}

impl StoreError {
    /// What a file operation's failure means for the database.
    pub(super) fn from_io(path: &Path, error: &io::Error) -> Self {
        let path = path.to_owned();
        match error.kind() {
            io::ErrorKind::NotFound => Self::NoFolder { path },
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Self::ReadOnly { path, reason: format!("the folder is read-only ({error})") }
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::Full { path },
            _ => Self::Database { path, reason: error.to_string() },
        }
    }

    /// What a failure that SQLite reports means.
    pub(super) fn from_sqlite(path: &Path, error: &sqlx::Error) -> Self {
        let path = path.to_owned();
        let (extended, reason) = match error {
            sqlx::Error::Database(database) => {
                let code = database.code().and_then(|code| code.parse::<i32>().ok()).unwrap_or_default();
                (code, one_line(database.message()))
            }
            // A value that does not fit its column's type.
            sqlx::Error::ColumnDecode { .. } | sqlx::Error::Decode(_) => {
                (code::CORRUPT, one_line(&error.to_string()))
            }
            _ => (0, one_line(&error.to_string())),
        };
        match extended & 0xff {
            code::NOTADB => Self::Foreign { path, reason: "it is not an SQLite database".to_owned() },
            code::CORRUPT => Self::Corrupt { path, reason },
            code::FULL => Self::Full { path },
            code::IOERR if extended == code::IOERR_SHMSIZE => Self::Full { path },
            code::READONLY => {
                Self::ReadOnly { path, reason: "the file or its folder is read-only".to_owned() }
            }
            code::BUSY | code::LOCKED => Self::Locked { path, holder: "another program".to_owned() },
            code::CANTOPEN => {
                Self::Database { path, reason: "the file or one beside it cannot be opened".to_owned() }
            }
            _ => Self::Database { path, reason },
        }
    }
}

fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join(" ")
}
