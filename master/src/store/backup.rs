//! A copy of the history while it is written.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::{SqliteStore, StoreError, open};

impl SqliteStore {
    /// Copies the history as it stands into another file, and returns the length of that, in bytes. A master that
    /// writes meanwhile is not held up. The copy appears when it is complete and on the disk; one that is there is
    /// replaced then.
    ///
    /// # Errors
    /// [`StoreError::Foreign`] when the file there is no history, or is this one; others when the history cannot be read
    /// or the copy cannot be written. What was there stays then.
    pub async fn back_up(&self, to: &Path) -> Result<u64, StoreError> {
        self.replaceable(to).await?;
        let part = part(to);
        let failed = |error: io::Error| StoreError::from_io(&part, &error);
        remove(&part).map_err(failed)?;
        let copied = self.copy(&part).await;
        if let Err(error) = copied {
            // What there is of it is of no use to anybody.
            let _ = remove(&part);
            return Err(error);
        }
        let file = File::open(&part).map_err(failed)?;
        file.sync_all().map_err(failed)?;
        std::fs::rename(&part, to).map_err(|error| StoreError::from_io(to, &error))?;
        // The new name has to be on the disk as well, where folders can be synced.
        if let Some(Ok(folder)) = to.parent().map(File::open) {
            let _ = folder.sync_all();
        }
        Ok(file.metadata().map_err(failed)?.len())
    }

    /// Whether there may be a copy in place of the file.
    async fn replaceable(&self, to: &Path) -> Result<(), StoreError> {
        if let (Ok(ours), Ok(there)) = (self.path.canonicalize(), to.canonicalize())
            && ours == there
        {
            let reason = "it is the history that is to be copied".to_owned();
            return Err(StoreError::Foreign { path: to.to_owned(), reason });
        }
        match open::reader(to).await {
            // An older one is a history, too, and so is one that was damaged.
            Ok(_)
            | Err(StoreError::Missing { .. } | StoreError::Older { .. } | StoreError::Corrupt { .. }) => {
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    async fn copy(&self, to: &Path) -> Result<(), StoreError> {
        let Some(name) = to.to_str() else {
            let reason = "a name in UTF-8 is expected".to_owned();
            return Err(StoreError::Database { path: to.to_owned(), reason });
        };
        let mut state = self.state().await;
        let copied = sqlx::query("VACUUM INTO ?").bind(name).execute(&mut state.connection).await;
        copied.map(drop).map_err(|error| StoreError::from_sqlite(to, &error))
    }
}

/// The copy's name until it is complete.
fn part(of: &Path) -> PathBuf {
    let mut name = of.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

fn remove(file: &Path) -> io::Result<()> {
    match std::fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
