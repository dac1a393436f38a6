//! The master's side of a worker's connection.

use std::sync::Arc;
use std::time::Duration;

use selftalk_proto::v1::evaluation_server::Evaluation;
use selftalk_proto::v1::{MasterMessage, WorkerMessage};
use selftalk_proto::{Answer, FromMaster, FromWorker, Hello, PROTOCOL, RefusalReason, UnitResult, WireError};
use tokio::sync::mpsc;
use tokio::time::timeout;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use tonic::{Request, Response, Status, Streaming};
use tracing::Instrument;

use super::Settings;
use super::gate::{Admission, admission};
use super::handle::{Command, Handle, Line};
use crate::scheduler::{Event, PeerId};
use crate::store::{Store, StoreError, WorkerId, WorkerInfo};

/// How long a worker may take to say hello.
const PATIENCE: Duration = Duration::from_secs(10);

/// Where workers come in.
#[derive(Debug)]
pub(super) struct Door<S> {
    reception: Arc<Reception<S>>,
    connections: TaskTracker,
}

#[derive(Debug)]
struct Reception<S> {
    handle: Handle,
    store: Arc<S>,
    settings: Settings,
}

/// Why a worker's connection ends before it is accepted.
enum Turned {
    /// With a reason that the worker understands.
    Away(RefusalReason, String),
    /// There is nobody to answer.
    Gone,
}

/// How an accepted worker's connection ended.
enum Parting {
    /// It said goodbye.
    Left,
    /// The line was cut.
    Lost,
}

impl<S: Store> Door<S> {
    pub(super) fn new(handle: Handle, store: Arc<S>, settings: Settings) -> Self {
        let reception = Arc::new(Reception { handle, store, settings });
        Self { reception, connections: TaskTracker::new() }
    }

    /// The tasks that attend to the workers.
    pub(super) fn connections(&self) -> TaskTracker {
        self.connections.clone()
    }
}

#[tonic::async_trait]
impl<S: Store> Evaluation for Door<S> {
    type WorkStream = std::pin::Pin<Box<dyn Stream<Item = Result<MasterMessage, Status>> + Send>>;

    async fn work(
        &self,
        request: Request<Streaming<WorkerMessage>>,
    ) -> Result<Response<Self::WorkStream>, Status> {
        let reception = Arc::clone(&self.reception);
        if reception.settings.token.as_ref().is_some_and(|token| !token.admits(request.metadata())) {
            let from = admission(&request).map(|admission| admission.from());
            tracing::warn!(?from, "a worker without the token was refused");
            return Err(Status::unauthenticated(
                "this master asks for a token, and none or another was given",
            ));
        }
        let admission = admission(&request);
        let (outgoing, messages) = mpsc::channel::<FromMaster>(Line::ROOM);
        let attend = async move { reception.attend(request.into_inner(), outgoing, admission).await };
        self.connections.spawn(attend);
        let messages = ReceiverStream::new(messages).map(|message| Ok(message.into()));
        Ok(Response::new(Box::pin(messages)))
    }
}

impl<S: Store> Reception<S> {
    async fn attend(
        &self,
        mut incoming: Streaming<WorkerMessage>,
        outgoing: mpsc::Sender<FromMaster>,
        admission: Option<Admission>,
    ) {
        let hello = match self.greet(&mut incoming).await {
            Ok(hello) => hello,
            Err(Turned::Away(reason, text)) => {
                tracing::warn!(text, "worker refused");
                let _ = outgoing.try_send(FromMaster::Refusal { reason, text });
                return;
            }
            Err(Turned::Gone) => return,
        };
        let (host, pid) = (hello.host.clone(), hello.pid);
        match self.join(hello, outgoing).await {
            Ok((peer, worker, cut)) => {
                admission.iter().for_each(Admission::grant);
                tracing::info!(worker = worker.0, host, pid, "worker joined");
                let span = tracing::info_span!("worker", worker = worker.0, host, pid);
                self.listen(peer, incoming, cut).instrument(span).await;
                tracing::info!(worker = worker.0, host, pid, "worker gone");
                if let Err(error) = self.store.worker_left(worker).await {
                    tracing::warn!(%error, "the worker's leave could not be noted");
                }
            }
            // The line closes and the worker tries again later; the run loop meets the same error and ends.
            Err(error) => tracing::warn!(%error, "the worker could not be noted"),
        }
    }

    async fn greet(&self, incoming: &mut Streaming<WorkerMessage>) -> Result<Hello, Turned> {
        let Ok(Ok(Some(first))) = timeout(PATIENCE, incoming.message()).await else {
            return Err(Turned::Gone);
        };
        let garbled = |error: WireError| Turned::Away(RefusalReason::Hello, error.to_string());
        let FromWorker::Hello(hello) = FromWorker::try_from(first).map_err(garbled)? else {
            return Err(Turned::Away(RefusalReason::Hello, "a worker must say hello first".to_owned()));
        };
        if hello.protocol != PROTOCOL {
            let text = format!(
                "the worker (release {}) speaks version {} of the protocol, this master (release {}) version \
                 {PROTOCOL}",
                hello.version,
                hello.protocol,
                env!("CARGO_PKG_VERSION")
            );
            return Err(Turned::Away(RefusalReason::Protocol, text));
        }
        if hello.fingerprint != self.settings.fingerprint {
            let text = format!(
                "the worker's simulator (release {}, fingerprint {}) gives other results than this master's \
                 (release {}, fingerprint {})",
                hello.version,
                hello.fingerprint,
                env!("CARGO_PKG_VERSION"),
                self.settings.fingerprint
            );
            return Err(Turned::Away(RefusalReason::Fingerprint, text));
        }
        Ok(hello)
    }

    /// Notes the worker and lets it in.
    async fn join(
        &self,
        hello: Hello,
        outgoing: mpsc::Sender<FromMaster>,
    ) -> Result<(PeerId, WorkerId, CancellationToken), StoreError> {
        let Hello { version, host, pid, slots, instance, holds, .. } = hello;
        // Workers of one process differ in their instance alone.
        let name = format!("{host}-{pid}-{:04x}", instance & 0xffff);
        let (called, machine) = (Arc::from(name.as_str()), Arc::from(host.as_str()));
        let info = WorkerInfo { name, host, process: pid, version, slots };
        let worker = self.store.worker_joined(&info).await?;
        let heartbeat_ms = u32::try_from(self.settings.heartbeat.as_millis()).unwrap_or(u32::MAX);
        let _ = outgoing.try_send(FromMaster::Welcome { worker: worker.0, heartbeat_ms });
        let peer = self.handle.next_peer();
        let cut = CancellationToken::new();
        let line = Line { outgoing, worker, name: called, host: machine, cut: cut.clone() };
        self.handle.tell(Command::Joined { peer, instance, slots, holds, line }).await;
        Ok((peer, worker, cut))
    }

    /// Passes on what the worker says until it leaves.
    async fn listen(&self, peer: PeerId, mut incoming: Streaming<WorkerMessage>, cut: CancellationToken) {
        let parting = loop {
            let message = tokio::select! {
                biased;
                () = cut.cancelled() => break Parting::Lost,
                message = incoming.message() => message,
            };
            let message = match message {
                Ok(Some(message)) => message,
                Ok(None) => break Parting::Lost,
                Err(status) => {
                    tracing::debug!(%status, "line cut");
                    break Parting::Lost;
                }
            };
            match FromWorker::try_from(message) {
                Ok(FromWorker::Heartbeat) => self.tell(vec![Event::Heard(peer)]).await,
                Ok(FromWorker::Results(results)) => {
                    let event = |UnitResult { key, answer }| match answer {
                        Answer::Outcomes(outcomes) => Event::Answered(peer, key, outcomes),
                        Answer::Failed(reason) => Event::Failed(peer, key, reason),
                    };
                    self.tell(results.into_iter().map(event).collect()).await;
                }
                Ok(FromWorker::Goodbye) => break Parting::Left,
                Ok(FromWorker::Hello(_)) => {
                    tracing::warn!("a worker said hello twice and is cut off");
                    break Parting::Lost;
                }
                Err(error) => {
                    tracing::warn!(%error, "a worker sent something wrong and is cut off");
                    break Parting::Lost;
                }
            }
        };
        let parting = match parting {
            Parting::Left => Event::Left(peer),
            Parting::Lost => Event::Lost(peer),
        };
        self.tell(vec![parting]).await;
    }

    async fn tell(&self, events: Vec<Event>) {
        self.handle.tell(Command::Events(events)).await;
    }
}
