//! A master at work: the run loop and the service that feeds it.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::sync::Arc;

use selftalk_proto::v1;
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::watch;
use tokio_stream::Stream;
use tokio_util::sync::CancellationToken;
use tonic::transport::server::Connected;

use crate::driver::{Board, Driver, DriverError, RunEnd, Standing, settle_doubts};
use crate::scheduler::Limits;
use crate::service::{Crew, Floor, Handle, Hub, Roll, Served, ServiceError, Settings, serve};
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

/// The board, as operators are told of it.
#[derive(Debug)]
struct OnBoard(watch::Receiver<Board>);

impl Roll for OnBoard {
    fn standings(&self) -> Vec<v1::Standing> {
        let told = |standing: &Standing| v1::Standing {
            experiment: standing.experiment.clone(),
            replication: standing.replication,
            generations: standing.generations,
            of: standing.of,
            finished: standing.finished,
            best_fitness: standing.last.map(|last| last.best),
            best_successes: standing.last.map(|last| last.successes),
            trials: standing.trials,
        };
        self.0.borrow().standings.iter().map(told).collect()
    }
}

/// A master that is ready to receive workers.
#[derive(Debug)]
pub struct Master<S> {
    store: Arc<S>,
    driver: Driver<S>,
    handle: Handle,
    settings: Settings,
}

impl<S: Store> Master<S> {
    /// Prepares to run the unfinished replications of these experiments. If answers are to be looked into, so are those that
    /// the master before did not come to any more.
    ///
    /// # Errors
    /// [`MasterError::Driver`] when the history cannot be read.
    pub async fn prepare(
        store: Arc<S>,
        experiments: &[StoredExperiment],
        settings: Settings,
    ) -> Result<Self, MasterError> {
        let limits = Limits { audit_share: settings.audit, audit_secret: secret(), ..Limits::default() };
        let (handle, findings) = Hub::start(limits);
        let hub = (handle.clone(), findings);
        let experiments = match settings.audit > 0.0 {
            true => &*settle_doubts(&*store, experiments).await?,
            false => experiments,
        };
        let driver = Driver::prepare(Arc::clone(&store), hub, experiments).await?;
        Ok(Self { store, driver, handle, settings })
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

    /// Runs until all replications are finished or `shutdown` is cancelled, by the caller or by an operator, with the
    /// workers that come `incoming` (see [`connections`](crate::service::connections)), and takes leave of them.
    ///
    /// # Errors
    /// [`MasterError`] when the history or the network fails.
    pub async fn run<C>(
        self,
        incoming: impl Stream<Item = io::Result<C>>,
        shutdown: CancellationToken,
    ) -> Result<RunEnd, MasterError>
    where
        C: AsyncRead + AsyncWrite + Connected + Unpin + Send + 'static,
    {
        let Self { store, driver, handle, settings } = self;
        let close = CancellationToken::new();
        let roll = Arc::new(OnBoard(driver.board()));
        let served = Served { handle: handle.clone(), store, roll, run: shutdown.clone() };
        let serving = serve(incoming, served, settings, close.clone());
        let mut serving = std::pin::pin!(serving);
        let end = tokio::select! {
            biased;
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
