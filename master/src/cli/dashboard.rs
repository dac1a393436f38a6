//! The dashboard: that of a run, and `selftalk dashboard`, which shows any database.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use selftalk_sim::fingerprint;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::args::{DashboardArgs, DashboardAt, Shown};
use super::conduct::{listen, watch_signals};
use super::{Global, select};
use crate::dashboard::{Live, Sources, Stage, serve};
use crate::exit::{Exit, Failure};
use crate::store::SqliteStore;

/// Where it is if nothing else is said.
const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 7780);

/// A dashboard that can be looked at. It ends when this is dropped.
pub(super) struct Dashboard {
    stage: Stage,
    address: SocketAddr,
    /// Whether another address would have been usual, and is taken.
    elsewhere: bool,
    announced: AtomicBool,
    shutdown: CancellationToken,
    task: JoinHandle<std::io::Result<()>>,
}

/// Carries out `selftalk dashboard`.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: DashboardArgs, global: &Global) -> Result<(), Failure> {
    consent("--listen", args.listen, args.insecure)?;
    let signal = watch_signals()?;
    let store = select::open(global).await?;
    let fingerprint = fingerprint()?;
    let mut dashboard = Dashboard::open(args.listen).await?;
    dashboard.stage.show(Sources::new(store, file_name(&global.db), fingerprint, None));
    dashboard.announce();
    let ended = tokio::select! {
        () = signal.token().cancelled_owned() => Ok(()),
        served = &mut dashboard.task => Err(ended(served)),
    };
    dashboard.clear().await;
    ended
}

/// The dashboard of a run, if there is to be one. Its port is taken at once and nothing is said yet.
///
/// # Errors
/// [`Exit::Usage`] when other machines could read along without consent, [`Exit::Network`] when the port is taken.
pub(super) async fn of_run(args: &Shown) -> Result<Option<Dashboard>, Failure> {
    let address = match args.dashboard {
        Some(DashboardAt::Off) => return Ok(None),
        Some(DashboardAt::At(address)) => Some(address),
        None => None,
    };
    consent("--dashboard", address, args.insecure)?;
    Dashboard::open(address).await.map(Some)
}

/// Where other machines can come in, it takes a word to say that the network is trusted.
fn consent(option: &str, address: Option<SocketAddr>, insecure: bool) -> Result<(), Failure> {
    match address {
        Some(address) if !address.ip().is_loopback() && !insecure => {
            let message = format!(
                "{option} {address}: other machines could read along, as nothing is encrypted; add --insecure if the \
                 network is trusted"
            );
            Err(Failure::new(Exit::Usage, message))
        }
        _ => Ok(()),
    }
}

impl Dashboard {
    /// Listens where it is said, or where it is usual or, if that is taken, on a free port.
    async fn open(address: Option<SocketAddr>) -> Result<Self, Failure> {
        let (listener, elsewhere) = match address {
            Some(address) => (listen(address).await?, false),
            None => match TcpListener::bind(USUAL).await {
                Ok(listener) => (listener, false),
                Err(_) => (listen(SocketAddr::new(USUAL.ip(), 0)).await?, true),
            },
        };
        let address = listener.local_addr().map_err(|error| Failure::new(Exit::Network, error))?;
        let (stage, shutdown) = (Stage::new(), CancellationToken::new());
        let task = tokio::spawn(serve(listener, stage.clone(), shutdown.clone()));
        Ok(Self { stage, address, elsewhere, announced: AtomicBool::new(false), shutdown, task })
    }

    /// Says where it is, once.
    fn announce(&self) {
        if self.announced.swap(true, Ordering::Relaxed) {
            return;
        }
        let taken = if self.elsewhere { format!(" (port {} is taken)", USUAL.port()) } else { String::new() };
        eprintln!("dashboard: http://{}/{taken}", self.address);
    }

    /// Shows a database, and the master that is at work on it, and says where. A run goes on without if the file cannot be read.
    pub(super) async fn show(&self, db: &Path, fingerprint: &str, live: Option<Live>) {
        match SqliteStore::open_reader(db).await {
            Ok(store) => {
                self.stage.show(Sources::new(store, file_name(db), fingerprint.to_owned(), live));
                self.announce();
            }
            Err(error) => tracing::warn!(%error, "the dashboard has nothing to show"),
        }
    }

    /// Shows nothing any more, so that the database can be closed.
    pub(super) async fn clear(&self) {
        if let Err(error) = self.stage.clear().await {
            tracing::warn!(%error, "the dashboard could not close the database");
        }
    }
}

impl Drop for Dashboard {
    fn drop(&mut self) {
        self.shutdown.cancel();
    }
}

fn ended(served: Result<std::io::Result<()>, tokio::task::JoinError>) -> Failure {
    let words = match served {
        Ok(Ok(())) => "it has ended".to_owned(),
        Ok(Err(error)) => error.to_string(),
        Err(error) => error.to_string(),
    };
    Failure::new(Exit::Network, format!("the dashboard has failed: {words}"))
}

/// Pages say which file they show, not where on the machine it is.
fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
