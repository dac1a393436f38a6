//! A run whose storage fails at its first call, its second, and so on: resumed, it comes to the undisturbed history.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use selftalk::driver::{DriverError, RunEnd};
use selftalk::master::{Master, MasterError};
use selftalk::service::{Settings, connections};
use selftalk::store::{
    GenerationCommit, HistoryDigest, ReplicationId, Resumed, SqliteStore, Store, StoreError,
    StoredExperiment, Unproven, WorkerId, WorkerInfo,
};
use selftalk_sim::Experiment;
use selftalk_worker::Config;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

const EXPERIMENT: &str = "\
name = 'stored'
engine = 'null'
replications = 2
generations = 3
evolution = { population = 10, parents = 2, mutation = 0.001 }
";

/// What has become of a call that reports a failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Failure {
    /// Nothing was written.
    Before,
    /// All was written, and it is not known.
    After,
}

/// A history in a file, one of whose calls fails.
#[derive(Debug)]
struct Faulty {
    store: SqliteStore,
    calls: AtomicU64,
    /// Which one, counted from 1, and how.
    fault: Option<(u64, Failure)>,
}

impl Faulty {
    async fn call<T>(&self, call: impl Future<Output = Result<T, StoreError>>) -> Result<T, StoreError> {
        let number = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
        let failure = self.fault.filter(|(at, _)| *at == number).map(|(_, failure)| failure);
        let injected = || StoreError::Database { path: "stored.db".into(), reason: "injected".to_owned() };
        if failure == Some(Failure::Before) {
            return Err(injected());
        }
        let result = call.await;
        if failure == Some(Failure::After) { Err(injected()) } else { result }
    }

    fn has_failed(&self) -> bool {
        self.fault.is_some_and(|(at, _)| self.calls.load(Ordering::Relaxed) >= at)
    }
}

impl Store for Faulty {
    async fn create_experiment(
        &self,
        experiment: &Experiment,
        fingerprint: &str,
    ) -> Result<StoredExperiment, StoreError> {
        self.call(self.store.create_experiment(experiment, fingerprint)).await
    }

    async fn experiment(&self, name: &str) -> Result<Option<StoredExperiment>, StoreError> {
        self.call(self.store.experiment(name)).await
    }

    async fn experiments(&self) -> Result<Vec<StoredExperiment>, StoreError> {
        self.call(self.store.experiments()).await
    }

    async fn last_generation(&self, replication: ReplicationId) -> Result<Option<Resumed>, StoreError> {
        self.call(self.store.last_generation(replication)).await
    }

    async fn commit_generation(&self, commit: GenerationCommit<'_>) -> Result<(), StoreError> {
        self.call(self.store.commit_generation(commit)).await
    }

    async fn take_back(&self, replication: ReplicationId, from: u32) -> Result<(), StoreError> {
        self.call(self.store.take_back(replication, from)).await
    }

    async fn worker_joined(&self, worker: &WorkerInfo) -> Result<WorkerId, StoreError> {
        self.call(self.store.worker_joined(worker)).await
    }

    async fn worker_left(&self, worker: WorkerId) -> Result<(), StoreError> {
        self.call(self.store.worker_left(worker)).await
    }

    async fn workers_audited(&self, workers: &[WorkerId]) -> Result<(), StoreError> {
        self.call(self.store.workers_audited(workers)).await
    }

    async fn unproven(&self) -> Result<Vec<Unproven>, StoreError> {
        self.call(self.store.unproven()).await
    }
}

/// Runs the experiment from wherever it stands, with a worker.
async fn run(store: &Arc<Faulty>) -> Result<RunEnd, MasterError> {
    let stored = |error| MasterError::Driver(DriverError::Store(error));
    let experiment = Experiment::from_toml("stored.toml", EXPERIMENT, &[]).unwrap();
    let begun = match store.experiment(&experiment.name).await.map_err(stored)? {
        Some(begun) => begun,
        None => store.create_experiment(&experiment, "f").await.map_err(stored)?,
    };
    let settings = Settings { audit: 0.1, ..Settings::new("f") };
    let master = Master::prepare(Arc::clone(store), &[begun], settings).await?;
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let mut config = Config::new(format!("http://{}", listener.local_addr().unwrap()), "f");
    config.slots = 1;
    let dismissed = CancellationToken::new();
    let worker = tokio::spawn(selftalk_worker::run(config, dismissed.clone()));
    let end = master.run(connections(listener), CancellationToken::new()).await;
    dismissed.cancel();
    worker.await.unwrap().unwrap();
    end
}

/// The same, in a file; whether a call has failed, and how the run ended.
async fn attempt(file: &Path, fault: Option<(u64, Failure)>) -> (bool, Result<RunEnd, MasterError>) {
    let store = SqliteStore::open_writer(file).await.unwrap();
    let store = Arc::new(Faulty { store, calls: AtomicU64::new(0), fault });
    let end = run(&store).await;
    // The connections' last words may still be on their way.
    let mut store = store;
    let faulty = loop {
        match Arc::try_unwrap(store) {
            Ok(faulty) => break faulty,
            Err(shared) => store = shared,
        }
        tokio::task::yield_now().await;
    };
    let failed = faulty.has_failed();
    faulty.store.close().await.unwrap();
    (failed, end)
}

async fn digests(file: &Path) -> Vec<String> {
    let store = SqliteStore::open_reader(file).await.unwrap();
    let stored = store.experiment("stored").await.unwrap().unwrap();
    let mut digests = Vec::new();
    for replication in &stored.replications {
        let (mut digest, mut generations) = (HistoryDigest::new(), store.generations(replication));
        for generation in 0..replication.generations {
            digest.update(&generations.read(generation).await.unwrap());
        }
        digests.push(digest.finish());
    }
    digests
}

#[tokio::test]
async fn storage_that_fails_at_any_call_loses_nothing_and_writes_nothing_twice() {
    let folder = tempfile::tempdir().unwrap();
    let undisturbed = folder.path().join("undisturbed.db");
    assert!(matches!(attempt(&undisturbed, None).await, (false, Ok(RunEnd::Finished))));
    let expected = digests(&undisturbed).await;
    assert_eq!(expected.len(), 2);

    for failure in [Failure::Before, Failure::After] {
        let mut ended = 0;
        for call in 1_u64.. {
            let file = folder.path().join(format!("{failure:?}-{call}.db"));
            let (failed, end) = attempt(&file, Some((call, failure))).await;
            match end {
                Ok(end) => assert_eq!(end, RunEnd::Finished),
                Err(error) => {
                    assert!(error.to_string().contains("injected"), "{failure:?} {call}: {error}");
                    ended += 1;
                    let (_, again) = attempt(&file, None).await;
                    assert_eq!(again.unwrap(), RunEnd::Finished, "{failure:?} {call}");
                }
            }
            assert_eq!(digests(&file).await, expected, "{failure:?} {call}");
            if !failed {
                break;
            }
        }
        assert!(ended >= 10, "{failure:?}: only {ended} calls that end a run");
    }
}
