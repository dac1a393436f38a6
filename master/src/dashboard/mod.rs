//! The dashboard: what happened and what goes on, for a browser.
//!
//! The history is read from the database, over a connection that can only read; what the workers are at is taken from the
//! master, if there is one in this process. The dashboard itself keeps nothing.

mod answer;
mod assets;
mod curves;
mod guard;
mod individuals;
mod metrics;
mod overview;
mod replay;
mod routes;
mod sources;
#[cfg(test)]
mod tests;

use std::future::IntoFuture;
use std::io;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

pub use sources::{Live, Sources, Stage};

/// How long answers that are under way have to end.
const GRACE: Duration = Duration::from_secs(2);

/// Answers on `listener` with what is on the stage, until `shutdown` is cancelled. Where only this machine can reach it,
/// requests that name another host are refused: a page of that host may have sent them.
///
/// # Errors
/// When the listener fails.
pub async fn serve(listener: TcpListener, stage: Stage, shutdown: CancellationToken) -> io::Result<()> {
    let local = listener.local_addr()?.ip().is_loopback();
    let router = routes::router(stage, local, shutdown.clone());
    let serving = axum::serve(listener, router).with_graceful_shutdown(shutdown.clone().cancelled_owned());
    let end = async {
        shutdown.cancelled().await;
        tokio::time::sleep(GRACE).await;
    };
    tokio::select! {
        served = serving.into_future() => served,
        () = end => Ok(()),
    }
}
