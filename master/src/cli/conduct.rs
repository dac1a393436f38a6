//! Running a master from the command line, with or without workers in this process.

use std::sync::Arc;

use selftalk_proto::Token;
use selftalk_worker::signal::Signal;
use selftalk_worker::{Config, End, WorkerError};
use tokio::net::TcpListener;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use tonic::transport::ServerTlsConfig;

use super::Global;
use super::choose::{command, resume_command};
use super::dashboard::Dashboard;
use super::overall::Overall;
use super::progress::Progress;
use super::space::Space;
use crate::dashboard::Live;
use crate::driver::{DriverError, RunEnd};
use crate::exit::{Exit, Failure};
use crate::master::{Master, MasterError};
use crate::service::{Settings, connections};
use crate::store::{SqliteStore, Store, StoredExperiment};

/// Where the workers come from.
pub(super) enum Workers {
    /// So many threads of this process.
    Here(u32),
    /// Whoever connects.
    Remote(Remote),
}

/// How workers come in over the network.
pub(super) struct Remote {
    pub(super) listener: TcpListener,
    /// What they must know, if anything.
    pub(super) token: Option<Token>,
    /// What operators must know; without it there are none.
    pub(super) operators: Option<Token>,
    /// How lines are encrypted, if they are.
    pub(super) tls: Option<ServerTlsConfig>,
    /// Share of their answers that the master evaluates again.
    pub(super) audit: f64,
}

/// Begins to watch for Ctrl-C and SIGTERM.
///
/// # Errors
/// [`Exit::Unexpected`] when the system does not allow it.
pub(super) fn watch_signals() -> Result<Signal, Failure> {
    let fail = |error| Failure::new(Exit::Unexpected, format!("cannot watch for signals: {error}"));
    selftalk_worker::signal::watch().map_err(fail)
}

/// Runs experiments to their ends and returns how they stand then, and shows them meanwhile. As part of a study it is shown
/// how far that is.
///
/// # Errors
/// [`Failure`] with the exit code of an interruption, or of what went wrong.
pub(super) async fn conduct(
    store: SqliteStore,
    experiments: Vec<StoredExperiment>,
    workers: Workers,
    signal: &Signal,
    dashboard: Option<&Dashboard>,
    overall: Option<Overall>,
    global: &Global,
) -> Result<Vec<StoredExperiment>, Failure> {
    let store = Arc::new(store);
    let remote = matches!(workers, Workers::Remote(..));
    let result = run(Arc::clone(&store), &experiments, workers, signal, dashboard, overall, global).await;
    if let Some(dashboard) = dashboard {
        dashboard.clear().await;
    }
    let mut ended = Vec::new();
    for stored in &experiments {
        ended.extend(store.experiment(&stored.experiment.name).await?);
    }
    if let Some(store) = Arc::into_inner(store) {
        store.close().await?;
    }
    match result? {
        RunEnd::Finished => Ok(ended),
        RunEnd::Interrupted => Err(interrupted(&ended, remote, signal, global)),
    }
}

async fn run(
    store: Arc<SqliteStore>,
    experiments: &[StoredExperiment],
    workers: Workers,
    signal: &Signal,
    dashboard: Option<&Dashboard>,
    overall: Option<Overall>,
    global: &Global,
) -> Result<RunEnd, Failure> {
    let (remote, here) = match workers {
        Workers::Remote(remote) => (remote, 0),
        // These are the master's own threads: what they answer is what the master computes.
        Workers::Here(count) => {
            let listener = listen("127.0.0.1:0").await?;
            (Remote { listener, token: None, operators: None, tls: None, audit: 0.0 }, count)
        }
    };
    let Remote { listener, token, operators, tls, audit } = remote;
    let address = listener.local_addr().map_err(|error| Failure::new(Exit::Network, error))?;
    let fingerprint = selftalk_sim::fingerprint()?;
    let settings = Settings { token, operators, tls, audit, ..Settings::new(fingerprint.as_str()) };
    let master = Master::prepare(store, experiments, settings).await.map_err(failure)?;
    if let Some(dashboard) = dashboard {
        let live = Live { board: master.board(), floor: master.floor() };
        dashboard.show(&global.db, &fingerprint, Some(live)).await;
    }
    let _space = Space::watch(&global.db, master.board());
    let progress = Progress::show(master.board(), master.crew(), overall);
    let shutdown = signal.token().child_token();
    let mut crew = Crew::hire(here, &format!("http://{address}"), &fingerprint, &shutdown);
    let mut run = std::pin::pin!(master.run(connections(listener), shutdown.clone()));
    let mut strike = None;
    let end = loop {
        tokio::select! {
            end = &mut run => break end,
            error = crew.failure() => {
                strike = Some(error);
                shutdown.cancel();
            }
        }
    };
    shutdown.cancel();
    crew.dismiss().await;
    progress.finish().await;
    match strike {
        Some(failure) => Err(failure),
        None => end.map_err(failure),
    }
}

/// Opens a port.
///
/// # Errors
/// [`Exit::Network`] when it is taken or does not belong to this machine.
pub(super) async fn listen(
    address: impl tokio::net::ToSocketAddrs + std::fmt::Display,
) -> Result<TcpListener, Failure> {
    let name = address.to_string();
    let fail = |error| {
        Failure::new(
            Exit::Network,
            format!("{name}: cannot listen: {error}; name another address with --listen"),
        )
    };
    TcpListener::bind(address).await.map_err(fail)
}

/// The workers of this process: one slot each, connected like any others.
struct Crew {
    tasks: JoinSet<Result<End, WorkerError>>,
}

impl Crew {
    fn hire(count: u32, master: &str, fingerprint: &str, shutdown: &CancellationToken) -> Self {
        let mut tasks = JoinSet::new();
        for _ in 0..count {
            let mut config = Config::new(master, fingerprint);
            config.slots = 1;
            tasks.spawn(selftalk_worker::run(config, shutdown.clone()));
        }
        Self { tasks }
    }

    /// The next worker's failure. Waits forever if none fails.
    async fn failure(&mut self) -> Failure {
        while let Some(ended) = self.tasks.join_next().await {
            match ended {
                Ok(Ok(End::Finished | End::Stopped)) => {}
                Ok(Err(error)) => {
                    let exit = if error.is_network() { Exit::Network } else { Exit::Unexpected };
                    return Failure::new(exit, format!("a worker has failed: {error}"));
                }
                Err(error) => return Failure::new(Exit::Unexpected, format!("a worker has failed: {error}")),
            }
        }
        std::future::pending().await
    }

    async fn dismiss(mut self) {
        while self.tasks.join_next().await.is_some() {}
    }
}

fn failure(error: MasterError) -> Failure {
    match error {
        MasterError::Driver(DriverError::Store(error)) => error.into(),
        MasterError::Driver(error) => Failure::new(Exit::Unexpected, error),
        MasterError::Service(_) | MasterError::ServiceEnded => Failure::new(Exit::Network, error),
    }
}

fn interrupted(experiments: &[StoredExperiment], remote: bool, signal: &Signal, global: &Global) -> Failure {
    // Without a signal it was an operator, whose word counts like SIGTERM.
    let by_hand = signal.exit_code() == Some(Exit::Interrupted as u8);
    let exit = if by_hand { Exit::Interrupted } else { Exit::Terminated };
    let name = match experiments {
        [one] => one.experiment.name.as_str(),
        _ => "",
    };
    let resume = resume_command(global, name);
    let resume = resume.trim_end();
    let serve = if remote {
        format!("`{}` or, on this machine alone, ", command(global, "serve"))
    } else {
        String::new()
    };
    let message = format!("interrupted; all complete generations are kept, {serve}`{resume}` goes on");
    Failure::new(exit, message)
}
