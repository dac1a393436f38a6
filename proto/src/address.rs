//! The address of a master, and the way to it.

use thiserror::Error;
use tonic::transport::{ClientTlsConfig, Endpoint};

/// An address that is none of a master.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{master}: not the address of a master: {reason}")]
pub struct AddressError {
    /// As it was given.
    pub master: String,
    /// What is wrong with it.
    pub reason: String,
}

/// The way to a master, over an encrypted line if there is something to encrypt it with.
///
/// # Errors
/// [`AddressError`] when it is not http://HOST:PORT, or https://HOST:PORT with keys.
///
/// ```
/// assert!(selftalk_proto::endpoint("http://10.0.0.7:7700", None).is_ok());
/// assert!(selftalk_proto::endpoint("https://10.0.0.7:7700", None).is_err(), "there are no keys");
/// ```
pub fn endpoint(master: &str, tls: Option<&ClientTlsConfig>) -> Result<Endpoint, AddressError> {
    let refuse = |reason: String| AddressError { master: master.to_owned(), reason };
    let endpoint = Endpoint::from_shared(master.to_owned()).map_err(|error| refuse(chain(&error)))?;
    let (scheme, hint) = match tls {
        Some(_) => ("https", "expected https://HOST:PORT, as keys are given"),
        None => ("http", "expected http://HOST:PORT, or with --keys https://HOST:PORT"),
    };
    if endpoint.uri().scheme_str() != Some(scheme) || endpoint.uri().host().is_none() {
        return Err(refuse(hint.to_owned()));
    }
    match tls {
        Some(tls) => endpoint.tls_config(tls.clone()).map_err(|error| refuse(chain(&error))),
        None => Ok(endpoint),
    }
}

/// An error with its causes, in one line; the network library's own text often names only the layer.
#[must_use]
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let next = error.to_string();
        if !text.contains(&next) {
            text = format!("{text}: {next}");
        }
        cause = error.source();
    }
    text
}
