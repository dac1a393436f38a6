//! Runs batches of trials for a master.
//!
//! A worker keeps no state that matters: it connects, takes leases, simulates and reports. Its slots are threads that
//! share one queue of trials, so that the lanes of the simulator are refilled across units and batches. When the line
//! to the master is cut it goes on with what it has, reconnects, and hands the results in.

mod backoff;
mod config;
mod dial;
mod error;
mod queue;
mod session;
pub mod signal;
mod slots;
mod usage;

use std::sync::Arc;
use std::time::Duration;

use backoff::Backoff;
use selftalk_proto::UnitResult;
use session::{Ended, Session};
use slots::Slots;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;

pub use config::{Config, available_cores};
pub use dial::{Dial, over_tcp};
pub use error::WorkerError;

/// Even the last attempt to reach a master at first has this long.
const ATTEMPT: Duration = Duration::from_secs(1);

/// Why a worker ended without an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The master has no more work.
    Finished,
    /// It was told to stop, and said goodbye.
    Stopped,
}

/// Works for a master until that has finished or `shutdown` is cancelled.
///
/// A master that cannot be reached at first is tried for [`Config::connect_timeout`]; once it has been reached it is
/// awaited for as long as it takes.
///
/// # Errors
/// [`WorkerError`] when the master cannot be reached, refuses the worker, or sends what makes no sense.
///
/// ```
/// use std::time::Duration;
///
/// use selftalk_worker::{Config, WorkerError, run};
/// use tokio_util::sync::CancellationToken;
///
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> Result<(), Box<dyn std::error::Error>> {
/// // Nobody listens at port 1.
/// let mut config = Config::new("http://127.0.0.1:1", selftalk_sim::fingerprint()?);
/// config.connect_timeout = Duration::from_millis(100);
/// let ended = run(config, CancellationToken::new()).await;
/// assert!(matches!(ended, Err(WorkerError::Unreachable { .. })));
/// # Ok(())
/// # }
/// ```
pub async fn run(config: Config, shutdown: CancellationToken) -> Result<End, WorkerError> {
    let (results, outbox) = mpsc::unbounded_channel::<UnitResult>();
    let slots = Slots::start(config.slots, results).map_err(WorkerError::Threads)?;
    let mut session = Session::new(&config, over_tcp(), Arc::clone(slots.queue()), outbox, shutdown.clone())?;
    let ended = keep_connected(&config, &mut session, &shutdown).await;
    slots.stop().await;
    ended
}

/// The same without threads and over lines that `dial` opens: the trials run in the caller's task, those of a unit every
/// `pace`. For simulated networks, in which nothing may happen outside, and for crowds of workers in one process.
///
/// # Errors
/// As [`run`].
pub async fn run_in_task(
    config: Config,
    dial: Dial,
    pace: Duration,
    shutdown: CancellationToken,
) -> Result<End, WorkerError> {
    let (results, outbox) = mpsc::unbounded_channel::<UnitResult>();
    let queue = Arc::default();
    let mut session = Session::new(&config, dial, Arc::clone(&queue), outbox, shutdown.clone())?;
    tokio::select! {
        biased;
        ended = keep_connected(&config, &mut session, &shutdown) => ended,
        never = slots::work_in_task(&queue, &results, pace) => match never {},
    }
}

async fn keep_connected(
    config: &Config,
    session: &mut Session,
    shutdown: &CancellationToken,
) -> Result<End, WorkerError> {
    let begin = Instant::now();
    let mut backoff = Backoff::new(config.instance());
    let (mut reached, mut first) = (false, true);
    loop {
        let left = config.connect_timeout.saturating_sub(begin.elapsed());
        let limit = if reached { Duration::MAX } else { left.max(ATTEMPT) };
        let (reason, welcomed) = match session.run(limit).await? {
            Ended::Finished => return Ok(End::Finished),
            Ended::Stopped => return Ok(End::Stopped),
            Ended::Cut { reason, welcomed } => (reason, welcomed),
        };
        if welcomed {
            reached = true;
            backoff.reset();
        }
        if !reached && begin.elapsed() >= config.connect_timeout {
            let master = config.master.clone();
            return Err(WorkerError::Unreachable { master, seconds: begin.elapsed().as_secs(), reason });
        }
        let mut pause = backoff.next_pause();
        if !reached {
            pause = pause.min(config.connect_timeout.saturating_sub(begin.elapsed()));
        }
        // Said once; a master may be away for hours.
        if welcomed || first {
            tracing::info!(master = config.master, reason, "not connected, trying again and again");
        } else {
            tracing::debug!(reason, ?pause, "not connected");
        }
        first = false;
        tokio::select! {
            biased;
            () = shutdown.cancelled() => return Ok(End::Stopped),
            () = sleep(pause) => {}
        }
    }
}
