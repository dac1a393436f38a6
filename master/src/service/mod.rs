//! The master on the network: takes workers in, gives them units and collects the outcomes.
//!
//! A [`Hub`] owns the scheduler; [`serve`] brings workers to it over gRPC, and operators, and a [`Handle`] brings it work.

mod auditor;
mod connection;
mod desk;
mod floor;
mod gate;
mod handle;
mod hub;

use std::future::Future;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use selftalk_proto::v1::evaluation_server::EvaluationServer;
use selftalk_proto::v1::operation_server::OperationServer;
use selftalk_proto::{DESCRIPTORS, MESSAGE_LIMIT, Token};
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::time::timeout;
use tokio_stream::Stream;
use tokio_util::sync::CancellationToken;
use tonic::transport::server::Connected;
use tonic::transport::{Server, ServerTlsConfig};

use crate::store::Store;
use connection::Door;
use desk::Desk;

pub use auditor::is_right;
pub use desk::Roll;
pub use floor::{Attendance, Floor};
pub use gate::{Admission, Guest, connections};
pub use handle::{Crew, Finding, Findings, Handle, UnitEnd};
pub use hub::Hub;

/// A connection on which a ping is not answered for this long is cut.
const KEEPALIVE: Duration = Duration::from_secs(10);
/// How long a TLS handshake may take.
const HANDSHAKE: Duration = Duration::from_secs(10);
/// Streams on a connection at the same time; a worker needs one.
const STREAMS: u32 = 16;
/// Largest message of an operator, in bytes: they say next to nothing.
const OPERATION_LIMIT: usize = 4096;
/// How long the connections have to end on their own.
const GRACE: Duration = Duration::from_secs(3);

/// How workers are received.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Fingerprint of the simulator that workers must have.
    pub fingerprint: String,
    /// The token that workers must have, if any.
    pub token: Option<Token>,
    /// The token that operators must have; without one there are none.
    pub operators: Option<Token>,
    /// How connections are encrypted, if they are.
    pub tls: Option<ServerTlsConfig>,
    /// Share of the workers' answers that the master evaluates again, 0 to 1.
    pub audit: f64,
    /// Time between the heartbeats that workers are asked for.
    pub heartbeat: Duration,
}

impl Settings {
    /// Receives workers whose simulator has this fingerprint (see [`selftalk_sim::fingerprint()`]).
    #[must_use]
    pub fn new(fingerprint: impl Into<String>) -> Self {
        Self {
            fingerprint: fingerprint.into(),
            token: None,
            operators: None,
            tls: None,
            audit: 0.0,
            heartbeat: Duration::from_secs(2),
        }
    }
}

/// Why workers cannot be received any more.
#[derive(Debug, Error)]
pub enum ServiceError {
    /// The listener or its encryption failed.
    #[error("the network service failed: {0}")]
    Transport(#[from] tonic::transport::Error),
    /// What describes the service to its clients is damaged.
    #[error("the service's description is damaged: {0}")]
    Description(#[from] tonic_reflection::server::Error),
}

/// What is served: the work, and what operators may see of it and do with it.
#[derive(Debug)]
pub struct Served<S> {
    /// Where work comes from.
    pub handle: Handle,
    /// Where workers are noted.
    pub store: Arc<S>,
    /// Where the replications stand.
    pub roll: Arc<dyn Roll>,
    /// Cancelled when an operator ends the run.
    pub run: CancellationToken,
}

/// Receives workers and operators from the connections that come `incoming`, see [`connections`], until `shutdown` is
/// cancelled. That is to be after [`Handle::farewell`], so that the workers know what to expect.
///
/// # Errors
/// [`ServiceError`] when no connections can come in any more.
pub async fn serve<S: Store, C>(
    incoming: impl Stream<Item = io::Result<C>>,
    served: Served<S>,
    settings: Settings,
    shutdown: CancellationToken,
) -> Result<(), ServiceError>
where
    C: AsyncRead + AsyncWrite + Connected + Unpin + Send + 'static,
{
    let mut server = Server::builder();
    if let Some(tls) = &settings.tls {
        // A peer that does not get through the handshake is not kept waiting for.
        server = server.tls_config(tls.clone().timeout(HANDSHAKE))?;
    }
    let Served { handle, store, roll, run } = served;
    let desk = Desk { token: settings.operators.clone(), handle: handle.clone(), roll, run };
    let door = Door::new(handle, store, settings);
    // Anybody may ask whether there is a master and what it understands; neither says anything of its work.
    let (health, health_service) = tonic_health::server::health_reporter();
    health.set_serving::<EvaluationServer<Door<S>>>().await;
    health.set_serving::<OperationServer<Desk>>().await;
    let reflection = tonic_reflection::server::Builder::configure()
        .register_encoded_file_descriptor_set(DESCRIPTORS)
        .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
        .build_v1()?;
    let connections = door.connections();
    let service = EvaluationServer::new(door)
        .max_decoding_message_size(MESSAGE_LIMIT)
        .max_encoding_message_size(MESSAGE_LIMIT);
    let serving = server
        .max_concurrent_streams(STREAMS)
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE))
        .add_service(service)
        .add_service(OperationServer::new(desk).max_decoding_message_size(OPERATION_LIMIT))
        .add_service(health_service)
        .add_service(reflection)
        .serve_with_incoming_shutdown(incoming, shutdown.clone().cancelled_owned());
    let end = async {
        shutdown.cancelled().await;
        health.set_not_serving::<EvaluationServer<Door<S>>>().await;
        health.set_not_serving::<OperationServer<Desk>>().await;
        connections.close();
        tokio::time::sleep(GRACE).await;
    };
    let result = first(serving, end).await;
    connections.close();
    if timeout(GRACE, connections.wait()).await.is_err() {
        tracing::warn!("a worker's connection did not end");
    }
    Ok(result.unwrap_or(Ok(()))?)
}

/// What `future` comes to, unless `limit` is over before.
async fn first<T>(future: impl Future<Output = T>, limit: impl Future<Output = ()>) -> Option<T> {
    tokio::select! {
        biased;
        value = future => Some(value),
        () = limit => None,
    }
}
