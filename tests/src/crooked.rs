//! A line on which what a worker says is changed on its way to the master.

use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex};

use selftalk_proto::v1::evaluation_client::EvaluationClient;
use selftalk_proto::v1::evaluation_server::{Evaluation, EvaluationServer};
use selftalk_proto::v1::unit_result::Answer;
use selftalk_proto::v1::worker_message::Body;
use selftalk_proto::v1::{MasterMessage, Results, UnitResult, WorkerMessage};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio_stream::wrappers::{ReceiverStream, TcpListenerStream};
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status, Streaming};

/// How a worker appears to go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// Every answer is wrong in its last bit.
    WrongBits,
    /// Every answer comes twice.
    Twice,
    /// No answer ever comes, only signs of life.
    Hangs,
    /// Every fourth answer is none that could be.
    Garbage,
    /// Answers are held back until the worker connects again: mostly to another master than the one that had asked.
    Late,
}

/// A port at which a worker reaches its master, and is not heard as it speaks. It closes when this is dropped.
#[derive(Debug)]
pub struct CrookedLine {
    address: SocketAddr,
    _runtime: Runtime,
}

impl CrookedLine {
    /// A line to the master at this port of this machine.
    ///
    /// # Panics
    /// If the system has no port left.
    #[must_use]
    pub fn to(port: u16, manner: Manner) -> Self {
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
        let address = listener.local_addr().unwrap();
        let master = format!("http://127.0.0.1:{port}");
        let relay = Relay { master, twist: Arc::new(Twist { manner, state: Mutex::default() }) };
        let serving = tonic::transport::Server::builder()
            .add_service(EvaluationServer::new(relay))
            .serve_with_incoming(TcpListenerStream::new(listener));
        runtime.spawn(serving);
        Self { address, _runtime: runtime }
    }

    /// What a worker takes for its master's address.
    #[must_use]
    pub fn master(&self) -> String {
        format!("http://{}", self.address)
    }
}

struct Relay {
    master: String,
    twist: Arc<Twist>,
}

/// What is done to a worker's words, over all its connections.
struct Twist {
    manner: Manner,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    answers: usize,
    held_back: Vec<UnitResult>,
}

#[tonic::async_trait]
impl Evaluation for Relay {
    type WorkStream = Pin<Box<dyn Stream<Item = Result<MasterMessage, Status>> + Send>>;

    async fn work(
        &self,
        request: Request<Streaming<WorkerMessage>>,
    ) -> Result<Response<Self::WorkStream>, Status> {
        let gone = |_| Status::unavailable("the master is away");
        let mut master = EvaluationClient::connect(self.master.clone()).await.map_err(gone)?;
        let (forward, forwarded) = tokio::sync::mpsc::channel(64);
        let (twist, mut said) = (Arc::clone(&self.twist), request.into_inner());
        tokio::spawn(async move {
            while let Some(Ok(message)) = said.next().await {
                for message in twist.twist(message) {
                    if forward.send(message).await.is_err() {
                        return;
                    }
                }
            }
        });
        let answer = master.work(ReceiverStream::new(forwarded)).await?;
        Ok(Response::new(Box::pin(answer.into_inner())))
    }
}

impl Twist {
    /// What the master hears instead.
    fn twist(&self, message: WorkerMessage) -> Vec<WorkerMessage> {
        let mut state = self.state.lock().unwrap();
        match message.body {
            Some(Body::Results(Results { results })) => {
                let results = results.into_iter().flat_map(|result| state.twist(self.manner, result));
                Vec::from_iter(say(results.collect()))
            }
            Some(Body::Hello(_)) => {
                let late = say(std::mem::take(&mut state.held_back));
                std::iter::once(message).chain(late).collect()
            }
            _ => vec![message],
        }
    }
}

impl State {
    fn twist(&mut self, manner: Manner, mut result: UnitResult) -> Vec<UnitResult> {
        self.answers += 1;
        match manner {
            Manner::WrongBits => {
                if let Some(Answer::Outcomes(outcomes)) = &mut result.answer {
                    outcomes.trials.iter_mut().for_each(|trial| trial.score = flipped(trial.score));
                }
                vec![result]
            }
            Manner::Twice => vec![result.clone(), result],
            Manner::Hangs => Vec::new(),
            Manner::Garbage => {
                if self.answers.is_multiple_of(4) {
                    result.key.truncate(3);
                }
                vec![result]
            }
            Manner::Late => {
                self.held_back.push(result);
                Vec::new()
            }
        }
    }
}

fn say(results: Vec<UnitResult>) -> Option<WorkerMessage> {
    (!results.is_empty()).then_some(WorkerMessage { body: Some(Body::Results(Results { results })) })
}

/// The number next to it.
fn flipped(score: f64) -> f64 {
    f64::from_bits(score.to_bits() ^ 1)
}
