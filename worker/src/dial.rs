//! How a line to the master is opened.

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;

use tonic::transport::{Channel, Endpoint, Error};

/// Opens a line to a master. A worker brings its own, as a simulated network has other ways than the real one.
pub type Dial =
    Arc<dyn Fn(Endpoint) -> Pin<Box<dyn Future<Output = Result<Channel, Error>> + Send>> + Send + Sync>;

/// Opens lines over TCP, encrypted if the endpoint says so.
#[must_use]
pub fn over_tcp() -> Dial {
    Arc::new(|endpoint| Box::pin(async move { endpoint.connect().await }))
}
