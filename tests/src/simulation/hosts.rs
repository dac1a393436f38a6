//! The master and the workers as hosts of a simulated network.

use std::cell::Cell;
use std::io;
use std::net::Ipv4Addr;
use std::pin::Pin;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use hyper_util::rt::TokioIo;
use selftalk::driver::RunEnd;
use selftalk::master::Master;
use selftalk::service::Settings;
use selftalk::store::Store;
use selftalk_sim::Experiment;
use selftalk_worker::{Config, Dial};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::transport::{Channel, Endpoint, Uri};
use turmoil::Sim;
use turmoil::net::{TcpListener, TcpStream};

use super::lines::{Line, Lines};
use super::shelf::Shelf;

/// The master's name in the network.
pub(super) const MASTER: &str = "master";
const PORT: u16 = 7700;
/// What master and workers give out as the simulator's; it is the same process.
const FINGERPRINT: &str = "simulated";

/// A worker's name in the network.
pub(super) fn worker(number: u32) -> String {
    format!("worker-{number}")
}

/// Adds the master, which runs the experiment from wherever it stands on the shelf.
pub(super) fn add_master(network: &mut Sim<'_>, lines: &Lines, shelf: &Shelf, experiment: &Experiment) {
    let (lines, shelf, experiment) = (lines.clone(), shelf.clone(), experiment.clone());
    network.host(MASTER, move || {
        let (lines, shelf, experiment) = (lines.clone(), shelf.clone(), experiment.clone());
        async move {
            let stored = match shelf.experiment(&experiment.name).await? {
                Some(stored) => stored,
                None => shelf.create_experiment(&experiment, FINGERPRINT).await?,
            };
            let settings = Settings::new(FINGERPRINT);
            let master = Master::prepare(Arc::new(shelf.clone()), &[stored], settings).await?;
            let listener = TcpListener::bind((Ipv4Addr::UNSPECIFIED, PORT)).await?;
            let end = master.run(connections(listener, lines), CancellationToken::new()).await?;
            assert_eq!(end, RunEnd::Finished);
            shelf.finish();
            Ok(())
        }
    });
}

/// Adds a worker that takes `pace` for a unit. After a restart it is another process, and says so.
pub(super) fn add_worker(network: &mut Sim<'_>, number: u32, pace: Duration) {
    let lives = Rc::new(Cell::new(0_u64));
    network.host(worker(number).as_str(), move || {
        lives.set(lives.get() + 1);
        let instance = u64::from(number + 1) << 32 | lives.get();
        async move {
            let mut config =
                Config::new(format!("http://{MASTER}:{PORT}"), FINGERPRINT).with_instance(instance);
            config.slots = 1;
            config.connect_timeout = Duration::from_secs(3600);
            selftalk_worker::run_in_task(config, dial(), pace, CancellationToken::new()).await?;
            Ok(())
        }
    });
}

/// Opens lines in the simulated network.
fn dial() -> Dial {
    let open = |uri: Uri| async move {
        let host = uri.host().unwrap_or_default().to_owned();
        Ok::<_, io::Error>(TokioIo::new(TcpStream::connect((host, PORT)).await?))
    };
    let dial = move |endpoint: Endpoint| async move {
        endpoint.connect_with_connector(tower::service_fn(open)).await
    };
    Arc::new(move |endpoint| -> Pin<Box<dyn Future<Output = Result<Channel, _>> + Send>> {
        Box::pin(dial(endpoint))
    })
}

fn connections(listener: TcpListener, lines: Lines) -> ReceiverStream<io::Result<Line>> {
    let (sender, receiver) = mpsc::channel(16);
    tokio::task::spawn_local(async move {
        loop {
            let accepted = listener.accept().await.map(|(stream, _)| lines.open(stream));
            if sender.send(accepted).await.is_err() {
                return;
            }
        }
    });
    ReceiverStream::new(receiver)
}
