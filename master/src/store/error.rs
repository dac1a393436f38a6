//! What can go wrong with a history.

use std::path::PathBuf;

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
    #[error("{}: the folder does not exist", path.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
    },
    /// The file or its folder cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    ReadOnly {
        /// The file.
        path: PathBuf,
        /// Which of the two it is.
        reason: String,
    },
    /// The file is not an SQLite database.
    #[error("{}: not a selftalk history: {reason}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        reason: String,
    },
    /// The file is damaged.
    #[error("{}: the file is damaged: {reason}", path.display())]
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
    /// Another master has the file.
    #[error("{}: in use by another selftalk master ({holder})", path.display())]
    Locked {
        /// The file.
        path: PathBuf,
        /// Who has it, as far as is known.
        holder: String,
    },
    /// The file was written by a later release.
    #[error("{}: written by a later release (schema {found}, this one knows up to {known})", path.display())]
    Newer {
        /// The file.
        path: PathBuf,
        /// The file's schema version.
        found: i64,
        /// The newest version this release can read.
        known: i64,
    },
    /// An experiment of that name is there already.
    #[error("{}: experiment `{name}` exists already", path.display())]
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
