//! What a master and those who call it, workers and operators, prove to each other who they are with, and encrypt what
//! they say: a folder of certificate, key, authority and token each. `selftalk keys init` makes such folders. The files have the names of the secrets in
//! which Kubernetes keeps certificates, so one of those can be mounted as it is.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, PrivateKeyDer};
use thiserror::Error;
use tonic::transport::{Certificate, ClientTlsConfig, Endpoint, Identity, Server, ServerTlsConfig};

use crate::{Token, TokenError};

/// The certificate that is shown to the other side, in PEM.
pub const CERTIFICATE: &str = "tls.crt";
/// Its private key, in PEM.
pub const KEY: &str = "tls.key";
/// Certificate of the authority by which the other side's certificate has to be signed, in PEM.
pub const AUTHORITY: &str = "ca.crt";
/// The token: a worker's, an operator's, or in a master's folder the one that workers must have.
pub const TOKEN: &str = "token";
/// In a master's folder, the token that operators must have.
pub const OPERATOR_TOKEN: &str = "operator-token";

/// Why a folder of keys cannot be used.
#[derive(Debug, Error)]
pub enum KeysError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {reason}; `selftalk keys init` makes such folders", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: std::io::Error,
    },
    /// A file does not hold what it should.
    #[error("{}: there is no {expected} in PEM in this file", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What should be in it.
        expected: &'static str,
    },
    /// A certificate without its key, or a key without its certificate.
    #[error("{}: there is only one of {CERTIFICATE} and {KEY}, which belong together", folder.display())]
    Half {
        /// The folder.
        folder: PathBuf,
    },
    /// Certificate, key and authority are no basis for TLS.
    #[error("{}: these keys cannot be used: {reason}", folder.display())]
    Refused {
        /// The folder.
        folder: PathBuf,
        /// What the TLS library says.
        reason: String,
    },
    /// The token cannot be used.
    #[error(transparent)]
    Token(#[from] TokenError),
}

/// A master's keys: its certificate and key, and, where there are any, the authority that signs the certificates which
/// its callers must have then, and the tokens.
#[derive(Debug, Clone)]
pub struct MasterKeys {
    /// How connections are encrypted.
    pub tls: ServerTlsConfig,
    /// The token that workers must have, if any.
    pub token: Option<Token>,
    /// The token that operators must have; without one there are none.
    pub operators: Option<Token>,
}

impl MasterKeys {
    /// The keys in a folder.
    ///
    /// # Errors
    /// [`KeysError`] when one is missing or cannot be used.
    pub fn read(folder: &Path) -> Result<Self, KeysError> {
        let identity = identity(folder)?.ok_or_else(|| KeysError::File {
            path: folder.join(CERTIFICATE),
            reason: ErrorKind::NotFound.into(),
        })?;
        let mut tls = ServerTlsConfig::new().identity(identity);
        if let Some(authority) = authority(folder)? {
            tls = tls.client_ca_root(authority);
        }
        Server::builder().tls_config(tls.clone()).map_err(|error| refused(folder, &error))?;
        Ok(Self { tls, token: token(folder, TOKEN)?, operators: token(folder, OPERATOR_TOKEN)? })
    }
}

/// The keys of a worker or an operator: the authority that signs its master's certificate, and, where there are any, its own certificate and
/// key, and the token.
#[derive(Debug, Clone)]
pub struct ClientKeys {
    /// How connections are encrypted.
    pub tls: ClientTlsConfig,
    /// The token, if any.
    pub token: Option<Token>,
}

impl ClientKeys {
    /// The keys in a folder.
    ///
    /// # Errors
    /// [`KeysError`] when one is missing or cannot be used.
    pub fn read(folder: &Path) -> Result<Self, KeysError> {
        let authority = authority(folder)?.ok_or_else(|| KeysError::File {
            path: folder.join(AUTHORITY),
            reason: ErrorKind::NotFound.into(),
        })?;
        let mut tls = ClientTlsConfig::new().ca_certificate(authority);
        if let Some(identity) = identity(folder)? {
            tls = tls.identity(identity);
        }
        let anywhere = Endpoint::from_static("https://localhost");
        anywhere.tls_config(tls.clone()).map_err(|error| refused(folder, &error))?;
        Ok(Self { tls, token: token(folder, TOKEN)? })
    }
}

fn identity(folder: &Path) -> Result<Option<Identity>, KeysError> {
    let (certificate, key) = (folder.join(CERTIFICATE), folder.join(KEY));
    match (contents(&certificate)?, contents(&key)?) {
        (None, None) => Ok(None),
        (Some(chain), Some(secret)) => {
            certificates(&certificate, &chain)?;
            PrivateKeyDer::from_pem_slice(&secret)
                .map_err(|_| KeysError::Content { path: key, expected: "private key" })?;
            Ok(Some(Identity::from_pem(chain, secret)))
        }
        _ => Err(KeysError::Half { folder: folder.to_owned() }),
    }
}

fn authority(folder: &Path) -> Result<Option<Certificate>, KeysError> {
    let path = folder.join(AUTHORITY);
    let Some(pem) = contents(&path)? else { return Ok(None) };
    certificates(&path, &pem)?;
    Ok(Some(Certificate::from_pem(pem)))
}

fn token(folder: &Path, name: &str) -> Result<Option<Token>, KeysError> {
    let path = folder.join(name);
    let there = path.try_exists().map_err(|reason| KeysError::File { path: path.clone(), reason })?;
    Ok(if there { Token::given(Some(&path), None)? } else { None })
}

/// Makes sure that there are certificates, at least one.
fn certificates(path: &Path, pem: &[u8]) -> Result<(), KeysError> {
    let mut found = CertificateDer::pem_slice_iter(pem).peekable();
    if found.peek().is_none() || found.any(|certificate| certificate.is_err()) {
        return Err(KeysError::Content { path: path.to_owned(), expected: "certificate" });
    }
    Ok(())
}

/// What is in a file, if it exists.
fn contents(path: &Path) -> Result<Option<Vec<u8>>, KeysError> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(reason) => Err(KeysError::File { path: path.to_owned(), reason }),
    }
}

/// The library's own text names only the layer.
fn refused(folder: &Path, error: &dyn std::error::Error) -> KeysError {
    let mut cause = error;
    while let Some(deeper) = cause.source() {
        cause = deeper;
    }
    KeysError::Refused { folder: folder.to_owned(), reason: cause.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, content) in files {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        folder
    }

    fn pair() -> (String, String) {
        let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
        (made.cert.pem(), made.signing_key.serialize_pem())
    }

    #[test]
    fn a_master_needs_a_certificate_and_a_worker_an_authority() {
        let (certificate, key) = pair();
        let token = "0123456789abcdef";
        let master = folder(&[(CERTIFICATE, &certificate), (KEY, &key), (TOKEN, token)]);
        assert!(MasterKeys::read(master.path()).unwrap().token.is_some());
        let message = ClientKeys::read(master.path()).unwrap_err().to_string();
        assert!(message.contains("ca.crt: cannot be read"), "{message}");
        let worker = folder(&[(AUTHORITY, &certificate)]);
        assert!(ClientKeys::read(worker.path()).unwrap().token.is_none());
        let message = MasterKeys::read(worker.path()).unwrap_err().to_string();
        assert!(message.contains("tls.crt: cannot be read") && message.contains("keys init"), "{message}");
    }

    #[test]
    fn files_that_are_not_what_they_should_be_are_named() {
        let (certificate, key) = pair();
        let (_, other) = pair();
        for (files, words) in [
            (vec![(CERTIFICATE, "nonsense"), (KEY, &*key)], "tls.crt: there is no certificate"),
            (vec![(CERTIFICATE, &*certificate), (KEY, &*certificate)], "tls.key: there is no private key"),
            (vec![(CERTIFICATE, &*certificate)], "only one of tls.crt and tls.key"),
            (vec![(CERTIFICATE, &*certificate), (KEY, &*other)], "these keys cannot be used: "),
            (vec![(CERTIFICATE, &*certificate), (KEY, &*key), (TOKEN, "short")], "a token has 16 to 512"),
            (vec![(CERTIFICATE, &*certificate), (KEY, &*key), (AUTHORITY, "")], "ca.crt: there is no"),
        ] {
            let message = MasterKeys::read(folder(&files).path()).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
