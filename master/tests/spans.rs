//! What is told of a run to whoever follows its spans. This test is alone in its program: others, on other threads that
//! nobody follows, would have the library take note that nobody is interested.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::sync::{Arc, Mutex};

use selftalk::driver::RunEnd;
use selftalk::master::Master;
use selftalk::service::{Settings, connections};
use selftalk::store::{MemoryStore, Store};
use selftalk_sim::{Experiment, fingerprint};
use selftalk_worker::Config;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;
use tracing::span::{Attributes, Id};
use tracing::subscriber::set_default;
use tracing_subscriber::layer::{Context, SubscriberExt};
use tracing_subscriber::{Layer, Registry, registry};

/// The names of all spans.
#[derive(Clone, Default)]
struct Names(Arc<Mutex<Vec<&'static str>>>);

impl Layer<Registry> for Names {
    fn on_new_span(&self, attributes: &Attributes<'_>, _: &Id, _: Context<'_, Registry>) {
        self.0.lock().unwrap().push(attributes.metadata().name());
    }
}

#[tokio::test]
async fn generations_commits_and_workers_are_spans() {
    let names = Names::default();
    let _guard = set_default(registry().with(names.clone()));
    let text = "name = \"small\"\nreplications = 1\ngenerations = 2\nevolution = { population = 4, parents = 2, offspring = 2 }";
    let experiment = Experiment::from_toml("small.toml", text, &[]).unwrap();
    let store = Arc::new(MemoryStore::new());
    let stored = store.create_experiment(&experiment, "f").await.unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let settings = Settings::new(fingerprint().unwrap());
    let master = Master::prepare(store, &[stored], settings).await.unwrap();
    let mut config = Config::new(format!("http://{address}"), fingerprint().unwrap());
    config.slots = 1;
    let worker = tokio::spawn(selftalk_worker::run(config, CancellationToken::new()));
    assert_eq!(master.run(connections(listener), CancellationToken::new()).await.unwrap(), RunEnd::Finished);
    worker.await.unwrap().unwrap();
    let names = names.0.lock().unwrap();
    let count = |name| names.iter().filter(|other| **other == name).count();
    assert_eq!(["generation", "commit", "worker"].map(count), [2, 2, 1]);
}
