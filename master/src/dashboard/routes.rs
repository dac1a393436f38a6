//! Which address is answered with what.

use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, RawQuery, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;
use tokio_util::sync::CancellationToken;

use super::answer::{Refusal, json, typed};
use super::assets::{PAGE, part};
use super::guard::guard;
use super::replay::{Studio, policy};
use super::sources::{Sources, Stage};
use super::{curves, individuals, metrics, overview};
use crate::store::{Store, StoredExperiment, StoredReplication};

const HTML: &str = "text/html; charset=utf-8";
const TEXT: &str = "text/plain; charset=utf-8";
/// Connections of workers that are listed at most, the latest.
const WORKERS: usize = 200;

#[derive(Debug, Clone)]
struct App {
    stage: Stage,
    studio: Studio,
}

impl App {
    fn sources(&self) -> Result<Arc<Sources>, Refusal> {
        self.stage.now().ok_or(Refusal::Dark)
    }
}

/// All there is to ask.
pub(super) fn router(stage: Stage, local: bool, shutdown: CancellationToken) -> Router {
    let app = App { stage, studio: Studio::new(shutdown) };
    Router::new()
        .route("/", get(page))
        .route("/experiments/{name}", get(page))
        .route("/experiments/{name}/{replication}", get(page))
        .route("/experiments/{name}/{replication}/{generation}", get(page))
        .route("/experiments/{name}/{replication}/{generation}/{individual}", get(page))
        .route("/experiments/{name}/{replication}/{generation}/{individual}/replay", get(replay))
        .route("/assets/{name}", get(asset))
        .route("/api/overview", get(look))
        .route("/api/workers", get(workers))
        .route("/api/experiments/{name}/settings", get(settings))
        .route("/api/experiments/{name}/curves", get(curve))
        .route("/api/experiments/{name}/{replication}/{generation}", get(generation))
        .route("/api/experiments/{name}/{replication}/{generation}/{individual}", get(individual))
        .route("/metrics", get(measure))
        .route("/healthz", get(|| async { typed(TEXT, "serving\n") }))
        .route("/readyz", get(ready))
        .fallback(|| async { (StatusCode::NOT_FOUND, "there is nothing at this address\n") })
        .layer(from_fn_with_state(local, guard))
        .with_state(app)
}

async fn page() -> Response {
    typed(HTML, PAGE)
}

async fn asset(Path(name): Path<String>) -> Response {
    match part(&name) {
        Some((kind, content)) => typed(kind, content),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

async fn look(State(app): State<App>) -> Result<Response, Refusal> {
    Ok(json(&overview::overview(&*app.sources()?).await?))
}

async fn measure(State(app): State<App>) -> Response {
    let measured = match app.sources() {
        Ok(sources) => metrics::metrics(&sources).await,
        Err(refusal) => Err(refusal),
    };
    match measured {
        Ok(text) => typed(metrics::TYPE, text),
        Err(refusal) => in_words(refusal),
    }
}

async fn ready(State(app): State<App>) -> Response {
    match app.sources() {
        Ok(_) => typed(TEXT, "ready\n"),
        Err(refusal) => in_words(refusal),
    }
}

/// A worker's connection, as the history has it.
#[derive(Serialize)]
struct Connection {
    name: String,
    host: String,
    version: String,
    slots: u32,
    joined_at: String,
    left_at: Option<String>,
}

async fn workers(State(app): State<App>) -> Result<Response, Refusal> {
    let all = app.sources()?.store().list_workers().await?;
    let latest: Vec<Connection> = all
        .into_iter()
        .rev()
        .take(WORKERS)
        .map(|worker| Connection {
            name: worker.name,
            host: worker.host,
            version: worker.version,
            slots: worker.slots,
            joined_at: worker.joined_at,
            left_at: worker.left_at,
        })
        .collect();
    Ok(json(&latest))
}

async fn settings(State(app): State<App>, Path(name): Path<String>) -> Result<Response, Refusal> {
    let stored = experiment(&*app.sources()?, &name).await?;
    Ok(typed(TEXT, stored.experiment.to_toml()))
}

async fn curve(
    State(app): State<App>,
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
) -> Result<Response, Refusal> {
    let sources = app.sources()?;
    let stored = experiment(&sources, &name).await?;
    let since = query.as_deref().and_then(since).unwrap_or_default();
    Ok(json(&curves::curves(&sources, &stored, since).await?))
}

/// The generation in `since=GENERATION`.
fn since(query: &str) -> Option<u32> {
    query.split('&').find_map(|pair| pair.strip_prefix("since="))?.parse().ok()
}

async fn generation(
    State(app): State<App>,
    Path((name, replication, generation)): Path<(String, u32, u32)>,
) -> Result<Response, Refusal> {
    let sources = app.sources()?;
    let (stored, replication) = of_replication(&sources, &name, replication).await?;
    Ok(json(&individuals::generation(&sources, &stored, &replication, generation).await?))
}

async fn individual(
    State(app): State<App>,
    Path((name, replication, generation, number)): Path<(String, u32, u32, u32)>,
) -> Result<Response, Refusal> {
    let sources = app.sources()?;
    let (stored, replication) = of_replication(&sources, &name, replication).await?;
    Ok(json(&individuals::individual(&sources, &stored, &replication, generation, number).await?))
}

async fn replay(
    State(app): State<App>,
    Path((name, replication, generation, number)): Path<(String, u32, u32, u32)>,
) -> Response {
    let made = async {
        let sources = app.sources()?;
        let (stored, replication) = of_replication(&sources, &name, replication).await?;
        app.studio.replay(sources, stored, replication, generation, number).await
    };
    match made.await {
        Ok(page) => {
            let policy = HeaderValue::try_from(policy(&page));
            let mut response = typed(HTML, page);
            if let Ok(policy) = policy {
                response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, policy);
            }
            response
        }
        Err(refusal) => in_words(refusal),
    }
}

/// A refusal for people.
fn in_words(refusal: Refusal) -> Response {
    let status = refusal.status();
    (status, typed(TEXT, format!("{}\n", refusal.words()))).into_response()
}

async fn experiment(sources: &Sources, name: &str) -> Result<StoredExperiment, Refusal> {
    let stored = sources.store().experiment(name).await?;
    stored.ok_or_else(|| Refusal::Missing(format!("there is no experiment `{name}`")))
}

async fn of_replication(
    sources: &Sources,
    name: &str,
    number: u32,
) -> Result<(StoredExperiment, StoredReplication), Refusal> {
    let stored = experiment(sources, name).await?;
    let found = stored.replications.iter().find(|replication| replication.number == number).cloned();
    let replication = found.ok_or_else(|| Refusal::missing("replication", number))?;
    Ok((stored, replication))
}
