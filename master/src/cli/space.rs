//! Whether the disk has room for what a run is going to write.

use std::path::{Path, PathBuf};
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval};

use crate::driver::Board;

/// How often it is looked at.
const PERIOD: Duration = Duration::from_secs(30);
/// Less room than this is said in any case: no more than some generations of many replications.
const LITTLE: u64 = 64 << 20;
/// Generations of a run after which it is told how fast the database grows; before, what SQLite does at once and not bit by
/// bit weighs too much.
const ENOUGH: u64 = 500;

/// Watches the room for a database while a run goes on. Ended by dropping it.
pub(super) struct Space {
    watching: JoinHandle<()>,
}

impl Space {
    /// Begins to watch; a warning is logged once for each reason.
    pub(super) fn watch(database: &Path, board: watch::Receiver<Board>) -> Self {
        let database = database.to_owned();
        Self { watching: tokio::spawn(watch(database, board)) }
    }
}

impl Drop for Space {
    fn drop(&mut self) {
        self.watching.abort();
    }
}

async fn watch(database: PathBuf, board: watch::Receiver<Board>) {
    let (begun, _) = generations(&board.borrow());
    let size = size(&database);
    let (mut almost_full, mut will_be_full) = (false, false);
    let mut moments = interval(PERIOD);
    moments.set_missed_tick_behavior(MissedTickBehavior::Delay);
    while !(almost_full && will_be_full) {
        moments.tick().await;
        let Some(free) = free(&database) else { return };
        let (done, left) = generations(&board.borrow());
        if !almost_full && free < LITTLE {
            tracing::warn!(
                "{}: the disk has only {} MiB left; when it is full the run ends, with all complete generations",
                database.display(),
                free >> 20
            );
            almost_full = true;
        }
        let growth = Growth {
            bytes: self::size(&database).saturating_sub(size),
            generations: done.saturating_sub(begun),
            left,
        };
        if let Some(needed) = growth.needed().filter(|needed| !will_be_full && *needed > free) {
            tracing::warn!(
                "{}: the {left} generations to come need about {} MiB, and the disk has {} MiB left",
                database.display(),
                needed >> 20,
                free >> 20
            );
            will_be_full = true;
        }
    }
}

/// How a database has grown.
#[derive(Debug, Clone, Copy)]
struct Growth {
    /// By so many bytes ...
    bytes: u64,
    /// ... in so many generations.
    generations: u64,
    /// Generations to come.
    left: u64,
}

impl Growth {
    /// Bytes that the generations to come need; none as long as that cannot be told.
    fn needed(self) -> Option<u64> {
        let needed = u128::from(self.bytes) * u128::from(self.left) / u128::from(self.generations.max(1));
        (self.generations >= ENOUGH).then(|| u64::try_from(needed).unwrap_or(u64::MAX))
    }
}

/// Generations that are committed, and that are to come.
fn generations(board: &Board) -> (u64, u64) {
    let done = board.standings.iter().map(|standing| u64::from(standing.generations)).sum();
    let open = board.standings.iter().filter(|standing| !standing.finished);
    (done, open.map(|standing| u64::from(standing.of.saturating_sub(standing.generations))).sum())
}

/// Bytes of a database, with what has not been moved into it yet.
fn size(database: &Path) -> u64 {
    let mut log = database.as_os_str().to_owned();
    log.push("-wal");
    let length = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
    length(database) + length(Path::new(&log))
}

/// Bytes that may still be written where a database is; none where the system does not tell.
#[cfg(unix)]
fn free(database: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(database).ok()?;
    Some(disk.f_bavail.saturating_mul(disk.f_frsize))
}

#[cfg(not(unix))]
fn free(_database: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_come_needs_as_much_a_generation_as_what_was() {
        let growth = Growth { bytes: 8_000_000, generations: 1000, left: 14_000 };
        assert_eq!(growth.needed(), Some(112_000_000));
        assert_eq!(Growth { generations: 499, ..growth }.needed(), None);
        assert_eq!(Growth { left: 0, ..growth }.needed(), Some(0));
    }

    #[test]
    fn a_database_is_as_long_as_its_file_and_its_log() {
        let folder = tempfile::tempdir().unwrap();
        let database = folder.path().join("a.db");
        assert_eq!(size(&database), 0);
        std::fs::write(&database, [0; 100]).unwrap();
        std::fs::write(folder.path().join("a.db-wal"), [0; 11]).unwrap();
        assert_eq!(size(&database), 111);
        #[cfg(unix)]
        assert!(free(&database).is_some_and(|free| free > 0));
    }
}
