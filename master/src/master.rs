//! A master at work: the run loop and the service that feeds it.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::Arc;

use thiserror::Error;
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use crate::driver::{Board, Driver, DriverError, RunEnd};
use crate::scheduler::Limits;
use crate::service::{Crew, Floor, Handle, Hub, ServiceError, Settings, serve};
use crate::store::{Store, StoredExperiment};

/// Why a master cannot go on.
#[derive(Debug, Error)]
pub enum MasterError {
    /// The run loop failed.
    #[error(transparent)]
    Driver(#[from] DriverError),
    /// The network service failed.
    #[error(transparent)]
    Service(#[from] ServiceError),
    /// The network service ended before the work did.
    #[error("the network service has ended")]
    ServiceEnded,
}

/// A number that nobody else knows: the standard library's hasher is seeded at random. No result depends on it.
fn secret() -> u64 {
    RandomState::new().build_hasher().finish()
}

/// A master that is ready to receive workers.
#[derive(Debug)]
pub struct Master<S> {
    store: Arc<S>,
    driver: Driver<S>,
    handle: Handle,
    listener: TcpListener,
    settings: Settings,
}

impl<S: Store> Master<S> {
    /// Prepares to run the unfinished replications of these experiments with the workers that come to `listener`.
    ///
    /// # Errors
    /// [`MasterError::Driver`] when the history cannot be read.
    pub async fn prepare(
        store: Arc<S>,
        experiments: &[StoredExperiment],
        listener: TcpListener,
        settings: Settings,
    ) -> Result<Self, MasterError> {
        let limits = Limits { audit_share: settings.audit, audit_secret: secret(), ..Limits::default() };
        let (handle, revocations) = Hub::start(limits);
        let hub = (handle.clone(), revocations);
        let driver = Driver::prepare(Arc::clone(&store), hub, experiments).await?;
        Ok(Self { store, driver, handle, listener, settings })
    }

    /// Where the replications stand, now and from now on.
    #[must_use]
    pub fn board(&self) -> watch::Receiver<Board> {
        self.driver.board()
    }

    /// The workers that are connected, now and from now on.
    #[must_use]
    pub fn crew(&self) -> watch::Receiver<Crew> {
        self.handle.crew()
    }

    /// What each worker is at, now and from now on.
    #[must_use]
    pub fn floor(&self) -> watch::Receiver<Floor> {
        self.handle.floor()
    }

    /// Runs until all replications are finished or `shutdown` is cancelled, and takes leave of the workers.
    ///
    /// # Errors
    /// [`MasterError`] when the history or the network fails.
    pub async fn run(self, shutdown: CancellationToken) -> Result<RunEnd, MasterError> {
        let Self { store, driver, handle, listener, settings } = self;
        let close = CancellationToken::new();
        let serving = serve(listener, handle.clone(), store, settings, close.clone());
        let mut serving = std::pin::pin!(serving);
        let end = tokio::select! {
            end = driver.run(shutdown) => end,
            served = &mut serving => {
                served?;
                return Err(MasterError::ServiceEnded);
            }
        };
        handle.farewell(matches!(end, Ok(RunEnd::Finished))).await;
        close.cancel();
        let served = serving.await;
        let end = end?;
        served?;
        Ok(end)
    }
}
