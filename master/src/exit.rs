//! How a command ends: its exit code, and the one line on stderr that says why.

use std::fmt::Display;
use std::process::ExitCode;

use selftalk_sim::{ExperimentError, SimError};

use crate::store::StoreError;

/// The exit codes of the commands. 0 is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Nothing the other codes stand for.
    Unexpected = 1,
    /// The command line is wrong, or asks for something that is not there.
    Usage = 2,
    /// The experiment file is refused.
    Experiment = 3,
    /// The database cannot be opened, read or written.
    Database = 4,
    /// A port is taken, the master cannot be reached or refuses the worker.
    Network = 5,
    /// The experiment exists: interrupted, or with other settings.
    Exists = 6,
    /// What is stored is not what comes out when it is run again.
    Mismatch = 7,
    /// Ended by Ctrl-C.
    Interrupted = 130,
    /// Ended by SIGTERM.
    Terminated = 143,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a command did not do what it was asked to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// One line for people.
    pub message: String,
}

impl Failure {
    /// A failure with a message, whose lines are joined into one.
    #[must_use]
    pub fn new(exit: Exit, message: impl Display) -> Self {
        // Messages of libraries may run over several lines.
        let message = message.to_string().lines().map(str::trim).collect::<Vec<_>>().join(" ");
        Self { exit, message }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        let exit = if matches!(error, StoreError::Exists { .. }) { Exit::Exists } else { Exit::Database };
        Self::new(exit, error)
    }
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        Self::new(Exit::Unexpected, error)
    }
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        Self::new(Exit::Experiment, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_line() {
        assert_eq!(Failure::new(Exit::Network, "no\n  way\n").message, "no way");
    }

    #[test]
    fn errors_have_their_codes() {
        let exists = StoreError::Exists { path: "a.db".into(), name: "x".into() };
        assert_eq!(Failure::from(exists).exit, Exit::Exists);
        let full = Failure::from(StoreError::Full { path: "a.db".into() });
        assert_eq!(full.exit, Exit::Database);
        assert!(full.message.starts_with("a.db: "), "{full}");
    }
}
