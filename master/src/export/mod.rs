//! A history as tidy tables, one file each: CSV or Parquet. `docs/export.md` says what is in them.

mod columns;
mod parquet;
mod sheet;
mod signals;

use std::path::PathBuf;

use selftalk_sim::robot::RobotError;
use thiserror::Error;

pub use columns::{Column, Kind, Topic, Value};
pub use sheet::{FileType, Folder, Sheet, Written};
pub use signals::rows;

/// Why tables cannot be written.
#[derive(Debug, Error)]
pub enum ExportError {
    /// A file is there already.
    #[error("{}: is there already; name another folder with --out, or replace its files with --force", .0.display())]
    Occupied(PathBuf),
    /// A file cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The shipped robot is damaged.
    #[error(transparent)]
    Robot(#[from] RobotError),
}
