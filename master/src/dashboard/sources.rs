//! Where the dashboard has what it shows from.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use selftalk_sim::{Behaviour, Simulator};
use tokio::sync::watch;
use tokio::time::sleep;

use crate::driver::Board;
use crate::service::Floor;
use crate::store::{ExperimentId, SqliteStore, StoreError, StoredExperiment};

/// How long the answers that are under way may hold the file when it is taken off the stage.
const PATIENCE: Duration = Duration::from_secs(5);

/// What goes on in the master of this process.
#[derive(Debug, Clone)]
pub struct Live {
    /// Where the replications stand.
    pub board: watch::Receiver<Board>,
    /// What the workers are at.
    pub floor: watch::Receiver<Floor>,
}

/// What is shown.
#[derive(Debug)]
pub struct Sources {
    /// The history, open for reading.
    store: SqliteStore,
    /// Name of its file.
    file: String,
    /// Fingerprint of this program's simulator.
    fingerprint: String,
    live: Option<Live>,
    /// What is asked of individuals, which never changes.
    kinds: Mutex<HashMap<ExperimentId, Kind>>,
}

/// What an experiment asks of its individuals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Kind {
    /// The behaviour of each trial.
    pub(super) behaviours: Vec<&'static str>,
}

impl Kind {
    pub(super) fn trials(&self) -> usize {
        self.behaviours.len()
    }
}

impl Sources {
    /// A history, the name of its file, the fingerprint of this program's simulator ([`selftalk_sim::fingerprint()`]), and
    /// the master at work on it, if it is in this process.
    #[must_use]
    pub fn new(store: SqliteStore, file: String, fingerprint: String, live: Option<Live>) -> Self {
        Self { store, file, fingerprint, live, kinds: Mutex::default() }
    }

    pub(super) const fn store(&self) -> &SqliteStore {
        &self.store
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    pub(super) fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    pub(super) fn live(&self) -> Option<&Live> {
        self.live.as_ref()
    }

    /// Why individuals of an experiment cannot be run again, if so.
    pub(super) fn foreign(&self, stored: &StoredExperiment) -> Option<String> {
        (stored.fingerprint != self.fingerprint).then(|| {
            format!(
                "run with a simulator that gives other results (fingerprint {}, this release has {})",
                stored.fingerprint, self.fingerprint
            )
        })
    }

    /// What an experiment asks for; none when this release cannot run it.
    pub(super) fn kind(&self, stored: &StoredExperiment) -> Option<Kind> {
        let mut kinds = self.kinds.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kind) = kinds.get(&stored.id) {
            return Some(kind.clone());
        }
        let simulator = Simulator::new(&stored.experiment).ok()?;
        let behaviour = |trial| Behaviour::name(simulator.behaviour(trial));
        let kind = Kind { behaviours: (0..simulator.trial_count()).map(behaviour).collect() };
        kinds.insert(stored.id, kind.clone());
        Some(kind)
    }
}

/// What the dashboard shows at present: nothing at first, and again when a command is done with its database. Cheap to
/// clone; all clones are the same stage.
#[derive(Debug, Clone)]
pub struct Stage {
    sources: Arc<watch::Sender<Option<Arc<Sources>>>>,
}

impl Stage {
    /// An empty stage.
    #[must_use]
    pub fn new() -> Self {
        Self { sources: Arc::new(watch::Sender::new(None)) }
    }

    /// Shows something from now on.
    pub fn show(&self, sources: Sources) {
        self.sources.send_replace(Some(Arc::new(sources)));
    }

    /// Shows nothing any more, and closes the file: whoever closes it last tidies up behind it, which only a writer can.
    ///
    /// # Errors
    /// [`StoreError`] when closing fails.
    pub async fn clear(&self) -> Result<(), StoreError> {
        let Some(mut sources) = self.sources.send_replace(None) else { return Ok(()) };
        let step = Duration::from_millis(10);
        let mut waited = Duration::ZERO;
        loop {
            match Arc::try_unwrap(sources) {
                Ok(sources) => return sources.store.close().await,
                Err(shared) if waited < PATIENCE => sources = shared,
                Err(_) => {
                    tracing::warn!("the dashboard still reads the database");
                    return Ok(());
                }
            }
            sleep(step).await;
            waited += step;
        }
    }

    pub(super) fn now(&self) -> Option<Arc<Sources>> {
        self.sources.borrow().clone()
    }
}

impl Default for Stage {
    fn default() -> Self {
        Self::new()
    }
}
