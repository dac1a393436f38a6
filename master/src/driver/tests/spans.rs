//! What is told of a run to whoever follows its spans.

use std::sync::Mutex;

use tracing::span::{Attributes, Id};
use tracing::subscriber::set_default;
use tracing_subscriber::layer::{Context, SubscriberExt};
use tracing_subscriber::{Layer, Registry, registry};

use super::*;

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
    let experiment = small(&["replications=1", "generations=2"]);
    let folder = TempDir::new().unwrap();
    let site = Site::open(folder.path(), &experiment, ANYWHERE).await;
    let worker = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    worker.end().await;
    let names = names.0.lock().unwrap();
    let count = |name| names.iter().filter(|other| **other == name).count();
    assert_eq!(["generation", "commit", "worker"].map(count), [2, 2, 1]);
}
