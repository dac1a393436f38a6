//! Whole runs in one process: a master and workers that talk over loopback.

mod audit;

use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use selftalk_proto::v1::evaluation_client::EvaluationClient;
use selftalk_proto::{Answer, FromMaster, FromWorker, Hello, PROTOCOL, RefusalReason, Unit, UnitResult, v1};
use selftalk_sim::TrialOutcome;
use selftalk_worker::{Config, End, WorkerError};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_stream::wrappers::ReceiverStream;

use super::*;
use crate::master::{Master, MasterError};
use crate::service::{Crew, Settings, connections};
use crate::store::{GenerationRecord, HistoryDigest, SqliteStore, WorkerId};

const ANYWHERE: &str = "127.0.0.1:0";
const FOREVER: Duration = Duration::from_secs(120);

fn small(overrides: &[&str]) -> Experiment {
    let text = "name = \"small\"\nreplications = 3\ngenerations = 4\n[evolution]\npopulation = 20\nparents = 4\n\
                mutation = 0.001\ndraws_every = 2\n\
                [reach]\nsteps = 8\n[open]\nsteps = 8\n[grasp]\nsteps = 8\n[move]\nsteps = 8\n";
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Experiment::from_toml("small.toml", text, &overrides).unwrap()
}

/// A master with its database.
struct Site {
    store: Arc<SqliteStore>,
    address: SocketAddr,
    board: watch::Receiver<Board>,
    crew: watch::Receiver<Crew>,
    shutdown: CancellationToken,
    run: JoinHandle<Result<RunEnd, MasterError>>,
}

impl Site {
    async fn open(folder: &Path, experiment: &Experiment, address: &str) -> Self {
        Self::auditing(folder, experiment, address, 0.0).await
    }

    /// A master that looks into a share of the answers.
    async fn auditing(folder: &Path, experiment: &Experiment, address: &str, audit: f64) -> Self {
        let store = Arc::new(SqliteStore::open_writer(&folder.join("history.db")).await.unwrap());
        let stored = match store.experiment(&experiment.name).await.unwrap() {
            Some(stored) => stored,
            None => store.create_experiment(experiment, "f").await.unwrap(),
        };
        let listener = TcpListener::bind(address).await.unwrap();
        let address = listener.local_addr().unwrap();
        let settings = Settings {
            heartbeat: Duration::from_millis(100),
            audit,
            ..Settings::new(selftalk_sim::fingerprint().unwrap())
        };
        let master = Master::prepare(Arc::clone(&store), &[stored], settings).await.unwrap();
        let (board, crew, shutdown) = (master.board(), master.crew(), CancellationToken::new());
        let run = tokio::spawn(master.run(connections(listener), shutdown.clone()));
        Self { store, address, board, crew, shutdown, run }
    }

    async fn end(self) -> RunEnd {
        let end = timeout(FOREVER, self.run).await.expect("no end").unwrap().unwrap();
        Arc::try_unwrap(self.store).expect("someone still has the store").close().await.unwrap();
        end
    }

    /// Waits until a number of generations are committed, over all replications.
    async fn generations(&mut self, count: u32) {
        let enough =
            |board: &Board| board.standings.iter().map(|standing| standing.generations).sum::<u32>() >= count;
        timeout(FOREVER, self.board.wait_for(enough)).await.expect("no progress").unwrap();
    }

    async fn workers(&mut self, count: u32) {
        timeout(FOREVER, self.crew.wait_for(|crew| crew.workers == count)).await.expect("nobody").unwrap();
    }

    fn worker(&self, slots: u32) -> Hand {
        let shutdown = CancellationToken::new();
        let mut config =
            Config::new(format!("http://{}", self.address), selftalk_sim::fingerprint().unwrap());
        config.slots = slots;
        Hand { run: tokio::spawn(selftalk_worker::run(config, shutdown.clone())), shutdown }
    }
}

/// A worker.
struct Hand {
    shutdown: CancellationToken,
    run: JoinHandle<Result<End, WorkerError>>,
}

impl Hand {
    async fn end(self) -> End {
        timeout(FOREVER, self.run).await.expect("no end").unwrap().unwrap()
    }
}

/// Everything that was stored, except who did it; and its digests.
async fn history(folder: &Path) -> (Vec<Vec<GenerationRecord>>, Vec<String>) {
    let store = SqliteStore::open_reader(&folder.join("history.db")).await.unwrap();
    let (mut history, mut digests) = (Vec::new(), Vec::new());
    for replication in store.experiments().await.unwrap().remove(0).replications {
        assert!(replication.finished);
        let mut reader = store.generations(&replication);
        let mut generations = Vec::new();
        let mut digest = HistoryDigest::new();
        for generation in 0..replication.generations {
            let mut record = reader.read(generation).await.unwrap();
            digest.update(&record);
            for evaluated in &mut record.evaluated {
                assert!(evaluated.failure.is_none());
                evaluated.worker = None;
            }
            generations.push(record);
        }
        history.push(generations);
        digests.push(digest.finish());
    }
    (history, digests)
}

async fn undisturbed(experiment: &Experiment) -> (Vec<Vec<GenerationRecord>>, Vec<String>) {
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), experiment, ANYWHERE).await;
    let worker = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(worker.end().await, End::Finished);
    history(folder.path()).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_history_does_not_depend_on_the_number_of_workers() {
    let experiment = small(&[]);
    let alone = undisturbed(&experiment).await;
    assert_eq!(alone.0.len(), 3);
    assert!(alone.0.iter().all(|generations| generations.len() == 4));

    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let workers = [1, 2, 1].map(|slots| site.worker(slots));
    assert_eq!(site.end().await, RunEnd::Finished);
    for worker in workers {
        // On a busy machine one may come when all is done and the master gone.
        let end = timeout(FOREVER, worker.run).await.expect("no end").unwrap();
        assert!(matches!(end, Ok(End::Finished) | Err(WorkerError::Unreachable { .. })), "{end:?}");
    }
    assert!(history(folder.path()).await == alone);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn workers_may_leave_or_vanish_half_way() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    let mut site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let (leaves, vanishes) = (site.worker(1), site.worker(2));
    site.workers(2).await;
    site.generations(2).await;
    leaves.shutdown.cancel();
    assert_eq!(leaves.end().await, End::Stopped);
    site.workers(1).await;
    vanishes.run.abort();
    site.workers(0).await;
    let last = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(last.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_worker_outlives_its_master() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    let mut site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let worker = site.worker(2);
    site.generations(3).await;
    site.shutdown.cancel();
    let address = site.address.to_string();
    assert_eq!(site.end().await, RunEnd::Interrupted);
    assert!(!worker.run.is_finished());

    let site = Site::open(folder.path(), &experiment, &address).await;
    let store = Arc::clone(&site.store);
    let resumed = store.experiment("small").await.unwrap().unwrap();
    assert!(resumed.replications.iter().map(|replication| replication.generations).sum::<u32>() >= 3);
    drop(store);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(worker.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_simulator_is_refused() {
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &small(&[]), ANYWHERE).await;
    let mut config = Config::new(format!("http://{}", site.address), selftalk_sim::fingerprint().unwrap());
    config.fingerprint = "another".to_owned();
    let error = selftalk_worker::run(config, CancellationToken::new()).await.unwrap_err();
    assert!(matches!(&error, WorkerError::Refused { .. }) && error.is_network(), "{error}");
    assert!(error.to_string().contains("fingerprint another"), "{error}");
    assert_eq!(*site.crew.borrow(), Crew::default());
    site.shutdown.cancel();
    assert_eq!(site.end().await, RunEnd::Interrupted);
}

#[tokio::test]
async fn a_master_that_is_not_there_is_given_up() {
    let listener = TcpListener::bind(ANYWHERE).await.unwrap();
    let mut config = Config::new(
        format!("http://{}", listener.local_addr().unwrap()),
        selftalk_sim::fingerprint().unwrap(),
    );
    drop(listener);
    config.connect_timeout = Duration::from_millis(300);
    let error = selftalk_worker::run(config, CancellationToken::new()).await.unwrap_err();
    assert!(matches!(&error, WorkerError::Unreachable { .. }), "{error}");
    assert_eq!(error.to_string().lines().count(), 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn workers_are_remembered() {
    let experiment = small(&["replications=1", "generations=1"]);
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let worker = site.worker(1);
    site.end().await;
    worker.end().await;
    let store = SqliteStore::open_reader(&folder.path().join("history.db")).await.unwrap();
    let replication = store.experiments().await.unwrap().remove(0).replications.remove(0);
    let record = store.generations(&replication).read(0).await.unwrap();
    assert!(record.evaluated.iter().all(|evaluated| evaluated.worker == Some(WorkerId(1))));
}

/// Says these things to a master and returns what it answers, until it closes the line or `answer` has nothing to say.
async fn talk(
    site: &Site,
    first: v1::WorkerMessage,
    mut answer: impl FnMut(&FromMaster) -> Option<Vec<FromWorker>>,
) -> Vec<FromMaster> {
    let mut client = EvaluationClient::connect(format!("http://{}", site.address)).await.unwrap();
    let (sender, messages) = tokio::sync::mpsc::channel(1000);
    sender.send(first).await.unwrap();
    let mut incoming = client.work(ReceiverStream::new(messages)).await.unwrap().into_inner();
    let mut heard = Vec::new();
    while let Ok(Some(message)) = incoming.message().await {
        let message = FromMaster::try_from(message).unwrap();
        let replies = answer(&message);
        heard.push(message);
        let Some(replies) = replies else { break };
        for reply in replies {
            // The master may have closed its side, and what it said last is still to be heard.
            let _ = sender.send(reply.into()).await;
        }
    }
    heard
}

fn hello() -> Hello {
    Hello {
        protocol: PROTOCOL,
        version: "0".to_owned(),
        fingerprint: selftalk_sim::fingerprint().unwrap(),
        host: "h".to_owned(),
        pid: 1,
        slots: 1,
        instance: 1,
        holds: Vec::new(),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn units_that_always_fail_are_set_aside_and_said_to_be() {
    let experiment = small(&["replications=1", "generations=1"]);
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let fail = |unit: &Unit| UnitResult { key: unit.key, answer: Answer::Failed("no luck".to_owned()) };
    let mut attempts = 0;
    let heard = talk(&site, FromWorker::Hello(hello()).into(), |message| match message {
        FromMaster::Lease(units) => {
            attempts += units.len();
            Some(vec![FromWorker::Results(units.iter().map(fail).collect())])
        }
        FromMaster::Farewell { .. } => None,
        _ => Some(Vec::new()),
    })
    .await;
    assert_eq!(heard.last(), Some(&FromMaster::Farewell { finished: true }));
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(attempts, 20 * 5);
    let store = SqliteStore::open_reader(&folder.path().join("history.db")).await.unwrap();
    let replication = store.experiments().await.unwrap().remove(0).replications.remove(0);
    let record = store.generations(&replication).read(0).await.unwrap();
    for evaluated in &record.evaluated {
        assert_eq!(evaluated.failure.as_deref(), Some("set aside after 5 losses: no luck"));
        assert!(evaluated.outcomes.iter().all(|outcome| outcome.score == 0.0 && !outcome.success));
    }
    assert!(record.scored.iter().all(|scored| scored.fitness == 0.0));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_known_of_a_draw_is_not_run_again() {
    // Generations 0 and 1 have one draw, 2 and 3 another one; all children are copies.
    let experiment = small(&["replications=1", "evolution.mutation=0.0"]);
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let nothing = TrialOutcome { score: 0.5, success: false, steps: 1 };
    let answer = |unit: &Unit| UnitResult {
        key: unit.key,
        answer: Answer::Outcomes(vec![nothing; unit.trials.len()]),
    };
    let mut units = 0;
    talk(&site, FromWorker::Hello(hello()).into(), |message| match message {
        FromMaster::Lease(leased) => {
            units += leased.len();
            Some(vec![FromWorker::Results(leased.iter().map(answer).collect())])
        }
        FromMaster::Farewell { .. } => None,
        _ => Some(Vec::new()),
    })
    .await;
    assert_eq!(site.end().await, RunEnd::Finished);
    // All are equal, so only the first founder has descendants in generation 2.
    assert_eq!(units, 20 + 1, "the founders, and what is left of them in the second draw");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn strangers_are_told_why_they_are_refused() {
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &small(&[]), ANYWHERE).await;
    let other_protocol = FromWorker::Hello(Hello { protocol: PROTOCOL + 1, ..hello() }).into();
    let no_slots = FromWorker::Hello(Hello { slots: 0, ..hello() }).into();
    for (first, expected) in [
        (other_protocol, RefusalReason::Protocol),
        (no_slots, RefusalReason::Hello),
        (FromWorker::Heartbeat.into(), RefusalReason::Hello),
        (v1::WorkerMessage { body: None }, RefusalReason::Hello),
    ] {
        let heard = talk(&site, first, |_| Some(Vec::new())).await;
        assert!(
            matches!(&heard[..], [FromMaster::Refusal { reason, .. }] if *reason == expected),
            "{heard:?}"
        );
    }
    site.shutdown.cancel();
    assert_eq!(site.end().await, RunEnd::Interrupted);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_master_says_that_it_serves_and_what_it_understands() {
    use tonic_health::pb::HealthCheckRequest;
    use tonic_health::pb::health_check_response::ServingStatus;
    use tonic_health::pb::health_client::HealthClient;
    use tonic_reflection::pb::v1::ServerReflectionRequest;
    use tonic_reflection::pb::v1::server_reflection_client::ServerReflectionClient;
    use tonic_reflection::pb::v1::server_reflection_request::MessageRequest;
    use tonic_reflection::pb::v1::server_reflection_response::MessageResponse;

    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &small(&[]), ANYWHERE).await;
    let channel = tonic::transport::Endpoint::from_shared(format!("http://{}", site.address)).unwrap();
    let channel = channel.connect().await.unwrap();
    for service in ["", "selftalk.v1.Evaluation"] {
        let request = HealthCheckRequest { service: service.to_owned() };
        let status = HealthClient::new(channel.clone()).check(request).await.unwrap().into_inner().status();
        assert_eq!(status, ServingStatus::Serving, "{service}");
    }
    let request = ServerReflectionRequest {
        host: String::new(),
        message_request: Some(MessageRequest::ListServices(String::new())),
    };
    let requests = tokio_stream::iter([request]);
    let answers = ServerReflectionClient::new(channel).server_reflection_info(requests).await.unwrap();
    let answer = answers.into_inner().message().await.unwrap().unwrap().message_response.unwrap();
    let MessageResponse::ListServicesResponse(list) = answer else { panic!("{answer:?}") };
    let names: Vec<&str> = list.service.iter().map(|service| service.name.as_str()).collect();
    assert!(
        names.contains(&"selftalk.v1.Evaluation") && names.contains(&"grpc.health.v1.Health"),
        "{names:?}"
    );
    site.shutdown.cancel();
    assert_eq!(site.end().await, RunEnd::Interrupted);
}
