//! `selftalk run`.

use super::Global;
use super::args::RunArgs;
use crate::exit::{Exit, Failure};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(_args: RunArgs, _global: &Global) -> Result<(), Failure> {
    Err(Failure::new(Exit::Unexpected, "not there yet"))
}
