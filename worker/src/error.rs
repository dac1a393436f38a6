//! Why a worker cannot go on.

use selftalk_sim::{ExperimentError, SimError};
use thiserror::Error;

/// Why a worker cannot go on.
#[derive(Debug, Error)]
pub enum WorkerError {
    /// The master's address is not one.
    #[error("{master}: not the address of a master: {reason}")]
    Address {
        /// As it was given.
        master: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The master could not be reached.
    #[error("{master}: no master reached within {seconds} s: {reason}")]
    Unreachable {
        /// Its address.
        master: String,
        /// How long it was tried.
        seconds: u64,
        /// What the last attempt came to.
        reason: String,
    },
    /// The master does not take this worker.
    #[error("{master}: refused: {text}")]
    Refused {
        /// Its address.
        master: String,
        /// What it says.
        text: String,
    },
    /// The master asks for another token.
    #[error("{master}: refused: {text}; give the master's token with --token-file or SELFTALK_TOKEN")]
    Token {
        /// Its address.
        master: String,
        /// What it says.
        text: String,
    },
    /// Something answers at the address that does not understand workers.
    #[error("{master}: there is no selftalk master at this address")]
    NotAMaster {
        /// The address.
        master: String,
    },
    /// The master sent an experiment that this worker cannot run.
    #[error("the master's experiment cannot be run: {0}")]
    Experiment(#[from] ExperimentError),
    /// The simulator cannot be set up.
    #[error(transparent)]
    Simulator(#[from] SimError),
    /// The master sent what makes no sense.
    #[error("{master}: the master sent something wrong: {reason}")]
    Protocol {
        /// Its address.
        master: String,
        /// What is wrong.
        reason: String,
    },
    /// The threads could not be started.
    #[error("the slots' threads could not be started: {0}")]
    Threads(#[source] std::io::Error),
}

impl WorkerError {
    /// Whether the network or the master is the reason, not this worker.
    #[must_use]
    pub const fn is_network(&self) -> bool {
        matches!(
            self,
            Self::Unreachable { .. } | Self::Refused { .. } | Self::Token { .. } | Self::NotAMaster { .. }
        )
    }
}

/// An error with its causes, in one line; the network library's own text often names only the layer.
pub(crate) fn chain(error: &dyn std::error::Error) -> String {
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
