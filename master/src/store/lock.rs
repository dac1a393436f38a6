//! At most one master a history.

use std::ffi::OsString;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::StoreError;

/// The right to write a history: an advisory lock on the file `<database>.lock`, which names the holder's process.
///
/// The operating system releases it when the process ends, however it ends. The file itself stays: deleting it could
/// let two masters lock two files of the same name.
#[derive(Debug)]
pub(super) struct WriterLock {
    _file: File,
}

impl WriterLock {
    /// Takes the lock, or says who has it.
    pub(super) fn acquire(database: &Path) -> Result<Self, StoreError> {
        let fail = |error| StoreError::from_io(database, &error);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(lock_path(database))
            .map_err(fail)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // Some systems do not let others read a locked file.
                let known = file.read_to_string(&mut holder).is_ok() && !holder.trim().is_empty();
                let process =
                    if known { format!("process {}", holder.trim()) } else { "unknown process".to_owned() };
                let holder = format!("another selftalk master ({process})");
                return Err(StoreError::Locked { path: database.to_owned(), holder });
            }
            Err(TryLockError::Error(error)) => return Err(fail(error)),
        }
        file.set_len(0).map_err(fail)?;
        file.rewind().map_err(fail)?;
        writeln!(file, "{}", std::process::id()).map_err(fail)?;
        Ok(Self { _file: file })
    }
}

fn lock_path(database: &Path) -> PathBuf {
    let mut name = OsString::from(database);
    name.push(".lock");
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_holder_is_refused_and_told_who_has_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.db");
        let first = WriterLock::acquire(&path).unwrap();
        let error = WriterLock::acquire(&path).unwrap_err();
        assert!(error.to_string().contains(&format!("process {}", std::process::id())), "{error}");
        drop(first);
        WriterLock::acquire(&path).unwrap();
    }

    #[test]
    fn a_lock_file_left_behind_by_a_killed_master_is_no_obstacle() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.db");
        std::fs::write(lock_path(&path), "1234567\n").unwrap();
        let _lock = WriterLock::acquire(&path).unwrap();
        assert_eq!(std::fs::read_to_string(lock_path(&path)).unwrap().trim(), std::process::id().to_string());
    }
}
