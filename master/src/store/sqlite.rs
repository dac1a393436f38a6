//! The history in an SQLite file.

use std::path::{Path, PathBuf};

use selftalk_sim::Experiment;
use sqlx::SqliteConnection;
use tokio::sync::{Mutex, MutexGuard};

use super::commit::Checked;
use super::generations::GenerationReader;
use super::lock::WriterLock;
use super::{
    GenerationCommit, GenerationRecord, ReplicationId, Resumed, Store, StoreError, StoredExperiment,
    StoredReplication, Unproven, WorkerId, WorkerInfo, open, read, unproven, write,
};

/// An open history.
#[derive(Debug)]
pub struct SqliteStore {
    pub(super) path: PathBuf,
    state: Mutex<State>,
    /// Held by a writer until it is dropped, after the connection.
    _lock: Option<WriterLock>,
}

#[derive(Debug)]
pub(super) struct State {
    pub(super) connection: SqliteConnection,
    /// A transaction was begun and its end not seen: it failed, or whoever waited for it was dropped.
    unsettled: bool,
    /// Whether a transaction is on the disk when its end returns.
    synced: bool,
}

/// When a transaction has to be on the disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Durable {
    /// When its end returns.
    AtOnce,
    /// With the next one that is at once: so that a thousand workers may join without a thousand waits for the disk.
    WithTheNext,
}

impl SqliteStore {
    /// Opens the history for writing, and creates it if there is none. The schema is brought up to date.
    ///
    /// # Errors
    /// [`StoreError::Locked`] when another master writes it; others when it is not a sound history of a release up to
    /// this one, or the place cannot be written.
    pub async fn open_writer(path: &Path) -> Result<Self, StoreError> {
        // Two names of one file must find the same lock.
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let lock = WriterLock::acquire(&path)?;
        let connection = open::writer(&path).await?;
        Ok(Self::new(path, connection, Some(lock)))
    }

    /// Opens the history for reading, whether or not a master is writing it. What the writing calls return is
    /// [`StoreError::ReadOnly`].
    ///
    /// # Errors
    /// [`StoreError::Missing`] when there is no such file; others when it is not a sound history of this release.
    pub async fn open_reader(path: &Path) -> Result<Self, StoreError> {
        let connection = open::reader(path).await?;
        Ok(Self::new(path.to_owned(), connection, None))
    }

    fn new(path: PathBuf, connection: SqliteConnection, lock: Option<WriterLock>) -> Self {
        Self { path, state: Mutex::new(State { connection, unsettled: false, synced: true }), _lock: lock }
    }

    /// Closes the file and waits until that is done. Without it the write-ahead log may stay beside the file, which
    /// is as safe.
    ///
    /// # Errors
    /// [`StoreError`] when the last writes fail.
    pub async fn close(self) -> Result<(), StoreError> {
        open::close(&self.path, self.state.into_inner().connection).await
    }

    /// Reads the generations of a replication one after the other or here and there.
    #[must_use]
    pub fn generations(&self, replication: &StoredReplication) -> Generations<'_> {
        Generations {
            store: self,
            reader: GenerationReader::new(&self.path, replication.id, replication.number),
        }
    }

    pub(super) fn fail(&self, error: &sqlx::Error) -> StoreError {
        StoreError::from_sqlite(&self.path, error)
    }

    /// The connection, outside any transaction.
    pub(super) async fn state(&self) -> MutexGuard<'_, State> {
        let mut state = self.state.lock().await;
        if state.unsettled {
            // It fails when SQLite has rolled back by itself already, as it does when the disk is full.
            let _ = sqlx::query("ROLLBACK").execute(&mut state.connection).await;
            state.unsettled = false;
        }
        state
    }

    /// Begins a transaction. It takes place when [`Self::commit`] returns; otherwise nothing of it does.
    pub(super) async fn begin(&self) -> Result<MutexGuard<'_, State>, StoreError> {
        self.begin_as(Durable::AtOnce).await
    }

    async fn begin_as(&self, durable: Durable) -> Result<MutexGuard<'_, State>, StoreError> {
        let mut state = self.state().await;
        let synced = durable == Durable::AtOnce;
        if state.synced != synced {
            // In WAL mode, NORMAL does not wait for the disk at a transaction's end, and FULL waits for all before as well.
            let set = if synced { "PRAGMA synchronous = FULL" } else { "PRAGMA synchronous = NORMAL" };
            sqlx::query(set).execute(&mut state.connection).await.map_err(|error| self.fail(&error))?;
            state.synced = synced;
        }
        state.unsettled = true;
        let begin = sqlx::query("BEGIN IMMEDIATE").execute(&mut state.connection).await;
        begin.map_err(|error| self.fail(&error))?;
        Ok(state)
    }

    pub(super) async fn commit(&self, mut state: MutexGuard<'_, State>) -> Result<(), StoreError> {
        let commit = sqlx::query("COMMIT").execute(&mut state.connection).await;
        commit.map_err(|error| self.fail(&error))?;
        state.unsettled = false;
        Ok(())
    }
}

/// Reads the generations of one replication; consecutive ones are cheapest.
pub struct Generations<'a> {
    store: &'a SqliteStore,
    reader: GenerationReader<'a>,
}

impl Generations<'_> {
    /// Everything about a generation.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be read, or does not hold what was committed.
    pub async fn read(&mut self, generation: u32) -> Result<GenerationRecord, StoreError> {
        let mut state = self.store.state().await;
        self.reader.record(&mut state.connection, generation).await
    }
}

impl Store for SqliteStore {
    async fn create_experiment(
        &self,
        experiment: &Experiment,
        fingerprint: &str,
    ) -> Result<StoredExperiment, StoreError> {
        let mut state = self.begin().await?;
        let name = experiment.name.clone();
        let existing = read::experiments(&self.path, &mut state.connection, Some(&name)).await?;
        if !existing.is_empty() {
            return Err(StoreError::Exists { path: self.path.clone(), name });
        }
        write::experiment(&mut state.connection, experiment, fingerprint)
            .await
            .map_err(|error| self.fail(&error))?;
        let created = read::experiments(&self.path, &mut state.connection, Some(&name)).await?.pop();
        let created = created.ok_or_else(|| self.fail(&sqlx::Error::RowNotFound))?;
        self.commit(state).await?;
        Ok(created)
    }

    async fn experiment(&self, name: &str) -> Result<Option<StoredExperiment>, StoreError> {
        let mut state = self.state().await;
        Ok(read::experiments(&self.path, &mut state.connection, Some(name)).await?.pop())
    }

    async fn experiments(&self) -> Result<Vec<StoredExperiment>, StoreError> {
        let mut state = self.state().await;
        read::experiments(&self.path, &mut state.connection, None).await
    }

    async fn last_generation(&self, replication: ReplicationId) -> Result<Option<Resumed>, StoreError> {
        let mut state = self.state().await;
        let connection = &mut state.connection;
        let at = read::replication(connection, replication).await.map_err(|error| self.fail(&error))?;
        let Some(last) = at.generations.checked_sub(1) else { return Ok(None) };
        GenerationReader::new(&self.path, replication, at.number).population(connection, last).await.map(Some)
    }

    async fn commit_generation(&self, commit: GenerationCommit<'_>) -> Result<(), StoreError> {
        let mut state = self.begin().await?;
        let at = read::replication(&mut state.connection, commit.replication).await;
        let at = at.map_err(|error| self.fail(&error))?;
        let checked = Checked::new(commit, at)
            .map_err(|reason| StoreError::Commit { path: self.path.clone(), reason })?;
        write::generation(&mut state.connection, &checked).await.map_err(|error| self.fail(&error))?;
        self.commit(state).await
    }

    async fn take_back(&self, replication: ReplicationId, from: u32) -> Result<(), StoreError> {
        let mut state = self.begin().await?;
        let taken = write::take_back(&mut state.connection, replication, from).await;
        taken.map_err(|error| self.fail(&error))?;
        self.commit(state).await
    }

    async fn worker_joined(&self, worker: &WorkerInfo) -> Result<WorkerId, StoreError> {
        let mut state = self.begin_as(Durable::WithTheNext).await?;
        let id = write::worker(&mut state.connection, worker).await.map_err(|error| self.fail(&error))?;
        self.commit(state).await?;
        Ok(id)
    }

    async fn worker_left(&self, worker: WorkerId) -> Result<(), StoreError> {
        let mut state = self.begin_as(Durable::WithTheNext).await?;
        write::worker_left(&mut state.connection, worker).await.map_err(|error| self.fail(&error))?;
        self.commit(state).await
    }

    async fn workers_audited(&self, workers: &[WorkerId]) -> Result<(), StoreError> {
        let mut state = self.begin_as(Durable::WithTheNext).await?;
        for &worker in workers {
            let noted = write::worker_audited(&mut state.connection, worker).await;
            noted.map_err(|error| self.fail(&error))?;
        }
        self.commit(state).await
    }

    async fn unproven(&self) -> Result<Vec<Unproven>, StoreError> {
        let mut state = self.state().await;
        unproven::read(&self.path, &mut state.connection).await
    }
}
