//! A worker that measures how long it waits for work.

use std::collections::HashMap;
use std::time::Duration;

use selftalk_proto::v1::evaluation_client::EvaluationClient;
use selftalk_proto::v1::{MasterMessage, WorkerMessage};
use selftalk_proto::{Answer, FromMaster, FromWorker, Hello, PROTOCOL, Unit, UnitResult};
use selftalk_sim::{Experiment, Simulator};
use tokio::sync::mpsc::{Sender, channel};
use tokio::time::{Instant, timeout_at};
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Status, Streaming};

/// A worker with one slot.
pub(crate) struct Probe {
    stream: Streaming<MasterMessage>,
    sender: Sender<WorkerMessage>,
    simulators: HashMap<u32, Simulator>,
    held: Vec<Unit>,
}

impl Probe {
    /// Joins a master. Of workers that have as little to do, the first to come is given work first.
    pub(crate) async fn join(address: String, fingerprint: String) -> Self {
        let mut client = EvaluationClient::connect(format!("http://{address}")).await.expect("a master");
        let (sender, messages) = channel(16);
        let hello = Hello {
            protocol: PROTOCOL,
            version: "probe".to_owned(),
            fingerprint,
            host: "probe".to_owned(),
            pid: std::process::id(),
            slots: 1,
            instance: 0,
            holds: Vec::new(),
        };
        sender.send(FromWorker::Hello(hello).into()).await.expect("an open channel");
        let stream = client.work(ReceiverStream::new(messages)).await.expect("a master").into_inner();
        Self { stream, sender, simulators: HashMap::new(), held: Vec::new() }
    }

    /// Works for some time, with a pause before all that it holds is answered at once. Returns the milliseconds from each
    /// answer, which leaves it without work, to the next lease, from short to long.
    pub(crate) async fn waits(mut self, pause: Duration, time: Duration) -> Vec<f64> {
        let (end, mut waits) = (Instant::now() + time, Vec::new());
        while Instant::now() < end {
            let pause = Instant::now() + pause;
            while let Ok(message) = timeout_at(pause, self.stream.message()).await {
                self.hear(message);
            }
            self.answer().await;
            let begin = Instant::now();
            while self.held.is_empty() {
                let message = self.stream.message().await;
                self.hear(message);
            }
            waits.push(1e3 * begin.elapsed().as_secs_f64());
        }
        self.say(FromWorker::Goodbye).await;
        waits.sort_by(f64::total_cmp);
        waits
    }

    fn hear(&mut self, message: Result<Option<MasterMessage>, Status>) {
        let message =
            message.expect("a master").expect("a master that has not finished: take more generations");
        match FromMaster::try_from(message).expect("what a master says") {
            FromMaster::Experiment { id, toml } => {
                let experiment = Experiment::from_toml("experiment", &toml, &[]).expect("an experiment");
                self.simulators.insert(id, Simulator::new(&experiment).expect("a simulator"));
            }
            FromMaster::Lease(units) => self.held.extend(units),
            FromMaster::Cancel(keys) => self.held.retain(|unit| !keys.contains(&unit.key)),
            FromMaster::Welcome { .. } | FromMaster::Refusal { .. } | FromMaster::Farewell { .. } => {}
        }
    }

    async fn answer(&mut self) {
        let results = self.held.drain(..).map(|unit| {
            let simulator = &self.simulators[&unit.experiment];
            let outcomes = simulator.evaluate(&unit.genotype, unit.draw, unit.trials).expect("a unit");
            UnitResult { key: unit.key, answer: Answer::Outcomes(outcomes) }
        });
        let results = results.collect();
        self.say(FromWorker::Results(results)).await;
    }

    async fn say(&self, message: FromWorker) {
        self.sender.send(message.into()).await.expect("an open channel");
    }
}
