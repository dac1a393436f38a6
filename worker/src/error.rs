//! Why a worker cannot go on.

use selftalk_proto::AddressError;
use selftalk_sim::{ExperimentError, SimError};
use thiserror::Error;

/// Why a worker cannot go on.
#[derive(Debug, Error)]
pub enum WorkerError {
    /// The master's address is not one.
    #[error(transparent)]
    Address(#[from] AddressError),
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
