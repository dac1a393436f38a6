//! The worker's side of one connection after another.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use selftalk_proto::v1::WorkerMessage;
use selftalk_proto::v1::evaluation_client::EvaluationClient;
use selftalk_proto::{
    FromMaster, FromWorker, Hello, MESSAGE_LIMIT, PROTOCOL, Token, Unit, UnitKey, UnitResult, chain, endpoint,
};
use selftalk_sim::{Experiment, Simulator};
use tokio::sync::mpsc;
use tokio::time::{Interval, MissedTickBehavior, interval, sleep, timeout};
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;
use tonic::transport::Endpoint;
use tonic::{Code, Request, Status, Streaming};

use crate::config::{Config, host};
use crate::dial::Dial;
use crate::error::WorkerError;
use crate::queue::{Queue, Study, Task};

/// How long a master may take to accept a connection, and to answer the hello.
const PATIENCE: Duration = Duration::from_secs(5);
/// A line on which nothing comes back for this long after a question is cut.
const KEEPALIVE: Duration = Duration::from_secs(10);
/// How long a goodbye may take.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// How long the first of some results waits for the others, while there is more to come. Slots have other units to go on with.
const MOMENT: Duration = Duration::from_millis(2);
/// Most results that go together.
const TOGETHER: usize = 64;
/// Results that are kept after they were sent, as the line may be cut before they arrive.
const KEPT: usize = 256;

/// How a connection ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// The master has no more work.
    Finished,
    /// The worker was told to stop.
    Stopped,
    /// There is no line, or it was cut.
    Cut {
        reason: String,
        /// Whether the master had accepted the worker.
        welcomed: bool,
    },
}

/// What outlives a connection.
pub(crate) struct Session {
    endpoint: Endpoint,
    dial: Dial,
    hello: Hello,
    master: String,
    token: Option<Token>,
    queue: Arc<Queue>,
    outbox: mpsc::UnboundedReceiver<UnitResult>,
    /// The last results sent, handed in again after a cut; the master ignores what it has.
    recent: VecDeque<UnitResult>,
    /// Experiments by their files; a restarted master numbers them anew.
    studies: BTreeMap<String, (Study, Simulator)>,
    shutdown: CancellationToken,
}

/// What belongs to one connection.
struct Line {
    sender: mpsc::Sender<WorkerMessage>,
    inbound: Streaming<selftalk_proto::v1::MasterMessage>,
    experiments: BTreeMap<u32, (Study, Simulator)>,
    heartbeat: Interval,
}

/// Why a connection is over.
enum Stop {
    Cut(String),
    Fatal(WorkerError),
}

impl From<WorkerError> for Stop {
    fn from(error: WorkerError) -> Self {
        Self::Fatal(error)
    }
}

impl Session {
    pub(crate) fn new(
        config: &Config,
        dial: Dial,
        queue: Arc<Queue>,
        outbox: mpsc::UnboundedReceiver<UnitResult>,
        shutdown: CancellationToken,
    ) -> Result<Self, WorkerError> {
        let master = config.master.clone();
        let endpoint = endpoint(&master, config.tls.as_ref())?
            .connect_timeout(PATIENCE)
            .tcp_nodelay(true)
            .http2_keep_alive_interval(KEEPALIVE)
            .keep_alive_timeout(KEEPALIVE)
            .keep_alive_while_idle(true);
        let hello = Hello {
            protocol: PROTOCOL,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint: config.fingerprint.clone(),
            host: host(),
            pid: std::process::id(),
            slots: config.slots,
            instance: config.instance(),
            holds: Vec::new(),
        };
        let (recent, studies) = Default::default();
        let token = config.token.clone();
        Ok(Self { endpoint, dial, hello, master, token, queue, outbox, recent, studies, shutdown })
    }

    /// Connects, for at most `limit`, and works until the line is cut, the master has finished or the worker is told
    /// to stop.
    pub(crate) async fn run(&mut self, limit: Duration) -> Result<Ended, WorkerError> {
        let shutdown = self.shutdown.clone();
        let connected = tokio::select! {
            biased;
            () = shutdown.cancelled() => return Ok(Ended::Stopped),
            connected = self.connect() => connected,
            () = sleep(limit) => Err(Stop::Cut("the master does not answer".to_owned())),
        };
        let (stop, welcomed) = match connected {
            Ok(mut line) => match self.work(&mut line).await {
                Ok(ended) => return Ok(ended),
                Err(stop) => (stop, true),
            },
            Err(stop) => (stop, false),
        };
        match stop {
            Stop::Cut(reason) => Ok(Ended::Cut { reason, welcomed }),
            Stop::Fatal(error) => Err(error),
        }
    }

    async fn connect(&mut self) -> Result<Line, Stop> {
        let channel = (self.dial)(self.endpoint.clone()).await.map_err(|error| Stop::Cut(chain(&error)))?;
        let mut client = EvaluationClient::new(channel)
            .max_decoding_message_size(MESSAGE_LIMIT)
            .max_encoding_message_size(MESSAGE_LIMIT);
        let (sender, outgoing) = mpsc::channel(64);
        let hello = FromWorker::Hello(Hello { holds: self.holds(), ..self.hello.clone() });
        send(&sender, hello).await?;
        let mut request = Request::new(ReceiverStream::new(outgoing));
        if let Some(token) = &self.token {
            token.attach(request.metadata_mut());
        }
        let call = client.work(request);
        let mut inbound = match timeout(PATIENCE, call).await {
            Ok(Ok(response)) => response.into_inner(),
            Ok(Err(status)) if status.code() == Code::Unimplemented => {
                return Err(WorkerError::NotAMaster { master: self.master.clone() }.into());
            }
            Ok(Err(status)) if status.code() == Code::Unauthenticated => {
                let text = status.message().to_owned();
                return Err(WorkerError::Token { master: self.master.clone(), text }.into());
            }
            Ok(Err(status)) => return Err(self.cut(&status)),
            Err(_) => return Err(Stop::Cut("the master does not answer".to_owned())),
        };
        let first = timeout(PATIENCE, inbound.message()).await;
        let first = first.map_err(|_| Stop::Cut("the master does not answer the hello".to_owned()))?;
        match self.message(first)? {
            FromMaster::Welcome { worker, heartbeat_ms } => {
                tracing::info!(master = self.master, worker, "connected");
                let mut heartbeat = interval(Duration::from_millis(u64::from(heartbeat_ms.max(1))));
                heartbeat.set_missed_tick_behavior(MissedTickBehavior::Delay);
                Ok(Line { sender, inbound, experiments: BTreeMap::new(), heartbeat })
            }
            FromMaster::Refusal { text, .. } => {
                Err(WorkerError::Refused { master: self.master.clone(), text }.into())
            }
            FromMaster::Farewell { .. } => Err(Stop::Cut("the master is ending".to_owned())),
            other => Err(self.nonsense(format!("expected a welcome, got {other:?}"))),
        }
    }

    /// Units the master should leave to this worker: unanswered ones, and those whose results may not have arrived.
    fn holds(&self) -> Vec<UnitKey> {
        let recent = self.recent.iter().map(|result| result.key);
        self.queue.live().into_iter().chain(recent).collect::<BTreeSet<_>>().into_iter().collect()
    }

    async fn work(&mut self, line: &mut Line) -> Result<Ended, Stop> {
        if !self.recent.is_empty() {
            send(&line.sender, FromWorker::Results(self.recent.iter().cloned().collect())).await?;
        }
        let shutdown = self.shutdown.clone();
        let mut results = Vec::new();
        loop {
            // In an order, so that a simulated network plays out in the same way every time. Nothing starves: what
            // comes first is rarely ready, and there is an end to what a worker has in hand.
            tokio::select! {
                biased;
                () = shutdown.cancelled() => {
                    self.say_goodbye(line).await;
                    return Ok(Ended::Stopped);
                }
                _ = line.heartbeat.tick() => send(&line.sender, FromWorker::Heartbeat).await?,
                _ = self.outbox.recv_many(&mut results, TOGETHER), if !self.outbox.is_closed() => {
                    if self.queue.is_busy() {
                        // What comes within a moment goes along: a message costs as much as some fast units.
                        sleep(MOMENT).await;
                        while results.len() < TOGETHER && let Ok(result) = self.outbox.try_recv() {
                            results.push(result);
                        }
                    }
                    tracing::trace!(count = results.len(), "results");
                    self.hand_in(line, std::mem::take(&mut results)).await?;
                }
                message = line.inbound.message() => {
                    let message = self.message(message)?;
                    if let Some(ended) = self.obey(line, message)? {
                        return Ok(ended);
                    }
                }
            }
        }
    }

    fn obey(&mut self, line: &mut Line, message: FromMaster) -> Result<Option<Ended>, Stop> {
        match message {
            FromMaster::Experiment { id, toml } => {
                let study = self.study(toml)?;
                line.experiments.insert(id, study);
            }
            FromMaster::Lease(units) => {
                let tasks: Result<Vec<_>, Stop> =
                    units.into_iter().map(|unit| self.task(line, unit)).collect();
                self.queue.push(tasks?);
            }
            FromMaster::Cancel(keys) => self.queue.cancel(&keys),
            FromMaster::Farewell { finished: true } => return Ok(Some(Ended::Finished)),
            FromMaster::Farewell { finished: false } => {
                return Err(Stop::Cut("the master has ended".to_owned()));
            }
            FromMaster::Refusal { text, .. } => {
                return Err(WorkerError::Refused { master: self.master.clone(), text }.into());
            }
            FromMaster::Welcome { .. } => return Err(self.nonsense("a second welcome".to_owned())),
        }
        Ok(None)
    }

    fn study(&mut self, toml: String) -> Result<(Study, Simulator), WorkerError> {
        if let Some(study) = self.studies.get(&toml) {
            return Ok(study.clone());
        }
        let experiment = Experiment::from_toml("experiment", &toml, &[])?;
        let simulator = Simulator::new(&experiment)?;
        let study = (self.queue.open(simulator.clone()), simulator);
        self.studies.insert(toml, study.clone());
        Ok(study)
    }

    fn task(&self, line: &Line, unit: Unit) -> Result<(Study, Arc<Task>), Stop> {
        let Some((study, simulator)) = line.experiments.get(&unit.experiment) else {
            return Err(self.nonsense(format!("a unit of the unknown experiment {}", unit.experiment)));
        };
        // The simulator would give up all trials under way along with a misfit.
        if unit.genotype.genes().len() != simulator.gene_count() || unit.trials.end > simulator.trial_count()
        {
            return Err(self.nonsense(format!("unit {} does not fit its experiment", unit.key)));
        }
        Ok((*study, Task::new(unit.key, unit.genotype, unit.draw, unit.trials)))
    }

    async fn hand_in(&mut self, line: &Line, results: Vec<UnitResult>) -> Result<(), Stop> {
        let excess = (self.recent.len() + results.len()).saturating_sub(KEPT).min(self.recent.len());
        self.recent.drain(..excess);
        self.recent.extend(results.iter().cloned());
        send(&line.sender, FromWorker::Results(results)).await
    }

    /// Gives everything back, so that the master need not wait for silence.
    async fn say_goodbye(&self, line: &mut Line) {
        let last_words = async {
            // Once the master has understood it closes its side.
            if send(&line.sender, FromWorker::Goodbye).await.is_ok() {
                while let Ok(Some(_)) = line.inbound.message().await {}
            }
        };
        if timeout(LAST_WORDS, last_words).await.is_err() {
            tracing::debug!("the master does not answer the goodbye");
        }
    }

    fn message(
        &self,
        message: Result<Option<selftalk_proto::v1::MasterMessage>, Status>,
    ) -> Result<FromMaster, Stop> {
        let message = message.map_err(|status| self.cut(&status))?;
        let message = message.ok_or_else(|| Stop::Cut("the master closed the line".to_owned()))?;
        FromMaster::try_from(message).map_err(|error| self.nonsense(error.to_string()))
    }

    fn cut(&self, status: &Status) -> Stop {
        let text = if status.message().is_empty() { chain(status) } else { status.message().to_owned() };
        Stop::Cut(text)
    }

    fn nonsense(&self, reason: String) -> Stop {
        Stop::Fatal(WorkerError::Protocol { master: self.master.clone(), reason })
    }
}

async fn send(sender: &mpsc::Sender<WorkerMessage>, message: FromWorker) -> Result<(), Stop> {
    sender.send(message.into()).await.map_err(|_| Stop::Cut("the line is cut".to_owned()))
}
